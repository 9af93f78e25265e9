"""Draws `sensors_scan.png` and `sensors_camera.png`: what a robot senses.

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


def main() -> None:
    """Draws both, at one instant of a trial."""
    scenario = LoadScenario(data=SCENARIO)
    diagram = MakeTrialDiagram(scenario)
    simulator = MakeTrialSimulator(diagram)
    simulator.AdvanceTo(1.0)
    context = simulator.get_context()

    def output(name: str):
        return diagram.GetOutputPort(name).Eval(context)

    draw_scan(scenario, output)
    draw_images(output)
    for path in sorted(FOLDER.glob("sensors_*.png")):
        print(f"Wrote {path}, {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
