import math

import numpy as np
import pytest

from hunav_drake.validation.cases import CASES
from hunav_drake.validation.plots import (
    PLOTS,
    plot_counterflow,
    plot_door_flow,
    plot_lanes,
    plot_speeds,
)


def line_of(ax, label):
    (line,) = [it for it in ax.get_lines() if it.get_label() == label]
    return line


def test_speeds_stand_beside_those_of_weidmann():
    measured = {"a": {"density": [1, 2], "speed": [1.2, 0.7]}}
    ax = plot_speeds(measured)
    assert line_of(ax, "a").get_xydata().tolist() == [[1, 1.2], [2, 0.7]]
    x, y = line_of(ax, "Weidmann").get_xydata().T
    assert np.interp(2.0, x, y) == pytest.approx(0.61, abs=0.01)


def test_flows_stand_beside_those_of_people():
    measured = {
        name: {"width": [1, 2], "flow": [1.5, flow]}
        for name, flow in (("a", 1.7), ("b", 5.0))
    }
    ax = plot_door_flow(measured)
    assert line_of(ax, "b").get_ydata().tolist() == [1.5, 5.0]
    assert line_of(ax, "a").get_color() != line_of(ax, "b").get_color()
    (band,) = ax.patches
    assert (band.get_y(), band.get_height()) == pytest.approx((1.6, 0.6))


def test_who_never_crosses_is_a_cross():
    measured = {"a": {"against": [0, 50, 100], "time": [30, 60, math.inf]}}
    ax = plot_counterflow(measured)
    assert line_of(ax, "a").get_ydata().tolist() == [30, 60]
    (cross,) = [it for it in ax.get_lines() if it.get_marker() == "x"]
    assert cross.get_xdata().tolist() == [100]


def test_lanes_show_each_crowd_in_the_corridor():
    numbers = {"order": 0.5, "x": [1.0, -2, 20, 40], "y": [1.0, 1, 2, 2]}
    ax = plot_lanes({"_a$": numbers, "b": numbers})
    right = [it for it in ax.get_lines() if it.get_marker() == ">"]
    left = [it for it in ax.get_lines() if it.get_marker() == "<"]
    # Those beyond the ends are not drawn.
    assert [len(it.get_xdata()) for it in right + left] == [1, 1, 1, 1]
    assert [text.get_text() for text in ax.texts] == [
        "_a$: order 0.50",
        "b: order 0.50",
    ]


def test_every_plot_is_of_a_case():
    assert {plot.case for plot in PLOTS} <= set(CASES)
