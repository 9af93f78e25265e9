"""The LeafSystem that detects people in view."""

import math

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.checks import check_count
from hunav_drake.systems.common.layout import OUTSIDE, STATE_SIZE, X, Y
from hunav_drake.systems.sensing.ray_kernels import people_in_view
from hunav_drake.systems.sensing.scans import sensor_pose
from hunav_drake.systems.sensing.sensor_parameters import VisibleParameters
from hunav_drake.systems.world.obstacles import Obstacles


class VisiblePeople(LeafSystem):
    """Detects the people in a robot's view.

    .. pydrake_system::

        name: VisiblePeople
        input_ports:
        - robot_state
        - human_states
        - other_robot_states (only with other robots)
        output_ports:
        - visible_people
        - visible

    A person is in view if the center is within `range_max` and in the field of
    view, and at least one of three lines meets no wall: to the center, and to
    the points half a radius to its left and right. Optionally, the discs of
    other people occlude a person as walls do.

    Port ``robot_state`` takes the row (x, y, yaw, vx, vy, omega, radius) of the
    robot; a detector on the ground does not need it. Port ``human_states``
    takes n such rows of the people, and ``other_robot_states`` m rows of
    further robots, which count as people n + 1, ... Port ``visible`` gives 1
    for each person in view, else 0. Port ``visible_people`` gives the rows in
    the order of the inputs; the row of a person out of view has the coordinates
    `layout.OUTSIDE` (10^6 m, beyond any world), zero velocity, yaw 0 and radius
    0. All in W, in SI units.

    It has no state: the outputs are functions of the inputs.
    """

    def __init__(
        self,
        config: VisibleParameters | None = None,
        *,
        obstacles: Obstacles | None = None,
        num_humans: int,
        num_other_robots: int = 0,
        num_more_rows: int = 0,
    ) -> None:
        """Constructs a VisiblePeople.

        `obstacles` occlude people, such as walls; none by default. The outputs
        have `num_more_rows` at the end, for classes derived from this one.

        Raises:
            ValueError: If ``num_humans`` or ``num_other_robots`` is negative.
        """
        super().__init__()
        self._config = config or VisibleParameters()
        if obstacles is None:
            obstacles = Obstacles.from_shapes([], solid=[])
        self._walls = obstacles.table
        num_humans = check_count("num_humans", num_humans)
        num_others = check_count("num_other_robots", num_other_robots)
        self._num_bodies = num_humans + num_others
        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._human_states = self.DeclareVectorInputPort(
            "human_states", num_humans * STATE_SIZE
        )
        self._others = None
        if num_others:
            self._others = self.DeclareVectorInputPort(
                "other_robot_states", num_others * STATE_SIZE
            )
        rows = self._num_bodies + num_more_rows
        self._visible = self.DeclareVectorOutputPort(
            "visible", rows, self._CalcVisible
        )
        self._visible_people = self.DeclareVectorOutputPort(
            "visible_people", rows * STATE_SIZE, self._CalcVisiblePeople
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_visible_people_output_port(self) -> OutputPort:
        """Returns the port with the states of the people in view."""
        return self._visible_people

    def get_visible_output_port(self) -> OutputPort:
        """Returns the port with 1 for each person in view, else 0."""
        return self._visible

    def _Pose(self, context: Context) -> tuple[float, float, float]:
        """Returns the pose of the detector in W."""
        robot = None
        if self._config.mount == "robot":
            robot = self._robot_state.Eval(context)
        return sensor_pose(self._config, robot)

    def _Look(self, context: Context, bodies: Array) -> Mask:
        """Returns which bodies, shape (7k,), are in view, shape (k,)."""
        config = self._config
        view: Mask = people_in_view(
            *self._Pose(context),
            config.range_max,
            # A full turn has no edges.
            min(config.field_of_view + 1e-9, 2 * math.pi + 1e-6),
            config.hidden_by_people,
            bodies,
            self._walls,
        )
        return view

    def _Bodies(self, context: Context) -> Array:
        """Returns the rows of people, then of other robots, in one vector."""
        if self._others is None:
            people: Array = self._human_states.Eval(context)
            return people
        others: Array = self._others.Eval(context)
        if self._num_bodies * STATE_SIZE == len(others):
            return others
        return np.append(self._human_states.Eval(context), others)

    def _CalcVisible(self, context: Context, output: BasicVector) -> None:
        if self._num_bodies:
            seen = self._Look(context, self._Bodies(context))
            output.SetFromVector(seen.astype(float))

    def _CalcVisiblePeople(self, context: Context, output: BasicVector) -> None:
        if not self._num_bodies:
            return
        seen = self._visible.Eval(context) > 0
        rows = self._Bodies(context).reshape(-1, STATE_SIZE)
        output.SetFromVector(only_seen(rows, seen).ravel())


def only_seen(rows: Array, seen: Mask) -> Array:
    """Returns rows of people; those not `seen`, shape (n,), are outside."""
    unseen = np.zeros_like(rows)
    unseen[:, [X, Y]] = OUTSIDE
    return np.where(seen[:, None], rows, unseen)
