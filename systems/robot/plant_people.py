"""People as bodies of a MultibodyPlant."""

from collections.abc import Sequence
import math

import numpy as np
from pydrake.geometry import Cylinder
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    PdControllerGains,
    PrismaticJoint,
    SpatialInertia,
)
from pydrake.systems.framework import (
    BasicVector,
    Context,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import STATE_SIZE, VX, VY, X, Y

# The model instance of all people in a plant.
PEOPLE = "people"

# The mass and the height of an adult, in kg and meters.
MASS, HEIGHT = 70.0, 1.7

# The gains with which a body follows the person, in N/m and N s/m, and the
# maximum force, in N.
STIFFNESS, DAMPING, STRENGTH = 1e5, 1e4, 5e3

# Friction of clothes on a robot's shell.
_FRICTION = CoulombFriction(0.3, 0.3)


def AddPeople(
    plant: MultibodyPlant, radii: Sequence[float], starts: Array
) -> tuple[BodyIndex, ...]:
    """Adds the bodies of people to a plant, as one model instance.

    Each is an upright cylinder of a radius in meters, with two motors that move
    it along x and y of W. (It needs no yaw, because it is round.) The plant is
    not finalized yet; people begin at `starts`, rows (x, y, ...), in meters.
    """
    instance = plant.AddModelInstance(PEOPLE)
    world = plant.world_frame()
    bodies = []
    for i, (radius, start) in enumerate(zip(radii, starts, strict=True)):
        inertia = SpatialInertia.SolidCylinderWithMass(
            MASS, radius, HEIGHT, [0, 0, 1]
        )
        stage = plant.AddRigidBody(
            f"person_{i}_x", instance, SpatialInertia.Zero()
        )
        body = plant.AddRigidBody(f"person_{i}", instance, inertia)
        for name, parent, child, axis, position in (
            (f"person_{i}_x", world, stage, [1, 0, 0], start[X]),
            (f"person_{i}_y", stage.body_frame(), body, [0, 1, 0], start[Y]),
        ):
            joint = plant.AddJoint(
                PrismaticJoint(name, parent, child.body_frame(), axis)
            )
            joint.set_default_translation(position)
            actuator = plant.AddJointActuator(name, joint, STRENGTH)
            actuator.set_controller_gains(
                PdControllerGains(p=STIFFNESS, d=DAMPING)
            )
        plant.RegisterCollisionGeometry(
            body,
            RigidTransform([0, 0, HEIGHT / 2]),
            Cylinder(radius, HEIGHT),
            "body",
            _FRICTION,
        )
        bodies.append(body.index())
    return tuple(bodies)


def PlacePeople(plant: MultibodyPlant, context: Context, states: Array) -> None:
    """Places the bodies of people at their states, at rest.

    The plant has the people of `AddPeople`, or nobody; `context` is its
    Context, `states` are rows of ``human_states``.
    """
    if not plant.HasModelInstanceNamed(PEOPLE):
        return
    instance = plant.GetModelInstanceByName(PEOPLE)
    places = states[:, : Y + 1].ravel()
    plant.SetPositions(context, instance, places)
    plant.SetVelocities(context, instance, np.zeros(places.size))


def people_states(state: Array) -> Array:
    """Returns rows (n, 7) of people from the state of their model instance.

    That has shape (4n,): all x and y, then their rates, from the state output
    port of the instance.
    """
    positions, velocities = state.reshape(2, -1, 2)
    rows = np.zeros((len(positions), STATE_SIZE))
    rows[:, X : Y + 1] = positions
    rows[:, VX : VY + 1] = velocities
    return rows


class PeopleDriver(LeafSystem):
    """Gives the desired state of the bodies of people in a plant.

    .. pydrake_system::

        name: PeopleDriver
        input_ports:
        - human_states
        output_ports:
        - desired_state

    Port ``human_states`` takes n rows (x, y, yaw, vx, vy, omega, radius) in W,
    in SI units, which change every ``time_step``. Port ``desired_state`` gives
    all positions (x, y), then all velocities, for the plant's port of that name
    of `PEOPLE`.

    At a time t, the plant computes its step to t + h, so the positions are
    those of t + h. Between two steps of people, Drake holds the states of the
    later one, which are extrapolated backwards along the velocities. At a step
    of people, the states are still those of t, and are extrapolated forwards.

    There is no state.
    """

    def __init__(
        self, num_humans: int, *, time_step: float, plant_step: float
    ) -> None:
        """Constructs a PeopleDriver.

        People step every `time_step`, in seconds, the plant every `plant_step`:
        the same, or a half, a quarter ... of it.
        """
        super().__init__()
        self._plant_step = plant_step
        self._steps = round(time_step / plant_step)
        self._human_states = self.DeclareVectorInputPort(
            "human_states", STATE_SIZE * num_humans
        )
        self._human_states_index = int(self._human_states.get_index())
        self._desired_state = self.DeclareVectorOutputPort(
            "desired_state",
            4 * num_humans,
            self._CalcDesiredState,
            prerequisites_of_calc={
                self.time_ticket(),
                self.all_input_ports_ticket(),
            },
        )

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_desired_state_output_port(self) -> OutputPort:
        """Returns the port with the desired state of their bodies."""
        return self._desired_state

    def _CalcDesiredState(self, context: Context, output: BasicVector) -> None:
        # A view instead of the copy from Eval, because this runs at each plant
        # step.
        rows = self.EvalVectorInput(context, self._human_states_index).value()
        rows = rows.reshape(-1, STATE_SIZE)
        if not math.isfinite(rows.sum()):
            raise RuntimeError(
                f"{self.GetSystemPathname()}, t = {context.get_time():.3f} s:"
                " human_states must be finite: a physical robot needs people"
                " who are present from start to end; choose the robot"
                " differential_drive for others"
            )
        step = round(context.get_time() / self._plant_step) % self._steps
        ahead = 1 if step == 0 else step + 1 - self._steps
        desired = np.empty((2, len(rows), 2))
        desired[1] = rows[:, VX : VY + 1]
        np.multiply(desired[1], ahead * self._plant_step, out=desired[0])
        desired[0] += rows[:, : Y + 1]
        output.SetFromVector(desired.ravel())
