"""Groups of people who stand and talk, from their signals or their places."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.components import connected_components
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

# Who is slower stands, in m/s.
_STANDING = 0.2

# People talk with somebody this far ahead of them, in meters.
_AHEAD = 1.0

# Two are linked if these points, and if they themselves, are within, in meters.
_VOTES_APART, _BODIES_APART = 1.1, 3.4

# The distances of members from the middle of their group, in meters.
_INNER, _OUTER = 0.4, 2.0

# The largest angle by which members look past the middle, and the least
# difference of headings: those in a queue or on a bench have equal ones.
_PAST = _TURNED = np.pi / 4

_Indices = NDArray[np.int64]


class Groups(NamedTuple):
    """The groups of G samples; a sample with two groups counts twice.

    Attributes:
        sample: The sample of each, shape (G,).
        center: Its middle o, shape (G, 2), in W, in meters.
        radius: The largest distance rho of a member from o, (G,), in meters.
        members: Whether each person is a member, shape (G, n).
    """

    sample: _Indices
    center: Array
    radius: Array
    members: Mask


def groups_by_signals(humans: Array, signals: Array) -> Groups:
    """Returns the circles that people show, with the center of their host.

    Members show the activity CONVERSATION and the same host, and stand within
    2.0 m of the center; others are still on their way. The center is that of
    the host, or the mean of those who talk if the host is a robot.

    Args:
        humans: States of n people, shape (N + 1, n, 7).
        signals: Rows of `layout.Signal`, shape (N + 1, n, 22).
    """
    n = humans.shape[1]
    talks = signals[..., Signal.ACTIVITY] == Activity.CONVERSATION
    sample, person = np.nonzero(talks & _stands(humans))
    told = signals[sample, person, Signal.HOST].astype(np.int64)
    host = np.where(told < 0, person, told)
    span = n + host.max(initial=0) + 1
    keys, label = np.unique(sample * span + host, return_inverse=True)
    places = humans[sample, person, : Y + 1]
    center = _means(places, label, len(keys))
    # (A host who is interrupted shows no center.)
    by_person = np.zeros(len(keys), dtype=np.bool_)
    by_person[label[told == person]] = True
    center[by_person] = signals[
        keys[by_person] // span,
        keys[by_person] % span,
        Signal.CENTER_X : Signal.CENTER_Y + 1,
    ]
    near = np.hypot(*(places - center[label]).T) <= _OUTER
    own = np.eye(n, dtype=bool)[person]
    return _groups(sample[near], own[near], label[near], places[near], center)


def groups_by_geometry(humans: Array) -> Groups:
    """Returns groups of people who face the same place.

    Each person slower than 0.2 m/s votes for the point 1.0 m ahead. Two are
    linked if their votes are at most 1.1 m and their bodies at most 3.4 m
    apart. The middle of those who are linked is the mean of their votes; who
    is not 0.4 to 2.0 m from it, or looks more than pi/4 past it, is left out,
    until there is nobody to leave out. At least two remain, whose headings
    differ by pi/4 or more.

    Args:
        humans: States of n people, shape (N + 1, n, 7); NaN if missing.
    """
    n = humans.shape[1]
    pairs = _pairs(humans)
    rows = humans.reshape(-1, humans.shape[2])
    places, yaw = rows[:, : Y + 1], rows[:, YAW]
    votes = places + _AHEAD * np.column_stack([np.cos(yaw), np.sin(yaw)])
    linked = (_apart(votes, pairs) <= _VOTES_APART) & (
        _apart(places, pairs) <= _BODIES_APART
    )
    # Only people with a link are nodes of the graph.
    nodes, ends = np.unique(pairs[:, linked], return_inverse=True)
    edges = ends.reshape(2, -1)
    label = connected_components(len(nodes), edges)
    count = int(label.max(initial=-1)) + 1
    keeps = np.ones(len(nodes), dtype=np.bool_)
    while True:
        center = _means(votes[nodes[keeps]], label[keeps], count)
        x, y = (center[label] - places[nodes]).T
        away = np.hypot(x, y)
        past = np.abs(wrap_angles(np.arctan2(y, x) - yaw[nodes]))
        kept = keeps & (away >= _INNER) & (away <= _OUTER) & (past <= _PAST)
        if kept.sum() == keeps.sum():
            break
        keeps = kept
    of = np.full(len(rows), -1)
    of[nodes[keeps]] = label[keeps]
    first, second = of[pairs]
    turn = np.abs(wrap_angles(yaw[pairs[0]] - yaw[pairs[1]]))
    talk = np.unique(first[(first == second) & (turn >= _TURNED)])
    # A group's label becomes its place among those that talk.
    found = np.flatnonzero(np.isin(of, talk[talk >= 0]))
    talk, label = np.unique(of[found], return_inverse=True)
    own = np.eye(n, dtype=bool)[found % n]
    return _groups(found // n, own, label, places[found], center[talk])


def _stands(humans: Array) -> Mask:
    stands: Mask = np.hypot(humans[..., VX], humans[..., VY]) < _STANDING
    return stands


def _pairs(humans: Array) -> _Indices:
    """Returns pairs of standing people who may share a group, shape (2, m).

    A person i in sample k is k n + i.
    """
    n = humans.shape[1]
    stands = _stands(humans)
    found = [np.zeros((2, 0), dtype=np.int64)]
    for i in range(n - 1):
        x, y = (humans[:, i + 1 :, j] - humans[:, i, j, None] for j in (X, Y))
        near = np.hypot(x, y) <= 2 * _OUTER
        k, j = np.nonzero(near & stands[:, i + 1 :] & stands[:, i, None])
        found.append(np.stack([k * n + i, k * n + i + 1 + j]))
    return np.concatenate(found, axis=1)


def _apart(points: Array, pairs: _Indices) -> Array:
    distance: Array = np.hypot(*(points[pairs[0]] - points[pairs[1]]).T)
    return distance


def _means(points: Array, label: _Indices, count: int) -> Array:
    """Returns the mean of the points of each label, shape (count, 2)."""
    sizes = np.maximum(np.bincount(label, minlength=count), 1)
    sums = [np.bincount(label, values, count) for values in points.T]
    means: Array = np.stack(sums, axis=1) / sizes[:, None]
    return means


def _groups(
    sample: _Indices,
    person: Mask,
    label: _Indices,
    places: Array,
    center: Array,
) -> Groups:
    """Returns the groups of m members, without those of one member.

    `person` has a row for each member, which is true in its column.
    """
    count = len(center)
    members = np.zeros((count, person.shape[1]), dtype=np.bool_)
    np.logical_or.at(members, label, person)
    samples = np.zeros(count, dtype=np.int64)
    samples[label] = sample
    radius = np.zeros(count)
    np.maximum.at(radius, label, np.hypot(*(places - center[label]).T))
    several = members.sum(axis=1) >= 2
    return Groups(
        samples[several], center[several], radius[several], members[several]
    )
