import copy
import math
import pickle

from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp
import numpy as np
import pytest

from hunav_drake.systems.evaluation import recording_file
from hunav_drake.systems.evaluation.recording import Recording
from hunav_drake.systems.world.obstacles import Obstacles


def constant_recording(samples=3, n=2, **kwargs) -> Recording:
    settings = {
        "times": np.arange(samples) * 0.1,
        "robot": np.ones((samples, 7)),
        "humans": np.full((samples, n, 7), 2.0),
    }
    return Recording(**(settings | kwargs))


def full_recording() -> Recording:
    humans = np.random.default_rng(0).normal(size=(3, 2, 7)) ** 2
    humans[1, 0] = np.nan
    return constant_recording(
        humans=humans,
        behavior_status=[[0, 1], [2, 0], [1, 1]],
        human_names=("Ana", "Bo Ø"),
        human_ids=(7, 3),
        behaviors=("regular", "scared"),
        group_ids=(1, 1),
        goal=(1.0, 2.0, 3.0),
        goal_tolerance=0.3,
        goal_yaw_tolerance=0.4,
        obstacles=Obstacles.from_shapes(
            [[[0, 0], [1, 0], [1, 1]], [[5, 5]]], solid=[True, False]
        ),
        nearest_walls=np.full((3, 3, 1, 2), 0.5),
        doors=[[1.5, -2.0]],
    )


def test_people_have_defaults():
    dut = constant_recording()
    assert dut.human_names == ("human_1", "human_2")
    assert dut.human_ids == (1, 2)
    assert dut.behaviors == ("regular", "regular")
    assert dut.group_ids == (-1, -1)
    assert dut.behavior_status.tolist() == [[0, 0]] * 3
    assert dut.goal is None


def test_it_may_be_of_nobody_and_of_one_instant():
    dut = constant_recording(samples=1, n=0)
    assert len(dut) == 1
    assert dut.num_humans == 0


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"times": [0.0, 0.1]}, r"robot: must have the shape \(2, 7\)"),
        ({"times": []}, "times: needs at least one sample"),
        ({"times": [0.0, 0.1, 0.1]}, "sample 2 at 0.1 s follows sample 1"),
        ({"times": [0.0, 0.2, 0.1]}, "times: must increase strictly"),
        ({"times": [0.0, np.nan, 1.0]}, "times: must be finite"),
        ({"times": "now"}, "times: is not an array"),
        ({"robot": np.ones((3, 6))}, r"robot: must have the shape \(3, 7\)"),
        ({"robot": np.full((3, 7), np.inf)}, r"robot: .* 0: x must be finite"),
        ({"robot": np.full((3, 7), 2e10)}, r"x must be finite, in \[-1e\+10, "),
        ({"times": [0.0, 0.1, 1e300]}, "times: must be finite, and at most"),
        ({"times": [0.0, 1e-300, 1.0]}, "sample 1 at 1e-300 s follows"),
        ({"times": [0.0, 0.1j, 1.0]}, "times: is not an array"),
        ({"behavior_status": [[0, np.nan]] * 3}, "status: must be finite, who"),
        ({"behavior_status": [[0, 0.5]] * 3}, "status: must be finite, whole"),
        ({"human_ids": (1, 1.5)}, "human_ids: must be finite, whole.*got 1.5"),
        ({"human_ids": (1, 2j)}, "human_ids: is not an array.*complex"),
        ({"human_ids": (1, 10**30)}, "human_ids: must be finite, whole"),
        ({"human_ids": ("a", "b")}, "human_ids: is not an array"),
        ({"human_ids": ([1], [2])}, r"human_ids: must have the shape \(2\)"),
        ({"group_ids": 3}, "group_ids: is not a list"),
        ({"group_ids": (1, math.inf)}, "group_ids: must be finite, whole"),
        ({"goal": (1j, 2.0, 3.0)}, "goal: is not an array.*complex"),
        ({"goal_tolerance": [1.0, 2.0]}, "goal_tolerance: must have the"),
        ({"goal_tolerance": 1j}, "goal_tolerance: is not an array"),
        ({"goal_yaw_tolerance": math.inf}, "goal_yaw_tolerance: must be"),
        (
            {"nearest_walls": np.full((3, 3, 1, 2), np.inf)},
            "nearest_walls: must be finite",
        ),
        ({"reference_path": np.full((1, 3), 1e11)}, "path: must be finite"),
        ({"robot": -np.ones((3, 7))}, r"radius must be finite, in \[0, 1e"),
        ({"humans": np.ones((3, 14))}, r"must have the shape \(3, any, 7\)"),
        ({"behavior_status": [[0, 0]]}, "behavior_status: must have"),
        ({"human_names": ("a",)}, "human_names: needs one for each of 2"),
        ({"human_ids": (1, 1)}, r"human_ids: must differ, got \(1, 1\)"),
        ({"behaviors": ("a", "b", "c")}, "behaviors: needs one for each"),
        ({"goal": (1.0, 2.0)}, r"goal: must have the shape \(3\)"),
        ({"goal": (1.0, 2.0, np.nan)}, "goal: must be finite"),
        ({"goal_tolerance": 0.0}, "goal_tolerance: must be positive"),
        ({"goal_yaw_tolerance": np.nan}, "goal_yaw_tolerance: must be"),
        ({"nearest_walls": np.ones((3, 2, 1, 2))}, "nearest_walls: must have"),
        ({"end_time": np.nan}, "end_time: must be finite.* got nan"),
        ({"end_time": [1.0]}, "end_time: must have the shape"),
    ],
)
def test_what_cannot_be_is_an_error(kwargs, message):
    with pytest.raises(ValueError, match=message):
        constant_recording(**kwargs)


