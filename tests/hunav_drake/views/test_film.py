import dataclasses
import multiprocessing

import numpy as np
from PIL import Image
import pytest

from hunav_drake.runs.result_files import WriteResult
from hunav_drake.scenario import LoadScenario, SaveScenario
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.scene.palette import accent, clothes
from hunav_drake.systems.scene.scene_config import OVERLAYS
from hunav_drake.trial.simulation import RunTrial
from hunav_drake.views import film as mut, film_overlays
from hunav_drake.views.film_files import frame_times, gif_period
from hunav_drake.views.film_overlays import FilmOverlays
from hunav_drake.views.film_scene import FilmScene
from hunav_drake.views.plan_view import PlanView
from hunav_drake.views.recorded_trial import LoadRecordedTrial
from tests.robot_models import FILES

SIZE = (320, 200)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run of three seconds."""
    scenario = LoadScenario(
        filename="combined", overrides=["simulation.duration=3.0"]
    )
    return WriteResult(
        RunTrial(scenario),
        tmp_path_factory.mktemp("results"),
        add=lambda folder: SaveScenario(scenario, folder / "scenario.yaml"),
    )


def config(**options):
    return mut.FilmConfig(size=SIZE, **options)


def near(image, pixel, color, reach=14, tolerance=0.25):
    """How many pixels about a place have a color, RGB in [0, 1]."""
    x, y = (round(float(v)) for v in pixel)
    part = image[max(y - reach, 0) : y + reach, max(x - reach, 0) : x + reach]
    off = np.abs(part / 255.0 - np.array(color)).max(axis=-1)
    return int((off < tolerance).sum())


@pytest.mark.parametrize("view", ["perspective", "top", "follow"])
def test_robot_and_people_are_seen_where_they_are(run, view):
    trial = LoadRecordedTrial(run)
    scene = FilmScene(trial, view, SIZE, start=1.0, step=0.5, shadows=False)
    for time in (1.0, 1.5):
        shot = scene.Take()
        assert shot.time == pytest.approx(time)
        humans, (robot,) = trial.States(time)
        (pixel,), _ = shot.camera.Project(np.array([[*robot[:2], 0.25]]))
        assert near(shot.image, pixel, (0.95, 0.95, 0.95)) > 15
        # Blue, orange and green are the shirts of the first three.
        chests = np.column_stack([humans[:, :2], np.full(3, 1.3)])
        pixels, _ = shot.camera.Project(chests)
        for place, color in zip(
            pixels,
            [(0, 0.4, 0.65), (0.8, 0.55, 0), (0, 0.55, 0.4)],
            strict=True,
        ):
            inside = np.all(place > 0) and np.all(place < SIZE)
            assert inside or view == "follow"
            if inside:
                assert near(shot.image, place, color) > 5
        # The floor is seen, but not where the robot stands.
        x, y = (int(v) for v in pixel)
        assert shot.floor.mean() > 0.2
        assert not shot.floor[y, x]


def test_meshes_that_cannot_be_shown_are_told(tmp_path):
    """Drake's renderer asks for normals."""
    (tmp_path / "tent.obj").write_text(FILES["part.obj"])
    (tmp_path / "hall.urdf").write_text(
        '<robot name="hall"><link name="l"><visual><geometry><mesh'
        ' filename="tent.obj"/></geometry></visual><collision><geometry><box'
        ' size="1 1 1"/></geometry></collision></link></robot>'
    )
    (tmp_path / "trial.yaml").write_text(
        "{world: {models: [{file: hall.urdf}]},"
        " robot: {start: [-2, 0, 0], goal: [-1, 0, 0]},"
        " simulation: {duration: 0.1}}"
    )
    scenario = LoadScenario(filename=str(tmp_path / "trial.yaml"))
    folder = WriteResult(
        RunTrial(scenario),
        tmp_path / "out",
        add=lambda folder: SaveScenario(scenario, folder / "scenario.yaml"),
    )
    rule = r"world\.models\[0\]\.file: no film can show it: .*no normals"
    with pytest.raises(ValueError, match=rule):
        mut.RenderFilm(folder, tmp_path / "a.png", config())
    assert mut.RenderFilm(
        folder, tmp_path / "a.png", config(view="plot")
    ).exists()


NARROW = """
world:
  walls:
    - {type: box, center: [0, 0.8], size: [6, 0.2]}
    - {type: box, center: [0, -0.8], size: [6, 0.2]}
humans: [{pose: [1, 0, 3.14]}]
robot: {start: [-2, 0, 0], goal: [2.5, 0, 0]}
simulation: {duration: 0.5}
"""


