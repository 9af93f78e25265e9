"""The scripts in attributes such as `_skipIf`: comparisons and assignments.

BehaviorTree.CPP has a language with arithmetic there; this reads the part of
it that needs no arithmetic::

    _skipIf="mode == 'shy' && !(seen >= 3)"
    _onSuccess="mode := 'bold'; seen = 0"
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
import re

from hunav_drake.systems.behavior.language.blackboard import (
    Entry,
    Scope,
    literal_of,
)
from hunav_drake.systems.behavior.language.entry_types import (
    EntryType,
    TextTable,
)
from hunav_drake.systems.behavior.nodes import operations as op
from hunav_drake.systems.behavior.nodes.errors import Place, Spot
from hunav_drake.systems.behavior.nodes.operations import Instruction, Script
from hunav_drake.systems.common.suggest import shown

MAX_LENGTH = 1000
_MAX_DEPTH = 20

_TOKEN = re.compile(
    r"\s*(?:(?P<number>-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"|'(?P<text>[^']*)'"
    r"|(?P<name>@?[A-Za-z_]\w*)"
    r"|(?P<sign>:=|==|!=|<=|>=|&&|\|\||[<>!()=;]))",
    re.ASCII,
)

_ORDERS = {"<": op.LESS, "<=": op.AT_MOST, ">": op.GREATER, ">=": op.AT_LEAST}
_EQUALITIES = {"==": op.EQUAL, "!=": op.UNEQUAL}
_SIGNS = {**_ORDERS, **_EQUALITIES, "!": op.NOT}
_DECIDING = {"&&": op.AND, "||": op.OR}
_REMEDY = (
    "a script compares values with == != < <= > >= and joins with && || !, or"
    " assigns with :="
)


@dataclass(eq=False)
class Expression:
    """A parsed expression.

    Attributes:
        sign: Its operator; "name", "number" or "text" if it has none.
        literal: The number, the text or the name, if it is one.
        operands: The operands of the operator.
        kind: The type of its value.
        entry: The blackboard entry of a name.
    """

    sign: str
    literal: str = ""
    operands: tuple["Expression", ...] = ()
    kind: EntryType = field(default_factory=EntryType)
    entry: Entry | None = None

    def parts(self) -> Iterator["Expression"]:
        """Yields the expression and all its subexpressions."""
        yield self
        for operand in self.operands:
            yield from operand.parts()


@dataclass(frozen=True)
class Assignment:
    """An assignment of an expression to a blackboard entry."""

    target: Expression
    value: Expression


class _Reader:
    """A recursive-descent parser of one script."""

    def __init__(self, text: str) -> None:
        if len(text) > MAX_LENGTH:
            raise ValueError(f"a script may have {MAX_LENGTH} letters")
        self.tokens: list[tuple[str, str]] = []
        at, end = 0, len(text.rstrip())
        while at < end:
            match = _TOKEN.match(text, at)
            if match is None:
                raise ValueError(
                    f"{text[at:].strip()[:10]!r} is not understood; {_REMEDY}"
                )
            group = match.lastgroup or ""
            self.tokens.append((group, match[group]))
            at = match.end()
        self.at = 0
        self.depth = 0

    def sign(self) -> str:
        """Returns the next sign, or an empty text."""
        if self.at == len(self.tokens):
            return ""
        group, text = self.tokens[self.at]
        return text if group == "sign" else ""

    def wrong(self) -> ValueError:
        if self.at == len(self.tokens):
            return ValueError(f"it ends too early; {_REMEDY}")
        return ValueError(
            f"{shown(self.tokens[self.at][1])} cannot be here; {_REMEDY}"
        )

    def nested(self, read: Callable[[], Expression]) -> Expression:
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            raise ValueError(f"it is nested more than {_MAX_DEPTH} deep")
        result = read()
        self.depth -= 1
        return result

    def expression(self) -> Expression:
        return self.nested(lambda: self.chain("||", self.conjunction))

    def conjunction(self) -> Expression:
        return self.chain("&&", self.comparison)

    def chain(self, sign: str, read: Callable[[], Expression]) -> Expression:
        parts = [read()]
        while self.sign() == sign:
            self.at += 1
            parts.append(read())
        return parts[0] if len(parts) == 1 else Expression(sign, "", (*parts,))

    def comparison(self) -> Expression:
        left = self.operand()
        sign = self.sign()
        if sign not in _ORDERS and sign not in _EQUALITIES:
            return left
        self.at += 1
        return Expression(sign, "", (left, self.operand()))

    def operand(self) -> Expression:
        sign = self.sign()
        if sign == "!":
            self.at += 1
            return Expression("!", "", (self.nested(self.operand),))
        if sign == "(":
            self.at += 1
            result = self.expression()
            if self.sign() != ")":
                raise self.wrong()
            self.at += 1
            return result
        if sign or self.at == len(self.tokens):
            raise self.wrong()
        group, text = self.tokens[self.at]
        self.at += 1
        if group == "name" and text in ("true", "false"):
            group = "number"
        return Expression(group, text)

    def assignments(self) -> Iterator[Assignment]:
        while self.at < len(self.tokens):
            target = self.operand()
            if target.sign != "name" or self.sign() not in (":=", "="):
                raise ValueError("it must be assignments: name := value; ...")
            self.at += 1
            yield Assignment(target, self.expression())
            if self.at < len(self.tokens):
                if self.sign() != ";":
                    raise self.wrong()
                self.at += 1


def read_condition(text: str) -> Expression:
    """Parses a condition, or raises a ValueError."""
    reader = _Reader(text)
    expression = reader.expression()
    if reader.at < len(reader.tokens):
        raise reader.wrong()
    return expression


def read_assignments(text: str) -> tuple[Assignment, ...]:
    """Parses the assignments of a script, or raises a ValueError."""
    return tuple(_Reader(text).assignments())


def bind(expression: Expression, scope: Scope, place: Place) -> None:
    """Looks up the blackboard entries of an expression's names."""
    for part in expression.parts():
        if part.sign == "name":
            part.entry = scope.entry(part.literal, place)


