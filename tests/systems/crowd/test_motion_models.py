"""Rules for all models of human motion."""

from dataclasses import dataclass
import math

from hypothesis import given, strategies as st
import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import LoadScenario, RunTrial
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    FORCES_SIZE,
    TOTAL_FORCE,
    Command,
    RobotRole,
)
from hunav_drake.systems.crowd import (
    MOTION_MODELS,
    CrowdConfig,
    HumanCrowd,
    MotionModel,
    motion_model,
    register_motion_model,
)
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.world.obstacles import Obstacles
from tests.systems.crowd.crowds import BODILESS, human_states, step

NAMES = sorted(MOTION_MODELS)

CORNERS = [[-6.0, 4.0], [-6.0, -5.0], [7.0, -5.0]]
PILLAR = [[0.0, 1.0], [0.5, 1.0], [0.5, 1.5], [0.0, 1.5]]


@pytest.fixture(params=NAMES)
def name(request):
    return request.param


@pytest.fixture
def dut(name):
    return MOTION_MODELS.make(name)


@pytest.fixture
def crowd(make_snapshot):
    """People of all kinds: in groups, held, turned, pushed, without a goal."""
    rng = np.random.default_rng(7)
    n = 24
    states = np.empty((n, 6))
    states[:, :2] = rng.uniform(-4, 6, (n, 2))
    states[:, 2:] = rng.uniform(-1, 1, (n, 4))
    snapshot = make_snapshot(
        states,
        rng.uniform(-5, 6, (n, 2)),
        robots=[[1, 0, 0.3, 0.4, 0.1, 0.2, 0.35], [3, 2, 0, 0, 0, 0, 0.3]],
        walls=Obstacles.from_shapes([CORNERS, PILLAR], solid=[False, True]),
    )
    command = snapshot.command
    command[:, Command.DESIRED_SPEED] = rng.uniform(0, 1.5, n)
    command[:, Command.MAX_SPEED] = rng.uniform(0.5, 1.6, n)
    command[:, Command.ROBOT_ROLE] = np.arange(n) % 3
    command[3:7, Command.GROUP_ID] = 4
    command[7:9, Command.GROUP_ID] = 2
    command[9:12, Command.HOLD] = 1
    command[11:14, Command.TURN_RATE] = 1.5
    command[11:14, Command.YAW_TARGET] = [3.0, -3.0, 0.5]
    command[14:16, Command.ROBOT_REPULSION] = 4.0
    command[16:18, Command.HAS_GOAL] = 0
    return snapshot


def moved_snapshot(snapshot, angle=0.0, shift=(0.0, 0.0), order=None):
    """Returns the snapshot of a world that is turned, shifted, reordered."""
    c, s = math.cos(angle), math.sin(angle)
    matrix = np.array([[c, -s], [s, c]])
    order = np.arange(len(snapshot.states)) if order is None else order

    def move(rows):
        rows = np.array(rows)
        rows[:, :2] = rows[:, :2] @ matrix.T + shift
        rows[:, 2] += angle
        rows[:, 3:5] = rows[:, 3:5] @ matrix.T
        return rows

    command = snapshot.command.copy()
    command[:, :2] = command[:, :2] @ matrix.T + shift
    command[:, Command.YAW_TARGET] += angle
    segments = snapshot.obstacles.segments.reshape(-1, 2) @ matrix.T + shift
    obstacles = Obstacles(
        segments.reshape(-1, 4),
        snapshot.obstacles.first,
        snapshot.obstacles.solid,
    )
    return snapshot._replace(
        states=np.ascontiguousarray(move(snapshot.states)[order]),
        radii=snapshot.radii[order],
        command=np.ascontiguousarray(command[order]),
        parameters=np.ascontiguousarray(snapshot.parameters[order]),
        robots=move(snapshot.robots),
        obstacles=obstacles,
    )


def assert_same_states(states, expected, atol=1e-9):
    states, expected = states.copy(), expected.copy()
    turn = states[:, 2] - expected[:, 2]
    expected[:, 2] += 2 * math.pi * np.round(turn / (2 * math.pi))
    np.testing.assert_allclose(states, expected, rtol=0, atol=atol)


def test_forces_and_states_have_a_row_for_each_person(dut, crowd):
    assert isinstance(dut, MotionModel)
    forces = dut.forces(crowd)
    assert forces.shape == (24, FORCES_SIZE)
    assert forces.dtype == float
    assert dut.advance(crowd, forces).shape == (24, 6)


