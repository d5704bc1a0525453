"""The files of the page: vendored libraries, words, size, and nothing from elsewhere."""

import hashlib
import json
import re
from pathlib import Path

import pytest

from nodes.hmi.protocol.words import KEYS

PAGE = Path(__file__).parents[4] / "nodes" / "hmi" / "page"
VENDORED = PAGE / "vendored"
OURS = sorted([*PAGE.glob("*.js"), *PAGE.glob("*.html")])
LARGEST = 1_000_000  # [bytes] of the whole page


def words(language: str) -> dict[str, str]:
    """Return the words of a language: each line of the file is a JSON member."""
    lines = re.findall(
        r'^  ("[^"]+": ".*"),$', (PAGE / "words" / f"{language}.js").read_text(), re.M
    )
    found: dict[str, str] = json.loads("{" + ",".join(lines) + "}")
    assert len(found) == len(lines), "a key is there twice"
    return found


def placeholders(text: str) -> set[str]:
    return set(re.findall(r"\{(\w+)\}", text))


def test_the_vendored_files_are_those_that_the_script_made() -> None:
    lines = (VENDORED / "SHA256SUMS").read_text().splitlines()
    listed = {name: digest for digest, name in (line.split("  ") for line in lines)}
    there = {
        file.name: hashlib.sha256(file.read_bytes()).hexdigest()
        for file in VENDORED.iterdir()
        if file.name != "SHA256SUMS"
    }
    assert there == listed


def test_each_vendored_library_has_its_licence_beside_it() -> None:
    for library in ("three", "uplot"):
        assert "Permission is hereby granted" in (VENDORED / f"{library}.LICENSE").read_text()


def test_the_pinned_versions_are_those_of_the_bundles() -> None:
    pinned = json.loads((PAGE.parent / "vendoring" / "package.json").read_text())["dependencies"]
    assert pinned["three"].split(".")[1] in re.findall(
        r'="(\d+)"', (VENDORED / "three.js").read_text()
    )
    locked = json.loads((PAGE.parent / "vendoring" / "package-lock.json").read_text())["packages"]
    for name, version in pinned.items():
        assert locked[f"node_modules/{name}"]["version"] == version
        assert locked[f"node_modules/{name}"]["integrity"].startswith("sha512-")


def test_the_whole_page_is_small() -> None:
    assert sum(file.stat().st_size for file in PAGE.rglob("*") if file.is_file()) < LARGEST


@pytest.mark.parametrize("file", OURS, ids=lambda file: file.name)
def test_nothing_comes_from_elsewhere_and_nothing_needs_a_wider_policy(file: Path) -> None:
    text = re.sub(r'xmlns="[^"]*"', "", file.read_text())
    assert not re.search(r"https?://|\beval\(|new Function|innerHTML|document\.write", text)
    if file.suffix == ".html":
        assert not re.search(r"<style|\sstyle=|\son\w+=|<script(?![^>]*src=)", text)


def test_files_of_the_page_are_short() -> None:
    assert not [file.name for file in OURS if len(file.read_text().splitlines()) > 350]


def test_all_languages_have_the_same_words_with_the_same_values() -> None:
    english, french = words("en"), words("fr")
    assert english.keys() == french.keys()
    for key, text in english.items():
        assert placeholders(text) == placeholders(french[key]), key
        assert text.strip(), key
        assert french[key].strip(), key


def test_all_that_the_server_says_has_words() -> None:
    known = words("en")
    for key, values in KEYS.items():
        assert key in known
        assert placeholders(known[key]) <= set(values.split()), key


def test_every_word_that_the_page_names_is_there() -> None:
    known = words("en")
    for file in OURS:
        named = re.findall(r'data-(?:word|label)"?(?:=|: )"([^"]+)"', file.read_text())
        named += re.findall(r'\b(?:word|say)\(\s*"([^"]+)"', file.read_text())
        named += re.findall(r'\bbutton\("[^"]+", "([^"]+)"', file.read_text())
        assert not set(named) - known.keys(), file.name
