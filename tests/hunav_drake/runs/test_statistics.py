import math

import numpy as np
import pandas as pd
import pytest

from hunav_drake import WriteFigures, plot_distribution
from hunav_drake.runs.intervals import (
    LEAST_DRAWN,
    bootstrap_interval,
    mean_interval,
    paired_rate_interval,
    wilson_interval,
)
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.runs.statistics import (
    LEAST_PAIRS,
    arrivals,
    compare,
    early_mark,
    summarize,
)


def make_runs(n=8):
    rng = np.random.default_rng(5)
    rows = []
    for scenario in ("passing", "crossing"):
        for planner, shift in (("fast", 0.0), ("slow", 2.0)):
            for seed in range(n):
                length = 10 + 3 * math.sin(seed) + shift
                rows.append(
                    {
                        "tag": f"{scenario}_{planner}_{seed}",
                        "scenario": scenario,
                        "planner": planner,
                        "seed": seed,
                        "end_reason": "goal",
                        "end_time": 20.0,
                        "path_length": length + 0.01 * rng.normal(),
                        "min_dist_to_people": 1 + 0.1 * shift,
                        "completed": float(seed != 3),
                        "duration": length,
                    }
                )
    return pd.DataFrame(rows)


def test_mean_deviation_and_median_by_hand():
    runs = pd.DataFrame({"x": [1.0, 2.0, 4.0, math.nan, 5.0]})
    row = summarize(runs, by=()).loc["x"].iloc[0]
    assert row["n"] == 4
    assert row["mean"] == 3
    # sqrt((4 + 1 + 1 + 4) / 3)
    assert row["sd"] == pytest.approx(math.sqrt(10 / 3))
    assert row["median"] == 3
    # Student's t for 3 degrees of freedom is 3.18244631.
    half = 3.18244631 * math.sqrt(10 / 3) / 2
    assert row["low"] == pytest.approx(3 - half)
    assert row["high"] == pytest.approx(3 + half)


def test_a_row_for_each_kind_and_metric():
    table = summarize(make_runs())
    assert table.index.names == ["scenario", "planner", "metric"]
    assert list(table.index[:4]) == [
        ("passing", "fast", "path_length"),
        ("passing", "fast", "min_dist_to_people"),
        ("passing", "fast", "completed"),
        ("passing", "fast", "duration"),
    ]
    assert len(table) == 4 * 4
    assert (table["n"] == 8).all()
    assert table.attrs["units"]["path_length"] == "m"
    other = table.copy()
    other.attrs["units"]["path_length"] = "km"
    assert table.attrs["units"]["path_length"] == "m"


def test_what_tells_runs_apart_is_no_metric():
    plain = make_runs()
    # A column without a text is read as one of numbers.
    runs = plain.assign(repetition=0, end_message=math.nan)
    for function in (summarize, lambda r: compare(r, "fast", "slow")):
        pd.testing.assert_frame_equal(function(runs), function(plain))


def test_a_rate_has_wilsons_interval():
    row = summarize(make_runs()).loc["passing", "fast", "completed"]
    assert row["mean"] == 7 / 8
    assert (row["low"], row["high"]) == wilson_interval(7, 8)


def test_wilsons_interval_by_hand():
    # Of 10 tries 5: the center is 1/2, the half width is
    # z / (1 + z^2 / n) sqrt(1 / 4n + z^2 / 4n^2).
    z = 1.959963984540054
    half = z / (1 + z * z / 10) * math.sqrt(1 / 40 + z * z / 400)
    low, high = wilson_interval(5, 10)
    assert low == pytest.approx(0.5 - half)
    assert high == pytest.approx(0.5 + half)
    # Never: from 0 to z^2 / (n + z^2). Always: the mirror image.
    assert wilson_interval(0, 10) == (0, pytest.approx(z**2 / (10 + z**2)))
    assert wilson_interval(10, 10) == (pytest.approx(10 / (10 + z**2)), 1)
    assert np.isnan(wilson_interval(0, 0)).all()


def test_the_bootstrap_comes_near_the_normal_interval():
    values = np.random.default_rng(0).normal(3, 2, 400)
    low, high = bootstrap_interval(values)
    half = 1.96 * values.std(ddof=1) / math.sqrt(400)
    assert low == pytest.approx(values.mean() - half, abs=0.03)
    assert high == pytest.approx(values.mean() + half, abs=0.03)


def test_the_bootstrap_of_two_values_by_hand():
    # The mean of two draws is 0, 1/2 or 1, and 0 or 1 a quarter of the time.
    assert bootstrap_interval(np.array([0.0, 1.0])) == (0, 1)
    assert bootstrap_interval(np.array([0.0, 1.0]), 0.4) == (0.5, 0.5)


