"""Nodes such as a user may add, for the tests of deployments."""

from runtime.processes.node import Context, Node


class Page(Node):
    """Does nothing, in the role of the operator's page."""

    def run(self, context: Context) -> None:
        """Wait for the end."""
        context.ending.wait(1e9)
