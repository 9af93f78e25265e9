"""Social leaves with people who come and go, several robots, forks, seeds."""

import json
import math

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveContext,
    ScenarioError,
    TransferContext,
)
from hunav_drake.scenario.randomness import drawn_by_seed
from hunav_drake.systems.behavior import (
    BehaviorTreeError,
    NodeStatus,
    register_action,
)
from hunav_drake.systems.behavior.nodes.texts import text_code
from hunav_drake.systems.common.layout import OUTSIDE, SILENT, Activity, Signal
from hunav_drake.systems.people.places import Place, complete_places
from hunav_drake.systems.people.traffic import Sink, Source, Traffic
from hunav_drake.trial.seeds import SetHumansSeed
from tests.vocabulary.stage import DT, STAND, Stage, someone, tree

R, S, F = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE

PLACES = [{"name": "x", "pose": [4, 0, 0]}, {"name": "y", "pose": [0, 4, 0]}]


def scenario(nodes="", **more):
    data = {
        "places": PLACES,
        "humans": [{"pose": [0, 0, 0], "behavior": tree(nodes)}],
        "robot": {"start": [-6, -3, 0], "goal": [6, -3, 0]},
        "planner": {"type": "pursuit"},
        "simulation": {"duration": 5.0},
    }
    return LoadScenario(data=json.dumps(data | more))


def arrivals(n, outside):
    """Returns the traffic of people of whom some are outside at first."""
    rows = tuple((i,) for i in outside)
    field = np.array([[-3.0, -3.0], [3.0, 3.0]])
    return Traffic(
        (Source("door", 0.3, 100, rows, field, 0.3),),
        (Sink("exit", np.array([[8.0, 8.0]]), 0.3),),
        np.array([0 if i in outside else -1 for i in range(n)]),
        np.full((n, 2), 8.0),
    )


@pytest.mark.parametrize(
    "node",
    [
        '<ConversationFormation name="it" non_main_agent_ids="2"/>',
        '<FollowAgent name="it" target_agent_id="2"/>',
        '<ApproachAgent name="it" target_agent_id="2"/>',
        '<BlockAgent name="it" target_agent_id="2"/>',
        '<LookAtAgent name="it" target_id="2"/>',
        '<IsAgentClose name="it" observer_id="2" target_agent_id="3"/>',
        '<IsAgentVisible name="it" observer_id="2" agent_id="3"/>',
        '<SaySomething name="it" to="2" message="hello"/>',
    ],
)
def test_who_has_not_come_yet_cannot_be_met(node):
    people = [someone(0, 0, nodes=node), someone(1, 1), someone(1, -1)]
    stage = Stage(people, traffic=arrivals(3, [1, 2]))
    stage.step()
    assert (stage.states[1:, 0] == OUTSIDE).all()
    assert stage.statuses(0)["it"] == F


@pytest.mark.slow
def test_people_who_come_draw_by_the_seed_of_the_trial():
    chance = (
        '<ForceFailure><RandomChanceCondition probability="0.5"/>'
        "</ForceFailure>"
    )
    people = [someone(i, 0, 0, chance, goals=[(8, 8)]) for i in range(3)]

    def draws(made, later=None):
        stage = Stage(people, traffic=arrivals(3, [1, 2]), seed=made)
        if later is not None:
            SetHumansSeed(stage.diagram, stage.context, later)
            stage._simulator.Initialize()
        return [
            [stage.statuses(i)["RandomChanceCondition"] for i in range(3)]
            for _ in stage.run(12.0)
        ]

    assert draws(7) == draws(0, 7)
    assert draws(7) != draws(0)


def test_chances_of_behaviors_are_among_the_draws_of_a_trial():
    chance = '<Sequence><RandomChanceCondition/><GoTo goal_id="x"/></Sequence>'
    assert drawn_by_seed(scenario(chance)) == ("chances of behaviors",)
    assert drawn_by_seed(scenario('<GoTo goal_id="x"/>')) == ()
    drawn = scenario(
        humans=[],
        population={
            "seed": 1,
            "cohorts": [
                {
                    "number": 2,
                    "start": [{"rectangle": [-2, -2, 2, 2]}],
                    "goals": [{"point": [3, 3]}],
                    "behaviors": {tree(chance): 1},
                }
            ],
        },
    )
    assert drawn_by_seed(drawn) == ("chances of behaviors",)


