"""When exactly a robot came near people, crossed their ways, cut groups."""

import dataclasses

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake import (
    GetTrialResult,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
)
from hunav_drake.systems.evaluation import ZONES, Recording, find_encounters
from hunav_drake.systems.evaluation.chords import (
    chords_within,
    nearest_on_chords,
)
from hunav_drake.systems.evaluation.encounters import encounter_values

RADII = 0.3, 0.2


def row(x, y, radius):
    return [x, y, 0.0, 0.0, 0.0, 0.0, radius]


def recording(robot, *people, times=None, **more):
    """Returns a recording of places (x, y) of a robot and of people."""
    robot = np.asarray(robot, dtype=float)
    times = np.arange(len(robot), dtype=float) if times is None else times
    rows = np.array([row(*p, RADII[0]) for p in robot])
    humans = np.array(
        [
            [row(*p, RADII[1]) for p in np.asarray(person, dtype=float)]
            for person in people
        ]
    ).reshape(len(people), len(robot), 7)
    humans[np.isnan(humans[..., 0])] = np.nan
    return Recording(
        times=times, robot=rows, humans=humans.swapaxes(0, 1), **more
    )


def straight(start, velocity, times):
    return np.add(start, np.outer(times, velocity))


def test_discs_on_straight_lines_meet_when_they_do():
    times = np.arange(0.0, 20.0, 0.7)
    run = recording(
        straight([-5, 0], [0.6, 0.0], times),
        straight([5, 0.9], [-0.9, 0.0], times),
        times=times,
    )
    found = find_encounters(run)
    events = found.events()
    for zone, gap in ZONES.items():
        own = events[events["zone"] == zone]
        reach = gap + sum(RADII)
        if reach < 0.9:
            assert own.empty
            continue
        half = np.sqrt(reach**2 - 0.9**2)
        expected = [(10 - half) / 1.5, (10 + half) / 1.5]
        assert own["kind"].tolist() == ["entry", "exit"]
        np.testing.assert_allclose(own["time"], expected, atol=1e-12)
        assert found.people()[f"time_in_{zone}"].iloc[0] == pytest.approx(
            2 * half / 1.5, abs=1e-12
        )
        # Both along the line between them.
        entry = own.iloc[0]
        part = half / reach
        assert entry["robot_speed"] == pytest.approx(0.6 * part)
        assert entry["person_speed"] == pytest.approx(0.9 * part)
        assert entry["fault"] == "person"
        assert entry["share"] == pytest.approx(0.4)
    (person,) = found.people().itertuples()
    assert person.min_gap_exact == pytest.approx(0.4, abs=1e-12)
    assert person.min_gap_time == pytest.approx(10 / 1.5, abs=1e-12)
    assert found.period == pytest.approx(0.7)


def test_in_and_out_between_two_samples_is_found():
    run = recording([[-5, 0], [5, 0]], [[0, 0.1], [0, 0.1]])
    found = find_encounters(run)
    events = found.events()
    assert events["kind"].tolist() == ["entry"] * 5 + ["exit"] * 5
    assert run.features.closest_gap.min() > 4
    values = {name: value for name, (value, _) in found.values().items()}
    half = np.sqrt(0.5**2 - 0.1**2)
    assert values["first_contact_time"] == pytest.approx(
        (5 - np.sqrt(0.52**2 - 0.1**2)) / 10
    )
    assert values["time_in_touch"] == pytest.approx(half / 5)
    assert values["min_gap_exact"] == pytest.approx(0.1 - 0.5)


def test_who_is_missing_leaves_no_event():
    nowhere = [np.nan, np.nan]
    run = recording(
        [[0, 0], [0, 0], [0, 0], [0, 0]],
        [nowhere, [0.6, 0], [0.6, 0], nowhere],
        [nowhere] * 4,
    )
    found = find_encounters(run)
    assert found.events().empty
    people = found.people()
    assert people["time_in_intimate"].tolist() == [1.0, 0.0]
    assert people["entries_intimate"].tolist() == [0, 0]
    assert np.isnan(people["min_gap_exact"].iloc[1])
    alone = find_encounters(recording([[0, 0], [1, 0]]))
    assert alone.events().empty
    assert alone.values()["time_in_social"] == (0.0, "s")
    single = find_encounters(recording([[0, 0]], [[0.6, 0]]))
    assert single.events().empty


