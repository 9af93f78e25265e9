"""The text of a scenario follows its data, and keeps what did not change."""

import copy
import random

from hypothesis import given, strategies as st
import pytest

from hunav_drake.editor.document.plain_data import apply, same
from hunav_drake.editor.document.text_patch import inverse, patched
from hunav_drake.editor.document.yaml_patch import patch_yaml
from hunav_drake.scenario.yaml_source import parse_yaml

# As somebody may write it: every kind of spacing, quotes and comments.
TEXT = """\
# A scenario of somebody.
name: 'first'   # its name

description: >-
  Some words
  in two lines.

world:
    walls:
    # the north
    - type: box     # a box
      center: [ 1, 2.50 ]
      size: [3.0,0.2]

    # the south
    - {type: box, center: [1, -2],  size: [3, .2]}  # short
    -
      type: polyline
      points: [[0, 0],
               [1, 1],   # a corner
               [2, 0]]
humans:

  # Ana walks.
  - name: ana
    pose: [0, 0, 0]      # at the door
    # Where to:
    goals:
      # first
      - [5, 6.0]
      - [ 7,8 ]   # last
    behavior: {type: curious, distance: 6.0}
    # (no more of ana)

  # Ben stands.
  - name: ben
    pose: [1e1, 2, 0]
    desired_speed: 0
    note: |
      A text
        of lines

    goals: []
  - pose:
      - 3
      - 4
      - 0   # yaw
empty:
planner: pursuit
"""

ANCHORS = """\
base: &base   # shared
  radius: 0.3
  forces: &forces {goal: 2.0}
humans:
  - <<: *base
    pose: [0, 0, 0]
  # second
  - pose: [1, 1, 0]
    radius: 0.2
    forces: *forces
"""

# Texts that YAML could take for something else.
_TEXTS = [
    *("a", "1e3", "null", "", " x", "a: b", "# c", "[x", "y, z", "-", "<<"),
    *("two\nlines", "  in\n text\n\n", "'", '"', "1:30", "~", ".inf", "%"),
    *("*a", "&b", "!c", "x #y", "\t", "é\u2028x", "?", "😀"),
]
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**12), 10**12),
    st.floats(allow_nan=True),
    st.sampled_from(_TEXTS),
    st.text(max_size=8),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["shape", "points", "a b", "1", "é: x", "<<"]),
            inner,
            max_size=3,
        )
    ),
    max_leaves=6,
)


def paths(data, loc=()):
    """Yields the paths of all parts."""
    yield loc
    items = ()
    if isinstance(data, dict):
        items = data.items()
    elif isinstance(data, list):
        items = enumerate(data)
    for key, item in items:
        yield from paths(item, (*loc, key))


@st.composite
def operations(draw, data):
    """Draws operations that fit the data."""
    result = []
    for _ in range(draw(st.integers(1, 3))):
        path = draw(st.sampled_from(list(paths(data))))
        part = data
        for step in path:
            part = part[step]
        kinds = ["set"]
        if path:
            kinds.append("remove")
        if isinstance(part, list):
            kinds += ["insert", "insert", "move"]
        if isinstance(part, dict):
            kinds += ["add", "add"]
        kind = draw(st.sampled_from(kinds))
        if kind == "move" and len(part) > 1:
            i = draw(st.integers(0, len(part) - 1))
            k = draw(st.integers(0, len(part) - 1))
            ops = [("remove", (*path, i)), ("insert", (*path, k), part[i])]
        elif kind in ("insert", "move"):
            i = draw(st.integers(0, len(part)))
            ops = [("insert", (*path, i), draw(VALUES))]
        elif kind == "add":
            key = draw(st.sampled_from(["goals", "x", "1e3", "a b", "<<"]))
            ops = [("set", (*path, key), draw(VALUES))]
        elif kind == "remove":
            ops = [("remove", path)]
        else:
            value = draw(VALUES)
            if not path:
                value = {"name": value}
            ops = [("set", path, value)]
        data = apply(data, ops)
        result += ops
    return result


@given(st.data(), st.sampled_from([TEXT, ANCHORS]), st.booleans())
def test_patched_text_reads_as_the_data(data, text, dos):
    if dos:
        text = text.replace("\n", "\r\n")
    document = parse_yaml(text, name="data")
    before = document.plain()
    kept = copy.deepcopy(before)
    after = apply(before, data.draw(operations(before)))
    patch = patch_yaml(text, document, before, after)
    assert same(parse_yaml(patch.text, name="data").plain(), after)
    assert same(before, kept)
    assert patched(text, patch.patches) == patch.text
    assert patched(patch.text, inverse(patch.patches)) == text


def _patched(text, *operations):
    document = parse_yaml(text, name="data")
    before = document.plain()
    return patch_yaml(text, document, before, apply(before, operations)).text


def _lines_gone(old, new):
    """Returns the lines that are in the old text only."""
    left = new.splitlines()
    gone = []
    for line in old.splitlines():
        if line in left:
            left.remove(line)
        else:
            gone.append(line)
    return gone


