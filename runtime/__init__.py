"""Everything that touches the outside: deployment files, the bus, processes, the command line."""
