"""People who join a crowd at sources, and leave it at sinks."""

from hypothesis import given, settings, strategies as st
import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from scipy import stats

from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    OUTSIDE,
    STATE_SIZE,
    Command,
    is_outside,
)
from hunav_drake.systems.crowd import HumanCrowd, OpenCrowd
from hunav_drake.systems.crowd.doors import (
    CAME,
    ENTERED,
    LEFT,
    PEOPLE,
    SINK_SIZE,
    SOURCE_SIZE,
    Doors,
    Passage,
)
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.area import Area
from hunav_drake.systems.people.population import draw_with_traffic
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
    SinkConfig,
    SourceConfig,
)
from hunav_drake.systems.world.obstacles import Obstacles

NO_WALLS = Obstacles.from_shapes([], solid=[])
STEP = 0.05


def drawn(rate=0.5, number=8, cohorts=(), **values):
    source = SourceConfig(
        name="door",
        start=[Area(rectangle=[0, 0, 1, 4])],
        rate=rate,
        max_present=number,
        sinks={"exit": 1},
        **values,
    )
    config = PopulationConfig(
        seed=1,
        cohorts=list(cohorts),
        sources=[source],
        sinks=[SinkConfig(name="exit", area=Area(rectangle=[5, 0, 6, 4]))],
    )
    return draw_with_traffic(config, NO_WALLS)


def straight(people):
    """Commands to walk to the last goal."""
    commands = np.zeros((len(people), COMMAND_SIZE))
    for row, human in zip(commands, people, strict=True):
        row[[Command.GOAL_X, Command.GOAL_Y]] = human.goals[-1]
        row[Command.HAS_GOAL] = 1
        row[Command.GOAL_RADIUS] = human.goal_radius
        row[Command.DESIRED_SPEED] = row[Command.MAX_SPEED] = 1.2
        row[Command.GROUP_ID] = human.group_id
    return commands


def make(people, traffic, **options):
    dut = OpenCrowd(people, traffic=traffic, num_robots=0, **options)
    context = dut.CreateDefaultContext()
    dut.get_commands_input_port().FixValue(context, straight(people).ravel())
    return dut, context


def rows(dut, context):
    port = dut.get_human_states_output_port()
    return port.Eval(context).reshape(-1, STATE_SIZE)


def advance(dut, context, seconds):
    simulator = Simulator(dut, context)
    simulator.AdvanceTo(context.get_time() + seconds)


def passage(n, sources=1, sinks=1):
    return Passage(
        states=np.full((n, 6), OUTSIDE),
        counts=np.zeros((sources, SOURCE_SIZE)),
        rests=np.zeros(n),
        departures=np.zeros((sinks, SINK_SIZE)),
        moved=np.zeros(n, dtype=bool),
    )


BUSY = drawn(0.2, 12, group_sizes=[2, 1, 1])


@pytest.fixture(scope="module")
def parts():
    return drawn(group_sizes=[2, 1])


def test_groups_come_as_often_as_makes_the_rate_of_people():
    people, traffic = drawn(2.0, 40, group_sizes=[1, 1])
    (source,) = traffic.sources
    size = len(people) / len(source.parties)
    assert 1.2 < size < 1.8
    assert source.rate * size == pytest.approx(2.0)


@pytest.mark.parametrize("rate", [0.7, 1.5])
def test_arrivals_are_a_poisson_process(rate):
    """In windows of 4 s; people who have to wait count, too."""
    people, traffic = drawn(0.1, 2)
    (source,) = traffic.sources
    source = source._replace(rate=rate)
    doors = Doors(people, traffic._replace(sources=(source,)), 0.5)
    windows = []
    commands, nobody = straight(people), np.zeros((0, STATE_SIZE))
    for seed in range(4):
        now = passage(len(people))
        for k in range(1200):
            now = doors.step(now, commands, nobody, seed)
            if k % 8 == 7:
                windows.append(now.counts[0, CAME])
    counts = np.diff(np.reshape(windows, (4, -1)), axis=1, prepend=0).ravel()
    mean = 4 * source.rate
    # Of 600 windows: mean and variance are the same.
    error = np.sqrt(mean / counts.size)
    assert abs(counts.mean() - mean) < 3 * error
    assert counts.var() / mean == pytest.approx(1, abs=0.15)
    most = int(mean) + 3
    observed = np.bincount(np.minimum(counts.astype(int), most))
    expected = stats.poisson.pmf(np.arange(most + 1), mean)
    expected[-1] += stats.poisson.sf(most, mean)
    chi = stats.chisquare(observed, expected * counts.size)
    assert chi.pvalue > 0.01
    # Nobody's number follows from the one before.
    assert abs(np.corrcoef(counts[:-1], counts[1:])[0, 1]) < 0.1


