"""A HumanCrowd whose people come and go."""

from collections.abc import Sequence
from numbers import Integral
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    OutputPort,
    SystemScalarConverter,
)

from hunav_drake.systems.common.arrays import Mask
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    FORCES_SIZE,
    MOTION_SIZE,
    OUTSIDE,
    RADIUS,
    STATE_SIZE,
    TOUCH_SIZE,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.common.ports import RequirePort
from hunav_drake.systems.crowd.bodies.standing import STANCE_SIZE
from hunav_drake.systems.crowd.doors import (
    CAME,
    ENTERED,
    FOR_GOOD,
    LEFT,
    PEOPLE,
    SINK_SIZE,
    SOURCE_SIZE,
    Doors,
    Passage,
)
from hunav_drake.systems.crowd.human_crowd import HumanCrowd
from hunav_drake.systems.crowd.motion_model import Snapshot
from hunav_drake.systems.crowd.replay import MASK, TRACK_SIZE
from hunav_drake.systems.crowd.step import CrowdStep
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.traffic import Traffic

Array = NDArray[Any]


# Farther away from others than this, in meters, people whose states are given
# have no effect: the default forces are below 0.01 m/s^2 there.
_FELT = 15.0


class TrafficCounts(NamedTuple):
    """The numbers of people who have come and gone.

    Attributes:
        arrivals: The number of people who have come in, by source.
        waiting: The number of parties, people or groups, that wait outside for
            a free place or for somebody to leave, by source.
        departures: The number of people who have left, by sink.
    """

    arrivals: dict[str, int]
    waiting: dict[str, int]
    departures: dict[str, int]


class _Present(NamedTuple):
    """The people who are here, and their step."""

    rows: NDArray[np.intp]
    step: CrowdStep
    snapshot: Snapshot


