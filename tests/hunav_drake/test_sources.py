"""People who come and go in trials."""

import itertools

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    SaveScenario,
    SetTrialSeed,
)
from hunav_drake.scenario import draw_people
from hunav_drake.systems.common.layout import OUTSIDE, RADIUS, is_outside
from hunav_drake.systems.evaluation import compute_metrics, count_people
from tests.hunav_drake.scenario.loading_failure import failure
from tests.hunav_drake.stations import (
    STATION,
    counts_of,
    crowd_of,
    make,
    rows_of,
    station,
)


@pytest.fixture(scope="module")
def scenario():
    # Nothing stops the trial before the end.
    return station("robot.goal=null")


@pytest.fixture(scope="module")
def diagram(scenario):
    return MakeTrialDiagram(scenario)


@pytest.fixture(scope="module")
def result(scenario, diagram):
    return RunTrial(scenario, diagram=diagram)


def steps(diagram, seconds, seed=0):
    """Yields the Context after each step."""
    context = diagram.CreateDefaultContext()
    SetTrialSeed(diagram, context, seed)
    simulator = Simulator(diagram, context)
    for k in range(round(seconds / 0.05)):
        simulator.AdvanceTo(0.05 * (k + 1))
        yield simulator.get_context()


def test_nobody_of_a_source_is_there_at_the_start(diagram):
    context = diagram.CreateDefaultContext()
    rows = rows_of(diagram, context)
    assert len(rows) == 26
    assert is_outside(rows).all()
    assert (rows[:, :2] == OUTSIDE).all()
    assert (rows[:, 2:] == 0).all()
    assert set(counts_of(diagram, context).arrivals.values()) == {0}


def test_people_come_cross_and_leave(diagram):
    *_, context = steps(diagram, 20.0)
    counts = counts_of(diagram, context)
    for source, sink in (("west", "east"), ("east", "west")):
        here = counts.arrivals[source] - counts.departures[sink]
        names = np.array(
            [h.name.startswith(source) for h in draw_people(station())]
        )
        present = ~is_outside(rows_of(diagram, context))
        assert counts.departures[sink] > 1
        assert here == np.count_nonzero(present & names)


def test_nobody_overlaps_who_comes_in(diagram):
    radii = np.array([h.body_radius for h in draw_people(station())])
    before = None
    entries = 0
    for context in steps(diagram, 20.0, seed=2):
        rows = rows_of(diagram, context)
        here = ~is_outside(rows)
        if before is not None and (new := np.flatnonzero(here & ~before)).size:
            entries += new.size
            assert (rows[new, 3:6] == 0).all()
            apart = np.hypot(*(rows[new, None, :2] - rows[here, :2]).T)
            gaps = apart.T - radii[new, None] - radii[here]
            own = new[:, None] == np.flatnonzero(here)
            assert gaps[~own].min(initial=1.0) >= 0.1 - 1e-9
            assert (abs(rows[new, 1]) <= 3).all()
        before = here
    assert entries > 15


def test_people_leave_in_the_sink_only(diagram):
    before = None
    for context in steps(diagram, 20.0, seed=1):
        rows = rows_of(diagram, context)
        if before is not None:
            gone = is_outside(rows) & ~is_outside(before)
            x, y = before[gone, 0], before[gone, 1]
            # At most a step before the reach of 0.3 m.
            assert ((x > 11.2) & (y > -0.4) | (x < 0.8) & (y < 0.4)).all()
        before = rows


def test_who_comes_again_begins_anew(diagram):
    """Everybody's second visit ends at the sink as well."""
    trial = make(
        "robot.goal=null",
        "population.sources[0].rate=0.3",
        "population.sources[0].max_present=3",
        "population.sources[0].group_sizes=[1]",
    )
    *_, context = steps(trial, 40.0)
    assert counts_of(trial, context).departures["east"] > 3


