"""The verbs of the `msma` command, a module each: a docstring, `add_arguments` and `run`."""
