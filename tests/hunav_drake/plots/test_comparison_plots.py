"""Plots over seeds: means, differences of pairs, distributions; their files."""

import re
import struct
import warnings

import matplotlib.colors as mcolors
import numpy as np
import pandas as pd
import pytest
from scipy import stats

from hunav_drake.report.comparison_figures import WriteFigures
from hunav_drake.report.plots import (
    plot_comparison,
    plot_differences,
    plot_distribution,
)
from hunav_drake.runs import compare, summarize
from hunav_drake.runs.statistics import differences
from tests.hunav_drake.passing_trials import make_result

A = np.array([10.0, 12.0, 11.0, 13.0, 10.5, 12.5, 11.5])
B = A + np.array([1.0, 2.0, 1.5, 0.5, 1.0, 2.5, 1.0])


def runs_of(**times):
    """Returns a run per seed of each planner, NaN for those that fail."""
    rows = [
        {
            "scenario": "hall",
            "planner": planner,
            "setting": "",
            "seed": seed,
            "completed": float(np.isfinite(time)),
            "time_to_reach_goal": time,
            "path_length": 2 * seed + 1.0,
        }
        for planner, values in times.items()
        for seed, time in enumerate(values)
    ]
    return pd.DataFrame(rows)


def labels(ax):
    return [it.get_text() for it in ax.get_yticklabels()]


def lines_of(ax):
    """Returns the points of the lines of a distribution, by label."""
    return {it.get_label(): it.get_xydata() for it in ax.get_lines()}


def test_a_distribution_is_that_of_scipy():
    ax = plot_distribution(
        runs_of(a=A, b=[*B[:-1], B[0]]), "time_to_reach_goal"
    )
    drawn = lines_of(ax)
    assert list(drawn) == ["a (n = 7)", "b (n = 7)"]
    for values, points in zip(
        (A, [*B[:-1], B[0]]), drawn.values(), strict=True
    ):
        cdf = stats.ecdf(values).cdf
        x, y = points.T
        assert y[0] == 0
        for at, share in zip(cdf.quantiles, cdf.probabilities, strict=True):
            assert y[x == at].max() == pytest.approx(100 * share)


def test_who_never_arrives_is_later_than_any_time():
    late = [*A[:3], np.nan, np.nan]
    drawn = lines_of(
        plot_distribution(runs_of(a=late, b=A[:5]), "time_to_reach_goal")
    )
    assert drawn["a (n = 5)"][-1, 1] == pytest.approx(60)
    assert drawn["b (n = 5)"][-1, 1] == pytest.approx(100)
    # Other metrics without a value are unknown, not late.
    runs = runs_of(a=A[:5]).assign(path_length=[1, 2, 3, np.nan, np.inf])
    ax = plot_distribution(runs, "path_length")
    assert lines_of(ax)["a (n = 3)"][-1, 1] == pytest.approx(100)


def test_a_fleet_of_which_a_robot_never_arrives_is_late():
    runs = runs_of(a=A[:4]).drop(columns="completed", errors="ignore")
    runs["makespan"] = [20.0, 21.0, np.nan, np.nan]
    runs["west.completed"] = 1.0
    runs["east.completed"] = [1.0, 1.0, 0.0, 0.0]
    drawn = lines_of(plot_distribution(runs, "makespan"))
    assert drawn["a (n = 4)"][-1, 1] == pytest.approx(50)
    # A single robot has no makespan, whether it arrives or not.
    alone = runs_of(a=[5.0, np.nan]).assign(scenario="elsewhere")
    both = pd.concat([runs, alone], ignore_index=True)
    drawn = lines_of(plot_distribution(both, "makespan"))
    assert drawn["a, hall (n = 4)"][-1, 1] == pytest.approx(50)
    assert "a, elsewhere (n = 0)" in drawn


def test_nothing_and_one_value_have_a_distribution():
    runs = runs_of(a=[np.nan, np.nan], b=[5.0])
    ax = plot_distribution(runs, "time_to_reach_goal")
    assert lines_of(ax)["b (n = 1)"][-1, 1] == 100
    assert lines_of(ax)["a (n = 2)"][-1, 1] == 0
    ax = plot_distribution(runs.assign(path_length=np.nan), "path_length")
    assert [it.get_text() for it in ax.texts] == ["there are no values"]


