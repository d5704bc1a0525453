"""Entry point of an echo process: `echo_process.py MODULE measured|watched PART...`.

It runs in the environment of one system. That environment's libraries come first on the import path
and our folder last, so that no library installed beside ours is measured instead.
"""

import os
import signal
import sys
from importlib import import_module
from pathlib import Path

_TIME_LIMIT = 300  # [s]


def main() -> None:
    """Run the process that the command line specifies, in the folder of its run."""
    from bench.echo.workload import parse_args, run_plant
    from bench.others.arrivals import RUN_FOLDER, run_logging_plant

    os.chdir(os.environ[RUN_FOLDER])  # some systems start processes elsewhere
    module, mode, *arguments = sys.argv[1:]
    spec = parse_args(arguments)
    sys.setswitchinterval(0.0005)  # [s], as in our processes
    signal.signal(signal.SIGTERM, lambda *_: os._exit(0))  # nothing to save
    signal.alarm(_TIME_LIMIT)  # in case the bench itself is killed
    if spec.role == "plant":
        # not file descriptor 1, because some systems print there or capture it
        sys.stdout = open("said", "w", encoding="ascii")  # noqa: SIM115 # stays open
    Path(f"{spec.role.replace('/', '-')}.{os.getpid()}.pid").touch()
    import_module(module).main(spec, run_plant if mode == "measured" else run_logging_plant)


if __name__ == "__main__":
    # our root replaces this folder on the import path until our own packages are imported, so that
    # this folder's modules cannot be imported by their bare names
    sys.path[0] = str(Path(__file__).resolve().parents[2])
    for package in ("bench", sys.argv[1].partition(".")[0]):
        import_module(package)
    sys.path.append(sys.path.pop(0))
    main()
