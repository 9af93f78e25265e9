"""The status and the memory of each node, for each status of its children.

A child is written as the results of its ticks, one letter each: (S)uccess,
(F)ailure, (R)unning, s(K)ipped; after the last it starts over, and so it does
when it is halted while it runs. An expected tick is the result of the node, a
colon, what each child said in that tick, "-" if it was not ticked, and, after
a slash, what the node remembers for the next tick.
"""

from hypothesis import given, strategies as st
import pytest

from hunav_drake.systems.behavior import NodeStatus, ParseTree
from hunav_drake.systems.behavior.nodes import registry
from hunav_drake.systems.behavior.nodes.node import NodeType
from hunav_drake.systems.behavior.nodes.operations import PYTHON, Operation
from hunav_drake.systems.behavior.nodes.port import Port
from hunav_drake.systems.behavior.nodes.program import RUNNING_SLOT
from tests.systems.behavior.ticks import ME, PERSON, as_xml, traces, tree_of

LETTERS = {
    "S": NodeStatus.SUCCESS,
    "F": NodeStatus.FAILURE,
    "R": NodeStatus.RUNNING,
    "K": NodeStatus.SKIPPED,
    "-": NodeStatus.IDLE,
}
NAMES = {status: letter for letter, status in LETTERS.items()}


def build_script(node):
    results = node.constant("results")
    slot = node.first + 1

    def tick(context, memory):
        at = int(memory[slot])
        memory[slot] = float((at + 1) % len(results))
        return LETTERS[results[at]]

    return tick


@pytest.fixture(autouse=True)
def script(node_types):
    node_types["Script"] = NodeType(
        "Script",
        "Action",
        Operation(PYTHON),
        "Says what is written.",
        ports={"results": Port("results", str)},
        slots={RUNNING_SLOT: 0.0, "at": 0.0},
        build=build_script,
    )


def parse_scripts(start, children):
    tag = start.split()[0]
    scripts = "".join(f'<Script results="{c}"/>' for c in children.split())
    return tree_of(f"<{start}>{scripts}</{tag}>")


def run_ticks(tree, count):
    """Returns the ticks, and the memory after each."""
    ticks, memories = [], []
    for outcome, statuses in traces(tree, count):
        text = "".join(NAMES[status] for status in statuses)
        ticks.append(f"{text[0]}:{text[1:]}")
        memories.append(outcome.memory)
    return ticks, memories


