"""Branches of a trial from one instant: what would be if."""

import json

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    GetTrialResult,
    LeaveOut,
    ListScenarios,
    LoadContext,
    LoadScenario,
    MakeHumans,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RobotGone,
    RobotStands,
    RunBranches,
    SaveContext,
    ScenarioError,
    SetRobotCommand,
    Without,
    WithoutPerson,
    WithPlanner,
    WithSettings,
)
from hunav_drake.report.branches_page import WriteBranchesPage
from hunav_drake.report.summary import branches_summary
from hunav_drake.systems.common.layout import OUTSIDE, VX, X, Y
from hunav_drake.trial.branches.kinds import Branch, RobotShifted
from hunav_drake.trial.branches.run import SAME, Fork, growth_text
from hunav_drake.trial.leaving import why_nobody_leaves
from tests.planners import NAMES, planner_override

FAST = [
    *(("crossing", "pursuit"), ("passing", "orca")),
    *(("cafe", "dwb"), ("fleet", "pursuit")),
]
PHYSICAL = ("robot.type=pmb2",)


def at(scenario, time):
    """Returns the diagram of a scenario, and its Context at a time."""
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram, ends=False)
    if time:
        simulator.AdvanceTo(time)
    return diagram, simulator.get_context()


def crossing(*overrides):
    return LoadScenario(filename="crossing", overrides=[*overrides])


def stage(people, *overrides, **more):
    """Returns a scenario of some people, in the open."""
    data = {
        "humans": people,
        "robot": {"start": [-3, 0.4, 0], "goal": [6, 0.4, 0]},
        "simulation": {"duration": 20.0},
        **more,
    }
    return LoadScenario(data=json.dumps(data), overrides=[*overrides])


def walker(name, x, y, goal_x, **more):
    yaw = 0.0 if goal_x > x else np.pi
    goals = [[goal_x, y]]
    return {"name": name, "pose": [x, y, yaw], "goals": goals, **more}


PAIR = [walker("ana", 5, 0, -6), walker("luis", 6, 1, -6)]


def scenarios_and_planners():
    """Returns each scenario with two planners, and each planner in turn.

    (With all seven it takes three minutes of CPU more.)
    """
    for k, name in enumerate(ListScenarios()):
        for shift in (0, 3):
            pair = name, NAMES[(k + shift) % len(NAMES)]
            if pair not in FAST:
                yield pytest.param(*pair, marks=pytest.mark.slow)
    yield from FAST


@pytest.mark.slow
@pytest.mark.parametrize(("name", "planner"), [*scenarios_and_planners()])
def test_nothing_changes_nothing(name, planner):
    """A state in a diagram whose people may leave goes on bit for bit."""
    scenario = LoadScenario(
        filename=name, overrides=[planner_override(planner)]
    )
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram, ends=False)
    for instant in (1.0, 4.0, 7.0):
        simulator.AdvanceTo(instant)
        fork = Fork(
            scenario,
            diagram,
            simulator.get_context(),
            until=instant + 2.0,
            may_leave=True,
        )
        fork.CheckSame(fork.RunOriginal(), fork.Run(Branch()))


@pytest.mark.slow
def test_a_physical_robot_goes_on_alike_and_stands():
    scenario = crossing(*PHYSICAL)
    diagram, context = at(scenario, 2.0)
    made = RunBranches(
        scenario,
        diagram,
        context,
        until=4.0,
        reference=SAME,
        branches={"stands": RobotStands(), "dwb": WithPlanner("dwb")},
    )
    (robot,) = made.futures["stands"].robots.values()
    assert abs(robot[-1, VX : VX + 2]).max() < 0.01
    words = r"lacks Shift\(context, ...\); do not ask for the growth"
    with pytest.raises(ValueError, match=words):
        RunBranches(
            *(scenario, diagram, context),
            **{"until": 4.0, "branches": {}, "reference": SAME, "growth": True},
        )
    for branch, words in (
        (RobotGone(), "physical, or its system lacks SetPose"),
        (WithoutPerson("ana"), "is physical, and needs people who are there"),
    ):
        with pytest.raises(ValueError, match=words):
            RunBranches(
                scenario, diagram, context, until=4.0, branches={"it": branch}
            )


