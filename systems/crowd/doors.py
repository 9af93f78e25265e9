"""Moves people in at sources and out at sinks, on arrays."""

from collections.abc import Sequence
import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
import shapely

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    OUTSIDE,
    RADIUS,
    VX,
    VY,
    YAW,
    Command,
    X,
    Y,
    is_outside,
)
from hunav_drake.systems.common.random_streams import Purpose, draw_uniform
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.people.traffic import Source, Traffic, place_party

# The columns of a source: the number of parties (people or groups) that have
# come to it, the time since the last one and from it to the next, in seconds (0
# before it is drawn), the number of parties that have come in, the next party,
# and the number of people who have come in.
CAME, SINCE, GAP, ENTERED, TURN, PEOPLE = range(6)
SOURCE_SIZE = 6

# The columns of a sink: the number of people who have left, and the time until
# the next one can, in seconds.
LEFT, BUSY = range(2)
SINK_SIZE = 2

# The least time that people who have left stay outside, in seconds, so that it
# can be seen.
REST = 1.0

# The same of those who never come back.
FOR_GOOD = 1e9

# Goals nearer to each other than this are the same, in meters.
_SAME = 1e-6

# People at their last goal, as behavior trees see it, may be farther from the
# sink by this, in meters, times the square root of the number of people here:
# trees let people stop short of others who stand at a goal.
_SHORT_OF = 0.5


class Passage(NamedTuple):
    """The data that change as people come and go.

    Attributes:
        states: Shape (n, 6): x, y, yaw, vx, vy, omega; rows of OUTSIDE.
        counts: Shape (s, SOURCE_SIZE), of sources.
        rests: Shape (n,), the least time that each person still stays outside,
            in seconds.
        departures: Shape (k, SINK_SIZE), of sinks.
        moved: Shape (n,), whether a person has just come in or left.
    """

    states: Array
    counts: Array
    rests: Array
    departures: Array
    moved: Mask

    def copy(self) -> Self:
        """Returns a copy."""
        return type(self)(
            states=self.states.copy(),
            counts=self.counts.copy(),
            rests=self.rests.copy(),
            departures=self.departures.copy(),
            moved=self.moved.copy(),
        )