def test_one_looks_over_high_walls(tmp_path):
    scenario = LoadScenario(data=NARROW)
    folder = WriteResult(
        RunTrial(scenario),
        tmp_path,
        add=lambda folder: SaveScenario(scenario, folder / "scenario.yaml"),
    )
    trial = LoadRecordedTrial(folder)
    assert [wall.height for wall in trial.world.walls] == [2.5, 2.5]
    scene = FilmScene(trial, "perspective", SIZE, start=0, step=1)
    shot = scene.Take()
    (chest,), _ = shot.camera.Project(np.array([[1, 0, 1.3]]))
    assert near(shot.image, chest, (0, 0.4, 0.65), reach=8, tolerance=0.2) > 15


def test_overlays_on_the_floor_are_behind_people(run):
    trial = LoadRecordedTrial(run)
    scene = FilmScene(
        trial, "perspective", SIZE, start=2.0, step=0.1, shadows=False
    )
    shot = scene.Take()
    bare = np.asarray(FilmOverlays(trial, []).Draw(shot))
    marked = np.asarray(FilmOverlays(trial, ["goals", "rings"]).Draw(shot))
    changed = np.any(bare != marked, axis=-1)
    assert changed.sum() > 100
    assert not np.any(changed & ~shot.floor)
    named = np.asarray(FilmOverlays(trial, ["names"]).Draw(shot))
    # Tags hide what is behind them: each is a plate of one color.
    assert np.any(named != bare, axis=-1).sum() > 1000


def test_tags_are_whole_beside_the_edges_of_a_picture(run):
    trial = LoadRecordedTrial(run)
    scene = FilmScene(trial, "top", SIZE, start=1.0, step=0.1, shadows=False)
    shot = scene.Take()
    blank = np.zeros_like(shot.image)
    robots = np.full_like(shot.robots, 1e3)

    def tag_size(place):
        humans = np.full_like(shot.humans, np.nan)
        humans[0] = [*place, 0.0, 0.0, 0.0, 0.0, 0.3]
        alone = dataclasses.replace(
            shot,
            image=blank,
            floor=np.zeros_like(shot.floor),
            humans=humans,
            robots=robots,
        )
        drawn = np.asarray(FilmOverlays(trial, ["names"]).Draw(alone))
        return np.any(drawn != blank, axis=-1).sum()

    grid = np.arange(-9.0, 9.0, 0.02)
    places = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    tops = np.column_stack([places, np.full(len(places), 2.0)])
    pixels, _ = shot.camera.Project(tops)
    middle, *edges = (
        tag_size(places[np.argmin(np.abs(pixels - [x, 100]).sum(axis=1))])
        for x in (160, 4, SIZE[0] - 4)
    )
    assert edges == [middle, middle]
    assert middle > 100


def test_a_drawing_has_the_tags_of_other_views_and_a_robot_unlike_people(run):
    trial = LoadRecordedTrial(run)
    plan = PlanView(trial, ["names", "clock"], (640, 400))
    plan.Draw(0.0)
    texts = {it.get_text(): it for it in plan._ax.texts}
    middle = " \N{MIDDLE DOT} "
    assert {it.partition(middle)[0] for it in texts} == {
        *(it.name for it in trial.humans),
        *("robot", "0.0 s"),
    }
    assert not any("regular" in it for it in texts)
    stands = [it for it in texts if it.endswith(f"{middle}stands")]
    assert len(stands) == len(trial.humans)
    for it in texts.values():
        box = it.get_window_extent()
        assert -1 <= box.x0 <= box.x1 <= 641
    discs = [it for it in plan._ax.patches if hasattr(it, "radius")]
    white = [it.get_facecolor()[:3] == (1.0, 1.0, 1.0) for it in discs]
    assert white == [False] * len(trial.humans) + [True]


def test_who_is_absent_is_not_drawn(run):
    trial = LoadRecordedTrial(run)
    humans = trial.recording.humans.copy()
    humans[:, 1] = np.nan
    recording = dataclasses.replace(trial.recording, humans=humans)
    trial = dataclasses.replace(trial, recording=recording)
    scene = FilmScene(trial, "top", SIZE, start=1.0, step=0.1, shadows=False)
    overlays = [it for it in OVERLAYS if it not in mut.NOT_RECORDED]
    shot = scene.Take()
    FilmOverlays(trial, overlays).Draw(shot)
    orange = np.abs(shot.image / 255.0 - (0.8, 0.55, 0)).max(axis=-1) < 0.2
    assert orange.sum() < 5


