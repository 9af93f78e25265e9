"""Texts on signs: their place, size and shape."""

from dataclasses import replace
import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.systems.scene.lettering import lettering_mesh
from hunav_drake.systems.world.solids import Lettering, turned

TEXT = Lettering(text="Exit", pose=(0.0, 0.0, 0.0), middle=2.0, size=(1.0, 0.3))


def area(mesh):
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def covers(mesh, point):
    """Whether a point (y, z) is in a triangle."""
    corners = mesh.vertices[mesh.faces][:, :, 1:] - point
    sides = np.roll(corners, -1, axis=1)
    cross = corners[..., 0] * sides[..., 1] - corners[..., 1] * sides[..., 0]
    return bool((cross >= 0).all(axis=1).any())


@given(
    width=st.floats(0.1, 5.0),
    height=st.floats(0.05, 2.0),
    text=st.sampled_from(["Exit", "Departures\n10:04", "i", "a\\n\\nb $5 $6"]),
)
def test_it_fills_its_room_around_its_middle(width, height, text):
    mesh = lettering_mesh(replace(TEXT, text=text, size=(width, height)))
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    filled = (high - low)[1:] / (width, height)
    assert filled.max() == pytest.approx(1.0)
    assert (filled <= 1 + 1e-9).all()
    np.testing.assert_allclose((low + high)[1:] / 2, [0.0, 2.0], atol=1e-9)
    # Just in front of what it is on.
    assert 0 < low[0] == high[0] < 0.01


@given(x=st.floats(-9, 9), y=st.floats(-9, 9), yaw=st.floats(-3, 3))
def test_it_is_moved_and_turned_as_a_whole(x, y, yaw):
    here = lettering_mesh(TEXT)
    there = lettering_mesh(replace(TEXT, pose=(x, y, yaw)))
    expected = turned(here.vertices[:, :2], (x, y, yaw))
    np.testing.assert_allclose(there.vertices[:, :2], expected, atol=1e-12)
    np.testing.assert_array_equal(there.vertices[:, 2], here.vertices[:, 2])
    facing = [math.cos(yaw), math.sin(yaw), 0.0]
    np.testing.assert_allclose(there.normals - facing, 0.0, atol=1e-12)


def test_its_front_is_where_it_faces():
    """Its triangles are counterclockwise for who looks at it."""
    mesh = lettering_mesh(TEXT)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 0] > 0).all()


def test_it_reads_from_left_to_right_and_down():
    """Who faces it looks along -x, so that +y is to the right."""
    mesh = lettering_mesh(replace(TEXT, text="MMM.\n.", size=(1.0, 1.0)))
    y, z = mesh.vertices[:, 1], mesh.vertices[:, 2]
    upper = y[z > 2.0]
    # The dot of the first line is at the right, and low.
    assert y[(z > 2.0) & (z < upper.mean() + 2.2)].max() > 0.4
    left, right = mesh.vertices[y < -0.2], mesh.vertices[y > 0.45]
    assert np.ptp(left[:, 2]) > 3 * np.ptp(right[:, 2])
    # The second line is below, in the middle.
    assert abs(y[z < z.min() + 0.01].mean()) < 0.05


def test_an_o_has_a_hole_and_a_bar_has_none():
    o = lettering_mesh(replace(TEXT, text="o"))
    bar = lettering_mesh(replace(TEXT, text="|"))
    assert not covers(o, (0.0, 2.0))
    assert covers(bar, (0.0, 2.0))
    width, height = np.ptp(bar.vertices[:, 1:], axis=0)
    assert area(bar) == pytest.approx(width * height)


def test_a_text_is_no_formula():
    """Of "$x$", all three characters are drawn."""
    alone, money = (
        np.ptp(
            lettering_mesh(replace(TEXT, text=it, size=(9, 1))).vertices[:, 1]
        )
        for it in ("x", "$x$")
    )
    assert money > 1.5 * alone


def test_an_island_in_a_hole_is_drawn():
    mesh = lettering_mesh(replace(TEXT, text="\N{REGISTERED SIGN}"))
    height = np.ptp(mesh.vertices[:, 2])
    # The letter R within the circle.
    near = np.hypot(mesh.vertices[:, 1], mesh.vertices[:, 2] - 2.0)
    assert (near < 0.3 * height).any()
    assert not covers(mesh, (-0.36 * height, 2.0))


@pytest.mark.parametrize("blank", ["\u2003\u2003", "\u200b", "\u2800\n\u00ad"])
def test_letters_that_show_nothing_are_no_fault(blank):
    assert len(lettering_mesh(replace(TEXT, text=blank)).faces) == 0
    lines = lettering_mesh(replace(TEXT, text=f"a\n{blank}\nb"))
    assert np.ptp(lines.vertices[:, 2]) == pytest.approx(0.3)