def test_a_long_time_is_saved(tmp_path):
    nodes = (
        '<ForceFailure><Cooldown seconds="1e9"><SaySomething message="hi"/>'
        "</Cooldown></ForceFailure>"
    )
    diagram = MakeTrialDiagram(scenario(nodes))
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(0.5)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    LoadContext(diagram, file)


def test_other_places_do_not_take_over_a_goal(tmp_path):
    nodes = '<ForceFailure><RunOnce><SetGoal goal_id="x"/></RunOnce>'
    nodes += "</ForceFailure>"
    one = MakeTrialDiagram(scenario(nodes))
    other = MakeTrialDiagram(scenario(nodes, places=PLACES[::-1]))
    moved = [PLACES[0] | {"pose": [5, 0, 0]}, PLACES[1]]
    same = MakeTrialDiagram(scenario(nodes, places=moved))
    simulator = MakeTrialSimulator(one)
    simulator.AdvanceTo(0.5)
    context = simulator.get_context()
    file = SaveContext(one, context, tmp_path / "c.npz")
    with pytest.raises(ValueError, match="of 2 places"):
        TransferContext(one, context, other)
    with pytest.raises(ValueError, match="of 2 places"):
        LoadContext(other, file)
    TransferContext(one, context, same)


def test_a_fault_in_the_memory_is_found_without_signals_of_robots(tmp_path):
    nodes = (
        '<ForceFailure><RunOnce><SetBlackboard value="pedestrian"'
        ' output_key="w"/></RunOnce></ForceFailure><ReactiveSequence>'
        '<RegularNav robot="{w}"/><GoTo goal_id="x"/></ReactiveSequence>'
    )
    diagram = MakeTrialDiagram(scenario(nodes))
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(0.5)
    trees = diagram.GetSubsystemByName("humans").GetSubsystemByName(
        "behavior_0"
    )
    context = trees.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    memory = trees.GetMemory(context, 0)
    memory[trees.trees()[0].slots.index("{w}")] = 7
    trees.SetMemory(context, 0, memory)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "c.npz")
    with pytest.raises(ValueError, match="a tick with its memory fails"):
        LoadContext(diagram, file)


@pytest.mark.parametrize("cyclic", [False, True])
@pytest.mark.parametrize("in_python", [False, True])
def test_places_follow_the_own_goals_once_and_one_after_the_other(
    cyclic, in_python
):
    places = [
        Place(name="p1", pose=(1, 1, 0)),
        Place(name="p2", pose=(0, 1, 0)),
    ]
    nodes = "".join(
        f'<ForceFailure><RunOnce><SetGoal goal_id="{it}"/></RunOnce>'
        "</ForceFailure>"
        for it in ("p1", "p2")
    )
    rest = (
        "<Sequence><Inverter><IsGoalReached/></Inverter><RegularNav/>"
        "</Sequence>"
    )
    rest += "<NextGoalInPython/>" if in_python else "<UpdateGoal/>"
    person = someone(
        *(-0.5, 0, 0, nodes, rest), goals=[(0, 0), (1, 0)], cyclic=cyclic
    )
    stage = Stage([person], places=places)
    seen = []
    for _ in stage.run(14.0):
        x, y, has = (float(stage.command(0)[i]) for i in (0, 1, 3))
        if has and (not seen or seen[-1] != (x, y)):
            seen.append((x, y))
    expected = [(0, 0), (1, 0), (1, 1), (0, 1)] + [(0, 0), (1, 0)] * cyclic
    assert seen[: len(expected)] == expected
    assert cyclic or len(seen) == 4


@register_action("NextGoalInPython", replace=True)
def next_goal(tick):
    goal = tick.goal
    return S if tick.go_to_next_goal() and goal is not None else F


def test_who_queues_again_is_the_last():
    till = Place(name="till", type="counter", pose=(0, 0, 0), seconds=1)
    again = '<Repeat num_cycles="9"><Queue place="till"/></Repeat>'
    once = '<RunOnce><Queue name="it" place="till"/></RunOnce>'
    people = [
        someone(0, 0, 0, again, rest=STAND),
        someone(-0.9, 0, 0, once, goals=[(-4, 6)]),
        someone(-1.8, 0, 0, once, goals=[(-4, 6)]),
    ]
    stage = Stage(people, places=[till])
    served = []
    for _ in stage.run(15.0):
        served += [i for i in (1, 2) if stage.statuses(i)["it"] == S]
        if len(served) == 2:
            break
    assert served == [1, 2]


