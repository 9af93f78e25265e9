"""A damaged Context file is refused in one clear sentence."""

import numpy as np
import pytest

from hunav_drake import (
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    SaveContext,
)
from tests.hunav_drake.crafted_contexts import is_refused, with_wrong_number

SCENARIO = LoadScenario(filename="reaction_scared")


@pytest.fixture(scope="module")
def diagram():
    return MakeTrialDiagram(SCENARIO)


@pytest.fixture(scope="module")
def whole(diagram, tmp_path_factory):
    """The file of a trial's Context, and a place for damaged ones."""
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(4.0)
    path = tmp_path_factory.mktemp("contexts") / "whole.npz"
    return SaveContext(diagram, simulator.get_context(), path)


@pytest.fixture(scope="module")
def arrays(whole):
    with np.load(whole) as file:
        return dict(file)


def find(arrays, ending):
    """Returns the first entry whose name ends so."""
    return next(name for name in arrays if name.endswith(ending))


def swapped(times):
    times = times.copy()
    times[[3, 4]] = times[[4, 3]]
    return times


def with_value(value, at=0):
    def change(array):
        changed = array.copy()
        changed.flat[at] = value
        return changed

    return change


@pytest.mark.parametrize(
    ("ending", "change", "message"),
    [
        ("time", lambda t: t * np.nan, "the time must be finite, got nan"),
        (
            "time",
            lambda t: t * 1j,
            r"'time' must be float64 of shape \(\), got",
        ),
        (
            "0.0/discrete/0",
            with_value(np.nan),
            r"::trial::humans::crowd: discrete/0: must be finite, but number 0",
        ),
        ("0.0/discrete/0", with_value(np.inf, 2), "but number 2 is inf"),
        ("0.0/discrete/0", lambda x: x[1:], r"must be float64 of shape \(6,\)"),
        ("0.1/discrete/0", with_value(7.0), "the goal index of person 1 must"),
        ("0.1/discrete/0", with_value(np.nan, 1), "must be a number, got NaN"),
        ("abstract/0/times", swapped, "times: must increase strictly"),
        ("abstract/0/times", lambda t: t[:-1], "robot: must be float64 of"),
        ("abstract/0/robot", with_value(np.nan), "robot: .* must be finite"),
        (
            "abstract/0/humans",
            with_value(np.inf),
            "person 0 at sample 0: x must be finite",
        ),
        ("abstract/0/humans", lambda h: h.astype("U9"), "humans: must be floa"),
        ("abstract/0/status", with_value(np.nan), "status: must be finite"),
        ("abstract/0/status", lambda s: s[:, :0], "status: must be float64 of"),
        # Nothing that could not be, but not what was saved.
        ("0.0/discrete/0", with_value(0.5), "its content is not what"),
        ("systems", lambda text: text[()].upper(), "its content is not what"),
    ],
)
def test_the_place_and_the_rule_are_named(
    diagram, arrays, tmp_path, ending, change, message
):
    name = find(arrays, ending)
    path = tmp_path / "c.npz"
    np.savez(path, **arrays | {name: change(arrays[name])})
    with pytest.raises(ValueError, match=rf"c\.npz: is damaged: .*{message}"):
        LoadContext(diagram, path)


@pytest.mark.parametrize("ending", ["times", "time", "0.0/discrete/0"])
def test_what_is_lost_is_named(diagram, arrays, tmp_path, ending):
    lost = find(arrays, ending)
    rest = {name: array for name, array in arrays.items() if name != lost}
    np.savez(tmp_path / "c.npz", **rest)
    with pytest.raises(ValueError, match=r"c.npz: is damaged: .*time|0.0/disc"):
        LoadContext(diagram, tmp_path / "c.npz")


def test_the_file_of_another_version_is_refused(diagram, arrays, tmp_path):
    old = np.array("hunav_drake context 1")
    np.savez(tmp_path / "c.npz", **arrays | {"format": old})
    with pytest.raises(ValueError, match=r"c.npz: .* of this version: .* got"):
        LoadContext(diagram, tmp_path / "c.npz")


def write_damaged(draw, whole, arrays, path):
    """Writes the file with one thing wrong, or perhaps nothing."""
    kind = draw.choice(["change", "drop", "add", "cut", "flip"])
    names = list(arrays)
    name = names[draw.integers(len(names))]
    if kind in ("cut", "flip"):
        data = bytearray(whole.read_bytes())
        at = int(draw.integers(len(data)))
        if kind == "cut":
            del data[at:]
        else:
            data[at] ^= 1 << int(draw.integers(8))
        path.write_bytes(data)
        return
    changed = dict(arrays)
    if kind == "change":
        changed[name] = with_wrong_number(draw, arrays[name])
    elif kind == "drop":
        del changed[name]
    else:
        changed[f"{name}/more"] = arrays[name]
    np.savez(path, **changed)


@pytest.mark.slow
def test_any_damage_is_refused_or_does_no_harm(
    diagram, whole, arrays, tmp_path
):
    draw = np.random.default_rng(8)
    path = tmp_path / "damaged.npz"
    refused = 0
    for _ in range(400):
        write_damaged(draw, whole, arrays, path)
        refused += is_refused(SCENARIO, diagram, path, 1)
    assert refused > 300
