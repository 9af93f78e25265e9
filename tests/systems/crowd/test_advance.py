"""People with a user's model follow their commands."""

import numpy as np
from pydantic.dataclasses import dataclass
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake import AddHumans, HumanConfig
from hunav_drake.systems.common.layout import FORCES_SIZE, TOTAL_FORCE, Command
from hunav_drake.systems.crowd import (
    MOTION_MODELS,
    CrowdConfig,
    HumanCrowd,
    MotionModel,
    advance_people,
    register_motion_model,
)
from tests.systems.crowd.crowds import BODILESS


@pytest.fixture(autouse=True)
def straight(monkeypatch):
    monkeypatch.setattr(MOTION_MODELS, "_choices", dict(MOTION_MODELS))

    @register_motion_model("straight")
    @dataclass
    class Straight(MotionModel):
        time: float = 0.5

        def forces(self, s):
            way = s.command[:, :2] - s.states[:, :2]
            way /= np.maximum(np.hypot(*way.T), 1e-9)[:, None]
            way *= s.command[:, Command.HAS_GOAL, None]
            wanted = 9 * way * s.command[:, Command.DESIRED_SPEED, None]
            forces = np.zeros((len(s.states), FORCES_SIZE))
            forces[:, TOTAL_FORCE:] = (wanted - s.states[:, 3:5]) / self.time
            return forces

        def advance(self, s, forces):
            return advance_people(s, forces)


def run_straight(human, time, **kwargs):
    builder = DiagramBuilder()
    people = AddHumans(
        builder,
        [human],
        config=CrowdConfig(**{**BODILESS, "model": "straight", **kwargs}),
        num_robots=0,
    )
    builder.ExportOutput(people.human_states, "human_states")
    diagram = builder.Build()
    simulator = Simulator(diagram)
    states = []
    for t in np.arange(0, time, 0.05):
        simulator.AdvanceTo(t)
        states.append(diagram.get_output_port().Eval(simulator.get_context()))
    return np.array(states)


def test_a_person_stays_at_the_goal():
    states = run_straight(HumanConfig(pose=[0, 0, 0], goals=[[3, 4]]), 25.0)
    assert np.hypot(*(states[-1, :2] - [3, 4])) < 1.0
    assert np.hypot(*states[-1, 3:5]) < 1e-3


def test_a_person_keeps_the_speed_limit_and_looks_ahead():
    human = HumanConfig(pose=[0, 0, 0], goals=[[30, 40]], max_speed=1.4)
    states = run_straight(human, 5.0)
    assert np.hypot(*states[:, 3:5].T).max() <= 1.4 + 1e-12
    assert states[-1, 2] == pytest.approx(np.arctan2(4, 3))


def test_a_person_who_is_to_stand_still_does():
    tree = (
        '<root BTCPP_format="4"><BehaviorTree ID="T"><Sequence>'
        '<StandStill seconds="100"/></Sequence></BehaviorTree></root>'
    )
    human = HumanConfig(pose=[0, 0, 0], goals=[[9, 0]], behavior=tree)
    states = run_straight(human, 3.0)
    np.testing.assert_array_equal(states[:, :2], 0)


def test_what_is_not_finite_is_told_with_the_person():
    @register_motion_model("wild")
    @dataclass
    class Wild(MotionModel):
        def forces(self, s):
            return np.zeros((len(s.states), FORCES_SIZE))

        def advance(self, s, forces):
            return np.full((len(s.states), 6), np.nan)

    human = HumanConfig(pose=[0, 0, 0], goals=[[3, 4]])
    crowd = HumanCrowd([human], config=CrowdConfig(model="wild"), num_robots=0)
    simulator = Simulator(crowd)
    context = simulator.get_mutable_context()
    crowd.get_commands_input_port().FixValue(context, np.zeros(12))
    words = r"'wild' must give finite numbers by advance\(\).* humans\[0\]"
    with pytest.raises(ValueError, match=words):
        simulator.AdvanceTo(0.1)
