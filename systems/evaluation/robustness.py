"""How near a recorded trial is to a failure, and the registry of failures.

A user's kind of failure is one decorated function of a recording::

    @register_robustness("hurry", unit="m/s")
    def hurry(recording: Recording) -> Array:
        \"\"\"How much slower than 0.8 m/s the robot is.\"\"\"
        return 0.8 - recording.features.forward_speed
"""

from collections.abc import Callable
from dataclasses import dataclass
import inspect
import math
from typing import Any, NamedTuple

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import RADIUS, VX, VY, YAW, Contact, X, Y
from hunav_drake.systems.common.poses import wrap_angles
from hunav_drake.systems.common.suggest import suggestion
from hunav_drake.systems.evaluation.chords import nearest_on_chords
from hunav_drake.systems.evaluation.features import CONTACT_GAP
from hunav_drake.systems.evaluation.metric import check_takes, origin_of
from hunav_drake.systems.evaluation.metrics.proxemics import INTIMATE
from hunav_drake.systems.evaluation.recording import Recording

# The robustness of a trial in which nothing could have failed.
NO_FAILURE = 9.0

# A robot that approaches a person at this speed, or drives, moves, in m/s.
_MOVES = 0.1

# A slower robot stands, in m/s, unless it is this near to its goal, in meters.
_STANDS, _AT_GOAL = 0.05, 1.0

# The longest time to stand, and to be in somebody's intimate space, in seconds.
_PATIENCE, _INTRUSION = 5.0, 2.0


class Failing(NamedTuple):
    """How near a trial is to a failure, when, and to whom.

    Attributes:
        robustness: The least margin; below 0 the trial fails.
        time: When the margin first fell below 0 or, if it never did, was least;
            in seconds.
        person: The index of the person whom it concerns, the nearest one if
            several are equal; -1 for nobody.
        bearing: The direction of the center of that person from the robot, one
            sample before (then, if the person was not there yet), in radians, 0
            ahead, counterclockwise; NaN for nobody.
        closing_speed: The speed at which the two approach each other then, in
            m/s; NaN for nobody.
    """

    robustness: float
    time: float
    person: int
    bearing: float
    closing_speed: float


@dataclass(frozen=True, kw_only=True)
class Robustness:
    """A kind of failure.

    Attributes:
        name: Its name.
        unit: The unit of its margins.
        definition: Its description.
        timed: Whether the function also takes the time limit of the trial.
        function: The function that returns the margins.
    """

    name: str
    unit: str
    definition: str
    timed: bool
    function: Callable[..., Any]

    def margins(self, recording: Recording, duration: float) -> Array:
        """Returns the margins: shape (N + 1,), or (N + 1, n) for n people.

        They are infinite where nothing can fail. Of a single number, all but
        the last one are.

        Args:
            recording: Its recording.
            duration: Its time limit, in seconds.

        Raises:
            ValueError: If the function returns something other than a number
                or margins of the right shape.
        """
        given = (recording, duration) if self.timed else (recording,)
        margins = np.asarray(self.function(*given), dtype=float)
        samples, people = len(recording), recording.num_humans
        if margins.shape not in ((), (samples,), (samples, people)):
            raise ValueError(
                f"robustness {self.name!r}: it must return a number, or one for"
                f" each of {samples} samples, and perhaps of {people} people;"
                f" got the shape {margins.shape}"
            )
        margins = np.where(np.isnan(margins), np.inf, margins)
        if margins.ndim:
            return margins
        series = np.full(samples, np.inf)
        series[-1] = margins
        return series

    def failing(self, recording: Recording, duration: float) -> Failing:
        """Returns how near a trial is to this failure: see `margins`."""
        margins = self.margins(recording, duration)
        people = recording.num_humans
        series = margins.reshape(len(recording), -1).min(axis=1, initial=np.inf)
        least = float(series.min())
        at = int(np.argmax(series < 0) if least < 0 else series.argmin())
        gaps = recording.features.gaps[at]
        if margins.ndim == 2 and people and math.isfinite(least):
            # (Of equal margins, that of the nearest person.)
            person = int(np.lexsort((gaps, margins[at]))[0])
        else:
            nobody = not np.isfinite(gaps).any()
            person = -1 if nobody else int(np.nanargmin(gaps))
        return Failing(
            least if math.isfinite(least) else NO_FAILURE,
            float(recording.times[at]),
            person,
            *_meeting(recording, at, person),
        )


# All kinds of failures by name, in the order of their registration.
ROBUSTNESS: dict[str, Robustness] = {}


def register_robustness[F: Callable[..., Any]](
    name: str, *, unit: str = "-", timed: bool = False
) -> Callable[[F], F]:
    """Registers a function of a recording as a kind of failure.

    The function returns margins of shape (N + 1,), or (N + 1, n) for each of n
    people, or a single number; below 0 is a failure, and NaN or infinity where
    nothing can fail. The less there is to a failure, the smaller they should
    be, since searches descend on them. A function replaces one that was defined
    in the same place, as when a notebook cell is run again.

    Args:
        name: Its name.
        unit: The unit of the margins.
        timed: Whether the function also takes the time limit of the trial, in
            seconds, as its second argument.

    Returns:
        A decorator that returns the function unchanged.

    Raises:
        ValueError: If the name is taken, or the function takes other arguments.
    """

    def register(function: F) -> F:
        given = ("recording", "duration") if timed else ("recording",)
        check_takes(function, f"robustness {name!r}", *given)
        old = ROBUSTNESS.get(name)
        if old is not None and origin_of(old.function) != origin_of(function):
            raise ValueError(
                f"a robustness named {name!r} is registered already; choose"
                " another name"
            )
        ROBUSTNESS[name] = Robustness(
            name=name,
            unit=unit,
            definition=inspect.cleandoc(function.__doc__ or ""),
            timed=timed,
            function=function,
        )
        return function

    return register