@pytest.mark.slow
def test_the_trial_itself_is_not_changed():
    scenario = crossing()
    diagram, context = at(scenario, 3.0)
    before = context.Clone()
    made = [
        RunBranches(
            scenario,
            diagram,
            context,
            until=8.0,
            branches={"no ana": WithoutPerson("ana")},
        )
        for _ in range(2)
    ]
    for name in ("human_states", "robot_state"):
        port = diagram.GetOutputPort(name)
        np.testing.assert_array_equal(port.Eval(context), port.Eval(before))
    assert made[0].people.equals(made[1].people)
    assert made[0].metrics.equals(made[1].metrics)


@pytest.mark.slow
@pytest.mark.parametrize("instant", [0.0, 2.0])
def test_who_is_far_away_is_not_missed(instant):
    """A placebo: for the others, all stays the same, bit for bit."""
    far = walker("far", 9e4, 9e4, 9e4 - 50)
    scenario = stage([*PAIR, far])
    diagram, context = at(scenario, instant)
    fork = Fork(scenario, diagram, context, until=12.0)
    same, without = fork.Run(Branch()), fork.Run(WithoutPerson("far"))
    np.testing.assert_array_equal(same.humans[:, :2], without.humans[:, :2])
    np.testing.assert_array_equal(same.robots["robot"], without.robots["robot"])
    assert np.isnan(without.humans[:, 2]).all()


@pytest.mark.parametrize("group", [-1, 3])
def test_without_a_person_from_the_start_is_a_scenario_without(group):
    """Also for a group, which walks on without her."""
    people = [
        walker("ana", 5, 0, -6, group_id=group),
        walker("eva", 5.6, 0.8, -6, group_id=group),
        walker("luis", 5.2, -0.9, -6, group_id=group),
    ]
    whole, less = stage(people), stage([people[0], people[2]])
    found = []
    for scenario, branch in ((whole, WithoutPerson("eva")), (less, Branch())):
        diagram, context = at(scenario, 0.0)
        fork = Fork(scenario, diagram, context, until=12.0)
        found.append(fork.Run(branch))
    np.testing.assert_array_equal(found[0].humans[:, [0, 2]], found[1].humans)
    np.testing.assert_array_equal(
        found[0].robots["robot"], found[1].robots["robot"]
    )


def test_without_a_robot_is_a_crowd_of_no_robots():
    scenario = stage(PAIR)
    diagram, context = at(scenario, 0.0)
    future = Fork(scenario, diagram, context, until=10.0).Run(RobotGone())
    assert future.robots == {}
    alone = MakeHumans(scenario.humans, num_robots=0)
    simulator = Simulator(alone)
    simulator.AdvanceTo(10.0)
    port = alone.GetOutputPort("human_states")
    np.testing.assert_array_equal(
        port.Eval(simulator.get_context()), future.humans[-1].ravel()
    )


def test_a_robot_that_stands_brakes_within_its_limits():
    scenario = stage([])
    diagram, context = at(scenario, 3.0)
    made = RunBranches(
        scenario,
        diagram,
        context,
        until=6.0,
        reference=SAME,
        branches={
            "stands": RobotStands(),
            "at once": RobotStands(at_once=True),
        },
    )
    braking = made.futures["stands"].robots["robot"]
    speed = braking[:, VX]
    assert speed[0] > 0.3
    assert speed[-1] == 0
    most = scenario.robot.limits.max_acceleration * 0.05
    assert -np.diff(speed).min() == pytest.approx(most)
    # From the very first step on.
    assert speed[0] - speed[1] == pytest.approx(most)
    way = made.futures["at once"].robots["robot"][:, X]
    assert (way == way[0]).all()
    assert made["stands"].end_reason == "running"


def test_the_held_command_drives_the_robot():
    scenario = stage([], "planner=external")
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(1.0)
    robot = diagram.GetOutputPort("robot_state")
    assert robot.Eval(simulator.get_context())[X] == -3
    SetRobotCommand(diagram, simulator.get_mutable_context(), [0.4, 0.2])
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(4.0)
    moved = robot.Eval(simulator.get_context())
    assert np.hypot(*moved[VX : VX + 2]) == pytest.approx(0.4)
    assert moved[5] == pytest.approx(0.2)
    fork = MakeTrialSimulator(diagram, clone)
    fork.AdvanceTo(4.0)
    np.testing.assert_array_equal(robot.Eval(fork.get_context()), moved)
    with pytest.raises(ValueError, match="two finite numbers"):
        SetRobotCommand(diagram, clone, [0.4, np.nan])
    with pytest.raises(ValueError, match="there is no robot 'b'"):
        SetRobotCommand(diagram, clone, [0.4, 0.0], "b")


