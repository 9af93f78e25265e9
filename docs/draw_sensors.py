"""Draws `sensors_*.png`: what a robot senses, and with which errors.

python docs/draw_sensors.py
"""

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib.patches import Circle, Polygon
import matplotlib.pyplot as plt
import numpy as np

from hunav_drake import LoadScenario, MakeTrialDiagram, MakeTrialSimulator
from hunav_drake.systems.scene.labels import human_label
from hunav_drake.systems.sensing import scan_points
from hunav_drake.systems.sensing.scans import sensor_pose

FOLDER = Path(__file__).parent
SCENARIO = """
world:
  walls:
    - {type: box, center: [4, 4], size: [10, 0.2], height: 2.0}
    - {type: box, center: [4, -4], size: [10, 0.2], height: 2.0}
    - {type: box, center: [9, 0], size: [0.2, 8], height: 2.0}
    - {type: box, center: [5, 2.6], size: [0.2, 2.6], height: 2.0}
    - {type: box, center: [3.5, -2.8], size: [0.8, 0.8], yaw: 0.4}
humans:
  - {pose: [3.5, 0.8, 3.1], goals: [[-2, 0.8]]}
  - {pose: [6.8, 0.0, 3.1], goals: [[-2, 0]]}
  - {pose: [7.0, 2.9, 0.0]}
  - {pose: [6.2, -1.6, 1.6], goals: [[6.2, 3]]}
robot: {start: [0, 0, 0], goal: [8, 0, 0]}
sensors:
  - {type: lidar, num_rays: 720, noise: 0.01, pose: [0.2, 0, 0]}
  - {type: visible_people}
  - {type: camera, image_size: [800, 450], height: 1.1, pitch: 0.1}
"""
BLUE, ORANGE, GRAY = "#0072b2", "#d55e00", "0.55"


def draw_scan(scenario, output) -> None:
    """Draws a scan, and who is visible, from above."""
    robot, scan = output("robot_state"), output("scan")
    people = output("human_states").reshape(-1, 7)
    visible = output("visible") > 0
    lidar = scenario.sensors[0]
    points = scan_points(lidar, scan, robot)
    start = sensor_pose(lidar, robot)[:2]
    figure, axes = plt.subplots(figsize=(8, 6), layout="constrained")
    for wall in scenario.world.walls:
        axes.add_patch(Polygon(wall.vertices(), color="0.85"))
    for point in points[::6]:
        axes.plot(*np.transpose([start, point]), color="0.8", lw=0.5)
    axes.plot(*points.T, ".", color=ORANGE, ms=3, label="scan")
    for seen, row in zip(visible, people, strict=True):
        color = BLUE if seen else GRAY
        axes.add_patch(Circle(row[:2], row[6], fill=False, color=color))
    for color, label in ((BLUE, "visible"), (GRAY, "hidden")):
        axes.plot([], [], "o", mfc="none", color=color, label=label)
    axes.add_patch(Circle(robot[:2], robot[6], color="0.2"))
    axes.plot([], [], "o", color="0.2", label="robot")
    axes.set(
        xlim=(-1.2, 9.4),
        ylim=(-4.4, 4.4),
        aspect="equal",
        xlabel="x (m)",
        ylabel="y (m)",
    )
    axes.legend(loc="upper left")
    figure.savefig(FOLDER / "sensors_scan.png", dpi=80)


def draw_images(output) -> None:
    """Draws what the camera sees: color, depth and labels."""
    color = output("color_image").data[:, :, :3]
    depth = output("depth_image").data[:, :, 0]
    labels = output("label_image").data[:, :, 0].astype(int)
    figure, axes = plt.subplots(1, 3, figsize=(12, 2.6), layout="constrained")
    axes[0].imshow(color)
    finite = np.where(np.isfinite(depth), depth, np.nan)
    shown = axes[1].imshow(finite, cmap="viridis", vmax=14)
    figure.colorbar(shown, ax=axes[1], label="m")
    is_person = (labels >= human_label(0)) & (labels < 30_000)
    people = np.where(is_person, labels - human_label(0), np.nan)
    axes[2].imshow(is_person, cmap="gray_r", vmin=-0.15, vmax=1.5)
    axes[2].imshow(people, cmap="tab10", vmin=0, vmax=9)
    for panel, title in zip(axes, ("color", "depth", "people"), strict=True):
        panel.set_title(title)
        panel.axis("off")
    figure.savefig(FOLDER / "sensors_camera.png", dpi=75)


