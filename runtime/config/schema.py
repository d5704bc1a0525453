"""A JSON schema of deployment files, from the same annotations that read them."""

import inspect
import math
import re
from dataclasses import MISSING
from typing import Any

from runtime.config.classes import ClassOf
from runtime.config.kinds import Choice, Items, Kind, Maybe, Number, Quantity, Table, Text, Whole
from runtime.config.reading import Derived, Structure, kind_of

_NUMBER = r"([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?"


def schema(annotation: Any) -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of what `kind_of(annotation)` reads.

    It covers the structure, but nothing that depends on other values or on the named classes.
    """
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **_of(kind_of(annotation))}


def _of(kind: Kind) -> dict[str, Any]:
    match kind:
        case Quantity():
            sign = r"\+?" if max(kind.above, kind.least) >= 0 else "[+-]?"
            text = {"type": "string", "pattern": rf"^\s*{sign}{_NUMBER}(\s*[^0-9\s.+-]\S*)?\s*$"}
            return {"anyOf": [{"type": "number", **_bounds(kind)}, text]}
        case Whole():
            return {"type": "integer", **_bounds(kind)}
        case Choice() if all(isinstance(value, bool) for value in kind.values.values()):
            return {"type": "boolean"}
        case Choice():
            return {"enum": list(kind.values)}
        case Text() if kind.regex != Text.regex:
            return {"type": "string", "pattern": f"^({kind.regex})$"}
        case Items(bare=True):
            return _one_or_more(_of(kind.kinds[0]))
        case ClassOf():
            return _one_or_more({"type": "string", "examples": [kind.such_as]})
        case Items(many=True):
            return {"type": "array", "items": _of(kind.kinds[0])}
        case Items():
            items, count = [_of(each) for each in kind.kinds], len(kind.kinds)
            return {"type": "array", "prefixItems": items, "minItems": count, "maxItems": count}
        case Maybe():
            return {"anyOf": [_of(kind.kind), {"type": "null"}]}
        case Table():
            names, values = _of(kind.key), _of(kind.value)
            return {"type": "object", "propertyNames": names, "additionalProperties": values}
        case Structure(type=of) if hasattr(of, "short"):
            short = next(field.kind for field in kind.fields if field.name == of.short)
            return {"anyOf": [_of(short), _object(kind)]}
        case Structure():
            return _object(kind)
        case _:
            return {"type": "string", "examples": [kind.such_as]}


def _one_or_more(one: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1}]}


def _bounds(kind: Number) -> dict[str, float]:
    named = {"exclusiveMinimum": kind.above, "minimum": kind.least, "maximum": kind.most}
    return {name: bound for name, bound in named.items() if math.isfinite(bound)}


def _object(kind: Structure) -> dict[str, Any]:
    doc = inspect.cleandoc(kind.type.__doc__ or "")
    properties = {}
    for field in kind.fields:
        properties[field.key] = _of(field.kind) | _note(doc, field.name)
        if field.default not in (MISSING, None) and not isinstance(field.default, Derived):
            properties[field.key]["default"] = field.kind.write(field.default)
    result = {
        "type": "object",
        "description": doc.partition("\n")[0],
        "properties": properties,
        "required": [field.key for field in kind.fields if field.required],
        "additionalProperties": kind.rest is not None,
    }
    one_of = getattr(kind.type, "one_of", ())
    return result | ({"oneOf": [{"required": [key]} for key in one_of]} if one_of else {})


def _note(doc: str, name: str) -> dict[str, str]:
    """Return the description of an attribute in a docstring's `Attributes` section."""
    found = re.search(rf"^    {name}: (.*(?:\n {{5,}}.*)*)", doc, re.MULTILINE)
    return {"description": " ".join(found[1].split())} if found else {}