@pytest.mark.parametrize("sees", ["lidar", "detector", "visible"])
def test_a_held_command_follows_a_planner_of_any_perception(sees):
    scenario = stage(PAIR, f"planner={{type: pursuit, sees: {sees}}}")
    diagram, context = at(scenario, 1.0)
    made = RunBranches(
        scenario,
        diagram,
        context,
        until=2.0,
        reference=SAME,
        branches={"held": WithPlanner("external")},
    )
    # The command of the planner stays.
    speeds = made.futures["held"].robots["robot"][1:, VX]
    assert np.ptp(speeds) == 0
    assert speeds[0] > 0.1


@pytest.mark.slow
def test_results_are_of_the_time_from_the_instant_to_the_end():
    scenario = crossing()
    diagram, context = at(scenario, 4.0)
    made = RunBranches(
        scenario,
        diagram,
        context,
        until=30.0,
        branches={"dwb": WithPlanner("dwb", {"period": 0.1})},
    )
    assert list(made.futures) == ["same", "dwb", "robot gone"]
    for name in ("same", "dwb"):
        result = made[name]
        assert result.recording.times[0] == 4.0
        assert result.end_reason == "goal"
        assert result.recording.times[-1] == pytest.approx(result.end_time)
        assert made.futures[name].times[-1] == 30.0
        assert result.provenance["branch"] == name
    assert made["same"].provenance["from_context_sha256"]
    with pytest.raises(KeyError, match="has no robot, and so no result"):
        made["robot gone"]
    assert made["dwb"].provenance["planner"] == "dwb"
    assert set(made.metrics["branch"]) == {"same", "dwb"}
    people = made.people
    assert len(people) == 3 * 4 * 4
    own = people[people["branch"] == "robot gone"]
    assert (own["difference"] == 0).all()
    sums = people.groupby(["branch", "quantity"])["difference"].sum()
    for name in made.futures:
        assert made.totals.loc[name, "time"] == pytest.approx(
            sums[name, "time"]
        )
    late = made.delays("same")
    assert (late.iloc[0].dropna() == 0).all()
    arrived = people[
        (people["branch"] == "same") & (people["quantity"] == "time")
    ].set_index("person")
    # On the arrival, the delay is the extra time.
    luis = late["luis"].dropna()
    assert luis.iloc[-1] == pytest.approx(
        arrived.loc["luis", "difference"], abs=0.06
    )


@pytest.mark.parametrize("step", [0.02, 0.1])
def test_other_time_steps_have_all_their_steps(step):
    # (Of a planner that keeps to it; 0.3 s is less than 3 of 0.1 s, and so is
    # 1.7 s than 17.)
    scenario = crossing(f"simulation.time_step={step}", "planner.period=0.1")
    diagram, context = at(scenario, 0.3)
    branches = RunBranches(
        scenario,
        diagram,
        context,
        until=1.7,
        branches={"stands": RobotStands(), "no": WithoutPerson("ana")},
    )
    for future in branches.futures.values():
        np.testing.assert_allclose(np.diff(future.times), step)
        assert future.times[[0, -1]] == pytest.approx([0.3, 1.7])


def test_arrivals_are_exact_within_a_step():
    """The step does not matter to who walks straight at a steady speed."""
    people = [walker("ana", 0, 0, 8.0, goal_radius=0.5, desired_speed=1.0)]
    found = []
    for step in (0.05, 0.1):
        scenario = stage(
            people,
            f"simulation.time_step={step}",
            f"planner.period={step}",
            robot={"start": [0, 500, 0]},
            crowd={"profile": "hunavsim"},
        )
        diagram, context = at(scenario, 3.0)
        future = Fork(scenario, diagram, context, until=12.0).Run(Branch())
        (arrival,) = future.arrivals
        after = np.searchsorted(future.times, arrival)
        row = future.humans[after, 0]
        late = future.times[after] - arrival
        # (A goal counts as reached 0.1 m from its radius.)
        assert row[X] - row[VX] * late == pytest.approx(8 - 0.6, abs=1e-12)
        assert future.quantities["path"][0] == pytest.approx(
            7.4 - future.humans[0, 0, X], abs=1e-12
        )
        found.append(arrival)
    assert found[0] == pytest.approx(found[1], abs=0.05)