@pytest.mark.parametrize("n", [2, 3, 5, 8, LEAST_DRAWN])
def test_means_are_in_their_intervals_as_often_as_they_should(n):
    rng = np.random.default_rng(n)
    count = 200 if n == LEAST_DRAWN else 2000
    inside = 0
    for seed in range(count):
        low, high = mean_interval(rng.normal(10, 1, n), seed=seed)
        inside += low <= 10 <= high
    # Three standard errors.
    error = math.sqrt(0.95 * 0.05 / count)
    assert inside / count == pytest.approx(0.95, abs=3 * error)


@pytest.mark.slow
@pytest.mark.parametrize("n", [6, 8, 12, 20])
@pytest.mark.parametrize("rate", [0.5, 0.9])
def test_differences_of_rates_are_in_their_intervals(n, rate):
    rng = np.random.default_rng(n)
    inside = 0
    for _ in range(1000):
        a, b = (rng.random((2, n)) < rate).astype(float)
        low, high = paired_rate_interval(a, b)
        inside += low <= 0 <= high
    assert inside / 1000 > 0.93


def test_differences_of_rates_by_hand():
    # Of two that never agree, each half is Wilson's own, side by side.
    a = np.array([1.0, 1.0, 0.0, 0.0])
    b = np.array([1.0, 0.0, 1.0, 0.0])
    low, high = wilson_interval(2, 4)
    half = math.sqrt(2) * (high - 0.5)
    assert paired_rate_interval(a, b) == pytest.approx((-half, half))
    # All equal is no proof that all will be.
    low, high = paired_rate_interval(np.ones(6), np.ones(6))
    assert low < -0.3
    assert high == pytest.approx(-low)
    assert np.isnan(paired_rate_interval(np.ones(0), np.ones(0))).all()
    # The other way round it is the mirror image.
    a = np.array([1.0, 1.0, 1.0, 0.0, 1.0, 1.0])
    b = np.array([0.0, 1.0, 0.0, 0.0, 1.0, 0.0])
    low, high = paired_rate_interval(a, b)
    assert paired_rate_interval(b, a) == pytest.approx((-high, -low))


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 5, LEAST_PAIRS, 12])
def test_of_equal_planners_none_is_called_better(n):
    rng = np.random.default_rng(n)
    verdicts = 0
    for _ in range(100):
        runs = pd.DataFrame(
            {
                "planner": np.repeat(["a", "b"], n),
                "seed": np.tile(np.arange(n), 2),
                "path_length": rng.normal(10, 1, 2 * n),
            }
        )
        table = compare(runs, "a", "b", by=())
        verdicts += table["better"].iloc[0] is not None
    # Once in 20 times it is by chance.
    assert verdicts <= (0 if n < LEAST_PAIRS else 12)


def test_rounding_is_no_difference():
    runs = make_runs()
    length = 10 + 0.1 * runs["seed"]
    runs["path_length"] = length * np.where(
        runs["planner"] == "slow", 1 + 1e-15, 1
    )
    row = compare(runs, "fast", "slow").loc["passing", "path_length"]
    assert row["difference"] == row["low"] == row["high"] == 0
    assert row["better"] is None


@pytest.mark.filterwarnings("error")
def test_what_is_infinite_does_not_count():
    runs = make_runs()
    runs.loc[runs["seed"] == 1, "path_length"] = math.inf
    finite = runs[runs["seed"] != 1]
    # In one pair nobody arrives.
    for n, function in (
        (7, summarize),
        (6, lambda r: compare(r, "fast", "slow")),
    ):
        row = function(runs).xs("path_length", level="metric").iloc[0]
        expected = function(finite).xs("path_length", level="metric").iloc[0]
        assert row["n"] == n
        pd.testing.assert_series_equal(row, expected)


def test_a_single_name_may_be_a_string():
    runs = make_runs()
    pd.testing.assert_frame_equal(
        summarize(runs, "planner", metrics="path_length", rates="completed"),
        summarize(runs, ["planner"], metrics=["path_length"]),
    )
    pd.testing.assert_frame_equal(
        compare(
            runs, "fast", "slow", pair="seed", by="scenario", metrics="duration"
        ),
        compare(runs, "fast", "slow", metrics=["duration"]),
    )


def test_equal_values_have_an_interval_of_no_width():
    assert bootstrap_interval(np.full(7, 0.1)) == (0.1, 0.1)


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_values_have_no_interval(count):
    assert np.isnan(bootstrap_interval(np.ones(count))).all()
    runs = pd.DataFrame({"x": [1.0] * count + [math.nan]})
    row = summarize(runs, by=()).loc["x"].iloc[0]
    assert row["n"] == count
    assert math.isnan(row["sd"])
    assert math.isnan(row["mean"]) == (count == 0)