def test_another_source_changes_nobodys_time(parts):
    """The times of a source hang on its name and the seed alone."""
    people, traffic = parts
    first = Doors(people, traffic, STEP)
    named = traffic.sources[0]._replace(name="a", stream=7, parties=())
    both = traffic._replace(sources=(named, *traffic.sources))
    second = Doors(people, both, STEP)
    one, two = passage(len(people)), passage(len(people), 2)
    arguments = straight(people), np.zeros((0, STATE_SIZE)), 3
    for _ in range(400):
        one, two = first.step(one, *arguments), second.step(two, *arguments)
    assert one.counts[0, CAME] > 0
    np.testing.assert_array_equal(one.counts[0], two.counts[1])


def test_a_full_crowd_moves_as_one_without_sources(parts):
    """Bit for bit, as long as nobody comes or leaves."""
    people, traffic = parts
    dut, context = make(people, traffic)
    plain = HumanCrowd(people, num_robots=0)
    other = plain.CreateDefaultContext()
    plain.get_commands_input_port().FixValue(other, straight(people).ravel())
    rng = np.random.default_rng(0)
    states = np.zeros((len(people), 6))
    states[:, :2] = rng.uniform([-8, -4], [0, 4], (len(people), 2))
    for system, own in ((dut, context), (plain, other)):
        system.SetStates(own, states)
        advance(system, own, 2.0)
    np.testing.assert_array_equal(rows(dut, context), rows(plain, other))
    ports = ("forces", "overlaps")
    for name in ports:
        np.testing.assert_array_equal(
            dut.GetOutputPort(name).Eval(context),
            plain.GetOutputPort(name).Eval(other),
        )


def test_those_present_move_as_a_crowd_of_their_own(parts):
    people, traffic = parts
    dut, context = make(people, traffic)
    own = [1, 4, 5]
    some = [people[i] for i in own]
    plain = HumanCrowd(some, num_robots=0)
    other = plain.CreateDefaultContext()
    plain.get_commands_input_port().FixValue(other, straight(some).ravel())
    states = rows(dut, context)[:, :6].copy()
    states[own] = 0.0
    states[own, :2] = [[-6, 1], [-5.5, 1.5], [-5, 0.8]]
    dut.SetStates(context, states)
    plain.SetStates(other, states[own])
    for _ in range(20):
        for system, it in ((dut, context), (plain, other)):
            advance(system, it, STEP)
        now = rows(dut, context)
        if not is_outside(np.delete(now, own, axis=0)).all():
            break
        np.testing.assert_array_equal(now[own], rows(plain, other))
        forces = dut.get_forces_output_port().Eval(context)
        forces = forces.reshape(len(people), -1)
        np.testing.assert_array_equal(
            forces[own].ravel(), plain.get_forces_output_port().Eval(other)
        )
        assert (np.delete(forces, own, axis=0) == 0).all()


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32), rate=st.floats(0.1, 20.0))
def test_whatever_happens_nobody_comes_twice_or_into_another(seed, rate):
    """Others stand, walk and leave at random."""
    people, traffic = BUSY
    sources = [it._replace(rate=rate) for it in traffic.sources]
    doors = Doors(people, traffic._replace(sources=tuple(sources)), 0.2)
    rng = np.random.default_rng(seed)
    bodies = np.array([human.contact_radius for human in people])
    commands, nobody = straight(people), np.zeros((0, STATE_SIZE))
    now = passage(len(people))
    for _ in range(40):
        here = ~is_outside(now.states)
        moves = rng.uniform(-0.3, 1.0, (len(people), 2)) * here[:, None]
        now.states[:, :2] += moves
        now = now._replace(moved=np.zeros(len(people), dtype=bool))
        after = doors.step(now, commands, nobody, seed)
        new = after.moved & ~is_outside(after.states)
        assert not (new & here).any()
        there = ~is_outside(after.states)
        for i in np.flatnonzero(new):
            others = there.copy()
            others[i] = False
            apart = after.states[others, :2] - after.states[i, :2]
            gaps = np.hypot(*apart.T) - bodies[others] - bodies[i]
            assert gaps.min(initial=1.0) >= 0.1 - 1e-9
        assert np.count_nonzero(there) == (
            after.counts[0, PEOPLE] - after.departures[0, LEFT]
        )
        assert after.counts[0, CAME] >= after.counts[0, ENTERED]
        now = after


