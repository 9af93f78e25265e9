"""The forces and steps of the crowd against those of the original C++."""

import itertools
import json

import numpy as np
from pydrake.systems.framework import Context
import pytest

from hunav_drake.systems.common.layout import COMMAND_SIZE, Command, RobotRole
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.crowd.social_force.hash_order import hash_order
from hunav_drake.systems.people import HumanConfig, SocialForceParameters
from hunav_drake.systems.world.obstacles import Obstacles
from tests.recorded import read_recorded, recorded_names, single
from tests.systems.crowd.crowds import FREE

# The original's names of the parameters, and ours.
PARAMETERS = {
    "force_factor_desired": "goal_factor",
    "force_factor_obstacle": "obstacle_factor",
    "force_sigma_obstacle": "obstacle_sigma",
    "force_factor_social": "social_factor",
    "force_factor_group_gaze": "group_gaze_factor",
    "force_factor_group_coherence": "group_coherence_factor",
    "force_factor_group_repulsion": "group_repulsion_factor",
    "lambda": "lambda_importance",
}

# Our components, and the original's.
COMPONENTS = {
    0: "desired",
    1: "obstacle",
    2: "social",
    3: "group_gaze",
    4: "group_coherence",
    5: "group_repulsion",
    7: "global",
}


def make_recorded_human(agent, *, epsilon):
    weights = {"social_factor": 2.1, **agent.get("params", {})}
    weights = {PARAMETERS.get(k, k): float(v) for k, v in weights.items()}
    if epsilon is not None:
        weights["epsilon"] = epsilon
    return HumanConfig(
        pose=[*agent["position"], agent["yaw"]],
        desired_speed=agent["desired_velocity"],
        radius=agent["radius"],
        forces=SocialForceParameters(**weights),
    )


def make_command(agent):
    command = np.zeros(COMMAND_SIZE)
    if agent.get("goals"):
        goal = agent["goals"][0]
        command[:4] = goal["x"], goal["y"], goal["radius"], 1
    command[Command.DESIRED_SPEED] = agent["desired_velocity"]
    command[Command.MAX_SPEED] = agent["desired_velocity"]
    command[Command.GROUP_ID] = agent.get("group_id", -1)
    return command


def eval_forces(agents, index, *, epsilon, kernel="fast"):
    """Returns the forces on one agent, the only one with these obstacles."""
    dut = HumanCrowd(
        [make_recorded_human(agent, epsilon=epsilon) for agent in agents],
        obstacles=Obstacles.from_points(agents[index].get("obstacles", [])),
        config=CrowdConfig(
            model={"type": "social_force", "kernel": kernel, "time_gap": 0.0},
            obstacle_range=1e5,
            route_planning=False,
            groups_part=False,
            keep_apart=False,
        ),
        num_robots=0,
    )
    context = dut.CreateDefaultContext()
    states = [
        [*agent["position"], agent["yaw"], *agent["velocity"], 0]
        for agent in agents
    ]
    context.SetDiscreteState(0, np.ravel(states).astype(float))
    commands = np.ravel([make_command(agent) for agent in agents])
    dut.get_commands_input_port().FixValue(context, commands)
    forces = dut.get_forces_output_port().Eval(context)
    return forces.reshape(len(agents), 8, 2)[index]


@pytest.mark.parametrize(("form", "epsilon"), [("single", 0.0), ("all", None)])
def test_forces_are_those_of_the_original(form, epsilon):
    compared = 0
    for case in json.loads(read_recorded("forces"))["cases"]:
        agents = case["input"]["agents"]
        places = [tuple(agent["position"]) for agent in agents]
        for i, expected in enumerate(case["expected"][form]["forces"]):
            # Of an exact head-on encounter, where rounding decides the side,
            # and of people on one another, where the original has no rule, the
            # forces between people are left out, and what they are part of.
            margin = float(expected["margin"]["min_abs_theta"])
            undecided = margin < 1e-9 or places.count(places[i]) > 1
            forces = eval_forces(agents, i, epsilon=epsilon)
            assert np.all(np.isfinite(forces))
            for component, name in COMPONENTS.items():
                if undecided and name in ("social", "global"):
                    continue
                value = np.array(expected[name], dtype=float)
                if not np.all(np.isfinite(value)):
                    continue
                error = np.abs(forces[component] - value)
                allowed = 1e-12 * np.maximum(1, np.abs(value))
                assert np.all(error <= allowed), (case["input"]["name"], name)
                compared += 1
    assert compared > 2800


def test_the_kernel_of_hunavsim_gives_the_bits_of_the_form_that_it_calls():
    """Every bit of every component of everybody, the undecided included."""
    compared = undecided = 0
    for case in json.loads(read_recorded("forces"))["cases"]:
        agents = case["input"]["agents"]
        places = [tuple(agent["position"]) for agent in agents]
        # It adds up in the order of a hash table, which shall be that of the
        # recorded agents here.
        rows = hash_order(range(1, len(agents) + 1))
        listed = [agents[k] for k in np.argsort(rows)]
        for i, expected in enumerate(case["expected"]["single"]["forces"]):
            forces = eval_forces(
                listed, rows[i], epsilon=None, kernel="hunavsim"
            )
            assert np.all(np.isfinite(forces))
            for component, name in COMPONENTS.items():
                value = np.array(expected[name], dtype=float)
                if np.all(np.isfinite(value)):
                    np.testing.assert_array_equal(
                        forces[component], value, (case["input"]["name"], name)
                    )
                    compared += 1
                elif name != "global":
                    # HuNavSim takes zero for what is not a number.
                    assert not forces[component].any(), name
            margin = float(expected["margin"]["min_abs_theta"])
            undecided += margin < 1e-9 or places.count(places[i]) > 1
    assert compared > 2800
    assert undecided > 10