@pytest.mark.slow
def test_later_goals_and_who_never_arrives():
    people = [
        {"name": "ana", "pose": [0, 0, 0], "goals": [[2, 0], [4, 0]]},
        walker("luis", 0, 5, 90.0),
        {"name": "eva", "pose": [0, 9, 0], "goals": []},
    ]
    scenario = stage(people, robot={"start": [0, 500, 0]})
    diagram, context = at(scenario, 0.0)
    first, second = (
        Fork(scenario, diagram, context, until=15.0, goal=k).Run(Branch())
        for k in (0, 1)
    )
    assert first.arrivals[0] < second.arrivals[0]
    assert np.isnan(first.arrivals[1:]).all()
    assert np.isnan(second.arrivals[1:]).all()
    made = RunBranches(
        scenario, diagram, context, until=15.0, branches={}, reference=SAME
    )
    table = made.people.set_index(["person", "quantity"])
    assert table.loc[("luis", "time"), "censored"] == 1
    assert table.loc[("ana", "time"), "censored"] == 0
    assert made.totals.loc[SAME, "people"] == 1


@pytest.mark.slow
def test_the_order_of_people_does_not_matter():
    people = [*PAIR, walker("eva", -6, 0.5, 6)]
    branches = {"no eva": WithoutPerson("eva"), "stands": RobotStands()}
    tables = []
    for order in (people, people[::-1]):
        scenario = stage(order)
        diagram, context = at(scenario, 2.0)
        made = RunBranches(
            scenario, diagram, context, until=14.0, branches=branches
        )
        keys = ["branch", "person", "quantity"]
        tables.append(made.people.set_index(keys)["difference"].sort_index())
    np.testing.assert_allclose(tables[0], tables[1], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("y", "low", "high"), [(0.0, 1000.0, np.inf), (0.3, 0.01, 100.0)]
)
def test_small_differences_grow_where_anything_decides_who_passes_where(
    y, low, high
):
    """Exactly head-on, 1 um decides on which side the robot passes."""
    robot = {"start": [-4, 0, 0], "goal": [6, 0, 0]}
    person = walker("ana", 4, y, -6, behavior="impassive")
    scenario = stage([person], planner_override("orca"), robot=robot)
    made = RunBranches(
        scenario,
        *at(scenario, 1.0),
        until=14.0,
        branches={},
        reference=SAME,
        growth=True,
    )
    assert low < made.growth < high
    summary = " ".join(branches_summary(made))
    assert ("may be chance" in summary) == (made.growth > 1000)
    assert "1 um aside" in summary


def test_growth_is_told_with_two_digits():
    assert "may be chance" not in growth_text(994.0)
    assert "1000 um later, at most. So" in growth_text(999.5)
    assert growth_text(np.nan) == ""


def test_a_robot_that_nobody_meets_moves_nobody():
    far = {"start": [-900, 0, 0], "goal": [-890, 0, 0]}
    scenario = stage([walker("ana", 4, 0, -6)], robot=far)
    options = {"until": 3.0, "branches": {}}
    fork = at(scenario, 1.0)
    assert RunBranches(scenario, *fork, **options, growth=True).growth == 0.0
    assert np.isnan(RunBranches(scenario, *fork, **options).growth)
    alone = stage([])
    made = RunBranches(alone, *at(alone, 1.0), **options, growth=True)
    assert np.isnan(made.growth)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("evaluator.timeout=0.5", "ended at 0.5 s; take an earlier instant"),
        ("evaluator.start=by_trigger", "trigger is not high; set it"),
    ],
)
def test_branches_of_which_nothing_is_recorded_are_refused(
    monkeypatch, override, words
):
    monkeypatch.delattr(Fork, "Run")
    scenario = stage(PAIR, override)
    diagram, context = at(scenario, 0.0)
    if diagram.HasInputPort("trigger"):
        diagram.GetInputPort("trigger").FixValue(context, 0.0)
    MakeTrialSimulator(diagram, context).AdvanceTo(1.0)
    with pytest.raises(ValueError, match=words):
        RunBranches(scenario, diagram, context, until=3.0, branches={})


@pytest.mark.slow
def test_differences_grow_of_the_robot_that_is_asked_for():
    scenario = LoadScenario(filename="three_robots")
    fork = at(scenario, 1.0)
    grown = [
        RunBranches(
            scenario,
            *fork,
            until=5.0,
            branches={"growth": RobotStands("east")},
            reference=SAME,
            growth=name,
        ).growth
        for name in (True, "east")
    ]
    assert grown[0] < 0.01 < grown[1]


