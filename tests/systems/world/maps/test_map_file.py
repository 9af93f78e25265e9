import dataclasses
import math
from pathlib import Path

import numpy as np
from PIL import Image
import pytest
import shapely
import yaml

from hunav_drake import LoadScenario, RunTrial, SaveScenario, ScenarioError
from hunav_drake.systems import behavior
from hunav_drake.systems.world.maps.map_file import (
    MAX_CELLS,
    MapError,
    map_outlines,
    read_map,
)
from hunav_drake.systems.world.obstacles import inside
from hunav_drake.systems.world.shapes import World
from tests.maps import GRAY, write_map
from tests.memory import needs_linux, peak_memory, reset_peak_memory

TREES = Path(behavior.__file__).parent / "trees"
ROOM = ["######", "#....#", "#...?#", "######"]


def test_cells_are_occupied_free_or_unknown(tmp_path):
    dut = read_map(write_map(tmp_path, ROOM))
    expected = np.array([list(row) for row in reversed(ROOM)])
    np.testing.assert_array_equal(dut.occupied, expected == "#")
    np.testing.assert_array_equal(dut.free, expected == ".")
    assert dut.resolution == 0.1
    assert dut.origin == (1.0, 2.0, 0.0)


def test_modes_and_negation_mean_what_they_mean_for_map_server(tmp_path):
    gray = np.array([[0, 50, 100, 101, 178, 255]], dtype=np.uint8)

    def cells(**changes):
        dut = read_map(write_map(tmp_path, gray, **changes))
        return dut.occupied[0].tolist(), dut.free[0].tolist()

    dark = [True, True, False, False, False, False]
    light = [False, False, False, False, False, True]
    assert cells() == cells(mode="scale") == (dark, light)
    # Of a negated map, 178 / 255 = 0.698 and 50 / 255 = 0.196.
    assert cells(negate=1, free_thresh=0.2) == (
        [False, False, False, False, True, True],
        [True, True, False, False, False, False],
    )
    # Percents; more than 100 is not known.
    assert cells(mode="raw") == (
        [False, False, True, False, False, False],
        [True, False, False, False, False, False],
    )
    assert cells(mode="Raw") == cells(mode="raw")
    assert cells(occupied_thresh=0.9)[0] == [True] + [False] * 5
    assert cells(free_thresh=0.5)[1] == [False] * 4 + [True, True]


def test_16_bits_and_transparency_are_read(tmp_path):
    deep = np.array([[65535, 20000, 0]], dtype=np.uint16)
    dut = read_map(write_map(tmp_path, deep))
    assert dut.occupied.tolist() == [[False, True, True]]
    assert dut.free.tolist() == [[True, False, False]]
    # Rounded to 8 bits, 16 bits are the percents of the mode "raw".
    percent = np.array([[257 * 101, 257 * 100, 257 * 2, 99]], dtype=np.uint16)
    dut = read_map(write_map(tmp_path, percent, mode="raw"))
    assert dut.occupied.tolist() == [[False, True, False, False]]
    assert dut.free.tolist() == [[False, False, True, True]]
    clear = np.zeros((1, 2, 4), dtype=np.uint8)
    clear[0, 0, 3] = 255
    path = write_map(tmp_path, ["#"], image="clear.png")
    Image.fromarray(clear).save(tmp_path / "clear.png")
    assert read_map(path).occupied.tolist() == [[True, False]]


def test_a_color_is_as_dark_as_the_mean_of_its_channels(tmp_path):
    """As for map_server: green is not brighter than blue."""
    colors = [[(0, 255, 0), (0, 0, 255), (255, 255, 0), (205, 205, 205)]]
    image = Image.fromarray(np.array(colors, np.uint8))
    image.save(tmp_path / "color.png")
    dut = read_map(write_map(tmp_path, ["...."], image="color.png"))
    assert dut.occupied.tolist() == [[True, True, False, False]]
    assert not dut.free.any()


def test_walls_are_where_the_origin_says(tmp_path):
    path = write_map(tmp_path, ["##..", "...."], resolution=0.5)
    (wall,) = map_outlines(path)
    corners = {(1.0, 2.5), (2.0, 2.5), (2.0, 3.0), (1.0, 3.0)}
    assert {tuple(p) for p in wall.tolist()} == corners
    turned = write_map(
        tmp_path,
        ["##..", "...."],
        name="turned",
        resolution=0.5,
        origin=[1.0, 2.0, math.pi / 2],
    )
    (wall,) = map_outlines(turned)
    corners = {(0.5, 2.0), (0.5, 3.0), (0.0, 3.0), (0.0, 2.0)}
    assert {tuple(p) for p in wall.tolist()} == corners