def test_the_seed_decides_and_other_columns_do_not():
    runs = make_runs(LEAST_DRAWN)
    whole = summarize(runs)
    pd.testing.assert_frame_equal(whole, summarize(runs))
    part = summarize(runs, metrics=["duration"])
    for row in part.index:
        assert part.loc[row].tolist() == whole.loc[row].tolist()
    other = summarize(runs, metrics=["duration"], seed=1)
    assert other["low"].iloc[0] != part["low"].iloc[0]


def test_a_higher_confidence_is_wider():
    runs = make_runs()
    narrow = summarize(runs, confidence=0.5, metrics=["path_length"])
    wide = summarize(runs, confidence=0.99, metrics=["path_length"])
    assert (wide["low"] < narrow["low"]).all()
    assert (wide["high"] > narrow["high"]).all()


def test_pairs_see_what_the_spread_over_seeds_hides():
    runs = make_runs()
    table = compare(runs, "fast", "slow")
    row = table.loc["passing", "path_length"]
    assert row["n"] == 7
    assert row["difference"] == pytest.approx(2, abs=0.05)
    assert row["difference"] == pytest.approx(row["b"] - row["a"])
    assert row["low"] > 1.9
    assert row["better"] == "fast"
    # Each by itself, they overlap.
    alone = summarize(runs, metrics=["path_length"]).loc["passing"]
    fast, slow = (alone.loc[p, "path_length"] for p in ("fast", "slow"))
    assert fast["high"] > slow["low"]


def test_which_is_better_is_the_metrics_to_say():
    table = compare(make_runs(), "fast", "slow").loc["crossing"]
    assert table.loc["min_dist_to_people", "better"] == "slow"
    assert table.loc["completed", "better"] is None
    # A longer run is neither better nor worse.
    assert table.loc["duration", "low"] > 0
    assert table.loc["duration", "better"] is None


def test_a_comparison_is_antisymmetric():
    one = compare(make_runs(), "fast", "slow")
    other = compare(make_runs(), "slow", "fast")
    for column in ("difference", "median"):
        assert one[column].to_numpy() == pytest.approx(
            -other[column].to_numpy()
        )
    assert one["sd"].to_numpy() == pytest.approx(other["sd"].to_numpy())
    assert one["better"].tolist() == other["better"].tolist()


def test_only_runs_with_their_like_count():
    runs = make_runs()
    alone = (runs["planner"] == "slow") & (runs["seed"] > 4)
    table = compare(runs[~alone], "fast", "slow")
    assert (table.xs("completed", level="metric")["n"] == 5).all()
    assert (table.drop("completed", level="metric")["n"] == 4).all()
    runs.loc[(runs["seed"] == 0), "path_length"] = math.nan
    table = compare(runs, "fast", "slow").loc["passing"]
    names = ["path_length", "duration", "completed"]
    assert table.loc[names, "n"].tolist() == [6, 7, 8]


def test_the_order_of_runs_does_not_matter():
    runs = make_runs()
    mixed = runs.sample(frac=1, random_state=3)
    a = compare(runs, "fast", "slow")
    b = compare(mixed, "fast", "slow").loc[a.index]
    for column in ("n", "a", "b", "difference", "sd", "median"):
        assert a[column].to_numpy() == pytest.approx(b[column].to_numpy())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda r: summarize(r, by=["robot"]), "'robot'; valid: .*tag"),
        (lambda r: summarize(r, metrics=["speed"]), "no column 'speed'"),
        (lambda r: summarize(r, confidence=1.0), r"in \(0, 1\), got 1.0"),
        (
            lambda r: summarize(r, rates=["duration"]),
            "'duration' is not a rate",
        ),
        (lambda r: summarize(r.iloc[:0]), "nothing to describe: 0 runs"),
        (lambda r: summarize(r, metrics=()), "32 runs, 0 metrics"),
        (lambda r: compare(r, "slow", "slow"), "'slow' cannot be compared wi"),
        (
            lambda r: compare(r.assign(completed=0.5), "fast", "slow"),
            "'completed' is not a rate",
        ),
        (
            lambda r: compare(r, "fast", "dwb"),
            "planner 'dwb'; there are 'fast'",
        ),
        (
            lambda r: compare(r[r["seed"] % 3 == 0], 1, 2, on="seed"),
            "no run has the seed 1; there are 0, 3, 6$",
        ),
        (
            lambda r: WriteFigures(r.drop(columns="planner"), "not_written"),
            "the table of runs has no column 'planner'",
        ),
        (
            lambda r: compare(r, "fast", "slow", by=()),
            "'fast' has more than one run with {'seed': 0}",
        ),
        (
            lambda r: compare(
                r[(r["planner"] == "fast") == (r["seed"] < 4)], "fast", "slow"
            ),
            "no two runs of 'fast' and 'slow' have the same scenario, seed",
        ),
    ],
)
def test_what_makes_no_sense_is_an_error(call, message):
    with pytest.raises(ValueError, match=message):
        call(make_runs())


