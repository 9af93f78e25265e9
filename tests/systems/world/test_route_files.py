import numpy as np
import pytest

from hunav_drake.systems.world import route_files, routes
from hunav_drake.systems.world.obstacles import Obstacles

BUILT = (np.arange(6.0).reshape(3, 2), np.array([[1.0, 0.0, 2.5]]))


class Builder:
    def __init__(self):
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return BUILT


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(route_files.VARIABLE, str(tmp_path))
    return tmp_path / "routes"


def same(result):
    return all(map(np.array_equal, result, BUILT))


def test_what_is_on_disk_is_not_built_again(folder):
    build = Builder()
    assert same(route_files.kept("one", build))
    assert same(route_files.kept("one", build))
    assert build.calls == 1
    assert same(route_files.kept("another", build))
    assert build.calls == 2
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: b"something else",
        lambda content: content[: len(content) // 2],
        lambda content: content[:200] + b"\0\1\2\3" + content[204:],
    ],
)
def test_a_damaged_file_is_replaced(folder, damage):
    build = Builder()
    route_files.kept("one", build)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    assert same(route_files.kept("one", build))
    assert build.calls == 2
    assert same(route_files.kept("one", build))
    assert build.calls == 2


def test_a_file_that_does_not_fit_is_replaced(folder):
    build = Builder()
    route_files.kept("one", build)
    (path,) = folder.iterdir()
    np.savez(path, vertices=BUILT[0], ways=np.array([[0.0, 7.0, 1.0]]))
    assert same(route_files.kept("one", build))
    assert build.calls == 2


def test_it_can_be_switched_off(monkeypatch, tmp_path):
    monkeypatch.setenv(route_files.VARIABLE, "")
    monkeypatch.chdir(tmp_path)
    build = Builder()
    assert same(route_files.kept("one", build))
    assert same(route_files.kept("one", build))
    assert build.calls == 2
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_is_no_error(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(route_files.VARIABLE, str(tmp_path / "file"))
    assert same(route_files.kept("one", Builder()))


def boxes(count):
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    places = [(3.0 * (i % 12), 3.0 * (i // 12)) for i in range(count)]
    return Obstacles.from_shapes(
        [corners + place for place in places], solid=[True] * count
    )


def test_only_large_worlds_are_kept_and_come_back_the_same(folder):
    routes.RouteMap.from_obstacles(boxes(9))
    assert not folder.exists()
    world = boxes(routes.KEPT_FROM // 4)
    first = routes.RouteMap.from_obstacles(world)
    assert len(list(folder.iterdir())) == 1
    assert routes.RouteMap.from_obstacles(boxes(len(world))) is first
    # As in another process.
    routes._route_map.cache_clear()
    second = routes.RouteMap.from_obstacles(world)
    assert second is not first
    np.testing.assert_array_equal(first.vertices, second.vertices)
    np.testing.assert_array_equal(first.ways, second.ways)
    routes._route_map.cache_clear()
    other = routes.RouteMap.from_obstacles(world, clearance=0.2)
    assert not np.array_equal(other.vertices, first.vertices)
    assert len(list(folder.iterdir())) == 2