ERRORS = """
humans:
  - {pose: [3, 1.5, 0], desired_speed: 0.0}
  - {pose: [6, -1.5, 0], desired_speed: 0.0}
  - {pose: [9, 1.5, 0], desired_speed: 0.0}
robot: {start: [0, 0, 0], radius: 0.3}
sensors:
  - type: people_detector
    noise_per_meter: 0.03
    false_rate: 0.5
    range_max: 10
    field_of_view: 1.6
evaluator: {metrics: [duration]}
simulation: {duration: 20.0}
"""
LOOP = """
humans: []
robot: {start: [0, 0, 0], goal: [0, 9, 0], goal_yaw_tolerance: 3.15}
world: {walls: [{type: box, center: [3, 4.5], size: [10, 3]}]}
evaluator: {metrics: [duration]}
simulation: {duration: 60.0}
"""


def draw_errors() -> None:
    """Draws what a detector reports, and estimated poses on one drive."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    rows = recorded(LoadScenario(data=ERRORS), "visible_people", 20.0)
    rows = rows.reshape(len(rows), -1, 7)
    people, false = rows[:, :3].reshape(-1, 7), rows[:, 3:].reshape(-1, 7)
    for place, color, label in (
        (people, BLUE, "detections in 20 s"),
        (false, GRAY, "false detections"),
    ):
        place = place[place[:, 0] < 100]
        axes[0].plot(*place[:, :2].T, ".", color=color, ms=3, label=label)
    for person in LoadScenario(data=ERRORS).humans:
        disc = Circle(
            person.pose[:2], 0.25, fill=False, color=ORANGE, lw=2, zorder=3
        )
        axes[0].add_patch(disc)
    axes[0].plot([], [], "o", mfc="none", color=ORANGE, label="people")
    axes[0].add_patch(Circle((0, 0), 0.3, color="0.2"))
    for name, color, size in (
        ("odometry", ORANGE, "alpha1: 0.01, alpha2: 0.004, alpha3: 0.004"),
        ("gauss_markov", BLUE, "position_deviation: 0.2"),
    ):
        estimate = f"planner={{type: dwb, localization: {{type: {name},"
        estimate += f" {size}}}}}"
        scenario = LoadScenario(data=LOOP, overrides=[estimate])
        rows = recorded(scenario, "estimated_robot_state", 30.0)
        axes[1].plot(*rows[:, :2].T, color=color, lw=1, label=name)
        rows = recorded(scenario, "robot_state", 30.0)
        axes[1].plot(*rows[:, :2].T, color=color, lw=2, ls=":")
    axes[1].plot([], [], color="0.2", lw=2, ls=":", label="true ways")
    for wall in scenario.world.walls:
        axes[1].add_patch(Polygon(wall.vertices(), color="0.85"))
    for panel in axes:
        panel.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
        panel.legend(loc="best", fontsize="small")
    figure.savefig(FOLDER / "sensors_errors.png", dpi=80)


def recorded(scenario, name: str, end: float):
    """Returns what an output of a trial gives every 0.1 s."""
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    found = []
    for k in range(round(10 * end)):
        simulator.AdvanceTo(0.1 * k)
        found.append(
            diagram.GetOutputPort(name).Eval(simulator.get_context()).copy()
        )
    return np.array(found)


def main() -> None:
    """Draws them: one instant of a trial, and then errors."""
    scenario = LoadScenario(data=SCENARIO)
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(1.0)
    context = simulator.get_context()

    def output(name: str):
        return diagram.GetOutputPort(name).Eval(context)

    draw_scan(scenario, output)
    draw_images(output)
    draw_errors()
    for path in sorted(FOLDER.glob("sensors_*.png")):
        print(f"Wrote {path}, {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
