"""The list of differences from HuNavSim is complete and correct."""

import json
from pathlib import Path

import pytest
import yaml

from hunav_drake.hunavsim.differences import (
    DIFFERENCES,
    PROFILE_AREAS,
    as_markdown,
    left_by_profile,
)
from hunav_drake.scenario import LoadScenario
from hunav_drake.systems.crowd import CrowdConfig
from hunav_drake.systems.evaluation.metrics import METRICS
from hunav_drake.systems.people.profile import PROFILES

PAGE = Path(__file__).resolve().parents[3] / "docs/hunavsim.md"
KEYS = sorted({row.key for row in DIFFERENCES if row.key})


def test_the_page_is_up_to_date():
    """`hunav differences --markdown -o docs/hunavsim.md --force` writes it."""
    assert PAGE.read_text() == as_markdown()


def test_names_are_unique_and_nothing_is_left_empty():
    names = [row.name for row in DIFFERENCES]
    assert len(set(names)) == len(names)
    for row in DIFFERENCES:
        assert all([row.name, row.original, row.here, row.why]), row
        assert set(row.metrics) <= set(METRICS)


def test_little_is_left_with_the_profile():
    assert 1 <= len(left_by_profile()) <= 6


def test_every_row_of_the_profile_has_its_differences():
    """What the profile sets is in the list, and the list says that it is."""
    text = " ".join(row.key for row in DIFFERENCES if row.by_profile)
    for field in PROFILES["hunavsim"].crowd:
        assert field in text, field
    for field in PROFILES["hunavsim"].human:
        assert field in text, field
    assert all(
        row.area in PROFILE_AREAS for row in DIFFERENCES if row.by_profile
    )


@pytest.mark.parametrize("key", [k for k in KEYS if k.startswith("crowd")])
def test_a_key_of_the_crowd_is_one_and_that_of_the_profile(key):
    config = LoadScenario(data=key).crowd
    profile = CrowdConfig(profile="hunavsim")
    given = yaml.safe_load(key)["crowd"]
    for field in given.keys() - {"model"}:
        assert getattr(config, field) == getattr(profile, field)
        assert getattr(config, field) != getattr(CrowdConfig(), field)


@pytest.mark.parametrize("key", [k for k in KEYS if k.startswith("humans")])
def test_a_key_of_a_person_can_be_written(key):
    where, _, value = key.partition(": ")
    field = where.removeprefix("humans[].")
    tree = "type: scared" if field == "behavior" and "type" not in value else ""
    value = value.replace("{", f"{{{tree}, ") if tree else value
    scenario = LoadScenario(
        data=f"humans: [{{pose: [0, 5, 0], {field}: {value}}}]"
    )
    assert (
        scenario.humans[0]
        != LoadScenario(data="humans: [{pose: [0, 5, 0]}]").humans[0]
    )


def test_the_command_prints_the_list(hunav):
    code, out, err = hunav("differences", "--json")
    assert (code, err) == (0, "")
    rows = json.loads(out)
    assert [row["name"] for row in rows] == [row.name for row in DIFFERENCES]
    code, out, _ = hunav("differences")
    assert code == 0
    assert all(row.here in out for row in DIFFERENCES)
    code, out, _ = hunav("differences", "--left")
    assert "the robot's number" in out
    assert "occlusion" not in out


def test_a_metric_names_the_slip_of_the_original(hunav):
    code, out, _ = hunav("metrics", "show", "time_not_moving")
    assert code == 0
    assert "abs(w < 0.02)" in out
    _, out, _ = hunav("metrics", "show", "avg_robot_angular_speed")
    assert "mean of |w|" in out
    assert "with its sign" in out
