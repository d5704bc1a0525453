"""Texts of robot descriptions to be put together."""

from pathlib import Path

LIMIT = "<limit lower='-1' upper='1' velocity='2' effort='1'/>"


def joint(name: str, parent: str, child: str, inside: str = LIMIT, kind: str = "revolute") -> str:
    """The text of a joint element, on a line of its own."""
    ends = f"<parent link='{parent}'/><child link='{child}'/>"
    return f"<joint name='{name}' type='{kind}'>{ends}{inside}</joint>\n"


def links(*names: str) -> str:
    """The text of empty links, all on one line."""
    return "".join(f"<link name='{name}'/>" for name in names) + "\n"


def write(folder: Path, content: str) -> Path:
    """A URDF file of that content, which begins on line 2."""
    path = folder / "bot.urdf"
    path.write_text(f"<robot name='bot'>\n{content}</robot>\n")
    return path
