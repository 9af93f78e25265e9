"""Lidars with held inputs, and what they must measure, by closed forms."""

import numpy as np
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.sensing import Lidar, LidarConfig
from hunav_drake.systems.world.obstacles import Obstacles

NOWHERE = Obstacles.from_shapes([], solid=[])


class Moving(LeafSystem):
    """Gives a vector that is a function of the time."""

    def __init__(self, function):
        super().__init__()
        self._function = function
        size = np.size(function(0.0))
        self.DeclareVectorOutputPort("value", size, self._CalcValue)

    def _CalcValue(self, context, output):
        output.SetFromVector(np.ravel(self._function(context.get_time())))


def moved(dut, **functions):
    """Returns a diagram of a system with inputs that move, and its outputs."""
    builder = DiagramBuilder()
    builder.AddNamedSystem("dut", dut)
    for name, function in functions.items():
        source = builder.AddSystem(Moving(function))
        builder.Connect(source.get_output_port(), dut.GetInputPort(name))
    for i in range(dut.num_output_ports()):
        port = dut.get_output_port(i)
        builder.ExportOutput(port, port.get_name())
    return builder.Build()


def outputs(simulator, name, times):
    """Returns what an output of a simulated diagram gives at some times."""
    port = simulator.get_system().GetOutputPort(name)
    found = []
    for time in times:
        simulator.AdvanceTo(time)
        found.append(port.Eval(simulator.get_context()).copy())
    return np.array(found)


def rows(*bodies, radius=0.3) -> np.ndarray:
    """Returns bodies at rest at places (x, y) or (x, y, yaw), shape (n, 7)."""
    result = np.zeros((len(bodies), STATE_SIZE))
    for row, body in zip(result, bodies, strict=True):
        row[: len(body)] = body
    result[:, 6] = radius
    return result


def fix(lidar, context, *, robot=(0, 0, 0), people=()):
    """Holds the inputs of a lidar at a robot's pose and rows of people."""
    (state,) = rows(robot)
    lidar.get_robot_state_input_port().FixValue(context, state)
    lidar.get_human_states_input_port().FixValue(context, np.ravel(people))


def scan(config=None, *, obstacles=NOWHERE, robot=(0, 0, 0), people=()):
    """Returns one scan."""
    lidar = Lidar(config, obstacles=obstacles, num_humans=len(people))
    context = lidar.CreateDefaultContext()
    fix(lidar, context, robot=robot, people=people)
    return lidar.get_scan_output_port().Eval(context)


def to_segments(start, directions, segments):
    """Returns how far rays run to the nearest segment, by Cramer's rule.

    Rays begin at `start`, shape (2,), and have directions of shape (r, 2);
    segments have shape (s, 4).
    """
    a = segments[:, :2] - start
    along = segments[:, 2:] - segments[:, :2]
    u = directions[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        det = u[..., 0] * along[:, 1] - u[..., 1] * along[:, 0]
        far = (a[:, 0] * along[:, 1] - a[:, 1] * along[:, 0]) / det
        part = (a[:, 0] * u[..., 1] - a[:, 1] * u[..., 0]) / det
    hit = (far >= 0) & (part >= 0) & (part <= 1)
    return np.where(hit, far, np.inf).min(axis=1, initial=np.inf)


def to_discs(start, directions, discs):
    """Returns how far rays run to the nearest disc, rows (x, y, radius)."""
    d = start - discs[:, :2]
    b = directions @ d.T
    c = (d**2).sum(axis=1) - discs[:, 2] ** 2
    with np.errstate(invalid="ignore"):
        far = -b - np.sqrt(b**2 - c)
    far = np.where((b < 0) & (b**2 >= c), far, np.inf)
    return np.where(c <= 0, 0.0, far).min(axis=1, initial=np.inf)


def directions_of(config: LidarConfig, yaw: float) -> np.ndarray:
    """Returns where the rays of a lidar point, shape (r, 2)."""
    angles = yaw + config.angles()
    return np.column_stack([np.cos(angles), np.sin(angles)])
