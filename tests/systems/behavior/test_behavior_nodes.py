"""What each node says and remembers, for what its children say.

A child is written as the results of its ticks, one letter each: (S)uccess,
(F)ailure, (R)unning, s(K)ipped; after the last it starts over, and so it does
when it is halted while it runs. An expected tick is the result of the node, a
colon, and what each child said in that tick, "-" if it was not ticked.
"""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from hunav_drake.systems.behavior import ParseTree, Person, Status, registry
from hunav_drake.systems.behavior.node import Built, NodeType, Port
from hunav_drake.systems.crowd.human_config import HumanConfig

LETTERS = {
    "S": Status.SUCCESS,
    "F": Status.FAILURE,
    "R": Status.RUNNING,
    "K": Status.SKIPPED,
    "-": Status.IDLE,
}
NAMES = {status: letter for letter, status in LETTERS.items()}
PERSON = Person.from_config(
    HumanConfig(pose=(0.0, 0.0, 0.0)), index=0, time_step=0.1
)
NOBODY = np.zeros(7)


def build_script(node, children):
    results = node.constant("results")
    slot = node.slot("at")

    def tick(memory, moment):
        at = int(memory[slot])
        memory[slot] = (at + 1) % len(results)
        return LETTERS[results[at]]

    def halt(memory):
        if results[int(memory[slot]) - 1] == "R":
            memory[slot] = 0.0

    return Built(tick, halt, may_skip="K" in results)


@pytest.fixture(autouse=True)
def script(monkeypatch):
    monkeypatch.setitem(
        registry._TYPES,
        "Script",
        NodeType(
            "Script",
            "Action",
            build_script,
            "Says what is written.",
            ports={"results": Port("results", str)},
            slots={"at": 0.0},
        ),
    )


def parse(start, children):
    tag = start.split()[0]
    scripts = "".join(f'<Script results="{c}"/>' for c in children.split())
    return ParseTree(
        f"<root><BehaviorTree><{start}>{scripts}</{tag}></BehaviorTree></root>"
    )


def run(tree, count):
    """Returns the ticks, and the memory after each."""
    memory = tree.initial_memory(PERSON)
    ticks, memories = [], []
    for _ in range(count):
        outcome, statuses = tree.trace(PERSON, memory, NOBODY, NOBODY)
        assert tree.tick(PERSON, memory, NOBODY, NOBODY) == outcome
        memory = outcome.memory
        text = "".join(NAMES[status] for status in statuses)
        ticks.append(f"{text[0]}:{text[1:]}")
        memories.append(memory)
    return ticks, memories


