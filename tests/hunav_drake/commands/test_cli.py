import os
from pathlib import Path
import subprocess
import sys
import time

import pytest
import yaml

from hunav_drake.commands.cli import main
from hunav_drake.runs.run_table import ReadRuns
from hunav_drake.scenario import ListScenarios, LoadScenario
from hunav_drake.systems.common.registry import name_of
from hunav_drake.systems.evaluation import Recording
from tests.hunav_drake.passing_trials import make_recording
from tests.processes import run_python


def test_help_answers_at_once():
    command = Path(sys.executable).parent / "hunav"
    times = []
    for _ in range(3):
        started = time.perf_counter()
        done = subprocess.run(
            [command, "--help"], capture_output=True, text=True, check=True
        )
        times.append(time.perf_counter() - started)
    assert "run a trial" in done.stdout
    # The bound has room for a slow machine: NumPy alone takes longer.
    code = "import sys; import hunav_drake.commands.cli; print(*sys.modules)"
    modules = run_python(code).stdout.split()
    assert not {"numpy", "pydrake", "pandas", "yaml"} & set(modules)
    print(f"hunav --help takes {min(times):.2f} s")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "spared"),
    [
        (["check", "passing"], {"pandas", "matplotlib", "PIL", "jinja2"}),
        (["tree", "show", "curious"], {"pandas", "matplotlib", "PIL"}),
        (
            ["run", "passing", "--quiet"],
            {
                *("matplotlib", "PIL", "jinja2", "pandas.core", "ssl"),
                # Of numba, what compiles.
                *("scipy.linalg", "numba.np.arraymath"),
            },
        ),
    ],
    ids=lambda it: it[0] if isinstance(it, list) else "",
)
def test_a_command_loads_no_more_than_it_needs(words, spared):
    """What it loads is most of its time."""
    code = (
        "import sys; from hunav_drake.commands import cli;"
        f" assert cli.main({words!r}) == 0; print(); print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert not spared & set(done.stdout.splitlines()[-1].split())


def test_run_prints_how_it_ended_and_the_metrics(hunav):
    # The first run compiles kernels, which is told: those of leaves when
    # they are first reached.
    hunav("run", "passing")
    code, out, err = hunav("run", "passing")
    assert code == 0
    assert not err
    assert "the robot has reached its goal" in out
    assert "times real time" in out
    assert "more metrics with --all" in out
    for line in out.splitlines():
        assert len(line) <= 80
    row = next(line for line in out.splitlines() if "path_length" in line)
    assert row.split()[0] == "path_length"
    assert 14 < float(row.split()[1]) < 16
    assert row.split()[2] == "m"


def test_run_writes_tables_recording_and_replay(hunav, tmp_path):
    out = tmp_path / "results" / "new"
    arguments = ["run", "passing", "--set", "simulation.duration=1.0"]
    for seed in (0, 1):
        hunav(*arguments, "--out", out, "--seed", seed, "--quiet")
    for seed in (0, 1):
        folder = out / f"runs/passing_pursuit_{seed}"
        assert (folder / "replay.html").exists()
        assert 'href="replay.html"' in (folder / "report.html").read_text()
        assert len(Recording.load(folder / "recording.npz").times) == 11
    assert ReadRuns(out)["seed"].tolist() == [0, 1]


def test_a_run_can_be_filmed(hunav, tmp_path):
    arguments = ["run", "passing", "--set", "simulation.duration=2.0"]
    hunav(*arguments, "--out", tmp_path, "--no-replay", "--seed", 3)
    (run,) = (tmp_path / "runs").iterdir()
    scenario = LoadScenario(filename=str(run / "scenario.yaml"))
    assert scenario.simulation.seed == 3
    film = tmp_path / "film.png"
    options = ("--at", 1.0, "--size", "200x120", "--view", "plot")
    code, out, err = hunav("render", run, "-o", film, *options)
    assert (code, err) == (0, "")
    assert str(film) in out
    assert film.read_bytes().startswith(b"\x89PNG")
    code, _, err = hunav("render", run, "-o", film, *options)
    assert code == 2
    assert "overwrite it with --force" in err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["nothing", "-o", "a.gif"], "no such file or folder; `hunav run"),
        ([".", "-o", "a.gif"], "there is no recording"),
        ([".", "-o", "a.avi"], "must end in one of .gif, .mp4, .png"),
        ([".", "-o", "a.gif", "--at", "1"], "--at 1: is only for a .png"),
        ([".", "-o", "a.png", "--from", "1"], "use --at instead"),
        ([".", "-o", "a.png", "--speed", "4"], "without --fps and --speed"),
        ([".", "-o", "a.png", "--fps", "5"], "without --fps and --speed"),
        ([".", "-o", "no/folder/a.gif"], "there is no folder no/folder"),
    ],
)
def test_a_film_that_cannot_be_is_told(
    hunav, tmp_path, monkeypatch, options, message
):
    monkeypatch.chdir(tmp_path)
    code, out, err = hunav("render", *options)
    assert code == 2
    assert message in err
    assert not out


