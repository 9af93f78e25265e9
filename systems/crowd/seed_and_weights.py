"""Sets the states, the seed and the weights in the Context of a crowd."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import Context

from hunav_drake.systems.common.layout import MOTION_SIZE, STATE_SIZE, Y
from hunav_drake.systems.common.random_streams import (
    check_seed,
    halves_to_seed,
    seed_to_halves,
)
from hunav_drake.systems.crowd.bodies.standing import STANCE_SIZE
from hunav_drake.systems.crowd.limits import plain
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.parameters import NUM_PARAMETERS
from hunav_drake.systems.people.profile import ProfileName
from hunav_drake.systems.people.starts import draw_starts
from hunav_drake.systems.people.weights import check_weights, draw_weights

# People who are put elsewhere by more than this do not come back, in meters.
_SHIFT = 0.5


class SeedAndWeights:
    """Sets the states of people, and sets and returns the seed and the weights.

    A part of `HumanCrowd`, which declares the parameters and the state.
    """

    _humans: tuple[HumanConfig, ...]
    _profile: ProfileName
    _start_jitter: float
    # The indices of the states and of the numeric parameters.
    _state: int
    _stances: int
    _weights: int
    _seed: int
    ValidateContext: Callable[[Context], None]
    # Return the rows of the state, and the stances.
    _GetState: Callable[[Context], NDArray[Any]]
    _GetStances: Callable[[Context], NDArray[Any]]

    def _Draw(self, seed: int) -> Sequence[NDArray[np.float64]]:
        """Returns the start, the weights and the halves of a seed."""
        return (
            draw_starts(self._humans, seed, self._start_jitter).ravel(),
            draw_weights(self._humans, seed, self._profile).ravel(),
            seed_to_halves(seed),
        )

    def SetSeed(self, context: Context, seed: int) -> None:
        """Resets people to the start and the weights of a seed.

        They are at rest, as in the default Context of a crowd of that
        seed. Nothing else of the Context changes: `SetHumansSeed` also resets
        the memories of people.

        Args:
            context: Of this system, changed.
            seed: In [0, 2^63).

        Raises:
            ValueError: If the seed is not such a number.
        """
        self.ValidateContext(context)
        start, weights, halves = self._Draw(seed)
        context.SetDiscreteState(self._state, start)
        context.SetDiscreteState(
            self._stances, np.zeros(STANCE_SIZE * len(self._humans))
        )
        for index, vector in (self._weights, weights), (self._seed, halves):
            context.get_mutable_numeric_parameter(index).SetFromVector(vector)

    def GetSeed(self, context: Context) -> int:
        """Returns the seed that a Context was set to.

        Args:
            context: Of this system.
        """
        self.ValidateContext(context)
        return halves_to_seed(self._GetParameter(context, self._seed))

    def CheckContext(self, context: Context) -> None:
        """Checks that the seed and the weights of a Context are valid.

        Raises:
            ValueError: If they are not.
        """
        self.ValidateContext(context)
        halves = self._GetParameter(context, self._seed)
        seed = check_seed(halves_to_seed(halves))
        if not np.array_equal(seed_to_halves(seed), halves):
            raise ValueError(f"no seed has the halves {halves.tolist()}")
        check_weights(self.GetWeights(context), len(self._humans))

    def SetWeights(self, context: Context, weights: ArrayLike) -> None:
        """Sets the weights of the forces on people.

        Args:
            context: Of this system, changed.
            weights: Shape (n, 13): for each person the fields of
                SocialForceParameters, in their order.

        Raises:
            ValueError: If the array does not have that shape, or a weight
                is not finite or out of its range.
        """
        self.ValidateContext(context)
        rows = check_weights(weights, len(self._humans))
        vector = context.get_mutable_numeric_parameter(self._weights)
        vector.SetFromVector(rows.ravel())

    def GetWeights(self, context: Context) -> NDArray[np.float64]:
        """Returns the weights of the forces, a copy of shape (n, 13).

        They are as `SetWeights` takes them, and have no derivatives.

        Args:
            context: Of this system.
        """
        self.ValidateContext(context)
        weights = self._GetParameter(context, self._weights)
        return weights.reshape(-1, NUM_PARAMETERS)

    def _GetParameter(
        self, context: Context, index: int
    ) -> NDArray[np.float64]:
        """Returns a copy of a numeric parameter, without derivatives."""
        vector = context.get_numeric_parameter(index).CopyToVector()
        return plain(vector).ravel()

    def SetStates(self, context: Context, states: ArrayLike) -> None:
        """Sets the positions and velocities of people.

        Args:
            context: Of this system, changed.
            states: Shape (n, 6 or 7): rows of ``human_states``; radii are
                not read.

        Raises:
            ValueError: If the array does not have that shape, or a number is
                not finite.
        """
        self.ValidateContext(context)
        rows = np.asarray(states)
        n = len(self._humans)
        if rows.shape not in ((n, STATE_SIZE), (n, MOTION_SIZE)):
            raise ValueError(
                f"states must have shape ({n}, {STATE_SIZE}) or"
                f" ({n}, {MOTION_SIZE}), got {rows.shape}"
            )
        if not np.isfinite(plain(rows)).all():
            raise ValueError(f"states must be finite, got {plain(rows)}")
        stances = self._GetStances(context).copy()
        was = self._GetState(context)
        moved = rows[:, : Y + 1] - was[:, : Y + 1]
        stances[(abs(moved) > _SHIFT).any(axis=1)] = 0.0
        context.SetDiscreteState(self._state, rows[:, :MOTION_SIZE].ravel())
        context.SetDiscreteState(self._stances, stances.ravel())
