"""The verbs of the `msma` command: modules with a docstring, `add_arguments` and `run`."""
