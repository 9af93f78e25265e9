"""The LeafSystem that moves the people."""

from collections.abc import Sequence
import dataclasses

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.crowd.motion_model import (
    Snapshot,
    make_motion_model,
)
from hunav_drake.systems.crowd.parameters import SocialForceParameters
from hunav_drake.systems.layout import COMMAND_SIZE, FORCES_SIZE, STATE_SIZE
from hunav_drake.systems.obstacles import Obstacles


class HumanCrowd(LeafSystem):
    """People who walk to their goals by a model of human motion.

    .. pydrake_system::

        name: HumanCrowd
        input_ports:
        - robot_state
        - command_0
        - ...
        - command_{n-1}
        output_ports:
        - human_states
        - forces

    Every ``time_step``, the forces on all people are computed from one
    snapshot, and everybody moves at once: the order of people does not
    matter, to rounding.

    Port ``robot_state`` takes m rows (x, y, yaw, vx, vy, omega, radius) of the
    robots, and ``human_states`` gives n such rows of the people, in W, in SI
    units: see `hunav_drake.systems.layout`. Without robots there is no port
    ``robot_state``. Port ``command_i`` takes what person i wants, laid out as
    `layout.Command`. Port ``forces`` gives n rows of 8 vectors (x, y), in
    m/s^2: see `layout.FORCES`; it is computed when someone asks.

    The discrete state holds n rows (x, y, yaw, vx, vy, omega).
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        *,
        obstacles: Obstacles | None = None,
        config: CrowdConfig | None = None,
        num_robots: int = 1,
        time_step: float = 0.05,
    ) -> None:
        """Constructs a HumanCrowd.

        Args:
            humans: The people, in the order of the ports. They start at rest.
            obstacles: The walls; none by default.
            config: How people move, and how they take in the world.
            num_robots: How many robots port ``robot_state`` has.
            time_step: The time between two updates, in seconds.

        Raises:
            ValueError: If ``time_step`` is not positive, ``num_robots`` is
                negative, or ``config`` names a model that there is not.
        """
        super().__init__()
        if not time_step > 0:
            raise ValueError(f"time_step must be positive, got {time_step} s")
        if num_robots < 0:
            raise ValueError(f"num_robots must be >= 0, got {num_robots}")
        n = len(humans)
        self._obstacles = obstacles or Obstacles.from_shapes([], solid=[])
        self._config = config or CrowdConfig()
        self._model = make_motion_model(
            self._config.model, self._config.parameters
        )
        self._time_step = time_step
        self._radii = np.array([human.radius for human in humans])
        self._parameters = np.array(
            [dataclasses.astuple(human.forces) for human in humans]
        ).reshape(n, len(dataclasses.fields(SocialForceParameters)))
        self._no_robots = np.zeros((0, STATE_SIZE))

        self._robot_state = (
            self.DeclareVectorInputPort("robot_state", num_robots * STATE_SIZE)
            if num_robots
            else None
        )
        self._commands = [
            self.DeclareVectorInputPort(f"command_{i}", COMMAND_SIZE)
            for i in range(n)
        ]
        start = np.zeros((n, 6))
        start[:, :3] = np.array([human.pose for human in humans]).reshape(n, 3)
        self._state = self.DeclareDiscreteState(start.ravel())
        state_ticket = self.discrete_state_ticket(self._state)
        self._human_states = self.DeclareVectorOutputPort(
            "human_states",
            n * STATE_SIZE,
            self._CalcHumanStates,
            prerequisites_of_calc={state_ticket},
        )
        self._forces = self.DeclareVectorOutputPort(
            "forces",
            n * FORCES_SIZE,
            self._CalcForces,
            prerequisites_of_calc={
                state_ticket,
                self.all_input_ports_ticket(),
            },
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the states of the robots.

        Raises:
            ValueError: If the crowd was made with no robots.
        """
        if self._robot_state is None:
            raise ValueError(
                f"{self.GetSystemPathname()} has no port robot_state: it was"
                " made with num_robots=0"
            )
        return self._robot_state

    def get_command_input_port(self, index: int) -> InputPort:
        """Returns the port with what person `index` wants."""
        return self._commands[index]

    def get_human_states_output_port(self) -> OutputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_forces_output_port(self) -> OutputPort:
        """Returns the port with the forces on the people."""
        return self._forces

    def _Look(self, context: Context) -> Snapshot:
        """Returns the snapshot of a Context."""
        state = context.get_discrete_state(self._state).value()
        command = np.array([port.Eval(context) for port in self._commands])
        return Snapshot(
            states=state.reshape(-1, 6),
            radii=self._radii,
            command=command.reshape(-1, COMMAND_SIZE),
            parameters=self._parameters,
            robots=(
                self._no_robots
                if self._robot_state is None
                else self._robot_state.Eval(context).reshape(-1, STATE_SIZE)
            ),
            obstacles=self._obstacles,
            obstacle_range=self._config.obstacle_range,
            max_obstacles=self._config.max_obstacles,
            time_step=self._time_step,
        )

    def _CalcHumanStates(self, context: Context, output: BasicVector) -> None:
        rows = np.empty((len(self._radii), STATE_SIZE))
        state = context.get_discrete_state(self._state).value()
        rows[:, :6] = state.reshape(-1, 6)
        rows[:, 6] = self._radii
        output.SetFromVector(rows.ravel())

    def _CalcForces(self, context: Context, output: BasicVector) -> None:
        forces = self._model.forces(self._Look(context))
        output.SetFromVector(forces.ravel())

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        snapshot = self._Look(context)
        forces = self._model.forces(snapshot)
        moved = self._model.advance(snapshot, forces)
        discrete_state.set_value(self._state, moved.ravel())
