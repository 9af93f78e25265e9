"""The operations of nodes and of scripts, as numbers for compiled code.

An operation of a node is a code and the numbers that it needs; see `walk`,
which has their meaning.
"""

from typing import NamedTuple

# Compiled leaves, and a decorator that calls one before and after its child.
CONDITION, ACTION, AROUND = 0, 1, 2
# A leaf in Python.
PYTHON = 3
# The actions of the language: gives a status; sets a blackboard entry.
GIVE, SET = 4, 5
# Sequences and fallbacks.
ORDERED, REACTIVE = 6, 7
# Decorators: maps each status to another; those that count.
MAPPED = 8
AGAIN, RUN_ONCE, DELAY, TIMEOUT = 9, 10, 11, 12
TIME_DELAY, COOLDOWN = 17, 18
# What satisfies a need, and what chooses among such nodes.
SATISFIES, NEEDS = 19, 20
# Nodes that choose a child, and Parallel.
IF, WHILE, SWITCH, PARALLEL = 13, 14, 15, 16

# Scripts: instructions for a machine with a stack.
NUMBER, ENTRY, NOT, AND, OR, TRUTH, ASSIGN = 0, 1, 2, 3, 4, 5, 6
LESS, AT_MOST, GREATER, AT_LEAST, EQUAL, UNEQUAL = 7, 8, 9, 10, 11, 12


class Operation(NamedTuple):
    """What a node does.

    Attributes:
        code: One of the operations above.
        numbers: At most four numbers, most often statuses.
    """

    code: int
    numbers: tuple[int, ...] = ()


class Instruction(NamedTuple):
    """An instruction of a script.

    Attributes:
        code: One of the instructions above.
        value: A number, the slot of an entry, or how many instructions AND
            and OR skip if their left side decides.
    """

    code: int
    value: float = 0.0


Script = tuple[Instruction, ...]
