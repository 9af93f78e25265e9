"""Trials with a robot that is a body of a plant."""

import hashlib
import json

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
import pytest

from hunav_drake import (
    HumanConfig,
    LoadContext,
    LoadScenario,
    MakeTrialDiagram,
    MakeTrialSimulator,
    RunTrial,
    SaveContext,
    Scenario,
    SetTrialSeed,
)
from hunav_drake.scenario import ScenarioError, SimulationConfig, World
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.evaluation import compute_metrics
from hunav_drake.systems.evaluation.recording import Recording
from tests.processes import run_python
from tests.robot_models import ROBOTS as MODELS

PORTS = ("robot_state", "human_states", "contacts", "velocity_command")
STEP = 0.05


def collision_course(model="pmb2", **simulation) -> Scenario:
    """Somebody who runs into the robot, and others around it."""
    return Scenario(
        robot={"type": model, "goal": (6, 0, 0), "start": (0, 0, 0.1)},
        humans=[
            HumanConfig(
                pose=(2.2, 0.05, 3.1), goals=[(-4, 0)], desired_speed=1.3
            ),
            HumanConfig(pose=(3, 1.5, 0), goals=[(3, -6)]),
            HumanConfig(pose=(4, -0.2, 3), desired_speed=0.0),
        ],
        crowd=CrowdConfig(robot_gap=0.0),
        world=World(
            walls=[{"type": "box", "center": [2, 2.2], "size": [9, 0.2]}]
        ),
        simulation=SimulationConfig(duration=6.0, stuck_time=60, **simulation),
    )


def seen(diagram, context, ports=PORTS):
    return np.concatenate(
        [diagram.GetOutputPort(name).Eval(context) for name in ports]
    )


@pytest.fixture(scope="module")
def straight():
    """A trial's diagram, and all that is seen of it at each step."""
    diagram = MakeTrialDiagram(collision_course())
    simulator = Simulator(diagram)
    rows = [seen(diagram, simulator.get_context())]
    for k in range(1, 121):
        simulator.AdvanceTo(k * STEP)
        rows.append(seen(diagram, simulator.get_context()))
    return diagram, np.array(rows)


@pytest.mark.slow
def test_the_plant_is_part_of_the_trial(straight):
    diagram, _ = straight
    plant = diagram.GetSubsystemByName("plant")
    assert isinstance(plant, MultibodyPlant)
    assert diagram.HasSubsystemNamed("scene_graph")
    assert diagram.HasSubsystemNamed("scene")
    kinematic = MakeTrialDiagram(collision_course("differential_drive"))
    assert not kinematic.HasSubsystemNamed("plant")
    assert kinematic.HasSubsystemNamed("contacts")


def test_steps_of_plant_and_people_meet(straight):
    """No event of one is an ulp off those of the other."""
    diagram, _ = straight
    plant = diagram.GetSubsystemByName("plant")
    steps = STEP / plant.time_step()
    assert steps == 4
    k = np.arange(100000)
    assert (k * STEP == (4 * k) * plant.time_step()).all()


def test_there_is_a_contact_to_speak_of(straight):
    _, rows = straight
    contacts = rows[:, 28:52].reshape(-1, 3, 8)
    assert contacts[-1, 0, Contact.BY_PERSON] >= 1
    assert contacts[..., Contact.PEAK_FORCE].max() > 100
    assert np.isfinite(rows).all()


@pytest.mark.slow
def test_clones_go_on_as_the_whole_from_any_instant(straight):
    diagram, expected = straight
    rng = np.random.default_rng(3)
    simulator = Simulator(diagram)
    for time in np.sort(rng.uniform(0, 5.3, 20)):
        simulator.AdvanceTo(time)
        clone = Simulator(diagram, simulator.get_context().Clone())
        last = int(time / STEP) + 10
        clone.AdvanceTo(last * STEP)
        np.testing.assert_array_equal(
            seen(diagram, clone.get_context()), expected[last]
        )