@pytest.mark.slow
def test_those_outside_are_not_there_for_anybody(scenario, diagram):
    """Bit for bit, the others do as if they were alone in the world."""
    still = ("population.sources[0].rate=0", "population.sources[1].rate=0")
    cohort = (
        "population.cohorts=[{name: guest, number: 6, start: [{rectangle:"
        " [2, -3, 10, 3]}], goals: [{rectangle: [2, -3, 10, 3]}],"
        " group_sizes: [1, 1], behaviors: {curious: 1, regular: 1}}]"
    )
    many = station(*still, cohort)
    few = LoadScenario(
        data=STATION, overrides=[cohort, "population.sources=[]"]
    )
    first, second = RunTrial(many), RunTrial(few)
    assert np.isnan(first.recording.humans[:, 6:]).all()
    alone = first.recording.humans[:, :6]
    assert alone.tobytes() == second.recording.humans.tobytes()
    robots = [it.recording.robot.tobytes() for it in (first, second)]
    assert robots[0] == robots[1]
    # The metrics do not know of them either, but for the order of sums.
    np.testing.assert_allclose(first.metrics, second.metrics, rtol=1e-12)


def test_a_recording_has_only_who_is_there(result):
    recording = result.recording
    table = count_people(recording)
    assert table["present"].iloc[0] == 0
    assert table["arrivals"].iloc[-1] > 10
    assert (table["present"] == table["arrivals"] - table["departures"]).all()
    here = recording.features.present
    assert np.nanmin(recording.humans[..., RADIUS]) > 0.3
    assert abs(recording.humans[here][:, 0] - 6).max() < 7
    assert (recording.behavior_status[~here] == 0).all()


def test_metrics_are_of_those_who_are_there(result):
    """The closest person is one who is present, at each sample."""
    recording = result.recording
    distances = np.full(len(recording), np.nan)
    for k, (robot, humans) in enumerate(
        zip(recording.robot, recording.humans, strict=True)
    ):
        gaps = [
            max(np.hypot(*(h[:2] - robot[:2])) - h[6] - robot[6], 0.0)
            for h in humans
            if not np.isnan(h[0])
        ]
        if gaps:
            distances[k] = min(gaps)
    value = compute_metrics(recording)["avg_dist_to_closest_person"]
    assert value == pytest.approx(np.nanmean(distances))
    assert result.metrics["max_dist_to_people"] < 13


@pytest.mark.slow
def test_a_trial_repeats_and_seeds_differ(scenario, diagram, result):
    again = RunTrial(scenario)
    assert again.recording == result.recording
    assert RunTrial(scenario, 5, diagram=diagram).recording != result.recording
    # After another seed, too.
    assert RunTrial(scenario, 0, diagram=diagram).recording == result.recording


@pytest.mark.slow
def test_a_clone_goes_on_alike_and_alone(scenario, diagram, result):
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(11.0)
    clone = simulator.get_context().Clone()
    kept = rows_of(diagram, clone).copy()
    simulator.AdvanceTo(20.0)
    # The first has changed nothing of the second.
    np.testing.assert_array_equal(rows_of(diagram, clone), kept)
    second = MakeTrialSimulator(diagram, clone)
    second.AdvanceTo(20.0)
    for it in (simulator, second):
        got = GetTrialResult(scenario, diagram, it.get_context())
        assert got.recording == result.recording


def test_a_trial_goes_on_from_a_file(scenario, result, tmp_path):
    first = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(first)
    simulator.AdvanceTo(12.0)
    path = SaveContext(first, simulator.get_context(), tmp_path / "c.npz")
    second = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(second, LoadContext(second, path))
    simulator.AdvanceTo(20.0)
    got = GetTrialResult(scenario, second, simulator.get_context())
    assert got.recording == result.recording


def test_figures_of_those_outside_are_out_of_sight(diagram):
    """No camera reaches so far, and the browser shows no way there."""
    scene = diagram.GetSubsystemByName("scene")
    graph = scene.GetSubsystemByName("scene_graph")
    inspector = graph.model_inspector()
    frames = [
        next(
            frame
            for frame in inspector.GetAllFrameIds()
            if inspector.GetName(frame).endswith(f"{human.name}::base")
        )
        for human in draw_people(station())
    ]
    for context in itertools.islice(steps(diagram, 12.0), 0, None, 40):
        query = diagram.GetOutputPort("query").Eval(context)
        rows = rows_of(diagram, context)
        for frame, row, out in zip(frames, rows, is_outside(rows), strict=True):
            place = query.GetPoseInWorld(frame).translation()
            if out:
                assert np.hypot(*place[:2]) > 1e6
            else:
                np.testing.assert_allclose(place[:2], row[:2])


