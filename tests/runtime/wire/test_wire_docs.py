"""docs/wire.md has the table that the code has; `python -m tests.runtime.wire.test_wire_docs` does.

Run so, this module writes the generated part of the page anew.
"""

import inspect
import re
from collections.abc import Sequence
from typing import Any

from msgspec import inspect as types

from runtime.wire.refusals import Reason
from runtime.wire.topics import TOPICS, Topic
from tests.runtime.conftest import ROOT

PAGE = ROOT / "docs" / "wire.md"
BEGIN, END = "<!-- generated from runtime/wire/topics.py -->\n", "<!-- end -->"


def generated() -> str:
    """Return the tables of topics and of the fields of their messages."""
    topics: list[tuple[str, ...]] = [
        ("key", "published by", "how often", "sent", "percept", "recorded", "message")
    ]
    topics += [_row(topic) for topic in TOPICS]
    messages = [("message", "fields", "meaning")]
    for kind in dict.fromkeys(topic.message for topic in TOPICS):
        info = types.type_info(kind)
        assert isinstance(info, types.StructType)
        own = [field for field in info.fields if field.encode_name not in ("t", "by", "n")]
        fields = "; ".join(_field(field) for field in own)
        messages.append((f"`{kind.__name__}`", fields, (inspect.getdoc(kind) or "").split("\n")[0]))
    reasons = ", ".join(reason.value for reason in Reason)
    counted = f"Reasons by which `msma status` counts messages: {reasons}.\n"
    return f"{_table(topics)}\n{_table(messages)}\n{counted}"


def _row(topic: Topic) -> tuple[str, ...]:
    sent = "urgent" if topic.urgent else "in the background"
    return (
        f"`{topic.key}`",
        "every role" if topic.publisher == "**" else f"`{topic.publisher}`",
        topic.rate,
        f"{sent}, at once" if topic.express else f"{sent}, with the next one",
        f"`{topic.percept}`" if topic.percept else "",
        "yes" if topic.recorded else "no",
        f"`{topic.message.__name__}`",
    )


def _field(field: types.Field) -> str:
    optional = "" if field.required else " (optional)"
    return f"`{field.encode_name}` {_shape(field.type)}{optional}"


def _shape(kind: types.Type) -> str:
    match kind:
        case types.Metadata(type=inner, extra=extra):
            unit = (extra or {}).get("unit")
            return unit or _shape(inner)
        case types.FloatType():
            return "number"
        case types.IntType():
            return "count"
        case types.BoolType():
            return "true or false"
        case types.StrType():
            return "text"
        case types.BoolType():
            return "true or false"
        case types.UnionType(types=members):
            return " or ".join(map(_shape, members))
        case types.LiteralType(values=values):
            return " or ".join(f"`{value}`" for value in values)
        case types.NoneType():
            return "nil"
        case types.VarTupleType(item_type=item, min_length=least, max_length=most):
            return f"[{least}] {_shape(item)}" if least == most else f"[n] {_shape(item)}"
        case types.NamedTupleType(fields=fields):
            return "[" + ", ".join(f"{field.name} {_shape(field.type)}" for field in fields) + "]"
        case types.StructType(fields=inside):
            return "{" + ", ".join(_field(field) for field in inside) + "}"
        case types.DictType(value_type=value):
            return "map of " + _shape(value)
    raise TypeError(kind)


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    lines = [f"| {' | '.join(row)} |\n" for row in rows]
    return "".join([lines[0], "|" + " --- |" * len(rows[0]) + "\n", *lines[1:]])


def _with_tables(page: str) -> str:
    tables: Any = lambda _: f"{BEGIN}\n{generated()}\n{END}"  # noqa: E731 - no escapes in it
    return re.sub(f"{re.escape(BEGIN)}.*?{re.escape(END)}", tables, page, flags=re.DOTALL)


def test_the_page_has_the_tables_of_the_code() -> None:
    page = PAGE.read_text()
    assert _with_tables(page) == page, f"python -m {__spec__.name if __spec__ else __name__}"


if __name__ == "__main__":
    PAGE.write_text(_with_tables(PAGE.read_text()))
