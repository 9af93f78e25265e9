"""How people look: sizes by age, seats, wheelchairs, and drawn people."""

import json

from hypothesis import given, strategies as st
import numpy as np
import pytest

from hunav_drake import (
    HumanConfig,
    LoadScenario,
    RunTrial,
    SaveScenario,
    ScenarioError,
)
from hunav_drake.systems.people.figure_config import (
    FigureConfig,
    figure_rows,
    height_of_age,
)
from hunav_drake.systems.people.gait import (
    BASE_X,
    FOOTREST,
    HIP_HEIGHT,
    LEFT_HIP,
    LEFT_KNEE,
    LEFT_SHOULDER,
    RIGHT_HIP,
    RIGHT_KNEE,
    RIGHT_SHOULDER,
    SEAT,
    SEATED,
    SHIN,
    THIGH,
    pose_figures,
    reach,
    seated_knee,
)
from hunav_drake.systems.people.legs import RIM, WHEEL_Y
from hunav_drake.systems.people.population import draw_population
from hunav_drake.systems.people.population_config import (
    CohortConfig,
    PopulationConfig,
)
from hunav_drake.systems.world.obstacles import Obstacles

NO_WALLS = Obstacles.from_points([])
HALL = {"rectangle": [0, 0, 120, 120]}


def posed(figure, phase=1.0, pace=1.2):
    states = np.array([2.0, 3, 0.5, pace, 0, 0, 0.35])
    gait = np.array([phase, pace, 2, 3])
    (q,) = pose_figures(gait, states, figure_rows([figure]))
    return q


def test_adults_are_all_alike_and_children_small():
    assert FigureConfig().tall == FigureConfig(age=18).tall == 1.0
    assert FigureConfig(age=18).wide == 1.0
    heights = height_of_age(np.arange(3.0, 30.0))
    assert (np.diff(heights) >= 0).all()
    assert heights[[0, -1]].tolist() == [0.955, 1.7]
    child = FigureConfig(age=6)
    assert 0.6 < child.tall < child.wide < 0.85
    assert FigureConfig(age=6, height=1.7).tall == 1.0
    assert FigureConfig(build=1.3).wide == 1.3


@given(st.floats(0.8, 2.2), st.floats(0, 2 * np.pi), st.floats(0, 2.0))
def test_the_lower_foot_is_on_the_floor(height, phase, pace):
    figure = FigureConfig(height=height)
    q = posed(figure, phase, pace)
    low = max(reach(q[h], q[h + 1]) for h in (LEFT_HIP, RIGHT_HIP))
    assert q[HIP_HEIGHT] == pytest.approx(figure.tall * low)


def test_short_legs_swing_wider_at_the_same_speed():
    stride = [
        figure.tall
        * (THIGH + SHIN)
        * np.sin(posed(figure, np.pi / 2)[LEFT_HIP])
        for figure in (FigureConfig(height=1.3), FigureConfig())
    ]
    assert stride[0] == pytest.approx(stride[1], rel=0.01)


@pytest.mark.parametrize("height", [0.9, 1.3, 1.7, 2.0])
def test_hips_are_on_the_seat_and_feet_above_the_floor(height):
    tall = height / 1.7
    low = tall * reach(SEATED, seated_knee(tall))
    if tall < 1:
        assert low < SEAT
    else:
        assert low == pytest.approx(SEAT)


def test_who_is_in_a_wheelchair_sits_and_pushes_with_both_hands():
    wheels = FigureConfig(wheelchair=True)
    found = np.array([posed(wheels, it) for it in (0.5, 2.0, 4.0)])
    assert found[:, HIP_HEIGHT] == pytest.approx(SEAT + FOOTREST)
    legs = found[:, [LEFT_HIP, LEFT_KNEE, RIGHT_HIP, RIGHT_KNEE]]
    np.testing.assert_array_equal(legs, np.full((3, 4), legs[0, 0]))
    left, right = found[:, LEFT_SHOULDER], found[:, RIGHT_SHOULDER]
    np.testing.assert_array_equal(left, right)
    assert np.ptp(left) > 0.2
    assert (found[:, BASE_X] == 2.0).all()


def test_the_body_of_a_wheelchair_is_as_wide_as_it_is():
    def radius(**more):
        wheels = FigureConfig(wheelchair=True)
        person = {"pose": (0, 0, 0), "radius": 0.35, "figure": wheels}
        return HumanConfig(**person | more).contact_radius

    assert radius() == 0.3 == pytest.approx(WHEEL_Y + RIM, abs=0.01)
    assert radius(figure=FigureConfig()) == 0.25
    assert radius(body_radius=0.33) == 0.33


def drawn(**values):
    cohort = CohortConfig(number=2000, start=[HALL], spacing=0.0, **values)
    config = PopulationConfig(seed=3, cohorts=[cohort])
    return draw_population(config, NO_WALLS)


