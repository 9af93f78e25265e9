"""Nothing but a Scenario or a ScenarioError ever comes of a file."""

from importlib import resources
import math

from hypothesis import given, strategies as st
import numpy as np
import pytest
import yaml

from hunav_drake.scenario import (
    Box,
    CheckScenario,
    CrowdConfig,
    DifferentialDriveConfig,
    EvaluatorConfig,
    HumanConfig,
    LoadScenario,
    Polygon,
    Polyline,
    RobotLimits,
    SaveScenario,
    Scenario,
    ScenarioError,
    SimulationConfig,
    SocialForceParameters,
    World,
)
from hunav_drake.systems.planning import PursuitPlanner

# Among random headings some are of more than a turn.
pytestmark = pytest.mark.filterwarnings("ignore:.*a whole turn")

PASSING = (
    resources.files("hunav_drake.scenarios")
    .joinpath("passing.yaml")
    .read_text(encoding="utf-8")
)
WORDS = """
[ ] { } : , - ? & * ! | > ' " % @ ` # ~ &a *a !!str !x <<: *a --- ... -1 0 1e3
1e999 .nan .inf null true yes 1:30 '' [] {} 9999999999999999999 humans world
walls name pose id goals [1,2] [1,2,3] polygon box polyline
"""
BREAKS = ["\n", "\n  ", "\n- ", "\t", "\0", "\x85", "\u2028", "é", "😀", " "]
SCRAPS = [*WORDS.split(), *BREAKS]
PATHS = """
world world.walls world.walls[0] world.walls[1].center humans humans[0]
humans[1].pose humans[1].pose[2] humans[0].goals humans[0].goals[0][1]
humans[0].forces humans[0].forces.n humans[0].id humans[1].name
humans[0].behavior humans[1].max_speed robot robot.start robot.goal
robot.limits robot.radius planner planner.type planner.period
planner.parameters planner.x crowd.model crowd.model.type crowd.model.kernel
evaluator.period evaluator.metrics
simulation.time_step simulation.duration simulation.seed crowd
crowd.max_obstacles other
"""


def is_scenario(**kwargs):
    """Returns whether it is a scenario; a ScenarioError must make sense."""
    try:
        scenario = LoadScenario(**kwargs)
    except ScenarioError as caught:
        error = caught
    else:
        assert isinstance(scenario, Scenario)
        return True
    assert error.faults
    assert all(fault.message for fault in error.faults)
    count = len(error.faults)
    assert len(str(error).split("\n")) == 1 + min(count, 50) + (count > 50)
    return False


@given(content=st.binary(max_size=300))
def test_random_bytes(content, tmp_path_factory):
    file = tmp_path_factory.getbasetemp() / "random.yaml"
    file.write_bytes(content)
    is_scenario(filename=file)


@given(scraps=st.lists(st.sampled_from(SCRAPS), max_size=30))
def test_random_scraps_of_yaml(scraps):
    is_scenario(data=" ".join(scraps))


@given(
    edits=st.lists(
        st.tuples(
            st.integers(0, len(PASSING)),
            st.integers(0, 20),
            st.sampled_from(SCRAPS) | st.text(max_size=5),
        ),
        min_size=1,
        max_size=5,
    )
)
def test_random_edits_of_a_scenario(edits):
    text = PASSING
    for start, size, scrap in edits:
        text = text[:start] + scrap + text[start + size :]
    is_scenario(data=text)


VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats()
    | st.sampled_from(["ana", "box", "polygon", "regular", "", "x" * 70]),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["x", "pose", "type"]), inner)
    ),
    max_leaves=6,
)


@given(
    changes=st.dictionaries(
        st.sampled_from(PATHS.split()), VALUES, min_size=1, max_size=3
    )
)
def test_random_values_in_a_scenario(changes):
    overrides = {
        path: yaml.safe_dump(value, default_flow_style=True)
        for path, value in changes.items()
    }
    is_scenario(filename="passing", overrides=overrides)


@given(
    override=st.text(max_size=20)
    | st.lists(
        st.sampled_from(
            [
                "humans",
                "[0]",
                "[9]",
                ".",
                "=",
                "pose",
                "1",
                "[",
                "&a",
                "robot",
                " ",
            ]
        ),
        max_size=8,
    ).map("".join)
)
def test_random_overrides(override):
    is_scenario(filename="passing", overrides=[override])


NUMBERS = st.floats(0.1, 5.0)
ODD_WORDS = """
no 1e3 1 null ~ # ' " << = 1:30 2026-01-31 é😀 - ? [ { & * ! | > % @ true .5
"""
SPACES = ["", " ", " x ", "a: b", "a #b", "a\nb", "\t", "\x85", "\u2028", "\0"]
TEXTS = st.sampled_from([*ODD_WORDS.split(), *SPACES, "\ufeff"]) | st.text(
    max_size=20
).filter(str.isprintable)
# Of a name, there is one line.
NAMES = TEXTS.filter(str.isprintable)


