"""Counts the contacts of kinematic robots with people."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import check_time_step
from hunav_drake.systems.common.layout import (
    CONTACT_SIZE,
    STATE_SIZE,
    TOUCH_SIZE,
)
from hunav_drake.systems.people.human_config import HumanConfig
from hunav_drake.systems.robot.contact_rows import MEMORY_SIZE
from hunav_drake.systems.robot.discs import touch_discs

_NO_TOUCHES = np.zeros((0, TOUCH_SIZE))


class DiscContacts(LeafSystem):
    """Counts the contacts between the discs of a robot and of people.

    .. pydrake_system::

        name: DiscContacts
        input_ports:
        - robot_state
        - human_states
        - robot_touches (optional)
        output_ports:
        - contacts

    The ports take the rows (x, y, yaw, vx, vy, omega, radius) of the robot and
    of n people in W, in SI units. The robot's disc has the radius of its row,
    those of people have their body radius (`HumanConfig.contact_radius`). They
    touch where they overlap; and, because a crowd keeps them apart, where they
    would otherwise overlap at the end of the step that begins now. Port
    ``robot_touches`` takes the latter: n rows of a `HumanCrowd`'s port of that
    name.

    Port ``contacts`` gives n rows of `layout.Contact`. All forces are 0,
    because nothing stops a kinematic robot.

    The discrete state holds a row of `contact_rows` per person. It is updated
    every ``time_step`` with the states at that instant.
    """

    def __init__(
        self, humans: Sequence[HumanConfig], *, time_step: float = 0.05
    ) -> None:
        """Constructs a DiscContacts without contacts; `time_step` in seconds.

        Raises:
            ValueError: If ``time_step`` is not positive.
        """
        super().__init__()
        self._time_step = check_time_step(time_step)
        n = len(humans)
        self._bodies = np.array([human.contact_radius for human in humans])
        self._robot_state = self.DeclareVectorInputPort(
            "robot_state", STATE_SIZE
        )
        self._human_states = self.DeclareVectorInputPort(
            "human_states", STATE_SIZE * n
        )
        self._robot_touches = self.DeclareVectorInputPort(
            "robot_touches", TOUCH_SIZE * n
        )
        # (Numbers are found faster by an integer than by a typed index.)
        self._memory = int(self.DeclareDiscreteState(MEMORY_SIZE * n))
        self._contacts = self.DeclareVectorOutputPort(
            "contacts",
            CONTACT_SIZE * n,
            self._CalcContacts,
            prerequisites_of_calc={
                self.discrete_state_ticket(DiscreteStateIndex(self._memory))
            },
        )
        if n:
            self.DeclarePeriodicDiscreteUpdateEvent(
                period_sec=time_step, offset_sec=0.0, update=self._Update
            )

    def get_robot_state_input_port(self) -> InputPort:
        """Returns the port with the state of the robot."""
        return self._robot_state

    def get_human_states_input_port(self) -> InputPort:
        """Returns the port with the states of the people."""
        return self._human_states

    def get_robot_touches_input_port(self) -> InputPort:
        """Returns the port with the contacts that the crowd prevents."""
        return self._robot_touches

    def get_contacts_output_port(self) -> OutputPort:
        """Returns the port with the contacts."""
        return self._contacts

    def _CalcContacts(self, context: Context, output: BasicVector) -> None:
        memory = context.get_discrete_state(self._memory).value()
        rows = memory.reshape(-1, MEMORY_SIZE)[:, :CONTACT_SIZE]
        output.SetFromVector(rows.ravel())

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        # Views: Eval() would copy the states.
        touches = self._robot_touches
        after = touch_discs(
            self._robot_state.EvalBasicVector(context).value(),
            self._human_states.EvalBasicVector(context)
            .value()
            .reshape(-1, STATE_SIZE),
            self._bodies,
            touches.EvalBasicVector(context).value().reshape(-1, TOUCH_SIZE)
            if touches.HasValue(context)
            else _NO_TOUCHES,
            context.get_discrete_state(self._memory)
            .value()
            .reshape(-1, MEMORY_SIZE),
            self._time_step,
        )
        discrete_state.set_value(self._memory, after.ravel())