def test_a_second_offer_begins_when_it_is_made():
    nodes = (
        '<RunOnce><Sequence><ConversationFormation name="first"'
        ' non_main_agent_ids="2" conversation_duration="1"/>'
        '<ConversationFormation name="second" non_main_agent_ids="2"'
        ' conversation_duration="1"/></Sequence></RunOnce>'
    )
    people = [someone(0, 0, 0, nodes, rest=STAND), someone(1.4, 0, math.pi)]
    stage = Stage(people)
    since = set()
    for _ in stage.run(12.0):
        if stage.signal(0, Signal.ACTIVITY) == Activity.CONVERSATION:
            since.add(stage.signal(0, Signal.SINCE))
    assert len(since) == 2


def test_who_is_invited_shows_since_when():
    nodes = (
        '<TimeDelay delay="1"><RunOnce><ConversationFormation'
        ' non_main_agent_ids="2"/></RunOnce></TimeDelay>'
    )
    stage = Stage([someone(0, 0, 0, nodes, STAND), someone(1.4, 0, 0)])
    for _ in stage.run(3.0):
        pass
    assert stage.signals[:, Signal.SINCE] == pytest.approx([20, 20])


def test_who_stands_at_its_goal_comes_when_invited():
    nodes = (
        '<TimeDelay delay="4"><RunOnce><ConversationFormation name="it"'
        ' non_main_agent_ids="2" goal_id="x" conversation_duration="3"'
        ' patience="15"/></RunOnce></TimeDelay>'
    )
    people = [
        {"pose": [0, 0, 0], "behavior": tree(nodes, STAND)},
        {"pose": [5, 2, 0], "goals": [[5, 3]], "behavior": "cooperative"},
    ]
    trial = scenario(humans=people, simulation={"duration": 30.0})
    diagram = MakeTrialDiagram(trial)
    simulator = MakeTrialSimulator(diagram)
    humans = diagram.GetSubsystemByName("humans")
    trees = humans.GetSubsystemByName("behavior_0")
    names = [it.name for it in trees.trees()[0].nodes]
    seen = set()
    for k in range(1, 500):
        simulator.AdvanceTo(0.05 * k)
        own = trees.GetMyContextFromRoot(simulator.get_context())
        seen.add(trees.EvalNodeStatus(own, 0)[names.index("it")])
        if S in seen:
            break
    assert S in seen
    assert F not in seen


def test_a_person_goes_on_with_the_robot_that_it_has_seen():
    nodes = (
        '<Sequence><IsRobotVisible distance="5"/><LookAtRobot/>'
        '<ApproachRobot name="it" closest_dist="1.5"/></Sequence>'
    )
    people = [someone(0, 0, 0, nodes, rest=STAND)]
    # (The nearer one is behind the person.)
    robots = [[4, 0, 0, 0, 0, 0, 0.3], [-2, 0, 0, 0, 0, 0, 0.3]]
    stage = Stage(people, robot=lambda t: np.ravel(robots))
    for _ in stage.run(4.0):
        pass
    assert stage.states[0, 0] == pytest.approx(2.5, abs=0.2)


def test_a_robot_is_heard_and_its_offers_count():
    nodes = (
        '<Sequence><IsAnyoneSpeaking name="it" speaker_id="{who}"/>'
        "<LookAtRobot/></Sequence>"
    )
    people = [someone(0, 0, 0, nodes), someone(1, 2, goals=[(9, 9)])]
    stage = Stage(people, robot=lambda t: [-3, 0, 0, 0, 0, 0, 0.3])
    signal = np.array(SILENT)
    port = stage.diagram.GetInputPort("robot_signals")
    port.FixValue(stage.context, signal)
    for _ in stage.run(1.0):
        assert stage.statuses(0)["it"] == R
    signal[Signal.UTTERANCE] = text_code("excuse me")
    signal[Signal.ACTIVITY] = Activity.CONVERSATION
    signal[Signal.OPEN] = 1
    signal[Signal.SLOT] = 0
    signal[Signal.CENTER_X] = -2
    signal[Signal.ANGLE] = math.pi
    signal[Signal.PARTNER_1] = 1
    port.FixValue(stage.context, signal)
    stage.step()
    for _ in stage.run(8.0):
        pass
    assert abs(stage.states[0, 2]) == pytest.approx(math.pi, abs=0.1)
    assert stage.signal(1, Signal.HOST) == 2
    # In its place, opposite of the robot.
    assert stage.states[1, :2] == pytest.approx([-1.3, 0], abs=0.2)


