"""Frames are published to Meshcat for viewers and recordings."""

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial
import pytest

from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.scene import AddScene
from hunav_drake.systems.world.shapes import World


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(host="localhost"))


def walk(meshcat):
    """A simulator of a person who walks along x at 1 m/s, and the scene."""
    builder = DiagramBuilder()
    ana = HumanConfig(name="ana", pose=(0.0, 0.0, 0.0))
    ports = AddScene(builder, World(), [ana], meshcat=meshcat)
    ends = np.array([[t, 0, 0, 1, 0, 0, 0.3] for t in (0.0, 20.0)]).T
    source = builder.AddSystem(
        TrajectorySource(PiecewisePolynomial.FirstOrderHold([0.0, 20.0], ends))
    )
    builder.Connect(source.get_output_port(), ports.human_states)
    return Simulator(builder.Build()), ports


def shown(meshcat):
    """Where along x Meshcat shows her."""
    packed = meshcat._GetPackedTransform("/drake/visualizer/ana/base")
    # The matrix is the last in the message: 16 numbers, column by column.
    numbers = np.frombuffer(packed[-16 * 9 :], dtype=np.uint8).reshape(16, 9)
    values = numbers[:, 1:].copy().view(">f8").ravel()
    return values[12]


def test_who_looks_sees_every_frame(meshcat, monkeypatch):
    monkeypatch.setattr(Meshcat, "GetNumActiveConnections", lambda _: 1)
    simulator, _ = walk(meshcat)
    for time in (0.5, 1.2, 2.0):
        simulator.AdvanceTo(time)
        assert shown(meshcat) == pytest.approx(time, abs=0.11)


def test_while_nobody_looks_few_frames_are_published(meshcat):
    simulator, _ = walk(meshcat)
    places = set()
    for time in np.arange(0.0, 10.0, 0.1):
        simulator.AdvanceTo(time)
        places.add(shown(meshcat))
    assert 0.0 in places
    assert 1 < len(places) <= 3


def test_who_comes_late_sees_the_present_from_the_next_frame_on(
    meshcat, monkeypatch
):
    simulator, _ = walk(meshcat)
    simulator.AdvanceTo(5.0)
    assert shown(meshcat) == 0.0
    monkeypatch.setattr(Meshcat, "GetNumActiveConnections", lambda _: 1)
    simulator.AdvanceTo(5.2)
    assert shown(meshcat) == pytest.approx(5.2, abs=0.11)


def test_a_forced_frame_is_published(meshcat):
    simulator, _ = walk(meshcat)
    simulator.AdvanceTo(3.0)
    simulator.get_system().ForcedPublish(simulator.get_context())
    assert shown(meshcat) == pytest.approx(3.0)


def test_a_recording_has_all_frames_though_nobody_looks(meshcat):
    simulator, ports = walk(meshcat)
    dut = ports.visualizer
    dut.StartRecording(set_transforms_while_recording=True)
    for time in (0.5, 1.2, 2.0):
        simulator.AdvanceTo(time)
        assert shown(meshcat) == pytest.approx(time, abs=0.11)
    dut.StopRecording()
    simulator.AdvanceTo(4.0)
    assert shown(meshcat) < 2.1
    dut.DeleteRecording()


def test_nothing_of_a_trial_depends_on_what_is_published(meshcat):
    states = []
    for seen in (None, meshcat):
        simulator, _ = walk(seen)
        simulator.AdvanceTo(2.0)
        context = simulator.get_context()
        states.append(context.get_discrete_state_vector().CopyToVector())
    np.testing.assert_array_equal(*states)
