from abc import ABC, abstractmethod
import dataclasses
import json
import subprocess
import sys
from typing import Annotated

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass
import pytest

from hunav_drake.systems.common.registry import Registry, name_of
from hunav_drake.systems.crowd.motion_model import MOTION_MODELS
from hunav_drake.systems.planning.planner import PLANNERS


class Brush(ABC):
    @abstractmethod
    def paint(self): ...


@pytest.fixture
def dut():
    return Registry("brush", Brush, default="broad")


def make_choice(result=2.0):
    @dataclass
    class Broad(Brush):
        gain: Annotated[float, Field(gt=0)] = 2.0

        def paint(self):
            return result

    return Broad


@dataclass(kw_only=True)
class Needy(Brush):
    gain: float

    def paint(self): ...


@pytest.mark.parametrize(
    "data",
    [
        "broad",
        {"type": "broad"},
        {"type": "broad", "gain": 2.0},
        {"gain": 2},
        {},
        None,
    ],
)
def test_data_stand_for_a_choice(dut, data):
    broad = dut.register("broad")(make_choice())
    assert dut["broad"] is broad
    assert list(dut) == ["broad"]
    made = dut.make(data)
    assert made == broad()
    assert name_of(made) == "broad"
    assert dut.make(made) is made


def test_a_cell_may_be_run_again(dut):
    old = dut.register("broad")(make_choice())
    dut.register("broad")(make_choice(result=7.0))
    assert dut.make("broad").paint() == 7.0
    # Choices made before still have their name.
    assert name_of(old()) == "broad"


def test_another_choice_cannot_take_its_name(dut):
    dut.register("broad")(make_choice())
    with pytest.raises(
        ValueError, match=r"'broad' is registered already, from"
    ):
        dut.register("broad")(Needy)


def test_a_class_has_one_name(dut):
    broad = dut.register("broad")(make_choice())
    with pytest.raises(ValueError, match=r"is registered already, as 'broad'"):
        dut.register("wide")(broad)


def test_a_class_derived_from_a_choice_is_another_one(dut):
    broad = dut.register("broad")(make_choice())
    derived = dataclass(type("Derived", (broad,), {}))
    with pytest.raises(ValueError, match=r"Derived is not registered"):
        dut.make(derived())
    dut.register("derived")(derived)
    assert name_of(dut.make("derived")) == "derived"
    assert name_of(dut.make("broad")) == "broad"


def test_what_is_no_choice_is_refused(dut):
    with pytest.raises(TypeError, match=r"Half is no brush: it lacks paint"):
        dut.register("broad")(dataclass(type("Half", (Brush,), {})))
    with pytest.raises(TypeError, match=r"must derive from Brush"):
        dut.register("broad")(dataclasses.make_dataclass("Else", []))
    with pytest.raises(TypeError, match=r"a brush is a dataclass, .*got 3"):
        dut.register("broad")(3)

    class Bare(Brush):
        gain: float = 2.0

        def paint(self): ...

    words = "a brush is a dataclass, .* write @dataclass above class .*Bare"
    with pytest.raises(TypeError, match=words):
        dut.register("broad")(Bare)

    @dataclass
    class Tagged(Brush):
        type: str = ""

        def paint(self): ...

    with pytest.raises(TypeError, match="must not have a field 'type'"):
        dut.register("broad")(Tagged)
    assert not dut


@pytest.mark.parametrize("decorate", [dataclass, dataclasses.dataclass])
def test_a_field_that_would_change_nothing_is_refused(dut, decorate):
    class Own(make_choice()):
        flow: float = 1.0

    with pytest.raises(TypeError, match=r"@dataclass above class .*Own"):
        dut.register("own")(Own)
    Other = decorate(type("Other", (make_choice(),), {"gain": 3.0}))
    words = r"Other\.gain changes nothing without a type; write gain: TYPE = 3"
    with pytest.raises(TypeError, match=words):
        dut.register("other")(Other)
    typed = {"gain": 3.0, "__annotations__": {"gain": float}}
    typed = decorate(type("Typed", (make_choice(),), typed))
    assert dut.register("typed")(typed)().gain == 3.0


@pytest.mark.parametrize("data", ["braod", {"type": "braod", "gain": 1}])
def test_an_unknown_name_tells_the_nearest(dut, data):
    dut.register("broad")(make_choice())
    words = r"type\n  there is no brush 'braod'; did you mean 'broad'\?"
    with pytest.raises(ValueError, match=words):
        dut.make(data)


@pytest.mark.parametrize("data", [5, ["broad"], True, object()])
def test_what_is_neither_name_nor_mapping_is_told(dut, data):
    dut.register("broad")(make_choice())
    with pytest.raises(ValueError, match=r"a mapping, or the name of a brush"):
        dut.make(data)


