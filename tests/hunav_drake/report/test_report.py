import os
import re

from matplotlib import pyplot as plt
import numpy as np
import pandas as pd
from PIL import Image
import pytest

from hunav_drake.commands import cli
from hunav_drake.report.tables import number
from hunav_drake.report.writing import WriteReport
from hunav_drake.runs.result_files import LoadResults, WriteResult
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.scenario import LoadScenario
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.trial.quantity_text import label_text, number_text, unit_text
from hunav_drake.trial.simulation import RunTrial
from tests import screenshot
from tests.hunav_drake.passing_trials import (
    make_recording,
    make_result,
    make_results,
)
from tests.hunav_drake.report.pages import visible


def make_batch():
    return make_results(planners=("pursuit", "social"), gain=0.01)


def assert_stands_alone(html):
    assert html.startswith("<!DOCTYPE html>")
    # Nothing is fetched, and nothing is run.
    assert "://" not in html
    assert "@import" not in html
    assert not re.search(r"<(script|link|iframe|img|object|embed|base)\b", html)
    assert not re.search(r"\son\w+=", html)
    for target in re.findall(r'\b(?:href|src|url)\s*[=(]\s*"?([^")>]*)', html):
        assert re.fullmatch(r"#[\w-]+|replay\.html", target), target
    # Names that pictures use are theirs alone.
    names = re.findall(r'\sid="([^"]*)"', html)
    assert len(names) == len(set(names))
    assert set(re.findall(r'href="#([^"]*)"', html)) <= set(names)
    assert set(re.findall(r"url\(#([^)]*)\)", html)) <= set(names)
    # Every tag of the text is closed.
    for tag in ("table", "tr", "div", "figure", "p", "h2", "small", "svg"):
        assert len(re.findall(rf"<{tag}[ >]", html)) == html.count(f"</{tag}>")


def test_a_trial_is_told_in_full(tmp_path):
    result = make_result(
        make_recording(
            range(2),
            y=1.5,
            samples=41,
            start=-2.0,
            behaviors=("regular", "scared"),
            human_names=("ana", "luis"),
        )
    )
    path = WriteReport(result, tmp_path / "report.html")
    html = path.read_text()
    assert_stands_alone(html)
    text = visible(html)
    assert "<h1>passing</h1>" in html
    assert "planner pursuit, seed 0, 2 people, 4.00 s" in text
    assert "The robot has reached its goal." in text
    for name in result.metrics.index:
        assert name in text
        assert METRICS[name].family in text
    assert re.search(r"path_length ↓ 4.00 m ", text)
    assert re.search("luis scared \N{EN DASH} 0.900 3.00 0", text)
    assert "all people regular scared unit" in text
    assert html.count("<svg") == 6
    assert "empty 3.8 3.8 0 0 standing 96.2 96.2 1 3.85" in text
    assert "Watch the replay" not in html


@pytest.mark.slow
def test_each_of_several_robots_has_a_column(tmp_path):
    scenario = LoadScenario(
        data="""
        robots:
          - {name: anna, robot: {start: [-1, 0, 0], goal: [1, 0, 0]}}
          - {name: bob, robot: {start: [1, 3, 0], goal: [2, 3, 0]}}
        humans: [{name: luis, pose: [1, 4, 0], goals: [[1, 5]]}]
        simulation: {duration: 2.0}
        """
    )
    result = RunTrial(scenario)
    html = WriteReport(result, tmp_path / "report.html").read_text()
    text = visible(html)
    assert "metric anna bob all robots unit" in text
    lengths = [result.metrics[f"{it}.path_length"] for it in ("anna", "bob")]
    wanted = " ".join(number(float(it), "m") for it in lengths)
    assert f"path_length ↓ {wanted} m" in text
    # The gap of luis to bob, the closest robot.
    gap = result.metrics["bob.min_dist_to_people"]
    assert f"luis regular \N{EN DASH} {number(float(gap))}" in text


