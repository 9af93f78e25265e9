"""Draws overlays onto the pictures of a film."""

from collections.abc import Iterator, Sequence
import math
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw
from pydrake.geometry import Rgba

from hunav_drake.systems.common.arrays import Array, Mask
from hunav_drake.systems.common.layout import RADIUS, VX, VY, X, Y
from hunav_drake.systems.scene.bounds import figure_of
from hunav_drake.systems.scene.meshes import circle
from hunav_drake.systems.scene.overlays.tags import (
    BUBBLE_Z,
    CALM,
    CROWD,
    REACTING,
    ROBOT_TAG_Z,
    SPEECH,
    TAG_Z,
    Colors,
    activity_text,
    bubble_text,
    tag_lift,
    tag_picture,
    tag_text,
)
from hunav_drake.systems.scene.palette import (
    BODY_DISC,
    PROXEMIC_RINGS,
    REACTION,
    RECORDED,
    accent,
    top_of,
)
from hunav_drake.systems.scene.scene_config import (
    PROXEMIC_RADII,
    STANDING_SPEED,
    WALKED_TIME,
    Overlay,
)
from hunav_drake.systems.scene.surroundings import (
    GOAL_DOT,
    GOAL_WIDTH,
    goal_radius,
)
from hunav_drake.systems.world.solids import turned
from hunav_drake.views.film_scene import Shot
from hunav_drake.views.recorded_trial import RecordedTrial
from hunav_drake.views.replay import view_bounds

# The scale at which marks on the floor are drawn, for smooth edges.
_FINER = 2

# The steps of a walked path, in seconds, and its width, in meters.
_WALKED_STEP = 0.2
_WALKED_WIDTH = 0.07

# The heights of letters of tags and clock, relative to that of the picture.
_TAG_LETTERS, _CLOCK_LETTERS = 0.026, 0.04
_SMALLEST_LETTERS = 11

# The height of the middle of heads, and their radius, in meters, and how many
# heights of a tag it may be above its place.
_HEAD_Z, _HEAD, _FARTHEST = 1.6, 0.16, 4


class _Board(NamedTuple):
    """A text above a body: see `tag_picture`."""

    place: Array
    height: float
    text: str
    colors: Colors
    owner: Rgba | None
    person: int = -1


# Left, top, right and bottom, in pixels.
_Box = tuple[int, int, int, int]