def test_two_contexts_do_not_disturb_each_other(parts):
    dut, first = make(*parts)
    second = dut.CreateDefaultContext()
    dut.get_commands_input_port().FixValue(second, straight(parts[0]).ravel())
    dut.SetSeed(second, 9)
    advance(dut, first, 6.0)
    expected = rows(dut, first).copy(), dut.GetCounts(first)
    assert (rows(dut, second) == rows(dut, dut.CreateDefaultContext())).all()
    advance(dut, second, 6.0)
    assert dut.GetCounts(first) == expected[1]
    assert (rows(dut, first) == expected[0]).all()
    assert (rows(dut, first) != rows(dut, second)).any()


def test_a_clone_has_the_same_future(parts):
    dut, context = make(*parts)
    advance(dut, context, 5.0)
    clone = context.Clone()
    for it in (context, clone):
        advance(dut, it, 8.0)
    assert (rows(dut, context) == rows(dut, clone)).all()
    assert dut.GetCounts(context) == dut.GetCounts(clone)
    assert dut.GetCounts(context).departures["exit"] > 0


def test_the_seed_resets_all(parts):
    dut, context = make(*parts)
    advance(dut, context, 9.0)
    assert dut.GetCounts(context).arrivals["door"] > 0
    dut.SetSeed(context, 0)
    fresh = dut.CreateDefaultContext()
    for k in range(fresh.num_discrete_state_groups()):
        np.testing.assert_array_equal(
            context.get_discrete_state(k).value(),
            fresh.get_discrete_state(k).value(),
        )


def test_states_that_were_read_can_be_set(parts):
    dut, context = make(*parts)
    advance(dut, context, 6.0)
    kept = rows(dut, context).copy()
    assert 0 < np.count_nonzero(is_outside(kept)) < len(kept)
    advance(dut, context, 3.0)
    dut.SetStates(context, kept)
    np.testing.assert_array_equal(rows(dut, context), kept)


def test_who_is_put_outside_comes_again(parts):
    people, traffic = parts
    dut, context = make(people, traffic)
    advance(dut, context, 6.0)
    gone = np.zeros((len(people), 6))
    gone[:, :2] = OUTSIDE
    dut.SetStates(context, gone)
    before = dut.GetCounts(context).arrivals["door"]
    advance(dut, context, 10.0)
    assert dut.GetCounts(context).arrivals["door"] > before


def test_those_who_go_elsewhere_do_not_leave(parts):
    """Not even in the middle of the sink; nor do those who hold still."""
    people, traffic = parts
    doors = Doors(people, traffic, STEP)
    now = passage(len(people))
    now.states[:] = 0.0
    now.states[:, :2] = [5.5, 2.0]
    commands = straight(people)
    commands[:, Command.GOAL_X] -= 3
    nobody = np.zeros((0, STATE_SIZE))
    assert not doors.step(now, commands, nobody, 0).moved.any()
    commands[:, Command.HAS_GOAL] = 0
    commands[:, Command.HOLD] = 1
    assert not doors.step(now, commands, nobody, 0).moved.any()
    commands[:, Command.HOLD] = 0
    after = doors.step(now, commands, nobody, 0)
    assert after.moved.all()
    assert after.departures[:, LEFT] == [len(people)]


@pytest.mark.parametrize("rate", [0.5, 4.0, 60.0])
def test_a_sink_lets_out_one_after_the_other(rate):
    """Ten who are there at once; nine times the time of one, to a step."""
    people, traffic = drawn(number=10)
    sinks = (traffic.sinks[0]._replace(rate=rate),)
    doors = Doors(people, traffic._replace(sinks=sinks), STEP)
    now = passage(len(people))
    now.states[:] = 0.0
    now.states[:, 0] = 4.75 + 0.1 * np.arange(10)[::-1]
    now.states[:, 1] = 2.0
    nobody = np.zeros((0, STATE_SIZE))
    commands = straight(people)
    for _ in range(100):
        # Time in which nobody is there does not count.
        now = doors.step(now, commands * 0 - 1, nobody, 0)
    assert now.departures[0, LEFT] == 0
    times = []
    steps = 0
    while now.departures[0, LEFT] < 10:
        before = now.departures[0, LEFT]
        now = doors.step(now, commands, nobody, 0)
        times += [steps * STEP] * round(now.departures[0, LEFT] - before)
        steps += 1
    assert times[0] == 0
    expected = np.arange(10) / rate
    late = np.array(times) - expected
    assert late.min() > -1e-9
    assert late.max() < STEP + 1e-9