@pytest.mark.slow
def test_many_trials_are_compared(tmp_path):
    path = WriteReport(make_batch(), tmp_path / "r.html", title="My <study>")
    html = path.read_text()
    assert_stands_alone(html)
    text = visible(html)
    assert "<h1>My &lt;study&gt;</h1>" in html
    assert "12 runs, 2 scenarios, 2 planners, 3 seeds" in text
    assert "passing pursuit 3 3" in text
    assert "Bars are means with" in text
    # The mean of 4.00, 4.04 and 4.08 m; 4.303 * 0.04 / sqrt(3) is 0.099.
    assert re.search(r"path_length ↓ 4.04 \[3.94, 4.14\]", text)
    assert re.search(r"crossing social 2 goal 4.00", text)
    assert "seed 0, 1, 2" in text


@pytest.mark.slow
def test_statistics_are_told_in_full(tmp_path):
    trials = []
    for planner, longer in (("pursuit", 0.0), ("social", 0.5)):
        for seed in range(7):
            trial = make_result(planner=planner, seed=seed)
            trial.metrics["path_length"] = 10 + longer + 0.012 * seed
            trial.metrics["completed"] = float(seed > 0)
            trial.metrics["time_to_reach_goal"] = (
                np.nan if seed > 3 else 20.0 + seed + longer
            )
            trials.append(trial)
    html = WriteReport(trials, tmp_path / "r.html").read_text()
    assert_stands_alone(html)
    text = visible(html)
    # Mean of 7, or of 4 where only so many have a value.
    assert re.search(r"path_length ↓ 10.04\* \[10.01, 10.06\] 10.54\*", text)
    assert "time_to_reach_goal ↓ 21.50 [19.45, 23.55] n = 4" in text
    assert re.search(r"completed ↑ 85.7 \[48.7, 97.4\] 85.7 .*? %", text)
    # The spread: n, mean, standard deviation, median.
    assert "path_length ↓ pursuit 7 10.04* [10.01, 10.06] 0.026 10.04 m" in text
    # On equal seeds: both means, their difference, pairs, which is better; of
    # ways only those in which both arrive.
    assert "social \N{MINUS SIGN} pursuit pairs better unit" in text
    told = (
        r"path_length ↓ 10.04 10.54 0.500 \[0.500, 0.500\] 6 arriving pursuit m"
    )
    assert re.search(told, text)
    # No verdict of 3 pairs.
    told = r"_goal ↓ 22.00 22.50 0.500 \[0.500, 0.500\] 3 arriving s"
    assert re.search(told, text)


@pytest.mark.slow
def test_planners_without_equal_seeds_are_not_compared_in_pairs(tmp_path):
    trials = [
        make_result(planner=planner, seed=seed)
        for seed, planner in enumerate("abab")
    ]
    text = visible(WriteReport(trials, tmp_path / "r.html").read_text())
    assert "a and b are not compared: no two runs" in text
    for trial in trials:
        del trial.provenance["seed"]
    text = visible(WriteReport(trials, tmp_path / "r.html").read_text())
    assert "not compared" not in text


@pytest.mark.slow
def test_a_page_does_not_depend_on_the_style_of_the_session(tmp_path):
    pages = []
    for style in ("classic", "dark_background"):
        with plt.style.context(style):
            page = WriteReport(make_result(), tmp_path / "r.html")
            is_dark = plt.rcParams["axes.facecolor"] == "black"
            assert is_dark == (style == "dark_background")
        pages.append(page.read_text())
    assert pages[0] == pages[1]


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_any_script_is_left_to_the_browser(tmp_path):
    result = make_result(
        make_recording(
            human_names=("\u7f8e\u7f8e", "\u0627\u062d\u0645\u062f"),
            behaviors=("\u597d\u5947", "regular"),
        ),
        scenario_name="\u8d70\u5eca",
    )
    html = WriteReport(result, tmp_path / "r.html").read_text()
    for name in result.recording.human_names:
        assert re.search(rf"<text[^>]*>{name}</text>", html)


@pytest.mark.slow
def test_runs_link_to_their_own_pages(tmp_path):
    for seed in range(2):
        folder = WriteResult(make_result(seed=seed), tmp_path)
        (folder / "report.html").touch()
    (folder / "replay.html").touch()
    page = WriteReport(LoadResults(tmp_path), tmp_path / "all.html")
    targets = re.findall(r'<a href="([^"#]*)">(\w+)</a>', page.read_text())
    assert targets == [
        ("runs/passing_pursuit_0/report.html", "report"),
        ("runs/passing_pursuit_1/report.html", "report"),
        ("runs/passing_pursuit_1/replay.html", "replay"),
    ]


