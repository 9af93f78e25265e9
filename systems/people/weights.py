"""The weights of the forces on people who are not all alike.

The modes are those of HuNavSim 2.0, and so are the distributions.
"""

from collections.abc import Callable, Mapping, Sequence
import dataclasses
from types import MappingProxyType
from typing import NamedTuple

from hunav_drake.systems.common.random_streams import (
    Purpose,
    check_seed,
    draw_normal,
    draw_uniform,
)
from hunav_drake.systems.people.human_config import ForcesMode, HumanConfig
from hunav_drake.systems.people.names import check_consistent, people_ids
from hunav_drake.systems.people.parameters import SocialForceParameters


class Weight(NamedTuple):
    """How one factor of the forces differs between people.

    Attributes:
        mean: The mean of the normal distribution.
        deviation: Its standard deviation.
        least: What is drawn below this becomes this.
        low: The lower end of the uniform distribution.
        high: Its upper end, which is not drawn itself.
    """

    mean: float
    deviation: float
    least: float
    low: float
    high: float


# The factors that are drawn, by their names in SocialForceParameters. Even a
# draw a hundred deviations above the mean would be in their range.
WEIGHTS: Mapping[str, Weight] = MappingProxyType(
    {
        "goal_factor": Weight(2.0, 1.5, 0.5, 2.0, 5.0),
        "obstacle_factor": Weight(10.0, 4.0, 0.5, 2.0, 50.0),
        "social_factor": Weight(4.0, 3.5, 3.0, 4.0, 20.0),
    }
)


def draw_weights(humans: Sequence[HumanConfig], seed: int) -> list[HumanConfig]:
    """Returns the people with the weights that their modes give them.

    Each person's draws follow from the seed and the person's number alone:
    they stay as they are when others are added or removed.

    Args:
        humans: The people. Those without a number have the one that
            `people_ids` gives.
        seed: The seed of the trial, in [0, 2^63).

    Returns:
        The people in the same order, all with mode "custom": drawing again
        changes nothing.

    Raises:
        ValueError: If the seed is not such a number, or if people are mixed
            up: see `check_consistent`.
    """
    check_seed(seed)
    check_consistent(humans)
    return [
        _draw(human, seed, human_id)
        for human, human_id in zip(humans, people_ids(humans), strict=True)
    ]


def _draw(human: HumanConfig, seed: int, human_id: int) -> HumanConfig:
    factors = _MODES[human.forces_mode](seed, human_id)
    return dataclasses.replace(
        human,
        forces=dataclasses.replace(human.forces, **factors),
        forces_mode="custom",
    )


Factors = dict[str, float]


def _custom(seed: int, human_id: int) -> Factors:
    return {}


def _default(seed: int, human_id: int) -> Factors:
    default = SocialForceParameters()
    return {name: getattr(default, name) for name in WEIGHTS}


def _random_normal(seed: int, human_id: int) -> Factors:
    draws = draw_normal(seed, human_id, Purpose.WEIGHTS_NORMAL, len(WEIGHTS))
    return {
        name: max(weight.least, weight.mean + weight.deviation * draw)
        for (name, weight), draw in zip(
            WEIGHTS.items(), draws.tolist(), strict=True
        )
    }


def _random_uniform(seed: int, human_id: int) -> Factors:
    draws = draw_uniform(seed, human_id, Purpose.WEIGHTS_UNIFORM, len(WEIGHTS))
    return {
        name: weight.low + (weight.high - weight.low) * draw
        for (name, weight), draw in zip(
            WEIGHTS.items(), draws.tolist(), strict=True
        )
    }


_MODES: Mapping[ForcesMode, Callable[[int, int], Factors]] = MappingProxyType(
    {
        "custom": _custom,
        "default": _default,
        "random_normal": _random_normal,
        "random_uniform": _random_uniform,
    }
)


def check_drawn(humans: Sequence[HumanConfig]) -> None:
    """Checks that nobody has weights that are still to be drawn.

    Raises:
        ValueError: If somebody has.
    """
    for i, human in enumerate(humans):
        if human.forces_mode not in ("custom", "default"):
            raise ValueError(
                f"humans[{i}].forces_mode is {human.forces_mode!r}, whose"
                " weights follow from a seed: give HumanCrowd the people"
                " draw_weights(humans, seed)"
            )
