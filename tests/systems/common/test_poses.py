"""Angles, and being at a goal, of one state or of many."""

import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.common.poses import is_at_goal, wrap_angle, wrap_angles

PI = math.pi


@given(st.floats(-1e3, 1e3))
def test_wrapping_keeps_the_direction(angle):
    one, many = wrap_angle(angle), wrap_angles(np.array([angle]))[0]
    for wrapped in (one, many):
        assert -PI <= wrapped <= PI
        assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
        assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)
    if abs(one) < 3.14:
        assert many == pytest.approx(one, abs=1e-9)
    if abs(angle) < PI:
        assert one == many == angle


@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 2])
def test_the_back_is_a_positive_half_turn(turns):
    angle = PI + 2 * PI * turns
    assert wrap_angle(angle) == pytest.approx(PI)
    if turns in (-1, 0):
        assert wrap_angles(np.array(angle)) == PI


@pytest.mark.parametrize(
    ("pose", "expected"),
    [
        ((2, 3, 1), True),
        ((2.299, 3, 1), True),
        ((2.3, 3, 1), False),
        ((2.2, 3.2, 1), True),
        ((2.25, 3.25, 1), False),
        ((2, 3, 1.5), True),
        ((2, 3, 1.501), False),
        ((2, 3, 0.5 + 2 * PI), True),
        ((2, 3, 0.499 - 2 * PI), False),
    ],
)
def test_at_the_goal_are_both_tolerances_kept(pose, expected):
    settings = {"tolerance": 0.3 - 1e-12, "yaw_tolerance": 0.5 + 1e-12}
    goal = (2.0, 3.0, 1.0)
    assert is_at_goal(pose, goal, **settings) is expected
    many = is_at_goal(tuple(np.full((2, 3), v) for v in pose), goal, **settings)
    assert many.shape == (2, 3)
    assert (many == expected).all()


@given(st.floats(-1e3, 1e3))
def test_a_tolerance_of_half_a_turn_takes_any_heading(yaw):
    assert is_at_goal((0, 0, yaw), (0, 0, 0), tolerance=1, yaw_tolerance=PI)
