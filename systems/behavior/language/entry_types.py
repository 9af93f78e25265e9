"""The types of blackboard entries, numbers or texts, inferred in parsing.

The memory is numbers. A boolean is 1 or 0 there, and a text is its index in the
table of all texts of the tree. The type of an entry follows from how the tree
uses it, and never changes.
"""

from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, TypeAdapter, ValidationError

from hunav_drake.systems.behavior.nodes.errors import Spot

# The largest length of a text on the blackboard.
MAX_TEXT = 100

_BOOLEANS = {"true": 1.0, "false": 0.0}


def _word_or_number(value: object) -> object:
    """Returns 1 for the text "true", 0 for "false", all else unchanged."""
    if isinstance(value, str):
        return _BOOLEANS.get(value.strip().lower(), value)
    return value


_NUMBER: TypeAdapter[float] = TypeAdapter(
    Annotated[float, BeforeValidator(_word_or_number)],
    config=ConfigDict(allow_inf_nan=False),
)


def number_of(text: str) -> float | None:
    """Returns the number or boolean in a literal; None for another text."""
    try:
        return _NUMBER.validate_strings(text)
    except ValidationError:
        return None


class EntryType:
    """The type of entries and literals that must have the same type.

    Types that turn out to be one are joined: each then points to the next,
    and the last of them holds the result.
    """

    __slots__ = ("_next", "_reason", "_text")

    def __init__(self) -> None:
        """Constructs an EntryType that is not known yet."""
        self._next: EntryType | None = None
        self._text: bool | None = None
        self._reason = ""

    @property
    def is_text(self) -> bool:
        """Whether it is text; a type that is never determined is number."""
        return bool(self._last()._text)

    def require(self, text: bool, reason: str, spot: Spot) -> None:
        """Requires it to be text, or number, for a reason: "port distance"."""
        last = self._last()
        if last._text is None:
            last._text = text
            last._reason = f"{reason} at {spot.place}"
        elif last._text is not text:
            ours, theirs = ("text", "number") if text else ("number", "text")
            raise spot.fault(
                f"{reason} needs a {ours}, and {last._reason} a {theirs}; an"
                " entry holds the one or the other for ever"
            )

    def literal(self, text: str, spot: Spot) -> None:
        """Requires it to be text if a literal is not a number."""
        if number_of(text) is None:
            self.text(text, spot)

    def text(self, text: str, spot: Spot) -> None:
        """Requires it to be text, even if the literal looks like a number."""
        self.require(True, f"the text {text[:MAX_TEXT]!r}", spot)
        if len(text) > MAX_TEXT:
            raise spot.fault(
                f"a text may have {MAX_TEXT} letters, this has {len(text)}"
            )

    def join(self, other: "EntryType", spot: Spot) -> None:
        """Joins two types into one."""
        ours, theirs = self._last(), other._last()
        if ours is theirs:
            return
        if ours._text is None:
            ours, theirs = theirs, ours
        if theirs._text is not None and theirs._text is not ours._text:
            words = {True: "a text", False: "a number"}
            raise spot.fault(
                f"what meets here must be of one type: {ours._reason} needs"
                f" {words[bool(ours._text)]}, and {theirs._reason}"
                f" {words[theirs._text]}"
            )
        theirs._next = ours

    def _last(self) -> "EntryType":
        last = self
        while last._next is not None:
            last = last._next
        # Later look-ups are short.
        if last is not self:
            self._next = last
        return last


class TextTable:
    """The table of a tree's texts, whose indices are kept in memory."""

    def __init__(self) -> None:
        """Constructs an empty table."""
        self._codes: dict[str, int] = {}

    def add(self, text: str) -> None:
        """Adds a text if it is not in the table."""
        self._codes.setdefault(text, len(self._codes))

    def number(self, literal: str, kind: EntryType) -> float:
        """Returns the number in memory for a literal of a type."""
        if kind.is_text:
            return float(self._codes[literal])
        number = number_of(literal)
        assert number is not None  # Else its type would be text.
        return number

    def table(self) -> tuple[str, ...]:
        """Returns the texts; the number of each is its index."""
        return tuple(self._codes)
