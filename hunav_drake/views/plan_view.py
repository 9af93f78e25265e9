"""Drawings of a recorded trial from above."""

from collections.abc import Sequence
import math

import numpy as np
from PIL import Image

from hunav_drake.systems.common.layout import RADIUS, VX, VY, YAW, X, Y
from hunav_drake.systems.scene.bounds import figure_of
from hunav_drake.systems.scene.overlays.tags import (
    activity_text,
    bubble_text,
    tag_text,
)
from hunav_drake.systems.scene.palette import REACTION, RECORDED, TOPS, accent
from hunav_drake.systems.scene.plan_walls import draw_walls
from hunav_drake.systems.scene.scene_config import (
    PROXEMIC_RADII,
    STANDING_SPEED,
    WALKED_TIME,
    Overlay,
)
from hunav_drake.systems.world.solids import turned
from hunav_drake.views.recorded_trial import RecordedTrial
from hunav_drake.views.replay import view_bounds

_DPI = 100
_WALKED_STEP = 0.2

# The arrowhead on a robot of radius 1.
_HEAD = np.array([[0.62, 0], [-0.30, 0.42], [-0.10, 0], [-0.30, -0.42]])


class PlanView:
    """Draws one trial from above with Matplotlib."""

    def __init__(
        self,
        trial: RecordedTrial,
        overlays: Sequence[Overlay],
        size: tuple[int, int],
    ) -> None:
        """Takes a trial, its overlays, and the size of a picture in pixels.

        Overlays that are not recorded are ignored.
        """
        # Not pyplot, which keeps all figures, and needs a screen.
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self._trial = trial
        self._shown = frozenset(overlays)
        figure = Figure((size[0] / _DPI, size[1] / _DPI), dpi=_DPI)
        self._canvas = FigureCanvasAgg(figure)
        self._ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        # As large as possible, with equal scales along x and y.
        bounds = view_bounds(trial.world, trial.humans, trial.robots)
        scale = max(b / s for b, s in zip(bounds.size, size, strict=True))
        self._limits = [
            (middle - scale * pixels / 2, middle + scale * pixels / 2)
            for middle, pixels in zip(bounds.center, size, strict=True)
        ]

    def Draw(self, time: float) -> Image.Image:
        """Returns the picture of a time, in seconds."""
        ax, trial = self._ax, self._trial
        ax.clear()
        ax.set_axis_off()
        (x_min, x_max), (y_min, y_max) = self._limits
        ax.set(xlim=(x_min, x_max), ylim=(y_min, y_max))
        draw_walls(ax, trial.world.obstacles())
        humans, robots = trial.States(time)
        if "goals" in self._shown:
            self._DrawGoals()
        if "walked" in self._shown:
            self._DrawWalked(time)
        reacts, follows = trial.Reacts(time), trial.Follows(time)
        says, words = trial.Says(time), trial.Activities(time)
        for i, row in enumerate(humans):
            if not math.isnan(row[X]):
                color = REACTION if reacts[i] else RECORDED
                sign = color.rgba if reacts[i] or follows[i] else None
                stands = math.hypot(row[VX], row[VY]) < STANDING_SPEED
                does = activity_text(words[i], stands)
                if reacts[i] and not words[i]:
                    does = "reacts"
                self._DrawPerson(i, row, sign, says[i], does)
        for k, (name, row) in enumerate(zip(trial.robots, robots, strict=True)):
            self._DrawRobot(row, accent(k).rgba)
            if "names" in self._shown:
                self._DrawName(row, figure_of(name))
        if "clock" in self._shown:
            style = {"transform": ax.transAxes, "va": "top", "fontsize": 13}
            board = {"fc": "white", "ec": "none", "alpha": 0.85, "pad": 3}
            ax.text(0.015, 0.98, f"{time:.1f} s", zorder=9, bbox=board, **style)
        self._canvas.draw()
        return Image.fromarray(np.asarray(self._canvas.buffer_rgba())).convert(
            "RGB"
        )

    def _DrawGoals(self) -> None:
        for i, human in enumerate(self._trial.humans):
            for x, y, *_ in human.goals:
                color = TOPS[i % len(TOPS)].rgba
                self._ax.plot(x, y, "x", color=color, ms=7, mew=2, zorder=3)
        for k, robot in enumerate(self._trial.robots.values()):
            if robot.goal is not None:
                color = accent(k).rgba
                place = robot.goal[:2]
                self._ax.plot(*place, "*", color=color, ms=14, zorder=3)

    def _DrawWalked(self, time: float) -> None:
        from matplotlib.collections import LineCollection

        ages = np.arange(0.0, WALKED_TIME, _WALKED_STEP)
        ages = ages[time - ages >= self._trial.recording.times[0]]
        if len(ages) < 2:
            return
        states = [self._trial.States(time - age) for age in ages]
        rows = np.stack([np.vstack([h, r]) for h, r in states])
        n = len(self._trial.humans)
        for i in range(rows.shape[1]):
            color = TOPS[i % len(TOPS)] if i < n else accent(i - n)
            places = rows[:, i, [X, Y]]
            segments = np.stack([places[:-1], places[1:]], axis=1)
            fade = 1.0 - ages[:-1] / WALKED_TIME
            colors = [(color.r(), color.g(), color.b(), a) for a in fade]
            self._ax.add_collection(
                LineCollection(segments, colors=colors, lw=2, zorder=4)
            )

    def _DrawPerson(
        self,
        i: int,
        row: np.ndarray,
        sign: Sequence[float] | None,
        says: str,
        does: str,
    ) -> None:
        from matplotlib.patches import Circle

        place = row[[X, Y]]
        if sign is not None and "reactions" in self._shown:
            line = {"fill": False, "ec": sign, "lw": 2.5, "zorder": 5}
            self._ax.add_patch(Circle(place, row[RADIUS] + 0.08, **line))
        self._DrawBody(row, TOPS[i % len(TOPS)].rgba)
        if "rings" in self._shown:
            line = {"fill": False, "ec": "0.6", "lw": 0.8, "ls": ":"}
            for radius in PROXEMIC_RADII:
                self._ax.add_patch(Circle(place, radius, zorder=2, **line))
        lines = []
        if says and "speech" in self._shown:
            lines.append(bubble_text(says))
        if "names" in self._shown:
            human = self._trial.humans[i]
            lines.append(tag_text(human.name, human.behavior_name, does))
        if lines:
            self._DrawName(row, "\n".join(lines))

    def _DrawName(self, row: np.ndarray, text: str) -> None:
        """Writes a text above a body, whole beside an edge."""
        x, y = row[[X, Y]] + [0.0, row[RADIUS] + 0.1]
        written = self._ax.annotate(
            text,
            (x, y),
            ha="center",
            va="bottom",
            fontsize=8,
            parse_math=False,
            annotation_clip=True,
            zorder=8,
        )
        box = written.get_window_extent(self._canvas.get_renderer())
        width = self._canvas.get_width_height()[0]
        outside = max(box.x1 - width, 0.0) + min(box.x0, 0.0)
        x_min, x_max = self._limits[0]
        written.set_x(x - outside * (x_max - x_min) / width)

    def _DrawBody(self, row: np.ndarray, color: Sequence[float]) -> None:
        """Draws a person's disc with its heading."""
        from matplotlib.patches import Circle

        place, radius = row[[X, Y]], row[RADIUS]
        self._ax.add_patch(
            Circle(place, radius, fc=color, ec="0.15", lw=0.8, zorder=5)
        )
        nose = place + radius * np.array(
            [math.cos(row[YAW]), math.sin(row[YAW])]
        )
        self._ax.plot(
            *np.column_stack([place, nose]), color="0.1", lw=2, zorder=5
        )

    def _DrawRobot(self, row: np.ndarray, color: Sequence[float]) -> None:
        """Draws a white disc with an arrowhead, as in other views."""
        from matplotlib.patches import Circle, Polygon

        place, radius = row[[X, Y]], row[RADIUS]
        self._ax.add_patch(
            Circle(place, radius, fc="white", ec=color, lw=2, zorder=6)
        )
        pose = (row[X], row[Y], row[YAW])
        head = turned(radius * _HEAD, pose)
        self._ax.add_patch(Polygon(head, fc=color, ec="none", zorder=6))
