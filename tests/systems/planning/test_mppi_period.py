"""MPPI looks ahead as far, and drives as well, whatever its period is."""

import dataclasses

from hypothesis import given, settings, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.planning import View
from hunav_drake.systems.planning.mppi import MppiMemory, MppiPlanner
from hunav_drake.systems.planning.mppi.mppi import setting
from hunav_drake.systems.planning.mppi.rollouts import (
    command_of,
    held,
    limit,
    roll_out,
)
from hunav_drake.systems.planning.navigation.memory import LocalPlan
from tests.systems.planning.test_local_planner import make_task
from tests.systems.planning.test_mppi import FAR, NOBODY, STRAIGHT, make_map


@pytest.mark.parametrize("step", [0.01, 0.05, 0.1])
@pytest.mark.parametrize("cycles", [1, 2, 3, 10])
def test_the_horizon_does_not_depend_on_the_period(step, cycles):
    planner = MppiPlanner(period=step * cycles)
    made = setting(planner, dataclasses.replace(make_task(), time_step=step))
    dt = made.p.dt
    horizon = planner.time_steps * planner.model_dt
    assert made.steps * dt == pytest.approx(horizon, abs=dt / 2)
    assert dt <= max(planner.model_dt, step) + 1e-12
    if planner.period >= planner.model_dt:
        assert made.hold * dt == pytest.approx(planner.period)
    else:
        assert (made.hold, made.steps) == (0, planner.time_steps)


@given(st.integers(1, 12), st.integers(2, 40))
@settings(max_examples=30)
def test_a_command_holds(hold, steps):
    controls = np.random.default_rng(steps).normal(size=(steps, 2))
    result = held(controls, hold)
    commands = np.array([command_of(k, hold) for k in range(steps)])
    # The first is of the last command, the others of `hold` steps each.
    assert (commands == -(-np.arange(steps) // hold)).all()
    for command in set(commands.tolist()):
        mine = commands == command
        mean = controls[mine].mean(axis=0)
        np.testing.assert_allclose(result[mine], [mean] * mine.sum())


def test_what_a_command_brings_about_is_what_the_robot_can_reach():
    """It is limited by where its ramp ends, not by where it begins."""
    planner = MppiPlanner(period=0.5)
    made = setting(planner, make_task())
    assert made.hold == 10
    controls = np.tile([0.6, 0.0], (made.steps, 1))
    limit(controls, np.zeros(5), made.p)
    poses, velocities = np.empty((56, 3)), np.empty((56, 2))
    roll_out(np.zeros(5), controls, made.p, poses, velocities)
    most = make_task().limits.max_acceleration
    # (The first step is as it moves now, the second has the last command.)
    ramp = np.minimum(0.05 * most * np.arange(1, 12), 0.6)
    np.testing.assert_allclose(velocities[1:12, 0], ramp, atol=1e-9)


@pytest.mark.parametrize("period", [0.05, 0.2, 0.5])
def test_the_next_cycle_begins_with_the_command_of_this_one(period):
    planner = MppiPlanner(period=period, batch_size=50)
    task, memory = make_task(), MppiMemory()
    view = View(np.array([0, 0, 0, 0.3, 0, 0, 0.3]), NOBODY, np.array(FAR))
    local = LocalPlan(STRAIGHT, FAR, True)
    made = setting(planner, task)
    for _ in range(3):
        control = planner.control(task, view, local, make_map(), memory)
        memory = control.memory
        assert memory.controls.shape == (made.steps, 2)
        assert memory.past.shape == (4, 2)
        np.testing.assert_array_equal(
            memory.controls[0], [control.v, control.omega]
        )
