"""Contacts between a robot in a plant and people."""

from collections.abc import Collection, Sequence
import math

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    CONTACT_SIZE,
    STATE_SIZE,
    Contact,
    X,
    Y,
)
from hunav_drake.systems.robot.contact_rows import (
    MEMORY_SIZE,
    PERSON_SPEED,
    ROBOT_SPEED,
    count_contacts,
)
from hunav_drake.systems.robot.discs import closing_speeds, gaps
from hunav_drake.systems.robot.plant_people import people_states

# The maximum approach speed of a robot and a person, in m/s, and the margin of
# the contact search, in meters.
_FASTEST, _MARGIN = 20.0, 0.1


class PlantContacts(LeafSystem):
    """Counts the contacts between a robot and people in a plant.

    .. pydrake_system::

        name: PlantContacts
        input_ports:
        - contact_results
        - robot_state
        - people_state
        output_ports:
        - contacts

    Port ``contact_results`` takes the contacts that a discrete plant without
    sampled outputs computes for the step that begins now; ``robot_state`` takes
    the row of the robot, and ``people_state`` the state of the model instance
    `PEOPLE`. Port ``contacts`` gives n rows of `layout.Contact`, with forces of
    the plant's last step, and counts and sums over all steps.

    A person inside the robot's disc is in contact, too, even without a force:
    the crowd keeps people out of the disc, also where it is larger than the
    robot's shapes, and moves them.

    The discrete state holds a row of `contact_rows` per person; a second group
    holds 1 while anybody is near enough to touch. It is updated with each step
    of the plant. (The plant's outputs cover its last step only: a saved Context
    would lose it, and samples would miss short pushes.)
    """

    def __init__(
        self,
        bodies: Sequence[BodyIndex],
        radii: Sequence[float],
        robot: Collection[BodyIndex],
        *,
        time_step: float,
        plant_step: float,
        reach: float = math.inf,
        num_bodies: int | None = None,
    ) -> None:
        """Constructs a PlantContacts without contacts.

        `bodies` are those of n people with some radii, in meters; with others
        after them, there are `num_bodies` in the plant. `robot` are the bodies
        of the robot.

        People step every `time_step`, the plant every `plant_step`, in seconds.
        While nobody can come within the `reach` of the robot's shapes, in
        meters, before the next step of people, the plant's contacts are not
        evaluated.
        """
        super().__init__()
        n = len(bodies)
        self._person = {int(body): i for i, body in enumerate(bodies)}
        self._robot = {int(body) for body in robot}
        self._radii = np.array(radii)
        self._plant_step = plant_step
        self._steps = round(time_step / plant_step)
        self._contact_results = self.DeclareAbstractInputPort(
            "contact_results", AbstractValue.Make(ContactResults())
        )
        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._people_state = self.DeclareVectorInputPort(
            "people_state", 4 * (n if num_bodies is None else num_bodies)
        )
        self._distances = self._radii + reach + _MARGIN + _FASTEST * time_step
        self._is_near = self.DeclareDiscreteState([1.0])
        self._memory = self.DeclareDiscreteState(MEMORY_SIZE * n)
        self._contacts = self.DeclareVectorOutputPort(
            "contacts",
            CONTACT_SIZE * n,
            self._CalcContacts,
            prerequisites_of_calc={self.discrete_state_ticket(self._memory)},
        )
        if n:
            self.DeclarePeriodicDiscreteUpdateEvent(
                period_sec=plant_step, offset_sec=0.0, update=self._Update
            )

    def get_contact_results_input_port(self) -> InputPort:
        """Returns the port with the contacts that the plant computes."""
        return self._contact_results

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_people_state_input_port(self) -> InputPort:
        """Returns the port with the state of the bodies of people."""
        return self._people_state

    def get_contacts_output_port(self) -> OutputPort:
        """Returns the port with the contacts."""
        return self._contacts

    def _CalcContacts(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).value()
        rows = memory.reshape(-1, MEMORY_SIZE)[:, :CONTACT_SIZE]
        output.SetFromVector(rows.ravel())

    def _Forces(self, context: Context) -> Array | None:
        """Returns the horizontal forces of people on the robot, (n, 2)."""
        forces = None
        results = self._contact_results.Eval(context)
        for k in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(k)
            a, b = int(info.bodyA_index()), int(info.bodyB_index())
            # The force is that on body B.
            sign = 1.0
            person = self._person.get(a)
            if person is None:
                person, b, sign = self._person.get(b), a, -1.0
            if person is not None and b in self._robot:
                if forces is None:
                    forces = np.zeros((len(self._person), 2))
                forces[person] += sign * info.contact_force()[:2]
        return forces

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # A copy, because it is modified.
        memory = context.get_discrete_state(self._memory).CopyToVector()
        memory = memory.reshape(-1, MEMORY_SIZE)
        (is_near,) = context.get_discrete_state(self._is_near).value()
        forces = self._Forces(context) if is_near else None
        # The recent speeds are those at the last step of people.
        step = round(context.get_time() / self._plant_step) % self._steps
        lasts = memory[:, Contact.LASTS].any()
        if forces is None and not lasts and step:
            return
        robot = self._robot_state.Eval(context)
        people = people_states(self._people_state.Eval(context))
        people = people[: len(self._person)]
        closing = closing_speeds(robot, people)
        gap = gaps(robot, people, self._radii)
        touching = gap < 0
        if forces is not None or lasts or touching.any():
            if forces is None:
                forces = np.zeros((len(people), 2))
            touching |= (forces != 0).any(axis=1)
            memory = count_contacts(
                memory, touching, forces, gap, closing, self._plant_step
            )
        if step == 0:
            memory[:, [ROBOT_SPEED, PERSON_SPEED]] = closing.T
            away = np.hypot(people[:, X] - robot[X], people[:, Y] - robot[Y])
            near = bool((away < self._distances).any())
            discrete_state.set_value(self._is_near, [float(near)])
        discrete_state.set_value(self._memory, memory.ravel())
