"""The trees of people, ready to be ticked together."""

from collections.abc import Sequence
import itertools
from typing import Any

import numpy as np

from hunav_drake.systems.behavior.nodes.compiled_leaf import address_of
from hunav_drake.systems.behavior.nodes.control_flow import IDLE, SCRATCH_SIZE
from hunav_drake.systems.behavior.nodes.language_nodes import check_thresholds
from hunav_drake.systems.behavior.nodes.pointers import MAX_PORTS
from hunav_drake.systems.behavior.nodes.program import Program
from hunav_drake.systems.behavior.nodes.scripts import (
    COMPILE_LEAF,
    READ_PORTS,
    RUN_LEAF,
    STACK_SIZE,
)
from hunav_drake.systems.behavior.nodes.tick import (
    COMMAND_AT,
    TICK,
    TICK_FIELDS,
    TICK_SIZE,
)
from hunav_drake.systems.behavior.nodes.tick_context import (
    GOAL_INDEX,
    Person,
    TickContext,
)
from hunav_drake.systems.behavior.nodes.walk_kernel import PORTS_READ, walk
from hunav_drake.systems.behavior.society import Society
from hunav_drake.systems.behavior.tick_checks import check_written
from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    SIGNAL_SIZE,
    STATE_SIZE,
)
from hunav_drake.systems.world.obstacles import Obstacles

# Parts of a tick: what leaves write, goals and robot, and where it stopped.
_WRITTEN = slice(COMMAND_AT - 1, COMMAND_AT + COMMAND_SIZE)
_CHOICES = [TICK_FIELDS.index(it) for it in ("goal", "noticed", "goal_place")]
_PLACE = slice(TICK_SIZE - 4, TICK_SIZE - 1)
_NOTHING = np.zeros(0)
_NO_WALLS = Obstacles.from_shapes([], solid=[]).table


