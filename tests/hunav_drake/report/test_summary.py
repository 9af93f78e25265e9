"""The three sentences at the top of a report are true."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.report.summary import main_metrics, runs_summary
from hunav_drake.report.trial_page import trial_content
from hunav_drake.report.trial_summary import trial_summary
from hunav_drake.report.writing import WriteReport
from hunav_drake.runs.result_files import WriteResult
from hunav_drake.runs.run_table import tabulate_runs
from hunav_drake.systems.evaluation.encounters import find_encounters
from hunav_drake.views.events import events_of
from hunav_drake.views.recorded_trial import LoadRecordedTrial
from tests.hunav_drake.passing_trials import make_recording, make_result

NAN = float("nan")
SLOW = [10.0, 10.2, 10.4, 10.6, 10.8, 11.0, 11.2]
FAST = [5.0, 5.3, 5.1, 5.2, 5.4, 5.5, 5.6]


def runs_of(scenario="hall", **planners):
    """Returns a run per seed; None is a run that failed, NaN one stuck."""
    rows = [
        {
            "scenario": scenario,
            "contender": planner,
            "planner": planner,
            "setting": "",
            "seed": seed,
            "drawn": "start jitter",
            "end_reason": "error"
            if time is None
            else "goal"
            if np.isfinite(time)
            else "stuck",
            "completed": float(time is not None and np.isfinite(time)),
            "time_to_reach_goal": NAN if time is None else time,
            "min_dist_to_people": NAN if time is None else 1.0 + seed,
        }
        for planner, times in planners.items()
        for seed, time in enumerate(times)
    ]
    return pd.DataFrame(rows)


def test_who_is_better_than_every_other_is_named():
    first, second, third = runs_summary(runs_of(a=SLOW, b=FAST, c=SLOW))
    assert first == (
        "21 of 21 runs reached the goal: a 7 of 7, b 7 of 7, c 7 of 7."
    )
    assert second == (
        "b has a better time to the goal than every other planner on equal"
        " seeds."
    )
    assert third == (
        "The mean least distance to people is from 4.00 m (a) to 4.00 m (c),"
        " but it is the same on all equal seeds."
    )


def test_none_is_better_where_an_interval_contains_0():
    mixed = [*SLOW[:3], *FAST[3:6], 40.0]
    _, second, _ = runs_summary(runs_of(a=SLOW, b=mixed))
    assert "better" not in second.replace("neither can be called better", "")
    assert second.endswith("contains 0.")
    # Two are better than the third, but neither than the other.
    _, second, _ = runs_summary(runs_of(a=FAST, b=FAST[::-1], c=SLOW))
    assert second.endswith(
        "to 10.60 s (c), but none can be called better than every other on"
        " equal seeds."
    )


@pytest.mark.slow
def test_the_order_of_planners_does_not_matter():
    told = {
        runs_summary(runs_of(**{it: by[it] for it in order}))[1]
        for by in [{"a": SLOW, "b": FAST, "c": [2 * x for x in SLOW]}]
        for order in ("abc", "acb", "bac", "bca", "cab", "cba")
    }
    assert len(told) == 1
    assert told.pop().startswith("b has a better time")


@pytest.mark.parametrize("n", [1, 5])
def test_few_seeds_have_no_winner(n):
    first, second, third = runs_summary(runs_of(a=SLOW[:n], b=FAST[:n]))
    assert ("there is one seed only" in first) == (n == 1)
    for it in (second, third):
        assert "none can be called better: this needs 6 equal seeds" in it
        assert it.endswith(f"and there are {n}.")


def test_seeds_that_one_planner_lacks_do_not_count():
    runs = runs_of(a=SLOW, b=FAST)
    lacking = runs[(runs["planner"] == "a") | (runs["seed"] > 2)]
    assert "and there are 4." in runs_summary(lacking)[1]
    apart = runs.assign(seed=range(len(runs)))
    assert "and there are none." in runs_summary(apart)[1]
    # Runs whose seeds are unknown are no pairs.
    assert "and there are none." in runs_summary(runs.assign(seed=""))[1]
    # Nor are several runs of one seed.
    twice = pd.concat([runs, runs], ignore_index=True)
    assert "and there are none." in runs_summary(twice)[1]


def test_failed_and_stuck_runs_are_told_and_not_compared():
    stuck = [NAN, None, *FAST[2:]]
    first, second, _ = runs_summary(runs_of(a=SLOW, b=stuck))
    assert first == (
        "12 of 14 runs reached the goal: a 7 of 7, b 5 of 7; 1 failed."
    )
    assert "and there are 5." in second
    first, second, third = runs_summary(runs_of(a=[NAN] * 7, b=[None] * 7))
    assert first.startswith("0 of 14 runs reached the goal")
    assert second == "No run has a time to the goal."
    assert third.endswith("but no other planner has a value.")


def test_who_never_arrives_is_named_beside_the_winner():
    _, second, _ = runs_summary(runs_of(a=SLOW, b=FAST, c=[NAN] * 7))
    assert second == (
        "b has a better time to the goal than the other planner on equal seeds"
        " (without a value: c): 5.30 s against 10.60 s."
    )
    _, second, _ = runs_summary(runs_of(a=SLOW, c=[NAN] * 7))
    assert second.endswith("(a), but no other planner has a value.")


def test_seeds_that_draw_nothing_are_one():
    runs = runs_of(a=[5.0] * 7, b=[6.0] * 7).assign(
        drawn="nothing", min_dist_to_people=1.0
    )
    first, second, _ = runs_summary(runs)
    assert "all seeds are alike, so no mean has an interval" in first
    assert "none can be called better" in second


def test_scenarios_are_never_averaged():
    runs = pd.concat(
        [
            runs_of("hall", a=SLOW, b=FAST),
            runs_of("yard", a=FAST, b=SLOW),
            runs_of("room", a=SLOW, b=SLOW),
        ],
        ignore_index=True,
    )
    _, second, third = runs_summary(runs)
    assert second == (
        "By the time to the goal, one planner is better than every other in 2"
        " of 3 scenarios: b in hall; a in yard; none in the rest."
    )
    assert third == (
        "By the least distance to people, no planner is better than every"
        " other in any of 3 scenarios."
    )


def test_a_single_planner_has_means_with_intervals():
    first, second, _ = runs_summary(runs_of(a=SLOW))
    assert first == "7 of 7 runs reached the goal."
    assert second == (
        "The mean time to the goal is 10.60 s, with a 95 % interval of 10.20 s"
        " to 11.00 s, over 7 runs with a value."
    )
    one = runs_summary(runs_of(a=[5.0]))
    assert one[1].endswith("over 1 run with a value, so without an interval.")
    both = pd.concat([runs_of("hall", a=SLOW), runs_of("yard", a=FAST)])
    assert runs_summary(both)[1] == (
        "The mean time to the goal is from 5.30 s (yard) to 10.60 s (hall)."
    )


def test_without_goals_nobody_is_said_to_have_missed_them():
    runs = runs_of(a=[NAN] * 3, b=[NAN] * 3).assign(
        completed=NAN, min_dist_to_people=NAN, personal_space_intrusions=3.0
    )
    first, _, third = runs_summary(runs)
    assert first == "6 runs had no goal to reach."
    assert main_metrics(runs) == ["personal_space_intrusions"]
    assert third.startswith("The mean time in personal spaces is from 3.0 %")


def test_robots_have_their_names():
    runs = runs_of(a=SLOW).rename(
        columns={"min_dist_to_people": "anna.min_dist_to_people"}
    )
    assert runs_summary(runs)[2].startswith(
        "The mean least distance to people of anna is 4.00 m"
    )


def told_of(result):
    run = result.recording
    found = {
        it.robot_name: find_encounters(run, robot=it.robot_name)
        for it in run.robots
    }
    return trial_summary(result, found)


def test_a_trial_is_told_in_three_sentences():
    run = make_recording(goal=(1.0, 0.0, 0.0))
    first, second, third = told_of(
        make_result(run, end_reason="goal", end_time=1.0)
    )
    assert first == "The robot reached its goal after 1.00 s and 1.00 m."
    # 1.5 m beside it, less both radii.
    assert second.endswith("after 0 s: 0.900 m, from surface to surface.")
    assert third == (
        "It touched nobody, and 0 of 2 people reacted to the robot."
    )
    first, _, _ = told_of(make_result(run, end_reason="stuck", end_time=1.0))
    assert first == (
        "The robot did not reach its goal: the trial ended after 1.00 s"
        " (stuck), in which it drove 1.00 m."
    )
    assert told_of(make_result(make_recording()))[0].startswith(
        "The robot had no goal; the trial ended after"
    )


def test_a_file_whose_clock_begins_late_ended_after_its_length():
    run = make_recording(goal=(1.0, 0.0, 0.0))
    run = dataclasses.replace(run, times=run.times + 8.0)
    told = {"end_time": 1.0, "provenance": {"source": "a.npz"}}
    first, _, _ = told_of(make_result(run, end_reason="goal", **told))
    assert first == (
        "The robot reached its goal after 1.00 s and 1.00 m, from 8.00 s on."
    )
    # The clock of a trial begins with the trial.
    first, _, _ = told_of(make_result(run, end_reason="goal", end_time=9.0))
    assert first.startswith("The robot reached its goal after 1.00 s and")


def test_contacts_and_empty_scenes_are_told():
    touched = make_recording((0.5,), y=0.1, human_names=("ana",))
    _, second, third = told_of(make_result(touched))
    assert second.startswith("It came nearest to ana, after")
    assert second.endswith(": a contact.")
    assert third == "It touched ana, and 0 of 1 person reacted to the robot."
    alone = make_recording((), y=())
    _, second, third = told_of(make_result(alone))
    assert second == "There were no people."
    assert third == "It drove at 1.00 m/s on average."


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2])
def test_the_summary_is_above_all_tables(count, tmp_path):
    results = [make_result(seed=seed) for seed in range(count)]
    html = WriteReport(results, tmp_path / "report.html").read_text()
    assert html.index('class="summary"') < html.index("<h2")
    if count == 1:
        sentences = told_of(results[0])
    else:
        runs = tabulate_runs(results)
        sentences = runs_summary(runs.assign(contender=runs["planner"]))
    assert len(sentences) == 3
    for it in sentences:
        assert it in html


def test_means_are_those_of_the_pairs_in_which_both_arrive():
    late = [*range(8, 18), 30.0, 40.0]
    some = [it + 2.0 for it in late[:8]] + [NAN] * 4
    _, second, _ = runs_summary(runs_of(a=late, b=some))
    assert second == (
        "a has a better time to the goal than the other planner on equal"
        " seeds: 11.50 s against 13.50 s."
    )


def test_pairs_are_counted_of_any_two_planners():
    table = runs_of(a=SLOW, b=[*SLOW], c=[*SLOW])
    table.loc[table["contender"] == "a", "seed"] += 100
    _, second, _ = runs_summary(table)
    assert "there are none" not in second


def test_one_seed_each_is_no_seed_for_all():
    table = runs_of(a=[10.0], b=[11.0])
    table.loc[table["contender"] == "b", "seed"] = 1
    first, _, _ = runs_summary(table)
    assert first.endswith(
        "each has one seed only, so only rates have an interval."
    )
    # A seed that was run several times has an interval, and none is denied.
    again = runs_of(a=[10.0, 11.0, 12.0]).assign(seed=0)
    first, second, _ = runs_summary(again)
    assert "interval" not in first
    assert "interval" in second


def reacting_of(result):
    """Returns how many react by the summary, and their times by the table."""
    content = trial_content(result)
    (rows,) = content["people"].groups.values()
    *_, third = content["summary"]
    return third.partition(", and ")[2], [row[-1] for row in rows]


@pytest.mark.slow
def test_who_talks_does_not_react():
    scenario = LoadScenario(
        filename="living_cafe", overrides=["simulation.duration=8.0"]
    )
    words, times = reacting_of(RunTrial(scenario))
    assert words == "0 of 11 people reacted to the robot."
    assert {*times} == {"0"}


TREE = """<root BTCPP_format="4" main_tree_to_execute="Mine">
<include path="regular.xml"/><BehaviorTree ID="Mine">
<Fallback>{}<SubTree ID="RegularNavTree"/></Fallback></BehaviorTree></root>"""


@pytest.mark.slow
def test_who_accompanies_a_robot_reacts_to_it(tmp_path):
    """It is an activity, with a word on tags, as talking is."""
    scenario = LoadScenario("passing", overrides=["simulation.duration=5.0"])
    for human in scenario.humans:
        human.behavior = TREE.format('<AccompanyRobot spacing="1.0"/>')
    result = RunTrial(scenario)
    words, times = reacting_of(result)
    assert words == "2 of 2 people reacted to the robot."
    assert {*times} == {"5.00"}
    kinds = [kind for _, _, kind, *_ in events_of(result.recording)]
    assert kinds.count("reaction") == 2
    # Films and replays say the same, and what they do.
    trial = LoadRecordedTrial(WriteResult(result, tmp_path))
    assert trial.Reacts(2.0).all()
    assert trial.Activities(2.0) == ["accompanies"] * 2


def test_runs_of_several_robots_count_beside_those_of_one():
    """Their rates and times have other names."""
    one = runs_of("hall", quick=[10.0 + i for i in range(8)])
    fleet = one.drop(columns="time_to_reach_goal").assign(
        scenario="lobby", makespan=30.0, end_reason="stuck"
    )
    fleet["anna.completed"], fleet["bob.completed"] = 0.0, 1.0
    fleet = fleet.drop(columns="completed")
    runs = pd.concat([one, fleet], ignore_index=True)
    first, second, _ = runs_summary(runs)
    assert first.startswith("8 of 16 runs reached the goal")
    assert "from 13.50 s (hall) to 30.00 s (lobby)" in second
    assert "time until all robots arrive" in second


def test_times_of_a_later_part_are_told_from_its_start():
    result = make_result(make_recording(times=5.0 + np.arange(11) * 0.1))
    first, *_ = trial_summary(result, {})
    assert ", from 5" in first
