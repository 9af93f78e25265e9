"""Worlds of the BARN Challenge: reading, score, damaged files."""

import numpy as np
import pytest

from hunav_drake import GenerateScenario, LoadSuite, RunSuite, ScenarioError
from hunav_drake.runs.cells import cell_sha256, make_cells
from hunav_drake.scenario.generate.barn import (
    Barn,
    barn_score,
    read_columns,
    time_to_goal,
)
from hunav_drake.systems.evaluation.metrics.contacts import contacts_with_walls
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.world.shapes import Disc

MODEL = """<model name='{name}'><static>1</static>
<pose frame=''>{x} {y} 0 0 0 0</pose>
<link name='link'><collision name='c'><geometry>
<cylinder><radius>{r}</radius><length>1</length></cylinder>
</geometry></collision></link></model>"""


def world(columns, state=""):
    models = "".join(
        MODEL.format(name=f"unit_cylinder_{i}", x=x, y=y, r=r)
        for i, (x, y, r) in enumerate(columns)
    )
    ground = "<model name='ground_plane'><link name='link'/></model>"
    return (
        f"<sdf version='1.6'><world name='default'>{ground}{models}"
        f"<state world_name='default'>{state}</state></world></sdf>"
    )


COLUMNS = [(-1.0, 6.0, 0.075), (-3.5, 7.5, 0.1)]


@pytest.fixture
def folder(tmp_path):
    """A folder with two worlds; the path of each is a straight line."""
    (tmp_path / "path_files").mkdir()
    for i in range(2):
        (tmp_path / f"world_{i}.world").write_text(world(COLUMNS[: 2 - i]))
        cells = np.column_stack([np.full(30, 15), np.arange(30)])
        np.save(tmp_path / "path_files" / f"path_{i}.npy", cells)
    return tmp_path


def test_columns_become_discs_and_a_state_moves_them(folder):
    file = folder / "world_0.world"
    assert read_columns(file).tolist() == [list(it) for it in COLUMNS]
    moved = (
        "<model name='unit_cylinder_1'><pose>-3 8 0 0 0 0</pose>"
        "<link name='link'><pose>-3 8 1 0 0 0</pose></link></model>"
    )
    file.write_text(world(COLUMNS, moved))
    assert read_columns(file)[1].tolist() == [-3, 8, 0.1]
    scenario = GenerateScenario("barn", folder=str(folder))
    assert scenario.world.walls == [
        Disc(center=(-1, 6), radius=0.075),
        Disc(center=(-3, 8), radius=0.1),
    ]
    robot = scenario.robot
    assert robot.start == pytest.approx((-2.25, 3, np.pi / 2), abs=1e-3)
    assert robot.goal[:2] == (-2.25, 13)
    assert (robot.goal_tolerance, robot.limits.max_speed) == (1, 2)
    assert scenario.simulation.duration == 100


def test_the_path_runs_from_the_start_through_its_cells_to_the_goal(folder):
    # Cell (15, 0) is at (-2.325, 5.075), cell (15, 29) at (-2.325, 9.425).
    expected = np.hypot(0.075, 2.075) + 29 * 0.15 + np.hypot(0.075, 13 - 9.425)
    kind = Barn(folder=str(folder))
    assert kind.path_length(0) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("time", "score"),
    # For 12 m, the least time is 6 s.
    [(3.0, 0.5), (12.0, 0.5), (24.0, 0.25), (48.0, 0.125), (99.0, 0.125)],
)
def test_the_score_is_the_least_time_over_the_clipped_time(time, score):
    assert barn_score(time, 12.0) == score
    assert barn_score(np.inf, 12.0) == 0