def test_what_other_tools_write_is_taken(tmp_path):
    # multi_map_server names its maps.
    more = {"map_id": "floor_1", "map_type": "occupancy"}
    assert read_map(write_map(tmp_path, ["#."], **more)).free.any()


def test_a_map_that_changes_is_read_again(tmp_path):
    path = write_map(tmp_path, ["#."])
    assert map_outlines(path)[0].min() == pytest.approx(1.0)
    Image.fromarray(np.zeros((7, 9), np.uint8)).save(tmp_path / "map.pgm")
    assert map_outlines(path)[0].max() == pytest.approx(2.7)


NAMES = ("bookstore", "map_cafe2", "small_house", "small_warehouse")


@pytest.mark.parametrize("name", NAMES)
def test_public_maps_have_the_areas_of_their_pixels(reference, name):
    path = reference / f"hunav/{name}.yaml"
    dut = read_map(path)
    with Image.open(path.with_suffix(".pgm")) as image:
        gray = np.asarray(image)
    assert dut.occupied.sum() == (gray == GRAY["#"]).sum()
    # By their threshold of 0.25, what their makers did not know is free, too.
    seen = np.isin(gray, [GRAY["."], GRAY["?"]])
    assert dut.free.sum() == seen.sum()
    cell = dut.resolution**2
    outlines = [shapely.Polygon(it) for it in map_outlines(path)]
    area = shapely.union_all(outlines).area
    assert area == pytest.approx(dut.occupied.sum() * cell, rel=0.08)
    obstacles = World(map=str(path)).obstacles()
    for cells, within in ((dut.occupied, True), (dut.free, False)):
        if not within:
            # Free cells with none that is occupied beside them.
            near = np.pad(dut.occupied, 1)
            rows, columns = cells.shape
            for i in range(3):
                for j in range(3):
                    cells = cells & ~near[i : i + rows, j : j + columns]
        rows, columns = np.nonzero(cells)
        centers = np.column_stack([columns + 0.5, rows + 0.5])
        p = np.array(dut.origin[:2]) + centers * dut.resolution
        assert (inside(obstacles, p).any(axis=1) == within).all()
    assert len(obstacles.segments) < 0.5 * dut.occupied.sum()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"image": "none.pgm"}, r"none.pgm: No such file"),
        ({"image": "map.yaml"}, "is no image"),
        ({"image": 5}, "image must be the name"),
        ({"image": "a\0b"}, "null"),
        ({"image": "."}, "directory"),
        ({"resolution": 0.0}, r"resolution must be in \(0, 10\] m"),
        ({"resolution": "fine"}, "resolution must be a number"),
        ({"resolution": None}, "resolution must be a number"),
        ({"origin": [1]}, "origin must be"),
        ({"origin": [1, float("nan"), 0]}, "origin must be"),
        ({"origin": [1e9, 0, 0]}, "at most 100000 m away"),
        ({"origin": [1, 10**400, 0]}, "origin must be"),
        ({"resolution": 10**400}, "resolution must be a number"),
        ({"negate": "yes"}, "negate must be 0 or 1"),
        ({"mode": "binary"}, "mode must be one of trinary, scale, raw"),
        ({"occupied_thresh": 0.1}, "free_thresh <= occupied_thresh"),
        ({"occupied_thresh": 65}, "free_thresh <= occupied_thresh"),
        (
            {"ocupied_thresh": 0.5},
            "unknown key 'ocupied_thresh'; did you mean 'occupied_thresh'",
        ),
        ({"inflation": 0.5}, "unknown key 'inflation'; valid: free_thresh"),
    ],
)
def test_a_faulty_map_is_one_fault(tmp_path, changes, words):
    write_map(tmp_path, ["#"], **changes)
    file = tmp_path / "scenario.yaml"
    # The rest is judged without the map.
    file.write_text("world:\n  map: map.yaml\nplanner: {period: 0.07}\n")
    with pytest.raises(ScenarioError, match=words) as info:
        LoadScenario(filename=file)
    assert [it.path for it in info.value.faults] == [
        "world.map",
        "planner.period",
    ]
    assert info.value.faults[0].line == 2
    assert str(tmp_path) in info.value.faults[0].message


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "must be a mapping"),
        (b"- 1\n", "must be a mapping"),
        (b"5: 1\n", "unknown key 5; valid: free_thresh"),
        (b"{", "is not YAML"),
        (b"\xff\xfe\xff", "is not YAML"),
        (b"# " + b"x" * 200_000, "at most 100000 bytes"),
    ],
)
def test_what_is_no_map_is_told(tmp_path, content, words):
    path = tmp_path / "map.yaml"
    path.write_bytes(content)
    with pytest.raises(MapError, match=words):
        read_map(path)