def test_time_with_anybody_is_not_counted_twice():
    times = np.arange(0.0, 10.1, 0.5)
    run = recording(
        straight([0, 0], [0, 0], times),
        straight([-3, 0.5], [1, 0], times),
        straight([-4, -0.5], [1, 0], times),
        times=times,
    )
    found = find_encounters(run)
    half = np.sqrt((0.45 + 0.5) ** 2 - 0.25)
    value, _ = found.values()["time_in_intimate"]
    assert value == pytest.approx(1 + 2 * half)
    each = found.people()["time_in_intimate"]
    np.testing.assert_allclose(each, 2 * half)


@pytest.mark.parametrize(
    ("robot", "crossings"),
    [
        # Across the way, one meter before the person.
        ([[2.5, -1], [2.5, 1]], 1),
        # Behind, too far ahead, not across, and while the person stands.
        ([[-1, -1], [-1, 1]], 0),
        ([[9, -1], [9, 1]], 0),
        ([[2.5, 1], [2.5, 2]], 0),
    ],
)
def test_crossings_in_front(robot, crossings):
    run = recording(robot, [[0, 0], [1, 0]])
    found = find_encounters(run)
    events = found.events()
    own = events[events["kind"] == "crossing"]
    assert len(own) == crossings
    assert found.people()["crossings_in_front"].tolist() == [crossings]
    if crossings:
        assert own["time"].iloc[0] == pytest.approx(0.5)
        assert own["gap"].iloc[0] == pytest.approx(2.0 - 0.5)
    stands = recording(robot, [[0, 0], [0, 0]])
    events = find_encounters(stands).events()
    assert "crossing" not in set(events["kind"])


def brute_force(robot, one, other):
    """Counts how often a robot crosses the line between two, by small steps."""
    u = np.linspace(0, 1, 20001)[:, None]
    r, a, b = (p[0] + u * (p[1] - p[0]) for p in (robot, one, other))
    line, way = b - a, r - a
    side = line[:, 0] * way[:, 1] - line[:, 1] * way[:, 0]
    part = (line * way).sum(axis=1) / (line * line).sum(axis=1)
    flips = np.flatnonzero(np.sign(side[1:]) != np.sign(side[:-1]))
    return int(((part[flips] > 0) & (part[flips] < 1)).sum())


@pytest.mark.slow
def test_cutting_a_group_is_what_small_steps_find():
    generator = np.random.default_rng(7)
    total = 0
    for _ in range(400):
        places = generator.uniform(-2, 2, (3, 2, 2))
        run = recording(places[0], *places[1:], group_ids=(4, 4))
        value, _ = find_encounters(run).values()["groups_cut"]
        assert value == brute_force(*places)
        total += value
    assert total > 20
    # Others are no group.
    run = recording(places[0], *places[1:], group_ids=(4, 5))
    assert find_encounters(run).values()["groups_cut"] == (0.0, "-")


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1, 2.6, 4.0])
@pytest.mark.parametrize("mirror", [False, True])
def test_what_happens_at_a_sample_happens_once(angle, mirror):
    steps = np.arange(-4, 5)
    across = np.column_stack([np.full(9, 2.0), 0.1 * steps])
    walker = np.column_stack([0.05 * (steps + 4), np.zeros(9)])
    pair = [np.column_stack([0.03 * steps + 2, np.full(9, y)]) for y in (1, -1)]
    along = np.column_stack([0.1 * steps + 2, np.full(9, 0.2)])
    for robot, people, name in (
        (across, [walker], "crossings_in_front"),
        (along, pair, "groups_cut"),
    ):
        groups = (1,) * len(people)
        run = recording(robot, *people, times=0.2 * (steps + 4))
        run = dataclasses.replace(run, group_ids=groups)
        value, _ = find_encounters(turned(run, angle, mirror)).values()[name]
        assert value == 1
        # Who begins on the line has not crossed it, to neither side.
        late = dataclasses.replace(
            run,
            times=run.times[4:],
            robot=run.robot[4:],
            humans=run.humans[4:],
            behavior_status=None,
            contacts=None,
        )
        value, _ = find_encounters(turned(late, angle, mirror)).values()[name]
        assert value == 0


def test_exits_are_as_many_as_entries_where_samples_are_at_the_border():
    generator = np.random.default_rng(0)
    for angle in generator.uniform(0, 2 * np.pi, 500):
        along = np.array([np.cos(angle), np.sin(angle)])
        places = np.outer(1.05 + 0.05 * np.arange(-4, 5), along)
        reach = np.full(8, 1.05)
        for way in (places, places[::-1]):
            begin, end = chords_within(way[:-1], way[1:], reach)
            assert (begin > 0).sum() + (end < 1).sum() == 1


