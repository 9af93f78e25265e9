"""Maps and pictures under a scenario, and walls made of them."""

import base64
import io
import math

from hypothesis import given, settings, strategies as st
import numpy as np
from PIL import Image
import pytest
import shapely

from hunav_drake.editor.background import BackgroundError, read_background
from hunav_drake.editor.session import EditSession
from hunav_drake.editor.tracing import traced_walls
from tests.hunav_drake.editor.test_session import View, kinds
from tests.maps import write_map

ROWS = ["." * 40] * 3 + ["." * 5 + "#" * 20 + "." * 15] * 4 + ["." * 40] * 3


def encoded(content):
    return base64.b64encode(content).decode()


def files_of(path):
    return {it.name: encoded(it.read_bytes()) for it in path.parent.iterdir()}


def picture(cells):
    buffer = io.BytesIO()
    gray = np.where(cells, 0, 255).astype(np.uint8)
    Image.fromarray(gray[::-1]).save(buffer, "PNG")
    return {"plan.png": encoded(buffer.getvalue())}


@pytest.fixture
def files(tmp_path):
    return files_of(write_map(tmp_path, ROWS))


@pytest.fixture
def view():
    return View(EditSession("# mine\n"))


@pytest.mark.slow
def test_a_map_lies_in_its_place(view, files):
    answer, told = view.ask("background", name="cafe", files=files)
    assert answer["kind"] == "background"
    # It has no walls yet.
    (fault,) = told["faults"]
    assert fault["fix"] == {"label": "Trace walls", "do": "trace"}
    assert fault["severity"] == "warning"
    assert (answer["width_m"], answer["height_m"]) == pytest.approx((4.0, 1.0))
    assert answer["origin"] == [1.0, 2.0, 0.0]
    image = base64.b64decode(answer["image"].partition(",")[2])
    pixels = np.asarray(Image.open(io.BytesIO(image)))
    assert pixels.shape == (10, 40)
    # The dark cells of the rows from the top.
    assert (pixels[3:7, 5:25] == 0).all()
    assert (pixels == 0).sum() == 80
    view.messages.clear()
    view.session.receive({"do": "hello", "id": 7})
    assert kinds(view.messages)[-1] == "background"


def test_traced_walls_are_where_the_cells_are(view, files):
    view.ask("background", files=files)
    view.ask("trace")
    (wall,) = view.data["world"]["walls"]
    shape = shapely.Polygon(wall["points"])
    # Columns 5 to 25 from x = 1, rows 3 to 7 from the bottom at y = 2.
    wanted = shapely.box(1.5, 2.3, 3.5, 2.7)
    assert shape.symmetric_difference(wanted).area < 0.05 * wanted.area
    assert view.faults == []
    assert view.text.startswith("# mine\n")
    view.ask("undo")
    assert view.text == "# mine\n"


def test_maps_are_turned(tmp_path, view):
    path = write_map(tmp_path, ROWS, origin=[1.0, 2.0, np.pi / 2])
    view.ask("background", files=files_of(path))
    view.ask("trace")
    shape = shapely.Polygon(view.data["world"]["walls"][0]["points"])
    wanted = shapely.box(0.3, 2.5, 0.7, 4.5)
    assert shape.symmetric_difference(wanted).area < 0.05 * wanted.area


def test_pictures_get_their_scale_from_the_view(view):
    cells = np.zeros((20, 40), dtype=bool)
    cells[5:15, 10:30] = True
    answer, told = view.ask("background", files=picture(cells))
    assert "set its scale" in told["faults"][0]["remedy"]
    assert not answer["is_map"]
    view.ask("trace", width_m=8.0, origin=[-4.0, -2.0, 0.0])
    shape = shapely.Polygon(view.data["world"]["walls"][0]["points"])
    wanted = shapely.box(-2, -1, 2, 1)
    assert shape.symmetric_difference(wanted).area < 0.05 * wanted.area


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.floats(0.1, 0.6))
def test_traced_walls_are_sound_and_hold_the_dark_cells(seed, share):
    coarse = np.random.default_rng(seed).random((7, 9)) < share
    coarse[3, 4] = True
    cells = np.kron(coarse, np.ones((4, 4), dtype=bool))
    background = read_background(picture(cells)).placed(36.0, (0.0, 0.0, 0.0))
    walls = traced_walls(background)
    shapes = [shapely.Polygon(wall["points"]) for wall in walls]
    assert all(it.is_valid and it.area > 0 for it in shapes)
    whole = shapely.union_all(shapes)
    y, x = np.nonzero(coarse)
    centers = shapely.points(4 * x + 2.0, 4 * y + 2.0)
    # Solids around a hole are cut into pieces, each to a cell of its line.
    assert shapely.distance(whole, centers).max(initial=0.0) <= 1.0
    y, x = np.nonzero(~coarse)
    centers = shapely.points(4 * x + 2.0, 4 * y + 2.0)
    assert not shapely.contains(whole, centers).any()


