"""Who makes which social situation of a robot, sample by sample.

The rules are those of SEAN 2.0 (Tsoi et al. 2022): a person is near within two
steps of 1.2 m and moves from 0.15 m/s on, and paths are crossed or shared
within 15 degrees. What differs, and what is new, is in docs/situations.md.
"""

import numpy as np

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import (
    VX,
    VY,
    YAW,
    Activity,
    Signal,
    X,
    Y,
)
from hunav_drake.systems.common.poses import wrap_angles
from hunav_drake.systems.evaluation.groups import (
    groups_by_geometry,
    groups_by_signals,
)
from hunav_drake.systems.evaluation.recording import Recording

# The labels that a sample can have as its primary one, the first that holds.
PRIMARIES = (
    *("in_o_space", "join_group", "leave_group", "blocked", "at_door"),
    *("at_queue", "accompanied", "cross_path", "down_path", "empty"),
    *("standing", "other"),
)

# The kinds of down_path.
DOWN_PATHS = ("passing", "overtaking", "overtaken", "following")

LABELS = (*PRIMARIES, *DOWN_PATHS)

# SEAN 2.0: near, in meters; moving, in m/s; the angle of paths, in radians.
NEAR, MOVING, ANGLE = 2.4, 0.15, np.pi / 12

# From this speed on, the robot's course counts, not its heading, in m/s.
_COURSE = 0.05

# Speeds are equal within this, in m/s.
_EQUAL = 0.1

# The part of a group's circle that its members stand in, in meters.
_BODY = 0.35

# The distances to somebody in a queue, and to a door, in meters.
_QUEUE, _DOOR = 1.2, 1.5

# A group is joined or left by who was farther or nearer so long ago, in
# seconds; by more than rounding, in meters.
_BEFORE, _ROUNDING = 1.0, 1e-9

# The angle within which a gaze meets the robot, in radians.
_GAZE = 0.2


def people_by_label(
    recording: Recording,
    near: Mask,
    doors: Array,
    signals: Array | None,
    code: int,
) -> dict[str, Mask]:
    """Returns who makes each label, shape (N + 1, n) each.

    Nobody makes "empty"; "standing" and "other" are made by who is near.

    Args:
        recording: The recording of one robot.
        near: See `people_near`.
        doors: The centers of doors, shape (k, 2), in W, in meters.
        signals: Rows of `layout.Signal`, shape (N + 1, n, 22), if recorded.
        code: The row code of the robot in signals.
    """
    found = dict.fromkeys(LABELS, np.zeros_like(near))
    found |= _of_paths(recording, near)
    found |= _of_groups(recording, signals)
    found["at_door"] = _at_doors(recording, doors)
    if signals is not None:
        activity = signals[..., Signal.ACTIVITY]
        gaze = signals[..., Signal.GAZE]
        elsewhere = (gaze >= recording.num_humans) & (gaze != code)
        distance = recording.encounters.distance
        found["at_queue"] = (activity == Activity.QUEUE) & (distance <= _QUEUE)
        found["accompanied"] = (
            near & (activity == Activity.ACCOMPANY) & ~elsewhere
        )
        found["blocked"] = (
            near
            & (activity == Activity.BLOCK)
            & _looks_at_robot(recording, signals, code)
        )
    made = np.any([it.any(axis=1) for it in found.values()], axis=0)
    moves = (near & _moving(recording)).any(axis=1)
    found["standing"] = near & ~(made | moves)[:, None]
    found["other"] = near & (moves & ~made)[:, None]
    return found


def _moving(recording: Recording) -> Mask:
    moving: Mask = recording.features.human_speed >= MOVING
    return moving


def people_near(recording: Recording) -> Mask:
    """Returns who is near, without a wall between, shape (N + 1, n)."""
    near: Mask = recording.encounters.distance <= NEAR
    if len(recording.obstacles):
        # Imported here, so that only worlds with walls load compiled code.
        from hunav_drake.systems.evaluation.curves import lines_blocked

        sample, person = np.nonzero(near)
        lines = np.hstack(
            [
                recording.robot[sample, : Y + 1],
                recording.humans[sample, person, : Y + 1],
            ]
        )
        near[sample, person] = ~lines_blocked(lines, recording.obstacles.table)
    return near


