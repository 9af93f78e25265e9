"""Fixes of findings, which a button applies."""

from collections.abc import Iterator
import math
import re
from typing import Any

from hunav_drake.editor.document.plain_data import get
from hunav_drake.scenario.error import Finding, Loc
from hunav_drake.systems.common.old_words import TAG

Fix = dict[str, Any]

_NUMBER = r"(-?[0-9.]+(?:e[-+]?[0-9]+)?)"
_MOVE = re.compile(rf"move it {_NUMBER} m along \({_NUMBER}, {_NUMBER}\)")
_TO = re.compile(
    rf"(?:move the goal to|place inside is) \({_NUMBER}, {_NUMBER}\)"
)
_ASIDE = re.compile(rf"starts on the same point .*; move it by {_NUMBER} m")
_MEANT = re.compile(r"did you mean '([^']*)'\?")
_RANGE = re.compile(rf"must be in ([(\[]){_NUMBER}, (inf|{_NUMBER})[)\]]")
_NEAREST = re.compile(rf"; nearest: {_NUMBER}")
_AT_LEAST = re.compile(rf"must be at least \w+(?:\.\w+)? \({_NUMBER}")
_REPEATS = re.compile(r"repeats points\[[0-9]+\]")


def fix_of(finding: Finding, data: Any) -> Fix | None:
    """Returns the fix of a finding in scenario data, for the page.

    It does what the remedy in the finding's text says.

    Returns:
        {"label", "ops"}, or None if there is no automatic fix.
    """
    return next(_fixes(finding, data), None)


def _fixes(finding: Finding, data: Any) -> Iterator[Fix]:
    loc, message = finding.loc, finding.message
    value = get(data, loc)
    if found := _MOVE.search(message):
        length, x, y = map(float, found.groups())
        label = f"M{found[0][1:]}"
        yield from _moved(loc, value, (length, x, y), label)
    elif found := _TO.search(message):
        if isinstance(value, list):
            moved = [*map(float, found.groups()), *value[2:]]
            label = f"Move the goal to ({found[1]}, {found[2]})"
            yield _fix(label, ["set", list(loc), moved])
    elif found := _ASIDE.match(message):
        yield from _moved(loc, value, (float(found[1]), 1.0, 0.0))
    elif message.startswith("unknown key;") and (
        found := _MEANT.search(message)
    ):
        yield from _renamed(loc, data, found[1])
    elif message.startswith(f"is now {TAG!r};"):
        yield from _renamed(loc, data, TAG)
    elif message.startswith(("unknown key;", "is the old word for")):
        yield _fix("Remove it", ["remove", list(loc)])
    elif found := _MEANT.search(message):
        if isinstance(value, str):
            yield _fix(f"Use {found[1]}", ["set", list(loc), found[1]])
    elif message.startswith("must be unique,"):
        yield from _unique(loc, data, value)
    elif (found := _NEAREST.search(message)) or (
        found := _AT_LEAST.search(message)
    ):
        yield _number(loc, float(found[1]))
    elif found := _RANGE.search(message):
        yield from _clamped(loc, value, found)
    elif _REPEATS.match(message):
        points = get(data, loc[:-1])
        if isinstance(points, list) and len(points) > 3:
            yield _fix("Remove the point", ["remove", list(loc)])


def _fix(label: str, *operations: list[Any]) -> Fix:
    return {"label": label, "ops": list(operations)}


def _number(loc: Loc, value: float) -> Fix:
    return _fix(f"Set it to {value:g}", ["set", list(loc), value])


def _moved(
    loc: Loc, value: Any, way: tuple[float, float, float], label: str = ""
) -> Iterator[Fix]:
    """Yields a fix that moves a point or a pose along a direction."""
    if not isinstance(value, list) or len(value) not in (2, 3):
        return
    if any(type(it) not in (int, float) for it in value):
        return
    length, x, y = way
    # A point on a wall has no direction, and moves along x.
    norm = math.hypot(x, y)
    x, y = (x / norm, y / norm) if norm else (1.0, 0.0)
    moved = [
        round(it + length * step, 3) if abs(length * step) >= 1e-3 else it
        for it, step in zip(value, (x, y), strict=False)
    ]
    label = label or f"Move it {length:g} m along ({x:g}, {y:g})"
    yield _fix(label, ["set", list(loc), [*moved, *value[2:]]])


def _renamed(loc: Loc, data: Any, name: str) -> Iterator[Fix]:
    holder = get(data, loc[:-1])
    if isinstance(holder, dict) and name not in holder and loc[-1] in holder:
        value = holder[str(loc[-1])]
        yield _fix(
            f"Rename it to {name}",
            ["remove", list(loc)],
            ["set", [*loc[:-1], name], value],
        )


def _unique(loc: Loc, data: Any, value: Any) -> Iterator[Fix]:
    """Yields a fix that sets a free name or number."""
    members = get(data, loc[:-2])
    if not isinstance(members, list):
        return
    taken = {
        it.get(loc[-1])
        for it in members
        if isinstance(it, dict) and isinstance(it.get(loc[-1]), str | int)
    }
    if isinstance(value, str):
        stem = re.sub(r"_[0-9]+$", "", value)[:58]
        count = 2
        while f"{stem}_{count}" in taken:
            count += 1
        yield _fix(
            f"Rename it to {stem}_{count}",
            ["set", list(loc), f"{stem}_{count}"],
        )
    elif type(value) is int:
        free = next(i for i in range(1, len(members) + 2) if i not in taken)
        yield _fix(f"Use {free}", ["set", list(loc), free])


def _clamped(loc: Loc, value: Any, found: re.Match[str]) -> Iterator[Fix]:
    """Yields a fix that limits a number to its range."""
    if type(value) not in (int, float):
        return
    low, high = float(found[2]), float(found[3])
    if value > high and math.isfinite(high):
        yield _number(loc, high)
    elif value < low and found[1] == "[":
        yield _number(loc, low)
