"""The weights of the forces on people who differ from each other.

The modes are those of HuNavSim 2.0, and so are the distributions.
"""

from collections.abc import Mapping, Sequence
import operator
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from pydantic import TypeAdapter, ValidationError

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.random_streams import (
    Purpose,
    check_seed,
    draw_normal,
    draw_uniform,
)
from hunav_drake.systems.people.human_config import ForcesMode, HumanConfig
from hunav_drake.systems.people.names import people_ids
from hunav_drake.systems.people.parameters import (
    NUM_PARAMETERS,
    PARAMETERS,
    SocialForceParameters,
)
from hunav_drake.systems.people.profile import ProfileName, own_forces


class Weight(NamedTuple):
    """The distributions of one factor of the forces.

    Attributes:
        mean: The mean of the normal distribution.
        deviation: Its standard deviation.
        least: The least value: lower draws become this.
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


def draw_weights(
    humans: Sequence[HumanConfig], seed: int, profile: ProfileName = "default"
) -> Array:
    """Returns the weights of people, according to their modes.

    Each person's draws follow from the seed and the person's number alone:
    they stay as they are when others are added or removed.

    Args:
        humans: The people. People without a number have that of
            `people_ids`.
        seed: The seed of the trial, in [0, 2^63).
        profile: The profile of the crowd, for people without weights.

    Returns:
        Shape (n, 13): for each person the fields of SocialForceParameters.

    Raises:
        ValueError: If the seed is not such a number.
    """
    check_seed(seed)
    weights = np.array(
        [_as_written(own_forces(human, profile)) for human in humans]
    )
    weights = weights.reshape(len(humans), NUM_PARAMETERS)
    ids = people_ids(humans)
    modes: tuple[ForcesMode, ...] = (
        "default",
        "random_normal",
        "random_uniform",
    )
    for mode in modes:
        rows = [i for i, h in enumerate(humans) if h.forces_mode == mode]
        if rows:
            own_ids = [ids[i] for i in rows]
            weights[np.ix_(rows, _COLUMNS)] = _draw(mode, seed, own_ids)
    return weights


# The columns of the factors that are drawn.
_COLUMNS = [PARAMETERS.index(name) for name in WEIGHTS]
_MEAN, _DEVIATION, _LEAST, _LOW, _HIGH = np.transpose(list(WEIGHTS.values()))
_as_written = operator.attrgetter(*PARAMETERS)
_as_default = operator.attrgetter(*WEIGHTS)


def _draw(mode: ForcesMode, seed: int, ids: Sequence[int]) -> Any:
    """Returns the values that replace the written factors in some modes."""
    if mode == "random_normal":
        draws = draw_normal(seed, ids, Purpose.WEIGHTS_NORMAL, len(WEIGHTS))
        return np.maximum(_LEAST, _MEAN + _DEVIATION * draws)
    if mode == "random_uniform":
        draws = draw_uniform(seed, ids, Purpose.WEIGHTS_UNIFORM, len(WEIGHTS))
        return _LOW + (_HIGH - _LOW) * draws
    return _as_default(SocialForceParameters())


def check_weights(weights: ArrayLike, num_humans: int) -> Array:
    """Returns weights (n, 13) that `SocialForceParameters` allows, as an array.

    Raises:
        ValueError: If the array has another shape, or if a weight is not
            finite or out of its range.
    """
    rows = np.asarray(weights, dtype=float)
    if rows.shape != (num_humans, NUM_PARAMETERS):
        raise ValueError(
            f"weights must have shape ({num_humans}, {NUM_PARAMETERS}), a row"
            f" of SocialForceParameters for each person, got {rows.shape}"
        )
    for i, k in np.argwhere(~np.isfinite(rows)).tolist():
        raise ValueError(
            f"weights[{i}].{PARAMETERS[k]} must be finite, got {rows[i, k]}"
        )
    rule = TypeAdapter(SocialForceParameters)
    for i, row in enumerate(rows.tolist()):
        try:
            rule.validate_python(dict(zip(PARAMETERS, row, strict=True)))
        except ValidationError as error:
            fault = error.errors()[0]
            raise ValueError(
                f"weights[{i}].{fault['loc'][0]} {fault['msg']}"
            ) from error
    return rows