def test_overlays_are_chosen_by_name(hunav, tmp_path):
    arguments = ["run", "passing", "--set", "simulation.duration=0.5"]
    hunav(*arguments, "--out", tmp_path, "--overlays", "rings,goals")
    (run,) = (tmp_path / "runs").iterdir()
    scenario = LoadScenario(filename=str(run / "scenario.yaml"))
    assert scenario.scene.overlays == ["goals", "rings"]
    with pytest.raises(SystemExit):
        hunav(*arguments, "--overlays", "halo")


def test_run_waits_for_no_browser_where_nobody_is(hunav):
    """The input of tests is no terminal."""
    code, out, _ = hunav(
        "run", "passing", "--set", "simulation.duration=0.2", "--meshcat"
    )
    assert code == 1
    assert "Watch the trial at http://localhost:" in out
    assert "Waiting" not in out


def test_ctrl_c_closes_a_view_whose_run_is_written(
    hunav, tmp_path, monkeypatch
):
    def closed(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("builtins.input", closed)
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(
        "hunav_drake.views.live.WaitForBrowser", lambda meshcat: None
    )
    code, _, err = hunav(
        *("run", "passing", "--set", "simulation.duration=0.2", "--meshcat"),
        *("--out", tmp_path, "--no-replay"),
    )
    assert code == 1
    assert not err
    assert list(tmp_path.glob("runs/*/report.html"))


def test_run_can_leave_the_replay_out(hunav, tmp_path):
    code, _, _ = hunav("run", "passing", "--out", tmp_path, "--no-replay")
    assert code == 0
    assert list(tmp_path.glob("runs/*/report.html"))
    assert not list(tmp_path.glob("runs/*/replay*"))


def test_quiet_prints_one_line(hunav):
    _, out, _ = hunav("run", "passing", "--quiet")
    assert len(out.splitlines()) == 1


def test_settings_seed_and_planner_are_obeyed(hunav, tmp_path):
    settings = ["--set", "robot.radius=0.3", "--set", "humans[0].radius=0.5"]
    code, _, _ = hunav(
        *["run", "passing", "--seed", 7, "--planner", "pursuit"],
        *["--out", tmp_path, "--no-replay", *settings],
    )
    assert code == 0
    recording = Recording.load(next(tmp_path.rglob("*.npz")))
    assert recording.robot[0, 6] == 0.3
    assert recording.humans[0, 0, 6] == 0.5


def test_a_trial_that_does_not_reach_its_goal_exits_with_1(hunav):
    code, out, _ = hunav("run", "passing", "--set", "simulation.duration=1")
    assert code == 1
    assert "the time is over" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "pasing"], "did you mean passing"),
        (["run", "passing", "--planner", "persuit"], "pursuit"),
        (["run", "passing", "--set", "robot.radius=-1"], "--set robot.radius"),
        (["run", "passing", "--set", "robot.raduis=1"], "radius"),
        (["run", "passing", "--set", "robot"], "--set robot"),
        (["run", "/"], "/"),
        (["check", "nowhere.yaml"], "nowhere.yaml"),
        (["import", "nowhere.yaml"], "nowhere.yaml"),
        (["run", "passing", "--out", "/dev/null/out"], "cannot write there"),
    ],
)
def test_bad_input_exits_with_2_and_says_why(hunav, arguments, words):
    code, out, err = hunav(*arguments)
    assert code == 2
    assert words in err
    assert "Traceback" not in out + err


@pytest.mark.parametrize("seed", ["-1", "1.5", "x", str(2**64)])
def test_a_bad_seed_exits_with_2(seed, capsys):
    with pytest.raises(SystemExit) as info:
        main(["run", "passing", f"--seed={seed}"])
    assert info.value.code == 2
    assert "whole number" in capsys.readouterr().err