CASES = [
    # Sequence: resumes at the running child, starts over after a failure.
    ("Sequence", "S", "S:S S:S"),
    ("Sequence", "F", "F:F F:F"),
    ("Sequence", "S S S", "S:SSS"),
    ("Sequence", "S F S", "F:SF- F:SF-"),
    ("Sequence", "F S", "F:F-"),
    ("Sequence", "R S", "R:R- R:R-"),
    ("Sequence", "S RS S", "R:SR- S:-SS R:SR-"),
    ("Sequence", "S RF S", "R:SR- F:-F- R:SR-"),
    ("Sequence", "S RRS F", "R:SR- R:-R- F:-SF R:SR-"),
    ("Sequence", "SF RS", "R:SR S:-S F:F-"),
    ("Sequence", "K S", "S:KS"),
    ("Sequence", "K F", "F:KF"),
    ("Sequence", "K K", "K:KK K:KK"),
    ("Sequence", "K RK K", "R:KR- K:-KK"),
    ("Sequence", "S RK K", "R:SR- S:-KK"),
    ("Sequence", "K R", "R:KR R:-R"),
    # Fallback: the same with success and failure exchanged.
    ("Fallback", "S", "S:S"),
    ("Fallback", "F", "F:F"),
    ("Fallback", "F F F", "F:FFF"),
    ("Fallback", "F S F", "S:FS- S:FS-"),
    ("Fallback", "S F", "S:S-"),
    ("Fallback", "R F", "R:R-"),
    ("Fallback", "F RS F", "R:FR- S:-S- R:FR-"),
    ("Fallback", "F RF S", "R:FR- S:-FS"),
    ("Fallback", "F RF F", "R:FR- F:-FF R:FR-"),
    ("Fallback", "FS RF", "R:FR F:-F S:S-"),
    ("Fallback", "K F", "F:KF"),
    ("Fallback", "K S", "S:KS"),
    ("Fallback", "K K", "K:KK"),
    ("Fallback", "K RK K", "R:KR- K:-KK"),
    # SequenceWithMemory: does not repeat what succeeded before a failure.
    ("SequenceWithMemory", "S S", "S:SS S:SS"),
    ("SequenceWithMemory", "S FS S", "F:SF- S:-SS F:SF-"),
    ("SequenceWithMemory", "S FFS S", "F:SF- F:-F- S:-SS"),
    ("SequenceWithMemory", "S RFS S", "R:SR- F:-F- S:-SS"),
    ("SequenceWithMemory", "S RS F", "R:SR- F:-SF F:--F"),
    ("SequenceWithMemory", "K K", "K:KK"),
    ("SequenceWithMemory", "K FK", "F:KF S:-K"),
    ("SequenceStar", "S FS S", "F:SF- S:-SS"),
    # ReactiveSequence: begins anew in each tick, halts what is behind.
    ("ReactiveSequence", "S S", "S:SS"),
    ("ReactiveSequence", "S F S", "F:SF-"),
    ("ReactiveSequence", "S RS", "R:SR S:SS R:SR"),
    ("ReactiveSequence", "SF RRS", "R:SR F:F- R:SR F:F-"),
    ("ReactiveSequence", "SSF RRS", "R:SR R:SR F:F- R:SR R:SR F:F-"),
    ("ReactiveSequence", "SRS RRS", "R:SR R:R- R:SR R:SR"),
    ("ReactiveSequence", "RS RS", "R:R- R:SR R:R-"),
    ("ReactiveSequence", "S RF", "R:SR F:SF"),
    ("ReactiveSequence", "K S", "S:KS"),
    ("ReactiveSequence", "K R", "R:KR"),
    ("ReactiveSequence", "K K", "K:KK"),
    # ReactiveFallback.
    ("ReactiveFallback", "F F", "F:FF"),
    ("ReactiveFallback", "F S F", "S:FS-"),
    ("ReactiveFallback", "F RF", "R:FR F:FF R:FR"),
    ("ReactiveFallback", "FS RRF", "R:FR S:S- R:FR S:S-"),
    ("ReactiveFallback", "FFS RRF", "R:FR R:FR S:S- R:FR"),
    ("ReactiveFallback", "RF RS", "R:R- R:FR R:R-"),
    ("ReactiveFallback", "F RS", "R:FR S:FS"),
    ("ReactiveFallback", "K F", "F:KF"),
    ("ReactiveFallback", "K K", "K:KK"),
    # Parallel: by default all must succeed, and one failure fails.
    ("Parallel", "S S", "S:SS"),
    ("Parallel", "S F", "F:SF"),
    ("Parallel", "F S", "F:F-"),
    ("Parallel", "S RS", "R:SR S:-S R:SR"),
    ("Parallel", "RS RRS", "R:RR R:SR S:-S"),
    ("Parallel", "RS RRF", "R:RR R:SR F:-F"),
    ("Parallel", "RRRS RF", "R:RR F:RF R:RR"),
    ("Parallel", "K S", "S:KS"),
    ("Parallel", "K K", "S:KK"),
    ("Parallel", "K R", "R:KR"),
    ('Parallel success_count="1"', "R S R", "S:RS-"),
    ('Parallel success_count="1"', "F S", "F:F-"),
    ('Parallel success_count="1" failure_count="2"', "F S", "S:FS"),
    ('Parallel success_count="2" failure_count="2"', "S F S", "S:SFS"),
    ('Parallel success_count="2" failure_count="2"', "F R F", "F:FRF"),
    ('Parallel success_count="2" failure_count="3"', "F F S", "F:FF-"),
    ('Parallel success_count="1" failure_count="-1"', "F RF R", "R:FRR R:-FR"),
    ('Parallel success_count="2" failure_count="2"', "K K R", "R:KKR"),
    ('Parallel success_count="2"', "K K", "K:KK"),
    ('Parallel success_threshold="1"', "R S", "S:RS"),
    # IfThenElse: the condition is asked once.
    ("IfThenElse", "S S F", "S:SS-"),
    ("IfThenElse", "F S F", "F:F-F"),
    ("IfThenElse", "S F", "F:SF"),
    ("IfThenElse", "F S", "F:F-"),
    ("IfThenElse", "R S F", "R:R--"),
    ("IfThenElse", "S RRS F", "R:SR- R:-R- S:-S- R:SR-"),
    ("IfThenElse", "F S RF", "R:F-R F:--F R:F-R"),
    ("IfThenElse", "RS S F", "R:R-- S:SS-"),
    ("IfThenElse", "K S F", "K:K--"),
    ("IfThenElse", "S K F", "K:SK-"),
    # WhileDoElse: the condition is asked in each tick.
    ("WhileDoElse", "S S F", "S:SS-"),
    ("WhileDoElse", "F S F", "F:F-F"),
    ("WhileDoElse", "S R F", "R:SR- R:SR-"),
    ("WhileDoElse", "SF RRS F", "R:SR- F:F-F R:SR- F:F-F"),
    ("WhileDoElse", "SF RRS RF", "R:SR- R:F-R R:SR- R:F-R"),
    ("WhileDoElse", "SSF RRF S", "R:SR- R:SR- S:F-S R:SR-"),
    ("WhileDoElse", "SF RRS", "R:SR F:F- R:SR"),
    ("WhileDoElse", "R S F", "R:R--"),
    ("WhileDoElse", "K S F", "K:K--"),
    # Decorators.
    ("Inverter", "S", "F:S"),
    ("Inverter", "F", "S:F"),
    ("Inverter", "RF", "R:R S:F"),
    ("Inverter", "K", "K:K"),
    ("ForceSuccess", "S", "S:S"),
    ("ForceSuccess", "F", "S:F"),
    ("ForceSuccess", "RF", "R:R S:F"),
    ("ForceSuccess", "K", "K:K"),
    ("ForceFailure", "S", "F:S"),
    ("ForceFailure", "F", "F:F"),
    ("ForceFailure", "RS", "R:R F:S"),
    ("ForceFailure", "K", "K:K"),
    ("KeepRunningUntilFailure", "SRSF", "R:S R:R R:S F:F R:S"),
    ("KeepRunningUntilFailure", "K", "R:K"),
    ('Repeat num_cycles="3"', "S", "S:S"),
    ('Repeat num_cycles="3"', "SF", "F:F"),
    ('Repeat num_cycles="2"', "RS", "R:R R:R S:S R:R"),
    ('Repeat num_cycles="2"', "RSRF", "R:R R:R F:F R:R"),
    ('Repeat num_cycles="0"', "S", "S:-"),
    ('Repeat num_cycles="-1"', "SSF", "R:S R:S F:F"),
    ('Repeat num_cycles="2"', "SK", "K:K S:S"),
    ('Repeat num_cycles="250"', "S", "R:S R:S S:S R:S"),
    ('RetryUntilSuccessful num_attempts="3"', "F", "F:F"),
    ('RetryUntilSuccessful num_attempts="3"', "FFS", "S:S"),
    ('RetryUntilSuccessful num_attempts="2"', "RF", "R:R R:R F:F R:R"),
    ('RetryUntilSuccessful num_attempts="0"', "S", "F:-"),
    ('RetryUntilSuccessful num_attempts="-1"', "FFS", "R:F R:F S:S"),
    ('RetryUntilSuccesful num_attempts="1"', "F", "F:F"),
    ("RunOnce", "S", "S:S K:- K:-"),
    ("RunOnce", "RF", "R:R F:F K:-"),
    ('RunOnce then_skip="false"', "RF", "R:R F:F F:-"),
    ('RunOnce then_skip="false"', "S", "S:S S:-"),
    # A tick lasts 100 ms.
    ('Delay delay_msec="300"', "S", "R:- R:- R:- S:S R:-"),
    ('Delay delay_msec="100"', "RF", "R:- R:R F:F R:-"),
    ('Delay delay_msec="0"', "F", "F:F"),
    ('Timeout msec="300"', "R", "R:R R:R R:R F:- R:R"),
    ('Timeout msec="300"', "RRS", "R:R R:R S:S R:R"),
    ('Timeout msec="0"', "R", "R:R R:R"),
    ('Timeout msec="100"', "S", "S:S"),
]


