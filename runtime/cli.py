"""The `msma` command: finds the module of a verb, and runs it."""

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import NoReturn

from plant.errors import MsmaError
from runtime.errors import exit_code, valid_are

_OURS = "runtime.verbs", "runtime.verbs.gate"
"""The packages of our own verbs."""
_GROUP = "msma.verbs"
_EPILOGUE = """\
Run `msma COMMAND --help` for the arguments of a command.

exit codes: 0 success, 1 failure at run time, 2 bad input, 3 goal not reached, 130 interrupted"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `msma VERB ...`, by default with this process's arguments; return its exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for small arrays
    verb, *rest = (sys.argv[1:] if argv is None else argv) or [""]
    if verb in ("", "-h", "--help"):
        print(_help())
        return 0 if verb else 2
    return exit_code(lambda: _run(verb, rest))


def msma() -> NoReturn:
    """Be the command `msma`: run what this process's arguments say, and end the process."""
    _end(main())


def launch() -> NoReturn:
    """Be the command `msma-launch ...`, which is `msma launch ...`."""
    _end(main(["launch", *sys.argv[1:]]))


def _run(verb: str, arguments: Sequence[str]) -> int:
    module = importlib.import_module(_module(verb))
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(f"msma {verb}", None, module.__doc__, formatter_class=form)
    module.add_arguments(parser)
    code: int = module.run(parser.parse_args(arguments))
    return code


def _end(code: int) -> NoReturn:
    """End this process, at once if a bus of it still closes: Python would be aborted as it ends."""
    bus = sys.modules.get("runtime.wire.bus")
    if bus is not None and bus.is_closing():
        with suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


def _module(verb: str) -> str:
    """Return the name of the verb's module.

    Our own verbs are found without reading the metadata of installed packages, which takes 30 ms.
    """
    for package in _OURS if verb.isidentifier() else ():
        spec = find_spec(f"{package}.{verb}")
        if spec is not None and spec.submodule_search_locations is None:  # it is no package
            return spec.name
    verbs = _verbs()
    if verb not in verbs:
        raise MsmaError(f"unknown command {verb!r}{valid_are(verb, verbs)}")
    return verbs[verb]


def _verbs() -> dict[str, str]:
    """Return the module of each verb: ours, and those of other packages' entry points."""
    import pkgutil
    from importlib.metadata import entry_points

    found = {
        module.name: f"{package}.{module.name}"
        for package in _OURS
        for module in pkgutil.iter_modules(importlib.import_module(package).__path__)
        if not module.ispkg
    }
    return {entry.name: entry.value for entry in entry_points(group=_GROUP)} | found


def _help() -> str:
    verbs = sorted(_verbs().items())
    lines = [f"  {verb:10}{_docstring(module)}" for verb, module in verbs]
    return "\n".join(["usage: msma COMMAND ...", "", "commands:", *lines, "", _EPILOGUE])


def _docstring(module: str) -> str:
    """Return the first line of a module's docstring, without importing it."""
    import ast

    spec = find_spec(module)
    if spec is None or spec.origin is None:
        return "(not found)"
    text = ast.get_docstring(ast.parse(Path(spec.origin).read_text("utf-8"))) or ""
    return text.partition("\n")[0]


if __name__ == "__main__":
    msma()
