"""The verbs of the `msma` command: modules whose docstrings are their help, with two functions.

`add_arguments(parser)` adds what the verb takes; `run(args)` does it, and returns the exit code.
"""