def test_nobody_is_a_crowd_too(dut, make_snapshot):
    nobody = make_snapshot([], [])
    forces = dut.forces(nobody)
    assert forces.shape == (0, FORCES_SIZE)
    assert dut.advance(nobody, forces).shape == (0, 6)


def test_a_robot_that_is_unseen_in_turn_is_unseen(dut, crowd):
    forces = []
    for role in (RobotRole.UNSEEN, RobotRole.UNSEEN_IN_TURN):
        command = crowd.command.copy()
        command[:, Command.ROBOT_ROLE] = role
        forces.append(dut.forces(crowd._replace(command=command)))
    np.testing.assert_array_equal(*forces)
    command[:, Command.ROBOT_ROLE] = RobotRole.PEDESTRIAN
    seen = dut.forces(crowd._replace(command=command))
    assert (seen != forces[0]).any()


def test_it_changes_nothing_and_repeats_itself(dut, crowd):
    arrays = [
        *(crowd.states, crowd.radii, crowd.command, crowd.parameters),
        *(crowd.robots, crowd.obstacles.segments, crowd.obstacles.first),
    ]
    for array in arrays:
        array.flags.writeable = False
    before = [array.copy() for array in arrays]
    forces = dut.forces(crowd)
    forces.flags.writeable = False
    kept = forces.copy()
    first = dut.advance(crowd, forces)
    np.testing.assert_array_equal(dut.advance(crowd, dut.forces(crowd)), first)
    np.testing.assert_array_equal(forces, kept)
    for array, old in zip(arrays, before, strict=True):
        np.testing.assert_array_equal(array, old)


def test_the_total_is_what_moves_people(dut, crowd):
    """A model that is not made of forces leaves the components zero."""
    forces = dut.forces(crowd).reshape(24, 8, 2)
    assert forces[:, 7].any()
    if forces[:, :7].any():
        np.testing.assert_allclose(
            forces[:, :7].sum(axis=1), forces[:, 7], atol=1e-9
        )


def test_the_way_is_that_of_the_new_velocity(dut, crowd):
    states = step(dut, crowd)
    np.testing.assert_allclose(
        states[:, :2], crowd.states[:, :2] + 0.05 * states[:, 3:5]
    )


def test_who_holds_still_does(dut, crowd):
    held = crowd.command[:, Command.HOLD] == 1
    states = step(dut, crowd)
    np.testing.assert_array_equal(states[held, 3:5], 0)
    np.testing.assert_array_equal(states[held, :2], crowd.states[held, :2])
    # Nor do they turn, unless they shall.
    np.testing.assert_array_equal(states[9:11, 2], crowd.states[9:11, 2])
    np.testing.assert_array_equal(states[9:11, 5], 0)


def test_who_shall_turn_does_at_that_rate(dut, crowd):
    states = step(dut, crowd)
    turned = states[11:14, 2] - crowd.states[11:14, 2]
    target = crowd.command[11:14, Command.YAW_TARGET]
    turn = target - crowd.states[11:14, 2]
    turn -= 2 * math.pi * np.round(turn / (2 * math.pi))
    expected = np.clip(turn, -1.5 * 0.05, 1.5 * 0.05)
    np.testing.assert_allclose(turned, expected, atol=1e-12)
    np.testing.assert_allclose(states[11:14, 5], expected / 0.05, atol=1e-9)


def test_without_a_goal_people_come_to_rest(dut, make_snapshot, walk):
    snapshot = make_snapshot([0, 0, 0.3, 1, 0.5, 1], [9, 0], max_speed=3.0)
    snapshot.command[0, Command.HAS_GOAL] = 0
    state = walk(dut, snapshot, 12.0)[-1, 0]
    assert np.hypot(*state[3:5]) < 1e-4
    assert abs(state[5]) < 1e-2


def test_people_reach_their_goal_and_stay(dut, make_snapshot, walk):
    snapshot = make_snapshot([0, 0, 2.5, 0, 0, 0], [4, 3])
    states = walk(dut, snapshot, 20.0)[:, 0]
    assert math.dist(states[-1, :2], (4, 3)) < 0.5
    assert np.hypot(*states[-1, 3:5]) < 1e-3
    # The yaw is where they walked to.
    assert states[80, 2] == pytest.approx(math.atan2(3, 4), abs=0.1)


@pytest.mark.parametrize("angle", [1.1, math.pi / 2, math.pi])
def test_a_turned_world_moves_the_same_way(angle, dut, crowd):
    assert_same_states(
        step(dut, moved_snapshot(crowd, angle)),
        moved_snapshot(crowd._replace(states=step(dut, crowd)), angle).states,
    )


