"""The LeafSystem that moves the people."""

from collections.abc import Sequence
import copy
import math
import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.autodiffutils import AutoDiffXd
from pydrake.common import cpp_template
from pydrake.common.value import AbstractValue, Value
from pydrake.systems import scalar_conversion
from pydrake.systems.framework import (
    BasicVector,
    BasicVector_,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem_,
    NumericParameterIndex,
    OutputPort,
    ValueProducer,
)
from pydrake.systems.scalar_conversion import TemplateSystem

from hunav_drake.systems.common.checks import (
    check_count,
    check_number,
    check_time_step,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    FORCES_SIZE,
    MOTION_SIZE,
    RADIUS,
    STATE_SIZE,
    TOUCH_SIZE,
)
from hunav_drake.systems.common.ports import (
    DeclareRobotStates,
    RequirePort,
    weakly,
)
from hunav_drake.systems.crowd.bodies.standing import STANCE_SIZE
from hunav_drake.systems.crowd.crowd_config import CrowdConfig
from hunav_drake.systems.crowd.limits import lifted
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.seed_and_weights import SeedAndWeights
from hunav_drake.systems.crowd.step import CrowdJacobian, CrowdStep
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.names import people_names
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[Any]

# The vectors of a `Stepped`.
_Step = tuple[Array, Array, NDArray[np.float64]]


