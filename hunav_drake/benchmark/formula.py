"""Formulas that compare means: sfw >= 1.15 * dwb and scl < sfw.

They are Python's comparisons of sums, products and powers of names and
numbers, joined by `and`, `or` and `not`; `&`, `|` and `~` are the same for
comparisons in brackets.
"""

import ast
from collections.abc import Callable, Iterator, Mapping
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


def formula_name(label: str) -> str:
    """Returns a planner's label, or any other, as formulas call it."""
    return re.sub(r"\W", "_", label)


def names_in(formula: str) -> list[str]:
    """Returns the names in a formula, in their order."""
    nodes = ast.walk(ast.parse(formula.strip(), mode="eval"))
    found = [node for node in nodes if isinstance(node, ast.Name)]
    found.sort(key=lambda node: (node.lineno, node.col_offset))
    return list(dict.fromkeys(node.id for node in found))


def check_formula(formula: str) -> None:
    """Looks whether a formula can be tested.

    Raises:
        ValueError: If not: the text says what it must be, without the formula.
    """
    try:
        body = ast.parse(formula.strip(), mode="eval").body
        faults = list(_truth_faults(body))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        faults = ["must compare names and numbers, as in sfw >= 1.15 * dwb"]
    if faults:
        raise ValueError(faults[0])


def holds(formula: str, values: Mapping[str, Array], size: int) -> Mask:
    """Tells where a formula holds, for several values of each name.

    Where something that it compares is NaN it does not.

    Args:
        formula: One that `check_formula` has nothing against.
        values: The values of each name, shape (size,).
        size: How many values there are.
    """
    known = np.ones(size, dtype=bool)

    def number(node: ast.expr) -> Any:
        match node:
            case ast.Name():
                return values[node.id]
            case ast.Constant():
                # Python's own integers would have no end.
                return np.float64(node.value)  # type: ignore[arg-type]
            case ast.UnaryOp():
                return _SIGNS[type(node.op)](number(node.operand))
            case ast.BinOp():
                left, right = number(node.left), number(node.right)
                return _ARITHMETIC[type(node.op)](left, right)
        raise TypeError(f"{type(node).__name__} is no number")

    def truth(node: ast.expr) -> Any:
        match node:
            case ast.Compare():
                sides = [number(it) for it in (node.left, *node.comparators)]
                for side in sides:
                    known[np.broadcast_to(np.isnan(side), size)] = False
                pairs = zip(node.ops, sides[:-1], sides[1:], strict=True)
                told = [_COMPARISONS[type(op)](a, b) for op, a, b in pairs]
                return np.logical_and.reduce(told)
            case ast.BoolOp():
                told = [truth(it) for it in node.values]
                result = told[0]
                for other in told[1:]:
                    result = _JOINTS[type(node.op)](result, other)
                return result
            case ast.BinOp():
                left, right = truth(node.left), truth(node.right)
                return _JOINTS[type(node.op)](left, right)
            case ast.UnaryOp():
                return np.logical_not(truth(node.operand))
        raise TypeError(f"{type(node).__name__} is no comparison")

    with np.errstate(all="ignore"):
        body = ast.parse(formula.strip(), mode="eval").body
        found: Mask = np.broadcast_to(truth(body), size) & known
    return found


def _truth_faults(node: ast.expr) -> Iterator[str]:
    """Yields what is wrong with what is to be true or not."""
    match node:
        case ast.Compare():
            if not any(isinstance(it, ast.Name) for it in ast.walk(node)):
                yield (
                    "must compare names, as in sfw >= 1.15 * dwb: numbers alone"
                    " say nothing"
                )
            for op in node.ops:
                if type(op) not in _COMPARISONS:
                    yield "must compare by <, <=, >, >=, == or !="
            for side in (node.left, *node.comparators):
                yield from _number_faults(side)
        case ast.BoolOp():
            for part in node.values:
                yield from _truth_faults(part)
        case ast.UnaryOp(op=ast.Not() | ast.Invert()):
            yield from _truth_faults(node.operand)
        case ast.BinOp(op=ast.BitAnd() | ast.BitOr()):
            yield from _truth_faults(node.left)
            yield from _truth_faults(node.right)
        case _:
            yield from _number_faults(node)
            yield (
                "must compare something, as in sfw >= 1.15 * dwb: what is only"
                " a number neither holds nor fails"
            )


def _number_faults(node: ast.expr) -> Iterator[str]:
    """Yields what is wrong with what is to be a number."""
    match node:
        case ast.Name():
            pass
        case ast.Constant(value=bool() as value):
            yield f"must have numbers, not {value}"
        case ast.Constant(value=int() | float() as value):
            if abs(value) > sys.float_info.max:
                yield "must have finite numbers"
        case ast.Constant(value=value):
            yield f"must have numbers, not {value!r:.40}"
        case ast.BinOp() if type(node.op) in _ARITHMETIC:
            yield from _number_faults(node.left)
            yield from _number_faults(node.right)
        case ast.UnaryOp() if type(node.op) in _SIGNS:
            yield from _number_faults(node.operand)
        case ast.BinOp(op=ast.BitAnd() | ast.BitOr()):
            yield (
                "must have brackets around comparisons beside & and |, or `and`"
                " and `or` in their place"
            )
        case _:
            yield (
                "must compare names and numbers by + - * / ** and brackets, as"
                " in sfw >= 1.15 * dwb"
            )
