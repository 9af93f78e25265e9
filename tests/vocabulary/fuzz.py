"""Random trees of all nodes: `python -m tests.vocabulary.fuzz 10000`.

Six people with random trees walk among walls and a robot for 200 steps. Nobody
may be in a wall or nowhere, and what people show must be in range.
"""

import itertools
import math
import sys

import numpy as np

from hunav_drake.systems.behavior import NODE_TYPES, BehaviorTreeError
from hunav_drake.systems.behavior.nodes.node import MANY
from hunav_drake.systems.behavior.nodes.port import Meaning
from hunav_drake.systems.common.layout import SIGNAL_SIZE, is_outside
from hunav_drake.systems.people.places import Place
from hunav_drake.systems.world.shapes import Box, Polyline, World
from tests.vocabulary.stage import Stage, someone

PEOPLE, STEPS, DEEPEST = 6, 200, 4
WORLD = World(
    walls=[
        Polyline(points=[(-7, -7), (7, -7), (7, 7), (-7, 7), (-7, -7)]),
        Box(center=(2.0, 0.0), size=(1.0, 3.0)),
    ]
)
PLACES = [Place(name=f"p{i}", pose=(3.0 * i - 4, i - 3.0, i)) for i in range(3)]
PLACES.append(Place(name="door", type="door", pose=(-2, 0.5, 0.4)))
NEEDS = {"thirst": {"initial": 60, "rate": 5.0}, "rest": {}}
# Nodes of the language that take texts or numbers of their own.
_PLAIN = ("Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback")
_AROUND = ("Inverter", "ForceSuccess", "ForceFailure", "RunOnce")
# Ports for numbers in [0, 1].
_SHARES = ("probability",)
_TIMED = (
    'Cooldown seconds="{:.2f}"',
    'TimeDelay delay="{:.2f}"',
    'Repeat num_cycles="2"',
    'Satisfies need="rest" amount="20" place="p0"',
)


def leaves():
    """Returns the types of all leaves of this package."""
    return [it for it in NODE_TYPES.values() if it.source and it.is_ours]


def _value(port, generator, own):
    """Returns a value for a port as a text, or None for its default."""
    if port.meaning is Meaning.RESULT:
        return "{who}"
    if port.meaning is Meaning.PERSON:
        return generator.choice(["{who}", str(generator.integers(1, 7))])
    if port.meaning is Meaning.PEOPLE:
        others = np.setdiff1d(np.arange(1, PEOPLE + 1), own)
        count = generator.integers(1, PEOPLE - 1)
        numbers = generator.choice(others, count, replace=False)
        return generator.choice(["{who}", ", ".join(map(str, numbers))])
    if port.meaning is Meaning.NEED:
        return generator.choice([*NEEDS])
    if port.meaning is Meaning.DOOR:
        return "door"
    if port.meaning is Meaning.PLACE:
        return generator.choice(["p0", "p1", "3"])
    if port.default is not ... and generator.random() < 0.6:
        return None
    if port.choices:
        return generator.choice(port.choices)
    if port.base is bool:
        return generator.choice(["true", "false"])
    if port.base is int:
        least = 2 if port.name == "max_members" else 0
        return str(least + generator.integers(0, 3))
    if port.base is str:
        return " ".join("word" for _ in range(generator.integers(1, 9)))
    values = [0.05, 0.3, 1.0, 3.0]
    return f"{generator.choice(values[: 3 if port.name in _SHARES else 4]):.2f}"


def _leaf(generator, own):
    kind = generator.choice(np.array(leaves(), dtype=object))
    values = {
        it: _value(port, generator, own) for it, port in kind.ports.items()
    }
    ports = "".join(f' {k}="{v}"' for k, v in values.items() if v is not None)
    return f"<{kind.name}{ports}/>"


def random_tree(generator, own, depth=0):
    """Returns the XML of a random node of a person's tree, and all below."""
    chance = generator.random()
    if depth == DEEPEST or chance < 0.35:
        return _leaf(generator, own)
    if chance < 0.55:
        head = generator.choice([*_AROUND, *_TIMED])
        head = head.format(generator.choice([0.2, 1.0, 3.0]))
        children = [random_tree(generator, own, depth + 1)]
    else:
        head = generator.choice([*_PLAIN, "NeedsSelector"])
        assert NODE_TYPES[head].children == MANY
        count = generator.integers(1, 5)
        children = [
            random_tree(generator, own, depth + 1) for _ in range(count)
        ]
        if head == "NeedsSelector":
            satisfies = '<Satisfies need="thirst" amount="30">{}</Satisfies>'
            children = [satisfies.format(it) for it in children]
    return f"<{head}>{''.join(children)}</{head.partition(' ')[0]}>"


def _robot(t):
    x, y = 4 * math.cos(0.3 * t), 4 * math.sin(0.3 * t)
    yaw = 0.3 * t + math.pi / 2
    vx, vy = -1.2 * math.sin(0.3 * t), 1.2 * math.cos(0.3 * t)
    return [x, y, yaw, vx, vy, 0.3, 0.3]


def run(seed: int) -> str:
    """Runs six random trees; returns what a tree was refused for, if it was."""
    generator = np.random.default_rng(seed)
    # The entry that many name is set by somebody.
    finds = '<ForceFailure><FindNearestAgent target_agent_id="{who}"/>'
    people = [
        someone(
            *(-5.0 + 2 * (i % 3), -3.0 + 5 * (i // 3)),
            generator.uniform(-3, 3),
            f"{finds}</ForceFailure>{random_tree(generator, i + 1)}",
            goals=[tuple(generator.uniform(-6, -1, 2)) for _ in range(2)],
            cyclic=bool(generator.integers(2)),
            needs=NEEDS,
            invitations=str(generator.choice(["accept", "ignore"])),
        )
        for i in range(PEOPLE)
    ]
    try:
        stage = Stage(
            people,
            places=PLACES,
            robot=_robot,
            obstacles=WORLD,
            separate_trees=bool(generator.integers(2)),
            seed=seed,
        )
        for _ in range(STEPS):
            stage.step()
    except BehaviorTreeError as error:
        return str(error)
    states, signals = stage.states, stage.signals
    assert np.isfinite(states).all(), seed
    assert not is_outside(states).any(), seed
    x, y = np.abs(states[:, 0]), np.abs(states[:, 1])
    assert (x < 7).all(), seed
    assert (y < 7).all(), seed
    in_box = (np.abs(states[:, 0] - 2) < 0.5) & (y < 1.5)
    assert not in_box.any(), seed
    system = next(
        it
        for it in stage.diagram.GetSystems()
        if it.get_name().startswith("behavior")
    )
    for row in signals.reshape(-1, SIGNAL_SIZE):
        system.CheckSignals(row)
    return ""


def main(trees: int) -> None:
    """Runs many random trees, and prints what they were refused for."""
    refused = 0
    for seed in itertools.count():
        if seed * PEOPLE >= trees:
            break
        words = run(seed)
        refused += bool(words)
        if words:
            print(seed, words[-200:])
    print(f"{trees} trees; {refused} of {seed} sixes refused")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 600)