class OpenCrowd(HumanCrowd):
    """A `HumanCrowd` that people join at sources and leave at sinks.

    .. pydrake_system::

        name: OpenCrowd
        input_ports:
        - robot_states
        - commands
        - tracks (optional)
        output_ports:
        - human_states
        - forces
        - overlaps
        - robot_touches
        - traffic

    The people are always the same n, some of whom are outside. Those are not
    seen, exert no forces, and do nothing. The ports are those of a
    `HumanCrowd`; in ``human_states``, people outside have rows of
    `layout.OUTSIDE`, and zeros elsewhere. Port ``traffic`` gives two numbers
    for each source, the people who have come in and the parties that wait
    outside, and then, for each sink, the people who have left: see `GetCounts`.

    People come to a source as a Poisson process, alone or in groups, and come
    in once there is a place where they touch nobody; they come in at rest, and
    keep their order. A source has a fixed number of people, who come in turn.
    If all are here, those who come wait until one has left. People who have
    reached the sink that is their last goal are outside at once (or, at a sink
    that has a rate, when it is their turn), for a second at least.

    Port ``tracks`` takes n rows (mask, x, y, yaw, vx, vy, omega): where the
    mask is 1, the row is the state of the person at the end of the step,
    whatever acts on it; a position of (OUTSIDE, OUTSIDE) takes it outside.
    Others within 15 m feel such a person as any other, and make way for its
    body. There is such a port only if the rows at the start are given: see
    `RecordedPeople`.

    Besides that of a `HumanCrowd`, the discrete state holds: for each source,
    the columns of `doors.CAME` and following; n numbers, the least time that
    each person still stays outside, in seconds; and for each sink, the columns
    of `doors.LEFT` and following. People outside, and only they, have the
    position (OUTSIDE, OUTSIDE) in the first vector. All draws follow from the
    seed of the Context. `SetStates` may put people outside, by such a row, or
    in.
    """

    def __init__(
        self,
        humans: Sequence[HumanConfig],
        *,
        traffic: Traffic | None = None,
        tracks: ArrayLike | None = None,
        time_step: float = 0.05,
        **options: Any,
    ) -> None:
        """Constructs an OpenCrowd.

        Args:
            humans: As of a `HumanCrowd`.
            traffic: The sources and sinks of these people; by default, none.
                The people of sources are outside at the start.
            tracks: The rows of port ``tracks`` at the start, shape (n, 7); by
                default, there is no such port.
            time_step: The time between two updates, in seconds.
            options: The other options of a `HumanCrowd`.

        Raises:
            ValueError: As `HumanCrowd`, and if traffic or tracks are not of
                these people.
        """
        n = len(humans)
        self._first_rows = np.zeros((n, TRACK_SIZE))
        if tracks is not None:
            self._first_rows = np.array(tracks, dtype=float)
            if self._first_rows.shape != (n, TRACK_SIZE):
                raise ValueError(
                    f"tracks must have shape ({n}, {TRACK_SIZE}), got"
                    f" {self._first_rows.shape}"
                )
        self._bodies = np.array([human.contact_radius for human in humans])
        if traffic is None:
            nobody = np.full(n, -1), np.zeros((n, 2))
            traffic = Traffic((), (), *nobody)
        self._doors = Doors(humans, traffic, time_step)
        HumanCrowd.__init__(
            self,
            humans,
            time_step=time_step,
            # Steps in which people come or go have no derivatives.
            converter=SystemScalarConverter(),
            **options,
        )
        self._tracks = None
        if tracks is not None:
            self._tracks = self.DeclareVectorInputPort("tracks", n * TRACK_SIZE)
        sizes = (
            SOURCE_SIZE * len(traffic.sources),
            len(humans),
            SINK_SIZE * len(traffic.sinks),
        )
        self._counts, self._rests, self._departures = (
            self.DeclareDiscreteState(size) for size in sizes
        )
        self._traffic = self.DeclareVectorOutputPort(
            "traffic",
            2 * len(traffic.sources) + len(traffic.sinks),
            self._CalcTraffic,
            prerequisites_of_calc={
                self.discrete_state_ticket(self._counts),
                self.discrete_state_ticket(self._departures),
            },
        )

    def get_tracks_input_port(self) -> InputPort:
        """Returns the port with the given states of people.

        Raises:
            ValueError: If the crowd was made without.
        """
        return RequirePort(self, self._tracks, "tracks", "tracks=None")

    def get_traffic_output_port(self) -> OutputPort:
        """Returns the port with the numbers of people who came and went."""
        return self._traffic

    def GetCounts(self, context: Context) -> TrafficCounts:
        """Returns the numbers of people who came in, wait, and have left.

        Args:
            context: Of this system.
        """
        self.ValidateContext(context)
        names = [source.name for source in self._doors.sources]
        numbers = [round(x) for x in self._traffic.Eval(context).tolist()]
        ends = 2 * len(names)
        sinks = [sink.name for sink in self._doors.sinks]
        return TrafficCounts(
            arrivals=dict(zip(names, numbers[:ends:2], strict=True)),
            waiting=dict(zip(names, numbers[1:ends:2], strict=True)),
            departures=dict(zip(sinks, numbers[ends:], strict=True)),
        )

    def SetSeed(self, context: Context, seed: int) -> None:
        """Resets people to the start of a seed: see `HumanCrowd.SetSeed`.

        The people of sources are outside, and nobody has come yet.
        """
        HumanCrowd.SetSeed(self, context, seed)
        for index in (self._counts, self._rests, self._departures):
            size = context.get_discrete_state(index).size()
            context.SetDiscreteState(index, np.zeros(size))

    def TakeOut(self, context: Context, rows: Sequence[int]) -> None:
        """Puts people outside, for good.

        Args:
            context: Of this system, changed.
            rows: The rows of the people in ``human_states``.

        Raises:
            ValueError: If there is no such row, or its person follows a
                recording, which would bring it back.
        """
        self.ValidateContext(context)
        n = len(self._humans)
        rows = [*rows]  # (To NumPy, a tuple is one index.)
        for row in rows:
            # (To NumPy, booleans are no rows but a mask.)
            is_row = isinstance(row, Integral) and not isinstance(row, bool)
            if not is_row or not 0 <= row < n:
                raise ValueError(
                    f"rows must be whole numbers in [0, {n}), got {row!r:.80}"
                )
            if self._tracks is not None and self._humans[row].track is not None:
                raise ValueError(
                    f"humans[{row}] follows a recording, and cannot be taken"
                    " out; leave it out of the people"
                )
        states = self._GetState(context).copy()
        states[rows] = 0.0
        states[rows, : Y + 1] = OUTSIDE
        self.SetStates(context, states)
        rests = context.get_discrete_state(self._rests).CopyToVector()
        rests[rows] = FOR_GOOD
        context.SetDiscreteState(self._rests, rests)

    def CalcJacobian(self, context: Context) -> Any:
        """Raises a ValueError: where people come and go, steps jump."""
        self.ValidateContext(context)
        raise ValueError(
            f"{self.GetSystemPathname()}: derivatives need a crowd without"
            " sources and sinks; use HumanCrowd"
        )

    def _Draw(self, seed: int) -> Sequence[NDArray[np.float64]]:
        start, *parameters = HumanCrowd._Draw(self, seed)
        states = start.reshape(len(self._humans), -1)
        self._doors.start(states)
        given = self._first_rows[:, MASK] != 0
        states[given] = self._first_rows[given, MASK + 1 :]
        return states.ravel(), *parameters

    def _LookAtPresent(self, context: Context) -> _Present:
        """Returns the people who are here, their step and their snapshot.

        People whose next states are given count only near others.
        """
        state = self._GetState(context)
        here = ~is_outside(state)
        if self._tracks is not None:
            given = here & (self._GetTracks(context)[:, MASK] != 0)
            here[given] = _is_near(state[given], state[here & ~given])
        rows = np.flatnonzero(here)
        step = self._step.of(rows)
        commands = self._commands.Eval(context).reshape(-1, COMMAND_SIZE)
        weights = self.GetWeights(context)[rows]
        weights.setflags(write=False)
        snapshot = step.look(
            state[rows], commands[rows], self._GetRobots(context), weights
        )
        return _Present(rows, step, snapshot)

    def _CalcHumanStates(self, context: Context, output: BasicVector) -> None:
        HumanCrowd._CalcHumanStates(self, context, output)
        rows = output.value().reshape(-1, STATE_SIZE).copy()
        rows[is_outside(rows), RADIUS] = 0.0
        output.SetFromVector(rows.ravel())

    def _CalcForces(self, context: Context, output: BasicVector) -> None:
        forces = np.zeros((len(self._humans), FORCES_SIZE))
        rows, step, snapshot = self._LookAtPresent(context)
        forces[rows] = step.forces(snapshot)
        if self._tracks is not None:
            forces[self._GetTracks(context)[:, MASK] != 0] = 0.0
        output.SetFromVector(forces.ravel())

    def _CalcOverlaps(self, context: Context, output: BasicVector) -> None:
        state = self._GetState(context)
        rows = np.flatnonzero(~is_outside(state))
        overlaps = np.zeros(len(state))
        overlaps[rows] = self._step.of(rows).overlaps(
            state[rows], self._GetRobots(context)
        )
        output.SetFromVector(overlaps)

    def _CalcTraffic(self, context: Context, output: BasicVector) -> None:
        counts = self._GetRows(context, self._counts, SOURCE_SIZE)
        waiting = counts[:, CAME] - counts[:, ENTERED]
        per_source = np.column_stack([counts[:, PEOPLE], waiting])
        departures = self._GetRows(context, self._departures, SINK_SIZE)
        output.SetFromVector(
            np.concatenate([per_source.ravel(), departures[:, LEFT]])
        )

    def _GetTracks(self, context: Context) -> Array:
        """Returns the rows of port ``tracks``."""
        rows: Array = self.get_tracks_input_port().Eval(context)
        return rows.reshape(-1, TRACK_SIZE)

    def _TakeStep(self, context: Context) -> tuple[Array, Array, Array]:
        if self._tracks is not None:
            return self._TakeGivenStep(context)
        states = self._GetState(context).copy()
        stances = self._GetStances(context).copy()
        robots = self._GetRobots(context)
        touches = np.zeros((len(robots), len(states), TOUCH_SIZE))
        rows, step, snapshot = self._LookAtPresent(context)
        stepped = step.advance(snapshot, step.forces(snapshot), stances[rows])
        states[rows], stances[rows], touched = stepped
        touches[:, rows] = touched.reshape(len(robots), len(rows), TOUCH_SIZE)
        return states.ravel(), stances.ravel(), touches.ravel()

    def _TakeGivenStep(self, context: Context) -> tuple[Array, Array, Array]:
        """Returns a step in which the states of some people are given."""
        before = self._GetState(context)
        states, stances = before.copy(), self._GetStances(context).copy()
        robots = self._GetRobots(context)
        touches = np.zeros((len(robots), len(states), TOUCH_SIZE))
        tracks = self._GetTracks(context)
        given = tracks[:, MASK] != 0
        here = ~is_outside(before)
        nexts = tracks[:, MASK + 1 :]
        if (here & ~given).any():
            rows, step, snapshot = self._LookAtPresent(context)
            come = given & ~is_outside(nexts)
            stepped = step.advance_others(
                *(snapshot, step.forces(snapshot), stances[rows], given[rows]),
                np.column_stack([nexts, self._bodies])[come],
            )
            states[rows], stances[rows], touched = stepped
            shape = len(robots), len(rows), TOUCH_SIZE
            touches[:, rows] = touched.reshape(shape)
        states[given], stances[given] = nexts[given], 0.0
        stay = np.flatnonzero(given & here & ~is_outside(nexts))
        if len(robots) and len(stay):
            touches[:, stay] = self._step.of(stay).touches(
                before[stay], states[stay], robots
            )
        return states.ravel(), stances.ravel(), touches.ravel()

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        states, stances, _ = map(np.copy, self._EvalStep(context))
        states = states.reshape(-1, MOTION_SIZE)
        stances = stances.reshape(-1, STANCE_SIZE)
        after = self._doors.step(
            Passage(
                states=states,
                counts=self._GetRows(context, self._counts, SOURCE_SIZE),
                rests=context.get_discrete_state(self._rests).value(),
                departures=self._GetRows(context, self._departures, SINK_SIZE),
                moved=np.zeros(len(states), dtype=bool),
            ),
            self._commands.Eval(context).reshape(-1, COMMAND_SIZE),
            self._GetRobots(context),
            self.GetSeed(context),
        )
        stances[after.moved] = 0.0
        for index, values in (
            (self._state, after.states),
            (self._stances, stances),
            (self._counts, after.counts),
            (self._rests, after.rests),
            (self._departures, after.departures),
        ):
            discrete_state.set_value(index, values.ravel())


def _is_near(states: Array, others: Array) -> Mask:
    """Returns whether people are near any of others, shape (n,)."""
    dx, dy = (states[:, None, k] - others[:, k] for k in (X, Y))
    near: Mask = (dx * dx + dy * dy <= _FELT * _FELT).any(axis=1)
    return near