def course(recording: Recording) -> tuple[Array, Array]:
    """Returns the robot's direction c, two components (N + 1, 1), and speed.

    It is that of its velocity from 0.05 m/s on, else its heading.
    """
    robot = recording.robot[:, None]
    vx, vy, yaw = robot[..., VX], robot[..., VY], robot[..., YAW]
    speed = np.hypot(vx, vy)
    angle = np.where(speed >= _COURSE, np.arctan2(vy, vx), yaw)
    return np.stack([np.cos(angle), np.sin(angle)]), speed


def _of_paths(recording: Recording, near: Mask) -> dict[str, Mask]:
    """Returns who is met on the way; alpha is between velocity and c."""
    (cx, cy), speed = course(recording)
    humans, own = recording.humans, recording.features.human_speed
    vx, vy = humans[..., VX], humans[..., VY]
    alpha = np.arctan2(np.abs(cx * vy - cy * vx), cx * vx + cy * vy)
    px, py = recording.encounters.offset
    ahead = px * cx + py * cy
    meets = near & _moving(recording)
    same = meets & (alpha <= ANGLE)
    against = meets & (alpha >= np.pi - ANGLE)
    return {
        "cross_path": meets & (np.abs(alpha - np.pi / 2) <= ANGLE),
        "down_path": same | against,
        "passing": against,
        "overtaking": same & (ahead > 0) & (speed - own > _EQUAL),
        "overtaken": same & (ahead < 0) & (own - speed > _EQUAL),
        "following": same & (ahead > 0) & (np.abs(own - speed) <= _EQUAL),
    }


def _of_groups(recording: Recording, signals: Array | None) -> dict[str, Mask]:
    """Returns the members of groups that the robot joins, leaves or divides."""
    humans, p = recording.humans, recording.robot[:, : Y + 1]
    if signals is None:
        groups = groups_by_geometry(humans)
    else:
        groups = groups_by_signals(humans, signals)

    def of(is_met: Mask) -> Mask:
        """Returns the members of some of the groups, (N + 1, n)."""
        members = np.zeros(humans.shape[:2], dtype=np.bool_)
        np.logical_or.at(members, groups.sample[is_met], groups.members[is_met])
        return members

    def around(place: Array, nears: float) -> Mask:
        """Returns which groups' place it is that the robot nears, (G,)."""
        distance = np.hypot(*(p - place).T)
        times = recording.times
        before = np.interp(times - _BEFORE, times, distance)
        moves = (distance <= NEAR) & (nears * (before - distance) > _ROUNDING)
        beside = np.hypot(*(groups.center - place).T) <= 2 * groups.radius
        met: Mask = moves[groups.sample] & beside
        return met

    away = np.hypot(*(p[groups.sample] - groups.center).T)
    found = {
        "in_o_space": of(away <= groups.radius - _BODY),
        "leave_group": of(around(p[0], -1.0)),
    }
    if recording.goal is not None:
        found["join_group"] = of(around(np.array(recording.goal[:2]), 1.0))
    return found


def _at_doors(recording: Recording, doors: Array) -> Mask:
    """Returns who is at the same door as the robot, (N + 1, n)."""
    found = np.zeros(recording.humans.shape[:2], dtype=np.bool_)
    for door in doors:
        robot, people = (
            np.hypot(*np.moveaxis(it[..., : Y + 1] - door, -1, 0)) <= _DOOR
            for it in (recording.robot, recording.humans)
        )
        found |= people & robot[:, None]
    return found


def _looks_at_robot(recording: Recording, signals: Array, code: int) -> Mask:
    """Returns whose gaze meets the robot, (N + 1, n)."""
    gaze, humans = signals[..., Signal.GAZE], recording.humans
    to_point = np.arctan2(
        signals[..., Signal.GAZE_Y] - humans[..., Y],
        signals[..., Signal.GAZE_X] - humans[..., X],
    )
    px, py = recording.encounters.offset
    looks = np.where(gaze == -2, to_point, humans[..., YAW])
    error = np.abs(wrap_angles(np.arctan2(-py, -px) - looks))
    met: Mask = (gaze == code) | ((gaze < 0) & (error <= _GAZE))
    return met
