"""Whatever the bytes, loading gives a tree or a BehaviorTreeError."""

from functools import partial
from pathlib import Path
import re

from hypothesis import example, given, strategies as st
import numpy as np

from hunav_drake.systems.behavior import (
    BEHAVIORS,
    NODE_TYPES,
    BehaviorTreeError,
    ParseTree,
    WriteTree,
)
from tests.systems.behavior.ticks import ME, PERSON, ROBOT

# A tree with all constructs, and the shipped ones with what they include in
# them: a text has no folder to include from.
RICH = """<root main_tree_to_execute="A">
<BehaviorTree ID="A"><Fallback name="do it">
<Sequence _skipIf="mode == 'bold'" _onSuccess="mode := 'bold'; n := 1">
<IsRobotVisible agent_id="{id}" distance="3"/>
<SequenceStar><RegularNav robot="obstacle"/>
<Delay delay_msec="500"><AlwaysSuccess/></Delay></SequenceStar></Sequence>
<Switch2 variable="{mode}" case_1="shy" case_2="bold"><AlwaysSuccess/>
<SubTree ID="B" k="mode"/><Repeat num_cycles="3"><AlwaysFailure/></Repeat>
</Switch2><Parallel success_threshold="1"><UpdateGoal _while="n &lt; 3"/>
</Parallel></Fallback></BehaviorTree>
<BehaviorTree ID="B"><Sequence><SetBlackboard output_key="k" value="shy"/>
<RegularNav/></Sequence></BehaviorTree></root>"""


TREES = BEHAVIORS["regular"].parent
INCLUDE = re.compile(r'<include path="(.*?)"/>')
PARTS = re.compile(r"<include .*?/>|<BehaviorTree.*?</BehaviorTree>", re.DOTALL)


def shipped():
    """Returns the shipped files, each with the files that it includes."""
    result = [RICH.encode()]
    for path in BEHAVIORS.values():
        text, found = path.read_text(), set()
        while include := INCLUDE.search(text):
            name = include[1]
            other = "" if name in found else (TREES / name).read_text()
            found.add(name)
            parts = PARTS.findall(other)
            text = text.replace(include[0], "".join(parts), 1)
        result.append(text.encode())
    return result


SOURCES = shipped()
WORDS = [
    *[name.encode() for name in NODE_TYPES],
    *b'< > / = " {id} {mode} -1 1e9 inf nan true <!-- --> &lt; &#0;'.split(),
    b"<SubTree ID='A'/>",
    b"<![CDATA[",
    b"<!DOCTYPE r [<!ENTITY a 'b'>]>",
    b"_while=",
    b"\xff\xfe",
    b"\x00",
]


def attempt(function):
    """Returns what a function gives, or the error that is allowed."""
    try:
        return function(), None
    except BehaviorTreeError as error:
        return None, error


def check(source):
    dut, fault = attempt(lambda: ParseTree(source))
    if dut is None:
        # (A subtree that is not in it is that of the package.)
        file = fault.place.file
        assert file == "<text>" or Path(file).parent == TREES
        assert str(fault).startswith(file)
        return None
    memory = dut.initial_memory(PERSON)
    assert len(dut.Describe().splitlines()) >= len(dut.nodes) + len(dut.slots)
    for _ in range(3):
        outcome, fault = attempt(partial(dut.tick, PERSON, memory, ME, ROBOT))
        if outcome is None:
            # An entry is not set, or out of the range of its port.
            assert "{" in str(fault)
            break
        assert len(outcome.memory) == len(memory) == len(dut.slots)
        assert np.all(np.isfinite(outcome.command))
        assert not np.any(np.isnan(outcome.memory))
        memory = outcome.memory
    return dut


@given(st.binary(max_size=200) | st.text(max_size=200).map(str.encode))
def test_any_bytes(source):
    check(source)


@given(st.text(alphabet="<>/=\"' ab{}&;!-?[]xID", max_size=80))
def test_any_markup(text):
    check(f"<root><BehaviorTree>{text}</BehaviorTree></root>".encode())


@st.composite
def mutated(draw):
    source = draw(st.sampled_from(SOURCES))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(source)))
        end = min(len(source), start + draw(st.integers(0, 40)))
        middle = draw(
            st.sampled_from(WORDS) | st.just(b"") | st.binary(max_size=4)
        )
        source = source[:start] + middle + source[end:]
    return source


@given(mutated())
def test_mutated_files(source):
    check(source)


VALUES = re.compile(rb'(?<==")[^"]*(?=")')


@st.composite
def other_values(draw):
    """Returns a file in which an attribute has another value."""
    source = draw(st.sampled_from(SOURCES))
    match = draw(st.sampled_from(list(VALUES.finditer(source))))
    value = draw(
        st.sampled_from([b"", b"-1", b"1e9", b"{id}", b"{k}", b"0", b"A"])
        | st.sampled_from(VALUES.findall(source))
        | st.text("a0.{}'=!&|():; ", max_size=8).map(
            lambda text: text.replace("&", "&amp;").encode()
        )
    )
    return source[: match.start()] + value + source[match.end() :]


@given(other_values())
@example(SOURCES[0])
def test_other_values(source):
    dut = check(source)
    if dut is not None:
        written = WriteTree(dut)
        assert WriteTree(ParseTree(written)) == written