class Doors:
    """Lets people in and out. Nothing here changes after the construction.

    Parties come to a source as a Poisson process: the times between two are
    exponentially distributed, each drawn from the seed, the source's name and
    its number.
    """

    def __init__(
        self, humans: Sequence[HumanConfig], traffic: Traffic, time_step: float
    ) -> None:
        """Constructs Doors.

        Args:
            humans: The people.
            traffic: The sources and sinks of people.
            time_step: In seconds.

        Raises:
            ValueError: If the traffic has another number of people.
        """
        if len(traffic.sink_of) != len(humans):
            raise ValueError(
                f"traffic must be of all {len(humans)} people, got"
                f" {len(traffic.sink_of)}; see Traffic.after()"
            )
        self.sources = traffic.sources
        self.sinks = traffic.sinks
        self.pool = np.array(traffic.pool(), dtype=np.intp)
        self._time_step = time_step
        self._sink_of = traffic.sink_of
        self._exits = traffic.exits
        self._areas = [
            shapely.Polygon(it.vertices)
            if len(it.vertices) > 2
            else shapely.Point(it.vertices[0])
            for it in traffic.sinks
        ]
        shapely.prepare(self._areas)
        radii = np.array([it.radius for it in traffic.sinks] + [0.0])
        self._reach = np.maximum(
            radii[self._sink_of], [human.goal_radius for human in humans]
        )
        self._discs = np.array([human.radius for human in humans])
        self._bodies = np.array([human.contact_radius for human in humans])
        self._first_goals = np.array(
            [(human.goals or [human.pose[:2]])[0] for human in humans]
        ).reshape(-1, 2)

    def start(self, states: Array) -> None:
        """Puts the people of sources outside; changes rows (n, 6)."""
        states[self.pool] = 0.0
        states[self.pool, : Y + 1] = OUTSIDE

    def step(
        self, passage: Passage, commands: Array, robots: Array, seed: int
    ) -> Passage:
        """Returns the data after people came and went in one step.

        Args:
            passage: The data, with the states at the end of the step.
            commands: The commands of people, shape (n, COMMAND_SIZE).
            robots: Shape (m, 7): rows of `robot_states`.
            seed: The seed of the times and places of those who come in.
        """
        after = passage.copy()
        after.rests[:] = np.maximum(after.rests - self._time_step, 0.0)
        self._leave(after, commands)
        for count, source in zip(after.counts, self.sources, strict=True):
            self._call(count, source, seed)
            self._let_in(after, count, source, robots, seed)
        return after

    def _leave(self, after: Passage, commands: Array) -> None:
        """Puts people who have reached their sinks outside."""
        goals = commands[:, [Command.GOAL_X, Command.GOAL_Y]]
        has_goal = commands[:, Command.HAS_GOAL] != 0
        bound = has_goal & (abs(goals - self._exits) < _SAME).all(axis=1)
        done = ~has_goal & (commands[:, Command.HOLD] == 0)
        here = ~is_outside(after.states)
        short_of = _SHORT_OF * math.sqrt(np.count_nonzero(here) + 1)
        reach = self._reach + np.where(done, short_of, 0.0)
        ready = (bound | done) & here
        for s, area in enumerate(self._areas):
            rows = np.flatnonzero(ready & (self._sink_of == s))
            places = shapely.points(after.states[rows, : Y + 1])
            away = shapely.distance(area, places)
            nearest = np.argsort(away, kind="stable")
            near = nearest[away[nearest] <= reach[rows[nearest]]]
            count = after.departures[s]
            gone = rows[near[: self._pass(count, s, len(near))]]
            after.states[gone] = 0.0
            after.states[gone, : Y + 1] = OUTSIDE
            after.rests[gone] = REST
            after.moved[gone] = True
            count[LEFT] += len(gone)

    def _pass(self, count: Array, sink: int, most: int) -> int:
        """Returns the number of people at a sink who leave in the step."""
        time = 1 / self.sinks[sink].rate
        if time == 0:
            return most
        count[BUSY] -= self._time_step
        number = 0
        while number < most and count[BUSY] <= 0:
            count[BUSY] += time
            number += 1
        if number == most:
            # It does not accumulate the time in which nobody comes.
            count[BUSY] = max(count[BUSY], self._time_step)
        return number

    def _call(self, count: Array, source: Source, seed: int) -> None:
        """Counts the parties that come to a source in the step."""
        if source.rate == 0:
            return
        count[SINCE] += self._time_step
        if count[GAP] == 0:
            count[GAP] = _gap(source, int(count[CAME]), seed)
        while count[SINCE] >= count[GAP]:
            count[SINCE] -= count[GAP]
            count[CAME] += 1
            count[GAP] = _gap(source, int(count[CAME]), seed)

    def _let_in(
        self,
        after: Passage,
        count: Array,
        source: Source,
        robots: Array,
        seed: int,
    ) -> None:
        """Lets in the parties at a source while there is a place."""
        while count[CAME] > count[ENTERED]:
            turn, party = self._turn(after, source, int(count[TURN]))
            if not len(party):
                return
            stream = source.stream + int(count[ENTERED])
            draws = draw_uniform(
                seed, [stream], Purpose.ARRIVAL_PLACE, len(source.places)
            )
            places = source.places[np.argsort(draws[0])]
            free = self._free(after.states, places, party, source, robots)
            bodies = self._bodies[party].tolist()
            points = place_party(places, free, bodies, source.spacing)
            if points is None:
                return
            way = self._first_goals[party] - points
            after.states[party] = 0.0
            after.states[party, : Y + 1] = points
            after.states[party, YAW] = np.arctan2(way[:, 1], way[:, 0])
            after.moved[party] = True
            count[ENTERED] += 1
            count[TURN] = (turn + 1) % len(source.parties)
            count[PEOPLE] += len(party)

    def _turn(
        self, after: Passage, source: Source, first: int
    ) -> tuple[int, NDArray[np.intp]]:
        """Returns the next party of which nobody is here, and its people.

        Those who never come back are left out; there may be nobody.
        """
        ready = is_outside(after.states) & (after.rests == 0.0)
        for k in range(len(source.parties)):
            turn = (first + k) % len(source.parties)
            party = np.array(source.parties[turn])
            party = party[after.rests[party] < FOR_GOOD / 2]
            if len(party) and ready[party].all():
                return turn, party
        return first, np.zeros(0, dtype=np.intp)

    def _free(
        self,
        states: Array,
        places: Array,
        party: NDArray[np.intp],
        source: Source,
        robots: Array,
    ) -> Mask:
        """Returns where each of a party could stand, shape (m, k)."""
        here = ~is_outside(states)
        away = _distances(states[here, : Y + 1], places) - source.spacing
        gap = np.min(away - self._bodies[here, None], axis=0, initial=math.inf)
        free: Mask = gap >= self._bodies[party][:, None]
        if len(robots):
            # Robots move on in the step.
            speeds = np.hypot(robots[:, VX], robots[:, VY])
            kept = robots[:, RADIUS] + speeds * self._time_step
            away = _distances(robots[:, : Y + 1], places) - source.spacing
            gap = np.min(away - kept[:, None], axis=0)
            free &= gap >= self._discs[party][:, None]
        return free


def _gap(source: Source, number: int, seed: int) -> float:
    """Returns the time until a party comes to a source, in seconds."""
    stream = source.stream + number
    (draw,) = draw_uniform(seed, [stream], Purpose.ARRIVAL_TIME, 1)[0]
    return -math.log1p(-draw) / source.rate


def _distances(points: Array, places: Array) -> Array:
    """Returns the distances (m, k) of points (m, 2) and places (k, 2)."""
    distances: Array = np.hypot(
        points[:, None, X] - places[:, X], points[:, None, Y] - places[:, Y]
    )
    return distances
