"""What a lidar takes for legs is what the scene shows."""

import numpy as np
from pydrake.geometry import Role
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest
import shapely

from hunav_drake import HumanConfig
from hunav_drake.systems.common.layout import (
    SILENT,
    STATE_SIZE,
    Posture,
    Signal,
)
from hunav_drake.systems.people.figure_config import (
    WIDE,
    FigureConfig,
    Figures,
    adult_figures,
    figure_rows,
)
from hunav_drake.systems.people.gait import (
    GAIT_SIZE,
    HIP_HEIGHT,
    initial_gait,
    pose_figures,
)
from hunav_drake.systems.people.legs import (
    RIM,
    TRUNK_X,
    WHEEL,
    WHEEL_Y,
    WHEELCHAIR_X,
    figure_width,
    legs_at,
)
from hunav_drake.systems.people.manners import LEAN, LIVELY_SIZE, hold_figures
from hunav_drake.systems.scene import AddScene, SceneInputs
from hunav_drake.systems.scene.models.make_people import make_people
from hunav_drake.systems.sensing import Lidar, LidarConfig
from hunav_drake.systems.world.shapes import World
from tests.systems.sensing.scans import fix, rows, scan

SPEEDS = (0.0, 0.6, 1.2, 1.8)


def walking_states():
    """People who walk along various directions, shape (n, 7)."""
    result = np.zeros((len(SPEEDS), STATE_SIZE))
    for i, speed in enumerate(SPEEDS):
        yaw = 0.7 * i - 1
        velocity = speed * np.cos(yaw), speed * np.sin(yaw)
        result[i] = 3.0 * i, 1.0, yaw, *velocity, 0.0, 0.3 + 0.05 * i
    return result


class Walkers:
    """Figures of a scene, and a lidar, with the same people."""

    def __init__(self, figures=None, signals=None):
        self.states = walking_states()
        n = len(self.states)
        builder = DiagramBuilder()
        humans = [
            HumanConfig(pose=row[:3], radius=row[6], figure=figure)
            for row, figure in zip(
                self.states, figures or [FigureConfig()] * n, strict=True
            )
        ]
        inputs = None if signals is None else SceneInputs(sayings=[{}] * n)
        self.scene = AddScene(builder, World(), humans, inputs=inputs)
        self.rows = figure_rows([it.figure for it in humans])
        lively = signals is not None
        self.lidar = builder.AddSystem(
            Lidar(
                LidarConfig(),
                num_humans=n,
                figures=Figures(self.rows, lively=lively),
            )
        )
        if lively:
            builder.ExportInput(
                self.scene.system.GetInputPort("social_signals"), "signals"
            )
            builder.ConnectInput(
                "signals", self.lidar.GetInputPort("social_signals")
            )
        builder.ExportInput(self.scene.human_states, "people")
        builder.ConnectInput("people", self.lidar.get_human_states_input_port())
        builder.ExportInput(self.lidar.get_robot_state_input_port(), "robot")
        self.diagram = builder.Build()
        self.simulator = Simulator(self.diagram)
        self.context = self.simulator.get_mutable_context()
        for name, value in (
            ("people", self.states.ravel()),
            ("robot", rows((50, 50))[0]),
            *([("signals", signals)] if lively else []),
        ):
            self.diagram.GetInputPort(name).FixValue(self.context, value)

    def gait(self):
        own = self.lidar.GetMyContextFromRoot(self.context)
        return own.get_discrete_state(1).value().copy()

    def legs(self, height):
        own = self.lidar.GetMyContextFromRoot(self.context)
        groups = own.get_discrete_state()
        states = self.states.ravel()
        figures = pose_figures(groups.value(1), states, self.rows)
        if groups.num_groups() > 2:
            figures = hold_figures(figures, groups.value(2), self.rows)
        return legs_at(figures, states, self.rows, height)

    def outline(self, i, side, height):
        """Points where a plane cuts the leg of a figure, shape (k, 2)."""
        plant, graph = self.scene.plant, self.scene.scene_graph
        own = graph.GetMyContextFromRoot(self.context)
        query = graph.get_query_output_port().Eval(own)
        inspector = graph.model_inspector()
        instance = plant.GetModelInstanceByName(self.scene.human_names[i])
        found = []
        for part in ("thigh", "shin"):
            body = plant.GetBodyByName(f"{side}_{part}", instance)
            frame = plant.GetBodyFrameIdOrThrow(body.index())
            for g in inspector.GetGeometries(frame, Role.kIllustration):
                shape = inspector.GetShape(g)
                text = shape.source().in_memory().mesh_file.contents()
                lines = text.decode().splitlines()
                v = [x.split()[1:] for x in lines if x.startswith("v ")]
                vertices = np.array(v, dtype=float) * shape.scale3()
                faces = [
                    [int(c.split("/")[0]) - 1 for c in x.split()[1:]]
                    for x in lines
                    if x.startswith("f ")
                ]
                p = (query.GetPoseInWorld(g) @ vertices.T).T
                found += list(edges_cut(p, np.array(faces), height))
        return np.array(found).reshape(-1, 2)