@pytest.mark.parametrize(("start", "children", "expected"), CASES)
def test_node_says_what_behavior_tree_cpp_documents(start, children, expected):
    ticks = expected.split()
    assert run(parse(start, children), len(ticks))[0] == ticks


STATES = [
    # What the node itself remembers after each tick.
    ("Sequence", "S RS F", [[1, 0], [0, 0]]),
    ("Sequence", "K RF", [[1, 1], [0, 0]]),
    ("Fallback", "F F RF", [[2, 0], [0, 0]]),
    ("SequenceWithMemory", "S FS RS", [[1, 0], [2, 0], [0, 0]]),
    ("Parallel", "S RS R", [[2, 0, 0], [2, 2, 0]]),
    ("Parallel", "RS RF R", [[0, 0, 0], [0, 0, 0]]),
    ("IfThenElse", "F S RS", [[2], [0]]),
    ('Repeat num_cycles="3"', "RS", [[0], [1], [2], [0]]),
    ('Repeat num_cycles="-1"', "S", [[0], [0]]),
    ("RunOnce", "F", [[3], [3]]),
    ('Delay delay_msec="200"', "S", [[1], [2], [0]]),
    ('Timeout msec="200"', "R", [[1], [2], [0]]),
]


@pytest.mark.parametrize(("start", "children", "expected"), STATES)
def test_node_remembers_only_what_it_needs(start, children, expected):
    tree = parse(start, children)
    own = slice(tree.root.first, tree.root.first + len(tree.root.slots))
    memories = run(tree, len(expected))[1]
    assert [memory[own] for memory in memories] == expected