CASES = [
    # Sequence: resumes at the running child, starts over after a failure.
    ("Sequence", "S", "S:S/0,0 S:S/0,0"),
    ("Sequence", "F", "F:F/0,0 F:F/0,0"),
    ("Sequence", "S S S", "S:SSS/0,0"),
    ("Sequence", "S F S", "F:SF-/0,0 F:SF-/0,0"),
    ("Sequence", "F S", "F:F-/0,0"),
    ("Sequence", "R S", "R:R-/0,0 R:R-/0,0"),
    ("Sequence", "S RS S", "R:SR-/1,0 S:-SS/0,0 R:SR-/1,0"),
    ("Sequence", "S RF S", "R:SR-/1,0 F:-F-/0,0 R:SR-/1,0"),
    ("Sequence", "S RRS F", "R:SR-/1,0 R:-R-/1,0 F:-SF/0,0 R:SR-/1,0"),
    ("Sequence", "SF RS", "R:SR/1,0 S:-S/0,0 F:F-/0,0"),
    ("Sequence", "K S", "S:KS/0,0"),
    ("Sequence", "K F", "F:KF/0,0"),
    ("Sequence", "K K", "K:KK/0,0 K:KK/0,0"),
    ("Sequence", "K RK K", "R:KR-/1,1 K:-KK/0,0"),
    ("Sequence", "S RK K", "R:SR-/1,0 S:-KK/0,0"),
    ("Sequence", "K R", "R:KR/1,1 R:-R/1,1"),
    # Fallback: the same with success and failure exchanged.
    ("Fallback", "S", "S:S/0,0"),
    ("Fallback", "F", "F:F/0,0"),
    ("Fallback", "F F F", "F:FFF/0,0"),
    ("Fallback", "F S F", "S:FS-/0,0 S:FS-/0,0"),
    ("Fallback", "S F", "S:S-/0,0"),
    ("Fallback", "R F", "R:R-/0,0"),
    ("Fallback", "F RS F", "R:FR-/1,0 S:-S-/0,0 R:FR-/1,0"),
    ("Fallback", "F RF S", "R:FR-/1,0 S:-FS/0,0"),
    ("Fallback", "F RF F", "R:FR-/1,0 F:-FF/0,0 R:FR-/1,0"),
    ("Fallback", "FS RF", "R:FR/1,0 F:-F/0,0 S:S-/0,0"),
    ("Fallback", "K F", "F:KF/0,0"),
    ("Fallback", "K S", "S:KS/0,0"),
    ("Fallback", "K K", "K:KK/0,0"),
    ("Fallback", "K RK K", "R:KR-/1,1 K:-KK/0,0"),
    # SequenceWithMemory: does not repeat what succeeded before a failure.
    ("SequenceWithMemory", "S S", "S:SS/0,0 S:SS/0,0"),
    ("SequenceWithMemory", "S FS S", "F:SF-/1,0 S:-SS/0,0 F:SF-/1,0"),
    ("SequenceWithMemory", "S FFS S", "F:SF-/1,0 F:-F-/1,0 S:-SS/0,0"),
    ("SequenceWithMemory", "S RFS S", "R:SR-/1,0 F:-F-/1,0 S:-SS/0,0"),
    ("SequenceWithMemory", "S RS F", "R:SR-/1,0 F:-SF/2,0 F:--F/2,0"),
    ("SequenceWithMemory", "K K", "K:KK/0,0"),
    ("SequenceWithMemory", "K FK", "F:KF/1,0 S:-K/0,0"),
    ("SequenceStar", "S FS S", "F:SF-/1,0 S:-SS/0,0"),
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
    ("Parallel", "S S", "S:SS/0,0"),
    ("Parallel", "S F", "F:SF/0,0"),
    ("Parallel", "F S", "F:F-/0,0"),
    ("Parallel", "S RS", "R:SR/2,0 S:-S/0,0 R:SR/2,0"),
    ("Parallel", "RS RRS", "R:RR/0,0 R:SR/2,0 S:-S/0,0"),
    ("Parallel", "RS RRF", "R:RR/0,0 R:SR/2,0 F:-F/0,0"),
    ("Parallel", "RRRS RF", "R:RR/0,0 F:RF/0,0 R:RR/0,0"),
    ("Parallel", "K S", "S:KS/0,0"),
    ("Parallel", "K K", "S:KK/0,0"),
    ("Parallel", "K R", "R:KR/0,0"),
    ('Parallel success_count="1"', "R S R", "S:RS-/0,0,0"),
    ('Parallel success_count="1"', "F S", "F:F-/0,0"),
    ('Parallel success_count="1" failure_count="2"', "F S", "S:FS/0,0"),
    ('Parallel success_count="2" failure_count="2"', "S F S", "S:SFS/0,0,0"),
    ('Parallel success_count="2" failure_count="2"', "F R F", "F:FRF/0,0,0"),
    ('Parallel success_count="2" failure_count="3"', "F F S", "F:FF-/0,0,0"),
    (
        'Parallel success_count="1" failure_count="-1"',
        "F RF R",
        "R:FRR/3,0,0 R:-FR/3,3,0",
    ),
    ('Parallel success_count="2" failure_count="2"', "K K R", "R:KKR/0,0,0"),
    ('Parallel success_count="2"', "K K", "K:KK/0,0"),
    ('Parallel success_threshold="1"', "R S", "S:RS/0,0"),
    # IfThenElse: the condition is asked once.
    ("IfThenElse", "S S F", "S:SS-/0"),
    ("IfThenElse", "F S F", "F:F-F/0"),
    ("IfThenElse", "S F", "F:SF/0"),
    ("IfThenElse", "F S", "F:F-/0"),
    ("IfThenElse", "R S F", "R:R--/0"),
    ("IfThenElse", "S RRS F", "R:SR-/1 R:-R-/1 S:-S-/0 R:SR-/1"),
    ("IfThenElse", "F S RF", "R:F-R/2 F:--F/0 R:F-R/2"),
    ("IfThenElse", "RS S F", "R:R--/0 S:SS-/0"),
    ("IfThenElse", "K S F", "K:K--/0"),
    ("IfThenElse", "S K F", "K:SK-/0"),
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
    ('Repeat num_cycles="3"', "S", "S:S/0"),
    ('Repeat num_cycles="3"', "SF", "F:F/0"),
    ('Repeat num_cycles="2"', "RS", "R:R/0 R:R/1 S:S/0 R:R/0"),
    ('Repeat num_cycles="2"', "RSRF", "R:R/0 R:R/1 F:F/0 R:R/0"),
    ('Repeat num_cycles="0"', "S", "S:-/0"),
    ('Repeat num_cycles="-1"', "SSF", "R:S/0 R:S/0 F:F/0"),
    ('Repeat num_cycles="2"', "SK", "K:K/1 S:S/0"),
    ('Repeat num_cycles="250"', "S", "R:S/100 R:S/200 S:S/0 R:S/100"),
    ('RetryUntilSuccessful num_attempts="3"', "F", "F:F/0"),
    ('RetryUntilSuccessful num_attempts="3"', "FFS", "S:S/0"),
    ('RetryUntilSuccessful num_attempts="2"', "RF", "R:R/0 R:R/1 F:F/0 R:R/0"),
    ('RetryUntilSuccessful num_attempts="0"', "S", "F:-/0"),
    ('RetryUntilSuccessful num_attempts="-1"', "FFS", "R:F/0 R:F/0 S:S/0"),
    ('RetryUntilSuccesful num_attempts="1"', "F", "F:F/0"),
    ("RunOnce", "S", "S:S/2 K:-/2 K:-/2"),
    ("RunOnce", "RF", "R:R/0 F:F/3 K:-/3"),
    ('RunOnce then_skip="false"', "RF", "R:R/0 F:F/3 F:-/3"),
    ('RunOnce then_skip="false"', "S", "S:S/2 S:-/2"),
    # A tick lasts 100 ms.
    ('Delay delay_msec="300"', "S", "R:-/1 R:-/2 R:-/3 S:S/0 R:-/1"),
    ('Delay delay_msec="100"', "RF", "R:-/1 R:R/1 F:F/0 R:-/1"),
    ('Delay delay_msec="0"', "F", "F:F/0"),
    ('Timeout msec="300"', "R", "R:R/1 R:R/2 R:R/3 F:-/0 R:R/1"),
    ('Timeout msec="300"', "RRS", "R:R/1 R:R/2 S:S/0 R:R/1"),
    ('Timeout msec="0"', "R", "R:R/0 R:R/0"),
    ('Timeout msec="100"', "S", "S:S/0"),
    # The decorator of HuNavSim 2, and one of ours.
    ('TimeDelay delay="0.3"', "S", "F:-/1 F:-/2 F:-/3 S:S/3 S:S/3"),
    (
        'TimeDelay delay="0.2" again="true"',
        "RS",
        "F:-/1 F:-/2 R:R/2 S:S/0 F:-/1",
    ),
    ('Cooldown seconds="0.2"', "S", "S:S/2,0 F:-/1,0 F:-/0,0 S:S/2,0"),
    (
        'Cooldown seconds="0.15"',
        "RF",
        "R:R/0,1 F:F/2,0 F:-/1,0 F:-/0,0 R:R/0,1",
    ),
    ('Cooldown seconds="0.2"', "FFS", "F:F/0,0 F:F/0,0 S:S/2,0 F:-/1,0"),
    ('Satisfies need="rest" amount="5"', "RSFK", "R:R S:S F:F K:K"),
    # Switch: ticks the child of the case, or the last one.
    ('Switch2 variable="a" case_1="a" case_2="b"', "S F R", "S:S--/0"),
    ('Switch2 variable="b" case_1="a" case_2="b"', "S F R", "F:-F-/0"),
    ('Switch2 variable="c" case_1="a" case_2="b"', "S F R", "R:--R/3 R:--R/3"),
    ('Switch2 variable="a" case_1="a" case_2="a"', "S F F", "S:S--/0"),
    (
        'Switch2 variable="a" case_1="a" case_2="b"',
        "RRS F F",
        "R:R--/1 R:R--/1 S:S--/0 R:R--/1",
    ),
    ('Switch2 variable="b" case_1="a" case_2="b"', "S RF S", "R:-R-/2 F:-F-/0"),
    ('Switch2 variable="a" case_1="a" case_2="b"', "K F S", "K:K--/0"),
    ('Switch2 variable="2.0" case_1="1" case_2="2"', "S F S", "F:-F-/0"),
    ('Switch2 variable="true" case_1="0" case_2="1"', "S F S", "F:-F-/0"),
    (
        'Switch3 variable="3" case_1="1" case_2="2" case_3="3"',
        "S S F S",
        "F:--F-/0",
    ),
    (
        'Switch3 variable="x" case_1="1" case_2="2" case_3="3"',
        "S S S F",
        "F:---F/0",
    ),
    (
        'Switch4 variable="d" case_1="a" case_2="b" case_3="c" case_4="d"',
        "S S S RF S",
        "R:---R-/4 F:---F-/0",
    ),
    (
        'Switch5 variable="1" case_1="5" case_2="4" case_3="3" case_4="2"'
        ' case_5="1"',
        "S S S S F S",
        "F:----F-/0",
    ),
    (
        'Switch6 variable="7" case_1="1" case_2="2" case_3="3" case_4="4"'
        ' case_5="5" case_6="6"',
        "S S S S S S RF",
        "R:------R/7 F:------F/0",
    ),
    # The actions of the language.
    ("AlwaysSuccess", "", "S: S:"),
    ("AlwaysFailure", "", "F: F:"),
    ('SetBlackboard output_key="a" value="1"', "", "S: S:"),
    ('SetBlackboard output_key="a" value="{a}"', "", "F: F:"),
    ('SetBlackboard output_key="a" value="{id}"', "", "S: S:"),
    # Further combinations.
    ("RunOnce", "K", "K:K/0 K:K/0"),
    ("RunOnce", "SF", "S:S/2 K:-/2 K:-/2"),
    ("ForceSuccess", "RK", "R:R K:K"),
    ("Parallel", "S RF", "R:SR/2,0 F:-F/0,0 R:SR/2,0"),
    ("SequenceWithMemory", "RS S", "R:R-/0,0 S:SS/0,0"),
    ("SequenceWithMemory", "SF RFS", "R:SR/1,0 F:-F/1,0 S:-S/0,0 F:F-/0,0"),
    ("SequenceWithMemory", "S K FS", "F:SKF/2,0 S:--S/0,0"),
    ('Delay delay_msec="200"', "KS", "R:-/1 R:-/2 K:K/2 S:S/0"),
    ('Timeout msec="200"', "RKS", "R:R/1 K:K/1 S:S/0"),
    ("KeepRunningUntilFailure", "RF", "R:R F:F"),
    ("Inverter", "RS", "R:R F:S"),
    ("Sequence", "S RS F", "R:SR-/1,0 F:-SF/0,0"),
    ("Sequence", "K RF", "R:KR/1,1 F:-F/0,0"),
    ("Fallback", "F F RF", "R:FFR/2,0 F:--F/0,0"),
    ("SequenceWithMemory", "S FS RS", "F:SF-/1,0 R:-SR/2,0 S:--S/0,0"),
    ("Parallel", "S RS R", "R:SRR/2,0,0 R:-SR/2,2,0"),
    ("Parallel", "RS RF R", "R:RRR/0,0,0 F:SF-/0,0,0"),
    ("IfThenElse", "F S RS", "R:F-R/2 S:--S/0"),
    ('Repeat num_cycles="3"', "RS", "R:R/0 R:R/1 R:R/2 S:S/0"),
    ('Repeat num_cycles="-1"', "S", "R:S/0 R:S/0"),
    ("RunOnce", "F", "F:F/3 K:-/3"),
    ('Delay delay_msec="200"', "S", "R:-/1 R:-/2 S:S/0"),
    ('Timeout msec="200"', "R", "R:R/1 R:R/2 F:-/0"),
]