def test_a_gif_has_the_frames_and_the_size_that_are_told(run, tmp_path):
    told = []
    path = mut.RenderFilm(
        run,
        tmp_path / "film.gif",
        config(view="plot", fps=10.0, start=0.5, end=1.5),
        progress=lambda done, total: told.append((done, total)),
    )
    with Image.open(path) as film:
        assert film.size == SIZE
        assert film.n_frames == 11
        assert film.info["duration"] == 100
    assert told == [(k + 1, 11) for k in range(11)]


def test_a_film_at_twice_the_speed_has_half_the_frames(run, tmp_path):
    slow, fast = (
        mut.RenderFilm(
            run,
            tmp_path / f"{speed}.gif",
            config(view="plot", fps=10.0, speed=speed, end=2.0),
        )
        for speed in (1.0, 2.0)
    )
    frames = []
    for path in (slow, fast):
        with Image.open(path) as film:
            frames.append(film.n_frames)
    assert frames == [21, 11]


def test_a_film_is_made_by_pyav(run, tmp_path):
    av = pytest.importorskip("av", reason="the extra [film] is not installed")
    path = mut.RenderFilm(
        run, tmp_path / "film.mp4", config(view="plot", fps=10.0, end=1.0)
    )
    with av.open(path) as film:
        frames = [f.to_image() for f in film.decode(video=0)]
    assert len(frames) == 11
    assert {frame.size for frame in frames} == {SIZE}


def test_a_picture_is_of_the_instant_that_is_told(run, tmp_path):
    pictures = []
    for time in (0.0, 2.5):
        path = mut.RenderFilm(
            run, tmp_path / f"{time}.png", config(start=time, shadows=False)
        )
        pictures.append(np.asarray(Image.open(path)))
    assert pictures[0].shape == (SIZE[1], SIZE[0], 3)
    assert np.any(pictures[0] != pictures[1])


def test_a_recording_from_elsewhere_is_filmed_too(run, tmp_path):
    """Without its scenario, by what the recording tells."""
    recording = Recording.load(run / "recording.npz")
    recording.save(tmp_path / "other.npz")
    trial = LoadRecordedTrial(tmp_path / "other.npz")
    known = LoadRecordedTrial(run)
    assert [h.name for h in trial.humans] == [h.name for h in known.humans]
    assert trial.robots[""].goal == pytest.approx(known.robots[""].goal)
    np.testing.assert_allclose(
        trial.world.obstacles().segments, known.world.obstacles().segments
    )
    mut.RenderFilm(
        tmp_path / "other.npz", tmp_path / "a.png", config(view="plot")
    )


def test_states_between_samples_turn_the_short_way():
    times = np.array([0.0, 1.0])
    rows = np.zeros((2, 7))
    rows[:, 0] = [0.0, 2.0]
    rows[:, 2] = [np.pi - 0.1, -np.pi + 0.1]
    rows[:, 6] = 0.3
    humans = np.stack([rows, np.full((2, 7), np.nan)], axis=1)
    recording = Recording(times=times, robot=rows, humans=humans)
    trial = mut.RecordedTrial(
        recording=recording, world=None, humans=[], robots={}, scene=None
    )
    people, (robot,) = trial.States(0.25)
    assert robot[0] == pytest.approx(0.5)
    assert robot[2] == pytest.approx(np.pi - 0.05)
    np.testing.assert_allclose(people[0], robot)
    assert np.isnan(people[1]).all()
    assert trial.States(7.0)[1][0, 0] == 2.0


FLEET = """
robots:
  - {name: anna, robot: {start: [-2, 0, 0], goal: [2, 0, 0]}}
  - {name: bob, robot: {start: [2, 1, 3.14], goal: [-2, 1, 3.14]}}
humans: [{pose: [0, -2, 0], goals: [[1, -2]]}]
simulation: {duration: 1.0}
"""


