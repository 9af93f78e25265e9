"""Reads untrusted XML safely, and keeps the line numbers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
import functools
from typing import Any
from xml.etree.ElementTree import ParseError

from defusedxml.common import DefusedXmlException
from defusedxml.ElementTree import DefusedXMLParser

from hunav_drake.systems.behavior.nodes.errors import (
    BehaviorTreeError,
    Place,
    Spot,
)

# A tree of a thousand nodes is a tenth of this.
MAX_BYTES = 1_000_000

# The attributes that Groot writes for itself.
NOTES = ("_description", "_fullpath", "_uid")

# The deepest nesting of elements, and later of nodes. Each level of a tree is
# a level of Python calls.
MAX_DEPTH = 100


@dataclass
class XmlElement:
    """An XML element with its place.

    Attributes:
        tag: Its name.
        attributes: Its attributes.
        place: The file and the line of its start tag.
        children: The elements in it.
        text: The text in it, without white space at the ends.
        comments: The comments before it.
        last_comments: Those before its end.
    """

    tag: str
    attributes: dict[str, str]
    place: Place
    children: list["XmlElement"] = field(default_factory=list)
    text: str = ""
    comments: list[str] = field(default_factory=list)
    last_comments: list[str] = field(default_factory=list)

    @property
    def spot(self) -> Spot:
        """The element and its place, for messages."""
        return Spot(self.place, self.tag)

    def all(self) -> Iterator["XmlElement"]:
        """Yields the element and all elements in it, from the top down."""
        yield self
        for child in self.children:
            yield from child.all()


class _Builder:
    """Builds the elements from the events of the XML parser."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.line: Callable[[], int] = lambda: 0
        self.root: XmlElement | None = None
        self._open: list[XmlElement] = []
        self._comments: list[str] = []

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        element = XmlElement(tag, attributes, Place(self.file, self.line()))
        if len(self._open) == MAX_DEPTH:
            raise element.spot.fault(
                f"elements are nested more than {MAX_DEPTH} deep"
            )
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)
        element.comments = self._taken_comments()

    def end(self, tag: str) -> None:
        self._open.pop().last_comments = self._taken_comments()

    def comment(self, text: str) -> None:
        self._comments.append(text)

    def _taken_comments(self) -> list[str]:
        comments, self._comments = self._comments, []
        return comments

    def data(self, data: str) -> None:
        if self._open:
            self._open[-1].text += data.strip()

    def close(self) -> XmlElement | None:
        return self.root


@functools.lru_cache(maxsize=32)
def read_xml(source: bytes, file: str) -> XmlElement:
    """Returns the root element of an XML document, not to be changed.

    A document that was read before comes from a cache; `file` is its name in
    messages.

    Raises:
        BehaviorTreeError: If it is not well-formed XML, longer than
            `MAX_BYTES`, deeper than `MAX_DEPTH`, or has a document type
            declaration, which trees do not need and which could make it grow
            without bound or read other files.
    """
    if len(source) > MAX_BYTES:
        raise BehaviorTreeError(
            f"a tree may have {MAX_BYTES} bytes, this has {len(source)}",
            Place(file),
        )
    builder = _Builder(file)
    parser: Any = DefusedXMLParser(
        target=builder,
        forbid_dtd=True,
        forbid_entities=True,
        forbid_external=True,
    )
    expat = parser.parser
    builder.line = lambda: int(expat.CurrentLineNumber)
    try:
        parser.feed(source)
        root = parser.close()
    except ParseError as error:
        line = error.position[0]
        raise BehaviorTreeError(
            f"this is not well-formed XML: {error}", Place(file, line)
        ) from error
    except DefusedXmlException as error:
        raise BehaviorTreeError(
            "a document type declaration (<!DOCTYPE ...>, <!ENTITY ...>) is"
            " not accepted; remove it",
            Place(file, expat.CurrentLineNumber),
        ) from error
    except (ValueError, LookupError) as error:
        if isinstance(error, BehaviorTreeError):
            raise
        # The parser's words on an encoding that it does not know.
        raise BehaviorTreeError(
            f"this cannot be read as XML: {error}",
            Place(file, expat.CurrentLineNumber),
        ) from error
    if not isinstance(root, XmlElement):
        raise BehaviorTreeError("there is no XML element", Place(file))
    return root
