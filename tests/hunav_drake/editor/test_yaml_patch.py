"""The text of a scenario follows its data, and keeps what did not change."""

import copy

from hypothesis import given, settings, strategies as st

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
    - shape: box     # a box
      center: [ 1, 2.50 ]
      size: [3.0,0.2]

    # the south
    - {shape: box, center: [1, -2],  size: [3, .2]}  # short
    -
      shape: polyline
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
    behavior: {tree: curious, distance: 6.0}
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

SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**12), 10**12),
    st.floats(allow_nan=True),
    st.sampled_from(
        ["a", "1e3", "null", "", " x", "a: b", "# c", "[x", "y, z", "-", "<<"]
        + [
            "two\nlines",
            "  indented\n text\n\n",
            "é\u2028x",
            "'",
            '"',
            "a" * 99,
        ]
        + ["1:30", "~", ".inf", "%", "*a", "&b", "!c", "x #y", "\t", "😀", "?"]
    ),
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


@settings(max_examples=500, deadline=None)
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
