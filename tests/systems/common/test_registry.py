import dataclasses
import subprocess
import sys
from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass
import pytest

from hunav_drake.systems.common.registry import Registry


@pytest.fixture
def dut():
    return Registry("brush", needs=("paint",))


def make_part(gain=2.0):
    @dataclass
    class Broad:
        gain: Annotated[float, Field(gt=0)] = 2.0

        def paint(self):
            return gain

    return Broad


def test_a_part_is_made_by_its_name(dut):
    part = dut.register("broad")(make_part())
    assert dut["broad"] is part
    assert list(dut) == ["broad"]
    assert dut.make("broad", {"gain": 3}).gain == 3.0


def test_a_cell_may_be_run_again(dut):
    dut.register("broad")(make_part())
    dut.register("broad")(make_part(gain=7.0))
    assert dut.make("broad", {}).paint() == 7.0


def test_another_part_cannot_take_its_name(dut):
    @dataclasses.dataclass
    class Other:
        def paint(self): ...

    dut.register("broad")(make_part())
    with pytest.raises(
        ValueError, match=r"'broad' is registered already, from"
    ):
        dut.register("broad")(Other)


def test_a_part_that_lacks_something_is_refused(dut):
    with pytest.raises(TypeError, match=r"Empty is no brush: it lacks paint"):
        dut.register("broad")(dataclasses.dataclass(type("Empty", (), {})))
    with pytest.raises(TypeError, match=r"a brush is a dataclass, .*got 3"):
        dut.register("broad")(3)
    assert not dut


def test_an_unknown_name_tells_the_nearest(dut):
    dut.register("broad")(make_part())
    words = r"no brush 'braod'; did you mean 'broad'\? \(there are: broad\)"
    with pytest.raises(ValueError, match=words):
        dut.make("braod", {})


def test_an_unknown_parameter_is_never_ignored(dut):
    dut.register("broad")(make_part())
    words = r"'broad' has no parameter 'gian'; did you mean 'gain'\?"
    with pytest.raises(ValueError, match=words):
        dut.make("broad", {"gian": 50.0})


def test_a_value_outside_its_range_is_told_in_one_line(dut):
    dut.register("broad")(make_part())
    with pytest.raises(
        ValueError, match=r"brush 'broad': gain: .*got -1"
    ) as info:
        dut.make("broad", {"gain": -1})
    assert "\n" not in str(info.value)


def test_a_plain_dataclass_is_checked_too(dut):
    @dut.register("plain")
    @dataclasses.dataclass
    class Plain:
        gain: float = 2.0

        def paint(self): ...

    assert isinstance(dut.make("plain", {"gain": 3}), Plain)
    with pytest.raises(ValueError, match=r"brush 'plain': gain: .*'wide'"):
        dut.make("plain", {"gain": "wide"})


@pytest.mark.parametrize(
    ("package", "register", "name"),
    [
        ("planning", "register_planner", "pursuit"),
        ("crowd", "register_motion_model", "orca"),
    ],
)
def test_nobody_takes_the_name_of_a_part_of_the_package(
    package, register, name
):
    """Also not before that part is loaded."""
    code = f"""
import dataclasses
from hunav_drake.systems.{package} import {register}

@dataclasses.dataclass
class Mine:
    memory_size = 0
    def plan(self): ...
    def forces(self): ...
    def advance(self): ...

try:
    {register}({name!r})(Mine)
except ValueError as error:
    assert "is registered already, from hunav_drake" in str(error)
else:
    raise SystemExit("taken")
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("name", ["", None, 5, ["x"]])
def test_a_name_is_a_text(dut, name):
    with pytest.raises(ValueError, match="the name of a brush is a text, got"):
        dut.register(name)
    with pytest.raises(ValueError, match="no brush"):
        dut.make(name, {})


def test_a_parameter_without_a_default_must_be_given(dut):
    @dut.register("needy")
    @dataclass
    class Needy:
        gain: float

        def paint(self): ...

    with pytest.raises(ValueError, match=r"brush .needy.: gain: .*required"):
        dut.make("needy", {})
