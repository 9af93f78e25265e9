"""YAML text as plain data, with lines."""

import math
import os

import pytest
import yaml

from hunav_drake.scenario import yaml_source
from hunav_drake.scenario.yaml_source import MAX_BYTES, parse_yaml, read_yaml

TEXTS = """
yes no on off y n 1:30 2026-01-31 0x1F 0o17 010 1_000 1.2.3 1e inf nan truE .e1
+ 1,5 =
"""


def read_plain(text):
    document = parse_yaml(text, name="text")
    assert document.findings == []
    return document.plain()


def complaint(text):
    """The line and message of the one thing that is wrong."""
    document = parse_yaml(text, name="text")
    ((line, finding),) = document.findings
    return line, finding.message


@pytest.fixture(params=["C", "Python"])
def loader(request, monkeypatch):
    """Both parsers of PyYAML must be read alike."""
    if request.param == "Python":
        monkeypatch.setattr(yaml_source, "_Loader", yaml.SafeLoader)
    elif not hasattr(yaml, "CSafeLoader"):
        pytest.skip("this PyYAML is built without LibYAML")


@pytest.mark.parametrize(
    ("word", "value"),
    [
        ("1", 1),
        ("-12", -12),
        ("+3", 3),
        ("0", 0),
        ("1e3", 1000.0),
        ("1e-3", 0.001),
        ("-1.5E+2", -150.0),
        (".5", 0.5),
        ("2.", 2.0),
        (".inf", math.inf),
        ("-.inf", -math.inf),
        ("true", True),
        ("False", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("9" * 30, int("9" * 30)),
        ("9" * 400, math.inf),
    ],
)
def test_words_for_numbers_flags_and_nothing(loader, word, value):
    (got,) = read_plain(f"- {word}")
    assert got == value
    assert type(got) is type(value)


def test_nan_is_a_number(loader):
    (got,) = read_plain("- .nan")
    assert math.isnan(got)


@pytest.mark.parametrize("word", TEXTS.split())
def test_all_other_words_are_text(loader, word):
    assert read_plain(f"a: {word}") == {"a": word}


@pytest.mark.parametrize("text", ["'1'", '"1"', "!!str 1", "! 1", "|-\n  1"])
def test_quoted_numbers_are_text(loader, text):
    assert read_plain(f"a: {text}") == {"a": "1"}


def test_long_runs_of_digits_take_no_time(loader):
    assert read_plain("a: " + "1" * 10**6) == {"a": "1" * 10**6}


def test_every_part_knows_its_line(loader):
    document = parse_yaml(
        "# a comment\n\na:\n  - b: 1\n    c:\n      d: 2\n  - 3\n", name="x"
    )
    assert document.line(("a",)) == 3
    assert document.line(("a", 0)) == 4
    assert document.line(("a", 0, "c")) == 5
    assert document.line(("a", 0, "c", "d")) == 6
    assert document.line(("a", 1)) == 7


def test_what_is_not_there_has_the_line_around_it():
    document = parse_yaml("a:\n  - b: 1\n  - c: 2\n", name="x")
    assert document.line(("a", 1, "missing", 3)) == 3
    assert document.line(("missing",)) == 1
    assert document.plain(("a", 5)) is None
    assert document.plain(("a", "b")) is None


def test_an_alias_is_a_copy_of_its_own():
    a, b = read_plain("[&x {k: [1]}, *x]")
    a["k"].append(2)
    assert b == {"k": [1]}


def test_an_alias_has_the_line_where_it_stands(loader):
    document = parse_yaml("a: &x\n  k: 1\nb: *x\n", name="x")
    assert document.line(("b",)) == 3
    assert document.line(("b", "k")) == 2


def test_merged_keys_yield_to_given_ones_and_to_earlier_ones(loader):
    data = read_plain(
        "- &a {x: 1, y: 1}\n- &b {y: 2, z: 2}\n- {<<: [*a, *b], x: 0}\n"
        "- {<<: *b}\n- {'<<': 5}\n"
    )
    assert data[2:] == [{"x": 0, "y": 1, "z": 2}, {"y": 2, "z": 2}, {"<<": 5}]


def test_a_byte_order_mark_is_no_text():
    assert read_plain(b"\xef\xbb\xbfa: 1") == {"a": 1}


def test_line_ends_of_windows(loader):
    document = parse_yaml(b"a: 1\r\nb: 2\r\n", name="x")
    assert document.plain() == {"a": 1, "b": 2}
    assert document.line(("b",)) == 2


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", 0, "is empty"),
        ("# nothing\n", 0, "is empty"),
        ("a: 1\nb: 2\na: 3", 3, "is given twice, first in line 1"),
        ("1: a", 1, "a key must be text, got 1"),
        ("true: a", 1, "a key must be text, got true"),
        ("? [a, b]\n: 1", 1, "a key must be text, got a list of 2"),
        ("a: !x 1", 1, "unknown tag '!x'"),
        ("a: !!python/name:os.system x", 1, "unknown tag '!!python/name"),
        ("a: !!binary x", 1, "unknown tag '!!binary'"),
        ("a: !!map [1]", 1, "unknown tag '!!map'"),
        ("a: 1\nb: *c", 2, "there is no anchor 'c'"),
        ("&a [*a]", 1, "the anchor 'a' contains itself"),
        ("&a {b: [*a]}", 1, "the anchor 'a' contains itself"),
        ("<<: 5", 1, "'<<' must be followed by a mapping"),
        ("a: 1\n---\nb: 1\n", 2, "holds a second document"),
        ("a: [1, 2", 1, "is not YAML"),
        ("a:\n\tb: 1", 2, "indent with spaces"),
        ("a: 1\nb: \x07", 2, "character U+0007 at offset 8"),
        (b"a: 1\nb: \xff", 2, "byte 0xff at offset 8"),
        (b"a: 1\n\x00", 2, "character U+0000 at offset 5"),
        ("a: \ud800", 1, "character U+D800"),
        ("[" * 51, 1, "nests deeper than 50 levels"),
        ("[" * 100_000, 1, "nests deeper than 50 levels"),
        ("- " * 100_000, 1, "nests deeper than 50 levels"),
        ("{a: " * 100_000, 1, "nests deeper than 50 levels"),
        pytest.param(
            *("[" + "1," * 200_000 + "]", 1),
            "unfolds to more than 200000 parts",
            marks=pytest.mark.slow,
        ),
        ("%TAG !a! b\n" * 50 + "--- {}", 1, "10 YAML directives"),
        ("a" * (MAX_BYTES + 1), 0, "is too large"),
    ],
    ids=lambda value: repr(value)[:30],
)
def test_what_is_wrong_is_told_with_its_line(loader, text, line, words):
    got_line, message = complaint(text)
    assert words in message
    # LibYAML and PyYAML differ on where an unclosed list ends.
    assert got_line == line or "is not YAML" in message


def test_nesting_through_aliases_counts():
    text = "- &a0 [1]\n" + "".join(
        f"- &a{i} [*a{i - 1}]\n" for i in range(1, 100)
    )
    line, message = complaint(text)
    assert message == "nests deeper than 50 levels"
    assert 45 < line < 52


def test_anchors_cannot_unfold_without_end(loader):
    text = "- &a0 [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
        f"- &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 40)
    )
    assert complaint(text)[1] == "unfolds to more than 200000 parts"


def test_the_deepest_allowed_nesting_is_read():
    assert read_plain("[" * 50 + "]" * 50) is not None


def test_several_findings_come_together():
    document = parse_yaml("a: 1\na: 2\n1: 3\nb: !x 4\n", name="x")
    assert [line for line, _ in document.findings] == [2, 3, 4]


def test_files_that_are_none(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path, words in [
        (tmp_path, "is a directory"),
        (pipe, "is not a regular file"),
        ("/dev/zero", "is not a regular file"),
        (tmp_path / "none", "No such file"),
        ("a\0b", "cannot be read"),
        ("x" * 5000, "cannot be read"),
    ]:
        document = read_yaml(path)
        assert document.root is None
        ((_, finding),) = document.findings
        assert words in finding.message
