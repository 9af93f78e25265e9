"""Plots of trials, and of comparisons."""

from dataclasses import replace

import matplotlib as mpl

mpl.use("Agg")

from matplotlib.container import ErrorbarContainer
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest

import hunav_drake
from hunav_drake.report.plots import (
    find_approaches,
    plot_behavior_activity,
    plot_comparison,
    plot_costmap,
    plot_distance_to_people,
    plot_robot_speed,
    plot_trajectories,
    plot_zones,
)
from hunav_drake.report.plots.style import shown
from hunav_drake.runs.statistics import summarize
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.world.maps.costs import NO_MAP, Costmap
from hunav_drake.systems.world.obstacles import Obstacles
from tests.hunav_drake.passing_trials import make_recording, make_result


def drive_by(xs=(-3.0, 3.0), *, y=1.5, samples=61, **kwargs):
    """Returns a recording of 6 s, with a person at each x on the left."""
    return make_recording(xs, y=y, samples=samples, start=-3.0, **kwargs)


def two_robots():
    """Returns a recording in which bob drives behind anna, and ends at 4 s."""
    first = drive_by((0.0,))
    rows = first.robot - [1.0, 0, 0, 0, 0, 0, 0]
    second = replace(first, robot=rows, robot_name="bob", end_time=4.0)
    return replace(first, robot_name="anna", others=(second,))


@pytest.mark.parametrize("plot", [plot_distance_to_people, plot_robot_speed])
def test_each_robot_has_a_line_until_its_end(plot):
    ax = plot(two_robots())
    lines = {line.get_label(): line for line in ax.get_lines()}
    assert lines["anna"].get_xdata()[-1] == 6.0
    assert lines["bob"].get_xdata()[-1] == 4.0
    assert lines["anna"].get_color() != lines["bob"].get_color()


def test_each_robot_has_a_path_and_a_bar():
    recording = two_robots()
    assert {"anna", "bob"} <= set(legend_texts(plot_trajectories(recording)))
    labels = plot_zones(recording).get_yticklabels()
    assert [it.get_text() for it in labels] == ["anna", "bob"]
    several = plot_zones({"a": recording, "b": drive_by()}).get_yticklabels()
    assert [it.get_text() for it in several] == ["a, anna", "a, bob", "b"]


def artists(ax, gid):
    return [a for a in ax.get_children() if a.get_gid() == gid]


def legend_texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


ALL_OF_ONE = [
    plot_behavior_activity,
    plot_distance_to_people,
    plot_robot_speed,
    plot_trajectories,
    plot_zones,
]


@pytest.mark.parametrize("plot", ALL_OF_ONE)
@pytest.mark.parametrize(
    "recording",
    [
        drive_by(),
        drive_by(()),
        drive_by(samples=1),
        drive_by((), samples=1),
        drive_by(range(12), human_names=[f"$_{i}^{{" for i in range(12)]),
    ],
    ids=["two people", "nobody", "one sample", "nobody, one sample", "many"],
)
def test_every_plot_can_be_drawn(plot, recording):
    ax = plot(recording)
    ax.figure.canvas.draw()
    assert "(" in ax.get_xlabel()
    assert ax.figure.get_figwidth() == 3.4


@pytest.mark.parametrize("plot", ALL_OF_ONE)
def test_no_plot_needs_a_new_figure(plot):
    figure, ax = plt.subplots()
    assert plot(make_result(drive_by()), ax=ax) is ax
    assert plt.get_fignums() == [figure.number]


@pytest.mark.parametrize("plot", ALL_OF_ONE)
def test_what_is_no_run_is_refused(plot):
    with pytest.raises(TypeError, match="got float"):
        plot([1.0])
    for nothing in ([], {}):
        with pytest.raises(ValueError, match="there are no runs to draw"):
            plot(nothing)


@pytest.mark.parametrize(
    ("plot", "xlabel", "ylabel"),
    [
        (plot_distance_to_people, "time (s)", "distance to closest person (m)"),
        (plot_robot_speed, "time (s)", "robot speed (m/s)"),
        (plot_trajectories, "x (m)", "y (m)"),
        (plot_zones, "share of time (%)", ""),
        (plot_behavior_activity, "time (s)", ""),
    ],
)
def test_axes_have_units(plot, xlabel, ylabel):
    ax = plot(drive_by())
    assert ax.get_xlabel() == xlabel
    assert ax.get_ylabel() == ylabel