class FilmOverlays:
    """Draws overlays of one trial."""

    def __init__(
        self, trial: RecordedTrial, overlays: Sequence[Overlay]
    ) -> None:
        """Takes a trial and its overlays; those not recorded are ignored."""
        self._trial = trial
        self._shown = frozenset(overlays)
        whole = view_bounds(trial.world, trial.humans, trial.robots)
        self._middle = whole.center

    def Draw(self, shot: Shot) -> Image.Image:
        """Returns a picture with the overlays on it."""
        picture = Image.fromarray(shot.image)
        floor = _FloorLayer(shot)
        reacts = self._trial.Reacts(shot.time)
        self._DrawDiscs(floor, shot, reacts)
        if "goals" in self._shown:
            self._DrawGoals(floor)
        if "walked" in self._shown:
            self._DrawWalked(floor, shot)
        if "rings" in self._shown:
            self._DrawRings(floor, shot)
        picture = floor.Onto(picture)
        self._DrawBoards(picture, shot, reacts)
        if "clock" in self._shown:
            _DrawClock(picture, shot.time)
        return picture

    def _DrawDiscs(
        self, floor: "_FloorLayer", shot: Shot, reacts: Mask
    ) -> None:
        sign = "reactions" in self._shown
        follows = self._trial.Follows(shot.time)
        for i, row in enumerate(shot.humans):
            if math.isnan(row[X]):
                continue
            at, radius = row[[X, Y]], row[RADIUS]
            floor.Fill(at + circle(radius, 40), BODY_DISC)
            if sign and (reacts[i] or follows[i]):
                color = REACTION if reacts[i] else RECORDED
                floor.Band(at, radius, radius + 0.09, color)

    def _DrawRings(self, floor: "_FloorLayer", shot: Shot) -> None:
        for row in shot.humans:
            if math.isnan(row[X]):
                continue
            for radius, color in zip(
                PROXEMIC_RADII, PROXEMIC_RINGS, strict=True
            ):
                floor.Band(row[[X, Y]], radius - 0.03, radius, color)

    def _DrawGoals(self, floor: "_FloorLayer") -> None:
        for i, human in enumerate(self._trial.humans):
            for goal in human.goals:
                place, r = np.array(goal[:2]), goal_radius(i)
                floor.Band(place, r - GOAL_WIDTH, r, top_of(i))
                dot = place + circle(GOAL_DOT, 24)
                floor.Fill(dot, top_of(i))
        head = np.array([[0.62, 0], [-0.30, 0.42], [-0.10, 0], [-0.30, -0.42]])
        for k, robot in enumerate(self._trial.robots.values()):
            if robot.goal is None:
                continue
            place, r = np.array(robot.goal[:2]), robot.radius
            floor.Band(place, 0.84 * r, r, accent(k))
            floor.Fill(turned(r * head, robot.goal), accent(k))

    def _DrawWalked(self, floor: "_FloorLayer", shot: Shot) -> None:
        ages = np.arange(0.0, WALKED_TIME, _WALKED_STEP)
        first = self._trial.recording.times[0]
        ages = ages[shot.time - ages >= first]
        if len(ages) < 2:
            return
        states = [self._trial.States(shot.time - age) for age in ages]
        rows = np.stack(
            [np.vstack([humans, robots]) for humans, robots in states]
        )
        n = len(self._trial.humans)
        for i in range(rows.shape[1]):
            color = top_of(i) if i < n else accent(i - n)
            places = rows[:, i, [X, Y]]
            for k in range(len(ages) - 1):
                rest = 1.0 - ages[k] / WALKED_TIME
                faded = Rgba(color.r(), color.g(), color.b(), 0.75 * rest)
                floor.Line(places[k], places[k + 1], _WALKED_WIDTH, faded)

    def _Boards(self, shot: Shot, reacts: Mask) -> Iterator[_Board]:
        """Yields the names of people and robots, and what people say."""
        signs = reacts & ("reactions" in self._shown)
        says = self._trial.Says(shot.time)
        words = self._trial.Activities(shot.time)
        crowd = np.isfinite(shot.humans[:, X]).sum() > CROWD
        for i, row in enumerate(shot.humans):
            place = row[[X, Y]]
            human = self._trial.humans[i]
            lift = tag_lift(human.figure.tall)
            if "names" in self._shown and not crowd:
                stands = math.hypot(row[VX], row[VY]) < STANDING_SPEED
                activity = activity_text(words[i], stands)
                if reacts[i] and not words[i]:
                    activity = "reacts"
                text = tag_text(human.name, human.behavior_name, activity)
                colors = REACTING if signs[i] else CALM
                yield _Board(place, TAG_Z + lift, text, colors, top_of(i), i)
            if "speech" in self._shown and says[i]:
                text = bubble_text(says[i])
                yield _Board(place, BUBBLE_Z + lift, text, SPEECH, top_of(i), i)
        for k, name in enumerate(self._trial.robots):
            if "names" in self._shown:
                text = tag_text(figure_of(name), "")
                owner = accent(k) if name else None
                place = shot.robots[k, [X, Y]]
                yield _Board(place, ROBOT_TAG_Z, text, CALM, owner)

    def _DrawBoards(
        self, picture: Image.Image, shot: Shot, reacts: Mask
    ) -> None:
        boards = [*self._Boards(shot, reacts)]
        if not boards:
            return
        tops = np.array([[*it.place, it.height] for it in boards])
        pixels, depth = shot.camera.Project(tops)
        letters = max(round(_TAG_LETTERS * picture.height), _SMALLEST_LETTERS)
        heads = self._Heads(shot)
        taken: list[_Box] = []
        middle = np.array([*self._middle, 0.0])
        reach = float(np.linalg.norm(shot.camera.X_WC.translation() - middle))
        # The nearest one is placed first.
        for i in np.argsort(depth):
            if not np.isfinite(pixels[i]).all():
                continue
            board = boards[i]
            tag = tag_picture(
                board.text, board.colors, letters, owner=board.owner
            )
            x, y = pixels[i]
            left, top = round(x - tag.width / 2), round(y - tag.height)
            if 0.0 <= x < picture.width:
                # Whole beside an edge.
                left = max(min(left, picture.width - tag.width), 0)
            lowest = top
            others = [box for k, box in heads if k != board.person]
            # Above those in the way, and above heads, but not far from its own.
            for box in sorted([*taken, *others], key=lambda box: -box[1]):
                if (
                    left < box[2]
                    and box[0] < left + tag.width
                    and top < box[3]
                    and box[1] < top + tag.height
                ):
                    top = box[1] - tag.height - 1
            if lowest - top > _FARTHEST * tag.height:
                continue
            taken.append((left, top, left + tag.width, top + tag.height))
            # Those behind fade.
            clear = float(np.clip(2.2 - depth[i] / reach, 0.45, 1.0))
            mask = tag.getchannel("A").point(lambda v, c=clear: round(c * v))
            picture.paste(tag, (left, top), mask)

    def _Heads(self, shot: Shot) -> list[tuple[int, _Box]]:
        """Returns people by their number, with a box around each head."""
        rows = shot.humans
        places = np.column_stack([rows[:, [X, Y]], np.full(len(rows), _HEAD_Z)])
        pixels, depth = shot.camera.Project(places)
        found: list[tuple[int, _Box]] = []
        for i, ((x, y), far) in enumerate(zip(pixels, depth, strict=True)):
            if np.isfinite([x, y]).all():
                r = _HEAD * shot.camera.focal_length / far
                box = (round(x - r), round(y - r), round(x + r), round(y + r))
                found.append((i, box))
        return found


