"""The LeafSystem that moves the people."""

from collections.abc import Sequence
import dataclasses
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem_,
    OutputPort,
)
from pydrake.systems.scalar_conversion import TemplateSystem

from hunav_drake.systems.checks import check_count, check_time_step
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.human_config import HumanConfig
from hunav_drake.systems.crowd.limits import limited
from hunav_drake.systems.crowd.models import make_motion_model
from hunav_drake.systems.crowd.motion_model import (
    MotionModel,
    Snapshot,
    checked,
)
from hunav_drake.systems.crowd.parameters import SocialForceParameters
from hunav_drake.systems.crowd.room import Room
from hunav_drake.systems.crowd.social_force_model import SocialForceModel
from hunav_drake.systems.crowd.weights import check_drawn
from hunav_drake.systems.layout import (
    COMMAND_SIZE,
    FORCES_SIZE,
    MOTION_SIZE,
    RADIUS,
    STATE_SIZE,
)
from hunav_drake.systems.obstacles import Obstacles


class CrowdJacobian(NamedTuple):
    """The derivatives of the next discrete state of a `HumanCrowd`.

    A row is for an element of that state, (x, y, yaw, vx, vy, omega) of each
    person. Where the step has a jump or a kink, the derivatives are those of
    the side that it takes.

    Attributes:
        states: Shape (6n, 6n): by the present state, in the same order.
        robots: Shape (6n, 7m): by port ``robot_state``.
    """

    states: NDArray[np.float64]
    robots: NDArray[np.float64]


