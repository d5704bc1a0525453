import contextlib
import os
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from runtime.config.overrides import Override
from runtime.config.tree import ConfigError, Location, YamlNode, parse, read_file

START = Location("x.yaml", Path("/"), 1, 1)


def plain(text: str) -> Any:
    return parse(text, START).plain()


def refused(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse(text, START)
    return str(caught.value)


def test_every_value_knows_where_it_was_written() -> None:
    root = parse("a:\n  - é: 1\n    b: [x, 2]\n", START)
    assert str(root.find("a", 0, "b", 1).location) == "x.yaml:3:12"
    assert root.find("a", 0, "b", 1).path == "a.0.b.1"
    assert root.find("a", 0, "b").key == START._replace(line=3, column=5)


def test_a_listed_mapping_goes_by_its_role() -> None:
    root = parse("agents: [{role: joint/1, gain: 3}]", START)
    error = root.find("agents", 0, "gain").error("is wrong")
    assert str(error) == "x.yaml:1:32: agents.joint/1.gain: is wrong"


def test_a_message_is_one_line_whatever_it_is_about() -> None:
    root = parse("agents: [{role: 'a\n\n b'}, {role: ok/1}]", START)
    assert str(root.find("agents", 0).error("two\nlines")) == "x.yaml:1:10: agents.0: two lines"
    assert root.find("agents", 0, "role").text == "a b"


@pytest.mark.parametrize("text", ["", "# only a remark\n", "---\n", "~", "null"])
def test_a_file_may_hold_nothing(text: str) -> None:
    assert plain(text) is None


def test_nothing_and_its_quoted_name_differ() -> None:
    assert plain("[~, null, '', 'null', \"~\", on, 1e-3]") == [
        None, None, "", "null", "~", "on", "1e-3",
    ]  # fmt: skip


def test_aliases_and_merge_keys_are_written_out() -> None:
    text = "base: &b {p: 1, q: [2]}\none: {<<: *b, q: 3}\ntwo: {<<: [{r: 4}, *b]}\nall: [*b, *b]"
    base = {"p": "1", "q": ["2"]}
    assert plain(text) == {
        "base": base,
        "one": {"p": "1", "q": "3"},
        "two": {"r": "4", **base},
        "all": [base, base],
    }


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: [1,", "x.yaml:2:1: is not YAML: did not find expected node content"),
        ("a: b: c", "x.yaml:1:5: is not YAML: mapping values are not allowed in this context"),
        ("a:\n\tb: c", "x.yaml:2:1: is not YAML: found character that cannot start any token"),
        ("a: é\x01", "x.yaml:1:5: is not YAML: the character '\\x01' is not allowed"),
        ("a: \udcff", "x.yaml:1:1: is not UTF-8 text"),
        ("a: 1\nb: 2\na: 3", "x.yaml:3:1: duplicate key 'a', first given at x.yaml:1:1"),
        ("a: 1\n---\nb: 2", "x.yaml:2:1: a second document; a file must have only one"),
        ("? [1]\n: 2", "x.yaml:1:3: a key must be plain text"),
        ("a: *b", "x.yaml:1:4: the alias *b has no anchor &b before it"),
        ("a: &b [*b]", "x.yaml:1:8: the alias *b has no anchor &b before it"),
        ("{<<: 3}", "x.yaml:1:6: << takes a mapping, or a list of mappings"),
        ("a: !b c", "x.yaml:1:4: the tag !b is not allowed; remove it"),
        ("[" * 22, "x.yaml:1:22: is nested deeper than 20 levels"),
        ("[" * 200_000, "x.yaml:1:22: is nested deeper than 20 levels"),
        ("é: " + "[" * 200_000, "x.yaml:1:24: is nested deeper than 20 levels"),
        ("{a: " * 999, "x.yaml:1:85: is nested deeper than 20 levels"),
        ("{a: " * 200_000, "x.yaml:1:85: is nested deeper than 20 levels"),
        ("- " * 200_000, "x.yaml:1:43: is nested deeper than 20 levels"),
    ],
)
def test_bad_yaml_is_refused_with_its_location(text: str, says: str) -> None:
    assert refused(text) == says