@pytest.mark.slow
def test_those_who_come_wait_while_all_are_here():
    """Slow people keep their source empty."""
    trial = make(
        "robot.goal=null",
        "population.sources[0].max_present=3",
        "population.sources[0].group_sizes=[1]",
        "population.sources[0].rate=0.25",
        "population.sources[1].rate=0",
    )
    waited = 0
    for context in steps(trial, 40.0, seed=1):
        here = np.count_nonzero(~is_outside(rows_of(trial, context)))
        waiting = counts_of(trial, context).waiting["west"]
        assert here <= 3
        waited = max(waited, waiting)
        _, own = crowd_of(trial, context)
        if waiting:
            resting = own.get_discrete_state(3).value()[:3] > 0
            assert here + np.count_nonzero(resting) == 3
    assert waited > 0


@pytest.mark.slow
def test_those_who_come_wait_while_the_door_is_blocked():
    trial = make(
        "robot.goal=null",
        "robot.start=[0.5, 1.5, 0]",
        "population.sources[0].start=[{point: [0.5, 1.5]}]",
        "population.sources[0].group_sizes=[1]",
        "population.sources[1].rate=0",
    )
    *_, context = steps(trial, 20.0)
    counts = counts_of(trial, context)
    assert counts.arrivals["west"] == 0
    assert counts.waiting["west"] > 5


def test_groups_come_in_together(diagram):
    people = draw_people(station())
    groups = np.array([h.group_id for h in people])
    before = None
    seen = set()
    for context in steps(diagram, 20.0):
        here = ~is_outside(rows_of(diagram, context))
        if before is not None:
            for group in set(groups[here & ~before].tolist()) - {-1}:
                assert (here & ~before)[groups == group].all()
                seen.add(group)
        before = here
    assert len(seen) > 1


def test_people_wait_at_a_sink_until_it_is_their_turn():
    """Nobody is left behind, however many stand before it."""
    trial = make(
        "robot.goal=null",
        "population.cohorts=[{number: 8, start: [{rectangle: [3, -3, 11, 3]}],"
        " sinks: {east: 1}}]",
        "population.sources=[]",
        "population.sinks[1].rate=0.8",
    )
    left = [
        counts_of(trial, context).departures["east"]
        for context in steps(trial, 20.0)
    ]
    assert left[-1] == 8
    assert np.diff(np.flatnonzero(np.diff(left, prepend=0))).min() >= 24


def test_people_of_a_cohort_leave_for_good():
    trial = make(
        "population.cohorts=[{number: 5, start: [{rectangle: [8, 0, 11, 3]}],"
        " sinks: {east: 1}}]",
        "population.sources=[]",
        "robot.goal=null",
    )
    *_, context = steps(trial, 15.0)
    assert is_outside(rows_of(trial, context)).all()
    assert counts_of(trial, context).departures == {"west": 0, "east": 5}


def test_a_scenario_is_written_as_it_was(scenario):
    text = SaveScenario(scenario)
    assert "max_present: 14" in text
    assert LoadScenario(data=text) == scenario


@pytest.mark.slow
def test_the_hunavsim_profile_lets_people_leave_too():
    trial = make("crowd={profile: hunavsim}", "robot.goal=null")
    *_, context = steps(trial, 20.0)
    assert counts_of(trial, context).departures["east"] > 2


@pytest.mark.slow
@pytest.mark.parametrize("model", ["orca", "collision_free_speed"])
def test_people_come_and_go_with_every_kind_of_model(model):
    trial = make(f"crowd={{model: {model}}}", "robot.goal=null")
    *_, context = steps(trial, 20.0)
    assert counts_of(trial, context).departures["east"] > 2


@pytest.mark.slow
def test_one_system_of_trees_does_the_same(scenario, result):
    """As do systems of their own."""
    fewer = station(
        "crowd.separate_trees=true",
        "robot.goal=null",
        "population.sources[1].max_present=5",
        "population.sources[1].rate=0.3",
    )
    assert (
        not MakeTrialDiagram(fewer)
        .GetSubsystemByName("humans")
        .HasSubsystemNamed("behaviors")
    )
    recording = RunTrial(fewer).recording
    assert count_people(recording)["departures"].iloc[-1] > 5