@pytest.mark.parametrize("kind", [int, float, np.float32, np.float64])
def test_the_end_of_a_robot_is_kept_whatever_its_type(kind, tmp_path):
    dut = constant_recording(robot_name="a", end_time=kind(2))
    dut.save(tmp_path / "a.npz")
    assert Recording.load(tmp_path / "a.npz") == dut


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_person_cannot_be_missing_in_part(value):
    humans = np.ones((3, 2, 7))
    humans[2, 1, 4] = value
    with pytest.raises(ValueError, match="person 1 at sample 2"):
        constant_recording(humans=humans)


def test_it_does_not_change_with_what_it_was_made_of():
    times = np.arange(3.0)
    dut = constant_recording(times=times)
    times[0] = -5
    assert dut.times[0] == 0


def test_nothing_in_it_can_be_written():
    dut = full_recording()
    for name in ("times", "robot", "humans", "behavior_status"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(dut, name)[0] = 1


@pytest.mark.parametrize("make", [constant_recording, full_recording])
def test_it_survives_a_file(tmp_path, make):
    dut = make()
    dut.save(tmp_path / "a.npz")
    assert Recording.load(tmp_path / "a.npz") == dut
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_the_file_of_equal_recordings_is_equal(tmp_path):
    full_recording().save(tmp_path / "a.npz")
    full_recording().save(tmp_path / "b.npz")
    a, b = (tmp_path / name for name in ("a.npz", "b.npz"))
    assert a.read_bytes() == b.read_bytes()


@settings(max_examples=20)
@given(
    hnp.arrays(
        float,
        st.tuples(st.integers(1, 4), st.integers(0, 3), st.just(7)),
        elements=st.floats(0, 1e6),
    )
)
def test_any_states_survive_a_file(tmp_path_factory, humans):
    dut = constant_recording(samples=len(humans), humans=humans)
    path = tmp_path_factory.mktemp("any") / "a.npz"
    dut.save(path)
    assert Recording.load(path) == dut


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    constant_recording().save(path)

    def fail(*args, **kwargs):
        raise OSError("no space left")

    monkeypatch.setattr(recording_file.np, "savez", fail)
    with pytest.raises(OSError, match="no space left"):
        full_recording().save(path)
    assert Recording.load(path) == constant_recording()
    assert [p.name for p in tmp_path.iterdir()] == ["a.npz"]


def test_a_file_of_something_else_is_an_error(tmp_path):
    path = tmp_path / "a.npz"
    for content in (b"", b"PK\x03\x04", b"times\n1\n", bytes(999)):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"a\.npz"):
            Recording.load(path)
    np.savez(path, times=[1.0])
    with pytest.raises(ValueError, match=r"a\.npz.*expected the format"):
        Recording.load(path)
    np.savez(path, times=np.array([{}], dtype=object))
    with pytest.raises(ValueError, match=r"a\.npz"):
        Recording.load(path)
    with pytest.raises(FileNotFoundError):
        Recording.load(tmp_path / "b.npz")


def test_a_cut_file_is_an_error(tmp_path):
    full_recording().save(tmp_path / "a.npz")
    whole = (tmp_path / "a.npz").read_bytes()
    for cut in range(1, len(whole), 97):
        (tmp_path / "b.npz").write_bytes(whole[:cut])
        with pytest.raises(ValueError, match=r"b\.npz"):
            Recording.load(tmp_path / "b.npz")


def test_a_changed_byte_is_an_error_or_does_not_matter(tmp_path):
    full_recording().save(tmp_path / "a.npz")
    whole = (tmp_path / "a.npz").read_bytes()
    path = tmp_path / "b.npz"
    errors = 0
    for place in range(1, len(whole), 61):
        changed = bytearray(whole)
        changed[place] ^= 0x55
        path.write_bytes(changed)
        try:
            assert Recording.load(path) == full_recording()
        except ValueError:
            errors += 1
    assert errors > 10