def test_steps_of_the_size_of_rounding_enter_as_well_as_exit():
    generator = np.random.default_rng(0)
    angle = generator.uniform(0, 2 * np.pi, 20_000)
    first = np.column_stack([np.cos(angle), np.sin(angle)])
    last = first + generator.normal(scale=1e-16, size=first.shape)
    was, stays = ((it * it).sum(axis=1) <= 1.0 for it in (first, last))
    begin, end = chords_within(first, last, np.ones(len(first)))
    np.testing.assert_array_equal(begin > 0, ~was & stays)
    np.testing.assert_array_equal(end < 1, was & ~stays)


def test_a_passage_that_ends_at_the_border_but_for_rounding_counts():
    angle = np.random.default_rng(0).uniform(0, 2 * np.pi, 2000)
    last = np.column_stack([np.cos(angle), np.sin(angle)])
    across = np.column_stack([np.cos(angle + 0.2), np.sin(angle + 0.2)])
    outside = (last * last).sum(axis=1) > 1.0
    assert outside.any()
    begin, end = chords_within(
        *((last + 1.2 * (across - last))[outside], last[outside]),
        np.ones(outside.sum()),
    )
    np.testing.assert_allclose(begin, 1 / 6, atol=1e-9)
    assert (end < 1).all()
    np.testing.assert_allclose(end, 1.0)


def test_who_leaves_along_the_border_exits_at_once():
    first, last = np.array([[1.0, 0.0], [0.0, 0.0]]), np.ones((2, 2))
    begin, end = chords_within(first, last, np.array([1.0, 0.0]))
    np.testing.assert_array_equal([begin, end], 0.0)
    begin, end = chords_within(last, first, np.array([1.0, 0.0]))
    np.testing.assert_array_equal([begin, end], 1.0)
    # The square of what the roots have is -1e-18 here.
    last, first = np.array([-0.4, 0.0]), np.array([-0.4, 0.1])
    np.testing.assert_array_equal(chords_within(first, last, -last[0]), 1.0)


points = st.floats(-5, 5).map(lambda x: round(x, 3))
chords = st.lists(points, min_size=4, max_size=4)


@given(chords, st.floats(0, 4))
def test_the_part_within_is_what_small_steps_find(ends, reach):
    first, last = np.reshape(ends, (2, 2))
    begin, end = chords_within(first, last, np.float64(reach))
    u = np.linspace(0, 1, 4001)
    away = np.linalg.norm(first + u[:, None] * (last - first), axis=1)
    inside = u[away < reach - 1e-9]
    if np.isnan(begin):
        assert not inside.size
    elif inside.size:
        assert begin <= inside[0] + 1e-6
        assert begin >= inside[0] - 3e-4
        assert end >= inside[-1] - 1e-6
        assert end <= inside[-1] + 3e-4
    at, least = nearest_on_chords(first, last)
    assert 0 <= at <= 1
    assert least <= away.min() + 1e-9


def turned(run, angle, mirror):
    """Returns a recording in another frame."""
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1, -1 if mirror else 1])

    def move(rows):
        rows = rows.copy()
        rows[..., :2] = rows[..., :2] @ matrix.T + [3, -2]
        return rows

    return dataclasses.replace(
        run, robot=move(run.robot), humans=move(run.humans)
    )


@pytest.fixture(scope="module")
def walked():
    scenario = LoadScenario(
        filename="approaching",
        overrides=["evaluator.period=0.05", "evaluator.encounters=true"],
    )
    return RunTrial(scenario)


@pytest.mark.parametrize("mirror", [False, True])
def test_the_frame_and_the_order_of_people_do_not_matter(walked, mirror):
    run = walked.recording
    found = find_encounters(run).people()
    moved = find_encounters(turned(run, 0.7, mirror)).people()
    np.testing.assert_allclose(moved, found, atol=1e-8)
    order = [2, 0, 1]
    other = dataclasses.replace(
        run,
        humans=run.humans[:, order],
        human_names=tuple(run.human_names[i] for i in order),
        group_ids=tuple(run.group_ids[i] for i in order),
        human_ids=(),
        behavior_status=None,
        contacts=None,
    )
    assert find_encounters(other).people().loc[found.index].equals(found)
    np.testing.assert_equal(encounter_values(other), encounter_values(run))


def test_a_part_of_a_recording_has_its_part_of_the_events(walked):
    run = walked.recording
    whole = find_encounters(run).events()
    part = find_encounters(run.since(12.0)).events()
    later = whole[whole["time"] > 12.0].reset_index(drop=True)
    assert part.equals(later)
    with pytest.raises(ValueError, match="nothing is recorded since"):
        run.since(1e4)