@pytest.mark.parametrize("view", ["perspective", "plot"])
def test_several_robots_have_names_and_colors(tmp_path, view):
    scenario = LoadScenario(data=FLEET)
    folder = WriteResult(
        RunTrial(scenario),
        tmp_path,
        add=lambda folder: SaveScenario(scenario, folder / "scenario.yaml"),
    )
    trial = LoadRecordedTrial(folder)
    _, robots = trial.States(1.0)
    assert [*trial.robots] == ["anna", "bob"]
    np.testing.assert_allclose(robots[:, 1], [0.0, 1.0], atol=0.1)
    if view == "plot":
        plan = PlanView(trial, [], SIZE)
        image, named = (
            np.asarray(PlanView(trial, shown, SIZE).Draw(1.0))
            for shown in ([], ["names"])
        )
        (x_min, x_max), (y_min, y_max) = plan._limits
        pixels = (robots[:, :2] - [x_min, y_max]) * (
            SIZE[0] / (x_max - x_min),
            SIZE[1] / (y_min - y_max),
        )
    else:
        scene = FilmScene(trial, view, SIZE, start=1.0, step=0.1, shadows=False)
        shot = scene.Take()
        image, named = (
            np.asarray(FilmOverlays(trial, shown).Draw(shot))
            for shown in ([], ["names"])
        )
        tops = np.column_stack([robots[:, :2], [0.3, 0.3]])
        pixels, _ = shot.camera.Project(tops)
    for k, pixel in enumerate(pixels):
        own, other = accent(k).rgba[:3], accent(1 - k).rgba[:3]
        assert near(image, pixel, own) > 4 * near(image, pixel, other)
        # The tag is above the robot.
        x, y = (round(v) for v in pixel)
        above = np.s_[max(y - 40, 0) : y, x - 20 : x + 20]
        assert np.any(image[above] != named[above])


def test_several_robots_of_a_recording_are_filmed_too(tmp_path):
    recording = RunTrial(LoadScenario(data=FLEET)).recording
    recording.save(tmp_path / "other.npz")
    trial = LoadRecordedTrial(tmp_path / "other.npz")
    goals = [robot.goal[:2] for robot in trial.robots.values()]
    assert goals == [(2.0, 0.0), (-2.0, 1.0)]


def test_times_of_frames():
    np.testing.assert_allclose(
        frame_times(1.0, 2.0, 0.25), [1, 1.25, 1.5, 1.75, 2]
    )
    assert frame_times(3.0, 3.0, 0.1) == [3.0]
    # A GIF counts in hundredths of a second.
    assert gif_period(25.0) == 40
    assert gif_period(12.0) == 80
    assert gif_period(120.0) == 20


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("film.avi", {}, r"must end in one of .gif, .mp4, .png, got '.avi'"),
        ("film", {}, "must end in one of"),
        ("film.gif", {"fps": 0.0}, r"fps: must be in \[0.1, 120\]"),
        ("film.gif", {"speed": float("nan")}, "speed: must be in"),
        (
            "film.gif",
            {"start": 90.0},
            r"in the recording, \[0, 3\] s, got 90 s",
        ),
        ("film.gif", {"start": 2.0, "end": 1.0}, "not be before the first"),
        ("film.gif", {"overlays": ["forces"]}, "'forces' is not in recordings"),
        ("film.gif", {"overlays": ["name"]}, "there is no 'name'; did you"),
        ("film.gif", {"view": "above"}, "view: there is no 'above'; valid"),
    ],
)
def test_errors_name_value_and_remedy(run, tmp_path, name, options, message):
    with pytest.raises(ValueError, match=message):
        mut.RenderFilm(run, tmp_path / name, config(**options))
    assert not list(tmp_path.iterdir())


def test_a_size_that_cannot_be_drawn_is_an_error(run, tmp_path):
    with pytest.raises(ValueError, match="width: must be in"):
        mut.RenderFilm(run, tmp_path / "a.gif", mut.FilmConfig(size=(8, 200)))


def test_tags_have_dots_in_the_colors_of_the_figures(
    run, tmp_path, monkeypatch
):
    owners = {}
    draw = film_overlays.tag_picture

    def drawn(text, *arguments, owner=None, **options):
        owners[text.split()[0]] = owner
        return draw(text, *arguments, owner=owner, **options)

    monkeypatch.setattr(film_overlays, "tag_picture", drawn)
    options = config(overlays=["names"], start=1.0, end=1.0)
    mut.RenderFilm(run, tmp_path / "a.gif", options, workers=1)
    names = LoadRecordedTrial(run).humans
    for i, human in enumerate(names):
        assert owners[human.name] == clothes(i).top
    assert owners["robot"] is None
    assert len({str(owners[it.name]) for it in names}) == len(names) > 1


def test_without_pyav_the_remedy_is_told(run, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "hunav_drake.views.film_files.importlib.util.find_spec",
        lambda name: None,
    )
    with pytest.raises(
        ValueError, match=r"hunav_drake\[film\].*or write a .gif"
    ):
        mut.RenderFilm(run, tmp_path / "a.mp4", config())


def test_a_folder_without_a_recording_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"there is no recording.*hunav run"):
        LoadRecordedTrial(tmp_path)


