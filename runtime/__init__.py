"""Everything that touches the outside: deployment files, the bus, processes, the command line."""

VERSION = "0.1.0"
"""Of MSMA: what the hosts of a robot should have in common."""
