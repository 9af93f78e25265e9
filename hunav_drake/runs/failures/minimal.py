"""Takes from a failing scene what its failure does not need."""

from collections.abc import Generator
import copy
import math
from typing import Any, NamedTuple

from hunav_drake.scenario.error import Loc, child
from hunav_drake.scenario.schema import SimulationConfig
from hunav_drake.systems.evaluation.robustness import Failing

# The numbers of decimals that are tried.
_DECIMALS = (1, 2, 3)

# How long a scene goes on after its failure, in seconds.
_AFTER = 2.0


class Shrinking(NamedTuple):
    """A failing scene.

    Attributes:
        data: Its scenario as plain data.
        ranges: The ranges of the numbers that the search has found, by their
            places.
        failing: How it fails.
    """

    data: dict[str, Any]
    ranges: dict[Loc, list[float]]
    failing: Failing


def shrink(scene: Shrinking) -> Generator[dict[str, Any], Failing, Shrinking]:
    """Makes a scene minimal, as long as it fails.

    People are left out one by one; behaviors become the default one; the
    numbers that the search has found get 1, 2 or 3 decimals, within their
    ranges; and the trial ends 2 s after the failure.

    Yields:
        The data of a scene to try; it is sent how near that is to a failure.

    Returns:
        The minimal scene.
    """
    i = 0
    while i < len(scene.data.get("humans", [])):
        data = copy.deepcopy(scene.data)
        del data["humans"][i]
        failing = yield data
        if failing.robustness < 0:
            ranges = {
                left: ends
                for loc, ends in scene.ranges.items()
                if (left := _without(loc, i))
            }
            scene = Shrinking(data, ranges, failing)
        else:
            i += 1
    for i, human in enumerate(scene.data.get("humans", [])):
        if "behavior" in human:
            data = copy.deepcopy(scene.data)
            del data["humans"][i]["behavior"]
            failing = yield data
            if failing.robustness < 0:
                scene = scene._replace(data=data, failing=failing)
    for decimals in _DECIMALS:
        data = _rounded(scene, decimals)
        if data == scene.data:
            break
        failing = yield data
        if failing.robustness < 0:
            scene = scene._replace(data=data, failing=failing)
            break
    data = copy.deepcopy(scene.data)
    simulation = data.setdefault("simulation", {})
    config = SimulationConfig()
    step = simulation.get("time_step", config.time_step)
    end = math.ceil(round((scene.failing.time + _AFTER) / step, 6)) * step
    if end < simulation.get("duration", config.duration):
        simulation["duration"] = round(end, 9)
        failing = yield data
        if failing.robustness < 0:
            scene = scene._replace(data=data, failing=failing)
    return scene


def _without(loc: Loc, person: int) -> Loc:
    """Returns a place when a person has left; empty if it has left, too."""
    if loc[0] != "humans" or len(loc) < 2 or not isinstance(loc[1], int):
        return loc
    if loc[1] == person:
        return ()
    return ("humans", loc[1] - (loc[1] > person), *loc[2:])


def _rounded(scene: Shrinking, decimals: int) -> dict[str, Any]:
    data = copy.deepcopy(scene.data)
    for (*outer, last), (low, high) in scene.ranges.items():
        part: Any = data
        for step in outer:
            part = child(part, step)
        value = child(part, last)
        if isinstance(value, float):
            rounded = round(value, decimals)
            part[last] = float(min(max(rounded, low), high))
    return data
