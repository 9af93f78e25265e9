"""`hunav import` of worlds of Gazebo, and what one sees of them."""

from pydrake.geometry import Role
from pydrake.systems.framework import DiagramBuilder
import pytest

from hunav_drake import LoadScenario
from hunav_drake.commands import cli
from hunav_drake.scenario.gazebo_import import import_world
from hunav_drake.systems.scene.scene import AddScene
from hunav_drake.systems.world.shapes import Model, World
from tests.agents import AGENTS
from tests.systems.common.models.gazebo_files import (
    block,
    mesh,
    model,
    stl,
    world,
)


def actor(rows, loop="true", name="ann"):
    """An actor whose script has rows (time, x, y)."""
    ways = "".join(
        f"<waypoint><time>{t}</time><pose>{x} {y} 0 0 0 0</pose></waypoint>"
        for t, x, y in rows
    )
    return (
        f'<actor name="{name}"><skin><filename>a.dae</filename></skin><script>'
        f'<loop>{loop}</loop><trajectory id="0">{ways}</trajectory></script>'
        "</actor>"
    )


@pytest.fixture(autouse=True)
def cache(monkeypatch, tmp_path):
    monkeypatch.setenv("HUNAV_CACHE", str(tmp_path / "cache"))


def test_an_actor_is_a_person_with_goals_and_its_mean_speed(tmp_path):
    # It walks 4 m in 4 s, waits for 2 s, and walks 5 m in 5 s.
    rows = [(0, 0, 0), (4, 4, 0), (6, 4, 0), (11, 4, 5)]
    stands = '<actor name="ann"><pose>7 8 0 0 0 1</pose></actor>'
    path = tmp_path / "a.world"
    path.write_text(world(actor(rows) + stands + '<light name="l"/>'))
    notes: list[str] = []
    one, other = import_world(path, notes=notes).humans
    assert (one.name, one.pose, one.cyclic) == ("ann", (0, 0, 0), True)
    assert one.goals == [(4, 0), (4, 5), (0, 0)]
    assert one.desired_speed == pytest.approx(1.0)
    assert (other.name, other.pose) == ("ann_2", (7, 8, 1))
    assert other.goals == []
    assert notes == ["1 <light>: has no meaning here"]
    path.write_text(world(actor(rows, loop="false")))
    (once,) = import_world(path).humans
    assert once.goals == [(4, 0), (4, 5)]
    assert once.cyclic is None


def test_slow_walks_count_and_trajectories_follow_each_other(tmp_path):
    path = tmp_path / "a.world"
    rows = [(i / 10, 0.04 * i, 0) for i in range(51)]
    path.write_text(world(actor(rows, loop=" False ")))
    (person,) = import_world(path).humans
    assert person.desired_speed == pytest.approx(0.4)
    assert person.cyclic is None
    second = (
        '</trajectory><trajectory id="1"><waypoint><time>3</time><pose>7 0 0 0'
        " 0 0</pose></waypoint></trajectory>"
    )
    text = actor([(0, 0, 0), (2, 2, 0)]).replace("</trajectory>", second)
    path.write_text(world(text))
    (person,) = import_world(path).humans
    assert person.desired_speed == pytest.approx(1.4)


def test_people_of_one_name_get_numbers_that_are_free(tmp_path):
    path = tmp_path / "a.world"
    names = ("p", "p_2", "p", "p" * 70, "p" * 70)
    path.write_text(world("".join(actor([(0, 0, 0)], name=it) for it in names)))
    found = [it.name for it in import_world(path).humans]
    assert found == ["p", "p_2", "p_3", "p" * 64, "p" * 58 + "_2"]


def test_the_command_writes_a_scenario_that_names_the_world(
    tmp_path, monkeypatch, capsys
):
    (tmp_path / "w").mkdir()
    hall = world(model(more="<pose>9 9 0 0 0 0</pose>") + actor([(0, 1, 1)]))
    (tmp_path / "w" / "hall.world").write_text(hall)
    (tmp_path / "agents.yaml").write_text(AGENTS)
    monkeypatch.chdir(tmp_path)
    way = [
        "--model-path",
        "w",
        "--start",
        "0",
        "5",
        "0",
        "--goal",
        "4",
        "5",
        "0",
    ]
    assert cli.main(["import", "w/hall.world", "-o", "my.yaml", *way]) == 0
    scenario = LoadScenario(filename="my.yaml")
    (found,) = scenario.world.models
    assert found.file == str(tmp_path / "w" / "hall.world")
    assert found.model_path == [str(tmp_path / "w")]
    assert [it.name for it in scenario.humans] == ["ann"]
    words = ["import", "agents.yaml", "--world", "w/hall.world", "-o", "b.yaml"]
    assert cli.main([*words, *way]) == 0
    assert (
        "1 actors of hall.world: those of agents.yaml"
        in capsys.readouterr().err
    )
    both = LoadScenario(filename="b.yaml")
    assert both.world == scenario.world
    assert "ann" not in [it.name for it in both.humans]
    assert cli.main(["import", "w/none.world", "-o", "c.yaml"]) == 2
    told = capsys.readouterr().err
    assert "there is no file" in told
    assert told.endswith("; check the path\n")
    assert cli.main(["import", "w/hall.world", "--metrics", "m.yaml"]) == 2


def test_viewers_see_high_things_cut_and_cameras_whole(tmp_path):
    (tmp_path / "wall.stl").write_text(stl(block((0, 0, 0), (4, 0.2, 3))))
    (tmp_path / "roof.stl").write_text(stl(block((0, 0, 3), (4, 4, 3.1))))
    wall, roof = model(mesh("wall.stl")), model(mesh("roof.stl"), "roof")
    path = tmp_path / "a.world"
    path.write_text(world(wall + roof + model(name="box")))
    builder = DiagramBuilder()
    ports = AddScene(builder, World(models=[Model(file=str(path))]))
    inspector = ports.scene_graph.model_inspector()

    def seen(role):
        found = {
            inspector.GetName(it): inspector.GetShape(it)
            for it in inspector.GetAllGeometryIds(role)
        }
        return {
            name.rpartition("::")[2].removeprefix("models_0_"): it
            for name, it in found.items()
            if "models_0" in name
        }

    shown, perceived = seen(Role.kIllustration), seen(Role.kPerception)
    assert set(shown) == {"0", "2"}
    assert set(perceived) == {"0_whole", "1_whole", "2"}
    for it, height in ((shown["0"], 1.1), (perceived["0_whole"], 3.0)):
        hull = it.GetConvexHull()
        z = [hull.vertex(i)[2] for i in range(hull.num_vertices())]
        assert max(z) == pytest.approx(height, abs=1e-4)
