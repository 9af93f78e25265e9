"""The LeafSystem that replays recorded people."""

from collections.abc import Sequence
import hashlib

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_count, check_time_step
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OUTSIDE,
    REPLAY_SIZE,
    STATE_SIZE,
    X,
    Y,
)
from hunav_drake.systems.common.ports import (
    DeclareRobotStates,
    RobotStatesOf,
    weakly,
)
from hunav_drake.systems.crowd.replay import (
    COUNT,
    END,
    LASTS,
    MEMORY_SIZE,
    PHASE,
    REACTS,
    SINCE,
    START,
    TRACK_SIZE,
    replay_rows,
    replay_step,
)
from hunav_drake.systems.crowd.replay_tables import make_tables
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.tracks import Track


class RecordedPeople(LeafSystem):
    """Replays recorded people, and hands them over to the crowd near a robot.

    .. pydrake_system::

        name: RecordedPeople
        input_ports:
        - human_states
        - robot_states
        - commands
        output_ports:
        - commands
        - tracks
        - replay

    It stands between the behaviors and an `OpenCrowd`. Ports ``human_states``,
    ``robot_states`` and ``commands`` take rows as those of the crowd; without
    robots there is no port ``robot_states``. Output ``commands`` gives the same
    n commands, changed for recorded people who walk by the motion model.
    Output ``tracks`` gives n rows (mask, x, y, yaw, vx, vy, omega) in W, in SI
    units: where the mask is 1, the state of the person at the end of the step,
    which is the row of `layout.OUTSIDE` before the beginning and after the end
    of the recording; else zeros. Output ``replay`` gives the n rows of
    `layout.REPLAY_SIZE`.

    A person follows the cubic spline through its recording (see `motion_at`),
    whatever the robot does if its mode is "blind". Else it is handed over to
    the motion model: with "reactive" as soon as it is there, with "hand_over"
    while the center of a robot is nearer than ``on``, until it is farther away
    than ``off``. Then its command is to go to the place of its own recording
    1.5 s ahead of the nearest one, at the speed recorded at the nearest one, in
    0.05 to 1.8 m/s. The rest of the command is the behavior's. Who is back
    stays late; the offset from its path decays in 0.8 s, or as long as needed
    for an acceleration of 1.5 m/s^2 from the place, and from the velocity.
    The nearest place never goes back, and goes on where the recorded person
    stands. Who reaches the end of its recording is outside.

    The discrete state holds the time of the recording at the present step, in
    seconds, and in a second vector n rows of `replay.MEMORY_SIZE` numbers. All
    outputs follow from the state and the inputs without delay.
    """

    def __init__(
        self,
        tracks: Sequence[Track | None],
        humans: Sequence[HumanConfig],
        *,
        num_robots: int = 1,
        time_step: float = 0.05,
    ) -> None:
        """Constructs RecordedPeople.

        Args:
            tracks: The recording of each person; None for those without.
            humans: All people, in the order of the ports; `HumanConfig.track`
                says how each recording is replayed.
            num_robots: The number of robots in ``robot_states``.
            time_step: The time between two steps, in seconds.

        Raises:
            ValueError: If there are not as many recordings as people,
                ``num_robots`` is negative, ``time_step`` is not positive, or a
                recording is not finite, or not in ascending order of times.
        """
        super().__init__()
        n = len(humans)
        if len(tracks) != n:
            raise ValueError(
                f"there must be a recording, or None, for each of {n} people,"
                f" got {len(tracks)}"
            )
        check_count("num_robots", num_robots)
        check_time_step(time_step)
        for i, track in enumerate(tracks):
            _check(i, track, humans[i])
        self._humans = tuple(humans)
        self._time_step = time_step
        self._tables = make_tables(
            tracks, [human.track for human in humans], time_step
        )
        self._no_robots = np.zeros(0)
        self._human_states = self.DeclareVectorInputPort(
            "human_states", n * STATE_SIZE
        )
        self._robot_states = DeclareRobotStates(self, num_robots)
        self._commands = self.DeclareVectorInputPort(
            "commands", n * COMMAND_SIZE
        )
        self._time = self.DeclareDiscreteState(1)
        self._memory = self.DeclareDiscreteState(n * MEMORY_SIZE)
        sizes = [n * MEMORY_SIZE, n * COMMAND_SIZE, n * TRACK_SIZE]
        ends = np.cumsum([0, *sizes]).tolist()
        self._parts = [slice(*ends[i : i + 2]) for i in range(3)]
        # The one step, which the ports and the update read.
        step = self.DeclareCacheEntry(
            "step",
            ValueProducer(
                allocate=lambda: Value(object()), calc=weakly(self._CalcStep)
            ),
            prerequisites_of_calc={
                self.xd_ticket(),
                self.all_input_ports_ticket(),
            },
        )
        self._step = step.cache_index()
        for name, size, calc in (
            ("commands", sizes[1], self._CalcCommands),
            ("tracks", sizes[2], self._CalcTracks),
        ):
            self.DeclareVectorOutputPort(
                name, size, calc, prerequisites_of_calc={step.ticket()}
            )
        self.DeclareVectorOutputPort(
            "replay",
            n * REPLAY_SIZE,
            self._CalcReplay,
            prerequisites_of_calc={
                self.xd_ticket(),
                self.input_port_ticket(self._human_states.get_index()),
            },
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def StartRows(self) -> Array:
        """Returns the rows of port ``tracks`` at time 0, of shape (n, 7)."""
        n = len(self._humans)
        nobody = np.zeros((n, STATE_SIZE))
        nobody[:, X] = nobody[:, Y] = OUTSIDE
        step: Array = replay_step(
            *(-self._time_step, self._time_step, np.zeros(n * MEMORY_SIZE)),
            *(nobody.ravel(), self._no_robots, np.zeros(n * COMMAND_SIZE)),
            *self._tables,
        )
        return step[self._parts[2]].reshape(n, TRACK_SIZE)

    def DescribeMemory(self) -> list[str]:
        """Returns what the meaning of the state depends on."""
        content = hashlib.sha256()
        for table in self._tables:
            content.update(table.tobytes())
        return [f"recordings {content.hexdigest()[:16]}"]

    def CheckContext(self, context: Context) -> None:
        """Checks that the state of a Context is valid.

        Raises:
            ValueError: If it is not.
        """
        self.ValidateContext(context)
        rows = context.get_discrete_state(self._memory).value()
        rows = rows.reshape(-1, MEMORY_SIZE)
        starts, ends = self._tables.roster[:, [START, END]].T
        reacts = rows[:, REACTS]
        phases = rows[:, PHASE]
        valid = np.isin(reacts, (0.0, 1.0)) & (
            rows[:, [SINCE, LASTS]] >= 0
        ).all(axis=1)
        valid &= (reacts == 0) | ((starts <= phases) & (phases <= ends))
        valid &= (self._tables.roster[:, COUNT] > 0) | (rows == 0).all(axis=1)
        if not valid.all():
            i = int(np.argmin(valid))
            raise ValueError(
                f"the memory of humans[{i}] is not one of a recorded person:"
                f" {rows[i].tolist()}"
            )

    def _CalcStep(self, context: Context, value: AbstractValue) -> None:
        robots = self._no_robots
        if self._robot_states is not None:
            robots = RobotStatesOf(self._robot_states, context)
        (now,) = context.get_discrete_state(self._time).value()
        value.set_value(
            replay_step(
                *(now, self._time_step),
                context.get_discrete_state(self._memory).value(),
                self._human_states.EvalBasicVector(context).value(),
                robots,
                self._commands.EvalBasicVector(context).value(),
                *self._tables,
            )
        )

    def _EvalStep(self, context: Context, part: int) -> Array:
        result: Array = self.get_cache_entry(self._step).Eval(context)
        return result[self._parts[part]]

    def _CalcCommands(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._EvalStep(context, 1))

    def _CalcTracks(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._EvalStep(context, 2))

    def _CalcReplay(self, context: Context, output: BasicVector) -> None:
        (now,) = context.get_discrete_state(self._time).value()
        output.SetFromVector(
            replay_rows(
                *(now, self._time_step),
                context.get_discrete_state(self._memory).value(),
                self._human_states.EvalBasicVector(context).value(),
                *self._tables,
            )
        )

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        (now,) = context.get_discrete_state(self._time).value()
        steps = round(now / self._time_step) + 1
        discrete_state.set_value(self._memory, self._EvalStep(context, 0))
        discrete_state.set_value(
            self._time, np.array([steps * self._time_step])
        )


def _check(i: int, track: Track | None, human: HumanConfig) -> None:
    """Raises a ValueError unless a recording can be replayed."""
    if (track is None) != (human.track is None):
        raise ValueError(
            f"humans[{i}]: a recording and `track` go together, got"
            f" {'only one' if track is None else 'a recording alone'}"
        )
    if track is None:
        return
    fine = len(track.times) and np.isfinite(track.times).all()
    fine = fine and np.isfinite(track.positions).all()
    if not fine or (np.diff(track.times) <= 0).any():
        raise ValueError(
            f"humans[{i}]: a recording must have finite rows, at ascending"
            " times"
        )
