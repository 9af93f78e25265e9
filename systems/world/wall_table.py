"""Walls as one table for compiled code, with a tree of bounding boxes.

Consecutive segments of a shape make runs, and runs that are near each other
share a box, as do such boxes: a query skips all that is in a box that it does
not reach. Unlike a grid of cells this has no cell size to choose, and its
memory does not grow with the extent of the world, or the length of a wall.
`walls.py` reads the table.
"""

import itertools

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# The largest number of segments of a run, and of runs that are not divided.
_RUN = 8
_FEW = 8

# Boxes are larger than their content by this part of its coordinates: so
# rounding loses nothing.
_SLACK = 1e-12


def wall_table(
    segments: Floats, first: Integers, solid: NDArray[np.bool_]
) -> Floats:
    """Returns the table of some walls, given the arrays of `Obstacles`.

    Returns:
        One array, read-only: Python passes one to compiled code in a fraction
        of the time that six take. It holds the numbers of segments (s),
        shapes (k), runs (r) and boxes (m); then segments (s, 4); boxes (m, 4),
        rows (x0, y0, x1, y1) from the lower left to the upper right corner, in
        meters, each before all that are in it; first (k + 1,); solid (k,);
        runs (r, 4), rows (first segment, the one after the last, shape, box);
        links (m, 2), rows (the next box that is not in this one, the run of
        this box, or -1). Integers have the bits of int64.
    """
    runs = _runs(first)
    boxes, links = _tree(_bounds(segments, runs))
    leaf = np.flatnonzero(links[:, 1] >= 0)
    runs[links[leaf, 1], 3] = leaf
    sizes = np.array([len(segments), len(solid), len(runs), len(boxes)])
    integers = (first, solid.astype(np.int64), runs, links)
    table: Floats = np.concatenate(
        [sizes.view(np.float64), segments.ravel(), boxes.ravel()]
        + [part.ravel().view(np.float64) for part in integers]
    )
    table.setflags(write=False)
    return table


def _runs(first: Integers) -> Integers:
    """Returns shapes cut into runs of about the same length, shape (r, 4)."""
    rows: list[tuple[int, int, int, int]] = []
    for shape, (begin, end) in enumerate(itertools.pairwise(first.tolist())):
        count = -((begin - end) // _RUN)
        cuts = [begin + i * (end - begin) // count for i in range(count)]
        rows += [
            (lo, hi, shape, -1) for lo, hi in itertools.pairwise([*cuts, end])
        ]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)


def _bounds(segments: Floats, runs: Integers) -> Floats:
    """Returns the box around each run, shape (r, 4)."""
    if not len(runs):
        return np.zeros((0, 4))
    ends = segments.reshape(-1, 2, 2)
    low = np.minimum.reduceat(ends.min(axis=1), runs[:, 0])
    high = np.maximum.reduceat(ends.max(axis=1), runs[:, 0])
    slack = _SLACK * np.maximum(-low, high).max(axis=1, keepdims=True)
    return np.hstack([low - np.abs(slack), high + np.abs(slack)])


def _tree(bounds: Floats) -> tuple[Floats, Integers]:
    """Returns the boxes and links of the tree over some runs."""
    boxes: list[Floats] = []
    links: list[list[int]] = []

    def grow(runs: Integers) -> None:
        if len(runs) <= _FEW:
            for run in runs:
                boxes.append(bounds[run])
                links.append([len(boxes), int(run)])
            return
        centers = bounds[runs, :2] + bounds[runs, 2:]
        axis = int(np.argmax(np.ptp(centers, axis=0)))
        order = runs[np.argsort(centers[:, axis], kind="stable")]
        halves = (
            np.sort(order[: len(order) // 2]),
            np.sort(order[len(order) // 2 :]),
        )
        # Runs come up nearly in their own order, which is that of sums.
        for half in sorted(halves, key=lambda half: int(half[0])):
            box = len(boxes)
            boxes.append(
                np.hstack(
                    [bounds[half, :2].min(axis=0), bounds[half, 2:].max(axis=0)]
                )
            )
            links.append([0, -1])
            grow(half)
            links[box][0] = len(boxes)

    grow(np.arange(len(bounds)))
    return (
        np.array(boxes).reshape(-1, 4),
        np.array(links, dtype=np.int64).reshape(-1, 2),
    )
