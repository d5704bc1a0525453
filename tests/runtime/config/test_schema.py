from pathlib import Path
from typing import Annotated, Any

import jsonschema
import pytest
import yaml

from runtime.config.deployment import Deployment
from runtime.config.kinds import Quantity
from runtime.config.reading import kind_of
from runtime.config.schema import schema

ROOT = Path(__file__).parents[3]
EXAMPLES = yaml.safe_load((Path(__file__).parent / "bad_files.yaml").read_text())
VALIDATOR = jsonschema.Draft202012Validator(schema(Deployment))


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(schema(Deployment))


@pytest.mark.parametrize("file", sorted((ROOT / "deploy").glob("*.yaml")), ids=lambda f: f.stem)
def test_the_schema_accepts_what_is_shipped(file: Path) -> None:
    VALIDATOR.validate(yaml.safe_load(file.read_text()))


@pytest.mark.parametrize(("old", "new", "says"), EXAMPLES["misshapen"])
def test_the_schema_refuses_what_is_misshapen(old: str | None, new: str, says: str) -> None:
    text = new if old is None else EXAMPLES["good"].replace(old, new, 1)
    assert not VALIDATOR.is_valid(yaml.safe_load(text)), says


@pytest.mark.parametrize("text", ["60 ms", "60ms", "1e-3", "+.5 s", "5", "0.5 m/s2", "50 %"])
def test_a_quantity_may_be_a_number_or_text_with_a_unit(text: str) -> None:
    assert jsonschema.Draft202012Validator(schema(float)).is_valid(text)
    assert jsonschema.Draft202012Validator(schema(float)).is_valid(5)


@pytest.mark.parametrize("value", ["-1 m", -1, "ms", "1 2", True, [1], None])
def test_a_quantity_out_of_bounds_or_without_number_is_refused(value: Any) -> None:
    bounded = schema(Annotated[float, Quantity("1 m", "m", above=0)])
    assert not jsonschema.Draft202012Validator(bounded).is_valid(value)


def test_the_schema_tells_what_each_key_is_and_what_it_is_by_default() -> None:
    properties = schema(Deployment)["properties"]
    assert all(entry.get("description") for entry in properties.values())
    assert properties["patience"]["default"] == "10.0 s"
    _, both = properties["tolerance"]["anyOf"]
    assert both["properties"]["position"]["default"] == "0.003 m"
    assert kind_of(Deployment).such_as == "{robot: arph, ...}"