def test_a_look_goes_on_while_another_who_looks_comes_nearer():
    look = '<LookAtAgent target_id="1" walk="true"/>'
    look = f"<ForceFailure>{look}</ForceFailure>"
    wait = (
        '<IsAnyoneLookingAtMe name="it" hold="1.5" duration="9"'
        ' observer_id="{who}"/>'
    )
    people = [
        someone(0, 0, 0, wait, rest=STAND),
        someone(2, 0, math.pi, look, rest=STAND),
        # (Passes the other after 1 s.)
        someone(3, 1, math.pi, look, goals=[(-9, 1)]),
    ]
    stage = Stage(people)
    done = next(t for t in stage.run(5.0) if stage.statuses(0)["it"] == S)
    assert done == pytest.approx(1.5, abs=0.11)


def test_a_leaf_acts_for_nobody_else():
    node = '<GoTo agent_id="2" goal_id="p"/>'
    place = Place(name="p", pose=(1, 1, 0))
    with pytest.raises(BehaviorTreeError, match="to act for person 2"):
        Stage([someone(0, 0, nodes=node), someone(3, 3)], places=[place])
    Stage([someone(3, 3), someone(0, 0, nodes=node)], places=[place])


def test_groups_that_walk_are_none_of_the_scenario():
    walk = '<SetGroupWalk non_main_agent_ids="2"/>'
    people = [
        someone(0, 0, 0, walk, goals=[(9, 0)]),
        someone(0, 1, 0, goals=[(-9, 1)]),
        someone(0, 3, 0, goals=[(9, 3)], group_id=1),
    ]
    stage = Stage(people)
    for _ in stage.run(1.0):
        pass
    groups = [stage.command(i)[-1] for i in range(3)]
    names = [float(it) for it in groups]
    assert names[0] == names[1] != names[2]


def test_a_group_without_a_goal_stands_together():
    walk = '<SetGroupWalk non_main_agent_ids="2"/>'
    people = [someone(0, 0, 0, walk), someone(3, 0, 0, goals=[(9, 0)])]
    stage = Stage(people)
    for _ in stage.run(6.0):
        pass
    assert 0.7 < stage.distance(0, 1) < 1.2
    assert np.hypot(*stage.states[1, 3:5]) < 0.05


@pytest.mark.parametrize(
    ("places", "message"),
    [
        ([{"name": "3", "pose": [0, 0, 0]}], "a name in words"),
        ([{"name": "in", "pose": [5, 5, 0]}], "inside"),
        ([{"name": "in", "pose": [0, 0, 0], "slots": [[5, 5, 0]]}], "inside"),
    ],
)
def test_places_that_cannot_be_used_are_told(places, message):
    box = {"type": "box", "center": [5, 5], "size": [1, 1]}
    with pytest.raises(ScenarioError, match=message):
        scenario(places=places, world={"walls": [box]})


def test_a_number_may_be_the_name_of_its_own_place():
    (place,) = complete_places([Place(name="3", id=3, pose=(0, 0, 0))])
    assert place.name == "3"


@pytest.mark.parametrize(
    ("node", "message"),
    [
        ('<FollowAgent target_agent_id="9"/>', "nobody has the number 9"),
        ('<SetGroupWalk non_main_agent_ids="2"/>', "the person's own"),
        ('<GoTo goal_id="z"/>', "there is no place 'z'"),
    ],
)
def test_names_in_trees_of_drawn_people_are_checked(node, message):
    cohort = {
        "number": 2,
        "start": [{"rectangle": [-2, -2, 2, 2]}],
        "goals": [{"point": [3, 3]}],
        "behaviors": {tree(node): 1},
    }
    with pytest.raises(ScenarioError, match=message):
        scenario(population={"cohorts": [cohort]})


