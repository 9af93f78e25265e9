import dataclasses
import io
import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from hunav_drake.runs.result_files import LoadResults
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.evaluation.recording import Recording
from tests.choices import COMMON_METRICS


@pytest.fixture
def recording(tmp_path):
    t = np.arange(21) * 0.1
    robot = np.zeros((21, 7))
    robot[:, 0], robot[:, 3], robot[:, 6] = t, 1.0, 0.35
    humans = np.zeros((21, 1, 7))
    humans[..., 1], humans[..., 6] = 2.0, 0.35
    path = tmp_path / "run 1.npz"
    Recording(times=t, robot=robot, humans=humans).save(path)
    return path


def words(out):
    return {
        line.split()[0]: line.split()[1:] for line in out.splitlines() if line
    }


def test_evaluate_prints_the_table(hunav, recording):
    code, out, err = hunav("evaluate", recording)
    assert (code, err) == (0, "")
    assert out.splitlines()[:2] == [
        "run 1",
        "ended after 2.00 s: end (the recording ends)",
    ]
    table = words(out)
    assert table["path_length"] == ["2.00", "m"]
    assert table["completed"] == ["-"]
    assert max(map(len, out.splitlines())) <= 80
    for name, metric in COMMON_METRICS.items():
        assert name in table
        assert metric.family in table


def test_evaluate_says_how_exact_encounters_are(hunav, recording):
    code, out, err = hunav("evaluate", recording, "--encounters")
    assert (code, err) == (0, "")
    assert words(out)["groups_cut"] == ["0"]
    run = Recording.load(recording)
    period = float(np.diff(run.times).max())
    assert f"up to {period:.3g} s\napart" in out
    assert max(map(len, out.splitlines())) <= 80
    first, other = (dataclasses.replace(run, robot_name=it) for it in "ab")
    # (It is at its goal at once.)
    first = dataclasses.replace(first, end_time=0.0, others=(other,))
    first.save(recording)
    code, out, err = hunav("evaluate", recording, "--encounters")
    assert (code, err) == (0, "")
    assert f"up to {period:.3g} s\napart" in out


def test_evaluate_takes_names_a_goal_and_a_reference(hunav, recording):
    code, out, _ = hunav(
        *("evaluate", recording, "--metrics", "completed", "ade", "danger"),
        *("--goal=2,0", "--reference", recording),
    )
    assert code == 0
    table = words(out)
    assert table["completed"] == ["1"]
    assert table["avg_displacement_error"] == ["0", "m"]
    assert "danger_fear_cost" in table
    assert "path_length" not in table
    for yaw, end in ((0.2, "goal (the robot"), (3, "end (the recording")):
        _, out, _ = hunav("evaluate", recording, f"--goal=2,0,{yaw}")
        assert end in out


def test_what_a_robot_does_after_its_end_does_not_count(hunav, tmp_path):
    """One is pushed off its goal later, and one on to it."""
    rows = np.zeros((3, 7))
    rows[:, 0] = 0, 1, 2
    off, on = (
        Recording(
            times=np.arange(3.0),
            robot=rows,
            humans=np.zeros((3, 0, 7)),
            goal=(x, 0.0, 0.0),
            robot_name=name,
            end_time=1.0,
        )
        for name, x in (("off", 1.0), ("on", 2.0))
    )
    for robots, end in (((off,), "goal"), ((off, on), "end")):
        path = tmp_path / "a.npz"
        first = dataclasses.replace(off, robot_name="a")
        dataclasses.replace(first, others=robots).save(path)
        _, out, _ = hunav("evaluate", path)
        assert f"s: {end} (" in out


def test_the_heading_counts_if_the_goal_has_one(hunav, tmp_path):
    path = tmp_path / "a.csv"
    rows = "".join(f"{k},robot,{k},0,0\n" for k in range(3))
    path.write_text("time,agent,x,y,yaw\n" + rows)

    def completed(*options):
        code, out, _ = hunav(
            "evaluate", path, "--metrics", "completed", *options
        )
        assert code == 0
        return words(out)["completed"][0] == "1"

    assert completed("--goal=2,0")
    assert completed("--goal=2,0,0.24")
    assert not completed("--goal=2,0,0.26")
    assert completed("--goal=2,0,0.26", "--goal-tolerance=0.1,0.3")
    assert not completed("--goal=2,0,0.26", "--goal-tolerance=0.1")
    assert completed("--goal=2.19,0")
    assert not completed("--goal=2.21,0")
    assert completed("--goal=2.21,0", "--goal-tolerance=0.22")