def settle(expression: Expression, spot: Spot) -> None:
    """Infers the types in an expression, or raises a BehaviorTreeError."""
    for part in expression.parts():
        if part.entry is not None:
            if part.entry.set_by_nodes:
                part.kind = part.entry.kind
            else:
                text = literal_of(part.entry, spot)
                part.kind.literal(text, spot)
        elif part.sign == "text":
            part.kind.text(part.literal, spot)
        else:
            what = part.literal or f"what {part.sign} gives"
            part.kind.require(False, what, spot)
    for part in expression.parts():
        if part.sign in _EQUALITIES:
            left, right = part.operands
            left.kind.join(right.kind, spot)
        else:
            for operand in part.operands:
                operand.kind.require(False, part.sign, spot)


def literals(expression: Expression) -> Iterator[tuple[EntryType, str]]:
    """Yields the type and the text of each literal of an expression."""
    for part in expression.parts():
        if part.sign == "text":
            yield part.kind, part.literal
        elif part.entry is not None and not part.entry.set_by_nodes:
            yield part.kind, part.entry.literal or ""


def compiled(expression: Expression, texts: TextTable) -> Script:
    """Returns the script that evaluates a settled expression in a tick."""
    sign, entry = expression.sign, expression.entry
    if entry is not None and entry.set_by_nodes:
        return (Instruction(op.ENTRY, entry.slot),)
    if sign in ("number", "text", "name"):
        literal = expression.literal
        if entry is not None:
            literal = entry.literal or ""
        return (Instruction(op.NUMBER, texts.number(literal, expression.kind)),)
    parts = [compiled(operand, texts) for operand in expression.operands]
    if sign not in _DECIDING:
        operands = [each for part in parts for each in part]
        return (*operands, Instruction(_SIGNS[sign]))
    # If a part decides, what follows up to the end is skipped.
    result = parts[-1]
    for part in reversed(parts[:-1]):
        skip = Instruction(_DECIDING[sign], len(result))
        result = (*part, skip, *result)
    return (*result, Instruction(op.TRUTH))


def assigning(assignment: Assignment, texts: TextTable) -> Script:
    """Returns the script of an assignment."""
    entry = assignment.target.entry
    assert entry is not None  # The target of an assignment is a name.
    value = compiled(assignment.value, texts)
    return (*value, Instruction(op.ASSIGN, entry.slot))
