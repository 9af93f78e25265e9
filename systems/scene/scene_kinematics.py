"""Converts the states of people and robot to the positions of their figures."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_time_step
from hunav_drake.systems.common.layout import SIGNAL_SIZE, STATE_SIZE, YAW
from hunav_drake.systems.people.figure_config import Figures, adult_figures
from hunav_drake.systems.people.gait import (
    advance_gait,
    initial_gait,
    pose_figures,
)
from hunav_drake.systems.people.manners import (
    LIVELY_SIZE,
    advance_manners,
    hold_figures,
    initial_manners,
)
from hunav_drake.systems.scene.bounds import port_of


class SceneKinematics(LeafSystem):
    """Computes the positions of walking figures from the states of people.

    .. pydrake_system::

        name: SceneKinematics
        input_ports:
        - human_states
        - robot_state (of several robots, NAME_robot_state for each)
        - social_signals (only of lively figures)
        output_ports:
        - positions

    Port `human_states` takes the states of `n` people (size 7n, see
    `common.layout`), and `robot_state` that of the robot (size
    7); without a robot there is no such port. Port `social_signals` takes `n`
    rows of `layout.Signal`, what people show; lively figures sit, look and
    gesture by these, unless it is not connected. Port `positions` gives the
    generalized positions of the scene's plant.

    The discrete state holds for each person the phase of the stride (rad), the
    smoothed speed (m/s) and the last position (m): see `gait`; of lively
    figures, a second group holds `manners`. It is updated every `time_step`.
    """

    def __init__(
        self,
        human_positions: ArrayLike,
        robot_positions: Mapping[str, ArrayLike],
        *,
        num_positions: int,
        default_positions: ArrayLike | None = None,
        time_step: float = 0.05,
        figures: Figures | None = None,
    ) -> None:
        """Constructs a SceneKinematics.

        `human_positions`, shape (n, 10), are the indices of each figure's
        positions in those of the plant (in the order of `gait`), of lively
        figures (n, 14), and
        `robot_positions` those of x, y and yaw of each robot, by its name,
        which is empty for a single one. All others of the `num_positions`
        stay at the `default_positions`, by default at 0. `figures` are those of
        the people, by default adults.
        """
        super().__init__()
        self._human_positions = np.asarray(human_positions, dtype=np.int64)
        self._robot_positions = [
            np.asarray(it, dtype=np.int64) for it in robot_positions.values()
        ]
        if figures is None:
            figures = Figures(adult_figures(len(self._human_positions)))
        self._figures = np.asarray(figures.rows, dtype=float)
        self._default_positions: Array = np.zeros(num_positions)
        if default_positions is not None:
            self._default_positions[:] = default_positions
        self._time_step = check_time_step(time_step)

        self._human_states = self.DeclareVectorInputPort(
            "human_states", STATE_SIZE * len(self._human_positions)
        )
        self._human_states_index = int(self._human_states.get_index())
        self._robot_states = [
            self.DeclareVectorInputPort(
                port_of(name, "robot_state"), STATE_SIZE
            )
            for name in robot_positions
        ]
        self._positions = self.DeclareVectorOutputPort(
            "positions", num_positions, self._CalcPositions
        )
        n, size = self._human_positions.shape
        # (Numbers are found faster by an integer than by a typed index.)
        gait = self.DeclareDiscreteState(initial_gait(figures.numbers()))
        self._gait = int(gait)
        self._signals: InputPort | None = None
        if size == LIVELY_SIZE:
            self._signals = self.DeclareVectorInputPort(
                "social_signals", SIGNAL_SIZE * n
            )
            manners = initial_manners(figures.numbers())
            self._manners = int(self.DeclareDiscreteState(manners))
        if len(self._human_positions):
            self.DeclarePeriodicDiscreteUpdateEvent(
                period_sec=time_step, offset_sec=0.0, update=self._Advance
            )

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port for the states of the people."""
        return self._human_states

    def get_robot_state_input_ports(self) -> list[InputPort]:
        """Returns the ports for the states of the robots."""
        return self._robot_states

    def get_positions_output_port(self) -> OutputPort:
        """Returns the port with the positions of the plant."""
        return self._positions

    def _Advance(self, context: Context, state: DiscreteValues) -> None:
        # Views instead of the copies from Eval: this runs at every step, even
        # without viewers, and advance_gait() only reads.
        humans = self.EvalVectorInput(context, self._human_states_index).value()
        gait = advance_gait(
            context.get_discrete_state(self._gait).value(),
            humans,
            self._time_step,
        )
        state.set_value(self._gait, gait)
        if self._signals is not None and self._signals.HasValue(context):
            robots = [
                it.EvalBasicVector(context).value() for it in self._robot_states
            ]
            manners = advance_manners(
                context.get_discrete_state(self._manners).value(),
                self._signals.EvalBasicVector(context).value(),
                humans,
                np.concatenate([np.zeros(0), *robots]),
                self._time_step,
            )
            state.set_value(self._manners, manners)

    def _CalcPositions(self, context: Context, output: BasicVector) -> None:
        q = self._default_positions.copy()
        # Without people their port may be unconnected.
        if len(self._human_positions):
            figures = pose_figures(
                context.get_discrete_state(self._gait).value(),
                self._human_states.Eval(context),
                self._figures,
            )
            if self._signals is not None:
                manners = context.get_discrete_state(self._manners).value()
                figures = hold_figures(figures, manners, self._figures)
            q[self._human_positions] = figures
        for port, positions in zip(
            self._robot_states, self._robot_positions, strict=True
        ):
            q[positions] = port.Eval(context)[: YAW + 1]
        output.SetFromVector(q)