def test_other_settings_and_files(tmp_path):
    scenario = crossing()
    diagram, context = at(scenario, 3.0)
    SaveContext(diagram, context, tmp_path / "at_3.npz")
    loaded = LoadContext(diagram, tmp_path / "at_3.npz")
    branches = {"gap": WithSettings(("crowd.robot_gap=0.4",))}
    made = [
        RunBranches(scenario, diagram, it, until=6.0, branches=branches)
        for it in (context, loaded)
    ]
    assert made[0].people.equals(made[1].people)
    hashes = {it["gap"].provenance["from_context_sha256"] for it in made}
    assert len(hashes) == 1


@pytest.mark.slow
def test_one_of_several_robots_and_people_of_sources():
    scenario = LoadScenario(filename="fleet")
    diagram, context = at(scenario, 2.0)
    first, second = (part.name for part in scenario.robots[:2])
    made = RunBranches(
        scenario,
        diagram,
        context,
        until=4.0,
        branches={
            "robot gone": RobotGone(second),
            "dwb": WithPlanner("dwb", robot=second),
        },
    )
    assert second not in made.futures["robot gone"].robots
    assert first in made.futures["robot gone"].robots
    table = made.metrics
    own = table[table["branch"] == "robot gone"]["metric"]
    assert {it.partition(".")[0] for it in own} == {
        part.name for part in scenario.robots if part.name != second
    }
    # Who is gone has no part in the result.
    left = made["robot gone"]
    assert [it.robot_name for it in left.recording.robots] == [
        part.name for part in scenario.robots if part.name != second
    ]
    assert second not in left.robot_ends
    assert second not in left.end_message
    assert np.nanmax(left.metrics) < 1e4
    same, other = made["same"], made["dwb"]
    assert (
        other.provenance["scenario_sha256"]
        != (same.provenance["scenario_sha256"])
    )
    scenario = LoadScenario(filename="station")
    diagram, context = at(scenario, 20.0)
    fork = Fork(scenario, diagram, context, until=30.0)
    there = ~np.isnan(fork.Run(Branch()).humans[..., X])
    k = int(np.flatnonzero(there[0])[0])
    without = fork.Run(WithoutPerson(fork.names[k]))
    assert np.isnan(without.humans[:, k, X]).all()


@pytest.mark.slow
def test_robots_that_are_left_end_when_the_last_of_them_does():
    scenario = LoadScenario(filename="three_robots")
    diagram, context = at(scenario, 1.0)
    gone = scenario.robots[-1].name
    made = RunBranches(
        *(scenario, diagram, context),
        until=20.0,
        branches={"it": RobotGone(gone)},
    )
    ends = made["it"].robot_ends
    assert set(ends.values()) == {"goal"}
    assert gone not in ends
    recording = made["it"].recording
    last = max(it.end_time for it in recording.robots)
    assert made["it"].end_time == pytest.approx(last)
    # Those that had ended before have no end before the instant.
    late = MakeTrialSimulator(diagram, context.Clone(), ends=False)
    late.AdvanceTo(15.0)
    result = GetTrialResult(
        *(scenario, diagram, late.get_context()),
        since=14.0,
        robots=[scenario.robots[0].name],
    )
    assert result.end_time >= result.recording.times[0]
    assert recording.times[-1] == pytest.approx(last, abs=0.11)
    with pytest.raises(ValueError, match="robots must be some of"):
        GetTrialResult(scenario, diagram, context, robots=["nobody"])


@pytest.mark.slow
def test_the_only_robot_that_is_left_ends_alone(tmp_path):
    scenario = LoadScenario(filename="fleet")
    keep = [it.name for it in scenario.robots][:2]
    scenario.robots = scenario.robots[:2]
    scenario.simulation.duration = 40.0
    diagram, context = at(scenario, 2.0)
    made = RunBranches(
        scenario,
        diagram,
        context,
        until=40.0,
        branches={"alone": RobotGone(keep[1])},
        reference=SAME,
    )
    alone = made["alone"]
    assert alone.end_reason == "goal"
    assert alone.robot_ends == {keep[0]: "goal"}
    assert alone.end_time < made.until
    assert alone.recording.times[-1] == pytest.approx(alone.end_time)
    table = made.metrics.set_index(["branch", "metric"])
    row = table.loc["alone", f"{keep[0]}.time_to_reach_goal"]
    assert row["value"] == alone.metrics["time_to_reach_goal"]
    assert np.isfinite(row["difference"])
    page = WriteBranchesPage(made, tmp_path / "a.html", "two").read_text()
    assert "\N{SUPERSCRIPT SIX}" not in page