def test_list_names_the_shipped_scenarios(hunav):
    code, out, _ = hunav("list")
    assert code == 0
    names = [line.split()[0] for line in out.splitlines()]
    assert names == list(ListScenarios())
    assert "passing" in names


def test_check_tells_good_files_from_bad_ones(hunav, tmp_path):
    bad = tmp_path / "bad.yaml"
    bad.write_text("robot: {radius: -1.0}\nhumen: []\n")
    code, out, err = hunav("check", "passing", bad)
    assert code == 2
    assert "passing: ok (2 people, 4 walls, planner pursuit)" in out
    assert f"{bad}:1" in err or "bad.yaml:1" in err
    assert "humans" in err
    assert hunav("check", "passing", "cafe")[0] == 0


def test_import_makes_a_scenario_of_agents_yaml(hunav, reference, tmp_path):
    agents = reference / "hunav" / "agents.yaml"
    output = tmp_path / "my.yaml"
    code, out, _ = hunav(
        *["import", agents, "-o", output],
        *["--metrics", reference / "hunav" / "metrics.yaml"],
    )
    assert code == 0
    assert "5 people" in out
    text = output.read_text()
    assert "threatening" in text
    # It is not lost by a second call.
    code, _, err = hunav("import", agents, "-o", output)
    assert code == 2
    assert "--force" in err
    assert output.read_text() == text
    assert hunav("import", agents, "-o", output, "--force")[0] == 0
    # With behaviors that there are, it can be run.
    for name in ("scared", "threatening", "curious"):
        text = text.replace(f"behavior: {name}", "behavior: regular")
    output.write_text(text)
    scenario = LoadScenario(filename=output)
    assert [human.id for human in scenario.humans] == [1, 2, 3, 4, 5]
    assert hunav("run", output, "--set", "simulation.duration=2")[0] == 0


def test_import_takes_the_map_and_says_what_it_leaves_out(
    hunav, reference, tmp_path
):
    folder = reference / "hunav"
    output = tmp_path / "cafe.yaml"
    code, out, err = hunav(
        *["import", folder / "agents.yaml", "-o", output],
        *["--map", folder / "map_cafe2.yaml", "--profile", "hunavsim"],
    )
    assert code == 0
    assert "5 people and their map" in out
    lines = err.splitlines()
    # A line for each kind of thing, all of which hold for all people.
    people = "agent1, agent2, agent7, agent4, agent5"
    place = folder / "agents.yaml"
    assert lines[0] == f"{place}:4: publish_people: has no meaning here"
    for line, told in zip(
        lines[1:4], ("13: skin", "21: init_pose.z", "32: h"), strict=True
    ):
        assert line.startswith(f"{place}:{told} of {people}: ")
    told = "without a goal it stands still; add --start X Y YAW and --"
    assert told in lines[4]
    assert len(lines) == 5
    # Its map is found from where the file is.
    path = yaml.safe_load(output.read_text())["world"]["map"]
    assert not Path(path).is_absolute()
    assert (tmp_path / path).resolve() == folder / "map_cafe2.yaml"
    start = ["--set", "robot.start=[0, -3, 0]"]
    code, _, err = hunav("check", output, *start)
    assert code == 0
    assert "the robot has no goal, so it stands still for all 60 s" in err
    # Or it is told where the robot is, and where it goes.
    places = ["--start", 0, -3, 0, "--goal", 0, -4, 0, "--force"]
    words = ["import", place, "--map", folder / "map_cafe2.yaml", *places]
    code, _, err = hunav(*words, "-o", output)
    assert (code, len(err.splitlines())) == (0, 4)
    robot = LoadScenario(filename=output).robot
    assert (robot.start, robot.goal) == ((0, -3, 0), (0, -4, 0))
    code, _, err = hunav(*words[:-5], "--goal", "inf", 0, 0)
    assert code == 2
    assert "goal" in err
    code, _, err = hunav("import", folder / "agents.yaml", "--map", output)
    assert code == 2
    assert "unknown key 'description'" in err


def test_doctor_finds_that_a_run_repeats(hunav):
    code, out, _ = hunav("doctor")
    assert code == 0
    assert "bit for bit" in out
    assert "drake" in out