def test_the_distance_is_that_between_surfaces():
    recording = drive_by((0.0,))
    line = next(
        line
        for line in plot_distance_to_people(recording).get_lines()
        if len(line.get_xdata()) == 61
    )
    np.testing.assert_array_equal(line.get_xdata(), recording.times)
    np.testing.assert_allclose(
        line.get_ydata(), np.hypot(recording.times - 3.0, 1.5) - 0.6
    )


def test_each_approach_has_its_minimum():
    ax = plot_distance_to_people(drive_by((-2.0, 2.0)))
    (minima,) = artists(ax, "minima")
    np.testing.assert_allclose(minima.get_xdata(), [1.0, 5.0])
    np.testing.assert_allclose(minima.get_ydata(), [0.9, 0.9])
    assert [t.get_text() for t in ax.texts] == ["0.90 m", "0.90 m"]


def test_the_minimum_of_who_is_behind_another_is_not_on_the_line():
    recording = drive_by((0.0, 0.0))
    humans = recording.humans.copy()
    humans[:, 1, 1] = -1.7
    behind = Recording(
        times=recording.times, robot=recording.robot, humans=humans
    )
    (minima,) = artists(plot_distance_to_people(behind), "minima")
    np.testing.assert_allclose(minima.get_ydata(), [0.9])
    assert len(find_approaches(behind)) == 2


def test_an_approach_lasts_while_the_person_is_near():
    # Within 1.2 m from surface to surface is within 1.8 m of the centers.
    (approach,) = find_approaches(drive_by((0.0,)))
    half = np.sqrt(1.8**2 - 1.5**2)
    assert approach.start == pytest.approx(3.0 - half, abs=0.1)
    assert approach.end == pytest.approx(3.0 + half, abs=0.1)
    assert approach.time == pytest.approx(3.0)
    assert approach.gap == pytest.approx(0.9)


def test_who_comes_twice_is_met_twice():
    recording = drive_by((-2.0,))
    humans = recording.humans.copy()
    humans[40:, 0, 0] = 2.0
    humans[30:40] = np.nan
    twice = find_approaches(
        Recording(times=recording.times, robot=recording.robot, humans=humans)
    )
    assert [e.person for e in twice] == [0, 0]
    assert [e.time for e in twice] == pytest.approx([1.0, 5.0])


@pytest.mark.parametrize("near", [0.0, -1.0, np.nan])
def test_near_must_be_positive(near):
    for function in (
        find_approaches,
        plot_distance_to_people,
        plot_robot_speed,
    ):
        with pytest.raises(ValueError, match="near must be positive"):
            function(drive_by(), near=near)


def test_the_time_with_a_person_near_is_shaded():
    ax = plot_robot_speed(drive_by((0.0,)), near=1.9)
    (span,) = artists(ax, "near")
    half = np.sqrt(2.5**2 - 1.5**2)
    bounds = span.get_extents().transformed(ax.transData.inverted())
    assert bounds.x0 == pytest.approx(3.0 - half, abs=0.11)
    assert bounds.x1 == pytest.approx(3.0 + half, abs=0.11)
    assert "person within 1.9 m" in legend_texts(ax)
    (line,) = ax.get_lines()
    np.testing.assert_allclose(line.get_ydata(), 1.0)


def test_a_robot_that_backs_up_has_a_speed_below_zero():
    recording = drive_by()
    robot = recording.robot.copy()
    robot[:, 2] = np.pi
    ax = plot_robot_speed(
        Recording(times=recording.times, robot=robot, humans=recording.humans)
    )
    np.testing.assert_allclose(ax.get_lines()[0].get_ydata(), -1.0)
    assert ax.get_ylim()[0] < -1.0


def test_several_runs_are_named_by_what_differs():
    results = [
        make_result(drive_by(), planner="a", seed=1),
        make_result(drive_by(), planner="b", seed=1),
        make_result(drive_by(), planner="b", seed=2),
        make_result(drive_by(), planner="b", seed=2),
    ]
    names = ["a, seed 1", "b, seed 1", "b, seed 2", "b, seed 2 (2)"]
    for plot in (plot_distance_to_people, plot_robot_speed, plot_trajectories):
        assert set(names) <= set(legend_texts(plot(results)))
    ticks = plot_zones(results).get_yticklabels()
    assert [tick.get_text() for tick in ticks] == names
    with pytest.raises(TypeError, match="needs one run, got 4"):
        plot_behavior_activity(results)


def test_runs_may_have_names_of_ones_own():
    runs = {"_first": drive_by(), "$x": make_result(drive_by())}
    ax = plot_robot_speed(runs)
    ax.figure.canvas.draw()
    assert {" _first", "$x"} <= set(legend_texts(ax))
    assert len(artists(ax, "near")) == 2


