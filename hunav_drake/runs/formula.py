"""Formulas that compare means: sfw >= 1.15 * dwb and scl < sfw.

They are Python's comparisons of sums, products and powers of names and
numbers, joined by `and`, `or` and `not`; `&`, `|` and `~` are the same for
comparisons in brackets.
"""

import ast
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import reduce
import operator
import re
import sys
from typing import Any

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask

_ARITHMETIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}
_SIGNS: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
_JOINTS: dict[type[ast.operator | ast.boolop], Callable[[Any, Any], Any]] = {
    ast.And: np.logical_and,
    ast.BitAnd: np.logical_and,
    ast.Or: np.logical_or,
    ast.BitOr: np.logical_or,
}

_AS_IN = "as in sfw >= 1.15 * dwb"


def formula_name(label: str) -> str:
    """Returns the name of a label in formulas."""
    return re.sub(r"\W", "_", label)


def names_in(formula: str) -> list[str]:
    """Returns the names in a formula, in their order."""
    nodes = ast.walk(ast.parse(formula.strip(), mode="eval"))
    found = [node for node in nodes if isinstance(node, ast.Name)]
    found.sort(key=lambda node: (node.lineno, node.col_offset))
    return list(dict.fromkeys(node.id for node in found))


def check_formula(formula: str) -> None:
    """Checks that a formula can be evaluated.

    Raises:
        ValueError: If not; the message has the rule, without the formula.
    """
    try:
        holds(formula, defaultdict(lambda: np.ones(1)), 1)
    except (SyntaxError, UnicodeError, RecursionError, MemoryError):
        raise ValueError(f"must compare names and numbers, {_AS_IN}") from None


def holds(formula: str, values: Mapping[str, Array], size: int) -> Mask:
    """Returns where a formula holds, for several values of each name.

    It does not hold where a compared value is NaN.

    Args:
        formula: A formula that `check_formula` accepts.
        values: The values of each name, shape (size,).
        size: The number of values.
    """
    tested = _Formula(values, size)
    told = tested.truth(ast.parse(formula.strip(), mode="eval").body)
    found: Mask = np.broadcast_to(told, size) & tested.known
    return found


class _Formula:
    """Evaluates a formula; raises a ValueError if it is not one."""

    def __init__(self, values: Mapping[str, Array], size: int) -> None:
        self._values = values
        # Where no compared value is NaN.
        self.known = np.ones(size, dtype=bool)

    def truth(self, node: ast.expr) -> Any:
        """Returns where an expression is true."""
        match node:
            case ast.Compare():
                return self._compare(node)
            case ast.BoolOp(op=op, values=parts):
                return reduce(_JOINTS[type(op)], map(self.truth, parts))
            case ast.BinOp(left, ast.BitAnd() | ast.BitOr() as op, right):
                return _JOINTS[type(op)](self.truth(left), self.truth(right))
            case ast.UnaryOp(ast.Not() | ast.Invert(), operand):
                return np.logical_not(self.truth(operand))
        self._number(node)
        raise ValueError(
            f"must be a comparison, {_AS_IN}: a number neither holds nor fails"
        )

    def _compare(self, node: ast.Compare) -> Any:
        if not any(isinstance(it, ast.Name) for it in ast.walk(node)):
            raise ValueError(f"must compare names, {_AS_IN}, not only numbers")
        if any(type(op) not in _COMPARISONS for op in node.ops):
            raise ValueError("must compare by <, <=, >, >=, == or !=")
        sides = [self._number(it) for it in (node.left, *node.comparators)]
        for side in sides:
            self.known &= ~np.isnan(side)
        pairs = zip(node.ops, sides[:-1], sides[1:], strict=True)
        told = [_COMPARISONS[type(op)](a, b) for op, a, b in pairs]
        return np.logical_and.reduce(told)

    def _number(self, node: ast.expr) -> Any:
        """Returns the values of an expression."""
        match node:
            case ast.Name():
                return self._values[node.id]
            case ast.Constant(value=bool() | str() | bytes() | complex()):
                raise ValueError(f"must have numbers, not {node.value!r:.40}")
            case ast.Constant(value=int() | float() as value):
                if abs(value) > sys.float_info.max:
                    raise ValueError("must have finite numbers")
                # Python's integers could grow without limit.
                return np.float64(value)
            case ast.BinOp(left, op, right) if type(op) in _ARITHMETIC:
                sides = self._number(left), self._number(right)
                with np.errstate(all="ignore"):
                    return _ARITHMETIC[type(op)](*sides)
            case ast.UnaryOp(op, operand) if type(op) in _SIGNS:
                return _SIGNS[type(op)](self._number(operand))
            case ast.BinOp(op=ast.BitAnd() | ast.BitOr()):
                raise ValueError(
                    "must have brackets around comparisons with & and |; or use"
                    " `and` and `or`"
                )
        raise ValueError(
            f"must compare names and numbers by + - * / ** and brackets,"
            f" {_AS_IN}"
        )