def test_a_shifted_world_moves_the_same_way(dut, crowd):
    shift = (100.0, -50.0)
    assert_same_states(
        step(dut, moved_snapshot(crowd, shift=shift)),
        moved_snapshot(
            crowd._replace(states=step(dut, crowd)), shift=shift
        ).states,
    )


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_people_does_not_matter(seed, dut, crowd):
    order = np.random.default_rng(seed).permutation(24)
    assert_same_states(
        step(dut, moved_snapshot(crowd, order=order)), step(dut, crowd)[order]
    )


numbers = st.one_of(
    st.sampled_from([0.0, 0.0, 1.0, -1.0, 1e-9, 1e-300, 0.3]), st.floats(-5, 5)
)
speeds = st.one_of(numbers, st.sampled_from([1e3, -1e6]))
people = st.lists(
    st.tuples(
        *(numbers, numbers, st.floats(-3.2, 3.2), speeds, speeds, numbers),
        *(numbers, numbers),
        st.sampled_from([0.0, 0.0, 1.2, 10.0]),
        st.sampled_from([-1, 0]),
        st.sampled_from(list(RobotRole)),
        st.sampled_from([0, 0, 1]),
    ),
    min_size=1,
    max_size=12,
)


@given(
    rows=people,
    walls=st.lists(st.lists(st.tuples(numbers, numbers), min_size=1)),
    time_step=st.sampled_from([0.01, 0.05, 0.5]),
)
@pytest.mark.parametrize("name", NAMES)
def test_no_crowd_gives_nan_or_exceeds_its_speed(
    name, rows, walls, time_step, make_snapshot
):
    model = MOTION_MODELS.make(name)
    rows = np.array(rows, dtype=float)
    snapshot = make_snapshot(
        rows[:, :6],
        rows[:, 6:8],
        speed=rows[:, 8],
        max_speed=np.maximum(rows[:, 8], 0.5),
        radius=0.35,
        robots=[[0, 0, 0, 1, 0, 0, 0.3], [0, 0, 0, 1, 0, 0, 0.3]],
        walls=Obstacles.from_shapes(walls, solid=[False] * len(walls)),
        time_step=time_step,
    )
    snapshot.command[:, Command.GROUP_ID] = rows[:, 9]
    snapshot.command[:, Command.ROBOT_ROLE] = rows[:, 10]
    snapshot.command[:, Command.HOLD] = rows[:, 11]
    snapshot.command[:, Command.ROBOT_REPULSION] = 4.0 * (rows[:, 10] == 1)
    for _ in range(3):
        forces = model.forces(snapshot)
        states = model.advance(snapshot, forces)
        assert np.isfinite(forces).all()
        assert np.isfinite(states).all()
        speed = np.hypot(states[:, 3], states[:, 4])
        cap = snapshot.command[:, Command.MAX_SPEED]
        assert (speed <= cap * (1 + 1e-12)).all()
        assert (speed[rows[:, 11] == 1] == 0).all()
        snapshot = snapshot._replace(states=states)


def make_crowd_of_three(config):
    humans = [
        HumanConfig(pose=[0, 0, 0]),
        HumanConfig(pose=[4, 0.3, math.pi]),
        HumanConfig(pose=[1, 2, -1.5]),
    ]
    wall = Obstacles.from_shapes([[[-5.0, -1.0], [9.0, -1.0]]], solid=[False])
    dut = HumanCrowd(humans, obstacles=wall, config=config)
    context = dut.CreateDefaultContext()
    goals = [[8, 0], [-6, 0], [1, -0.5]]
    commands = np.zeros((3, COMMAND_SIZE))
    for command, goal in zip(commands, goals, strict=True):
        command[:6] = *goal, 0.3, 1, 1.2, 1.3
        command[Command.ROBOT_ROLE] = RobotRole.PEDESTRIAN
        command[Command.GROUP_ID] = -1
    dut.get_commands_input_port().FixValue(context, commands.ravel())
    dut.get_robot_states_input_port().FixValue(
        context, [3.0, 3.0, math.pi, 0.0, 0.0, 0.0, 0.35]
    )
    return dut, context


def test_a_crowd_moves_by_it_and_a_clone_has_the_same_future(name):
    dut, context = make_crowd_of_three(CrowdConfig(model=name))
    simulator = Simulator(dut, context)
    simulator.AdvanceTo(1.5)
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(12.0)
    states = human_states(dut, simulator.get_context())
    assert np.linalg.norm(states[:2, :2] - [[8, 0], [-6, 0]]) < 1.0
    Simulator(dut, clone).AdvanceTo(12.0)
    np.testing.assert_array_equal(human_states(dut, clone), states)


