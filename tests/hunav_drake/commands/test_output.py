"""What commands print: little by default, all when asked, files before."""

import json
import os
import re
import subprocess
import sys

import numba
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.trial.compiling import compile_time
from hunav_drake.trial.metric_facts import HEADLINE
from tests.choices import COMMON_METRICS
from tests.processes import run_python

SHORT = ["--set", "simulation.duration=1"]


def test_the_version_is_told(capsys):
    from hunav_drake.commands.cli import main

    with pytest.raises(SystemExit) as info:
        main(["--version"])
    assert info.value.code == 0
    pattern = r"hunav_drake \d+\.\S+ \(Python 3\S+, Drake 1\.\S+\)\n"
    assert re.fullmatch(pattern, capsys.readouterr().out)


def test_a_run_prints_the_most_telling_metrics(hunav):
    _, out, _ = hunav("run", "passing", *SHORT)
    lines = out.splitlines()
    assert len(lines) < 22
    headline = [name for name in HEADLINE if name in COMMON_METRICS]
    for name in headline:
        assert sum(line.split()[:1] == [name] for line in lines) == 1
    assert (
        f"{len(COMMON_METRICS) - len(headline)} more metrics with --all"
        in lines
    )


def test_all_metrics_are_printed_when_asked(hunav):
    _, out, _ = hunav("run", "passing", *SHORT, "--all")
    words = {line.split()[0] for line in out.splitlines() if line}
    assert set(COMMON_METRICS) <= words
    assert "more metrics" not in out


def test_a_choice_of_few_metrics_is_shown_whole(hunav):
    few = ["--set", "evaluator.metrics=[path_length, avg_robot_jerk]"]
    _, out, _ = hunav("run", "passing", *SHORT, *few)
    assert "avg_robot_jerk" in out
    assert "completed" not in out
    assert "--all" not in out


def test_a_program_reads_json(hunav, tmp_path):
    _, out, _ = hunav("run", "passing", *SHORT, "--json", "--out", tmp_path)
    data = json.loads(out)
    assert data["end_reason"] == "timeout"
    assert set(COMMON_METRICS) <= set(data["metrics"])
    (recording,) = tmp_path.rglob("*.npz")
    _, out, _ = hunav("evaluate", recording, "--json")
    again = json.loads(out)
    assert again["metrics"]["path_length"] == data["metrics"]["path_length"]
    (file,) = tmp_path.rglob("result.json")
    kept = json.loads(file.read_text())
    assert kept["setting"] == data["setting"] == "simulation.duration=1"
    _, out, _ = hunav("run", "passing", *SHORT, "--json", "--label", "short")
    assert json.loads(out)["setting"] == "short"


@pytest.mark.slow
def test_files_are_written_also_if_nobody_reads_the_output(hunav, tmp_path):
    hunav("run", "passing", *SHORT, "--out", tmp_path / "a", "--no-replay")
    (recording,) = (tmp_path / "a").rglob("*.npz")
    command = [sys.executable, "-m", "hunav_drake.commands.cli"]
    for i, arguments in enumerate(
        (["evaluate", recording], ["run", "passing", *SHORT, "--no-replay"])
    ):
        reader, writer = os.pipe()
        os.close(reader)
        out = tmp_path / f"b{i}"
        done = subprocess.run(
            [*command, *arguments, "--out", out],
            stdout=writer,
            stderr=subprocess.PIPE,
            check=False,
        )
        os.close(writer)
        assert list(out.glob("runs/*/result.json"))
        assert b"Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.slow
@pytest.mark.parametrize("scenario", ["passing", "fleet"])
def test_files_of_a_run_are_written_without_slow_libraries(scenario, tmp_path):
    """What is not needed is not loaded: it would take as long as the trial."""
    run = f"""
import sys
from hunav_drake.commands.cli import main
words = ["--set", "simulation.duration=4", "--out", {str(tmp_path)!r}]
main(["run", "{scenario}", *words])
"""
    # (To compile kernels takes them, in the first process.)
    run_python(run)
    run_python(
        run
        + "slow = {'pandas.core', 'scipy.linalg'} & set(sys.modules)\n"
        + "assert not slow, slow\n"
        + "assert not [it for it in sys.modules if '.planning.dwb' in it]\n"
    )
    page, _ = tmp_path.glob("runs/*/report.html")
    assert "Encounters" in page.read_text()


def test_seed_and_repeat_are_told_apart(hunav, tmp_path):
    for _ in range(2):
        hunav(
            *["run", "passing", *SHORT, "--seed", 2, "--no-replay"],
            *["--out", tmp_path],
        )
    names = sorted(path.name for path in (tmp_path / "runs").iterdir())
    assert names == ["passing_pursuit_2", "passing_pursuit_2_run2"]


@pytest.mark.slow
def test_tables_have_no_rounding_of_binary_digits(hunav, tmp_path):
    hunav("run", "passing", "--no-replay", "--out", tmp_path)
    hunav("report", tmp_path)
    texts = [path.read_text() for path in tmp_path.rglob("*.csv")]
    assert len(texts) > 3
    for text in texts:
        assert not re.search(r"\d\.\d*(0{9}|9{9})\d", text)


def test_compiling_is_measured_apart_and_counted():
    # Not kept on disk: this is to be compiled each time.
    @numba.njit
    def inner(x):
        return x * 3.25

    @numba.njit
    def outer(x):
        return inner(x) + 1.125

    told = []
    with compile_time(lambda it: told.append(it.kernels)) as measured:
        outer(1.0)
    assert measured.kernels >= 2
    assert measured.seconds > 0
    assert told[0] == 0
    assert told[-1] == measured.kernels
    with compile_time(lambda _: told.append(-1)) as again:
        outer(2.0)
    assert (again.kernels, again.seconds) == (0, 0.0)
    assert -1 not in told


def test_who_waits_for_kernels_is_told_so():
    code = (
        "import numba\n"
        "from hunav_drake.trial.compiling import told_compile_time\n"
        "with told_compile_time():\n"
        "    numba.njit(lambda x: x + 1)(1.0)\n"
    )
    done = run_python(code)
    first, last = done.stderr.splitlines()
    assert first == "Compiling kernels (once, up to a minute) ..."
    assert re.fullmatch(r"Compiled \d+ kernels in \d+ s; they are.*", last)


def test_forces_are_drawn_large_enough_to_be_seen():
    from hunav_drake import MakeTrialDiagram, plot_forces

    scenario = LoadScenario("passing")
    diagram = MakeTrialDiagram(scenario)
    context = diagram.CreateDefaultContext()
    ax = plot_forces(
        diagram.GetOutputPort("forces").Eval(context),
        diagram.GetOutputPort("human_states").Eval(context),
    )
    assert ax.figure.get_figwidth() * 72 >= 450


def test_a_trial_has_the_same_numbers_with_and_without_notice(hunav):
    """To measure compiling does not touch the trial."""
    scenario = LoadScenario("passing", overrides=[SHORT[1]])
    plain = RunTrial(scenario).recording
    with compile_time():
        assert RunTrial(scenario).recording == plain