@st.composite
def humans(draw, index):
    desired = draw(st.floats(0.0, 3.0))
    return HumanConfig(
        # Far from each other, and from the robot and the walls.
        name=f"{draw(NAMES)}{index}",
        id=draw(st.sampled_from([index, 2**31 - 1 - index])),
        pose=(100.0 * index, draw(st.floats(-20, 20)), draw(st.floats(-9, 9))),
        behavior=draw(st.sampled_from(["regular", "impassive"])),
        desired_speed=desired,
        max_speed=draw(st.none() | st.floats(max(desired, 0.1), 10)),
        radius=draw(NUMBERS),
        group_id=draw(st.integers(-1, 3)),
        goals=draw(st.lists(st.tuples(*[st.floats(-50, 50)] * 2), max_size=3)),
        cyclic=draw(st.booleans()),
        goal_radius=draw(NUMBERS),
        forces=SocialForceParameters(
            n=draw(NUMBERS), social_factor=draw(NUMBERS)
        ),
    )


@st.composite
def walls(draw, index):
    x, y = 1000.0 * index, 5000.0
    kind = draw(st.sampled_from([Box, Polygon, Polyline]))
    name, height = draw(NAMES), draw(NUMBERS)
    if kind is Box:
        return Box(
            name=name,
            height=height,
            center=(x, y),
            size=(draw(NUMBERS), draw(NUMBERS)),
            yaw=draw(st.floats(-9, 9)),
        )
    # Any radii around a point make a simple polygon.
    radii = draw(st.lists(NUMBERS, min_size=4, max_size=8))
    angles = [2 * math.pi * k / len(radii) for k in range(len(radii))]
    points = [
        (x + r * math.cos(a), y + r * math.sin(a))
        for r, a in zip(radii, angles, strict=True)
    ]
    return kind(name=name, height=height, points=points)


@st.composite
def scenarios(draw):
    step = draw(st.sampled_from([0.01, 0.02, 0.05, 0.1]))
    return Scenario(
        description=draw(TEXTS),
        world=World(
            walls=[draw(walls(i)) for i in range(draw(st.integers(0, 3)))]
        ),
        crowd=CrowdConfig(max_obstacles=draw(st.integers(0, 9))),
        humans=[draw(humans(i)) for i in range(draw(st.integers(0, 3)))],
        robot=DifferentialDriveConfig(
            radius=draw(NUMBERS),
            limits=RobotLimits(max_speed=draw(NUMBERS)),
            start=(-500.0, draw(NUMBERS), draw(st.floats(-9, 9))),
            goal=draw(st.none() | st.just((-400.0, 1.0, 0.1))),
        ),
        planner=PursuitPlanner(
            period=step * draw(st.integers(1, 5)),
            **draw(
                st.just({}) | st.fixed_dictionaries({"cruise_speed": NUMBERS})
            ),
        ),
        evaluator=EvaluatorConfig(
            period=step * draw(st.integers(1, 100)),
            metrics=draw(st.sampled_from([["all"], [], ["path_length"]])),
        ),
        simulation=SimulationConfig(
            time_step=step,
            duration=step * draw(st.integers(1, 10**5)),
            seed=draw(st.integers(0, 2**63 - 1)),
        ),
    )


@pytest.mark.slow
@given(scenario=scenarios())
def test_a_saved_scenario_loads_as_an_equal_one(scenario):
    assert LoadScenario(data=SaveScenario(scenario)) == scenario


@pytest.mark.parametrize("text", ["1e3", "0x1F", "+1", ".5", "1.", "-.inf"])
def test_text_that_looks_like_a_number_stays_text(text):
    scenario = Scenario(
        description=text,
        planner=PursuitPlanner(),
        humans=[HumanConfig(name=text, pose=(5, 5, 0))],
    )
    loaded = LoadScenario(data=SaveScenario(scenario))
    assert loaded == CheckScenario(scenario)


@pytest.mark.slow
@given(
    points=st.lists(
        st.tuples(st.integers(-5, 5), st.integers(-5, 5)),
        min_size=3,
        max_size=7,
    )
)
def test_polygons_are_simple_or_refused_however_they_are_turned(points):
    """The verdict does not depend on where a polygon starts, or its sense."""
    verdicts = set()
    for shift in range(len(points)):
        turned = np.roll(points, shift, axis=0).tolist()
        for corners in (turned, turned[::-1]):
            verdicts.add(
                is_scenario(
                    data="robot: {start: [50, 50, 0]}\nworld:\n  walls:\n"
                    f"    - {{type: polygon, points: {corners}}}"
                )
            )
    assert len(verdicts) == 1