@pytest.mark.parametrize(
    "scenario",
    ["passing", "crossing", pytest.param("cafe", marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("name", sorted(set(NAMES) - {"social_force"}))
def test_a_shipped_scenario_ends_at_the_goal(scenario, name):
    scenario = LoadScenario(
        filename=scenario, overrides=[f"crowd.model={name}"]
    )
    result = RunTrial(scenario)
    humans, robot = result.recording.humans, result.recording.robot
    assert result.end_reason == "goal"
    assert np.isfinite(humans).all()
    assert np.isfinite(robot).all()
    # The robot touches no body.
    away = np.linalg.norm(humans[..., :2] - robot[:, None, :2], axis=-1)
    bodies = [human.contact_radius for human in scenario.humans]
    assert (away > bodies + robot[:, None, 6]).all()


@pytest.fixture
def drifting(monkeypatch):
    """A user's own model, of plain NumPy, for the time of a test."""
    monkeypatch.setattr(
        motion_model.MOTION_MODELS,
        "_choices",
        dict(motion_model.MOTION_MODELS._choices),
    )

    @register_motion_model("drifting")
    @dataclass(kw_only=True)
    class Drifting(MotionModel):
        """Everybody is carried away by the wind."""

        wind: float = 0.5

        def forces(self, snapshot):
            return np.zeros((len(snapshot.states), FORCES_SIZE))

        def advance(self, snapshot, forces):
            states = np.array(snapshot.states)
            states[:, 3] = self.wind
            states[:, 0] += self.wind * snapshot.time_step
            return states

    return Drifting


@pytest.mark.usefixtures("drifting")
def test_a_model_of_ones_own_moves_a_crowd():
    dut, context = make_crowd_of_three(
        CrowdConfig(**{**BODILESS, "model": {"type": "drifting", "wind": 2.0}})
    )
    Simulator(dut, context).AdvanceTo(1.0 - 0.01)
    np.testing.assert_allclose(human_states(dut, context)[:, 0], [2, 6, 3])


def test_a_name_is_given_once():
    with pytest.raises(ValueError, match="'orca' is registered already"):
        register_motion_model("orca")(MOTION_MODELS["social_force"])


def test_an_unknown_model_is_told():
    with pytest.raises(ValueError, match="'orka'; did you mean 'orca'"):
        make_crowd_of_three(CrowdConfig(model="orka"))


def test_an_unknown_parameter_is_told(name):
    with pytest.raises(ValueError, match="no_such_thing"):
        make_crowd_of_three(
            CrowdConfig(model={"type": name, "no_such_thing": 1.0})
        )


@pytest.mark.parametrize(
    ("name", "parameter", "value", "words"),
    [
        ("orca", "time_horizon", 0.0, r"in \(0, 1000\] s"),
        ("orca", "max_neighbors", 0, "greater than or equal to 1"),
        ("orca", "epsilon", "much", "valid number"),
        ("headed_social_force", "mass", 0.0, r"in \[1, 1000\] kg"),
        ("headed_social_force", "alpha", math.nan, "finite"),
        ("social_force", "kernel", "gpu", "'fast', 'reference', 'numpy'"),
        ("collision_free_speed", "time_gap", 0.0, r"in \(0, 1000\] s"),
        ("collision_free_speed", "epsilon", 2.0, r"in \[-1, 1\] rad"),
        ("anticipation_velocity", "same_way", 1.5, r"in \[0, 0.9\]"),
        ("anticipation_velocity", "body_radius", 0.0, r"in \(0, 5\] m"),
    ],
)
def test_a_parameter_out_of_range_is_told(name, parameter, value, words):
    with pytest.raises(ValueError, match=words) as info:
        MOTION_MODELS.make({"type": name, parameter: value})
    assert parameter in str(info.value)


WALL = Obstacles.from_shapes([[[3.0, -2.0], [3.0, 2.0]]], solid=[False])


@pytest.fixture(scope="module")
def changeable():
    """Registers a model whose results a function changes."""

    @register_motion_model("test_motion_models: changeable")
    @dataclass
    class Changeable(MotionModel):
        change: str = ""

        def forces(self, snapshot):
            forces = np.zeros((len(snapshot.states), FORCES_SIZE))
            forces[:, TOTAL_FORCE] = 2.0
            return CHANGES[self.change](forces)

        def advance(self, snapshot, forces):
            states = snapshot.states.copy()
            states[:, 0] += 0.1 * np.ravel(forces)[TOTAL_FORCE]
            return CHANGES[self.change](states)

    return "test_motion_models: changeable"


CHANGES = {
    "": lambda array: array,
    "single": lambda array: array.astype(np.float32),
    "columns": np.asfortranarray,
    "lists": lambda array: array.tolist(),
    "flat": np.ravel,
    "narrow": lambda array: array[:, :5],
    "nothing": lambda array: None,
    "words": lambda array: array.astype(str) + "m",
}


def drift(model, change, walls):
    """Returns where people are after a step of such a model."""
    dut = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0]), HumanConfig(pose=[0, 1, 0])],
        obstacles=WALL if walls else None,
        config=CrowdConfig(
            **{**BODILESS, "model": {"type": model, "change": change}}
        ),
        num_robots=0,
    )
    context = dut.CreateDefaultContext()
    dut.get_commands_input_port().FixValue(context, np.zeros(2 * COMMAND_SIZE))
    Simulator(dut, context).AdvanceTo(0.02)
    return dut.get_human_states_output_port().Eval(context).reshape(2, 7)