@pytest.mark.slow
def test_people_are_drawn_as_tall_as_their_age_and_sex_are():
    plain = drawn()
    assert {it.figure.tall for it in plain} == {1.0}
    women, men = (
        np.array(
            [
                it.figure.height
                for it in drawn(figures="varied", share_of_women=share)
            ]
        )
        for share in (1, 0)
    )
    # NHANES 2015-2018, in meters.
    assert women.mean() == pytest.approx(1.612, abs=0.01)
    assert men.mean() == pytest.approx(1.753, abs=0.01)
    assert men.std() == pytest.approx(0.075, abs=0.01)
    children = drawn(figures="varied", ages=[{"low": 5, "high": 9}])
    heights = [it.figure.height for it in children]
    assert 0.9 < min(heights) < max(heights) < 1.6
    assert {it.figure.carries for it in children} == {
        *("nothing", "backpack", "bag")
    }


@pytest.mark.slow
def test_looks_and_needs_change_nothing_else():
    plain = drawn()
    more = drawn(
        figures="varied", needs={"thirst": {"initial": [20, 60], "rate": 2.0}}
    )
    assert [it.pose for it in plain] == [it.pose for it in more]
    assert [it.desired_speed for it in plain] == [
        it.desired_speed for it in more
    ]
    assert more == drawn(
        figures="varied", needs={"thirst": {"initial": [20, 60], "rate": 2.0}}
    )


@pytest.mark.slow
def test_needs_are_drawn_for_each_person():
    needs = {"thirst": {"initial": [20, 60], "rate": 2.0}, "rest": {}}
    people = drawn(needs=needs)
    thirst, rest = (
        np.array([it.needs[name].initial for it in people]) for name in needs
    )
    assert 20 <= thirst.min() < 21 < 59 < thirst.max() <= 60
    assert thirst.mean() == pytest.approx(40, abs=1)
    assert rest.mean() == pytest.approx(50, abs=2)
    assert abs(np.corrcoef(thirst, rest)[0, 1]) < 0.1
    assert {it.needs["thirst"].rate for it in people} == {2.0}
    # Another need changes no draw of the first.
    alone = drawn(needs={"thirst": needs["thirst"]})
    assert [it.needs["thirst"] for it in alone] == [
        it.needs["thirst"] for it in people
    ]


def scenario(**person):
    data = {
        "humans": [{"pose": [3, 3, 0], **person}],
        "robot": {"start": [0, 0, 0], "goal": [5, 0, 0]},
    }
    return LoadScenario(data=json.dumps(data))


def test_a_figure_is_saved_only_if_it_is_given():
    assert "figure" not in SaveScenario(scenario())
    figure = {"age": 8.0, "carries": "backpack"}
    text = SaveScenario(scenario(figure=figure))
    assert LoadScenario(data=text).humans[0].figure == FigureConfig(**figure)


@pytest.mark.parametrize(
    ("figure", "fault"),
    [
        ({"age": 2}, "figure.age: must be in [3, 100] years, got 2"),
        ({"height": 3.0}, "figure.height: must be in [0.8, 2.2] m, got 3"),
        ({"carries": "bags"}, "did you mean 'bag'"),
        ({"wheelchair": 1}, "figure.wheelchair: must be true or false"),
    ],
)
def test_faults_of_figures_have_their_place(figure, fault):
    with pytest.raises(ScenarioError) as caught:
        scenario(figure=figure)
    assert fault in str(caught.value)


NEEDY = (
    '<root BTCPP_format="4"><BehaviorTree ID="A"><NeedsSelector><Satisfies'
    ' need="{}" amount="60"><UsePlace place="bar"/></Satisfies>'
    "</NeedsSelector></BehaviorTree></root>"
)


def test_trees_of_drawn_people_know_their_needs(tmp_path):
    def data(need):
        (tmp_path / "needy.xml").write_text(NEEDY.format(need))
        cohort = {
            "number": 3,
            "start": [{"rectangle": [3, 3, 9, 9]}],
            "needs": {"thirst": {"initial": [20, 40]}},
            "behaviors": {str(tmp_path / "needy.xml"): 1},
        }
        return {
            "places": [{"name": "bar", "pose": [6, 12, 0]}],
            "population": {"cohorts": [cohort]},
            "robot": {"start": [0, 0, 0], "goal": [5, 0, 0]},
        }

    people = LoadScenario(data=json.dumps(data("thirst")))
    assert people.population.cohorts[0].needs["thirst"].initial == (20, 40)
    with pytest.raises(ScenarioError, match="there is no need 'hunger'"):
        LoadScenario(data=json.dumps(data("hunger")))


def test_a_trial_of_people_with_needs_has_a_scenario_that_can_be_read():
    needs = {"thirst": {"initial": 20.0, "rate": 2.0}, "rest": {}}
    cohort = {
        "number": 2,
        "start": [{"rectangle": [3, 3, 9, 9]}],
        "needs": needs | {"thirst": {"initial": [20.0, 40.0]}},
    }
    data = {
        "humans": [{"pose": [0, 3, 0], "needs": needs}],
        "population": {"cohorts": [cohort]},
        "robot": {"start": [0, 0, 0], "goal": [5, 0, 0]},
        "simulation": {"duration": 0.1},
    }
    scenario = LoadScenario(data=json.dumps(data))
    assert LoadScenario(data=SaveScenario(scenario)) == scenario
    assert RunTrial(scenario).recording.num_humans == 3


def test_levels_of_needs_are_a_range():
    with pytest.raises(ValueError, match="a least and a largest level"):
        CohortConfig(number=1, start=[HALL], needs={"a": {"initial": [60, 20]}})