@TemplateSystem.define(
    "HumanCrowd_",
    T_list=[float, AutoDiffXd],
    # Else Drake reads the sources of the whole call stack to find it.
    scope=sys.modules[__name__],
)
def HumanCrowd_(T: Any) -> type:
    """Defines HumanCrowd for a scalar type: float or AutoDiffXd."""

    class Impl(LeafSystem_[T], SeedAndWeights):
        """People who walk to their goals by a model of human motion.

        .. pydrake_system::

            name: HumanCrowd
            input_ports:
            - robot_states
            - commands
            output_ports:
            - human_states
            - forces
            - overlaps
            - robot_touches

        Every ``time_step``, the forces on all people are computed from one
        snapshot, and everybody moves at once: the order of people does not
        matter, to rounding.

        Port ``robot_states`` takes m rows (x, y, yaw, vx, vy, omega, radius) of
        the robots, and ``human_states`` gives n such rows of the people, in W,
        in SI units: see `common.layout`. NaN for a robot is an error. Without
        robots there is no port ``robot_states``. Port ``commands`` takes n
        rows, the command of each person, laid out as `layout.Command`; where
        they come from several systems, a Multiplexer joins them.
        Port ``forces`` gives n rows of 8 vectors (x, y), in m/s^2: see
        `layout.FORCES`. Port ``overlaps`` gives for each person the present
        depth of other bodies and robots in its body, in meters: 0 unless
        people are squeezed, or not kept apart. Both are computed on request.
        Port ``robot_touches`` gives for each robot n rows (depth, speed) of
        the step that begins now: the depth of robot and person in each other
        at its end if they were not kept apart, in meters, else 0; and the
        speed at which the person approaches the robot in it, in m/s. Without
        robots there is no such port.

        The discrete state holds n rows (x, y, yaw, vx, vy, omega), and in a
        second vector n rows (x, y, 1) of the positions where people stand,
        zeros for people who walk. Numbers of a magnitude beyond 1e12, in the
        state or at the ports, count as that.

        Two numeric parameters hold what follows from a seed: the weights of
        the forces, n rows of the fields of SocialForceParameters, and the seed
        itself, in two halves of 32 bits. `SetSeed` draws the start and the
        weights of a Context anew; the system is the same for all seeds.

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
            time_step: float = 0.05,
            start_jitter: float = 0.0,
            seed: int = 0,
            converter: Any = None,
        ) -> None:
            """Constructs a HumanCrowd.

            Args:
                humans: The people, in the order of the ports. They start at
                    rest.
                obstacles: The walls; none by default.
                config: The configuration of the crowd.
                num_robots: The number of robots at port ``robot_states``.
                time_step: The time between two updates, in seconds.
                start_jitter: The largest distance of x and y of a start from
                    those of the configuration, in meters, which the seed
                    draws.
                seed: The seed of the default Context, in [0, 2^63), from which
                    starts and weights are drawn.
                converter: Set by Drake, which converts the scalar type.

            Raises:
                ValueError: If ``time_step`` is not positive, ``num_robots`` or
                    ``start_jitter`` is negative, ``seed`` is not such a
                    number, or the model of ``config`` has no derivatives,
                    which AutoDiffXd needs.
            """
            LeafSystem_[T].__init__(self, converter=converter)
            check_time_step(time_step)
            check_count("num_robots", num_robots)
            check_number("start_jitter", start_jitter, "m")
            config = config or CrowdConfig()
            # (Later changes of a person do not count.)
            self._humans = tuple(map(copy.copy, humans))
            self._profile = config.profile
            self._start_jitter = start_jitter
            # A copy for another scalar type has the same options.
            self._options: dict[str, Any] = {
                "obstacles": obstacles,
                "config": config,
                "num_robots": num_robots,
                "time_step": time_step,
                "start_jitter": start_jitter,
                "seed": seed,
            }
            self._step = CrowdStep(
                humans,
                obstacles=obstacles or Obstacles.from_shapes([], solid=[]),
                config=config,
                time_step=time_step,
                with_derivatives=T is not float,
            )
            self._no_robots = np.zeros(0)
            self._robot_states = DeclareRobotStates(self, num_robots)
            self._commands = self.DeclareVectorInputPort(
                "commands", len(humans) * COMMAND_SIZE
            )
            self._DeclareStateAndParameters(seed)
            self._DeclareOutputs()
            self.DeclarePeriodicDiscreteUpdateEvent(
                period_sec=time_step, offset_sec=0.0, update=self._Update
            )

        def _DeclareStateAndParameters(self, seed: int) -> None:
            start, *parameters = self._Draw(seed)
            # (Numbers are found faster by an integer than by a typed index.)
            self._state = int(self.DeclareDiscreteState(start))
            self._stances = int(
                self.DeclareDiscreteState(STANCE_SIZE * len(self._humans))
            )
            self._weights, self._seed = (
                self.DeclareNumericParameter(BasicVector_[T](vector))
                for vector in parameters
            )

        def _DeclareOutputs(self) -> None:
            n = len(self._humans)
            state = self.discrete_state_ticket(DiscreteStateIndex(self._state))
            inputs = self.all_input_ports_ticket()
            weights = self.numeric_parameter_ticket(
                NumericParameterIndex(self._weights)
            )
            # The one step that begins at an instant, for update and port.
            step = self.DeclareCacheEntry(
                "step",
                ValueProducer(
                    allocate=lambda: Value(object()),
                    calc=weakly(self._CalcStep),
                ),
                prerequisites_of_calc={
                    *(self.xd_ticket(), self.pn_ticket(), inputs)
                },
            )
            self._stepped = step.cache_index()

            def declare(
                name: str, size: int, calc: Any, *prerequisites: Any
            ) -> OutputPort:
                return self.DeclareVectorOutputPort(
                    name, size, calc, prerequisites_of_calc={*prerequisites}
                )

            self._human_states = declare(
                "human_states", n * STATE_SIZE, self._CalcHumanStates, state
            )
            self._forces = declare(
                *("forces", n * FORCES_SIZE, self._CalcForces),
                *(state, weights, inputs),
            )
            self._overlaps = declare(
                "overlaps", n, self._CalcOverlaps, state, inputs
            )
            self._touches = None
            if (port := self._robot_states) is not None:
                size = port.size() // STATE_SIZE * n * TOUCH_SIZE
                self._touches = declare(
                    "robot_touches", size, self._CalcTouches, step.ticket()
                )

        def _construct_copy(self, other: Any, converter: Any = None) -> None:
            """Constructs the same crowd for another scalar type.

            Raises:
                ValueError: If the model of motion has no derivatives.
            """
            Impl._construct(
                self, other._humans, **other._options, converter=converter
            )

        def get_robot_states_input_port(self) -> InputPort:
            """Returns the port with the states of the robots.

            Raises:
                ValueError: If the crowd was made with no robots.
            """
            return RequirePort(
                self, self._robot_states, "robot_states", "num_robots=0"
            )

        def DescribeMemory(self) -> list[str]:
            """Returns whose the states are, in order."""
            return [f"person {it}" for it in people_names(self._humans)]

        def get_commands_input_port(self) -> InputPort:
            """Returns the port with the commands of the people."""
            return self._commands

        def get_human_states_output_port(self) -> OutputPort:
            """Returns the port with the states of the people."""
            return self._human_states

        def get_forces_output_port(self) -> OutputPort:
            """Returns the port with the forces on the people."""
            return self._forces

        def get_overlaps_output_port(self) -> OutputPort:
            """Returns the port with the overlaps of bodies."""
            return self._overlaps

        def get_robot_touches_output_port(self) -> OutputPort:
            """Returns the port with the touches of people and robots.

            Raises:
                ValueError: If the crowd was made with no robots.
            """
            return RequirePort(
                self, self._touches, "robot_touches", "num_robots=0"
            )

        def CalcJacobian(self, context: Context) -> CrowdJacobian:
            """Computes the derivatives of the next discrete state.

            They are those by the present states of people and robots, from the
            formulas, with constant commands: the derivatives of
            `HumanCrowd_[AutoDiffXd]`, in one call of compiled code. With route
            planning, both are approximate near doors under 1 m: see
            `CrowdJacobian`.

            Args:
                context: Its inputs must be connected or fixed.

            Returns:
                Two matrices: see `CrowdJacobian`.

            Raises:
                TypeError: If this is a `HumanCrowd_[AutoDiffXd]`.
                ValueError: If the model of motion has no derivatives, or
                    somebody sits, lies, sits down or stands up.
            """
            self.ValidateContext(context)
            if T is not float:
                raise TypeError("CalcJacobian is for HumanCrowd_[float]")
            self._step.check_derivatives()
            forces = self._forces.Eval(context).reshape(-1, FORCES_SIZE)
            return self._step.jacobian(
                self._Look(context), forces, self._GetStances(context)
            )

        def _GetState(self, context: Context) -> NDArray[Any]:
            """Returns the rows of the discrete state, not to be written to."""
            return self._GetRows(context, self._state, MOTION_SIZE)

        def _GetStances(self, context: Context) -> NDArray[Any]:
            """Returns the stances of people: see `bodies.standing`."""
            return self._GetRows(context, self._stances, STANCE_SIZE)

        def _GetRows(
            self, context: Context, index: int, size: int
        ) -> NDArray[Any]:
            vector = context.get_discrete_state(index)
            # Only floats can be viewed in place, which is faster.
            rows: NDArray[Any] = (
                vector.value() if T is float else vector.CopyToVector()
            )
            rows = rows.reshape(-1, size)
            rows.setflags(write=False)
            return rows

        def _GetRobots(self, context: Context) -> NDArray[Any]:
            """Returns the rows of the robots, not to be written to."""
            if self._robot_states is None:
                return self._no_robots.reshape(0, STATE_SIZE)
            robots: NDArray[Any] = self._robot_states.Eval(context)
            if T is float:
                self._CheckRobots(context, robots)
            robots = robots.reshape(-1, STATE_SIZE)
            robots.setflags(write=False)
            return robots

        def _CheckRobots(self, context: Context, robots: Array) -> None:
            """Raises a RuntimeError if a number of the robots is NaN."""
            # (A sum is found faster; that of infinite numbers may be NaN.)
            if math.isnan(sum(robots.tolist())) and np.isnan(robots).any():
                raise RuntimeError(
                    f"{self.GetSystemPathname()}, t = {context.get_time():.3f}"
                    f" s: robot_states must be numbers, got {robots.tolist()}."
                    " Look at the system that gives them."
                )

        def _Present(
            self, context: Context
        ) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
            """Returns states, commands, robots and weights of a Context."""
            weights = self.GetWeights(context)
            weights.setflags(write=False)
            return (
                self._GetState(context),
                self._commands.Eval(context).reshape(-1, COMMAND_SIZE),
                self._GetRobots(context),
                weights,
            )

        def _Look(self, context: Context) -> Snapshot:
            """Returns the snapshot of a Context."""
            return self._step.look(*self._Present(context))

        def _CalcHumanStates(
            self, context: Context, output: BasicVector
        ) -> None:
            state = self._GetState(context)
            rows = np.empty((len(state), STATE_SIZE), dtype=state.dtype)
            rows[:, :MOTION_SIZE] = state
            rows[:, RADIUS] = self._step.radii
            output.SetFromVector(rows.ravel())

        def _CalcForces(self, context: Context, output: BasicVector) -> None:
            forces = self._step.forces(self._Look(context))
            output.SetFromVector(forces.ravel())

        def _CalcOverlaps(self, context: Context, output: BasicVector) -> None:
            overlaps = self._step.overlaps(
                self._GetState(context), self._GetRobots(context)
            )
            output.SetFromVector(overlaps if T is float else lifted(overlaps))

        def _CalcStep(self, context: Context, value: AbstractValue) -> None:
            value.set_value(self._TakeStep(context))

        def _TakeStep(self, context: Context) -> _Step:
            if T is float:
                taken = self._step.take_compiled(*self._Vectors(context))
                if taken is not None:
                    size = MOTION_SIZE * len(self._humans)
                    end = size + STANCE_SIZE * len(self._humans)
                    return taken[:size], taken[size:end], taken[end:]
            states, stances, touches = self._step.take(
                *self._Present(context), self._GetStances(context)
            )
            return states.ravel(), stances.ravel(), touches.ravel()

        def _Vectors(self, context: Context) -> tuple[Array, ...]:
            """Returns the arguments of `take_compiled`, views."""
            state = context.get_discrete_state(self._state).value()
            commands = self._commands.EvalBasicVector(context).value()
            robots = self._no_robots
            if self._robot_states is not None:
                robots = self._robot_states.EvalBasicVector(context).value()
                self._CheckRobots(context, robots)
            return (
                *(state, commands, robots),
                context.get_numeric_parameter(self._weights).value(),
                context.get_discrete_state(self._stances).value(),
            )

        def _EvalStep(self, context: Context) -> _Step:
            """Returns the step that begins now, not to be written to."""
            if self._touches is None:
                # Nobody else asks for it.
                return self._TakeStep(context)
            step: _Step = self.get_cache_entry(self._stepped).Eval(context)
            return step

        def _CalcTouches(self, context: Context, output: BasicVector) -> None:
            _, _, touches = self._EvalStep(context)
            output.SetFromVector(touches if T is float else lifted(touches))

        def _Update(
            self, context: Context, discrete_state: DiscreteValues
        ) -> None:
            states, stances, _ = self._EvalStep(context)
            discrete_state.set_value(self._state, states)
            discrete_state.set_value(self._stances, stances)

    return Impl


# For each method of a template, Drake looks for its module in the sources of
# the whole call stack, which takes a tenth of a second in the midst of imports.
# It is always that of the decorator.
_FIND = "_get_module_from_stack"
_find = getattr(cpp_template, _FIND, None)
setattr(cpp_template, _FIND, lambda *_: scalar_conversion)
try:
    HumanCrowd = HumanCrowd_[float]
finally:
    setattr(cpp_template, _FIND, _find)
# Drake's own systems are named like this, in diagrams and by pickle.
HumanCrowd.__name__ = HumanCrowd.__qualname__ = "HumanCrowd"