def edges_cut(p, faces, height):
    """Yields where edges of triangles meet a plane."""
    for a, b in ((0, 1), (1, 2), (2, 0)):
        one, other = p[faces[:, a]], p[faces[:, b]]
        above, below = one[:, 2] - height, other[:, 2] - height
        cut = above * below < 0
        part = (above[cut] / (above[cut] - below[cut]))[:, None]
        yield from (one[cut] + part * (other[cut] - one[cut]))[:, :2]


VARIED = [
    FigureConfig(age=6),
    FigureConfig(height=1.95),
    FigureConfig(build=1.3),
    FigureConfig(wheelchair=True, height=1.5),
]


@pytest.mark.parametrize("height", [0.15, 0.3, 0.5, 0.7])
def test_the_ellipses_are_the_cuts_of_the_figures(height):
    gaps = gaps_of_cuts(Walkers(), (0.5, 1.0, 1.35), height)
    print(f"largest {max(gaps):.4f} m, median {np.median(gaps):.4f} m")
    assert len(gaps) == 24
    assert np.median(gaps) < 0.005
    assert max(gaps) < 0.02


@pytest.mark.parametrize("height", [0.15, 0.3])
def test_figures_of_all_sizes_are_seen_as_they_are_drawn(height):
    gaps = gaps_of_cuts(Walkers(VARIED), (0.5, 1.0, 1.35), height)
    assert len(gaps) == 24
    assert max(gaps) < 0.02


def test_who_sits_is_seen_sitting():
    signals = np.tile(SILENT, (len(SPEEDS), 1))
    signals[:, Signal.POSTURE] = Posture.SEATED
    dut = Walkers(VARIED, signals.ravel())
    # (They sit down, then sit.)
    gaps = gaps_of_cuts(dut, (0.3, 0.6, 3.0), 0.2)
    assert max(gaps) < 0.02
    legs = dut.legs(0.2)[: 2 * len(SPEEDS)]
    ahead = (legs[:, :2] - np.repeat(dut.states[:, :2], 2, axis=0)) @ np.array(
        [np.cos(legs[0, 2]), np.sin(legs[0, 2])]
    )
    # The shins of the child and of the adults, in front of the seat.
    assert ahead[0] == pytest.approx(0.42 * 0.69, abs=0.05)
    assert dut.lidar.GetInputPort("social_signals").size() == signals.size


@pytest.mark.parametrize(
    ("figure", "height"),
    [
        (FigureConfig(age=3), 0.65),
        (FigureConfig(age=3), 0.7),
        (FigureConfig(wheelchair=True), 0.7),
    ],
)
def test_a_plane_above_the_legs_meets_the_trunk(figure, height):
    person = rows((2, 0, np.pi), radius=0.35)
    config = LidarConfig(num_rays=1801, field_of_view=0.5, height=height)
    figures = Figures(figure_rows([figure]))
    dut = Lidar(config, num_humans=1, figures=figures)
    context = dut.CreateDefaultContext()
    fix(dut, context, people=person)
    found = dut.get_scan_output_port().Eval(context)
    met = found < config.range_max
    off = WHEELCHAIR_X if figure.wheelchair else 0.0
    front = 2 - off - TRUNK_X * figure.wide
    # (Of who sits, thighs are before it.)
    sits = 0.15 if figure.wheelchair else 0.0
    assert front - sits - 1e-3 < found.min() <= front + 1e-3
    # It is one piece, as wide as the drawn torso.
    edges = np.flatnonzero(np.diff(met.astype(int)))
    assert len(edges) == 2
    width = np.ptp(np.tan(config.angles()[edges])) * (2 - off)
    torso = make_people()["torso"].vertices
    drawn = np.ptp(torso[abs(torso[:, 2] - 0.15) < 0.01][:, 1]) * figure.wide
    assert width == pytest.approx(drawn, rel=0.1)


@pytest.mark.parametrize("height", [0.6, 0.65, 0.7])
def test_the_smallest_are_seen_by_the_highest_planes(height):
    figure = figure_rows([FigureConfig(height=0.8)])
    gait, states = initial_gait([1]), rows((0, 0)).ravel()
    gait[1] = states[3] = 1.2
    for phase in np.linspace(0, 2 * np.pi, 40, endpoint=False):
        gait[0] = phase
        figures = pose_figures(gait, states, figure)
        first = legs_at(figures, states, figure, height)[0]
        # At the least, the neck.
        assert first[3:].min() > 0.025