@TemplateSystem.define("HumanCrowd_", T_list=[float, AutoDiffXd])
def HumanCrowd_(T: Any) -> type:
    """Defines HumanCrowd for a scalar type: float or AutoDiffXd."""

    class Impl(LeafSystem_[T]):
        """People who walk to their goals by a model of human motion.

        .. pydrake_system::

            name: HumanCrowd
            input_ports:
            - robot_state
            - command_0
            - ...
            - command_{n-1}
            - commands
            output_ports:
            - human_states
            - forces

        Every ``time_step``, the forces on all people are computed from one
        snapshot, and everybody moves at once: the order of people does not
        matter, to rounding.

        Port ``robot_state`` takes m rows (x, y, yaw, vx, vy, omega, radius) of
        the robots, and ``human_states`` gives n such rows of the people, in W,
        in SI units: see `hunav_drake.systems.layout`. Without robots there is
        no port ``robot_state``. Port ``command_i`` takes what person i wants,
        laid out as `layout.Command`; with ``one_command_port`` there is port
        ``commands`` instead, which takes those of all, one after the other.
        Port ``forces`` gives n rows of 8 vectors (x, y), in m/s^2: see
        `layout.FORCES`; it is computed when someone asks.

        The discrete state holds n rows (x, y, yaw, vx, vy, omega). Numbers of
        a size beyond 1e12, in the state or at the ports, count as that.

        ``HumanCrowd`` is ``HumanCrowd_[float]``. With the social force model,
        it converts to ``HumanCrowd_[AutoDiffXd]``, whose steps carry
        derivatives; `CalcJacobian` gives those of a step in one call.
        """

        def _construct(
            self,
            humans: Sequence[HumanConfig],
            *,
            obstacles: Obstacles | None = None,
            config: CrowdConfig | None = None,
            num_robots: int = 1,
            one_command_port: bool = False,
            time_step: float = 0.05,
            converter: Any = None,
        ) -> None:
            """Constructs a HumanCrowd.

            Args:
                humans: The people, in the order of the ports. They start at
                    rest.
                obstacles: The walls; none by default.
                config: How people move, and how they take in the world.
                num_robots: How many robots port ``robot_state`` has.
                one_command_port: Whether the commands come in one port, which
                    is faster for many people.
                time_step: The time between two updates, in seconds.
                converter: Set by Drake, which converts the scalar type.

            Raises:
                ValueError: If ``time_step`` is not positive, ``num_robots`` is
                    negative, weights of ``humans`` are still to be drawn, or
                    ``config`` names a model that there is not, or one without
                    the derivatives that AutoDiffXd asks for.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            check_time_step(time_step)
            check_count("num_robots", num_robots)
            check_drawn(humans)
            n = len(humans)
            self._humans = tuple(humans)
            self._obstacles = obstacles or Obstacles.from_shapes([], solid=[])
            self._config = config or CrowdConfig()
            self._num_robots = num_robots
            self._one_command_port = one_command_port
            self._time_step = time_step
            model = make_motion_model(
                self._config.model, self._config.parameters
            )
            self._model = (
                model
                if T is float
                else _differentiable(model, self._config.model)
            )
            self._radii = np.array([human.radius for human in humans])
            self._parameters = np.array(
                [dataclasses.astuple(human.forces) for human in humans]
            ).reshape(n, len(dataclasses.fields(SocialForceParameters)))
            # Models that are not ours get these, too.
            self._radii.setflags(write=False)
            self._parameters.setflags(write=False)
            self._no_robots = np.zeros((0, STATE_SIZE))
            self._room = Room(
                self._obstacles,
                self._radii,
                self._config,
                margin=getattr(model, "safety_margin", 0.0),
            )

            self._robot_state = (
                self.DeclareVectorInputPort(
                    "robot_state", num_robots * STATE_SIZE
                )
                if num_robots
                else None
            )
            self._commands = (
                [self.DeclareVectorInputPort("commands", n * COMMAND_SIZE)]
                if one_command_port
                else [
                    self.DeclareVectorInputPort(f"command_{i}", COMMAND_SIZE)
                    for i in range(n)
                ]
            )
            start = np.zeros((n, MOTION_SIZE))
            start[:, :3] = np.array([human.pose for human in humans]).reshape(
                n, 3
            )
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

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            """Constructs the same crowd for another scalar type.

            Raises:
                ValueError: If the model of motion has no derivatives.
            """
            Impl._construct(
                self,
                other._humans,
                obstacles=other._obstacles,
                config=other._config,
                num_robots=other._num_robots,
                one_command_port=other._one_command_port,
                time_step=other._time_step,
                converter=converter,
            )

        def get_robot_state_input_port(self) -> InputPort:
            """Returns the port with the states of the robots.

            Raises:
                ValueError: If the crowd was made with no robots.
            """
            if self._robot_state is None:
                raise ValueError(
                    f"{self.GetSystemPathname()} has no port robot_state: it"
                    " was made with num_robots=0"
                )
            return self._robot_state

        def get_command_input_port(self, index: int) -> InputPort:
            """Returns the port with what person `index` wants.

            Raises:
                ValueError: If the crowd was made with one port for all.
            """
            if self._one_command_port:
                raise ValueError(
                    f"{self.GetSystemPathname()} has no port command_{index}:"
                    " it was made with one_command_port=True"
                )
            return self._commands[index]

        def get_commands_input_port(self) -> InputPort:
            """Returns the port with what all people want.

            Raises:
                ValueError: If the crowd was made with a port for each.
            """
            if not self._one_command_port:
                raise ValueError(
                    f"{self.GetSystemPathname()} has no port commands: it was"
                    " made with one_command_port=False"
                )
            return self._commands[0]

        def get_human_states_output_port(self) -> OutputPort:
            """Returns the port with the states of the people."""
            return self._human_states

        def get_forces_output_port(self) -> OutputPort:
            """Returns the port with the forces on the people."""
            return self._forces

        def SetStates(self, context: Context, states: ArrayLike) -> None:
            """Sets where people are, and how they move.

            Args:
                context: Of this system, changed.
                states: Shape (n, 6 or 7): rows of ``human_states``; radii are
                    not read.

            Raises:
                ValueError: If the array does not have that shape.
            """
            rows = np.asarray(states)
            n = len(self._humans)
            if rows.shape not in ((n, STATE_SIZE), (n, MOTION_SIZE)):
                raise ValueError(
                    f"states must have shape ({n}, {STATE_SIZE}) or"
                    f" ({n}, {MOTION_SIZE}), got {rows.shape}"
                )
            context.SetDiscreteState(self._state, rows[:, :MOTION_SIZE].ravel())

        def CalcJacobian(self, context: Context) -> CrowdJacobian:
            """Computes the derivatives of the next discrete state.

            Those by what people and robots do now, from the formulas, with
            the commands as they are: in one call of compiled code, what
            `HumanCrowd_[AutoDiffXd]` would tell. In narrow passages, how hard
            walls push counts as constant: see `passage.ease`.

            Args:
                context: Its inputs must be connected or fixed.

            Returns:
                Two matrices: see `CrowdJacobian`.

            Raises:
                ValueError: If the model of motion has no derivatives.
            """
            if T is not float:
                raise TypeError("CalcJacobian is for HumanCrowd_[float]")
            # Few ask for it, and it takes a moment to load.
            from hunav_drake.systems.crowd import jacobian

            _differentiable(self._model, self._config.model)
            snapshot = self._Look(context)
            forces = self._forces.Eval(context).reshape(-1, FORCES_SIZE)
            derivatives = jacobian.step_jacobian(
                snapshot.states,
                snapshot.radii,
                snapshot.command,
                snapshot.parameters,
                snapshot.robots,
                snapshot.obstacles.segments,
                snapshot.obstacles.first,
                snapshot.obstacle_range,
                snapshot.max_obstacles,
                forces,
                snapshot.time_step,
            )
            size = snapshot.states.size
            moved = self._Advance(snapshot, forces)
            self._room.chain(derivatives, snapshot.states, moved)
            return CrowdJacobian(derivatives[:, :size], derivatives[:, size:])

        def _GetState(self, context: Context) -> NDArray[Any]:
            """Returns the rows of the discrete state, not to be written to."""
            vector = context.get_discrete_state(self._state)
            # Only floats can be looked at in place, which is faster.
            state: NDArray[Any] = (
                vector.value() if T is float else vector.CopyToVector()
            )
            state = state.reshape(-1, MOTION_SIZE)
            state.setflags(write=False)
            return state

        def _GetRobots(self, context: Context) -> NDArray[Any]:
            """Returns the rows of port robot_state, not to be written to."""
            if self._robot_state is None:
                return self._no_robots
            robots: NDArray[Any] = self._robot_state.Eval(context)
            robots = robots.reshape(-1, STATE_SIZE)
            robots.setflags(write=False)
            return limited(robots)

        def _Look(self, context: Context) -> Snapshot:
            """Returns the snapshot of a Context."""
            states = limited(self._GetState(context))
            command = np.array([port.Eval(context) for port in self._commands])
            command = self._room.guide(
                states, limited(command.reshape(-1, COMMAND_SIZE))
            )
            radii, parameters = self._room.ease(
                states, command, self._parameters
            )
            return Snapshot(
                states=states,
                radii=radii,
                command=command,
                parameters=parameters,
                robots=self._GetRobots(context),
                obstacles=self._obstacles,
                obstacle_range=self._config.obstacle_range,
                max_obstacles=self._config.max_obstacles,
                time_step=self._time_step,
            )

        def _Forces(self, snapshot: Snapshot) -> NDArray[Any]:
            """Returns what the model gives, of shape (n, FORCES_SIZE)."""
            return checked(
                self._model.forces(snapshot),
                (len(self._humans), FORCES_SIZE),
                *(self._config.model, "forces"),
            )

        def _Advance(
            self, snapshot: Snapshot, forces: NDArray[Any]
        ) -> NDArray[Any]:
            """Returns what the model gives, of shape (n, MOTION_SIZE)."""
            return checked(
                self._model.advance(snapshot, forces),
                (len(self._humans), MOTION_SIZE),
                *(self._config.model, "advance"),
            )

        def _CalcHumanStates(
            self, context: Context, output: BasicVector
        ) -> None:
            state = self._GetState(context)
            rows = np.empty((len(state), STATE_SIZE), dtype=state.dtype)
            rows[:, :MOTION_SIZE] = state
            rows[:, RADIUS] = self._radii
            output.SetFromVector(rows.ravel())

        def _CalcForces(self, context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._Forces(self._Look(context)).ravel())

        def _Update(
            self, context: Context, discrete_state: DiscreteValues
        ) -> None:
            snapshot = self._Look(context)
            moved = self._Advance(snapshot, self._Forces(snapshot))
            moved = self._room.keep_out(snapshot.states, moved)
            discrete_state.set_value(self._state, moved.ravel())

    return Impl


HumanCrowd = HumanCrowd_[float]
# So are Drake's own systems called, in diagrams and by pickle.
HumanCrowd.__name__ = HumanCrowd.__qualname__ = "HumanCrowd"


def _differentiable(model: MotionModel, name: str) -> MotionModel:
    """Returns the form of a model that takes scalars with derivatives.

    Raises:
        ValueError: If it has none.
    """
    if not isinstance(model, SocialForceModel):
        raise ValueError(
            "derivatives of a crowd need the motion model 'social_force';"
            f" {name!r} has none"
        )
    return dataclasses.replace(model, kernel="numpy")