@pytest.mark.parametrize("time", [1.3, 1.512, 2.0])
def test_a_file_holds_all_of_it(straight, tmp_path, time):
    diagram, expected = straight
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(time)
    file = SaveContext(diagram, simulator.get_context(), tmp_path / "a.npz")
    other = MakeTrialDiagram(collision_course())
    loaded = MakeTrialSimulator(other, LoadContext(other, file))
    loaded.AdvanceTo(3.0)
    np.testing.assert_array_equal(
        seen(other, loaded.get_context()), expected[60]
    )


def digest() -> str:
    recording = RunTrial(collision_course()).recording
    content = hashlib.sha256()
    for array in (recording.robot, recording.humans, recording.contacts):
        content.update(np.ascontiguousarray(array).tobytes())
    return content.hexdigest()


@pytest.mark.slow
def test_another_process_gives_the_same_bits():
    script = "from tests.hunav_drake import test_physical_trials as t"
    result = run_python(f"{script}; print(t.digest())")
    assert result.stdout.strip() == digest()


@pytest.mark.slow
def test_bodies_start_where_a_seed_puts_people():
    scenario = collision_course(start_jitter=0.3, seed=5)
    diagram = MakeTrialDiagram(scenario)
    plant = diagram.GetSubsystemByName("plant")
    people = plant.GetModelInstanceByName("people")

    def places(context):
        own = plant.GetMyContextFromRoot(context)
        bodies = plant.GetPositions(own, people).reshape(-1, 2)
        states = diagram.GetOutputPort("human_states").Eval(context)
        return bodies, states.reshape(-1, 7)[:, :2]

    fresh = diagram.CreateDefaultContext()
    np.testing.assert_array_equal(*places(fresh))
    used = Simulator(diagram)
    used.AdvanceTo(1.0)
    context = used.get_mutable_context()
    SetTrialSeed(diagram, context, 6)
    np.testing.assert_array_equal(*places(context))
    assert (places(context)[0] != places(fresh)[0]).all()
    SetTrialSeed(diagram, context, 5)
    used.Initialize()
    used.AdvanceTo(1.5)
    again = Simulator(diagram, fresh)
    again.AdvanceTo(1.5)
    np.testing.assert_array_equal(
        seen(diagram, context), seen(diagram, again.get_context())
    )


@pytest.fixture(scope="module")
def result():
    return RunTrial(collision_course())


@pytest.mark.slow
def test_contacts_are_recorded_and_measured(result):
    recording, metrics = result.recording, result.metrics
    assert recording.contact_forces_known
    last = recording.contacts[-1]
    assert metrics["contacts_by_person"] == last[:, Contact.BY_PERSON].sum()
    assert metrics["contacts_by_robot"] == last[:, Contact.BY_ROBOT].sum()
    assert metrics["contacts_by_person"] >= 1
    assert metrics["contact_impulse"] == pytest.approx(
        last[:, Contact.IMPULSE].sum()
    )
    assert metrics["max_contact_force"] == pytest.approx(
        recording.contacts[..., Contact.PEAK_FORCE].max()
    )


def test_a_kinematic_robot_counts_without_forces():
    result = RunTrial(collision_course("differential_drive"))
    assert not result.recording.contact_forces_known
    assert result.metrics["contacts_by_person"] >= 0
    assert np.isnan(result.metrics["max_contact_force"])
    assert np.isnan(result.metrics["contact_impulse"])


def test_a_recording_keeps_its_contacts(result, tmp_path):
    recording = result.recording
    recording.save(tmp_path / "a.npz")
    assert Recording.load(tmp_path / "a.npz") == recording
    # One behavior's people bring theirs.
    only = recording.only("regular")
    np.testing.assert_array_equal(only.contacts, recording.contacts)


def test_recordings_without_contacts_are_read(result, tmp_path):
    file = tmp_path / "a.npz"
    result.recording.save(file)
    with np.load(file) as archive:
        arrays = {k: v for k, v in archive.items() if "contact" not in k}
    np.savez(file, **arrays)
    old = Recording.load(file)
    assert old.contacts is None
    assert np.isnan(compute_metrics(old, ["contacts"])).all()


@pytest.mark.slow
def test_crowds_give_way_by_the_robot_of_the_trial():
    text = "robot: {type: pmb2}\nhumans: [{pose: [3, 0, 0]}]\n"
    assert LoadScenario(data=text).crowd.robots_stop is None
    chosen = LoadScenario(data=f"{text}crowd: {{robots_stop: false}}\n")
    assert chosen.crowd.robots_stop is False
    MakeTrialDiagram(chosen)