@pytest.mark.parametrize(("start", "children", "expected"), CASES)
def test_node_says_and_remembers_what_behavior_tree_cpp_does(
    start, children, expected
):
    tree = parse_scripts(start, children)
    own = slice(tree.root.first, tree.root.first + len(tree.root.slots))
    rows = expected.split()
    ticks, memories = run_ticks(tree, len(rows))
    told = []
    for tick, memory in zip(ticks, memories, strict=True):
        numbers = ",".join(f"{number:g}" for number in memory[own])
        told.append(f"{tick}/{numbers}" if numbers else tick)
    assert told == rows


def test_table_has_every_node_of_the_language():
    tested = {start.split()[0] for start, _, _ in CASES}
    tested = {registry.ALIASES.get(name, name) for name in tested}
    language = {t.name for t in registry.NODE_TYPES.values() if not t.source}
    # (The children of NeedsSelector are no scripts.)
    assert language - {"Script", "NeedsSelector"} <= tested
    assert len(CASES) >= 150


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
    ticks, memories = run_ticks(tree, 2)
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
    ticks = run_ticks(tree, 4)[0]
    # (The reactive sequence, its condition, the sequence, its two children.)
    assert ticks == ["R:SRSR", "F:F---", "R:SR-R", "S:SS-S"]