@pytest.mark.parametrize("name", [5, None, ["broad"], {}])
def test_a_name_that_is_no_text_is_told(dut, name):
    dut.register("broad")(make_choice())
    with pytest.raises(ValueError, match=r"must be the name of a brush, got"):
        dut.make({"type": name})


def test_without_a_default_the_tag_must_be_there():
    dut = Registry("brush", Brush)
    dut.register("broad")(make_choice())
    with pytest.raises(ValueError, match=r"type\n  is missing; valid: broad"):
        dut.make({"gain": 3.0})


def test_an_unknown_parameter_is_never_ignored(dut):
    """Also not by a dataclass that would."""
    dut.register("broad")(make_choice())
    with pytest.raises(ValueError, match=r"gian\n  Unexpected keyword"):
        dut.make({"gian": 50.0})


def test_a_value_outside_its_range_is_told_with_its_place(dut):
    dut.register("broad")(make_choice())
    with pytest.raises(ValueError, match=r"gain\n .*greater than 0"):
        dut.make({"type": "broad", "gain": -1})


def test_a_plain_dataclass_is_checked_too(dut):
    @dut.register("plain")
    @dataclasses.dataclass
    class Plain(Brush):
        gain: float = 2.0

        def paint(self): ...

    assert dut.make({"type": "plain", "gain": 3}) == Plain(3)
    with pytest.raises(ValueError, match=r"gain\n .*valid number"):
        dut.make({"type": "plain", "gain": "wide"})
    with pytest.raises(ValueError, match=r"gian\n  Unexpected keyword"):
        dut.make({"type": "plain", "gian": 50.0})


def test_a_parameter_without_a_default_must_be_given(dut):
    dut.register("needy")(Needy)
    with pytest.raises(ValueError, match=r"gain\n .*required"):
        dut.make("needy")


def test_as_a_field_it_takes_what_is_registered_later(dut):
    @dataclass
    class Box:
        brush: Annotated[Brush, dut]

    adapter = TypeAdapter(Box)
    with pytest.raises(ValueError, match=r"brush\.type\n  there is no brush"):
        Box(brush="broad")
    broad = dut.register("broad")(make_choice())
    assert Box(brush="broad").brush == broad()
    made = adapter.validate_python({"brush": {"type": "broad", "gain": 3}})
    assert made.brush.gain == 3.0
    assert '"broad"' in json.dumps(adapter.json_schema())


@pytest.mark.parametrize(
    ("package", "base", "register", "name"),
    [
        ("planning", "Planner", "register_planner", "pursuit"),
        ("crowd", "MotionModel", "register_motion_model", "orca"),
        ("robot", "RobotConfig", "register_robot", "differential_drive"),
    ],
)
def test_nobody_takes_the_name_of_a_choice_of_the_package(
    package, base, register, name
):
    """Also not before that choice is loaded."""
    code = f"""
import dataclasses
from hunav_drake.systems.{package} import {base}, {register}

@dataclasses.dataclass
class Mine({base}):
    def plan(self, task, view, memory): ...
    def forces(self, snapshot): ...
    def advance(self, snapshot, forces): ...
    def MakeSystem(self, task): ...

try:
    {register}({name!r})(Mine)
except ValueError as error:
    assert "is registered already, from hunav_drake" in str(error)
else:
    raise SystemExit("taken")
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("registry", [PLANNERS, MOTION_MODELS])
def test_each_choice_is_loaded_from_its_own_module(registry):
    homes = registry._homes
    assert [it for it in registry if ":" not in it][: len(homes)] == [*homes]
    for name, module in homes.items():
        assert registry[name].__module__ == module


def test_a_choice_is_made_without_loading_the_others():
    code = """
import sys
from hunav_drake.systems.planning.planner import PLANNERS
PLANNERS.make("pursuit")
assert "dwb, external" in repr(PLANNERS)
assert not [it for it in sys.modules if ".planning.dwb" in it]
assert [*PLANNERS][0] == "dwb" and len(PLANNERS) == 10
assert PLANNERS.make({"type": "scl"})
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_the_place_of_a_choice_of_the_package_is_no_foreign_code():
    """Also where scenarios run no code, and before others are loaded."""
    code = """
from hunav_drake.systems.common.choice_loading import registered_only
from hunav_drake.systems.planning.planner import PLANNERS
with registered_only():
    PLANNERS.make("hunav_drake.systems.planning.mppi.mppi:MppiPlanner")
    try:
        PLANNERS.make("antigravity:Planner")
    except ValueError as error:
        assert "code in a module" in str(error)
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("name", ["", None, 5, ["x"]])
def test_a_name_is_a_text(dut, name):
    with pytest.raises(ValueError, match="the name of a brush is a text, got"):
        dut.register(name)
