"""The commands `hunav tree show`, `check` and `convert`."""

import pytest

from hunav_drake.systems.behavior import BEHAVIORS, LoadTree, ParseTree
from hunav_drake.systems.behavior.port_words import port_entries

FORMAT_3 = """<root main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <SequenceStar name="walk"><SubTree ID="Go" who="id"/></SequenceStar>
  </BehaviorTree>
  <BehaviorTree ID="Go">
    <RegularNav agent_id="{who}"/>
  </BehaviorTree>
</root>
"""
FAULTY = "<root>\n<BehaviorTree><RegularNaw/></BehaviorTree></root>"


@pytest.fixture
def old(tmp_path):
    path = tmp_path / "old.xml"
    path.write_text(FORMAT_3)
    return path


@pytest.fixture
def faulty(tmp_path):
    path = tmp_path / "faulty.xml"
    path.write_text(FAULTY)
    return path


def test_show_draws_the_tree_and_its_memory(hunav, old):
    code, out, err = hunav("tree", "show", old)
    assert (code, err) == (0, "")
    assert "  0  →* SequenceWithMemory 'walk'" in out
    assert "  2     └─ RegularNav" in out
    assert "    1  walk: child (node 0)" in out


def test_show_tells_the_ports(hunav):
    code, out, _ = hunav("tree", "show", "curious")
    assert code == 0
    assert "CuriousNavTree" in out.splitlines()[0]
    lines = out.splitlines()
    row = next(i for i, line in enumerate(lines) if "speed_distance  " in line)
    assert lines[row].split() == ["speed_distance", "10.0", "m"]
    words = "CuriousNav: The person comes at speed at the distance"
    assert words in lines[row + 1]


@pytest.mark.parametrize("name", BEHAVIORS)
def test_each_port_of_a_behavior_is_explained(name):
    for port in port_entries(LoadTree(name)):
        assert port["help"].endswith("."), port
        assert len(port["help"]) > 20
        if port["type"] == "number":
            assert port["schema"]["x-unit"], port


def test_check_accepts_files_and_names(hunav, old):
    code, out, err = hunav("tree", "check", old, *BEHAVIORS)
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0] == f"{old}: ok (Main, 3 nodes, 4 numbers of memory)"
    assert len(lines) == 1 + len(BEHAVIORS)


def test_check_tells_the_fault_of_each_file(hunav, old, faulty, tmp_path):
    missing = tmp_path / "missing.xml"
    code, out, err = hunav("tree", "check", faulty, missing, old)
    assert code == 2
    first, _, second = err.splitlines()
    assert first.startswith(f"{faulty}:2: <RegularNaw>")
    assert "did you mean 'RegularNav'" in first
    assert str(missing) in second
    assert "ok" in out


@pytest.mark.parametrize("command", ["show", "convert"])
def test_fault_is_one_line(hunav, faulty, command):
    code, out, err = hunav("tree", command, faulty)
    assert (code, out) == (2, "")
    fault, *hint = err.splitlines()
    assert fault.startswith(f"hunav: {faulty}:2: ")
    assert hint == ["hunav: import your own parts with --import FILE"]


def test_convert_prints_format_4(hunav, old):
    code, out, _ = hunav("tree", "convert", old)
    assert code == 0
    assert 'BTCPP_format="4"' in out
    assert "<SequenceWithMemory" in out
    assert 'who="{id}"' in out
    assert ParseTree(out).slots == LoadTree(old).slots


def test_convert_writes_a_file_and_not_over_another(hunav, old, tmp_path):
    new = tmp_path / "new.xml"
    code, out, _ = hunav("tree", "convert", old, "-o", new)
    assert (code, out) == (0, f"Wrote {new}\n")
    assert LoadTree(new).slots == LoadTree(old).slots
    code, _, err = hunav("tree", "convert", old, "--output", new)
    assert code == 2
    assert "--force" in err
    assert hunav("tree", "convert", "curious", "-o", new, "--force")[0] == 0
    assert LoadTree(new).name == "CuriousNavTree"


def test_convert_to_a_place_that_is_not_there(hunav, old, tmp_path):
    code, _, err = hunav("tree", "convert", old, "-o", tmp_path / "a" / "b.xml")
    assert code == 2
    assert "there is no folder" in err


def test_tree_needs_a_command(hunav):
    with pytest.raises(SystemExit) as caught:
        hunav("tree")
    assert caught.value.code == 2
