"""The frames of a ROS bag, with their poses over time."""

from collections import defaultdict
import math

import numpy as np

from hunav_drake.hunavsim.ros2.bag import TRANSFORMS, Bag
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.planning.ros2 import messages as m

# Longer gaps between messages on a robot are not bridged, in seconds. Those
# between transforms are told.
LONGEST_GAP = 1.0


class Frames:
    """The frames of a bag, with their poses over time.

    Attributes:
        fixed: The frame to which all is moved: "map" if it is known, or else
            the root of the odometry's frame.
    """

    def __init__(self, bag: Bag) -> None:
        found: dict[str, list[tuple[float, ...]]] = defaultdict(list)
        self._bag = bag
        self._parents: dict[str, str] = {}
        self._others: dict[str, str] = {}
        self._gaps: dict[str, float] = {}
        topics = [
            it
            for it, kind in bag.types.items()
            if kind in (TRANSFORMS, "tf/msg/tfMessage")
        ]
        for topic, came, told in bag.messages(*topics):
            for it in told.transforms:
                child = plain(it.child_frame_id)
                parent = plain(it.header.frame_id)
                if self._parents.setdefault(child, parent) != parent:
                    self._others[child] = parent
                move, turn = it.transform.translation, it.transform.rotation
                when, yaw = bag.time(it.header, came), m.yaw_of(turn)
                numbers = {"x": move.x, "y": move.y, "yaw": yaw}
                bag.check(topic, when, numbers)
                found[child].append((when, *numbers.values()))
        self._poses = {
            child: np.array(sorted(rows)) for child, rows in found.items()
        }
        self._moving = {
            child
            for child, rows in self._poses.items()
            if np.ptp(rows, 0)[1:].any()
        }
        known = {*self._parents, *self._parents.values()}
        self.fixed = "map" if "map" in known else ""

    def root(self, frame: str) -> str:
        """Returns the frame that is above a frame, at the top."""
        seen = {frame}
        while frame in self._parents and self._parents[frame] not in seen:
            frame = self._parents[frame]
            seen.add(frame)
        return frame

    def pose(self, frame: str, time: float) -> tuple[float, float, float]:
        """Returns the pose of a frame in the fixed one, at a time.

        Raises:
            ValueError: If no transforms join them.
        """
        frame = plain(frame)
        # Without any frame named, all is in one.
        self.fixed = self.fixed or self.root(frame)
        x = y = yaw = 0.0
        at, steps = frame, 0
        while at != self.fixed:
            if not frame:
                raise ValueError(
                    "messages without a frame (header.frame_id) cannot be"
                    f" moved to {self.fixed!r}; name their frame in the bag"
                )
            if at not in self._parents or steps > len(self._parents):
                raise ValueError(
                    f"no transforms on /tf join the frames {frame!r} and"
                    f" {self.fixed!r}; record /tf and /tf_static, too"
                )
            if at in self._others:
                raise ValueError(
                    f"the frame {at!r} has two parents on /tf,"
                    f" {self._parents[at]!r} and {self._others[at]!r}; leave"
                    " one out of the bag"
                )
            dx, dy, turn = self._local(at, time)
            c, s = math.cos(turn), math.sin(turn)
            x, y = dx + c * x - s * y, dy + s * x + c * y
            yaw += turn
            at, steps = self._parents[at], steps + 1
        return x, y, yaw

    def _local(self, frame: str, time: float) -> tuple[float, float, float]:
        """Returns the pose of a frame in its parent, interpolated."""
        rows = self._poses[frame]
        right = int(np.searchsorted(rows[:, 0], time))
        if right == 0 or right == len(rows):
            end, x, y, yaw = rows[min(right, len(rows) - 1)].tolist()
            if frame in self._moving:
                self._note_gap(frame, abs(time - end))
            return x, y, yaw
        a, b = rows[right - 1], rows[right]
        if (a[1:] != b[1:]).any():
            self._note_gap(frame, float(b[0] - a[0]))
        share = (time - a[0]) / (b[0] - a[0]) if b[0] > a[0] else 1.0
        turn = math.remainder(b[3] - a[3], 2 * math.pi)
        x, y = (a[1:3] + share * (b[1:3] - a[1:3])).tolist()
        return x, y, float(a[3] + share * turn)

    def _note_gap(self, frame: str, gap: float) -> None:
        if gap > max(LONGEST_GAP, self._gaps.get(frame, 0.0)):
            self._gaps[frame] = gap

    def gaps(self) -> list[str]:
        """Returns which frames have no transforms for long, in words."""
        return [
            f"no transforms of the frame {frame!r} for up to {gap:.3g} s"
            for frame, gap in self._gaps.items()
        ]

    def moves(self, frame: str) -> Array | None:
        """Returns the times (s) of a frame's poses; None if it is unknown."""
        poses = self._poses.get(frame)
        return None if poses is None else poses[:, 0]


def plain(frame: str) -> str:
    """Returns the name of a frame without ROS 1's leading slash."""
    return str(frame).lstrip("/")


def moved(row: list[float], at: tuple[float, float, float]) -> list[float]:
    """Returns a row in another frame, given the pose of its own frame."""
    dx, dy, turn = at
    if dx == dy == turn == 0.0:
        return row
    x, y, yaw, vx, vy, omega, radius = row
    c, s = math.cos(turn), math.sin(turn)
    return [
        *(dx + c * x - s * y, dy + s * x + c * y, yaw + turn),
        *(c * vx - s * vy, s * vx + c * vy, omega, radius),
    ]
