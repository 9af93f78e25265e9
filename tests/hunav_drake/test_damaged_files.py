"""Forty damaged worlds and robots: `check` and `run` tell the same of each."""

import json

import pytest

from tests.systems.common.models import (
    test_gazebo as worlds,
    test_xacro as robots,
)

pytestmark = pytest.mark.slow

ROBOTS = [*robots.DAMAGED][:11]
cart = robots.cart


def told_by_both(hunav, scenario, folder):
    """Returns what `check` says of a scenario, and `run` as well."""
    file = folder / "scenario.yaml"
    file.write_text(json.dumps(scenario))
    before = {*folder.rglob("*")}
    code, out, told = hunav("check", file)
    assert (code, out) == (2, "")
    run, _, told_by_run = hunav("run", file, "--out", folder / "out")
    assert run == 2
    assert told_by_run.removeprefix("hunav: ") == told
    assert {*folder.rglob("*")} == before
    _, fault, *rest = told.splitlines()
    assert not rest
    assert "Traceback" not in told
    return fault


def test_there_are_forty():
    assert len(worlds.DAMAGED) + len(ROBOTS) >= 40


@pytest.mark.parametrize("name", worlds.DAMAGED)
def test_a_damaged_world(name, hunav, tmp_path, monkeypatch):
    monkeypatch.setenv("HUNAV_CACHE", str(tmp_path.parent / "cache"))
    text, files, _ = worlds.DAMAGED[name]
    for file, content in {"a.world": text, **files}.items():
        path = tmp_path / file
        path.parent.mkdir(parents=True, exist_ok=True)
        data = content if isinstance(content, bytes) else content.encode()
        path.write_bytes(data)
    robot = {"start": [0, 20, 0], "goal": [5, 20, 0]}
    models = [{"file": str(tmp_path / "a.world")}]
    scenario = {"world": {"models": models}, "robot": robot}
    assert "world.models[0].file" in told_by_both(hunav, scenario, tmp_path)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_damaged_robot(name, cart, hunav, tmp_path):
    change, _ = robots.DAMAGED[name]
    cart.write_text(change(cart.read_text()))
    robot = {
        "type": "urdf",
        "file": str(cart),
        "base": "base",
        "drive": "omnidirectional",
        "start": [0, 0, 0],
        "goal": [5, 0, 0],
    }
    fault = told_by_both(hunav, {"robot": robot}, cart.parent)
    assert "robot.file" in fault
