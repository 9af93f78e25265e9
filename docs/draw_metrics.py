"""Draws what the families of metrics measure: docs/metrics_*.svg.

Run it with `python docs/draw_metrics.py`.
"""

from collections.abc import Callable
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Wedge
import matplotlib.pyplot as plt
import numpy as np

FOLDER = Path(__file__).parent

ROBOT, PERSON, WALL, MARK = ("#222222", "#0072b2", "#999999", "#d55e00")
DRAWINGS: dict[str, Callable[[Axes], None]] = {}


def drawing(family: str) -> Callable[..., Callable[[Axes], None]]:
    """Returns a decorator that registers the drawing of a family."""

    def register(draw: Callable[[Axes], None]) -> Callable[[Axes], None]:
        DRAWINGS[family] = draw
        return draw

    return register


def disc(
    axes: Axes,
    place: tuple[float, float],
    color: str,
    *,
    yaw: float = 0.0,
    radius: float = 0.3,
    alpha: float = 1.0,
) -> None:
    """Draws a robot or a person from above, with the way they look."""
    axes.add_patch(Circle(place, radius, color=color, alpha=alpha, lw=0))
    nose = (place[0] + radius * np.cos(yaw), place[1] + radius * np.sin(yaw))
    axes.plot(*zip(place, nose, strict=True), color="white", lw=1.5)


def arrow(
    axes: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    color: str = MARK,
    both: bool = False,
) -> None:
    """Draws an arrow, or a measure with two heads."""
    style = "<|-|>" if both else "-|>"
    axes.add_patch(
        FancyArrowPatch(
            start,
            end,
            arrowstyle=style,
            mutation_scale=11,
            color=color,
            lw=1.4,
            shrinkA=0,
            shrinkB=0,
        )
    )


def note(axes: Axes, x: float, y: float, text: str, color: str = MARK) -> None:
    """Writes a name beside what it names."""
    axes.text(x, y, text, color=color, ha="center", va="center", fontsize=10)


def path(axes: Axes) -> np.ndarray:
    """Draws a robot's path with its samples; returns these, (n, 2)."""
    x = np.linspace(0, 6, 13)
    y = 0.9 * np.exp(-((x - 3) ** 2))
    axes.plot(x, y, ".-", color=ROBOT, ms=5, lw=1.2)
    return np.column_stack([x, y])


@drawing("goal")
def draw_goal(axes: Axes) -> None:
    """A robot that comes near its goal, and ends beside it."""
    x = np.linspace(0, 5.6, 60)
    y = 0.35 * np.sin(0.9 * x)
    axes.plot(x, y, color=ROBOT, lw=1.2)
    disc(axes, (x[-1], y[-1]), ROBOT)
    goal = (5.0, 0.55)
    axes.add_patch(Circle(goal, 0.5, fill=False, ls="--", color=MARK))
    axes.plot(*goal, "*", color=MARK, ms=11)
    k = np.argmin(np.hypot(x - goal[0], y - goal[1]))
    arrow(axes, (x[k], y[k]), goal, both=True)
    note(axes, 3.3, 0.85, "min_dist_to_target")
    arrow(axes, (x[-1], y[-1]), goal, both=True)
    note(axes, 7.2, 0.1, "final_dist_to_target")
    note(axes, 0.1, 0.35, "p_0", ROBOT)


@drawing("path")
def draw_path(axes: Axes) -> None:
    """Steps between samples, and the turn at one of them."""
    points = path(axes)
    arrow(axes, tuple(points[3]), tuple(points[4]))
    note(axes, 1.2, 0.75, "|p_{k+1} - p_k|")
    bend = points[6]
    axes.plot(
        [bend[0], bend[0] + 0.9], [bend[1], bend[1] + 0.12], ":", color=MARK
    )
    axes.add_patch(Wedge(bend, 0.75, -20, 8, color=MARK, alpha=0.3, lw=0))
    note(axes, 5.2, 1.0, "wrap(yaw_{k+1} - yaw_k)")
    disc(axes, tuple(points[-1]), ROBOT, radius=0.22)


@drawing("proxemics")
def draw_proxemics(axes: Axes) -> None:
    """The spaces around a person, measured from surface to surface."""
    spaces = ((3.6, "social"), (1.2, "personal"), (0.45, "intimate"))
    for (reach, name), alpha in zip(spaces, (0.1, 0.2, 0.4), strict=True):
        axes.add_patch(Circle((0, 0), 0.3 + reach, color=PERSON, alpha=alpha))
        axes.plot([0, 5.2], [0.3 + reach] * 2, ":", color=PERSON, lw=0.8)
        note(axes, 7.6, 0.3 + reach, f"{name}, up to {reach} m", PERSON)
    disc(axes, (0, 0), PERSON)
    disc(axes, (2.6, -1.0), ROBOT, yaw=2.0, radius=0.35)
    away = np.array([2.6, -1.0]) / np.hypot(2.6, 1.0)
    arrow(
        axes,
        tuple(0.3 * away),
        tuple(np.array([2.6, -1.0]) - 0.35 * away),
        both=True,
    )
    note(axes, 1.55, -0.25, "gap")


