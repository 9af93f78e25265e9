"""What docs/worlds.md says is what there is."""

from pathlib import Path
import re

from PIL import Image
import pytest

from hunav_drake import LoadScenario
from hunav_drake.systems.world.furniture import FURNITURE
from hunav_drake.systems.world.shapes import WALLS, World

DOCS = Path(__file__).resolve().parents[1] / "docs"
TEXT = (DOCS / "worlds.md").read_text()


def own(registry):
    """The choices of the package, whatever other tests have registered."""
    return {
        name: it
        for name, it in registry.items()
        if it.__module__.startswith("hunav_drake.")
    }


def test_all_kinds_of_furniture_are_told_with_their_sizes():
    rows = re.findall(
        r"^\| `(\w+)` \| (\S+) x (\S+) \| (\S+) \|(.*?)\|",
        TEXT.split("## Shipped worlds")[0],
        re.M,
    )
    kinds = own(FURNITURE)
    assert [row[0] for row in rows] == sorted(kinds)
    for kind, x, y, height, hides in rows:
        thing = kinds[kind](center=(0.0, 0.0))
        assert thing.size == (float(x), float(y))
        assert thing.height == float(height)
        if kind != "pallet":
            sight = World(furniture=[thing]).sight_obstacles()
            assert bool(len(sight)) == bool(hides.strip())
    shapes = re.findall(r"^\| `(\w+)` \| `\w+`[ ,]", TEXT, re.M)
    assert set(shapes) == set(own(WALLS))


def test_a_loaded_pallet_hides_from_the_height_that_is_told():
    (least,) = re.findall(r"with a load from (\S+) on", TEXT)
    pallet = own(FURNITURE)["pallet"]
    for load, hides in ((float(least), True), (float(least) - 0.01, False)):
        world = World(furniture=[pallet(center=(0.0, 0.0), load=load)])
        assert bool(len(world.sight_obstacles())) == hides


@pytest.mark.slow
def test_shipped_worlds_are_as_large_and_full_as_told():
    rows = re.findall(r"^\| `(\w+)` \| (\S+) x (\S+) \| (\d+) \|", TEXT, re.M)
    assert len(rows) == 12
    for name, x, y, people in rows:
        scenario = LoadScenario(filename=name)
        assert len(scenario.humans) == int(people)
        walls = {it.name: it.vertices() for it in scenario.world.walls}
        width = walls["east"][:, 0].min() - walls["west"][:, 0].max()
        depth = walls["north"][:, 1].min() - walls["south"][:, 1].max()
        assert (width, depth) == pytest.approx((float(x), float(y)))


def test_pictures_are_there_and_small():
    pictures = re.findall(r"!\[.*\]\((.*)\)", TEXT)
    assert len(pictures) == 8
    for picture in pictures:
        path = DOCS / picture
        assert path.stat().st_size <= 150_000
        with Image.open(path) as image:
            assert image.width >= 1000
