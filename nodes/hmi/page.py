"""The operator's page: a node that serves it, and drives the robot by what comes back."""

from contextlib import nullcontext
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

from nodes.hmi.listening import LOOPBACK, DoorError, Listening, check_listen, tls_context
from nodes.hmi.without_openssl import without_openssl
from runtime.config.kinds import Whole
from runtime.processes.node import Context, Node

Port = Annotated[int, Whole("8420", least=1, most=65535)]


class Page(Node):
    """Serves the page by which a person drives the robot, and an engineer watches it."""

    realtime = False  # a person waits longer than other programs delay it

    def __init__(
        self,
        *,
        port: Port | None = None,
        listen: str = LOOPBACK[0],
        names: tuple[str, ...] = (),
        certificate: Path | None = None,
        key: Path | None = None,
        language: Literal["en", "fr"] = "en",
    ) -> None:
        """Check the parameters; nothing is opened yet.

        Args:
            port: By default one that follows from the robot's ports, so that no other robot's page
                takes it while this one is not there.
            listen: The address that it listens at, of this computer; by default only programs on
                this computer reach it.
            names: Further names or addresses by which browsers call this computer.
            certificate: File with its TLS certificate (PEM), needed if others can reach it.
            key: File with the certificate's private key (PEM).
            language: Of the page, until a person chooses another.
        """
        if find_spec("websockets") is None:
            raise DoorError("class: the page needs a package more: pip install 'msma[web]'")
        check_listen(listen, names, certificate, key)
        self._at = Listening(port, listen, names, tls_context(certificate, key))
        self._language = language

    def run(self, context: Context) -> None:
        """Serve the page until the process is to end."""
        # Not before: the robot's other processes know this class too, and need no server.
        with without_openssl() if self._at.tls is None else nullcontext():
            from nodes.hmi.serving import serve
        serve(self, context, self._at, self._language)