@pytest.mark.slow
def test_one_planner_is_not_compared_with_itself(tmp_path):
    trials = [make_result(seed=seed) for seed in range(2)]
    html = WriteReport(trials, tmp_path / "r.html").read_text()
    assert_stands_alone(html)
    assert "Comparison" not in html
    assert "planner pursuit" in visible(html)


@pytest.mark.slow
@pytest.mark.parametrize("n", [0, 2])
@pytest.mark.parametrize("samples", [1, 41])
def test_there_may_be_next_to_nothing_to_tell(tmp_path, n, samples):
    result = make_result(make_recording([0.0] * n, y=1.5, samples=samples))
    html = WriteReport(result, tmp_path / "one.html").read_text()
    assert_stands_alone(html)
    assert not re.search(r"\bnan\b", visible(html), re.IGNORECASE)
    html = WriteReport([result] * 2, tmp_path / "two.html").read_text()
    assert_stands_alone(html)
    assert not re.search(r"\bnan\b", visible(html), re.IGNORECASE)


@pytest.mark.slow
def test_metrics_without_any_value_are_dashes(tmp_path):
    result = make_result()
    result.metrics[:] = np.nan
    for results in (result, [result, result]):
        html = WriteReport(results, tmp_path / "r.html").read_text()
        assert re.search("path_length ↓ \N{EN DASH} ", visible(html))


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_names_are_shown_as_they_are(tmp_path):
    evil = "<b>\"&'</b><script>x</script>"
    trials = [
        make_result(
            make_recording(
                human_names=(evil, "$_"), behaviors=(evil, "regular")
            ),
            scenario_name=evil,
            provenance={"planner": f"{planner}{evil}", "seed": 0, evil: evil},
        )
        for planner in "ab"
    ]
    for results in (trials[0], trials):
        html = WriteReport(results, tmp_path / "r.html").read_text()
        assert_stands_alone(html)
        assert "<b>" not in html
        assert "&lt;b&gt;&#34;&amp;&#39;&lt;/b&gt;" in html


@pytest.mark.slow
def test_the_report_links_to_the_replay_beside_it(tmp_path):
    replay = tmp_path / "replay.html"
    path = WriteReport(make_result(), tmp_path / "r.html", replay=replay)
    assert '<a href="replay.html">' in path.read_text()
    assert_stands_alone(path.read_text())
    odd = tmp_path / 'a "b" #' / "replay.html"
    path = WriteReport(make_result(), tmp_path / "r.html", replay=odd)
    assert '<a href="a%20%22b%22%20%23/replay.html">' in path.read_text()


@pytest.mark.slow
def test_the_same_results_are_the_same_report(tmp_path):
    for results in (make_result(), [make_result(seed=s) for s in (0, 1)]):
        pages = [tmp_path / "1.html", tmp_path / "2.html"]
        for page in pages:
            WriteReport(results, page)
        assert pages[0].read_bytes() == pages[1].read_bytes()


@pytest.mark.slow
def test_no_figure_stays_open(tmp_path):
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    WriteReport(make_result(), tmp_path / "r.html")
    assert plt.get_fignums() == before


@pytest.mark.slow
def test_a_report_that_fails_leaves_the_old_one(tmp_path, monkeypatch):
    path = WriteReport(make_result(), tmp_path / "r.html")
    before = path.read_bytes()

    def fail(source, target):
        raise OSError(28, "No space left on device", target)

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="No space left"):
        WriteReport(make_result(seed=3), path)
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["r.html"]