def test_the_nearest_leaves_first():
    people, traffic = drawn(number=4)
    sinks = (traffic.sinks[0]._replace(rate=1.0),)
    doors = Doors(people, traffic._replace(sinks=sinks), STEP)
    now = passage(len(people))
    now.states[:] = 0.0
    now.states[:, :2] = np.column_stack([[4.75, 4.9, 4.8, 3.0], 4 * [2.0]])
    nobody = np.zeros((0, STATE_SIZE))
    after = doors.step(now, straight(people), nobody, 0)
    assert is_outside(after.states).tolist() == [False, True, False, False]


def test_who_has_left_stays_away_for_a_second():
    people, traffic = drawn(rate=1.0, number=1, speed={"mean": 9.0})
    dut, context = make(people, traffic)
    away = []
    steps = 0
    for _ in range(800):
        advance(dut, context, STEP)
        if is_outside(rows(dut, context))[0]:
            steps += 1
        elif steps:
            away.append(steps)
            steps = 0
    # The first time, nobody had left before; later on, others always wait.
    assert len(away) > 3
    assert min(away[1:]) == 20


def test_robots_keep_a_source_from_letting_people_in():
    people, traffic = drawn(rate=2.0, number=12)
    doors = Doors(people, traffic, STEP)
    robots = np.zeros((1, STATE_SIZE))
    robots[0, :2] = [0.5, 2.0]
    robots[0, 6] = 3.0
    now = passage(len(people))
    for _ in range(100):
        now = doors.step(now, straight(people), robots, 0)
    assert is_outside(now.states).all()
    assert now.counts[0, CAME] > 2
    robots[0, 0] = -20
    now = doors.step(now, straight(people), robots, 0)
    assert not is_outside(now.states).all()


def test_a_crowd_without_sources_lets_people_leave():
    cohort = CohortConfig(
        number=3, start=[Area(rectangle=[2, 0, 4, 4])], sinks={"exit": 1}
    )
    config = PopulationConfig(
        cohorts=[cohort],
        sinks=[SinkConfig(name="exit", area=Area(point=[8, 2]))],
    )
    dut, context = make(*draw_with_traffic(config, NO_WALLS))
    assert not is_outside(rows(dut, context)).any()
    advance(dut, context, 12.0)
    assert is_outside(rows(dut, context)).all()
    assert dut.GetCounts(context) == ({}, {}, {"exit": 3})
    assert not dut.get_forces_output_port().Eval(context).any()


def test_it_has_no_derivatives(parts):
    dut, context = make(*parts)
    with pytest.raises(ValueError, match="without sources and sinks"):
        dut.CalcJacobian(context)
    with pytest.raises(RuntimeError, match="does not support scalar conv"):
        dut.ToAutoDiffXd()


def test_traffic_is_of_all_people(parts):
    people, traffic = parts
    with pytest.raises(ValueError, match=r"of all 9 people, got 8; .*after"):
        OpenCrowd([people[0], *people], traffic=traffic)
    dut, context = make([people[0], *people], traffic.after(1))
    assert is_outside(rows(dut, context)).tolist() == [False] + 8 * [True]


@pytest.mark.parametrize("row", [-1, 1, 0.0, True, "ana"])
def test_only_people_who_are_there_are_taken_out(row):
    dut = OpenCrowd([HumanConfig(pose=[0, 0, 0])])
    with pytest.raises(ValueError, match=r"rows must be whole numbers in \[0,"):
        dut.TakeOut(dut.CreateDefaultContext(), [row])


@pytest.mark.parametrize("rows_out", [(), (2,), (0, 2)])
def test_a_tuple_of_people_is_taken_out_as_a_list(rows_out):
    people = [HumanConfig(pose=[2.0 * i, 1, 0]) for i in range(3)]
    dut = OpenCrowd(people)
    context = dut.CreateDefaultContext()
    dut.TakeOut(context, rows_out)
    found = rows(dut, context)
    assert [*np.flatnonzero(is_outside(found))] == [*rows_out]
    left = [i for i in range(3) if i not in rows_out]
    np.testing.assert_array_equal(found[left, 0], 2.0 * np.array(left))


def test_of_a_group_whose_member_was_taken_out_the_others_come():
    dut, context = make(*drawn(group_sizes=[0, 1]))
    n = len(rows(dut, context))
    dut.TakeOut(context, [0, 2, 3])
    came = np.zeros(n, dtype=bool)
    for _ in range(600):
        advance(dut, context, STEP)
        came |= ~is_outside(rows(dut, context))
    assert came.tolist() == [i not in (0, 2, 3) for i in range(n)]