@pytest.mark.parametrize(
    ("operation", "gone", "come"),
    [
        (
            ("set", ("humans", 0, "pose"), [1.5, 2, 0.3]),
            ["    pose: [0, 0, 0]      # at the door"],
            ["    pose: [1.5, 2, 0.3]      # at the door"],
        ),
        (
            ("set", ("humans", 2, "pose", 2), 1),
            ["      - 0   # yaw"],
            ["      - 1   # yaw"],
        ),
        (("insert", ("humans", 0, "goals", 1), [9, 9]), [], ["      - [9, 9]"]),
        (
            ("remove", ("humans", 0, "goals", 0)),
            ["      # first", "      - [5, 6.0]"],
            [],
        ),
        (
            ("set", ("humans", 0, "behavior", "duration"), 3),
            ["    behavior: {type: curious, distance: 6.0}"],
            ["    behavior: {type: curious, distance: 6.0, duration: 3}"],
        ),
        (("set", ("humans", 1, "max_speed"), 1.5), [], ["    max_speed: 1.5"]),
        (
            ("remove", ("humans", 1, "desired_speed")),
            ["    desired_speed: 0"],
            [],
        ),
        (
            ("insert", ("world", "walls", 2), {"type": "box"}),
            [],
            ["    - {type: box}"],
        ),
        (
            ("remove", ("world", "walls", 1)),
            [
                "    # the south",
                "    - {type: box, center: [1, -2],  size: [3, .2]}  # short",
            ],
            [],
        ),
        (
            ("insert", ("humans", 3), {"name": "eva", "goals": [[1, 2]]}),
            [],
            ["  - name: eva", "    goals:", "      - [1, 2]"],
        ),
        (
            ("set", ("planner",), {"type": "dwb", "period": 0.1}),
            ["planner: pursuit"],
            ["planner:", "  type: dwb", "  period: 0.1"],
        ),
        (("set", ("empty",), 1), ["empty:"], ["empty: 1"]),
        (("set", ("simulation", "seed"), 4), [], ["simulation:", "  seed: 4"]),
    ],
)
def test_only_what_changes_is_written(operation, gone, come):
    new = _patched(TEXT, operation)
    assert _lines_gone(TEXT, new) == gone
    assert _lines_gone(new, TEXT) == come


def test_a_moved_item_takes_its_comments_along():
    humans = parse_yaml(TEXT, name="x").plain()["humans"]
    new = _patched(
        TEXT, ("remove", ("humans", 0)), ("insert", ("humans", 2), humans[0])
    )
    assert sorted(new.splitlines()) == sorted(TEXT.splitlines())
    assert new.index("# Ana walks.") > new.index("- 0   # yaw")


def test_a_new_key_takes_the_place_of_the_last_one():
    text = "a: 1   # one\nrobot: {start: [1, 2, 0]}   # gone\n"
    document = parse_yaml(text, name="data")
    patch = patch_yaml(
        text, document, document.plain(), {"a": 1, "robots": [{"name": "b"}]}
    )
    assert patch.text == "a: 1   # one\nrobots:\n  - name: b\n"
    assert patch.rewritten is None


def test_all_goals_go():
    new = _patched(TEXT, ("set", ("humans", 0, "goals"), []))
    assert "    goals: []\n    behavior" in new


def test_line_ends_stay():
    text = TEXT.replace("\n", "\r\n")
    human = {"name": "eva", "goals": [[1, 2]]}
    new = _patched(text, ("insert", ("humans", 3), human))
    assert new.count("\n") == new.count("\r\n") == text.count("\n") + 3


def test_an_anchor_is_written_anew_where_it_must_be():
    document = parse_yaml(ANCHORS, name="x")
    before = document.plain()
    # What an alias stands for gets a value of its own.
    own = apply(before, [("set", ("humans", 1, "forces", "goal"), 3.0)])
    patch = patch_yaml(ANCHORS, document, before, own)
    assert patch.rewritten is None
    assert "<<: *base" in patch.text
    # What comes with a merge key cannot be taken away from it.
    less = apply(before, [("remove", ("humans", 0, "radius"))])
    patch = patch_yaml(ANCHORS, document, before, less)
    assert patch.rewritten == ("humans", 0)
    assert "# second" in patch.text


def test_random_edits_are_seldom_written_anew():
    """Without anchors, what changes is nearly always found in its place."""
    generator = random.Random(1)
    document = parse_yaml(TEXT, name="data")
    before = document.plain()
    whole = [path for path in paths(before) if path]
    anew = 0
    for _ in range(60):
        path = generator.choice(whole)
        kind = generator.choice(["set", "remove"])
        value = [generator.choice([1.5, "word", [1, 2], {"a": 1}])]
        operation = (kind, path, *(value if kind == "set" else []))
        after = apply(before, [operation])
        patch = patch_yaml(TEXT, document, before, after)
        anew += patch.rewritten is not None
    assert anew == 0