@drawing("collisions")
def draw_collisions(axes: Axes) -> None:
    """Who is charged with a contact: who moves into the other."""
    for x, who, names in (
        (0.0, ROBOT, "robot_on_person"),
        (4.5, PERSON, "person_on_robot"),
    ):
        disc(axes, (x, 0), ROBOT, radius=0.35)
        disc(axes, (x + 0.62, 0), PERSON, yaw=np.pi)
        start, end = (x - 1.4, x - 0.4) if who == ROBOT else (x + 2, x + 1)
        arrow(axes, (start, 0), (end, 0), color=who)
        note(axes, x + 0.3, 0.65, names)


@drawing("speeds")
def draw_speeds(axes: Axes) -> None:
    """The speed over time: its mean, slopes, and where it is zero."""
    t = np.linspace(0, 8, 33)
    v = 0.6 * np.clip(np.minimum(t, 8 - t), 0, 1) - 0.6 * np.exp(
        -((t - 4.5) ** 6)
    )
    v = np.maximum(v, 0)
    axes.plot(t, 2 * v, ".-", color=ROBOT, ms=4)
    axes.plot([0, 8], [2 * v.mean()] * 2, "--", color=MARK)
    note(axes, 10.2, 2 * v.mean(), "mean: avg_robot_linear_speed")
    arrow(axes, (0.1, 0.1), (0.9, 1.05))
    note(axes, -0.1, 0.45, "a_k")
    arrow(axes, (3.8, -0.12), (5.2, -0.12), both=True)
    note(axes, 4.5, -0.32, "time_not_moving")
    note(axes, 7.9, -0.2, "t", ROBOT)


@drawing("forces")
def draw_forces(axes: Axes) -> None:
    """The forces of robot, person and wall on each other."""
    disc(axes, (0, 0), ROBOT, radius=0.35)
    disc(axes, (2.6, 0.5), PERSON, yaw=np.pi)
    axes.fill([-1, 4.5, 4.5, -1], [1.6, 1.6, 1.8, 1.8], color=WALL)
    arrow(axes, (-0.35, -0.07), (-1.5, -0.3))
    note(axes, -1.4, -0.55, "on the robot: f^{i->r}")
    arrow(axes, (2.9, 0.56), (4.05, 0.78))
    note(axes, 4.2, 0.45, "on the person: f^{r->i}")
    arrow(axes, (2.6, 0.2), (2.6, -0.5))
    note(axes, 3.7, -0.35, "of the wall: f^{o->i}")


@drawing("efficiency")
def draw_efficiency(axes: Axes) -> None:
    """The path driven, and the shortest one around the wall."""
    axes.fill([2.5, 3.5, 3.5, 2.5], [-1.0, -1.0, 0.5, 0.5], color=WALL)
    # Tangents, and arcs of the robot's radius around the corners of the wall.
    up = np.arctan2(0.5, 2.5) + np.arcsin(0.25 / np.hypot(2.5, 0.5))
    arc = np.linspace(np.pi / 2 + up, np.pi / 2, 12)
    left = np.array([2.5, 0.5]) + 0.25 * np.column_stack(
        [np.cos(arc), np.sin(arc)]
    )
    right = ([6, 0] + left * [-1, 1])[::-1]
    shortest = np.vstack([[0, 0], left, right, [6, 0]])
    axes.plot(*shortest.T, "--", color=MARK)
    x = np.linspace(0, 6, 60)
    axes.plot(
        x,
        1.75 * np.exp(-((x - 3) ** 2) / 2.5) * np.sin(np.pi * x / 6),
        color=ROBOT,
    )
    note(axes, 4.9, 1.35, "L: driven", ROBOT)
    note(axes, 1.1, 0.75, "L*: shortest")
    axes.plot(6, 0, "*", color=MARK, ms=11)
    disc(axes, (0, 0), ROBOT, radius=0.25)