@pytest.mark.parametrize("model", ["pmb2", "urdf"])
def test_people_who_come_and_go_have_no_bodies_and_are_refused(model):
    """In one line, before anything runs."""
    overrides = [f"robot.type={model}"]
    if model == "urdf":
        drive = "{type: omnidirectional}"
        overrides += ["robot.file=a.urdf", "robot.base=b"]
        overrides += [f"robot.drive={drive}"]
    with pytest.raises(ScenarioError, match="cannot come and go") as raised:
        LoadScenario(filename="station", overrides=overrides)
    (fault,) = (f for f in raised.value.faults if "come and go" in f.message)
    assert fault.path == "population.sources"
    assert "\n" not in fault.message
    assert "take differential_drive" in fault.message


def test_people_of_cohorts_who_leave_for_good_are_refused_too():
    text = """
    robot: {type: pmb2, start: [-5, 0, 0]}
    population:
      cohorts:
        - {number: 2, start: [{rectangle: [0, 0, 3, 3]}], sinks: {out: 1}}
      sinks: [{name: out, area: {rectangle: [8, 0, 9, 3]}}]
    """
    with pytest.raises(ScenarioError, match="cannot come and go"):
        LoadScenario(data=text)
    LoadScenario(data=text.replace("pmb2", "differential_drive"))
    LoadScenario(data=text.replace(", sinks: {out: 1}", ""))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*robot.radius")
def test_any_number_of_walls_stands_on_the_floor():
    """Half spaces crash Drake beside some 50 boxes."""
    overrides = ["robot.type=pmb2", "simulation.duration=1.0"]
    scenario = LoadScenario(filename="office", overrides=overrides)
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(0.5)
    clone = Simulator(diagram, simulator.get_context().Clone())
    clone.AdvanceTo(1.0)
    plant = diagram.GetSubsystemByName("plant")
    walls = plant.GetCollisionGeometriesForBody(plant.world_body())
    assert len(walls) > 100
    context = plant.GetMyContextFromRoot(clone.get_context())
    base = plant.GetBodyByName("base")
    # It stands on its wheels, neither in the floor nor in the air.
    height = plant.EvalBodyPoseInWorld(context, base).translation()[2]
    assert abs(height) < 1e-3


def test_there_is_a_floor_where_the_robot_starts():
    robot = {"type": "pmb2", "start": (9e4, -9e4, 0), "goal": (9e4, -8e4, 0)}
    simulation = SimulationConfig(duration=1.0)
    diagram = MakeTrialDiagram(Scenario(robot=robot, simulation=simulation))
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.5)
    plant = diagram.GetSubsystemByName("plant")
    context = plant.GetMyContextFromRoot(simulator.get_context())
    base = plant.GetBodyByName("base")
    assert abs(plant.EvalBodyPoseInWorld(context, base).translation()[2]) < 1e-3


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*robot.radius")
@pytest.mark.parametrize("model", MODELS)
def test_every_robot_of_ones_own_runs_in_worlds(model, tmp_path):
    """In a process of its own, which a fault of Drake's may end.

    (The shipped robots run in all worlds in `tests/crosswise`.)
    """
    text, base, drive = MODELS[model]
    file = tmp_path / model
    file.write_text(text)
    robot = {"type": "urdf", "file": str(file), "base": base}
    robot |= {"drive": drive, "radius": 0.3}
    overrides = [f"robot.{key}={json.dumps(it)}" for key, it in robot.items()]
    overrides.append("simulation.duration=5.0")
    names = ["passing", "cafe", "warehouse", "corridor_dense", "doorway"]
    result = run_python(
        "import numpy as np; from hunav_drake import LoadScenario, RunTrial\n"
        f"for name in {names!r}:\n"
        f"    it = LoadScenario(filename=name, overrides={overrides!r})\n"
        "    print(np.isfinite(RunTrial(it).recording.robot).all())"
    )
    assert result.stdout.split() == ["True"] * len(names)