def test_differences_are_those_of_a_paired_t_test():
    runs = runs_of(a=A, b=B)
    ax = plot_differences(runs, "time_to_reach_goal")
    dots, middle = ax.get_lines()[:2]
    np.testing.assert_allclose(dots.get_xdata(), B - A)
    assert middle.get_xdata() == pytest.approx((B - A).mean())
    expected = stats.ttest_rel(B, A).confidence_interval()
    (segment,) = ax.containers[0].lines[2][0].get_segments()
    np.testing.assert_allclose(segment[:, 0], expected)
    assert ax.get_xlabel() == "time_to_reach_goal, difference from a (s)"
    assert labels(ax) == ["b"]
    other = plot_differences(runs, "time_to_reach_goal", reference="b")
    assert other.get_lines()[1].get_xdata() == pytest.approx((A - B).mean())


def test_pairs_that_are_drawn_are_those_that_are_compared():
    runs = runs_of(a=A, b=[*B[:5], np.nan])
    row = compare(runs, "a", "b").loc["hall", "path_length"]
    gaps = differences(runs, "a", "b", "path_length")
    assert len(gaps) == row["n"] == 5
    assert gaps.mean() == row["difference"] == 0
    # A rate is of all pairs.
    assert len(differences(runs, "a", "b", "completed")) == 6


@pytest.mark.parametrize(
    ("runs", "label"),
    [
        (runs_of(a=A, b=B).query("planner == 'a' or seed > 90"), None),
        (runs_of(a=[np.nan] * 3, b=B[:3]), "b\nno pair has both"),
        (
            runs_of(a=A[:3], b=B[:3]).assign(seed=[0, 1, 2, 5, 6, 7]),
            "b\nno equal seeds",
        ),
    ],
)
def test_differences_tell_why_there_are_none(runs, label):
    ax = plot_differences(runs, "time_to_reach_goal")
    assert labels(ax) == ([label] if label else [])
    texts = [it.get_text() for it in ax.texts]
    assert texts == ([] if label else ["there is one planner only"])


def test_only_a_better_one_has_a_thick_interval():
    for b, width in ((B, 2.4), (A[::-1], 1.0), (A, 1.0)):
        ax = plot_differences(runs_of(a=A, b=b), "time_to_reach_goal")
        assert ax.containers[0].lines[2][0].get_linewidths() == [width]


def test_an_unknown_reference_is_told():
    with pytest.raises(
        ValueError, match="no run is of 'c'; there are 'a', 'b'"
    ):
        plot_differences(runs_of(a=A, b=B), reference="c")


def test_what_figures_lack_is_told(tmp_path):
    runs = runs_of(a=A, b=B)
    for column in ("planner", "seed"):
        with pytest.raises(ValueError, match=f"no column '{column}'"):
            plot_differences(runs.drop(columns=column), "path_length")
    for plot in (plot_differences, plot_distribution):
        for table in (runs, runs_of(a=A)):
            with pytest.raises(ValueError, match="no column 'path_lenth'"):
                plot(table, "path_lenth")
    with pytest.raises(ValueError, match="no column 'robot'"):
        plot_distribution(runs, "path_length", by="robot")
    with pytest.raises(ValueError, match=r"metrics: there is no 'path_lenth'"):
        WriteFigures(runs, tmp_path / "no", metrics=["path_lenth"])
    with pytest.raises(ValueError, match=r"formats: there is no 'eps'; valid"):
        WriteFigures(runs, tmp_path / "no", formats=["eps"])
    assert not (tmp_path / "no").exists()


@pytest.mark.parametrize(
    "plot", [plot_comparison, plot_differences, plot_distribution]
)
def test_a_table_without_runs_is_refused(plot):
    for nothing in (runs_of(a=A).iloc[:0], pd.DataFrame(), []):
        with pytest.raises(ValueError, match="there are no runs to draw"):
            plot(nothing, "path_length")


def test_scenarios_are_not_averaged():
    """A planner that lacks seeds in a hard one would look fast."""
    hall, yard = runs_of(a=A, b=B), runs_of(a=10 * A, b=[])
    runs = pd.concat([hall, yard.assign(scenario="yard")], ignore_index=True)
    ax = plot_comparison(runs, "time_to_reach_goal")
    assert labels(ax) == ["a\nhall", "b\nhall", "a\nyard"]
    widths = [it.get_width() for it in ax.patches]
    assert widths == pytest.approx([A.mean(), B.mean(), 10 * A.mean()])
    colors = [it.get_facecolor() for it in ax.patches]
    assert colors[0] == colors[2] != colors[1]
    # Differences are within a scenario.
    assert labels(plot_differences(runs, "path_length")) == [
        "b\nhall",
        "b\nyard\nno equal seeds",
    ]