@pytest.mark.parametrize(
    ("setting", "fault"),
    [
        (
            "sources[0].sinks={eats: 1}",
            "population: sources[0].sinks: there is no sink 'eats'; did you"
            " mean 'east'?; the sinks are west, east",
        ),
        (
            "sources[0].sinks={}",
            "sources[0] ('west').sinks: must have a weight above 0",
        ),
        (
            "sources[0].rate=-0.1",
            "sources[0] ('west').rate: must be in [0, 100] people/s, got -0.1",
        ),
        (
            "sources[0].start=[{rectangle: [1, 4, 2, 4.2]}]",
            "sources[0] ('west').start: has no place 0.35 m from all walls;"
            " move or enlarge it, or lower radius",
        ),
        (
            "sources[0].start=[{point: [1, 4.1]}]",
            "sources[0] ('west').start: has no place 0.35 m from all walls",
        ),
        (
            "sources[0].start=[{point: [1, 1]}]",
            "sources[0] ('west').start: has no room for a group of",
        ),
        (
            "sources[0].max_present=2",
            "sources[0] ('west').max_present: must be at least 6 for 0.8"
            " people per second, who need 7 s or more to their sinks, got 2;"
            " raise it, or lower rate",
        ),
        (
            "sources[0].max_present=0",
            "sources[0] ('west').max_present: must be at least 1, got 0",
        ),
        (
            "sources[0].behaviors={sacred: 1}",
            "sources[0] ('west').behaviors.sacred: there is no behavior"
            " 'sacred'; did you mean 'scared'?",
        ),
        (
            "sources[1].name=west",
            "population: sources[0].name must be unique among sources and"
            " cohorts, got 'west'; rename one",
        ),
        (
            "sinks[0].name=east",
            "population: sinks[0].name must be unique, got 'east'; rename one",
        ),
        (
            "sinks[1].area={rectangle: [3, 4, 5, 4.2]}",
            "sources[0] ('west').sinks.east: has no place 0.35 m from all"
            " walls; enlarge or move it",
        ),
        (
            "sinks[1].area={point: [3, 4.1]}",
            "sources[0] ('west').sinks.east: is inside a wall; move it",
        ),
        (
            "sinks[1].radius=-1",
            "sinks[1] ('east').radius: must be in [0, 100000] m, got -1",
        ),
        (
            "cohorts=[{number: 1, start: [{rectangle: [1, 0, 3, 3]}],"
            " sinks: {east: 1}, cyclic: true}]",
            "cohorts[0]: cyclic must be false for people who leave at sinks",
        ),
    ],
)
def test_faults_name_place_rule_value_and_remedy(setting, fault):
    error = failure(data=STATION, overrides=[f"population.{setting}"])
    assert fault in str(error.faults[0])


@pytest.mark.slow
def test_samples_are_so_close_that_nobody_comes_back_between_two():
    often = LoadScenario(data=STATION, overrides=["evaluator.period=1.0"])
    people = RunTrial(often).recording.humans[..., :2]
    steps = np.linalg.norm(np.diff(people, axis=0), axis=-1)
    assert 1.0 < np.nanmax(steps) < 2.5
    error = failure(data=STATION, overrides=["evaluator.period=1.05"])
    (found,) = error.faults
    assert found.path == "evaluator.period"
    assert "must be at most 1 s where people of sources" in found.message


def test_a_name_that_somebody_has_is_refused():
    text = STATION + "humans: [{name: west_2, pose: [6, 0, 0]}]\n"
    (found,) = failure(data=text).faults
    assert found.path == "population.sources[0] ('west').name"
    assert "'west_2' is humans[0] ('west_2'); rename one" in found.message


@pytest.mark.slow
def test_listed_people_come_before_those_of_sources():
    text = STATION + "humans: [{name: ana, pose: [6, 0, 0]}]\n"
    scenario = LoadScenario(data=text)
    trial = MakeTrialDiagram(scenario)
    rows = rows_of(trial, trial.CreateDefaultContext())
    assert is_outside(rows).tolist() == [False] + 26 * [True]
    *_, context = steps(trial, 20.0)
    assert not is_outside(rows_of(trial, context))[0]
    assert counts_of(trial, context).departures["east"] > 1