def test_walls_are_added_to_those_there_are(view, files):
    view.edit(
        [
            "set",
            ["world", "walls"],
            [{"type": "box", "center": [9, 9], "size": [1, 1]}],
        ]
    )
    view.ask("background", files=files)
    view.ask("trace")
    shapes = [wall["type"] for wall in view.data["world"]["walls"]]
    assert shapes == ["box", "polygon"]


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ({}, "give a map or a picture"),
        ({"x.png": "???"}, "is not in base64"),
        ({"x.png": encoded(b"no")}, "is not a picture"),
        ({"m.yaml": encoded(b"image: x.pgm")}, "resolution"),
        (
            {
                "m.yaml": encoded(
                    b"image: ../../etc/passwd\nresolution: 1\norigin: [0, 0]\n"
                )
            },
            "m.yaml|passwd",
        ),
        ({"a.png": "", "b.png": ""}, "several images"),
        ({"..": ""}, "is not a file name"),
    ],
)
def test_other_files_are_refused(view, files, words):
    (answer,) = view.ask("background", files=files)
    assert answer["kind"] == "error"
    assert any(word in answer["message"] for word in words.split("|"))
    assert "/tmp" not in answer["message"]
    (answer,) = view.ask("trace")
    assert "no background" in answer["message"]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
def test_a_background_is_nowhere_but_in_the_world(view, bad):
    """What no view could be told would end each session that asks."""
    pixels = picture(np.ones((4, 4), dtype=bool))
    view.ask("background", files=pixels)
    for width, origin in (
        (1.0, [bad, 0, 0]),
        (1.0, [0, bad, 0]),
        (1.0, [0, 0, bad]),
        (bad, [0, 0, 0]),
    ):
        for files in ({}, pixels):
            for do in ("background", "trace"):
                view.ask(do, files=files, width_m=width, origin=origin)
                if files and do == "background":
                    continue
                (answer,) = view.messages
                assert answer["kind"] == "error"
    assert "background" in [it["kind"] for it in view.ask("hello")]


def test_white_pictures_have_no_walls():
    background = read_background(picture(np.zeros((5, 5), dtype=bool)))
    with pytest.raises(BackgroundError, match="no dark areas"):
        traced_walls(background)


def test_the_map_of_a_scenario_is_shown_only_from_its_folder(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    write_map(folder, ROWS)
    write_map(tmp_path, ROWS, name="outside")
    text = "world: {map: map.yaml}\nrobot: {start: [2, 2.5, 0]}\n"
    view = View(EditSession(text, folder=folder))
    state = next(it for it in view.messages if it["kind"] == "state")
    assert state["outlines"]["world/map"]["kind"] == "map"
    assert "is inside" in view.faults[0]["message"]
    view.ask("text", text=text.replace("map.yaml", "../outside.yaml"))
    (fault,) = view.faults
    assert fault["severity"] == "warning"
    assert "outside the folder" in fault["message"]
    assert view.messages[0]["outlines"] == {}


def test_thin_walls_keep_their_thickness_and_are_traced(view, tmp_path):
    rows = ["#" * 80, *["#" + "." * 78 + "#"] * 58, "#" * 80]
    session = view.session
    session.set_map(write_map(tmp_path, rows))
    (fault,) = session.faults
    assert "everybody walks through it" in fault["message"]
    view.ask("trace")
    assert session.faults == []
    walls = [
        shapely.Polygon(it["points"]) for it in view.data["world"]["walls"]
    ]
    # One cell of 0.1 m all around a hall of 8 m by 6 m.
    area = sum(it.area for it in walls)
    assert area == pytest.approx(2 * (8 + 5.8) * 0.1, rel=0.2)
    # Its background may be removed; then nothing is missing either.
    view.ask("undo")
    assert len(session.faults) == 1
    answer, told = view.ask("background", files={}, remove=True)
    assert (answer["image"], told["faults"]) == (None, [])
