"""A broken planner ends a trial, which gives what came up to then."""

import json
import math

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.framework import LeafSystem
import pytest

from hunav_drake import HumanConfig, LoadScenario, RunTrial, SaveScenario
from hunav_drake.scenario import Scenario
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.planning import (
    PLANNERS,
    Plan,
    PlannerConfig,
    PlannerError,
    PlannerStatus,
    register_plan,
    register_planner,
)


@pytest.fixture(autouse=True)
def only_for_a_test(monkeypatch):
    monkeypatch.setattr(PLANNERS, "_choices", dict(PLANNERS))


def trial_with(planner):
    return Scenario(
        planner=planner,
        humans=[HumanConfig(pose=(1, 2, 0))],
        robot={"goal": (3, 0, 0)},
    )


DRIVE = Plan(0.5, 0.0, PlannerStatus.DRIVING)
BREAKS = {
    "raises": lambda: 1 / 0,
    "gives_nan": lambda: Plan(math.nan, 0.0, PlannerStatus.DRIVING),
    "gives_infinity": lambda: Plan(0.5, math.inf, PlannerStatus.DRIVING),
    "gives_nothing": lambda: None,
    "gives_a_text": lambda: "forwards",
}


@pytest.mark.parametrize("name", BREAKS)
def test_a_planner_that_breaks_ends_the_trial(name):
    @register_plan(name)
    def plan(task, view, memory):
        return BREAKS[name]() if view.robot[0] > 0.5 else DRIVE

    result = RunTrial(trial_with(name))
    assert result.end_reason == "planner_failed"
    assert result.end_message.startswith(f"planner '{name}' failed at t = 1.")
    assert 1.0 < result.end_time < 2.0
    # Nothing of it is lost.
    assert result.recording.times[-1] == result.end_time
    assert result.metrics["path_length"] == pytest.approx(0.5, abs=0.06)
    assert np.isfinite(result.recording.robot).all()
    with pytest.raises(PlannerError, match=name):
        RunTrial(trial_with(name), on_planner_error="raise")


@pytest.mark.parametrize("memory", [None, 1])
def test_a_planner_that_never_worked_is_told_too(memory):
    @register_plan("never", initial_memory=memory)
    def plan(task, view, memory):
        raise LookupError("no way")

    result = RunTrial(trial_with("never"))
    assert result.end_reason == "planner_failed"
    assert "failed at t = 0.000 s: LookupError: no way" in result.end_message
    assert result.end_time == 0.0


def test_one_diagram_serves_the_next_trial():
    @register_plan("far")
    def plan(task, view, memory):
        return None if view.robot[0] > 0.5 else DRIVE

    scenario = trial_with("far")
    first, second = (RunTrial(scenario, seed) for seed in (1, 1))
    assert first.end_message == second.end_message
    np.testing.assert_array_equal(first.recording.robot, second.recording.robot)


class OwnSystem(LeafSystem):
    """A planner that is a system: what it commands, a function tells."""

    def __init__(self, task, command):
        super().__init__()
        self._command = command
        self._robot = self.DeclareVectorInputPort("robot_state", STATE_SIZE)
        self.DeclareVectorInputPort(
            "human_states", task.num_humans * STATE_SIZE
        )
        self.DeclareVectorInputPort("goal", 3)
        state = self.DeclareDiscreteState(2)
        self.DeclareStateOutputPort("velocity_command", state)
        self.DeclareVectorOutputPort("status", 1, lambda context, output: None)
        from pydrake.common.value import Value

        self.DeclareAbstractOutputPort(
            "path",
            lambda: Value(np.zeros((0, 2))),
            lambda context, output: None,
        )
        self.DeclarePeriodicDiscreteUpdateEvent(0.05, 0.0, self._Update)

    def _Update(self, context, discrete_state):
        x = self._robot.Eval(context)[0]
        discrete_state.set_value(self._command(x))


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (lambda x: [0.5 / (x <= 0.5), 0.0], "ZeroDivisionError: .*by zero"),
        (
            lambda x: [0.5, math.nan if x > 0.5 else 0.0],
            r"velocity_command must give finite numbers, gives \(0.5, nan\)",
        ),
    ],
)
def test_a_system_that_breaks_ends_the_trial(command, words):
    @register_planner("own_system")
    @dataclass
    class Own(PlannerConfig):
        def MakeSystem(self, task):
            return OwnSystem(task, lambda x: command(float(x)))

    result = RunTrial(trial_with("own_system"))
    assert result.end_reason == "planner_failed"
    with pytest.raises(PlannerError, match=words) as info:
        RunTrial(trial_with("own_system"), on_planner_error="raise")
    assert info.value.planner == "own_system"
    assert 1.0 < info.value.time < 2.0


def test_a_system_that_breaks_ends_the_trial_of_other_robots_too():
    @register_planner("own_system")
    @dataclass
    class Own(PlannerConfig):
        def MakeSystem(self, task):
            return OwnSystem(task, lambda x: [0.5 / (float(x) <= 0.5), 0.0])

    robots = {
        "near": ("[0, 3, 0]", "[0.6, 3, 0]", "pursuit"),
        "far": ("[0, -3, 0]", "[9, -3, 0]", "pursuit"),
        "bad": ("[-1, 0, 0]", "[9, 0, 0]", "own_system"),
    }
    members = "".join(
        f"- {{name: {name}, robot: {{start: {start}, goal: {goal}}},"
        f" planner: {planner}}}\n"
        for name, (start, goal, planner) in robots.items()
    )
    result = RunTrial(LoadScenario(data=f"robots:\n{members}"))
    assert result.robot_ends == {
        "near": "goal",
        "far": "end",
        "bad": "planner_failed",
    }
    assert result.end_reason == "planner_failed"
    assert "planner 'own_system' of 'bad' failed" in result.end_message
    near, far, bad = result.recording.robots
    assert near.end_time < bad.end_time == result.end_time
    assert far.end_time is None