def test_the_trunk_of_who_bows_is_where_it_is_drawn():
    row, states = figure_rows([FigureConfig(height=1.2)]), rows((0, 0)).ravel()
    figures = pose_figures(initial_gait([1]), states, row)
    bowed = np.zeros((1, LIVELY_SIZE))
    bowed[:, : figures.shape[1]] = figures
    bowed[0, HIP_HEIGHT], bowed[0, LEAN] = 0.4, 0.5
    trunk = legs_at(bowed, states, row, 0.7)[0]
    assert trunk[0] == pytest.approx(0.3 * np.tan(0.5))
    width = row[0, WIDE] * figure_width(states[6])
    assert trunk[3] == pytest.approx(width * TRUNK_X / np.cos(0.5))


def test_a_wheelchair_has_wheels_beside_the_feet():
    person = rows((0, 0, np.pi / 2), radius=0.35)
    config = LidarConfig(num_rays=9, field_of_view=0.2)
    figures = Figures(figure_rows([FigureConfig(wheelchair=True)]))
    dut = Lidar(config, num_humans=1, figures=figures)
    context = dut.CreateDefaultContext()
    fix(dut, context, robot=(3, -0.15, np.pi), people=person)
    found = dut.get_scan_output_port().Eval(context)
    # From the side: at the height of the lidar, the wheel is as long as this.
    half = np.sqrt(WHEEL**2 - (config.height - WHEEL) ** 2)
    side = 3 - WHEEL_Y - RIM
    across = side * np.tan(config.angles())
    on_wheel = np.abs(across) < half - 0.06
    assert found[on_wheel] == pytest.approx(
        side / np.cos(config.angles()[on_wheel]), abs=0.02
    )
    assert on_wheel.sum() >= 5


def gaps_of_cuts(dut, times, height):
    """Returns how far ellipses are from the cuts of legs, in meters."""
    gaps = []
    for time in times:
        dut.simulator.AdvanceTo(time)
        legs = dut.legs(height)[: 2 * len(SPEEDS)]
        for k, (x, y, yaw, a, b) in enumerate(legs):
            side = "left" if k % 2 == 0 else "right"
            points = dut.outline(k // 2, side, height)
            cut = shapely.MultiPoint(points).convex_hull
            angles = np.linspace(0, 2 * np.pi, 60)
            c, s = np.cos(yaw), np.sin(yaw)
            ring = np.column_stack([a * np.cos(angles), b * np.sin(angles)])
            ellipse = shapely.Polygon(ring @ [[c, s], [-s, c]] + [x, y])
            gaps.append(shapely.hausdorff_distance(cut, ellipse))
    return gaps


def test_scene_and_lidar_walk_in_step():
    dut = Walkers()
    dut.simulator.AdvanceTo(1.7)
    scene = dut.diagram.GetSubsystemByName("scene")
    kinematics = scene.GetSubsystemByName("kinematics")
    own = kinematics.GetMyContextFromRoot(dut.context)
    figure = own.get_discrete_state(0).value()
    before = initial_gait(np.arange(len(figure) // GAIT_SIZE) + 1)
    assert (figure[::GAIT_SIZE] != before[::GAIT_SIZE]).any()
    np.testing.assert_array_equal(dut.gait(), figure)


def test_a_person_who_stands_has_two_legs():
    config = LidarConfig(num_rays=1801, field_of_view=0.5)
    found = scan(config, people=rows((2, 0, np.pi), radius=0.35))
    met = found < config.range_max
    # Two legs with a gap between them.
    edges = np.flatnonzero(np.diff(met.astype(int)))
    assert len(edges) == 4
    assert not met[900]
    # Both are in front of the middle by half their thickness.
    assert found[met].min() == pytest.approx(2 - 0.06, abs=0.01)
    width = np.ptp(config.angles()[edges]) * 2
    assert width == pytest.approx(2 * (0.09 + 0.057), abs=0.015)


def test_a_foot_in_the_air_is_above_a_low_plane():
    """Now and then, a plane below the ankles meets one foot alone."""
    gait = initial_gait([1])
    gait[1] = 1.4
    states = rows((0, 0))
    states[0, 3] = 1.4
    on_floor, adult = [], adult_figures(1)
    for phase in np.linspace(0, 2 * np.pi, 40, endpoint=False):
        gait[0] = phase
        figures = pose_figures(gait, states.ravel(), adult)
        legs = legs_at(figures, states.ravel(), adult, 0.03)
        on_floor.append((legs[:, 3] > 0).sum())
    assert set(on_floor) == {1, 2}


def test_two_lidars_see_the_same_legs_from_opposite_sides():
    person = rows((0, 0, 0.4))
    config = LidarConfig(num_rays=721, field_of_view=1.0)
    near = scan(config, robot=(-3, 0, 0), people=person)
    dut = Lidar(config, num_humans=1)
    context = dut.CreateDefaultContext()
    fix(dut, context, robot=(3, 0, np.pi), people=person)
    far = dut.get_scan_output_port().Eval(context)
    for found in (near, far):
        met = found < config.range_max
        assert 0.15 < met.sum() * config.angle_step * 3 < 0.4