class _FloorLayer:
    """The layer of marks on the floor, behind all objects on it."""

    def __init__(self, shot: Shot) -> None:
        self._shot = shot
        width, height = shot.camera.size
        self._size = (_FINER * width, _FINER * height)
        self._layer = Image.new("RGBA", self._size, (0, 0, 0, 0))

    def _Pixels(self, outline: Array) -> list[tuple[float, float]]:
        points = np.column_stack([outline, np.zeros(len(outline))])
        pixels, _ = self._shot.camera.Project(points)
        if not np.isfinite(pixels).all():
            return []
        # Pillow uses 32 bits; the exact place outside does not matter.
        limit = 20.0 * max(self._size)
        pixels = np.clip(_FINER * pixels, -limit, limit)
        return [(float(x), float(y)) for x, y in pixels]

    def _Add(self, outlines: Sequence[Array], color: Rgba) -> None:
        """Fills the first outline, except for holes, the other outlines."""
        shapes = [self._Pixels(outline) for outline in outlines]
        if not all(shapes):
            return
        points = np.vstack([np.array(shape) for shape in shapes])
        low = np.floor(np.maximum(points.min(axis=0) - 1, 0)).astype(int)
        high = np.ceil(np.minimum(points.max(axis=0) + 2, self._size)).astype(
            int
        )
        if np.any(high <= low):
            return
        mask = Image.new("L", (int(high[0] - low[0]), int(high[1] - low[1])))
        draw = ImageDraw.Draw(mask)
        for k, shape in enumerate(shapes):
            moved = [(x - low[0], y - low[1]) for x, y in shape]
            alpha = round(255 * color.a()) if k == 0 else 0
            draw.polygon(moved, fill=alpha)
        rgb = tuple(round(255 * c) for c in (color.r(), color.g(), color.b()))
        patch = Image.new("RGBA", mask.size, (*rgb, 0))
        patch.putalpha(mask)
        self._layer.alpha_composite(patch, (int(low[0]), int(low[1])))

    def Fill(self, outline: Array, color: Rgba) -> None:
        """Fills a polygon (k, 2) in W."""
        self._Add([outline], color)

    def Band(
        self, middle: Array, inner: float, outer: float, color: Rgba
    ) -> None:
        """Draws a ring around a point in W; lengths are in meters."""
        outlines = [middle + circle(r, 64) for r in (outer, inner)]
        self._Add(outlines, color)

    def Line(self, p: Array, q: Array, width: float, color: Rgba) -> None:
        """Draws a line between points in W, with a width in meters."""
        along = q - p
        length = float(np.hypot(*along))
        if not math.isfinite(length) or length < 1e-6:
            return
        across = np.array([-along[1], along[0]]) * (0.5 * width / length)
        self.Fill(
            np.array([p - across, q - across, q + across, p + across]), color
        )

    def Onto(self, picture: Image.Image) -> Image.Image:
        """Returns the picture with the layer on its floor."""
        if not (marked := self._layer.getbbox()):
            return picture
        left, top, right, bottom = marked
        left, top = left // _FINER, top // _FINER
        right, bottom = -(-right // _FINER), -(-bottom // _FINER)
        fine = (_FINER * left, _FINER * top, _FINER * right, _FINER * bottom)
        layer = self._layer.reduce(_FINER, fine)
        floor = self._shot.floor[top:bottom, left:right]
        alpha = np.asarray(layer.getchannel("A")) * floor
        picture.paste(layer.convert("RGB"), (left, top), Image.fromarray(alpha))
        return picture


def _DrawClock(picture: Image.Image, time: float) -> None:
    letters = max(round(_CLOCK_LETTERS * picture.height), _SMALLEST_LETTERS)
    tag = tag_picture(f"{time:.1f} s", CALM, letters)
    margin = round(0.5 * letters)
    picture.paste(tag, (margin, margin), tag)
