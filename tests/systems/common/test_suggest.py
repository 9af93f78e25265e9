"""Messages about an unknown word."""

import pytest

from hunav_drake.systems.common.suggest import nearest, suggestion
from hunav_drake.systems.evaluation.metrics import METRICS


@pytest.mark.parametrize(
    ("word", "near"),
    [
        ("path_lenght", "path_length"),
        ("jerk", "avg_robot_jerk"),
        ("collisons", "static_obstacle_collisions"),
        ("Success", "success_weighted_path_length"),
        ("xyzzy", None),
        ("", None),
    ],
)
def test_a_word_is_near_to_what_it_is_a_part_of(word, near):
    assert nearest(word, METRICS) == near


def test_many_valid_words_are_not_all_listed():
    few = [f"w{i}" for i in range(24)]
    assert suggestion("xyzzy", few) == "valid: " + ", ".join(sorted(few))
    told = suggestion("xyzzy", list(METRICS))
    assert told.startswith("valid: angle_over_length, asymmetric_dtw, ")
    assert told.endswith(f", and {len(METRICS) - 24} more")
    assert suggestion("xyzzy", []) == "there are none"
