"""What blackboard entries hold: numbers or texts, found out in parsing.

The memory is numbers. A truth is 1 or 0 there, and a text is its index in the
table of all texts of the tree. Which of them an entry holds follows from how
the tree uses it, and never changes.
"""

from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, TypeAdapter, ValidationError

from hunav_drake.systems.behavior.nodes.errors import BehaviorTreeError, Place

# Blackboards are for words, not for essays.
MAX_TEXT = 100

_TRUTHS = {"true": 1.0, "false": 0.0}


def _word_or_number(value: object) -> object:
    """Takes the words for truth for the numbers that stand for them."""
    if isinstance(value, str):
        return _TRUTHS.get(value.strip().lower(), value)
    return value


_NUMBER: TypeAdapter[float] = TypeAdapter(
    Annotated[float, BeforeValidator(_word_or_number)],
    config=ConfigDict(allow_inf_nan=False),
)


def number_of(text: str) -> float | None:
    """Returns the number or truth that a literal says; None of another text."""
    try:
        return _NUMBER.validate_strings(text)
    except ValidationError:
        return None


class Kind:
    """What some entries and literals hold, which all hold the same.

    Kinds that turn out to be one are joined: each then points to the next,
    and the last of them knows.
    """

    __slots__ = ("_next", "_reason", "_text")

    def __init__(self) -> None:
        """Constructs a Kind of which nothing is known."""
        self._next: Kind | None = None
        self._text: bool | None = None
        self._reason = ""

    @property
    def is_text(self) -> bool:
        """Whether it is texts; what nothing tells is a number."""
        return bool(self._last()._text)

    def require(self, text: bool, reason: str, place: Place, node: str) -> None:
        """Notes that it must be texts, or numbers.

        Args:
            text: Whether texts.
            reason: What says so, for messages: "port distance".
            place: Where that is.
            node: The node where that is.

        Raises:
            BehaviorTreeError: If something else has said the contrary.
        """
        last = self._last()
        if last._text is None:
            last._text = text
            last._reason = f"{reason} at {place}"
        elif last._text is not text:
            ours, theirs = ("text", "number") if text else ("number", "text")
            raise BehaviorTreeError(
                f"{reason} needs a {ours}, and {last._reason} a {theirs}; an"
                " entry holds the one or the other for ever",
                place,
                node=node,
            )

    def literal(self, text: str, place: Place, node: str) -> None:
        """Notes a literal: one that is no number must be a text.

        Raises:
            BehaviorTreeError: If something has asked for numbers, or if the
                text is too long.
        """
        if number_of(text) is not None:
            return
        self.text(text, place, node)

    def text(self, text: str, place: Place, node: str) -> None:
        """Notes a text, even if it looks like a number.

        Raises:
            BehaviorTreeError: As `literal`.
        """
        self.require(True, f"the text {text[:MAX_TEXT]!r}", place, node)
        if len(text) > MAX_TEXT:
            raise BehaviorTreeError(
                f"a text may have {MAX_TEXT} letters, this has {len(text)}",
                place,
                node=node,
            )

    def join(self, other: "Kind", place: Place, node: str) -> None:
        """Makes the two kinds one.

        Raises:
            BehaviorTreeError: If the one is texts and the other numbers.
        """
        ours, theirs = self._last(), other._last()
        if ours is theirs:
            return
        if ours._text is None:
            ours, theirs = theirs, ours
        if theirs._text is not None and theirs._text is not ours._text:
            words = {True: "a text", False: "a number"}
            raise BehaviorTreeError(
                f"what meets here must be of one type: {ours._reason} needs"
                f" {words[bool(ours._text)]}, and {theirs._reason}"
                f" {words[theirs._text]}",
                place,
                node=node,
            )
        theirs._next = ours

    def _last(self) -> "Kind":
        last = self
        while last._next is not None:
            last = last._next
        # Later look-ups are short.
        if last is not self:
            self._next = last
        return last


class Texts:
    """The texts of a tree, each once, and the numbers that stand for them."""

    def __init__(self) -> None:
        """Constructs an empty table."""
        self._codes: dict[str, int] = {}

    def add(self, text: str) -> None:
        """Adds a text if it is not in the table."""
        self._codes.setdefault(text, len(self._codes))

    def number(self, literal: str, kind: Kind) -> float:
        """Returns what stands for a literal of some kind in the memory."""
        if kind.is_text:
            return float(self._codes[literal])
        number = number_of(literal)
        assert number is not None  # Else its kind would be texts.
        return number

    def table(self) -> tuple[str, ...]:
        """Returns the texts; the index of each is its number."""
        return tuple(self._codes)