def robustness_of(name: str) -> Robustness:
    """Returns a kind of failure by its name.

    Raises:
        ValueError: If there is none of that name; it suggests another one.
    """
    if name not in ROBUSTNESS:
        near = suggestion(name, [*ROBUSTNESS])
        raise ValueError(f"there is no robustness {name!r}; {near}")
    return ROBUSTNESS[name]


@register_robustness("collision", unit="m")
def collision(recording: Recording) -> Array:
    """The gap to people whom the robot approaches, until it runs into one.

    The gap to each person whom the robot approaches at more than 0.1 m/s, and
    faster than the person the robot, up to their first contact. Between samples
    both move straight, and the smallest gap counts; gaps below 2 cm, which are
    no contact yet where bodies are smaller than the discs that people keep
    free, become ever smaller, and stay positive. If the first contact with a
    person is the robot's alone, the margin is less than 0: minus the closing
    speed, in m/s. Contacts that a person begins are no failures.
    """
    rows, robot = recording.humans, recording.robot[:, None]
    offset = rows[..., : Y + 1] - robot[..., : Y + 1]
    distance = np.hypot(offset[..., X], offset[..., Y])
    n = offset / np.maximum(distance, 1e-9)[..., None]
    a = (robot[..., VX : VY + 1] * n).sum(axis=-1)
    b = -(rows[..., VX : VY + 1] * n).sum(axis=-1)
    # Of the chord that leads to each sample; the first has none.
    start = np.concatenate([offset[:1], offset[:-1]])
    _, gap = nearest_on_chords(start, offset)
    gap = gap - rows[..., RADIUS] - robot[..., RADIUS]
    # It counts who approaches where the chord begins, or where it ends.
    meets, speed = (a > b) & (a > _MOVES), a + b
    meets[1:] |= meets[:-1].copy()
    speed[1:] = np.maximum(speed[1:], speed[:-1])
    hits = gap < CONTACT_GAP
    if recording.contacts is not None:
        counts = recording.contacts
        new = np.diff(counts, axis=0, prepend=counts[:1]) > 0
        by_robot = new[..., Contact.BY_ROBOT] & ~new[..., Contact.BY_PERSON]
        hits = new[..., Contact.BY_ROBOT] | new[..., Contact.BY_PERSON]
        hits[0] = counts[0, :, Contact.LASTS] > 0
        speed = counts[..., Contact.RELATIVE_SPEED]
        fails = by_robot & (speed > _MOVES)
    else:
        fails = hits & meets
    near = CONTACT_GAP * np.exp(np.minimum(gap / CONTACT_GAP - 1.0, 0.0))
    margins = np.where(meets & ~hits, np.maximum(gap, near), np.inf)
    margins = np.where(fails, -speed, margins)
    touched = np.cumsum(hits, axis=0) - hits > 0
    return np.where(touched, np.inf, margins)


@register_robustness("freeze", unit="s")
def freeze(recording: Recording) -> Array:
    """5 s less the time for which the robot has stood.

    It stands while it is slower than 0.05 m/s, more than 1 m from its goal.
    """
    robot, features = recording.robot, recording.features
    slow = np.hypot(robot[:, VX], robot[:, VY]) < _STANDS
    slow &= features.goal_distance > _AT_GOAL
    last = np.maximum.accumulate(np.where(slow, -1, np.arange(len(robot))))
    times = recording.times
    since = times[np.maximum(last, 0)]
    return np.round(_PATIENCE - np.where(slow, times - since, 0.0), 9)


@register_robustness("intrusion", unit="s")
def intrusion(recording: Recording) -> Array:
    """2 s less the time that the robot has moved in a person's intimate space.

    That is at a gap of less than 0.45 m, at more than 0.1 m/s.
    """
    robot, features = recording.robot, recording.features
    moves = np.hypot(robot[:, VX], robot[:, VY]) > _MOVES
    inside = (features.gaps < INTIMATE) & moves[:, None]
    spent = inside[1:] * features.intervals[:, None]
    within = np.zeros(inside.shape)
    within[1:] = np.cumsum(spent, axis=0)
    # (A sum of intervals has rounding errors, and just 2 s are no failure.)
    return np.round(_INTRUSION - within, 9)


@register_robustness("timeout", unit="s", timed=True)
def timeout(recording: Recording, duration: float) -> float:
    """The time limit less the time of arrival.

    A robot that does not arrive would need the time limit and the time for the
    straight way that is left at its largest speed (1 m/s if that is unknown).
    """
    features = recording.features
    if recording.goal is None:
        return math.inf
    if features.at_goal.any():
        arrival = recording.times[int(features.at_goal.argmax())]
        return float(duration - arrival)
    left = float(features.goal_distance[-1])
    return -left / (recording.robot_max_speed or 1.0)


def _meeting(
    recording: Recording, sample: int, person: int
) -> tuple[float, float]:
    """Returns the bearing and the closing speed of a person."""
    if person < 0:
        return math.nan, math.nan
    # (Who touches is stopped, or pushed.)
    before = max(sample - 1, 0)
    if recording.features.present[before, person]:
        sample = before
    robot, human = recording.robot[sample], recording.humans[sample, person]
    x, y, vx, vy = (human - robot)[[X, Y, VX, VY]].tolist()
    bearing = float(wrap_angles(math.atan2(y, x) - robot[YAW]))
    return bearing, -(x * vx + y * vy) / max(math.hypot(x, y), 1e-9)