HALTED = [
    ("Sequence", "<Sequence>{s}{r}</Sequence>"),
    ("Fallback", "<Fallback>{f}{r}</Fallback>"),
    ("Parallel", "<Parallel>{s}{r}</Parallel>"),
    ("IfThenElse", "<IfThenElse>{s}{r}</IfThenElse>"),
    ("WhileDoElse", "<WhileDoElse>{s}{r}</WhileDoElse>"),
    ("ReactiveSequence", "<ReactiveSequence>{s}{r}</ReactiveSequence>"),
    ("ReactiveFallback", "<ReactiveFallback>{f}{r}</ReactiveFallback>"),
    ("Inverter", "<Inverter>{r}</Inverter>"),
    ("Repeat", '<Repeat num_cycles="5">{r}</Repeat>'),
    ("Delay", '<Delay delay_msec="500">{s}</Delay>'),
    ("Timeout", '<Timeout msec="900">{r}</Timeout>'),
    ("nested", "<Sequence>{s}<Fallback>{f}{r}</Fallback></Sequence>"),
]


@pytest.mark.parametrize("name", [name for name, _ in HALTED])
def test_halting_gives_up_all_that_runs(name):
    """A reactive sequence halts a running child when its condition fails."""
    child = dict(HALTED)[name].format(
        s='<Script results="S"/>',
        f='<Script results="F"/>',
        r='<Script results="RRRRS"/>',
    )
    tree = ParseTree(
        "<root><BehaviorTree><ReactiveSequence>"
        f'<Script results="SF"/>{child}'
        "</ReactiveSequence></BehaviorTree></root>"
    )
    ticks, memories = run(tree, 2)
    assert [tick[0] for tick in ticks] == ["R", "F"]
    assert any(memories[0][2:])
    assert memories[1] == tree.initial_memory(PERSON)


def test_sequence_with_memory_keeps_its_place_when_halted():
    tree = ParseTree(
        "<root><BehaviorTree><ReactiveSequence>"
        '<Script results="SFS"/>'
        "<SequenceWithMemory>"
        '<Script results="S"/><Script results="RS"/>'
        "</SequenceWithMemory></ReactiveSequence></BehaviorTree></root>"
    )
    ticks = run(tree, 4)[0]
    # (The reactive sequence, its condition, the sequence, its two children.)
    assert ticks == ["R:SRSR", "F:F---", "R:SR-R", "S:SS-S"]


def test_subtree_says_what_its_tree_says():
    tree = ParseTree(
        '<root main_tree_to_execute="A">'
        '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>'
        '<BehaviorTree ID="B"><Script results="RSF"/></BehaviorTree></root>'
    )
    assert run(tree, 3)[0] == ["R:R", "S:S", "F:F"]


def logic_trees(depth):
    leaf = st.sampled_from(["S", "F"])
    if depth == 0:
        return leaf
    child = logic_trees(depth - 1)
    control = st.sampled_from(
        [
            "Sequence",
            "Fallback",
            "ReactiveSequence",
            "ReactiveFallback",
            "SequenceWithMemory",
        ]
    )
    return (
        leaf
        | st.tuples(control, st.lists(child, min_size=1, max_size=4))
        | st.tuples(
            st.just("Inverter"), st.lists(child, min_size=1, max_size=1)
        )
    )


def write(tree):
    if isinstance(tree, str):
        return f'<Script results="{tree}"/>'
    return f"<{tree[0]}>{''.join(map(write, tree[1]))}</{tree[0]}>"


def holds(tree):
    if isinstance(tree, str):
        return tree == "S"
    results = map(holds, tree[1])
    if tree[0] == "Inverter":
        return not next(results)
    return all(results) if "Sequence" in tree[0] else any(results)


@settings(max_examples=150, deadline=None)
@given(logic_trees(3))
def test_without_running_nodes_trees_are_logic(tree):
    """Sequence is "and", Fallback is "or", Inverter is "not"."""
    dut = ParseTree(f"<root><BehaviorTree>{write(tree)}</BehaviorTree></root>")
    memory = dut.initial_memory(PERSON)
    for _ in range(2):
        outcome = dut.tick(PERSON, memory, NOBODY, NOBODY)
        expected = Status.SUCCESS if holds(tree) else Status.FAILURE
        assert outcome.status is expected
        if "SequenceWithMemory" in str(tree):
            break
        memory = outcome.memory
