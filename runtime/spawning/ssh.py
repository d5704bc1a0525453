"""The other hosts of a run, by the system's `ssh`: keys, names and ports are as it is set up."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.spawning.remote import out_of

_OPTIONS = ("-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=5")


@contextmanager
def connect(deployment: Deployment, run: Path) -> "Iterator[dict[str, subprocess.Popen[bytes]]]":
    """Let `msma share` speak for each host; what ssh complains of goes to the run's folder.

    It asks for no password: there would be several questions at once on one terminal.
    """
    if shutil.which("ssh") is None:
        raise ConfigError("--ssh needs `ssh`, which is in the package openssh-client")
    processes = {}
    with ExitStack() as stack:
        for name in dict.fromkeys(one.host for one in deployment.processes):
            host = deployment.hosts[name]
            with out_of(run, name).open("ab") as out:
                process = subprocess.Popen(
                    ["ssh", *_OPTIONS, "--", host.ssh, f"{host.command} share {name}"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=out,
                    start_new_session=True,  # Ctrl-C is for the launcher
                )
            processes[name] = stack.enter_context(process)
            stack.callback(process.terminate)
        yield processes