@drawing("clearance")
def draw_clearance(axes: Axes) -> None:
    """The gap between the robot's disc and the nearest wall."""
    axes.fill([-1, 6, 6, -1], [-0.9, -0.9, -0.7, -0.7], color=WALL)
    axes.fill([3, 3.8, 3.8, 3], [0.9, 0.9, 1.5, 1.5], color=WALL)
    x = np.linspace(-0.5, 5.5, 50)
    axes.plot(x, 0.15 * np.sin(x), color=ROBOT, lw=1.2)
    disc(axes, (1.6, 0.15), ROBOT, radius=0.35)
    arrow(axes, (1.6, -0.2), (1.6, -0.7), both=True)
    note(axes, 1.95, -0.45, "c_k")


@drawing("comparison")
def draw_comparison(axes: Axes) -> None:
    """A path and its reference, at equal times."""
    points = path(axes)
    other = np.column_stack([points[:, 0], 0.3 * np.sin(points[:, 0]) - 0.3])
    axes.plot(*other.T, ".--", color=PERSON, ms=5)
    for k in (4, 6, 8):
        arrow(axes, tuple(points[k]), tuple(other[k]), both=True)
    arrow(axes, tuple(points[-1]), tuple(other[-1]), both=True)
    note(axes, 6.5, -0.1, "FDE")
    note(axes, 3.0, 1.15, "ADE: the mean of these")
    note(axes, 1.0, -0.35, "reference q", PERSON)


@drawing("contacts")
def draw_contacts(axes: Axes) -> None:
    """Bodies that touch: closing speeds along n, force, impulse."""
    disc(axes, (0, 0), ROBOT, radius=0.4)
    disc(axes, (0.7, 0), PERSON, yaw=np.pi)
    arrow(axes, (0.4, 0.6), (1.2, 0.6), color=ROBOT)
    note(axes, 0.8, 0.8, "n", ROBOT)
    arrow(axes, (-1.5, 0), (-0.45, 0), color=ROBOT)
    note(axes, -1.0, 0.22, "a = v_r . n", ROBOT)
    arrow(axes, (2.0, 0), (1.05, 0), color=PERSON)
    note(axes, 1.7, 0.22, "b = -v_i . n", PERSON)
    t = np.linspace(0, 2.5, 80)
    force = 1.1 * np.exp(-((t - 1) ** 2) / 0.08)
    axes.fill_between(t + 3.2, force - 0.4, -0.4, color=MARK, alpha=0.3)
    axes.plot(t + 3.2, force - 0.4, color=MARK)
    note(axes, 5.7, 0.6, "max_contact_force")
    note(axes, 4.2, -0.6, "contact_impulse: the area")


@drawing("danger")
def draw_danger(axes: Axes) -> None:
    """Relative place and velocity, and at what distance they would pass."""
    disc(axes, (0, 0), ROBOT, radius=0.35)
    disc(axes, (4, 0.9), PERSON, yaw=np.pi)
    arrow(axes, (0, 0), (4, 0.9), color=WALL)
    note(axes, 2.0, 0.75, "P", "#666666")
    arrow(axes, (0, 0), (2.2, 0))
    note(axes, 1.4, -0.25, "V: of the robot, relative")
    axes.plot([0, 5], [0, 0], ":", color=MARK)
    arrow(axes, (4, 0), (4, 0.6), both=True)
    note(axes, 4.75, 0.3, "d = |P| |sin a|")


@drawing("surprise")
def draw_surprise(axes: Axes) -> None:
    """A person, where they look, and the robot at the edge of it."""
    axes.add_patch(Wedge((0, 0), 4, -60, 60, color=PERSON, alpha=0.12, lw=0))
    disc(axes, (0, 0), PERSON)
    axes.plot([0, 4], [0, 0], "--", color=PERSON)
    disc(axes, (2.2, 2.0), ROBOT, yaw=-1.8, radius=0.35)
    arrow(axes, (0, 0), (1.95, 1.77), both=True)
    note(axes, 0.85, 1.15, "d")
    axes.add_patch(Wedge((0, 0), 1.1, 0, 42, color=MARK, alpha=0.3, lw=0))
    note(axes, 1.35, 0.4, "a")
    note(axes, 4.5, 0.35, "in view: 120 deg", PERSON)
    note(axes, 6.3, 2.0, "t since it came into view", ROBOT)


def main() -> None:
    """Draws all families."""
    plt.rcParams["svg.hashsalt"] = "metrics"
    for family, draw in DRAWINGS.items():
        figure, axes = plt.subplots(figsize=(6.4, 2.4), layout="constrained")
        draw(axes)
        axes.set(aspect="equal")
        axes.margins(0.08)
        axes.set_axis_off()
        axes.autoscale_view()
        figure.savefig(
            FOLDER / f"metrics_{family}.svg",
            metadata={"Date": None},
            facecolor="white",
        )
        plt.close(figure)


if __name__ == "__main__":
    main()
