"""Plots of forces."""

import matplotlib as mpl

mpl.use("Agg")

from matplotlib.colors import to_rgb
import matplotlib.pyplot as plt
from matplotlib.quiver import Quiver
import numpy as np
import pytest

from hunav_drake.report.plots import plot_forces
from hunav_drake.report.plots.forces import _COLORS
from hunav_drake.systems.common.layout import FORCES
from hunav_drake.systems.world.obstacles import Obstacles

STATES = np.array(
    [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.3], [2.0, 1.0, np.pi, 0, 0, 0, 0.4]]
)


def make_forces(n=2, **values):
    forces = np.zeros((n, len(FORCES), 2))
    for name, vectors in values.items():
        forces[:, FORCES.index(name)] = vectors
    return forces.reshape(n, -1)


def arrows_by_name(ax):
    """The arrows' ends less their beginnings, by their names."""
    quivers = [c for c in ax.collections if isinstance(c, Quiver)]
    return {
        quiver.get_label(): (
            np.stack([quiver.X, quiver.Y], axis=-1),
            np.stack([quiver.U, quiver.V], axis=-1) / quiver.scale,
        )
        for quiver in quivers
    }


def test_each_force_is_an_arrow_of_its_length():
    forces = make_forces(goal=[[1, 0], [0, 2]], total=[[1, 0], [0, 2]])
    drawn = arrows_by_name(plot_forces(forces, STATES, scale=0.5))
    assert set(drawn) == {"goal", "total"}
    for centers, vectors in drawn.values():
        np.testing.assert_allclose(centers, STATES[:, :2])
        np.testing.assert_allclose(vectors, [[0.5, 0], [0, 1]])


def test_what_does_not_push_is_not_drawn():
    forces = make_forces(social=[[0.0, 0.0], [1.0, 0.0]])
    drawn = arrows_by_name(plot_forces(forces, STATES))
    np.testing.assert_allclose(drawn["social"][0], STATES[1:, :2])


def test_all_forces_are_named_in_the_legend():
    forces = make_forces(**{name: [1.0, 1.0] for name in FORCES})
    ax = plot_forces(forces.ravel(), STATES.ravel(), robot_state=STATES[0])
    texts = {text.get_text() for text in ax.get_legend().get_texts()}
    assert texts == {
        *(name.replace("_", " ") for name in FORCES),
        "person",
        "robot",
    }
    assert "m/s²" in ax.get_legend().get_title().get_text()
    assert ax.get_xlabel() == "x (m)"


def test_everything_is_inside_the_axes():
    forces = make_forces(goal=[[9.0, 0.0], [0.0, -9.0]])
    wall = Obstacles.from_shapes([[[-3, -1], [-3, 1]]], solid=[False])
    ax = plot_forces(forces, STATES, obstacles=wall)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    assert left <= -3
    assert right >= 3.6
    assert bottom <= 1.0 - 3.6
    assert top >= 1.4


def test_it_draws_where_it_is_told():
    _, ax = plt.subplots()
    assert plot_forces(make_forces(goal=[1.0, 0.0]), STATES, ax=ax) is ax


def test_a_new_figure_is_as_wide_as_two_columns():
    ax = plot_forces(make_forces(goal=[1.0, 0.0]), STATES)
    assert ax.figure.get_figwidth() == 6.8


def test_nobody_is_an_empty_plot():
    ax = plot_forces(np.zeros((0, 16)), np.zeros((0, 7)))
    assert arrows_by_name(ax) == {}
    ax.figure.canvas.draw()


def test_the_colors_differ_for_color_blind_people_too():
    # Where red and green look the same, what is left of a color is about
    # their mean, and blue.
    seen = np.array(
        [
            [(r + g) / 2, b]
            for r, g, b in (to_rgb(_COLORS[name]) for name in FORCES)
        ]
    )
    gaps = np.hypot(*(seen[:, None] - seen[None]).T)
    np.fill_diagonal(gaps, 1.0)
    assert gaps.min() > 0.05


@pytest.mark.parametrize(
    ("forces", "states", "message"),
    [
        (
            np.zeros((1, 16)),
            STATES,
            "must be for as many people as human_states",
        ),
        (np.zeros(15), STATES, "forces must hold rows of 16 numbers"),
        (np.zeros((2, 16)), STATES[:, :6], "human_states must hold rows of 7"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(forces, states, message):
    with pytest.raises(ValueError, match=message):
        plot_forces(forces, states)


def test_a_scale_that_is_not_positive_is_refused():
    with pytest.raises(ValueError, match="scale must be positive, got 0"):
        plot_forces(make_forces(), STATES, scale=0)