class Walk:
    """The trees of people in one piece, ticked by one compiled call.

    Attributes:
        memory: The part of the result of a tick with the memories of all.
        memories: The part of each person in that.
        commands: The part with the commands of all: see `layout.Command`.
        behavior_status: The part with everybody's behavior status.
        node_status: The part with the status of all nodes.
        node_statuses: The part of each person in that.
        signals: The part with the rows of `social_signals` of all.
    """

    def __init__(
        self,
        programs: Sequence[Program],
        people: Sequence[Person],
        initials: Sequence[Array] | None = None,
        society: Society | None = None,
    ) -> None:
        """Constructs a Walk.

        Args:
            programs: The tree of each person.
            people: The people.
            initials: For each, the memory while the person is outside; by
                default, nobody can be outside: see `layout.OUTSIDE`.
            society: What social leaves know; by default, there are none.
        """
        self._programs = list(programs)
        self._people = list(people)
        self.memories = _slices([len(it.slots) for it in programs])
        self.node_statuses = _slices([len(it.nodes) for it in programs])
        deepest = max((len(it.nodes) for it in programs), default=0)
        sizes = [
            TICK_SIZE,
            sum(len(it.slots) for it in programs),
            COMMAND_SIZE * len(people),
            len(people),
            sum(len(it.nodes) for it in programs),
            SIGNAL_SIZE * len(people) * (society is not None),
            SCRATCH_SIZE * deepest,
            MAX_PORTS,
            STACK_SIZE,
        ]
        parts = _slices(sizes)
        _, self.memory, self.commands, self.behavior_status, *rest = parts
        self.node_status, self.signals, scratch, values, stack = rest
        self._values = values
        self._size = sum(sizes)
        # (What the addresses in the records point to.)
        self._kept: list[Array] = []
        self._ticks = np.zeros(len(people), TICK)
        known = self._society_fields(society) if society else {}
        # By whether a person is in a wheelchair.
        slots = [0, 0]
        if society is not None:
            tables = (society.slots, society.slots_beside)
            slots = [*map(self._address, tables)]
        self._places: list[list[float]] | None = None
        if society is not None:
            self._places = society.places[:, 10:12].tolist()
        for i, tick in enumerate(self._ticks):
            fields = {
                **self._tree_fields(programs[i]),
                **self._person_fields(people[i]),
                **known,
                "slots_of_places": slots[people[i].is_wheeled],
                "social": society is not None and programs[i].is_social,
                "signal": 8 * (self.signals.start + SIGNAL_SIZE * i),
                "initial": self._address(initials[i]) if initials else 0,
                "first_slot": self.memories[i].start,
                "memory": 8 * (self.memory.start + self.memories[i].start),
                "statuses": 8
                * (self.node_status.start + self.node_statuses[i].start),
                "scratch": 8 * scratch.start,
                "values": 8 * values.start,
                "stack": 8 * stack.start,
                "distances": 8 * stack.stop,
                "noticed": -1,
            }
            for name, value in fields.items():
                tick[name] = value
        self._at = self._address(self._ticks)

    def _address(self, array: Any) -> int:
        self._kept.append(array)
        address: int = array.ctypes.data
        return address

    def _tree_fields(self, program: Program) -> dict[str, int]:
        tables = ("rows", "slots", "ports", "numbers", "steps", "halted")
        return {
            **{name: self._address(getattr(program, name)) for name in tables},
            "num_rows": len(program.nodes),
            "num_slots": len(program.slots),
            "num_halted": len(program.halted),
            "num_needs": program.num_needs,
        }

    def _person_fields(self, person: Person) -> dict[str, float]:
        walls = _NO_WALLS if person.walls is None else person.walls
        hiding = _NO_WALLS if person.hiding is None else person.hiding
        return {
            "index": person.index,
            "commands": self._address(np.array(person.commands, float)),
            "num_goals": len(person.goals),
            "cyclic": person.cyclic,
            "reach": person.goal_radius,
            "body_radius": person.body_radius,
            "time_step": person.time_step,
            "ignores": person.ignores_invitations,
            "walls": self._address(walls),
            "walls_size": len(walls),
            "hiding": self._address(hiding),
            "hiding_size": len(hiding),
        }

    def _society_fields(self, society: Society) -> dict[str, int]:
        return {
            **{
                name: self._address(getattr(society, name))
                for name in ("ids", "places", "lists")
            },
            "num_places": len(society.places),
            "num_place_slots": len(society.slots),
            "num_lists": len(society.lists),
        }

    def tick(
        self,
        memory: Array,
        humans: Array,
        robots: Array,
        signals: Array = _NOTHING,
    ) -> Array:
        """Ticks the trees once. The result depends on the arguments only.

        Args:
            memory: The memories of all people.
            humans: Shape (7n,): see `common.layout`.
            robots: Shape (7m,): see `common.layout`.
            signals: Shape (22 (n + m),), rows of `layout.Signal`, if there is
                a society; else, empty.

        Returns:
            The numbers whose parts are the attributes of this class.

        Raises:
            BehaviorTreeError: See `Tree.tick`.
            TypeError: See `Tree.tick`.
        """
        numbers = len(robots) // STATE_SIZE + 3 * (len(humans) // STATE_SIZE)
        work = np.empty(self._size + numbers)
        given = (memory, humans, robots, signals)
        arguments = (self._at, len(self._people), *given, work)
        code = walk(*arguments, 0, -1, 0)
        if not code:
            return work
        context = None
        while code:
            i, row, slot = work[_PLACE].view(np.int64).tolist()
            if context is None or context.person is not self._people[i]:
                places = self._places if self._programs[i].is_social else None
                context = TickContext(
                    self._people[i], [0.0], humans, robots, places
                )
            try:
                status = self._interrupted(code, i, row, slot, work, context)
            except Exception as error:
                error.add_note(f"in the tree {self._programs[i].name!r}")
                raise
            code = walk(*arguments, i, row, status)
        return work

    def _interrupted(
        self,
        code: int,
        person: int,
        row: int,
        slot: int,
        work: Array,
        context: TickContext,
    ) -> int:
        """Does what the walk was interrupted for; returns the node's status."""
        program = self._programs[person]
        node = program.nodes[row]
        own = work[self.memory][self.memories[person]]
        memory: list[float] = own.tolist()
        if code == COMPILE_LEAF:
            assert node.type.leaf is not None
            program.rows[row]["leaf"] = address_of(node.type.leaf)
            return IDLE
        if code == READ_PORTS:
            values = {name: node.read(name, memory) for name in node.ports}
            check_thresholds(node, values)
            ports = node.type.ports
            numbers = [
                program.number(ports[it], value) for it, value in values.items()
            ]
            work[self._values][: len(numbers)] = numbers
            return int(PORTS_READ)
        if code != RUN_LEAF:
            entry = program.names[slot].partition(" ")[0]
            raise node.error(f"nothing has set {entry} yet")
        status, *command = work[_WRITTEN].tolist()
        before = (command, int(status))
        choices = work.view(np.int64)
        memory[GOAL_INDEX], *others = choices[_CHOICES].tolist()
        context.begin(memory, *before, *others)
        # (Numba takes long to see that a member of an enum is a number.)
        result = int(program.leaves[row](context, memory))
        check_written(node, context, memory, before)
        work[_WRITTEN] = [context.behavior_status, *context.command]
        choices[_CHOICES] = (
            *(int(memory[GOAL_INDEX]), context.noticed),
            context.goal_place,
        )
        own[:] = memory
        return result


def _slices(lengths: Sequence[int]) -> list[slice]:
    """Returns the slices of consecutive parts of these lengths."""
    ends = itertools.accumulate(lengths, initial=0)
    return [slice(begin, end) for begin, end in itertools.pairwise(ends)]
