"""A scene in which a robot that sees nobody meets two people."""

SCENE = """
robot: {start: [-3, 0, 0], goal: [3, 0, 0]}
planner: {type: pursuit, sees: {type: visible, range_max: 0.05}}
humans:
  - {name: ana, pose: [0, 3, -1.57], goals: [[0, -3]], behavior: distracted}
  - {name: luis, pose: [4, 4, 0], goals: [[-4, 4]]}
simulation: {duration: 12.0}
"""

SPACE = """
scenario: scene.yaml
robustness: collision
space:
  humans.ana.pose[0]: [-2, 2]
  humans.ana.pose[1]: [1, 4]
  humans.ana.desired_speed: [0.6, 1.6]
  humans.luis.behavior: {choices: [regular, curious]}
require: {start_gap: 0.5}
"""


def write_space(folder, text=SPACE, scene=SCENE):
    """Writes scene and space to a folder, and returns the file of the space."""
    (folder / "scene.yaml").write_text(scene)
    path = folder / "space.yaml"
    path.write_text(text)
    return path