@pytest.mark.parametrize("goal", ["[0.3, 0, 0]", "[9, 0, 0]"])
def test_a_robot_at_its_goal_has_ended_whatever_its_planner_does(goal):
    @register_planner("own_system")
    @dataclass
    class Own(PlannerConfig):
        def MakeSystem(self, task):
            return OwnSystem(task, lambda x: [0.5 / (float(x) <= 0.8), 0.0])

    result = RunTrial(
        LoadScenario(
            data="robots:\n- {name: bad, planner: own_system,"
            f" robot: {{start: [0, 0, 0], goal: {goal}}}}}\n"
            "- {name: far, robot: {start: [0, 3, 0], goal: [9, 3, 0]}}\n"
        )
    )
    ends = {"[0.3, 0, 0]": "goal", "[9, 0, 0]": "planner_failed"}
    assert result.robot_ends == {"bad": ends[goal], "far": "end"}
    assert result.end_reason == "planner_failed"
    assert "planner 'own_system' of 'bad' failed" in result.end_message


def test_a_failure_of_one_of_several_robots_is_raised_if_asked_for():
    @register_plan("far")
    def plan(task, view, memory):
        if view.robot[0] > 0.5:
            raise LookupError("no way")
        return DRIVE

    scenario = LoadScenario(
        data="robots:\n- {name: bad, planner: far, robot: {goal: [9, 0, 0]}}\n"
        "- {name: good, robot: {start: [0, 3, 0], goal: [1, 3, 0]}}\n"
    )
    assert RunTrial(scenario).robot_ends["bad"] == "planner_failed"
    told = r"'far' of 'bad' failed at t = 1\.\d+ s: LookupError: no way"
    with pytest.raises(PlannerError, match=told):
        RunTrial(scenario, on_planner_error="raise")


def test_what_breaks_elsewhere_is_raised():
    def progress(seconds):
        if seconds > 0.5:
            raise ZeroDivisionError("of the caller")

    with pytest.raises(ZeroDivisionError, match="of the caller"):
        RunTrial(trial_with("pursuit"), progress=progress)


MODULE = """
from pydantic.dataclasses import dataclass
from hunav_drake.systems.planning import Plan, Planner, PlannerStatus

@dataclass
class Mine(Planner):
    speed: float = 0.6

    def plan(self, task, view, memory):
        if view.robot[0] > {until}:
            raise ValueError("lost")
        return Plan(self.speed, 0.0, PlannerStatus.DRIVING)
"""


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    """Returns what writes a module to a folder of its own."""
    import sys

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", sys.path.copy())

    def write(name, until):
        (tmp_path / f"{name}.py").write_text(MODULE.format(until=until))
        return tmp_path

    return write


def test_a_scenario_names_a_class_by_its_place(in_folder, monkeypatch):
    folder = in_folder("by_place", 99)
    monkeypatch.syspath_prepend(folder)
    scenario = LoadScenario(
        data="planner: {type: 'by_place:Mine', speed: 0.9}\n"
        "robot: {goal: [3, 0, 0]}\n"
    )
    result = RunTrial(scenario)
    assert result.end_reason == "goal"
    assert result.provenance["planner"] == "by_place:Mine"
    assert LoadScenario(data=SaveScenario(scenario)) == scenario


def test_the_command_runs_a_class_by_its_place(hunav, in_folder):
    in_folder("mine_by_place", 99)
    arguments = ("--quiet", "--planner", "mine_by_place:Mine")
    code, out, err = hunav("run", "passing", *arguments)
    assert (code, err) == (0, "")
    assert "goal" in out
    code, _, err = hunav("run", "passing", "--planner", "mine_by_place:Yours")
    assert code == 2
    assert "has no attribute 'Yours'" in err


@pytest.mark.slow
def test_the_command_tells_a_broken_planner_in_a_line(hunav, in_folder):
    folder = in_folder("mine_broken", -7)
    arguments = ("run", "passing", "--planner", "mine_broken:Mine", "--quiet")
    code, _, err = hunav(*arguments, "--out", "results", "--no-replay")
    assert code == 1
    assert len(err.splitlines()) == 1
    assert err.startswith("hunav: planner 'mine_broken:Mine' failed at t = ")
    assert f"ValueError: lost ({folder}/mine_broken.py:11)" in err
    # What came up to then is kept.
    (summary,) = folder.glob("results/runs/*/*.json")
    assert json.loads(summary.read_text())["end_reason"] == "planner_failed"
    code, _, err = hunav(*arguments, "--debug")
    assert code == 1
    assert "Traceback" in err
    assert 'raise ValueError("lost")' in err


def test_a_system_that_cannot_be_made_is_told_in_a_line(hunav, in_folder):
    folder = in_folder("mine_unmade", 99)
    path = folder / "mine_unmade.py"
    path.write_text(
        path.read_text()
        + """
    def MakeSystem(self, task):
        raise OverflowError("too many people")
"""
    )
    arguments = ("run", "passing", "--planner", "mine_unmade:Mine", "--quiet")
    code, _, err = hunav(*arguments)
    assert code == 2
    assert err == f"hunav: {path}:15: OverflowError: too many people\n"
