"""XML elements that know which line of which file they come from, so that errors can say so."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from plant.robot import RobotError


@dataclass(frozen=True)
class Element:
    """One XML element.

    Attributes:
        tag: Its name.
        attributes: As written.
        children: In the file's order.
        file: The file's path, for messages.
        line: Where it begins, counting from 1.
    """

    tag: str
    attributes: dict[str, str]
    children: list["Element"] = field(repr=False)
    file: str
    line: int

    def all(self, tag: str) -> Iterator["Element"]:
        """The children of that name."""
        return (child for child in self.children if child.tag == tag)

    def find(self, tag: str) -> "Element | None":
        """The first child of that name."""
        return next(self.all(tag), None)

    def error(self, message: str) -> RobotError:
        """An error that begins with the file and the line."""
        return RobotError(f"{self.file}:{self.line}: {message}")

    def text(self, attribute: str, who: str) -> str:
        """The attribute's value; `who` names the element in the error when there is none."""
        value = self.attributes.get(attribute)
        if not value:
            raise self.error(f"{who}: <{self.tag}> has no {attribute}")
        return value

    def number(self, attribute: str, who: str, default: float | None = None) -> float:
        """The attribute as a finite number."""
        if default is not None and attribute not in self.attributes:
            return default
        (number,) = self._numbers(self.text(attribute, who), attribute, who, 1)
        return number

    def positive(self, attribute: str, who: str, default: float | None = None) -> float:
        """The attribute as a finite number above zero."""
        number = self.number(attribute, who, default)
        if number <= 0.0:
            raise self.error(
                f"{who}: <{self.tag} {attribute}='{self.attributes[attribute]}'> must be positive"
            )
        return number

    def vector(
        self, attribute: str, who: str, default: tuple[float, ...] = (0.0, 0.0, 0.0)
    ) -> tuple[float, ...]:
        """The attribute as finite numbers, as many as `default` has."""
        if attribute not in self.attributes:
            return default
        return self._numbers(self.attributes[attribute], attribute, who, len(default))

    def _numbers(self, text: str, attribute: str, who: str, count: int) -> tuple[float, ...]:
        try:
            numbers = tuple(float(word) for word in text.split())
        except ValueError:
            numbers = ()
        if len(numbers) != count or not all(map(math.isfinite, numbers)):
            what = (
                "a finite number" if count == 1 else f"{count} finite numbers with spaces between"
            )
            raise self.error(f"{who}: <{self.tag} {attribute}='{text}'> must be {what}")
        return numbers


def parse(content: bytes, file: str) -> Element:
    """Read a whole document and give its root element.

    Raises `RobotError` with the line where the document is not well-formed XML.
    """
    parser = expat.ParserCreate()
    document = Element("", {}, [], file, 0)
    open_elements = [document]

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, [], file, parser.CurrentLineNumber)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_elements.pop()
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        line = parser.CurrentLineNumber
        raise RobotError(f"{file}:{line}: this is not well-formed XML: {error}") from error
    return document.children[0]