def test_a_folder_of_results_is_that_of_its_only_run(run, tmp_path):
    results = run.parents[1]
    assert LoadRecordedTrial(results).duration == pytest.approx(3.0)


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_a_film_is_the_same_for_any_number_of_processes(run, tmp_path, suffix):
    if suffix == ".mp4":
        pytest.importorskip("av", reason="the extra [film] is not installed")
    films = []
    for workers in (1, 2):
        path = tmp_path / f"{workers}{suffix}"
        told = []
        mut.RenderFilm(
            run,
            path,
            config(fps=14.0),
            progress=lambda done, total, told=told: told.append((done, total)),
            workers=workers,
        )
        assert told == [(k + 1, told[0][1]) for k in range(told[0][1])]
        assert len(told) > 40
        films.append(path.read_bytes())
    assert films[0] == films[1]


@pytest.mark.slow
@pytest.mark.parametrize("view", ["perspective", "top"])
def test_what_stands_still_is_drawn_once_and_looks_the_same(run, view):
    """A picture is put together from what stands still and what moves."""
    trial = LoadRecordedTrial(run)
    shots = []
    for drawn in (FilmScene, WholeScene):
        scene = drawn(trial, view, SIZE, start=1.0, step=0.5)
        shots.append([scene.Take(), scene.Take()])
    for put, whole in zip(*shots, strict=True):
        off = np.abs(put.image.astype(int) - whole.image).max(axis=-1)
        # Shadows on the figures themselves, and the edges of all shadows.
        assert np.mean(off > 40) < 0.01
        assert np.mean(put.floor != whole.floor) < 0.002
    (first, second), _ = shots
    assert np.any(first.image != second.image)


class WholeScene(FilmScene):
    """Draws all anew for each picture, as for a camera that moves."""

    def _DrawStill(self):
        return None


@pytest.mark.slow
def test_a_picture_does_not_depend_on_those_before(run):
    trial = LoadRecordedTrial(run)
    one, other = (
        FilmScene(trial, "perspective", SIZE, start=0.0, step=0.04)
        for _ in range(2)
    )
    for number in range(12):
        last = one.Take(number)
    np.testing.assert_array_equal(other.Take(11).image, last.image)


@pytest.mark.slow
def test_a_gif_is_small_by_default(run, tmp_path):
    path = mut.RenderFilm(run, tmp_path / "film.gif")
    with Image.open(path) as film:
        assert film.size == (736, 414)
        assert 1000 / film.info["duration"] == pytest.approx(15.0, rel=0.1)
        assert film.n_frames == 43
    # A film of 22 s may have 6 MB.
    assert path.stat().st_size < 6e6 * 3.0 / 22.0


@pytest.mark.slow
def test_a_failed_film_leaves_neither_file_nor_process(run, tmp_path):
    def stop(done, total):
        raise KeyboardInterrupt

    before = {it.pid for it in multiprocessing.active_children()}
    with pytest.raises(KeyboardInterrupt):
        mut.RenderFilm(
            *(run, tmp_path / "film.gif", config(view="plot")),
            progress=stop,
            workers=2,
        )
    assert not list(tmp_path.iterdir())
    assert {it.pid for it in multiprocessing.active_children()} <= before


@pytest.mark.parametrize("view", ["perspective", "top"])
def test_odd_sizes_and_a_robot_alone_beside_the_middle(tmp_path, view):
    scenario = LoadScenario(
        data="""
world: {walls: [{type: box, center: [0, 3], size: [10, 0.2]},
                {type: box, center: [0, -3], size: [10, 0.2]}]}
robot: {start: [3.5, -1.5, 3.14159], goal: [-3.5, 1.5, 3.14159]}
simulation: {duration: 2.0}
"""
    )
    folder = WriteResult(
        RunTrial(scenario),
        tmp_path,
        add=lambda folder: SaveScenario(scenario, folder / "scenario.yaml"),
    )
    options = mut.FilmConfig(view=view, size=(301, 201), fps=2.0)
    film = mut.RenderFilm(folder, tmp_path / "film.gif", options)
    with Image.open(film) as gif:
        assert gif.size == (301, 201)


def test_others_keep_their_shadows_where_somebody_is_absent(run):
    """In single pictures as in films."""
    trial = LoadRecordedTrial(run)
    humans = trial.recording.humans.copy()
    humans[:, 0] = np.nan
    partly = dataclasses.replace(
        trial, recording=dataclasses.replace(trial.recording, humans=humans)
    )
    dark = []
    for shadows in (True, False):
        options = {"start": 1.0, "step": 0.1, "shadows": shadows}
        scene = FilmScene(partly, "top", SIZE, single=True, **options)
        dark.append(scene.Take().image.astype(int).sum(axis=-1))
    cast = dark[0] < dark[1] - 60
    assert cast.sum() > 100