def test_a_bomb_of_aliases_is_refused_before_it_goes_off() -> None:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 10)]
    assert "more than 100000 values, with aliases expanded" in refused("\n".join(lines))


YAML_VALUES = st.recursive(
    st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


@given(YAML_VALUES)
def test_what_another_writer_writes_is_read_as_it_was(value: Any) -> None:
    assert plain(yaml.safe_dump(value)) == value


@given(st.text())
def test_whatever_the_text_it_is_read_or_refused(text: str) -> None:
    with contextlib.suppress(ConfigError):
        parse(text, START)


def test_a_file_that_cannot_be_read_is_named_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkdir("folder")
    Path("latin.yaml").write_bytes("a: 1\nb: é\n".encode("latin-1"))
    Path("huge.yaml").write_bytes(b"#" * 4_000_001)

    def said(file: str) -> str:
        with pytest.raises(ConfigError) as caught:
            read_file(file)
        return str(caught.value)

    assert said("none.yaml") == "none.yaml: No such file or directory"
    assert said("folder") == "folder: is a folder, not a YAML file"
    assert said("latin.yaml") == "latin.yaml:2: is not UTF-8 text; save it as UTF-8"
    assert said("huge.yaml") == "huge.yaml: is larger than 4 MB"
    assert said("") == "'': No such file or directory"


def test_a_byte_order_mark_is_no_part_of_the_file(tmp_path: Path) -> None:
    (tmp_path / "x.yaml").write_bytes(b"\xef\xbb\xbfa: 1")
    assert read_file(tmp_path / "x.yaml").plain() == {"a": "1"}


TEXT = "a: {b: 1}\nlist: [{role: r, k: 1}, {role: s}]\nnone:\nplain: 2\n"


def override(path: str, value: str, text: str = TEXT) -> YamlNode:
    root = parse(text, START)
    Override(f"--set {path}={value}", path, value).apply(root)
    return root


@pytest.mark.parametrize(
    ("path", "changed"),
    [
        ("a.b", {"a": {"b": "[3]"}}),
        ("a.c", {"a": {"b": "1", "c": "[3]"}}),
        ("new.c", {"new": {"c": "[3]"}}),
        ("none.c", {"none": {"c": "[3]"}}),
        ("list.r.k", {"list": [{"role": "r", "k": "[3]"}, {"role": "s"}]}),
        ("list.1.k", {"list": [{"role": "r", "k": "1"}, {"role": "s", "k": "[3]"}]}),
        ("list.+", {"list": [{"role": "r", "k": "1"}, {"role": "s"}, "[3]"]}),
        ("new.+", {"new": ["[3]"]}),
    ],
)
def test_an_override_replaces_or_adds_one_value(path: str, changed: dict[str, Any]) -> None:
    assert override(path, "'[3]'").plain() == plain(TEXT) | changed


def test_the_location_of_an_overridden_value_is_the_override() -> None:
    value = override("list.r.k", "[1, 2]").find("list", 0, "k", 1)
    assert str(value.error("is wrong")) == "--set list.r.k=[1, 2]: list.r.k.1: is wrong"


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("a..b", "1", "'a..b' is not a path, such as goal.velocity"),
        ("plain.x", "1", "plain is not a mapping, so x cannot be set in it"),
        ("a.+", "1", "a is not a list, so + cannot be set in it"),
        ("+", "1", "the file is not a list, so + cannot be set in it"),
        ("list.t", "1", "list has no t; it has r, s, + for a new one"),
        ("list.2", "1", "list has no 2; it has r, s, + for a new one"),
        ("a", "[1", "is not YAML: did not find expected ',' or ']'"),
    ],
)
def test_an_override_of_a_missing_value_is_refused(path: str, value: str, says: str) -> None:
    with pytest.raises(ConfigError) as caught:
        override(path, value)
    assert str(caught.value) == f"--set {path}={value}: {says}"


@pytest.mark.parametrize("name", ["x", "0", "+"])
@pytest.mark.parametrize("text", ["[{role: x}]", "x"])
def test_an_override_in_a_file_without_keys_is_refused(text: str, name: str) -> None:
    with pytest.raises(ConfigError) as caught:
        override(name, "1", text)
    says = f"the file is not a mapping, so {name} cannot be set in it"
    assert str(caught.value) == f"--set {name}=1: {says}"
