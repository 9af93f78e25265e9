"""Robots that drive as they are told, among people who go about."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from hunav_drake import AddHumans
from hunav_drake.scenario import CrowdConfig
from hunav_drake.systems.robot import ROBOTS, DiscContacts, RobotTask
from hunav_drake.systems.world.obstacles import Obstacles

NOBODY = Obstacles.from_shapes([], solid=[])


class Drive(NamedTuple):
    """What happened to a robot and people, at the times of the samples.

    Attributes:
        times: Shape (k,), in seconds.
        robot: Shape (k, 7).
        people: Shape (k, n, 7).
        contacts: Shape (k, n, 8), rows of `layout.Contact`.
    """

    times: np.ndarray
    robot: np.ndarray
    people: np.ndarray
    contacts: np.ndarray


def make_diagram(
    robot, humans=(), *, obstacles=NOBODY, time_step=0.05, keep_apart=True
) -> Diagram:
    """Returns a diagram of a robot and people; its input is the command.

    Args:
        robot: The robot, as data.
        humans: The people.
        obstacles: The walls.
        time_step: In seconds.
        keep_apart: Whether bodies are kept apart.
    """
    config = ROBOTS.make(robot)
    builder = DiagramBuilder()
    people = AddHumans(
        builder,
        humans,
        obstacles=obstacles,
        # (People do not look where they go: else nobody would touch.)
        config=CrowdConfig(
            robots_stop=config.physical, keep_apart=keep_apart, robot_gap=0.0
        ),
        time_step=time_step,
    )
    task = RobotTask(time_step=time_step, obstacles=obstacles, humans=humans)
    system = config.AddToBuilder(builder, task)
    contacts = system
    if not config.physical:
        contacts = builder.AddSystem(DiscContacts(humans, time_step=time_step))
        builder.Connect(
            people.robot_touches, contacts.get_robot_touches_input_port()
        )
        builder.Connect(
            system.GetOutputPort("robot_state"),
            contacts.get_robot_state_input_port(),
        )
    for taker in {system, contacts}:
        if humans and taker.HasInputPort("human_states"):
            builder.Connect(
                people.human_states, taker.GetInputPort("human_states")
            )
    builder.Connect(system.GetOutputPort("robot_state"), people.robot_states)
    builder.ExportInput(system.GetInputPort("velocity_command"), "command")
    builder.ExportOutput(system.GetOutputPort("robot_state"), "robot_state")
    builder.ExportOutput(people.human_states, "human_states")
    builder.ExportOutput(contacts.GetOutputPort("contacts"), "contacts")
    return builder.Build()


def drive(
    diagram: Diagram,
    command,
    *,
    duration: float,
    every: float = 0.05,
    context: Context | None = None,
) -> Drive:
    """Drives a robot, and returns what happened.

    Args:
        diagram: From `make_diagram`.
        command: (v, omega), or a function of time and robot's row to it.
        duration: In seconds.
        every: The time between two samples, and two commands, in seconds.
        context: Where to go on from; by default the start.
    """
    simulator = (
        Simulator(diagram) if context is None else Simulator(diagram, context)
    )
    context = simulator.get_mutable_context()
    names = ("robot_state", "human_states", "contacts")
    rows = []
    times = np.arange(round(duration / every) + 1) * every
    for time in times:
        simulator_is_there = time <= context.get_time()
        if not simulator_is_there:
            simulator.AdvanceTo(time)
        values = [
            diagram.GetOutputPort(name).Eval(context).copy() for name in names
        ]
        told = command(time, values[0]) if callable(command) else command
        diagram.get_input_port().FixValue(context, told)
        rows.append(values)
    robot, people, contacts = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    k = len(times)
    return Drive(
        times, robot, people.reshape(k, -1, 7), contacts.reshape(k, -1, 8)
    )