def test_the_map_has_everything_on_it():
    walls = Obstacles.from_shapes(
        [[[-9, 2], [9, 2], [9, 3], [-9, 3]], [[-5, -8], [5, -8]]],
        solid=[True, False],
    )
    recording = drive_by(obstacles=walls, goal=(4.0, 0.0, 0.0))
    ax = plot_trajectories(recording)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    assert left < -9
    assert right > 9
    assert bottom < -8
    assert top > 3
    paths = [line for line in ax.get_lines() if len(line.get_xdata()) == 61]
    np.testing.assert_array_equal(
        np.stack([line.get_xydata() for line in paths]),
        np.concatenate(
            [
                recording.robot[None, :, :2],
                recording.humans[..., :2].swapaxes(0, 1),
            ]
        ),
    )
    assert ax.get_aspect() == 1.0
    star = next(line for line in ax.get_lines() if line.get_marker() == "*")
    np.testing.assert_array_equal(star.get_xydata(), [[4.0, 0.0]])


def test_marks_are_at_equal_times():
    ax = plot_trajectories(drive_by(()), mark_every=2.0)
    (marks,) = artists(ax, "marks")
    np.testing.assert_allclose(
        marks.get_xydata(), [[-3, 0], [-1, 0], [1, 0], [3, 0]]
    )
    assert [text.get_text() for text in ax.texts] == ["0", "2", "4", "6"]
    assert "every 2 s" in legend_texts(ax)


@pytest.mark.parametrize("others", [(), range(4)])
def test_each_of_several_runs_has_marks(others):
    data = {"a": drive_by(others), "b": drive_by(others)}
    marks = artists(plot_trajectories(data, mark_every=2.0), "marks")
    assert [len(it.get_xdata()) for it in marks] == [4, 4]
    assert marks[0].get_color() != marks[1].get_color()


def test_marks_of_large_times_tell_them_apart():
    recording = drive_by(())
    late = replace(recording, times=recording.times + 1.7e9)
    ax = plot_trajectories(late, mark_every=2.0)
    texts = [text.get_text() for text in ax.texts]
    assert texts == [f"170000000{i}" for i in (0, 2, 4, 6)]
    assert "from 1700000000 s to 1700000006 s" in repr(late)


@pytest.mark.parametrize("side", [2.0, 5.5, 8.0])
def test_the_legend_of_a_narrow_map_stays_in_the_figure(side):
    walls = Obstacles.from_shapes(
        [[[-5, -side], [5, -side], [5, side], [-5, side]]], solid=[False]
    )
    names = [f"human_{i}" for i in range(11, 15)]
    for data in (
        drive_by(range(4), obstacles=walls, human_names=names),
        {f"planner, speed={i}": drive_by(obstacles=walls) for i in range(4)},
    ):
        ax = plot_trajectories(data)
        ax.figure.canvas.draw()
        legend = ax.get_legend().get_window_extent()
        assert legend.x1 <= ax.figure.bbox.x1 + 1


def test_names_of_people_do_not_overlap():
    names = [f"a person of a name {i}" for i in range(20)]
    recording = drive_by(np.arange(20) / 4 - 2.5, human_names=names)
    ax = plot_trajectories(recording)
    ax.figure.canvas.draw()
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) > 5
    for i, box in enumerate(boxes):
        assert box.count_overlaps(boxes[:i]) == 0


def test_who_is_missing_has_no_mark():
    recording = drive_by((0.0,))
    humans = recording.humans.copy()
    humans[:35] = np.nan
    late = Recording(
        times=recording.times, robot=recording.robot, humans=humans
    )
    _, marks = artists(plot_trajectories(late, mark_every=2.0), "marks")
    assert len(marks.get_xdata()) == 2


def test_the_time_between_marks_must_be_positive():
    with pytest.raises(ValueError, match="mark_every must be positive"):
        plot_trajectories(drive_by(), mark_every=0.0)


def test_labels_keep_off_each_other():
    # All marks are at one place, and only so many labels fit around it.
    still = np.zeros((61, 7))
    recording = drive_by(())
    ax = plot_trajectories(
        Recording(times=recording.times, robot=still, humans=recording.humans),
        mark_every=0.1,
    )
    places = np.array([text.xyann for text in ax.texts])
    assert 2 <= len(places) <= 16
    gaps = np.hypot(*(places[:, None] - places).transpose(2, 0, 1))
    assert gaps[~np.eye(len(gaps), dtype=bool)].min() > 8.0