def test_a_cut_off_image_is_told(tmp_path):
    path = write_map(tmp_path, np.zeros((50, 50), np.uint8))
    image = tmp_path / "map.pgm"
    image.write_bytes(image.read_bytes()[:900])
    with pytest.raises(MapError, match=r"map\.pgm"):
        read_map(path)


@needs_linux
def test_a_huge_image_is_refused_before_it_is_decoded(tmp_path):
    path = write_map(tmp_path, ["#"])
    # A file of 100 megapixels that has only its head, and one far beyond.
    for size in ("10000 10000", "1000000 1000000"):
        (tmp_path / "map.pgm").write_text(f"P5\n{size}\n255\n")
        before = reset_peak_memory()
        with pytest.raises(MapError, match=f"at most {MAX_CELLS} pixels"):
            read_map(path)
        assert peak_memory() - before < 20e6


def test_bodies_must_be_clear_of_the_map(tmp_path):
    write_map(tmp_path, ROOM, resolution=1.0, origin=[0, 0, 0])
    text = {
        "world": {"map": "map.yaml"},
        "humans": [{"pose": [2.0, 1.2, 0], "goals": [[4.5, 2.5]]}],
        "robot": {"start": [3.5, 2.5, 0]},
    }
    file = tmp_path / "scenario.yaml"
    file.write_text(yaml.safe_dump(text))
    with pytest.raises(ScenarioError) as info:
        LoadScenario(filename=file)
    (fault,) = info.value.faults
    assert fault.path == "humans[0].pose"
    words = "overlaps world.map; move it 0.15 m along (0.00, 1.00)"
    assert words in fault.message


def test_a_file_and_its_map_may_be_moved(tmp_path):
    """So may a behavior tree."""
    there = tmp_path / "there"
    (there / "runs").mkdir(parents=True)
    write_map(there, ROOM, resolution=1.0, origin=[0, 0, 0])
    (there / "tree.xml").write_text((TREES / "regular.xml").read_text())
    file = there / "a.yaml"
    file.write_text(
        "world: {map: map.yaml}\nhumans: [{pose: [1.6, 2.2, 0],"
        " behavior: ./tree.xml}]\nrobot: {start: [3.2, 2.2, 0]}"
    )
    scenario = LoadScenario(filename=file)
    text = SaveScenario(scenario, there / "runs/a.yaml")
    assert "map: ../map.yaml" in text
    assert LoadScenario(filename=there / "runs/a.yaml") == scenario
    here = there.rename(tmp_path / "here")
    moved = LoadScenario(filename=here / "runs/a.yaml")
    assert moved.world.map == str(here / "map.yaml")
    assert moved.humans[0].behavior == str(here / "tree.xml")
    elsewhere = dataclasses.replace(
        scenario, world=World(map="/nowhere/map.yaml")
    )
    assert "map: /nowhere/map.yaml" in SaveScenario(elsewhere, here / "b.yaml")


def test_people_walk_and_a_file_is_written_with_a_map(tmp_path):
    rows = ["##########", "#........#", "#...##...#", "#........#", "#" * 10]
    write_map(tmp_path, rows, resolution=1.0, origin=[0, 0, 0])
    text = {
        "world": {"map": "map.yaml"},
        "humans": [{"pose": [2.0, 2.5, 0], "goals": [[8.0, 2.5]]}],
        "robot": {"start": [1.5, 1.5, 0]},
        "simulation": {"duration": 12.0},
    }
    file = tmp_path / "scenario.yaml"
    file.write_text(yaml.safe_dump(text))
    scenario = LoadScenario(filename=file)
    assert scenario.world.map == str(tmp_path / "map.yaml")
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    humans = RunTrial(scenario).recording.humans
    np.testing.assert_allclose(humans[-1, 0, :2], [8.0, 2.5], atol=0.35)
    # Around the block in the middle.
    assert not inside(scenario.world.obstacles(), humans[:, 0, :2]).any()