@pytest.mark.parametrize(
    ("name", "array"),
    [
        ("goal_tolerance", np.array([0.2, 0.3])),
        ("goal_tolerance", np.array(0.2 + 1j)),
        ("goal_yaw_tolerance", np.array("wide")),
        ("goal", np.array(1.0)),
        ("goal", np.array([1j, 2, 3])),
        ("human_names", np.array("Ana")),
        ("human_names", np.array([["Ana"], ["Bo"]])),
        ("human_names", np.array([1, 2])),
        ("human_ids", np.array(3)),
        ("human_ids", np.array([1j, 2])),
        ("human_ids", np.array([[1], [2]])),
        ("group_ids", np.array([1.5, 2])),
        ("times", np.array(0.0)),
        ("times", np.array(["a", "b", "c"])),
        ("robot", np.ones((3, 7), dtype=complex)),
        ("behavior_status", np.zeros((3, 2), dtype="M8[s]")),
        ("walls_known", np.array([True, False])),
        ("walls_known", np.array(2.5)),
        ("obstacles.segments", np.zeros(4)),
        ("obstacles.segments", np.zeros((4, 3))),
        ("obstacles.segments", np.full((4, 4), np.inf)),
        ("obstacles.first", np.array([0, 3, 10**9])),
        ("obstacles.first", np.array([0, 3, 3, 4])),
        ("obstacles.first", np.array([-1, 3, 4])),
        ("obstacles.first", np.array([0, 4], dtype=np.uint8)),
        ("obstacles.first", np.array([], dtype=int)),
        ("obstacles.solid", np.array([1.0, 0.0])),
    ],
)
def test_an_array_of_another_kind_is_named(tmp_path, name, array):
    path = tmp_path / "a.npz"
    full_recording().save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    np.savez(path, **(arrays | {name: array}))
    with pytest.raises(ValueError, match=rf"a\.npz: is damaged: {name}"):
        Recording.load(path)


def test_a_missing_array_is_named(tmp_path):
    path = tmp_path / "a.npz"
    full_recording().save(path)
    with np.load(path) as archive:
        arrays = dict(archive)
    del arrays["human_ids"]
    np.savez(path, **arrays)
    with pytest.raises(ValueError, match=r"a\.npz.*it has no human_ids"):
        Recording.load(path)


def test_recordings_are_equal_by_content():
    assert full_recording() == full_recording()
    assert constant_recording() != full_recording()
    assert constant_recording(goal=(1, 2, 3)) != constant_recording()
    assert constant_recording() != "a recording"
    assert constant_recording(
        obstacles=Obstacles.from_points([[1, 2]])
    ) != constant_recording(obstacles=Obstacles.from_points([[1, 3]]))


def test_copies_share_it_and_pickle_leaves_the_derived_behind():
    dut = full_recording()
    assert copy.deepcopy(dut) is dut
    assert copy.copy(dut) is dut
    small = len(pickle.dumps(dut))
    assert dut.features is dut.features
    assert dut.features.gaps.shape == (3, 2)
    assert len(pickle.dumps(dut)) == small
    assert pickle.loads(pickle.dumps(dut)) == dut


def test_only_keeps_the_people_of_one_behavior():
    dut = full_recording().only("scared")
    assert dut.human_names == ("Bo Ø",)
    assert dut.human_ids == (3,)
    assert dut.behavior_status.tolist() == [[1], [0], [1]]
    assert np.array_equal(dut.humans, full_recording().humans[:, 1:])
    assert dut.nearest_walls.shape == (3, 2, 1, 2)
    assert dut.goal == full_recording().goal


def test_only_names_the_nearest_behavior():
    with pytest.raises(ValueError, match="did you mean 'scared'"):
        full_recording().only("scare")


def test_it_is_short_in_messages():
    assert repr(constant_recording()) == (
        "<Recording of 3 samples from 0 s to 0.2 s, with 2 people>"
    )


def test_whether_walls_are_known_is_kept(tmp_path):
    dut = Recording(
        times=[0.0],
        robot=np.zeros((1, 7)),
        humans=np.zeros((1, 1, 7)),
        behaviors=("a",),
        walls_known=False,
    )
    path = tmp_path / "a.npz"
    dut.save(path)
    assert Recording.load(path).walls_known is False
    assert dut.only("a").walls_known is False
    # Files of before have no such entry; they are of trials.
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files}
    del arrays["walls_known"]
    np.savez(path, **arrays)
    assert Recording.load(path).walls_known is True


def test_until_and_since_count_from_any_time():
    """Also where the clock of the recording begins before 0."""
    run = constant_recording(4, times=[-2.0, -1.0, 0.0, 1.0])
    for k, time in enumerate(run.times):
        assert len(run.until(time)) == k + 1
        assert len(run.since(time)) == len(run) - k
    assert len(run.until(np.inf)) == len(run.since(-np.inf)) == len(run)
    for part in (run.until, run.since):
        with pytest.raises(ValueError, match="nan"):
            part(np.nan)