def test_shares_of_spaces_are_those_of_the_metrics():
    result = make_result(drive_by())
    ax = plot_zones(result)
    shares = [bars[0].get_width() for bars in ax.containers]
    names = ("intimate", "personal", "social+")
    assert shares[:3] == pytest.approx(
        [result.metrics[f"{name}_space_intrusions"] for name in names]
    )
    assert sum(shares) == pytest.approx(100.0)


def test_activity_is_where_the_status_says():
    status = np.zeros((61, 2))
    status[10:20, 1] = 1
    recording = drive_by(
        behavior_status=status,
        behaviors=("regular", "scared"),
        human_names=("ana", "<b>"),
    )
    ax = plot_behavior_activity(recording)
    labels = [text.get_text() for text in ax.get_yticklabels()]
    assert labels == ["ana", "<b>"]
    assert legend_texts(ax) == ["regular", "scared"]
    bars = ax.collections[-1].get_paths()
    assert len(bars) == 1
    (x0, y0), (x1, y1) = bars[0].get_extents().get_points()
    assert (x0, x1) == pytest.approx((1.0, 2.0))
    assert y0 < 1 < y1


# --- comparison ---


def three_planners():
    return pd.DataFrame(
        {
            "planner": ["a", "a", "a", "b", "b", "c"],
            "path_length": [1.0, 2.0, 3.0, 4.0, 6.0, np.nan],
        }
    )


def test_bars_are_means_with_intervals():
    ax = plot_comparison(three_planners(), "path_length")
    assert [bar.get_width() for bar in ax.patches] == [2.0, 5.0, 0.0]
    assert [t.get_text() for t in ax.get_yticklabels()] == ["a", "b", "c"]
    assert ax.get_xlabel() == "path_length (m)"
    table = summarize(three_planners(), ["planner"])
    intervals = [c for c in ax.containers if isinstance(c, ErrorbarContainer)]
    assert len(intervals) == 2
    for container, name in zip(intervals, "ab", strict=True):
        (segment,) = container.lines[2][0].get_segments()
        row = table.loc[(name, "path_length")]
        # (A length is never below zero.)
        low = max(row["low"], 0.0)
        np.testing.assert_allclose(segment[:, 0], [low, row["high"]])
    ax.figure.canvas.draw()


def test_anything_can_be_compared():
    runs = three_planners().rename(columns={"planner": "setting"})
    ax = plot_comparison(runs, "path_length", by="setting")
    assert len(ax.patches) == 3


def test_a_table_read_from_its_csv_is_drawn_the_same(tmp_path):
    """Empty cells, as of settings, are NaN there."""
    runs = three_planners()
    runs["setting"] = ""
    runs.to_csv(tmp_path / "runs.csv", index=False)
    read = pd.read_csv(tmp_path / "runs.csv")
    assert read["setting"].isna().all()
    one, two = (plot_comparison(it, "path_length") for it in (runs, read))
    assert [it.get_width() for it in one.patches] == pytest.approx(
        [it.get_width() for it in two.patches]
    )
    assert [it.get_text() for it in one.get_yticklabels()] == [
        it.get_text() for it in two.get_yticklabels()
    ]


def test_results_can_be_compared():
    results = [make_result(planner=p, seed=s) for p in "ab" for s in (0, 1)]
    ax = plot_comparison(results, "robot_on_person_collisions")
    assert ax.get_xlabel() == "robot_on_person_collisions"
    assert ax.get_xlim() == (0.0, 1.0)


def test_rates_are_in_percent():
    completed = [1.0, 1.0, 0.0, 1.0, np.inf, np.nan]
    runs = three_planners().assign(completed=completed)
    ax = plot_comparison(runs, "completed")
    assert [b.get_width() for b in ax.patches] == pytest.approx(
        [200 / 3, 100, 0]
    )
    assert ax.get_xlabel() == "completed (%)"
    ax.figure.canvas.draw()


def test_a_costmap_lies_where_it_is_in_the_world():
    costs = np.zeros((30, 20), dtype=np.uint8)
    costs[12, 3] = 254
    costmap = Costmap(costs, (-4.0, 1.0), 0.1)
    ax = plot_costmap(costmap, legend=True)
    (image,) = ax.images
    assert image.get_extent() == pytest.approx([-4.0, -2.0, 1.0, 4.0])
    assert np.asarray(image.get_array())[29 - 12, 3, 3] > 0
    assert legend_texts(ax) == [
        *("low cost", "high cost", "robot in collision", "occupied")
    ]
    ax.figure.canvas.draw()
    assert not plot_costmap(NO_MAP).images