def test_results_have_them_if_asked(walked):
    values = encounter_values(walked.recording)
    for name, (value, facts) in values.items():
        np.testing.assert_equal(walked.metrics[name], value)
        assert walked.metrics.attrs["units"][name] == facts["units"]
        assert name not in walked.by_behavior
    plain = RunTrial(LoadScenario(filename="approaching"))
    assert not set(values) & set(plain.metrics.index)
    # At every tenth second, instants are nearly the same.
    rough = find_encounters(plain.recording).values()
    for name, (value, _) in values.items():
        assert rough[name][0] == pytest.approx(value, abs=0.05, nan_ok=True)


def encounters_of(result):
    """Returns the metrics of encounters of a result, as text of all digits."""
    families = result.metrics.attrs["families"]
    names = [it for it in result.metrics.index if families[it] == "encounters"]
    assert names
    return {name: repr(float(result.metrics[name])) for name in names}


@pytest.mark.parametrize("name", ["crossing", "three_robots"])
def test_they_are_the_same_at_any_period_and_after_a_fork(name):
    found = []
    for period in (0.05, 0.1, 1.0):
        scenario = LoadScenario(
            filename=name,
            overrides=[
                "evaluator.encounters=true",
                f"evaluator.period={period}",
                "simulation.duration=9.0",
            ],
        )
        found.append(encounters_of(RunTrial(scenario)))
        diagram = MakeTrialDiagram(scenario)
        simulator = MakeTrialSimulator(diagram)
        simulator.AdvanceTo(4.35)
        fork = simulator.get_context().Clone()
        simulator.AdvanceTo(6.0)
        MakeTrialSimulator(diagram, fork).AdvanceTo(9.0)
        result = GetTrialResult(scenario, diagram, fork)
        found.append(encounters_of(result))
    assert all(values == found[0] for values in found)


@pytest.mark.parametrize(
    ("overrides", "window"),
    [
        (["evaluator.start=by_trigger"], (2.0, 5.0)),
        (["evaluator.timeout=2.5"], (0.0, 3.0)),
        (["evaluator.stale_samples=9"], (0.0, 5.5)),
    ],
)
def test_they_are_those_from_the_first_to_the_last_sample(overrides, window):
    scenario = LoadScenario(
        filename="crossing",
        overrides=[
            "evaluator.encounters=true",
            "evaluator.period=1.0",
            "simulation.duration=5.5",
            *overrides,
        ],
    )
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    context = simulator.get_mutable_context()
    # What is high between samples only begins nothing.
    for high, until in ((0, 0.3), (1, 0.6), (0, 1.7), (1, 5.3), (0, 5.5)):
        if diagram.HasInputPort("trigger"):
            diagram.GetInputPort("trigger").FixValue(context, float(high))
        simulator.AdvanceTo(until)
    result = GetTrialResult(scenario, diagram, context)
    # The robot is never far from people.
    assert result.metrics["time_in_social"] == pytest.approx(
        window[1] - window[0]
    )


def test_several_robots_have_their_names():
    scenario = LoadScenario(
        filename="three_robots",
        overrides=["evaluator.encounters=true", "simulation.duration=5.0"],
    )
    result = RunTrial(scenario)
    first = scenario.robots[0].name
    assert f"{first}.time_in_social" in result.metrics
    one = find_encounters(result.recording, robot=first).values()
    assert result.metrics[f"{first}.min_gap_exact"] == pytest.approx(
        one["min_gap_exact"][0], nan_ok=True
    )


def test_mistakes_are_told():
    run = recording([[0, 0], [1, 0]], [[5, 0], [5, 0]])
    with pytest.raises(ValueError, match=r"zones\['near'\] must be a gap"):
        find_encounters(run, {"near": -0.1})
    with pytest.raises(ValueError, match="robot: must be one of"):
        find_encounters(run, robot="b")


@pytest.mark.parametrize("samples", [1, 3])
def test_who_is_there_at_one_sample_only_is_near_then(samples):
    away = [(np.nan, np.nan)] * (samples - 1)
    run = recording([(0, 0)] * samples, [*away, (2, 0)], [*away, (0.3, 0)])
    last = samples - 1.0
    people = find_encounters(run).people()
    gaps = [2 - sum(RADII), 0.3 - sum(RADII)]
    assert people["min_gap_exact"].tolist() == pytest.approx(gaps)
    assert people["min_gap_time"].tolist() == [last, last]
    values = {name: value for name, (value, _) in encounter_values(run).items()}
    assert values["first_contact_time"] == last
    assert values["entries_touch"] == values["time_in_touch"] == 0