def test_a_metric_is_chosen_if_none_is_named(tmp_path):
    runs = runs_of(a=A, b=B)
    runs.to_csv(tmp_path / "runs.csv", index=False)
    ax = plot_comparison(pd.read_csv(tmp_path / "runs.csv"))
    assert ax.get_xlabel() == "completed (%)"
    ax = plot_comparison(runs.assign(completed=np.nan))
    assert ax.get_xlabel() == "time_to_reach_goal (s)"
    with pytest.raises(ValueError, match="no headline metric with a value"):
        plot_comparison(runs[["planner", "setting", "seed"]])


def test_tables_read_by_pandas_have_the_same_statistics(tmp_path):
    runs = runs_of(a=A, b=B).assign(drawn="")
    runs.loc[runs["seed"] % 2 == 0, "setting"] = "wide"
    runs.to_csv(tmp_path / "runs.csv", index=False)
    read = pd.read_csv(tmp_path / "runs.csv")
    assert read["setting"].hasnans
    one, other = summarize(runs), summarize(read)
    pd.testing.assert_frame_equal(one, other)
    assert other.loc[("hall", "a", "", "path_length"), "n"] == 3
    one, other = (
        compare(it, "a", "b", by=("scenario", "setting")) for it in (runs, read)
    )
    pd.testing.assert_frame_equal(one, other)