def test_every_plot_is_exported():
    for name in hunav_drake.report.plots.__all__:
        if name.startswith("plot_"):
            assert name in hunav_drake.__all__
        if name != "Approach":
            exported = getattr(hunav_drake, name)
            assert exported is getattr(hunav_drake.report.plots, name)


def test_a_metric_without_values_is_an_empty_plot():
    ax = plot_comparison(three_planners().iloc[5:], "path_length")
    assert [text.get_text() for text in ax.texts] == ["there are no values"]


def test_a_column_that_there_is_not_is_refused():
    with pytest.raises(ValueError, match="no column 'speed'"):
        plot_comparison(three_planners(), "speed")
    with pytest.raises(ValueError, match="no column 'robot'"):
        plot_comparison(three_planners(), "path_length", by="robot")


def test_numbers_of_approaches_are_beside_the_edges():
    ax = plot_distance_to_people(drive_by((0.5,)).until(3.0))
    ax.figure.canvas.draw()
    (text,) = ax.texts
    box, axes = text.get_window_extent(), ax.get_window_extent()
    assert axes.x0 <= box.x0 < box.x1 <= axes.x1


def test_numbers_of_close_approaches_do_not_hide_the_line():
    ax = plot_distance_to_people(drive_by((-2.0, 2.0), y=0.5))
    ax.figure.canvas.draw()
    (minima,) = artists(ax, "minima")
    # It is a contact: the mark is above the axis, the number below the mark.
    assert minima.get_ydata() == pytest.approx([0.0, 0.0], abs=0.11)
    axes, mark = ax.get_window_extent(), minima.get_markersize()
    dots = ax.figure.dpi / 72
    for x, y, text in zip(*minima.get_data(), ax.texts, strict=True):
        height = ax.transData.transform((x, y))[1]
        assert height - mark / 2 * dots > axes.y0
        box = text.get_window_extent()
        assert axes.y0 <= box.y0
        assert box.y1 < height
    assert min(ax.get_yticks()) >= 0


def test_marks_of_several_runs_are_above_the_axis():
    runs = {k: drive_by((0.0,), y=0.5) for k in "ab"}
    ax = plot_distance_to_people(runs)
    ax.figure.canvas.draw()
    height = ax.transData.transform((0.0, 0.0))[1] - ax.get_window_extent().y0
    assert height > 4.5 / 2 * ax.figure.dpi / 72


def test_settings_of_one_planner_have_bars_of_their_own():
    results = [
        make_result(seed=seed, setting=f"a.speed={v}")
        for v in (1, 2)
        for seed in (0, 1)
    ]
    ax = plot_comparison(results, "path_length")
    texts = [tick.get_text() for tick in ax.get_yticklabels()]
    assert texts == ["pursuit\nspeed=1", "pursuit\nspeed=2"]
    assert set(legend_texts(plot_robot_speed([results[0], results[2]]))) == {
        "speed=1",
        "speed=2",
    }


def test_long_names_keep_what_tells_them_apart():
    names = [f"parameters.something.long={i}" for i in range(2)]
    short = [shown(name) for name in names]
    assert short == ["paramete\u2026ng.long=0", "paramete\u2026ng.long=1"]


def test_a_legend_beside_long_names_stays_in_the_figure():
    ax = plot_zones({f"cruise_speed=0.{i}": drive_by() for i in (3, 7)})
    ax.figure.canvas.draw()
    legend = ax.get_legend().get_window_extent()
    assert legend.x1 <= ax.figure.bbox.x1 + 1


def test_labels_are_as_long_as_they_must_be_to_differ():
    names = [
        f"sfw, robot.radius={radius}, doorway {place}"
        for radius in (0.3, 0.35)
        for place in ("of an office", "of another office")
    ]
    data = {name: drive_by() for name in names}
    for ax in (plot_robot_speed(data), plot_trajectories(data)):
        assert len({*legend_texts(ax)} - {"every 1 s"}) == 4
    texts = {it.get_text() for it in plot_zones(data).get_yticklabels()}
    assert len(texts) == 4


@pytest.mark.parametrize("plot", ALL_OF_ONE)
def test_axes_may_be_those_of_a_part_of_a_figure(plot):
    part, _ = plt.figure(layout="constrained").subfigures(1, 2)
    ax = plot(drive_by(), ax=part.subplots())
    ax.get_figure(root=True).canvas.draw()
