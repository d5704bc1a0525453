import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.cli import launch, main

ROOT = Path(__file__).parents[2]
FILE = str(ROOT / "deploy" / "arph.yaml")


def test_a_valid_file_is_reported_as_valid(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", FILE]) == 0
    assert capsys.readouterr().out == f"{FILE}: valid: robot arph, 9 processes\n"


def test_a_mistake_is_one_line_and_exit_code_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate", FILE, "--speed", "0"]) == 2
    out, err = capsys.readouterr()
    assert (out, err) == ("", "msma: --speed 0: speed: 0 must be positive, such as 1\n")


def test_the_schema_is_printed_without_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["validate", "--schema"])
    assert "period" in json.loads(capsys.readouterr().out)["properties"]


def test_an_unknown_command_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["valdate"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("msma: unknown command 'valdate'; did you mean 'validate'? valid are ")


def test_a_full_disk_is_one_line_and_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(_: object) -> int:
        with open("/dev/full", "w", encoding="utf-8") as file:
            file.write("x")
        return 0

    monkeypatch.setattr("runtime.verbs.validate.run", full)
    assert main(["validate", FILE]) == 1
    assert capsys.readouterr().err == "msma: No space left on device\n"


@pytest.mark.parametrize(("argv", "code"), [(["--help"], 0), (["-h"], 0), ([], 2)])
def test_help_lists_the_verbs(
    argv: list[str], code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(argv) == code
    assert (
        "  validate  Check a deployment file without starting anything." in capsys.readouterr().out
    )


def test_the_help_has_a_short_sentence_for_each_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["--help"])
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  ")]
    assert len(lines) > 12
    for line in lines:
        assert line.endswith("."), line
        assert len(line) <= 100, line


VERB = '''"""Return a code."""
def add_arguments(parser):
    parser.add_argument("what")
def run(args):
    if args.what == "interrupt":
        raise KeyboardInterrupt
    return int(args.what)
'''


def test_a_verb_of_another_package_is_found_as_an_entry_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "other_verb.py").write_text(VERB)
    (tmp_path / "other-1.dist-info").mkdir()
    entry = "[msma.verbs]\nrepeat = other_verb\n"
    (tmp_path / "other-1.dist-info" / "entry_points.txt").write_text(entry)
    monkeypatch.syspath_prepend(str(tmp_path))
    assert main(["repeat", "3"]) == 3
    assert main(["repeat", "interrupt"]) == 130
    assert main(["--help"]) == 0
    assert "  repeat    Return a code." in capsys.readouterr().out


def test_msma_launch_is_msma_with_the_verb_launch(monkeypatch: pytest.MonkeyPatch) -> None:
    def run(argv: list[str]) -> int:
        assert argv == ["launch", FILE]
        return 7

    monkeypatch.setattr("runtime.cli.main", run)
    monkeypatch.setattr(sys, "argv", ["msma-launch", FILE])
    with pytest.raises(SystemExit) as end:
        launch()
    assert end.value.code == 7


def test_from_a_checkout_it_imports_no_more_than_the_verb_needs() -> None:
    watch = "import atexit, sys; atexit.register(lambda: print(*sys.modules))"
    program = f"{watch}; from runtime.cli import main; main(['validate', {FILE!r}])"
    result = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    said, imported = result.stdout.splitlines()
    assert said.endswith("valid: robot arph, 9 processes")
    verbs = [name for name in imported.split() if name.startswith("runtime.verbs.")]
    assert verbs == ["runtime.verbs.validate"]
    assert not {"importlib.metadata", "zenoh", "rich", "difflib"} & set(imported.split())


def test_a_closed_pipe_is_no_error() -> None:
    read, write = os.pipe()
    os.close(read)
    program = [sys.executable, "-m", "runtime.cli", "validate", FILE]
    result = subprocess.run(program, cwd=ROOT, stdout=write, stderr=subprocess.PIPE, text=True)
    os.close(write)
    assert (result.returncode, result.stderr) == (0, "")


@pytest.mark.parametrize(("takes", "said"), [(0.0, "Python ends\n"), (60.0, "")])
def test_a_command_ends_at_once_while_a_bus_of_it_still_closes(takes: float, said: str) -> None:
    """Zenoh closes a bus for seconds where a process hangs, and aborts a Python that has ended."""
    program = f"""
import atexit, math, sys, time
from types import SimpleNamespace
from runtime import cli
from runtime.wire.bus import Bus

def run(*_):
    bus = Bus.__new__(Bus)
    bus._asked, bus._session = -math.inf, SimpleNamespace(close=lambda: time.sleep({takes}))
    bus.close()
    return 7

cli._run = run
atexit.register(print, "Python ends")
assert cli.main(["any"]) == 7  # called by a program, it leaves that one alone
cli.msma()
"""
    command = [sys.executable, "-c", program, "any"]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert (result.returncode, result.stdout, result.stderr) == (7, said, "")