def test_a_closed_pipe_is_no_error(tmp_path):
    command = Path(sys.executable).parent / "hunav"
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [command, "list"], stdout=writer, stderr=subprocess.PIPE, check=False
    )
    os.close(writer)
    assert b"Traceback" not in done.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("word", ["list", "--version"])
def test_an_output_that_is_full_is_told(word):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "hunav_drake.commands.cli", word],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == "hunav: No space left on device\n"


def test_a_closed_output_is_no_error():
    command = f"{sys.executable} -m hunav_drake.commands.cli list >&- 2>&-"
    assert subprocess.run(command, shell=True, check=False).returncode == 0


def test_a_current_folder_that_was_deleted_is_told(
    hunav, tmp_path, monkeypatch
):
    folder = tmp_path / "deleted"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    code, _, err = hunav("list")
    assert code == 2
    assert err.startswith("hunav: the current folder was deleted; go to one")


@pytest.mark.slow
def test_a_name_in_another_script_needs_no_unicode():
    done = subprocess.run(
        [
            *(
                sys.executable,
                "-m",
                "hunav_drake.commands.cli",
                "run",
                "passing",
            ),
            *("--set", "name=愛", "--set", "simulation.duration=1.0"),
        ],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert not done.stderr
    assert "\\u611b, planner pursuit" in done.stdout


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["import", "FILE", "--fps", "3"], "--fps is for recorded people"),
        (
            ["import", "FILE", "--smooth", "0", "--mode", "blind"],
            "--smooth, --mode are for recorded people",
        ),
        (
            ["import", "FILE", "--skip-missing"],
            "--skip-missing is for worlds of Gazebo",
        ),
        (["run", "passing", "--name", "crowd"], "holds one scenario; leave"),
        (
            ["run", "passing", "--set", "robot.type=pmb2", "--relative"],
            "--relative: nobody can be left out",
        ),
        (["risk", "passing", "--fresh"], "--fresh: is for --out"),
        (
            ["risk", "passing", "--set", "simulation.seed=5"],
            "--set simulation.seed=5: would have no effect",
        ),
    ],
)
def test_options_that_would_do_nothing_are_told(hunav, tmp_path, words, told):
    agents = tmp_path / "agents.yaml"
    agents.write_text("hunav_loader: {ros__parameters: {agents: []}}")
    names = {"FILE": agents}
    code, _, err = hunav(*(names.get(word, word) for word in words))
    assert code == 2
    assert told in err


def test_another_planner_has_its_own_parameters(hunav, tmp_path):
    """As in a suite: those of the scenario's planner are not merged in."""
    file = tmp_path / "seen.yaml"
    file.write_text(
        "planner: {type: pursuit, cruise_speed: 0.3, sees: lidar}\n"
        "robot: {goal: [3, 0, 0]}\nsimulation: {duration: 0.2}\n"
    )
    out = tmp_path / "out"
    words = ["run", file, "--planner", "orca", "--out", out, "--no-replay"]
    code, _, _ = hunav(*words, "--set", "planner.period=0.1", "--quiet")
    assert code == 1
    (run,) = (out / "runs").iterdir()
    planner = LoadScenario(filename=run / "scenario.yaml").planner
    assert (planner.period, name_of(planner.sees)) == (0.1, "everything")
    assert list(ReadRuns(out)["setting"]) == ["planner.period=0.1"]


def test_walls_are_taken_from_one_of_several_scenarios(hunav, tmp_path):
    two = tmp_path / "two.yaml"
    wall = "world: {walls: [{type: disc, center: [9, 0], radius: 1}]}"
    two.write_text(f"one: {{{wall}}}\ntwo: {{robot: {{goal: [1, 0, 0]}}}}\n")
    recording = tmp_path / "it.npz"
    make_recording().save(recording)
    code, _, err = hunav("evaluate", recording, "--walls", two)
    assert code == 2
    assert "--name: 'one', 'two'" in err
    code, _, _ = hunav("evaluate", recording, "--walls", two, "--name", "one")
    assert code == 0


def test_a_folder_with_a_dot_takes_drawn_scenarios(hunav, tmp_path):
    folder = tmp_path / "gen.v1"
    folder.mkdir()
    code, _, _ = hunav("generate", "field", "-o", folder, "--seeds", 2)
    assert code == 0
    assert len(list(folder.iterdir())) == 2
