"""The choices of the package, and what must be given of them."""

import os
from pathlib import Path

import pytest

from hunav_drake.systems.common.registry import Registry
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.world.furniture import FURNITURE

# The metrics of trials with one robot and without recorded people.
COMMON_METRICS = {
    name: it
    for name, it in METRICS.items()
    if it.family not in ("replay", "fleet")
}


def shipped(registry: Registry) -> list[str]:
    """Returns the choices of a register that no test has added, sorted."""
    own = "hunav_drake."
    return sorted(
        it for it in registry if registry[it].__module__.startswith(own)
    )


def fast(choices, *names: str):
    """Returns parameters of which all but those of these names are slow."""
    return [
        it if it in names else pytest.param(it, marks=pytest.mark.slow)
        for it in choices
    ]


# What has no default.
SQUARE = [[8, 8], [9, 8], [9, 9]]
NEEDED = {
    "box": {"center": [8.5, 8.5], "size": [1, 1]},
    "polygon": {"points": SQUARE},
    "disc": {"center": [8.5, 8.5], "radius": 0.5},
    "polyline": {"points": SQUARE},
    **{kind: {"center": [8.5, 8.5]} for kind in FURNITURE},
    "urdf": {
        # A car, which any drive moves: that of `carts.py` with steered wheels.
        "file": str(Path(__file__).parent / "data/car.urdf"),
        "base": "base",
        "drive": {"type": "omnidirectional", "height": 0.11},
    },
    # Without somebody who drives it, the robot stands. Trials at once, of other
    # processes, need other domains.
    "bridge": {"lockstep": False, "domain": 60 + os.getpid() % 35},
    "differential": {
        "left_wheel": "rear_left_wheel",
        "right_wheel": "rear_right_wheel",
        "wheel_separation": 0.4,
        "wheel_radius": 0.1,
    },
    "ackermann": {
        "left_wheel": "rear_left_wheel",
        "right_wheel": "rear_right_wheel",
        "left_steering": "front_left_wheel_steering",
        "right_steering": "front_right_wheel_steering",
        "wheel_radius": 0.1,
    },
    "mecanum": {
        **{
            name: name
            for name in (
                f"{x}_{y}_wheel"
                for x in ("front", "rear")
                for y in ("left", "right")
            )
        },
        "wheel_radius": 0.1,
    },
}
