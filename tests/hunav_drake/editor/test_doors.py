"""Doors that are cut into walls."""

import math

from hypothesis import given, strategies as st
import pytest
import shapely

from hunav_drake.editor.document.plain_data import OperationError
from hunav_drake.editor.doors import DOOR, door_operations
from hunav_drake.editor.session import EditSession
from tests.hunav_drake.editor.test_session import View

BOX = {"type": "box", "name": "a", "center": [0, 0], "size": [4, 0.15]}
L_SHAPE = {
    "type": "polygon",
    "height": 2.0,
    "points": [
        *([-3, -0.1], [3, -0.1], [3, 3]),
        *([2.8, 3], [2.8, 0.1], [-3, 0.1]),
    ],
}


def walls_after(*walls, at=(0.0, 0.0)):
    """Returns the walls after a door at a place, by a session."""
    session = EditSession("")
    view = View(session)
    view.edit(["set", ["world"], {"walls": list(walls)}])
    view.ask("door", at=list(at), reach=0.2)
    session.receive({"do": "undo"})
    assert view.data["world"]["walls"] == list(walls)
    session.receive({"do": "redo"})
    return view.data["world"]["walls"]


@given(
    x=st.floats(-5, 5),
    y=st.floats(-5, 5),
    yaw=st.floats(-3, 3),
    length=st.floats(1.2, 8),
    share=st.floats(0, 1),
)
def test_a_box_of_any_pose_becomes_two_boxes(x, y, yaw, length, share):
    box = {**BOX, "center": [x, y], "size": [length, 0.15], "yaw": yaw}
    along = (share - 0.5) * length
    place = x + along * math.cos(yaw), y + along * math.sin(yaw)
    operations = door_operations({"world": {"walls": [box]}}, place, 0.2)
    pieces = [it[2] for it in operations]
    assert [it["type"] for it in pieces] == ["box", "box"]
    assert [it["name"] for it in pieces] == ["a", "a_2"]
    left = sum(it["size"][0] for it in pieces)
    assert left == pytest.approx(length - DOOR, abs=3e-3)
    for it in pieces:
        assert it["yaw"] == yaw
        assert it["size"][0] >= 0.1 - 2e-3
        away = [a - b for a, b in zip(it["center"], (x, y), strict=True)]
        across = away[1] * math.cos(yaw) - away[0] * math.sin(yaw)
        assert abs(across) < 2e-3


def test_a_polygon_becomes_two_and_keeps_its_height():
    first, second = walls_after(L_SHAPE)
    assert {first["height"], second["height"]} == {2.0}
    both = [shapely.Polygon(it["points"]) for it in (first, second)]
    whole = shapely.Polygon(L_SHAPE["points"]).area
    assert sum(it.area for it in both) == pytest.approx(whole - 0.2 * DOOR)
    assert both[0].distance(both[1]) == pytest.approx(DOOR)


def test_a_door_is_beside_a_wall_that_ends_there():
    """And opens onto free floor on both sides."""
    cross = {"type": "box", "center": [0, 1], "size": [0.15, 1.85]}
    walls = walls_after(BOX, cross)
    assert walls[-1] == cross
    gap = sorted(
        it["center"][0] + sign * it["size"][0] / 2
        for it in walls[:2]
        for sign in (-1, 1)
    )[1:3]
    assert gap[1] - gap[0] == pytest.approx(DOOR, abs=2e-3)
    assert min(abs(it) for it in gap) > 0.075
    assert gap[0] * gap[1] > 0


@pytest.mark.parametrize(
    ("wall", "words"),
    [
        ({**BOX, "size": [1.0, 0.15]}, "it takes 1.1 m of straight wall"),
        ({**BOX, "size": [4, 2]}, "at most 0.8 m thick"),
        ({**BOX, "center": [9, 9]}, r"no wall at \(0.00, 0.00\)"),
        (
            {"type": "disc", "center": [0, 0], "radius": 0.3},
            "no room for a door",
        ),
        ("nonsense", "no wall"),
    ],
)
def test_a_door_that_does_not_fit_is_refused(wall, words):
    with pytest.raises(OperationError, match=words):
        door_operations({"world": {"walls": [wall]}}, (0, 0), 0.2)


@pytest.mark.parametrize("thickness", [0.001, 0.005, 0.05])
def test_thin_walls_keep_what_stands_beside_the_door(thickness):
    wall = {**BOX, "size": [1.2, thickness]}
    operations = door_operations({"world": {"walls": [wall]}}, (0, 0), 0.2)
    widths = sorted(piece["size"][0] for *_, piece in operations)
    assert widths == pytest.approx([0.15, 0.15], abs=0.02)


def test_a_short_wall_within_the_door_goes():
    walls = [
        {"type": "box", "center": [0, 0], "size": [4, 0.1]},
        {"type": "box", "center": [0, 0.1], "size": [0.6, 0.1]},
    ]
    found = door_operations({"world": {"walls": walls}}, (0, 0), 0.2)
    assert ("remove", ("world", "walls", 1)) in [
        (kind, tuple(path)) for kind, path, *_ in found
    ]
    assert [it[0] for it in found].count("set") == 1