MIXED = [
    '<SubTree ID="ChatTree" probability="1" seconds="2" again="4"/>',
    '<SubTree ID="ChatTree" probability="1" seconds="2" again="4"/>',
    '<GiveWayAtDoor place="door"/>',
    '<AccompanyRobot duration="6"/>',
    '<SubTree ID="RandomGoalsTree" period="1"/>',
    "<Inverter><WaitForFreeWay/></Inverter>",
    '<SubTree ID="StopAndLookTree"/>',
    '<NeedsSelector><Satisfies need="rest" amount="30"><UsePlace kind="shelf"'
    ' seconds="1"/></Satisfies></NeedsSelector>',
]


def meeting(separate):
    """People with all of these, one who comes later, and two robots."""
    places = [
        Place(name="door", type="door", pose=(0, 0, 0)),
        *(Place(pose=(3.0 * i - 3, 3, 0)) for i in range(3)),
        Place(type="shelf", pose=(-4, 4, 0)),
    ]
    people = [
        someone(
            *(3.0 * (i % 4) - 5, 2.0 * (i // 4) - 1, 0.4 * i, node),
            goals=[(4.0 - i, 0.5 * i - 2), (i - 3.0, 2.0)],
            cyclic=True,
            needs={"rest": {"initial": 30}},
        )
        for i, node in enumerate(MIXED)
    ]

    def robots(t):
        one = [0.4 * t - 3, 0.2, 0, 0.4, 0, 0, 0.3]
        return [*one, 1.0, 3 - 0.3 * t, -1.57, 0, -0.3, 0, 0.3]

    return Stage(
        people,
        places=places,
        robot=robots,
        traffic=arrivals(len(people), [1]),
        separate_trees=separate,
        seed=4,
    )


@pytest.mark.slow
def test_separate_trees_and_one_system_do_the_same_also_after_a_fork():
    ends = []
    for separate in (True, False):
        stage = meeting(separate)
        for k, _ in enumerate(stage.run(12.0)):
            if k == 120:
                clone = stage.context.Clone()
        ends.append(np.r_[stage.states.ravel(), stage.signals.ravel()])
        simulator = Simulator(stage.diagram, clone)
        simulator.Initialize()
        for k in range(122, 241):
            port = stage.diagram.GetInputPort("robot_states")
            port.FixValue(clone, stage._robot(k * DT))
            simulator.AdvanceTo(k * DT)
        stage.context, stage._simulator = clone, simulator
        ends.append(np.r_[stage.states.ravel(), stage.signals.ravel()])
    for other in ends[1:]:
        np.testing.assert_array_equal(other, ends[0])


def test_needs_begin_anew_when_somebody_comes_in():
    needs = {"rest": {"initial": 50, "rate": 2.0}}
    node = '<ForceFailure><NeedBelow name="it" need="rest"/></ForceFailure>'
    people = [someone(i, 0, 0, node, rest=STAND, needs=needs) for i in (0, 1)]
    stage = Stage(people, traffic=arrivals(2, [1]))
    since, below = [None, None], [None, None]
    for t in stage.run(25.0):
        for i in range(2):
            if stage.states[i, 0] != OUTSIDE:
                since[i] = since[i] or t
            if stage.statuses(i)["it"] == S:
                below[i] = below[i] or t
    assert since[1] > 1
    assert np.subtract(below, since) == pytest.approx([10, 10], abs=0.11)


@pytest.mark.parametrize(
    "node",
    [
        '<GoTo goal_id=""/>',
        '<Queue place=""/>',
        '<LookAtAgent target_id="-1"/>',
    ],
)
def test_an_empty_name_is_told(node):
    with pytest.raises(BehaviorTreeError, match=r"there is no|nobody has"):
        Stage([someone(0, 0, nodes=node)])


def test_an_empty_name_may_stand_where_it_is_skipped():
    skipped = '<Sequence _skipIf="true"><GoTo goal_id=""/></Sequence>'
    nodes = f"<Fallback>{skipped}<AlwaysSuccess/></Fallback>"
    stage = Stage([someone(0, 0, nodes=nodes)])
    stage.step()
