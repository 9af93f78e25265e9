import math

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake.runs import LoadSuite
from hunav_drake.runs.formula import check_formula, holds, names_in
from hunav_drake.scenario import ScenarioError


def told(formula, **values):
    check_formula(formula)
    arrays = {name: np.array([value]) for name, value in values.items()}
    assert set(names_in(formula)) <= set(values)
    return bool(holds(formula, arrays, 1)[0])


@pytest.mark.parametrize(
    ("formula", "truth"),
    [
        ("a < b", True),
        ("a < b and b < 1", False),
        ("a > b or b > 1e-3", True),
        ("not a < b", False),
        ("not (a > b or b > 1e3)", True),
        ("(a < b) & (b < 1)", False),
        ("(a > b) | ~(b > 1e3)", True),
        ("a < b <= 2 * a", True),
        ("-a < b - a ** 2", True),
        ("b != 2", False),
        ("a // b == 0", True),
    ],
)
def test_formulas_are_those_of_python(formula, truth):
    assert told(formula, a=1.0, b=2.0) is truth


@given(
    st.lists(st.sampled_from(["a < b", "b < c", "a >= c", "b == 1"])).filter(
        len
    ),
    st.lists(st.sampled_from([" and ", " or "]), min_size=8, max_size=8),
    st.lists(st.booleans(), min_size=8, max_size=8),
    st.tuples(*[st.integers(0, 2)] * 3),
)
def test_joints_bind_as_in_python(parts, joints, nots, values):
    parts = parts[:8]
    text = "".join(
        joint * (i > 0) + "not " * no + part
        for i, (joint, no, part) in enumerate(
            zip(joints, nots, parts, strict=False)
        )
    )
    a, b, c = map(float, values)
    known = {"a": a, "b": b, "c": c}
    assert told(text, **known) == eval(text, {}, known)


@pytest.mark.parametrize(
    "formula", ["a < b", "a != b", "not a < b", "b > 1 or a > 1", "a / c != 1"]
)
def test_of_nan_nothing_holds(formula):
    assert not told(formula, a=math.nan, b=2.0, c=0.0)
    assert not told("a / c != 1", a=0.0, c=0.0)


def test_names_are_those_that_are_meant():
    assert names_in("not a_1 < 1e-3 and b or c") == ["a_1", "b", "c"]


@pytest.mark.parametrize(
    ("formula", "rule"),
    [
        ("1 < 2", "not only numbers"),
        ("a < b and 1e-3 < 2", "not only numbers"),
        ("sfw + dwb", "must be a comparison"),
        ("sfw", "must be a comparison"),
        ("not sfw", "must be a comparison"),
        ("a < b & b < c", "brackets around comparisons"),
        ("(a < b) + (b < c) > 1", "must compare names"),
        ("a in b", "must compare by <"),
        ("a is b", "must compare by <"),
        ("a < True", "must have numbers, not True"),
        ("a < 'b'", "must have numbers, not 'b'"),
        ("a < 1e999", "finite numbers"),
        ("a < " + "9" * 400, "finite numbers"),
        ("a[0] < 1", "must compare names"),
        ("f(a) < 1", "must compare names"),
        ("a <", "must compare names"),
        ("-" * 5000 + "a < 1", "must compare names"),
    ],
)
def test_what_cannot_be_tested_is_refused_with_its_line(formula, rule):
    with pytest.raises(ValueError, match=rule):
        check_formula(formula)
    relation = (
        f"{{scenarios: [passing], metric: path_length, holds: {formula!r}}}"
    )
    with pytest.raises(
        ScenarioError, match=f"data:3: relations.0..holds: .*{rule}"
    ):
        LoadSuite(data=f"scenarios: [passing]\nrelations:\n- {relation}\n")


def test_powers_of_numbers_have_an_end():
    assert told("a < 9 ** 9 ** 9 ** 9", a=1.0)