@pytest.mark.parametrize(("form", "epsilon"), [("single", 0.0), ("all", None)])
def test_the_reference_kernel_gives_the_same_bits(form, epsilon):
    """In the form with one snapshot, every bit of every component.

    The other form computes the middle of a group in another order.
    """
    different = dict.fromkeys(COMPONENTS.values(), 0)
    compared = 0
    for case in json.loads(read_recorded("forces"))["cases"]:
        agents = case["input"]["agents"]
        places = [tuple(agent["position"]) for agent in agents]
        for i, expected in enumerate(case["expected"][form]["forces"]):
            margin = float(expected["margin"]["min_abs_theta"])
            if margin < 1e-9 or places.count(places[i]) > 1:
                continue
            forces = eval_forces(agents, i, epsilon=epsilon, kernel="reference")
            for component, name in COMPONENTS.items():
                value = np.array(expected[name], dtype=float)
                if np.all(np.isfinite(value)):
                    compared += 1
                    different[name] += bool(np.any(forces[component] != value))
    print(f"{compared} compared, not bit-identical: {different}")
    assert compared > 2500
    if form == "all":
        assert not any(different.values())
    for name in ("desired", "obstacle", "social", "group_repulsion"):
        assert different[name] == 0


# The behaviors of the original that do not react to the robot.
ROLES = {1: RobotRole.PEDESTRIAN, 2: RobotRole.OBSTACLE}
TRACES = [
    name
    for name in recorded_names("crowd")
    if "regular" in name or "impassive" in name
]


def make_recorded_crowd(scenario) -> HumanCrowd:
    humans = [
        HumanConfig(
            pose=[agent["x"], agent["y"], agent["yaw"]],
            desired_speed=single(agent["desired_velocity"]),
            radius=single(agent["radius"]),
            forces=SocialForceParameters(epsilon=0.0),
        )
        for agent in scenario["agents"]
    ]
    walls = scenario.get("obstacles")
    if walls is None:
        return HumanCrowd(
            humans, config=CrowdConfig(**FREE), time_step=scenario["dt"]
        )
    return HumanCrowd(
        humans,
        obstacles=Obstacles.from_points(walls["points"]),
        config=CrowdConfig(
            obstacle_range=walls["max_dist"],
            max_obstacles=walls["count"],
            # The original has none of this.
            **FREE,
            keep_out_of_walls=False,
            route_planning=False,
        ),
        time_step=scenario["dt"],
    )


def fix_recorded_inputs(dut, context: Context, scenario, before, after):
    robot = [*after["robot"], scenario["robot"]["radius"]]
    dut.get_robot_states_input_port().FixValue(context, robot)
    commands = np.zeros((len(scenario["agents"]), COMMAND_SIZE))
    for i, agent in enumerate(scenario["agents"]):
        command = commands[i]
        goal_index = int(before["agents"][i][8])
        if goal_index >= 0:
            command[:4] = (
                *agent["goals"][goal_index],
                single(agent["goal_radius"]),
                1,
            )
        speed = single(agent["desired_velocity"])
        command[Command.DESIRED_SPEED] = command[Command.MAX_SPEED] = speed
        command[Command.ROBOT_ROLE] = ROLES[agent["behavior"]]
        command[Command.GROUP_ID] = agent["group_id"]
    dut.get_commands_input_port().FixValue(context, commands.ravel())


@pytest.mark.parametrize("name", TRACES)
def test_every_step_is_that_of_the_original(name):
    """Each step starts from the recorded state of the step before.

    The one difference: the original stands still for the step in which a goal
    is reached, and a person here walks on.
    """
    case = json.loads(read_recorded(name))
    scenario, steps = case["scenario"], case["trace"]["steps"]
    dut = make_recorded_crowd(scenario)
    context = dut.CreateDefaultContext()
    n = len(scenario["agents"])
    compared = 0
    for before, after in itertools.pairwise(steps):
        start = np.zeros((n, 6))
        start[:, :5] = np.array(before["agents"])[:, :5]
        context.SetDiscreteState(0, start.ravel())
        fix_recorded_inputs(dut, context, scenario, before, after)
        updated = dut.EvalUniquePeriodicDiscreteUpdate(context).value(0)
        moved = updated.reshape(n, 6)
        expected = np.array(after["agents"])
        same_goal = np.array(before["agents"])[:, 8] == expected[:, 8]
        columns = [0, 1, 3, 4]
        np.testing.assert_allclose(
            moved[same_goal][:, columns],
            expected[same_goal][:, columns],
            rtol=0,
            atol=1e-9,
        )
        np.testing.assert_allclose(
            np.exp(1j * moved[same_goal, 2]),
            np.exp(1j * expected[same_goal, 2]),
            atol=1e-6,
        )
        compared += int(same_goal.sum())
    assert compared >= 0.98 * n * (len(steps) - 1)