def test_people_may_walk_in_its_worlds(folder):
    scenario = GenerateScenario("barn", folder=str(folder), people=3)
    assert len(scenario.humans) == 3


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("world_0.world", b"<sdf><world>", "Error parsing XML: no element"),
        ("world_0.world", b"", "Error parsing XML"),
        ("world_0.world", b"<sdf/>", "has neither <world> nor <model>"),
        (
            "world_0.world",
            world([("x", 6, 0.075)]).encode(),
            "<pose> must be 6 finite numbers",
        ),
        (
            "world_0.world",
            world([(0, float("nan"), 0.075)]).encode(),
            "<pose> must be 6 finite numbers",
        ),
        (
            "world_0.world",
            world([(0, 6, -1)]).encode(),
            r"<radius> must be in \(0, ",
        ),
        ("world_0.world", None, "there is no such file"),
        ("path_files/path_0.npy", b"text", "is not a path"),
        ("path_files/path_0.npy", None, "there is no such file"),
    ],
)
def test_a_damaged_file_is_told_in_one_line(folder, name, content, told):
    file = folder / name
    file.unlink()
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ValueError, match=told) as caught:
        GenerateScenario("barn", folder=str(folder))
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_path_of_a_wrong_shape_is_told(folder):
    for bad in (np.zeros(4), np.zeros((3, 3)), np.array([[np.nan, 1.0]])):
        np.save(folder / "path_files" / "path_0.npy", bad)
        with pytest.raises(ValueError, match=r"finite numbers of shape \(k, 2"):
            GenerateScenario("barn", folder=str(folder))


def suite_of(folder, **options):
    text = f"scenarios: [{{type: barn, folder: '{folder}'}}]\nseeds: 2\n"
    return LoadSuite(data=text + "planners: [pursuit]\n")


@pytest.mark.slow
def test_a_suite_scores_its_worlds_and_continues(folder, tmp_path):
    suite = suite_of(folder)
    out = tmp_path / "out"
    result = RunSuite(suite, out=out, workers=1)
    assert [row.seed for row in result.rows] == [0, 1]
    for row in result.rows:
        length = Barn(folder=str(folder)).path_length(row.seed)
        # Straight at one column: the robot may touch it.
        touches = row.metrics["contacts_with_walls"] > 0
        assert row.metrics["barn_score"] == pytest.approx(
            0 if touches else barn_score(row.end_time, length), abs=0.02
        )
    (mean,) = result.summary().xs("barn_score", level="metric")["mean"]
    assert mean == pytest.approx(
        np.mean([row.metrics["barn_score"] for row in result.rows])
    )
    again = RunSuite(
        suite, out=out, workers=1, progress=lambda *_: pytest.fail("ran again")
    )
    scores = [
        [row.metrics["barn_score"] for row in it.rows] for it in (result, again)
    ]
    assert scores[0] == scores[1]
    # Other worlds are other trials.
    (folder / "world_1.world").write_text(world(COLUMNS))
    with pytest.raises(ValueError, match="fresh"):
        RunSuite(suite, out=out, workers=1)


def test_a_suite_tells_a_damaged_world_before_it_runs(folder):
    (folder / "world_1.world").write_text("<sdf>")
    with pytest.raises(ScenarioError, match=r"world_1\.world: cannot be read"):
        RunSuite(suite_of(folder), workers=1)


def test_a_world_that_changes_is_read_anew(folder):
    (before,) = make_cells(suite_of(folder))
    columns = len(before.load(1).world.walls)
    (folder / "world_1.world").write_text(world([*COLUMNS, (-2.0, 8.0, 0.1)]))
    (after,) = make_cells(suite_of(folder))
    assert after.sha256 != before.sha256
    assert len(after.load(1).world.walls) == 3 != columns
    # A worker finds that the file is not that of the driver any more.
    assert cell_sha256(before.text, before.load(0), before.kind) != (
        before.sha256
    )


def test_the_score_of_a_robot_whose_walls_are_not_known_is_none_either():
    times = np.arange(4.0)
    robot = np.zeros((4, 7))
    robot[:, 0] = times
    recording = Recording(
        times=times,
        robot=robot,
        humans=np.zeros((4, 0, 7)),
        goal=(3.0, 0.0, 0.0),
        goal_tolerance=0.3,
    )
    assert np.isnan(contacts_with_walls(recording)[0])
    assert np.isnan(barn_score(time_to_goal(recording), 10.0))
