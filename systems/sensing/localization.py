"""The LeafSystem between a robot and a planner that estimates its pose."""

import math
from typing import Any

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    InputPort,
    LeafSystem,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_count
from hunav_drake.systems.common.layout import (
    STATE_SIZE,
    VX,
    VY,
    YAW,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.common.random_streams import Purpose, draw_normal
from hunav_drake.systems.common.sampling import Sampling


class Localization(Sampling, LeafSystem):
    """Estimates the pose of a robot, with an error.

    .. pydrake_system::

        name: Localization
        input_ports:
        - robot_state
        - people (only with people)
        output_ports:
        - estimated_robot_state
        - localization
        - estimated_people (only with people)

    Port ``robot_state`` takes the true row (x, y, yaw, vx, vy, omega, radius)
    of the robot, ``people`` n such rows of people whom it perceives, in W.
    Port ``localization`` gives the error (x, y, yaw), the estimated pose less
    the true one in W, and the true pose for which it was drawn, in meters and
    radians: every ``time_step``, from the seed, the number and the step. Port
    ``estimated_robot_state`` gives the row of the robot at the estimated pose;
    its speeds relative to the robot are exact. Port ``estimated_people`` gives
    the rows of people moved by the same rigid motion, so that they are relative
    to the estimated pose as they are to the robot. Rows outside stay.

    For the state see `Sampling`: a sample is what ``localization`` gives.
    """

    def __init__(
        self,
        model: Any,
        *,
        num_people: int = 0,
        time_step: float = 0.05,
        seed: int = 0,
        number: int = 0,
    ) -> None:
        """Constructs a Localization.

        `model` is an `ErrorModel`; for the other arguments see `Lidar`.

        Raises:
            ValueError: If a number is out of its range.
        """
        super().__init__()
        self._model = model
        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._DeclareSampling(
            np.zeros(6),
            period=time_step,
            time_step=time_step,
            seed=seed,
            number=number,
        )
        size = check_count("num_people", num_people) * STATE_SIZE
        declare = self.DeclareVectorOutputPort
        self._samples = declare("localization", 6, self._CalcSample)
        declare("estimated_robot_state", STATE_SIZE, self._CalcState)
        if size:
            self._people = self.DeclareVectorInputPort("people", size)
            declare("estimated_people", size, self._CalcPeople)

    def _Measure(self, context: Context, held: Array, number: int) -> Array:
        pose = self._robot_state.Eval(context)[: YAW + 1]
        (normal,) = draw_normal(
            *(self.GetSeed(context), [self._number], Purpose.LOCALIZATION, 3),
            step=number,
        )
        error = None if held[-1] < 0 else held[:3]
        motion = held[3:6], pose
        after = self._model.next_error(error, motion, self._time_step, normal)
        return np.concatenate([after, pose])

    def _CalcState(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._Move(context, self._robot_state))

    def _CalcPeople(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._Move(context, self._people))

    def _Move(self, context: Context, port: InputPort) -> Array:
        """Returns rows, moved by the motion from the true pose to the estimate.

        Where the error is 0, they are equal, bit for bit.
        """
        rows: Array = port.Eval(context).reshape(-1, STATE_SIZE).copy()
        robot = self._robot_state.Eval(context)
        error_x, error_y, turn = self._samples.Eval(context)[:3].tolist()
        c, s = math.cos(turn) - 1, math.sin(turn)
        change = np.array([[c, s], [-s, c]])
        here = ~is_outside(rows)
        away = rows[:, [X, Y]] - robot[[X, Y]]
        moved = np.array([error_x, error_y])
        moved = moved + np.einsum("ij,jk->ik", away, change)
        rows[:, [X, Y]] += here[:, None] * moved
        rows[:, [VX, VY]] += np.einsum("ij,jk->ik", rows[:, [VX, VY]], change)
        rows[:, YAW] += here * turn
        return rows.ravel()