def test_subtree_says_what_its_tree_says():
    tree = ParseTree(
        '<root main_tree_to_execute="A">'
        '<BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>'
        '<BehaviorTree ID="B"><Script results="RSF"/></BehaviorTree></root>'
    )
    assert run_ticks(tree, 3)[0] == ["R:R", "S:S", "F:F"]


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


def holds(tree):
    if isinstance(tree, str):
        return tree == "S"
    results = map(holds, tree[1])
    if tree[0] == "Inverter":
        return not next(results)
    return all(results) if "Sequence" in tree[0] else any(results)


@given(logic_trees(3))
def test_without_running_nodes_trees_are_logic(tree):
    """Sequence is "and", Fallback is "or", Inverter is "not"."""
    dut = tree_of(as_xml(tree, "Script"))
    memory = dut.initial_memory(PERSON)
    for _ in range(2):
        outcome = dut.tick(PERSON, memory, ME, ME)
        expected = NodeStatus.SUCCESS if holds(tree) else NodeStatus.FAILURE
        assert outcome.node_status is expected
        if "SequenceWithMemory" in str(tree):
            break
        memory = outcome.memory


def as_mixed_xml(tree, in_python):
    """Returns logic in XML, some of whose leaves are in Python."""
    if isinstance(tree, str):
        compiled = {"S": "<AlwaysSuccess/>", "F": "<AlwaysFailure/>"}
        next_one = in_python.pop() if in_python else False
        return f'<Script results="{tree}"/>' if next_one else compiled[tree]
    tag, children = tree
    inner = "".join(as_mixed_xml(child, in_python) for child in children)
    return f"<{tag}>{inner}</{tag}>"


@given(logic_trees(3), st.lists(st.booleans(), max_size=30))
def test_leaves_in_python_interrupt_the_walk_and_change_nothing(tree, drawn):
    told = []
    for in_python in ([], list(drawn)):
        dut = tree_of(as_mixed_xml(tree, in_python))
        told.append([statuses for _, statuses in traces(dut, 3)])
    assert told[0] == told[1]
