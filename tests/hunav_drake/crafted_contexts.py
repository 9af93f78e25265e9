"""Context files that somebody has made up: wrong, but with a right digest."""

from collections.abc import Callable, Iterator
import json
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hunav_drake.trial.context_file import _digest

Arrays = dict[str, NDArray[Any]]

# What an array of numbers becomes.
_CHANGES: tuple[Callable[[NDArray[Any]], NDArray[Any]], ...] = (
    lambda a: a.astype(str),
    lambda a: np.zeros(a.shape, complex),
    lambda a: np.zeros(a.shape, bool),
    lambda a: np.zeros(a.shape, np.float32),
    lambda a: np.zeros((*a.shape, 2)),
    lambda a: np.zeros(0),
    lambda a: np.zeros((0, *a.shape)),
    lambda a: a.ravel()[: a.size // 2],
    lambda a: np.concatenate([a.ravel(), a.ravel()]),
    lambda a: a.T.copy().reshape(-1, 1),
    lambda a: ~a if a.dtype == bool else np.full(a.shape, 7),
)
_NUMBERS = (math.nan, math.inf, -math.inf, 1e308, -1e9, 1e18, -1.0, 0.5, 1e-320)

# What a part of JSON becomes.
_WRONG: tuple[Any, ...] = (
    *(None, True, -1, 10**30, 0.5, math.nan, 1e308, "", "x" * 5000, [], {}),
    *([[]], {"a": 1}, {"array": "none"}, {"tuple": 5}, {"tuple": [None]}),
    *({"class": 5}, {"class": "os:system", "items": {}}, {"class": "a:b"}),
)


def crafted(arrays: Arrays, count: int, seed: int = 0) -> Iterator[Arrays]:
    """Yields what a file holds, each time with one thing wrong in it."""
    draw = np.random.default_rng(seed)
    names = [name for name in arrays if name != "sha256"]
    for i in range(count):
        changed = {name: arrays[name] for name in names}
        # Each entry has its turn.
        name = names[i % len(names)]
        if draw.random() < 0.08:
            del changed[name]
        elif _is_json(arrays[name]):
            changed[name] = np.array(_with_wrong_part(draw, arrays[name]))
        else:
            changed[name] = _with_wrong_number(draw, arrays[name])
        changed["sha256"] = np.array(_digest(changed))
        yield changed


def _is_json(array: NDArray[Any]) -> bool:
    return array.dtype.kind == "U" and str(array)[:1] in "[{"


def _with_wrong_number(
    draw: np.random.Generator, array: NDArray[Any]
) -> NDArray[Any]:
    if draw.random() < 0.5 or not array.size or array.dtype.kind != "f":
        return _CHANGES[draw.integers(len(_CHANGES))](array)
    changed = array.copy()
    at = draw.integers(array.size)
    changed.reshape(-1)[at] = _NUMBERS[draw.integers(len(_NUMBERS))]
    return changed


def _with_wrong_part(draw: np.random.Generator, array: NDArray[Any]) -> str:
    """Returns JSON with another part somewhere, or that is none."""
    text = str(array)
    if draw.random() < 0.1:
        return text[: draw.integers(len(text))]
    whole = {"": json.loads(text)}
    places = list(_places(whole))
    part, key = places[draw.integers(len(places))]
    if draw.random() < 0.2:
        del part[key]
    else:
        part[key] = _WRONG[draw.integers(len(_WRONG))]
    return json.dumps(whole.get("", 0))


def _places(part: Any) -> Iterator[tuple[Any, Any]]:
    keys = part if isinstance(part, dict) else range(len(part))
    for key in list(keys):
        yield part, key
        if isinstance(part[key], dict | list):
            yield from _places(part[key])