def test_the_heading_of_a_trial_keeps_its_tolerance(hunav, tmp_path):
    Recording(
        times=[0.0],
        robot=np.zeros((1, 7)),
        humans=np.zeros((1, 0, 7)),
        goal_yaw_tolerance=0.5,
    ).save(tmp_path / "a.npz")
    for yaw, word in ((0.4, "goal"), (0.6, "end")):
        _, out, _ = hunav("evaluate", tmp_path / "a.npz", f"--goal=0,0,{yaw}")
        assert f"s: {word} (" in out


def test_walls_may_be_given(hunav, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time,agent,x,y\n0,robot,0,0\n1,robot,1,0\n")
    world = tmp_path / "world.yaml"
    world.write_text(
        "robot: {start: [0, 0, 0], goal: [1, 0, 0]}\n"
        "world: {walls: [{type: polyline, points: [[-5, 1], [5, 1]]}]}\n"
    )

    def run(*options):
        code, out, _ = hunav(
            *("evaluate", path, "--metrics", "clearance", "forces"),
            *("path_efficiency", *options),
        )
        assert code == 0
        assert max(map(len, out.splitlines())) <= 80
        return words(out), "--walls SCENARIO" in out

    table, hint = run()
    assert hint
    for name in ("min_clearance", "social_work", "path_efficiency"):
        assert table[name][0] == "-"
    _, out, _ = hunav("evaluate", path, "--metrics", "path", "stalled_time")
    assert "--walls" not in out
    table, hint = run("--walls", world)
    assert not hint
    assert table["min_clearance"] == ["0.650", "m"]
    assert float(table["obstacle_force_on_robot"][0]) > 0
    assert table["path_efficiency"][0].startswith("1")
    table, hint = run("--walls", "none")
    assert not hint
    assert table["min_clearance"][0] == "-"
    assert float(table["obstacle_force_on_robot"][0]) == 0
    assert table["static_obstacle_collisions"][0] == "0"


def test_evaluate_writes_tables(hunav, recording, tmp_path):
    out = tmp_path / "out"
    code, text, _ = hunav(
        "evaluate", recording, "--out", out, "--format", "hunav"
    )
    assert code == 0
    folder = out / "runs/run_1"
    assert f"Wrote the run to {folder}" in text
    assert ReadRuns(out)["tag"].tolist() == ["run_1"]
    assert pd.read_csv(folder / "metrics.txt", sep="\t")["path_length"][0] == (
        pytest.approx(2.0)
    )
    summary = json.loads((folder / "result.json").read_text())
    assert summary["provenance"]["source"] == "run 1.npz"
    assert len(summary["provenance"]["source_sha256"]) == 64


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing.csv"], "nothing.csv: No such file"),
        (["FILE", "--metrics", "path_lenght"], "did you mean 'path_length'"),
        (["FILE", "--goal", "here"], "--goal must be X,Y or X,Y,YAW"),
        (["FILE", "--goal", "1"], "--goal must be X,Y or X,Y,YAW"),
        (["FILE", "--goal", "1,nan"], "goal: must be finite"),
        (["FILE", "--goal", "1,2,3,4"], "--goal must be X,Y or X,Y,YAW"),
        (
            ["FILE", "--goal-tolerance", "1"],
            "--goal-tolerance: the recording has no goal; add --goal",
        ),
        (
            ["FILE", "--goal=1,2", "--goal-tolerance", "a"],
            "--goal-tolerance must be D or D,YAW in meters and radians",
        ),
        (
            ["FILE", "--goal=1,2", "--goal-tolerance", "0"],
            "goal_tolerance: must be positive",
        ),
        (["FILE", "--walls", "passin"], "--walls: passin: "),
        (["FILE", "--reference", "no.npz"], "no.npz: No such file"),
        (["FILE", "--out", "FILE"], "cannot write there"),
    ],
)
def test_evaluate_tells_what_cannot_be_used(
    hunav, recording, arguments, message
):
    arguments = [recording if a == "FILE" else a for a in arguments]
    code, out, err = hunav("evaluate", *arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert "Traceback" not in err


def test_run_writes_the_format_of_hunavsim(hunav, tmp_path):
    code, _, _ = hunav(
        *("run", "passing", "--set", "simulation.duration=1.0", "--quiet"),
        *("--out", tmp_path, "--no-replay", "--format", "hunav"),
    )
    assert code == 1
    assert (tmp_path / "runs/passing_pursuit_0/metrics.txt").exists()


def test_metrics_lists_all_with_unit_and_direction(hunav):
    code, out, _ = hunav("metrics")
    assert code == 0
    table = words(out)
    for name, metric in METRICS.items():
        assert metric.family in table
        sign = {"lower": "-", "higher": "+"}.get(metric.direction)
        expected = [metric.unit] if sign is None else [sign, metric.unit]
        assert table[name][: len(expected)] == expected
    assert max(map(len, out.splitlines())) <= 120


def test_metrics_show_prints_the_definition(hunav):
    code, out, _ = hunav("metrics", "show", "social_work")
    assert code == 0
    assert out.startswith("social_work [m/s^2]")
    for part in (
        "forces",
        "lower is better",
        "Moussaid",
        "The sum of",
        "HuNav",
    ):
        assert part in out
    _, out, _ = hunav("metrics", "show", "spl", "danger")
    assert "success_weighted_path_length [-]" in out
    assert "danger_fear_cost [1/s]" in out
    assert "also       spl" in out


def test_metrics_show_of_an_unknown_name(hunav):
    code, out, err = hunav("metrics", "show", "social_wok")
    assert (code, out) == (2, "")
    assert "did you mean 'social_work'" in err


DATA = Path(__file__).resolve().parents[2] / "data"


def test_situations_of_a_recording_of_another_program(hunav):
    code, out, err = hunav("situations", DATA / "situations_crossing.csv.gz")
    assert code == 0
    assert "The walls are unknown" in err
    heads = [it.split() for it in out.splitlines() if "label" in it]
    assert heads[0][:3] == ["label", "share", "(%)"]
    assert heads[1][:5] == ["label", "begin", "(s)", "end", "(s)"]
    shares = words(out.partition("\n\n")[0])
    assert shares["cross_path"][:3] == ["29.38", "29.38", "1"]
    code, out, err = hunav(
        "situations", DATA / "situations_crossing.csv.gz", "--csv"
    )
    assert (code, err) == (0, "")
    frame = pd.read_csv(io.StringIO(out))
    assert set(frame["label"]) >= {"empty", "cross_path"}
    assert (frame["end"] - frame["begin"] >= 0.5 - 1e-6).all()


def test_situations_of_several_robots(hunav, recording):
    first = Recording.load(recording)
    robots = dataclasses.replace(
        first,
        robot_name="a",
        others=(dataclasses.replace(first, robot_name="b"),),
    )
    robots.save(recording)
    code, out, err = hunav("situations", recording)
    assert (code, err) == (0, "")
    assert [it.split()[:2] for it in out.splitlines() if it] == [
        *(["robot", "label"], ["a", "empty"], ["a", "standing"]),
        *(["b", "empty"], ["b", "standing"]),
        *(["robot", "label"], ["a", "standing"], ["a", "empty"]),
        *(["b", "standing"], ["b", "empty"]),
    ]
    _, out, _ = hunav("situations", recording, "--csv")
    assert (
        pd.read_csv(io.StringIO(out))["robot"].tolist() == ["a"] * 2 + ["b"] * 2
    )


def test_situations_at_doors(hunav, recording):
    first = Recording.load(recording)
    x, y = first.robot[0, :2]
    assert "at_door" not in hunav("situations", recording)[1]
    words = ["--door=-90,2", f"--door={x},{y + 1}"]
    assert "at_door" in hunav("situations", recording, *words)[1]
    dataclasses.replace(first, doors=[[x, y + 1]]).save(recording)
    assert "at_door" in hunav("situations", recording)[1]
    for text, fault in (("2", "the shape (k, 2)"), ("2,b", "be numbers")):
        code, out, err = hunav("situations", recording, f"--door={text}")
        assert (code, out) == (2, "")
        assert fault in err
        assert err.count("\n") == 1


@pytest.mark.parametrize("text", ["", "time,agent,x,y\n0,human,0,0\n"])
def test_situations_of_what_is_no_recording(hunav, tmp_path, text):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    code, out, err = hunav("situations", path)
    assert (code, out) == (2, "")
    assert err.startswith(f"hunav: {path}: ")
    assert err.count("\n") == 1


def test_evaluate_by_situation(hunav, recording, tmp_path):
    told = hunav("evaluate", recording)[1]
    assert "[" not in told
    code, out, _ = hunav(
        *("evaluate", recording, "--situations", "--out", tmp_path / "out")
    )
    assert code == 0
    table = words(out)
    assert out.startswith(told)
    assert table["path_length[standing]"] == ["1.30", "m"]
    assert table["time_share[standing]"] == ["0.675"]
    runs = ReadRuns(tmp_path / "out")
    assert runs.attrs["units"]["path_length[standing]"] == "m"
    assert runs.attrs["families"]["path_length[standing]"] == "situations"
    (again,) = LoadResults(tmp_path / "out")
    assert again.metrics["path_length[standing]"] == pytest.approx(1.3)
    assert not [it for it in again.by_behavior.columns if "[" in it]
    assert hunav("report", tmp_path / "out")[0] == 0