def test_a_report_on_nothing_is_refused(tmp_path):
    with pytest.raises(ValueError, match="needs at least one result"):
        WriteReport([], tmp_path / "r.html")
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (np.nan, "m", "\N{EN DASH}"),
        (np.inf, "s", "\N{INFINITY}"),
        (3.0, "-", "3"),
        (0.0, "m", "0"),
        (12.345, "%", "12.3"),
        (0.12345, "m", "0.123"),
        (-1.2345, "m", "\N{MINUS SIGN}1.23"),
        (123.45, "m", "123.5"),
        (1234.5, "m", "1234"),
        (1.2e-7, "m", "1.2\N{MULTIPLICATION SIGN}10⁻⁷"),
        (1.2e7, "m", "1.2\N{MULTIPLICATION SIGN}10⁷"),
    ],
)
def test_numbers_have_sensible_digits(value, unit, text):
    assert number(value, unit) == text


def test_units_have_raised_powers():
    assert unit_text("m/s^2") == "m/s²"
    assert unit_text("s^-12") == "s⁻¹²"
    assert unit_text("-") == ""
    assert label_text("a", "m") == "a (m)"
    assert label_text("a", "-") == "a"


@pytest.mark.parametrize("value", [4.2e-16, -3.6e-9, 0.0])
@pytest.mark.parametrize("unit", ["rad/m", "-", "%"])
def test_rounding_is_shown_as_nothing(value, unit):
    assert number_text(value, unit) == "0"


def test_numbers_of_one_scale_have_as_many_decimals():
    texts = [number_text(value, scale=0.5) for value in (-5.5e-4, -0.0048)]
    assert texts == ["-0.001", "-0.005"]
    assert number_text(0.48, scale=1.34) == "0.48"
    assert number_text(-0.001, scale=1.34) == "0.00"


# --- the results of a folder ---


@pytest.mark.slow
def test_results_come_back_from_a_folder(tmp_path):
    trials = [
        make_result(make_recording(behaviors=("regular", "scared")), seed=seed)
        for seed in range(2)
    ]
    for trial in trials:
        WriteResult(trial, tmp_path)
    loaded = LoadResults(tmp_path)
    assert len(loaded) == 2
    for trial, again in zip(trials, loaded, strict=True):
        pd.testing.assert_series_equal(again.metrics, trial.metrics)
        assert again.metrics.attrs == trial.metrics.attrs
        pd.testing.assert_frame_equal(again.steps, trial.steps)
        pd.testing.assert_frame_equal(again.by_behavior, trial.by_behavior)
        assert again.recording == trial.recording
        assert again.provenance == trial.provenance
        assert again.end_reason == trial.end_reason
        assert again.end_time == trial.end_time
    WriteReport(loaded, tmp_path / "again.html")
    WriteReport(trials, tmp_path / "first.html")
    pages = [(tmp_path / f"{n}.html").read_text() for n in ("again", "first")]
    assert pages[0] == pages[1]


@pytest.mark.slow
def test_a_metric_of_another_program_keeps_its_value(tmp_path):
    WriteResult(make_result(), tmp_path, tag="01")
    # Without the log, a run's own file tells.
    (tmp_path / "runs.jsonl").unlink()
    path = tmp_path / "runs/01/result.json"
    text = path.read_text()
    path.write_text(text.replace('"path_length"', '"my_length"'))
    (result,) = LoadResults(tmp_path)
    assert result.metrics["my_length"] == pytest.approx(1.0)
    html = WriteReport(result, tmp_path / "r.html").read_text()
    assert "my_length ↓ 1.00 m" in visible(html)


@pytest.mark.slow
def test_the_command_reports_on_all_runs_of_a_folder(tmp_path, capsys):
    for seed in range(2):
        WriteResult(make_result(seed=seed), tmp_path)
    assert cli.main(["report", str(tmp_path), "--title", "Two runs"]) == 0
    text = capsys.readouterr().out
    assert "report on 2 runs" in text
    assert f"metrics to {tmp_path / 'runs.csv'}" in text
    pd.testing.assert_frame_equal(
        ReadRuns(tmp_path / "runs.csv"), ReadRuns(tmp_path), check_dtype=False
    )
    html = (tmp_path / "report.html").read_text()
    assert "<h1>Two runs</h1>" in html
    assert_stands_alone(html)