def test_files_of_many_metrics_are_drawn_without_a_word(tmp_path):
    """As those of several robots: pandas warns of so many columns."""
    runs = runs_of(a=A, b=B)
    names = [f"robot_{i}.path_length" for i in range(120)]
    more = pd.DataFrame(1.0, index=runs.index, columns=names)
    file = tmp_path / "runs.csv"
    pd.concat([runs, more], axis=1).to_csv(file, index=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read = pd.read_csv(file)
        for draw in (plot_comparison, plot_differences, plot_distribution):
            draw(read, "path_length")


@pytest.mark.slow
def test_each_figure_is_a_file_as_wide_as_a_column(tmp_path):
    runs = runs_of(**{"a_%": A, "b": B})
    paths = WriteFigures(
        runs, tmp_path, metrics=["time_to_reach_goal"], made_by="suite s_1"
    )
    names = {
        f"hall_time_to_reach_goal_{it}"
        for it in ("means", "differences", "distribution")
    }
    assert {p.name for p in paths} == {
        *(f"{it}.{kind}" for it in names for kind in ("pdf", "svg", "png")),
        "figures.tex",
    }
    for path in paths[:-1]:
        data = path.read_bytes()
        if path.suffix == ".pdf":
            assert re.search(rb"/MediaBox \[ 0 0 244.8 ", data)
            # The fonts are in it as outlines that can be searched.
            assert b"/Subtype /Type3" not in data
        elif path.suffix == ".svg":
            text = data.decode()
            assert 'width="244.8pt"' in text
        else:
            assert struct.unpack(">I", data[16:20]) == (1020,)
    tex = (tmp_path / "figures.tex").read_text()
    assert tex.count(r"\begin{figure}") == tex.count(r"\caption{") == 3
    for name in names:
        assert rf"{{{name}}}" in tex
    told = r"planners a\_\% and b; 7 seeds (0 to 6); suite s\_1."
    assert tex.count(told) == 3
    # Equal runs make equal files.
    before = {it: it.read_bytes() for it in paths}
    WriteFigures(
        runs, tmp_path, metrics=["time_to_reach_goal"], made_by="suite s_1"
    )
    assert {it: it.read_bytes() for it in paths} == before


@pytest.mark.slow
def test_all_text_of_figures_can_be_read():
    runs = runs_of(**{f"planner_{i}": A + i for i in range(7)})
    for plot in (plot_comparison, plot_differences, plot_distribution):
        ax = plot(runs, "time_to_reach_goal")
        ax.figure.canvas.draw()
        assert ax.figure.get_figwidth() == 3.4
        legend = ax.get_legend()
        low, high = ax.get_xlim()
        ticks = zip(ax.get_xticks(), ax.get_xticklabels(), strict=True)
        texts = [
            *(text for x, text in ticks if low <= x <= high),
            *ax.get_yticklabels(),
            ax.xaxis.label,
            ax.yaxis.label,
            *(legend.get_texts() if legend else ()),
        ]
        width = ax.figure.bbox.width
        for it in texts:
            assert it.get_fontsize() >= 7
            if it.get_text():
                box = it.get_window_extent()
                assert 0 <= box.x0 <= box.x1 <= width + 1, it.get_text()


def test_figures_are_of_results_too(tmp_path):
    results = [make_result(seed=seed) for seed in (0, 1)]
    paths = WriteFigures(
        results, tmp_path, metrics=["path_length"], formats=["svg"]
    )
    # One planner has no differences.
    assert [it.name for it in paths] == [
        "passing_path_length_means.svg",
        "passing_path_length_distribution.svg",
        "figures.tex",
    ]


def test_scenarios_with_names_in_another_script_have_figures_of_their_own(
    tmp_path,
):
    runs = pd.concat(
        [
            runs_of(a=it).assign(scenario=name)
            for name, it in {"大廳": A, "房間": B}.items()
        ]
    )
    paths = WriteFigures(
        runs, tmp_path, metrics=["time_to_reach_goal"], formats=["svg"]
    )
    assert len(set(paths)) == len(paths) == 5
    assert len({it.read_bytes() for it in paths}) == 5
    tex = (tmp_path / "figures.tex").read_text()
    assert all(f"{{{it.stem}}}" in tex for it in paths[:-1])


def test_a_robot_without_a_goal_has_no_distribution_of_its_time():
    runs = runs_of(a=A).rename(
        columns={"time_to_reach_goal": "anna.time_to_reach_goal"}
    )
    runs = runs.assign(
        completed=0.0,
        **{
            "anna.completed": 1.0,
            "bob.completed": np.nan,
            "bob.time_to_reach_goal": np.nan,
        },
    )
    for robot, n in (("anna", 7), ("bob", 0)):
        ax = plot_distribution(runs, f"{robot}.time_to_reach_goal")
        (label,) = [it for it in lines_of(ax) if "n =" in it]
        assert label == f"a (n = {n})"
    ends = lines_of(plot_distribution(runs, "anna.time_to_reach_goal"))
    assert ends["a (n = 7)"][-1, 1] == 100


def test_a_seed_of_which_not_all_repetitions_arrive_is_late():
    first = runs_of(a=A).assign(repetition=0)
    second = first.assign(
        repetition=1, completed=0.0, time_to_reach_goal=np.nan
    )
    ax = plot_distribution(pd.concat([first, second]), "time_to_reach_goal")
    assert lines_of(ax)["a (n = 7)"][-1, 1] == 0


def test_settings_in_several_scenarios_have_labels_of_their_own():
    one = runs_of(dwb=A, sfw=B)
    runs = pd.concat(
        one.assign(scenario=scenario, setting=f"robot.radius={radius}")
        for scenario in ("crossing", "doorway_of_an_office")
        for radius in (0.3, 0.35)
    )
    assert len({*labels(plot_comparison(runs))}) == 8
    assert len({*lines_of(plot_distribution(runs, "path_length"))}) == 8


def test_a_planner_has_one_color_in_all_scenarios():
    one = runs_of(dwb=A, sfw=B)
    runs = pd.concat([one, one.assign(scenario="office")])
    lines = plot_distribution(runs, "path_length").get_lines()
    bars = plot_comparison(runs, "path_length").patches
    colors = [mcolors.to_rgb(it.get_color()) for it in lines]
    assert colors == [it.get_facecolor()[:3] for it in bars]
    assert colors[0] == colors[2] != colors[1] == colors[3]
    assert [it.get_linestyle() for it in lines] == ["-", "-", "--", "--"]


def test_an_interval_of_a_rate_of_zero_is_in_the_axes():
    ax = plot_comparison(runs_of(dwb=[np.nan] * 7), "completed")
    high = summarize(runs_of(dwb=[np.nan] * 7)).high["hall", "dwb", "completed"]
    assert ax.get_xlim()[1] > 100 * high > 30


@pytest.mark.parametrize("size", [1e-7, 1e12])
def test_the_power_of_ten_is_apart_from_the_name_of_the_axis(size):
    runs = runs_of(dwb=A, sfw=B)
    runs["$cost^$"] = size * runs["path_length"] * (1 + runs["seed"] % 3)
    for plot in (plot_comparison, plot_distribution):
        ax = plot(runs, "$cost^$")
        ax.figure.canvas.draw()
        power = ax.xaxis.get_offset_text()
        assert power.get_text()
        boxes = [it.get_window_extent() for it in (power, ax.xaxis.label)]
        assert not boxes[0].overlaps(boxes[1])
