"""Random trees say what py_trees says of them.

What the two libraries call alike does not always mean the same. Compared are:

- Sequence, Fallback: py_trees' Sequence and Selector *with* memory.
- ReactiveSequence, ReactiveFallback: the same *without* memory.
- Inverter: Inverter.
- Parallel (all must succeed): Parallel with SuccessOnAll(synchronise=True),
  where a child that has succeeded is not ticked again. py_trees ticks all
  children even if one has failed: the result is the same, but it may tick
  leaves that BehaviorTree.CPP does not.
- Parallel success_count="1": py_trees' SuccessOnOne differs in two ways (a
  failure wins over a success that comes first, and children that are done are
  ticked again), so it is left out.

Leaves say what is drawn for them and for the tick, whether they were ticked
before or not; py_trees knows no SKIPPED.
"""

from hypothesis import given, strategies as st
import numpy as np
import py_trees
import pytest

from hunav_drake.systems.behavior import NodeStatus
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.operations import PYTHON, Operation
from hunav_drake.systems.behavior.nodes.port import Port
from tests.systems.behavior.ticks import ME, PERSON, as_xml, tree_of

TICKS = 8
OURS = {
    "S": NodeStatus.SUCCESS,
    "F": NodeStatus.FAILURE,
    "R": NodeStatus.RUNNING,
}
THEIRS = {
    "S": py_trees.common.Status.SUCCESS,
    "F": py_trees.common.Status.FAILURE,
    "R": py_trees.common.Status.RUNNING,
}
NAMES = {status.name: letter for letter, status in OURS.items()}


def build_drawn(node):
    results = node.constant("results")

    def tick(context, memory):
        # The robot's position is the number of the tick.
        return OURS[results[int(context.robots[0][0])]]

    return tick


@pytest.fixture(scope="module", autouse=True)
def drawn(module_node_types):
    module_node_types["Drawn"] = NodeType(
        "Drawn",
        "Action",
        Operation(PYTHON),
        "Says what is drawn for the tick.",
        ports={"results": Port("results", str)},
        build=build_drawn,
    )


class Drawn(py_trees.behaviour.Behaviour):
    def __init__(self, results):
        super().__init__(results)
        self.results = results
        self.ticked = []

    def update(self):
        self.ticked.append(CLOCK[0])
        return THEIRS[self.results[CLOCK[0]]]


CLOCK = [0]

LEAVES = st.text("SFR", min_size=TICKS, max_size=TICKS)
CONTROLS = (
    "Sequence",
    "Fallback",
    "ReactiveSequence",
    "ReactiveFallback",
    "Parallel",
)
TREES = st.recursive(
    LEAVES,
    lambda child: (
        st.tuples(
            st.sampled_from(CONTROLS), st.lists(child, min_size=1, max_size=4)
        )
        | st.tuples(
            st.just("Inverter"), st.lists(child, min_size=1, max_size=1)
        )
    ),
    max_leaves=12,
)


def as_py_trees(tree, leaves):
    if isinstance(tree, str):
        leaves.append(Drawn(tree))
        return leaves[-1]
    tag, children = tree
    made = [as_py_trees(child, leaves) for child in children]
    if tag == "Inverter":
        return py_trees.decorators.Inverter("i", made[0])
    if tag == "Parallel":
        policy = py_trees.common.ParallelPolicy.SuccessOnAll(synchronise=True)
        return py_trees.composites.Parallel("p", policy, children=made)
    memory = not tag.startswith("Reactive")
    if tag.endswith("Sequence"):
        return py_trees.composites.Sequence("s", memory, made)
    return py_trees.composites.Selector("f", memory, made)


@given(TREES)
def test_random_trees_say_what_py_trees_says(tree):
    dut = tree_of(as_xml(tree, "Drawn"))
    leaves = []
    theirs = as_py_trees(tree, leaves)
    ours = [i for i, n in enumerate(dut.nodes) if n.type.name == "Drawn"]
    memory = dut.initial_memory(PERSON)
    for t in range(TICKS):
        CLOCK[0] = t
        theirs.tick_once()
        robot = ME.copy()
        robot[0] = t
        outcome, statuses = dut.trace(PERSON, memory, ME, robot)
        memory = outcome.memory
        assert outcome.node_status.name == theirs.status.name
        ticked = [statuses[i] is not NodeStatus.IDLE for i in ours]
        their_ticked = [leaf.ticked[-1:] == [t] for leaf in leaves]
        if "Parallel" in str(tree):
            assert np.all(np.less_equal(ticked, their_ticked))
        else:
            assert ticked == their_ticked