def test_runs_are_read_from_a_table(tmp_path):
    runs = make_runs()
    path = tmp_path / "runs.csv"
    runs.to_csv(path, index=False)
    pd.testing.assert_frame_equal(ReadRuns(path), runs)
    path.write_text("")
    with pytest.raises(ValueError, match=r"runs\.csv: is not a table"):
        ReadRuns(path)
    with pytest.raises(FileNotFoundError):
        ReadRuns(tmp_path / "nothing.csv")


def test_a_text_among_numbers_is_an_error_of_its_row():
    runs = make_runs()
    runs["path_length"] = runs["path_length"].astype(object)
    whole = summarize(runs, metrics="path_length")
    pd.testing.assert_frame_equal(
        whole, summarize(make_runs(), metrics="path_length")
    )
    assert "path_length" in summarize(runs).index.get_level_values("metric")
    runs.loc[2, "path_length"] = "#DIV/0!"
    rule = "row 3 of the runs: 'path_length' must be a number, or empty, got"
    for call in (
        lambda: summarize(runs),
        lambda: compare(runs, "fast", "slow", metrics="path_length"),
        lambda: plot_distribution(runs, "path_length"),
    ):
        with pytest.raises(ValueError, match=f"{rule} '#DIV/0!'"):
            call()


def test_scenarios_may_be_categories_in_plots():
    runs = make_runs()
    runs["scenario"] = runs["scenario"].astype("category")
    ax = plot_distribution(runs, "path_length")
    assert len(ax.get_lines()) == 4


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_table_needs_commas(tmp_path, separator):
    path = tmp_path / "runs.csv"
    make_runs().to_csv(path, index=False, sep=separator)
    with pytest.raises(ValueError, match="columns must be separated by commas"):
        ReadRuns(path)


def test_texts_that_look_like_numbers_stay_texts(tmp_path):
    path = tmp_path / "runs.csv"
    path.write_text("tag,scenario,planner,seed,path_length\n01,NA,None,3,1.5\n")
    row = ReadRuns(path).iloc[0]
    assert row.tolist() == ["01", "NA", "None", 3, 1.5]


def test_rates_of_one_of_several_robots_are_rates_too():
    runs = make_runs()
    runs["west.completed"] = runs["completed"]
    table = summarize(runs).loc["passing", "fast"]
    of_all, of_one = table.loc["completed"], table.loc["west.completed"]
    assert (of_one["low"], of_one["high"]) == wilson_interval(7.0, 8)
    assert of_all.equals(of_one)
    own = summarize(runs, metrics="west.completed", rates="west.completed")
    assert own.loc[("passing", "fast", "west.completed")].equals(of_one)
    paired = compare(runs, "fast", "slow").loc["passing"]
    pair = ["n", "difference", "low", "high"]
    assert paired.loc["completed", pair].equals(
        paired.loc["west.completed", pair]
    )


def fleet_runs(n=8):
    """Runs of two robots, of which anna never arrives with planner a."""
    rng = np.random.default_rng(0)
    return pd.DataFrame(
        {
            "scenario": "lobby",
            "planner": planner,
            "seed": seed,
            "anna.completed": float(planner == "b"),
            "bob.completed": 1.0,
            "anna.path_length": (2 if planner == "a" else 9) + rng.random(),
            "bob.path_length": 9 + rng.random(),
            "makespan": math.nan if planner == "a" else 20 + rng.random(),
            "deadlock_time": rng.random(),
        }
        for planner in "ab"
        for seed in range(n)
    )


def test_of_several_robots_only_those_that_arrive_are_compared():
    found = compare(fleet_runs(), "a", "b").loc["lobby"]
    assert found.loc["anna.path_length", ["n", "pairs"]].tolist() == [
        0,
        "both arrive",
    ]
    assert found.loc["anna.path_length", "better"] is None
    assert found.loc["bob.path_length", ["n", "pairs"]].tolist() == [8, "all"]
    # What is about all robots needs all of them.
    assert found.loc["deadlock_time", "n"] == 0
    assert found.loc["anna.completed", "better"] == "b"


def test_shorter_ways_of_a_robot_that_does_not_arrive_are_marked():
    found = summarize(fleet_runs()).loc[("lobby", "a")]
    assert early_mark("anna.path_length", found.loc["anna.path_length"]) == "*"
    assert early_mark("bob.path_length", found.loc["bob.path_length"]) == ""
    assert found.loc["makespan", "arrived"] == 0


def test_without_rates_arrivals_are_unknown():
    runs = pd.DataFrame({"scenario": ["x"], "path_length": [1.0]})
    assert np.isnan(arrivals(runs)).tolist() == [True]