@pytest.mark.slow
def test_the_command_links_the_replay_of_a_single_run(tmp_path):
    (WriteResult(make_result(), tmp_path) / "replay.html").touch()
    other = tmp_path / "other" / "my.html"
    other.parent.mkdir()
    assert cli.main(["report", str(tmp_path), "-o", str(other)]) == 0
    text = other.read_text()
    assert 'href="../runs/passing_pursuit_0/replay.html"' in text


@pytest.mark.slow
def test_the_command_reports_on_what_can_be_read(tmp_path, capsys):
    for seed in range(4):
        WriteResult(make_result(seed=seed), tmp_path)
    runs = tmp_path / "runs"
    (runs / "passing_pursuit_1/recording.npz").write_bytes(b"no zip")
    (runs / "passing_pursuit_2/result.json").unlink()
    # The log would tell of that one.
    (tmp_path / "runs.jsonl").unlink()
    assert cli.main(["report", str(tmp_path)]) == 0
    captured = capsys.readouterr()
    assert "report on 2 runs" in captured.out
    assert len(captured.err.splitlines()) == 2
    text = visible((tmp_path / "report.html").read_text())
    lines = sorted(captured.err.splitlines())
    for line, seed in zip(lines, (1, 2), strict=True):
        assert f"left out the run passing_pursuit_{seed}: " in line
        assert f"Left out: passing_pursuit_{seed}." in text
    for seed in (0, 3):
        (runs / f"passing_pursuit_{seed}/result.json").write_text("{")
    assert cli.main(["report", str(tmp_path)]) == 2
    assert "no run to report on" in capsys.readouterr().err


def test_the_command_says_how_to_make_a_folder(tmp_path, capsys):
    assert cli.main(["report", str(tmp_path / "none")]) == 2
    error = capsys.readouterr().err
    assert "none: No results are there. `hunav run SCENARIO --out " in error


def test_the_command_says_where_the_page_cannot_be(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    WriteResult(make_result(), tmp_path)
    assert cli.main(["report", ".", "-o", "no/r.html"]) == 2
    error = capsys.readouterr().err
    told = "hunav: no/r.html: there is no folder no; make it first\n"
    assert error == told


@pytest.mark.slow
def test_each_run_writes_its_own_report(tmp_path, capsys):
    for seed in "01":
        code = cli.main(
            [
                *("run", "passing", "--quiet", "--no-replay", "--seed", seed),
                *("--set", "simulation.duration=1.0", "--out", str(tmp_path)),
            ]
        )
        assert code == 1
        path = tmp_path / f"runs/passing_pursuit_{seed}/report.html"
        assert f"Report, for a browser: {path}" in capsys.readouterr().out
        html = path.read_text()
        assert_stands_alone(html)
        assert "Watch the replay" not in html
        assert f"seed {seed}" in visible(html)
    assert not (tmp_path / "report.html").exists()
    assert cli.main(["report", str(tmp_path)]) == 0
    assert path.read_text() == html
    assert (
        str(path.relative_to(tmp_path))
        in (tmp_path / "report.html").read_text()
    )


def test_if_the_report_cannot_be_written_there_is_no_run(
    tmp_path, capsys, monkeypatch
):
    def fail(*args, **kwargs):
        raise OSError(28, "No space left on device", "report.html")

    monkeypatch.setattr("hunav_drake.report.writing.WriteReport", fail)
    command = ["run", "passing", "--quiet", "--no-replay"]
    assert cli.main([*command, "--out", str(tmp_path)]) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert os.listdir(tmp_path / "runs") == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [420, 1100])
def test_the_report_can_be_looked_at(tmp_path, width):
    results = make_result(make_recording(behaviors=("regular", "scared")))
    page = WriteReport(results, tmp_path / "report.html")
    png = screenshot.render(page, tmp_path / "r.png", size=(width, 1500))
    with Image.open(png) as image:
        pixels = np.asarray(image.convert("RGB"), dtype=float)
    # Dark text and colored lines on white, with white margins.
    assert 0.5 < np.mean(pixels.min(axis=2) > 250) < 0.99
    assert np.mean(pixels.max(axis=2) < 80) > 0.002
    assert np.mean(np.ptp(pixels, axis=2) > 60) > 0.002
    assert pixels[:, :10].min() > 250
    assert pixels[:, -10:].min() > 250