@pytest.mark.parametrize("walls", [False, True])
@pytest.mark.parametrize("change", ["", "single", "columns", "lists"])
def test_a_model_may_give_any_array_of_numbers(changeable, change, walls):
    states = drift(changeable, change, walls)
    np.testing.assert_allclose(states[:, 0], 0.2, rtol=1e-6)


@pytest.mark.parametrize("walls", [False, True])
@pytest.mark.parametrize("change", ["flat", "narrow", "nothing", "words"])
def test_a_model_that_gives_something_else_is_told(changeable, change, walls):
    with pytest.raises(
        ValueError, match=rf"'{changeable}' must give .* by forces\(\)"
    ):
        drift(changeable, change, walls)


@pytest.mark.parametrize("what", ["radii", "parameters", "states", "robots"])
def test_a_model_cannot_write_to_what_it_is_given(what):
    name = f"test_motion_models: writes {what}"

    @register_motion_model(name)
    @dataclass
    class Writing(MotionModel):
        def forces(self, snapshot):
            getattr(snapshot, what)[:] = 0.01
            return np.zeros((len(snapshot.states), FORCES_SIZE))

        def advance(self, snapshot, forces):
            return snapshot.states

    dut = HumanCrowd(
        [HumanConfig(pose=[1, 0, 0])], config=CrowdConfig(model=name)
    )
    context = dut.CreateDefaultContext()
    dut.get_commands_input_port().FixValue(context, np.zeros(COMMAND_SIZE))
    dut.get_robot_states_input_port().FixValue(context, np.ones(7))
    with pytest.raises(ValueError, match="read-only"):
        dut.get_forces_output_port().Eval(context)


def test_a_class_that_lacks_a_function_is_no_model():
    with pytest.raises(TypeError, match="lacks advance"):

        @register_motion_model("test_motion_models: half")
        @dataclass
        class Half(MotionModel):
            def forces(self, snapshot): ...


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("size", [1e13, 1e154, 1e200, 1.7e308])
@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("social_force", {}),
        ("social_force", {"kernel": "numpy"}),
        ("social_force", {"kernel": "reference"}),
        ("headed_social_force", {}),
        ("orca", {}),
        ("collision_free_speed", {}),
        ("anticipation_velocity", {}),
    ],
)
def test_no_finite_number_is_too_large(model, parameters, size):
    rng = np.random.default_rng(0)
    n = 60
    dut = HumanCrowd(
        [HumanConfig(pose=[0, 0, 0], group_id=i % 3) for i in range(n)],
        config=CrowdConfig(model={"type": model, **parameters}),
        obstacles=WALL,
    )
    context = dut.CreateDefaultContext()
    states = rng.choice([0.0, 1.0, -1.0, size, -size], (n, 6))
    dut.SetStates(context, states)
    command = rng.choice([0.0, 1.0, -1.0, size], (n, COMMAND_SIZE))
    command[:, Command.MAX_SPEED] = abs(command[:, Command.MAX_SPEED])
    dut.get_commands_input_port().FixValue(context, command.ravel())
    dut.get_robot_states_input_port().FixValue(
        context, rng.choice([0.0, 1.0, size], 7)
    )
    assert np.isfinite(dut.get_forces_output_port().Eval(context)).all()
    moved = dut.EvalUniquePeriodicDiscreteUpdate(context)
    assert np.isfinite(moved.value(0)).all()