@pytest.mark.slow
def test_who_sits_and_talks_goes_on_without_one():
    scenario = LoadScenario(filename="museum")
    diagram, context = at(scenario, 6.0)
    fork = Fork(scenario, diagram, context, until=9.0)
    future = fork.Run(Without(people=fork.names[:2]))
    assert np.isnan(future.humans[:, :2, X]).all()
    assert np.isfinite(future.humans[:, 2:, : Y + 1]).all()


BAD = {
    "until must be a time step (0.05 s) or more after that of the Context, 2 s,"
    " got 2.0": {"until": 2.0},
    "or more after that of the Context, 2 s, got 2.03": {"until": 2.03},
    "simulation.seed=4 has no effect: a branch goes on with the draws": {
        "branches": {"x": WithSettings(("simulation.seed=4",))}
    },
    "simulation.start_jitter=0.2 has no effect: it moves people at the": {
        "branches": {"jitter": WithSettings(("simulation.start_jitter=0.2",))}
    },
    "simulation.duration=9.0 has no effect: `until` is the end": {
        "branches": {"x": WithSettings(("simulation.duration=9",))}
    },
    "goal must be 0": {"goal": -1},
    "'same' is always there": {"branches": {"same": RobotStands()}},
    "reference must be the name of a branch, got 'ghost'": {
        "reference": "ghost"
    },
    "there is no person 'anna'; did you mean 'ana'": {
        "branches": {"x": WithoutPerson("anna")}
    },
    "there is no robot 'b'": {"branches": {"x": RobotGone("b")}},
    "there is no planner 'dwbb'": {"branches": {"x": WithPlanner("dwbb")}},
    "must be the name of a planner, got 3": {"branches": {"x": WithPlanner(3)}},
    "robot.radius: it was 0.35, and is 0.2": {
        "branches": {"x": WithSettings(("robot.radius=0.2",))}
    },
}


@pytest.mark.parametrize("words", BAD)
def test_mistakes_are_told_before_anything_runs(words, monkeypatch):
    scenario = crossing()
    diagram, context = at(scenario, 2.0)

    def run(*_, **__):
        raise AssertionError("a branch was run")

    monkeypatch.setattr(Fork, "Run", run)
    arguments = {"until": 6.0, "branches": {}, **BAD[words]}
    with pytest.raises((ValueError, ScenarioError)) as caught:
        RunBranches(scenario, diagram, context, **arguments)
    assert words in str(caught.value)


def test_people_leave_only_where_they_may():
    scenario = crossing()
    diagram, context = at(scenario, 0.0)
    with pytest.raises(ValueError, match="may_leave=True"):
        LeaveOut(diagram, context, "ana")
    LeaveOut(diagram, context)
    opened = MakeTrialDiagram(scenario, may_leave=True)
    context = opened.CreateDefaultContext()
    LeaveOut(opened, context, "ana")
    rows = opened.GetOutputPort("human_states").Eval(context).reshape(-1, 7)
    assert rows[0, :2].tolist() == [OUTSIDE, OUTSIDE]
    # It does not come back, and the file has it.
    simulator = MakeTrialSimulator(opened, context)
    simulator.AdvanceTo(5.0)
    rows = opened.GetOutputPort("human_states").Eval(simulator.get_context())
    assert rows[0] == OUTSIDE


def test_a_state_outside_the_context_is_found():
    """Its branches would differ for no reason."""
    scenario = crossing()
    diagram, context = at(scenario, 2.0)
    fork = Fork(scenario, diagram, context, until=4.0)
    original, other = fork.RunOriginal(), fork.Run(RobotStands())
    with pytest.raises(RuntimeError, match="nothing changes differs"):
        fork.CheckSame(original, other)


def test_a_robot_is_as_far_aside_as_told():
    scenario = stage([walker("ana", 4, 0, -6)])
    diagram, context = at(scenario, 1.0)
    port = diagram.GetOutputPort("robot_state")
    before = port.Eval(context)
    RobotShifted(0.01).Apply(diagram, context)
    moved = port.Eval(context) - before
    assert np.hypot(*moved[:2]) == pytest.approx(0.01)
    assert not moved[2:].any()


def test_one_of_several_robots_is_named_in_errors():
    change = "robots[1].robot.type=pmb2"
    scenario = LoadScenario(filename="three_robots", overrides=[change])
    told = why_nobody_leaves(scenario)
    assert told.startswith("nobody can be left out: the robot south is physic")
