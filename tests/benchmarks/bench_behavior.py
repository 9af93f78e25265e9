"""How long behavior trees take: `python tests/benchmarks/bench_behavior.py`.

Prints how long a thousand people take to build, beside one parse of their
tree; microseconds per tick of a tree alone, and per person and step of the
systems in a diagram, beside a crowd that only reads the commands; the time of
whole diagrams: with a system for each tree, with one system that ticks the
trees in a Python loop, and with the behavior written out in Python; and how
many times faster than real time a whole trial with curious people is.
"""

import dataclasses
import math
import time
import timeit

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, Multiplexer

from hunav_drake.systems.behavior import (
    BehaviorTree,
    LoadTree,
    ParseTree,
    Person,
)
from hunav_drake.systems.common.layout import (
    COMMAND_SIZE,
    RADIUS,
    STATE_SIZE,
    YAW,
    Command,
    X,
    Y,
)
from hunav_drake.systems.crowd import HumanCrowd
from hunav_drake.systems.evaluation import Evaluator
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.robot import DifferentialDrive, DifferentialDriveConfig

TIME_STEP = 0.05
HUMAN = HumanConfig(
    pose=(0.0, 0.0, 0.0), goals=[(50.0, 0.0), (0.0, 0.0)], cyclic=True
)
ROBOT = np.array([2.0, 1.0, 0, 0, 0, 0, 0.35])

# Ten nodes, all of which are ticked.
TEN_NODES = (
    "<root><BehaviorTree><Sequence>"
    + "<AlwaysSuccess/>" * 9
    + "</Sequence></BehaviorTree></root>"
)


class DummyCrowd(LeafSystem):
    """Reads the commands, moves all people by a little."""

    def __init__(self, n):
        super().__init__()
        self._commands = self.DeclareVectorInputPort(
            "commands", n * COMMAND_SIZE
        )
        self._state = self.DeclareDiscreteState(STATE_SIZE * n)
        self.DeclareStateOutputPort("human_states", self._state)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=TIME_STEP, offset_sec=0.0, update=self._Update
        )

    def _Update(self, context, discrete_state):
        self._commands.Eval(context)
        x = context.get_discrete_state(self._state).value() + 0.001
        discrete_state.set_value(self._state, x)


def us_per_step(n, tree):
    """Returns the time of a step of n people; without trees if it is None."""
    builder = DiagramBuilder()
    crowd = builder.AddSystem(DummyCrowd(n))
    robot = builder.AddSystem(ConstantVectorSource(ROBOT))
    commands = builder.AddSystem(Multiplexer([COMMAND_SIZE] * n))
    builder.Connect(commands.get_output_port(), crowd.get_input_port())
    for i in range(n):
        if tree is None:
            system = builder.AddSystem(
                ConstantVectorSource(np.zeros(COMMAND_SIZE))
            )
        else:
            system = builder.AddNamedSystem(
                f"tree_{i}", BehaviorTree([tree], [HUMAN] * n, indices=[i])
            )
            builder.Connect(
                crowd.get_output_port(), system.get_human_states_input_port()
            )
            builder.Connect(
                robot.get_output_port(), system.get_robot_states_input_port()
            )
        builder.Connect(system.get_output_port(0), commands.get_input_port(i))
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    steps = 200
    best = np.inf
    for i in range(1, 6):
        start = time.perf_counter()
        simulator.AdvanceTo(i * steps * TIME_STEP)
        best = min(best, time.perf_counter() - start)
    return best / steps * 1e6


def us_near_goals(n):
    """Returns the time of a person's tick in a crowd near its goals.

    A tenth of the people stand; all are within the distance of their goals at
    which others who stand there might bar the way: 0.4 m times the square root
    of their number.
    """
    rng = np.random.default_rng(0)
    states = np.zeros((n, STATE_SIZE))
    states[:, :2] = rng.uniform(0, math.sqrt(n / 0.3), (n, 2))
    states[:, 3] = rng.uniform(0, 1, n)
    states[:, RADIUS] = 0.35
    shift = rng.uniform(-0.2, 0.2, (n, 2)) * math.sqrt(n)
    humans = [
        HumanConfig(pose=(x, y, 0.0), goals=[(x + dx, y + dy)])
        for (x, y), (dx, dy) in zip(
            states[:, :2].tolist(), shift.tolist(), strict=True
        )
    ]
    trees = BehaviorTree([LoadTree("regular")] * n, humans, num_robots=0)
    context = trees.CreateDefaultContext()
    port = trees.get_human_states_input_port()
    best = math.inf
    for _ in range(5):
        port.FixValue(context, states.ravel())
        start = time.process_time()
        trees.get_commands_output_port().Eval(context)
        best = min(best, time.process_time() - start)
    return best / n * 1e6


def us_per_tick(tree):
    person = Person.from_config(HUMAN, 0, time_step=TIME_STEP)
    memory = tree.initial_memory(person)
    states = np.zeros(STATE_SIZE)
    number = 20_000
    return (
        min(
            timeit.repeat(
                lambda: tree.tick(person, memory, states, ROBOT),
                number=number,
                repeat=5,
            )
        )
        / number
        * 1e6
    )


class Loop(LeafSystem):
    """Ticks the trees of all people in a Python loop, for one simulation.

    It keeps the memories in its own attributes: what is the least that the
    trees take without Drake.
    """

    def __init__(self, humans):
        super().__init__()
        n = len(humans)
        self._humans = humans
        self._tree = LoadTree("curious")
        self._people = [
            Person.from_config(human, i, time_step=TIME_STEP)
            for i, human in enumerate(humans)
        ]
        self._memories = [self._tree.initial_memory(p) for p in self._people]
        self._commands = None
        self._time = -1.0
        self._states = self.DeclareVectorInputPort(
            "human_states", n * STATE_SIZE
        )
        self._robot = self.DeclareVectorInputPort("robot_state", STATE_SIZE)
        self.DeclareVectorOutputPort(
            "commands",
            n * COMMAND_SIZE,
            lambda context, output: output.SetFromVector(self._all(context)),
            prerequisites_of_calc={self.all_input_ports_ticket()},
        )

    def _all(self, context):
        if context.get_time() != self._time:
            self._time = context.get_time()
            self._commands = np.array(
                self._decide(
                    self._states.EvalBasicVector(context).value(),
                    self._robot.EvalBasicVector(context).value(),
                )
            ).ravel()
        return self._commands

    def _decide(self, states, robot):
        commands = []
        for i, person in enumerate(self._people):
            outcome = self._tree.tick(person, self._memories[i], states, robot)
            self._memories[i] = outcome.memory
            commands.append(outcome.command)
        return commands


class WrittenOut(Loop):
    """Has the curious behavior written out in Python, instead of trees."""

    def __init__(self, humans):
        super().__init__(humans)
        self._goals = [0] * len(humans)
        self._timers = [0.0] * len(humans)

    def _decide(self, states, robot):
        rows = states.reshape(-1, STATE_SIZE).tolist()
        robot = robot.tolist()
        return [self._one(i, row, robot) for i, row in enumerate(rows)]

    def _one(self, i, state, robot):
        human = self._humans[i]
        command = [0.0] * COMMAND_SIZE
        command[Command.GOAL_RADIUS] = human.goal_radius
        command[Command.HAS_GOAL] = 1.0
        command[Command.DESIRED_SPEED] = human.desired_speed
        command[Command.MAX_SPEED] = human.speed_limit
        command[Command.GROUP_ID] = human.group_id
        dx, dy = robot[X] - state[X], robot[Y] - state[Y]
        distance = math.hypot(dx, dy)
        if distance <= 10.0:
            bearing = math.atan2(dy, dx)
            turn = math.remainder(bearing - state[YAW], 2 * math.pi)
            if abs(turn) <= math.pi / 2 + 0.17:
                timer = self._timers[i] + TIME_STEP
                if timer < 30.0:
                    self._timers[i] = timer
                    if distance <= 1.5:
                        command[Command.HOLD] = 1.0
                        command[Command.TURN_RATE] = math.pi
                        command[Command.YAW_TARGET] = bearing
                    else:
                        speed = min(0.18 * distance, human.speed_limit)
                        command[Command.GOAL_X] = robot[X]
                        command[Command.GOAL_Y] = robot[Y]
                        command[Command.GOAL_RADIUS] = robot[RADIUS]
                        command[Command.DESIRED_SPEED] = speed
                        command[Command.MAX_SPEED] = speed
                    return command
        goal = human.goals[self._goals[i]]
        reached = math.hypot(goal[0] - state[X], goal[1] - state[Y])
        if reached <= human.goal_radius + 0.1:
            self._goals[i] = (self._goals[i] + 1) % len(human.goals)
            goal = human.goals[self._goals[i]]
        command[Command.GOAL_X], command[Command.GOAL_Y] = goal
        command[Command.ROBOT_ROLE] = 1.0
        return command


def seconds_of_a_diagram(n, kind):
    """Returns the time of 30 simulated seconds of n curious people."""
    humans = [
        HumanConfig(
            pose=(3.0 * (i % 10), 3.0 * (i // 10), 0.0),
            goals=[(40.0, 3.0 * (i // 10)), (0.0, 3.0 * (i // 10))],
            cyclic=True,
        )
        for i in range(n)
    ]
    builder = DiagramBuilder()
    crowd = builder.AddSystem(HumanCrowd(humans))
    robot = builder.AddSystem(
        DifferentialDrive(DifferentialDriveConfig(start=(-2.0, -2.0, 0.0)))
    )
    drive = builder.AddSystem(ConstantVectorSource([0.3, 0.02]))
    evaluator = builder.AddSystem(Evaluator(humans))
    states = crowd.get_human_states_output_port()
    robot_state = robot.get_robot_state_output_port()
    builder.Connect(drive.get_output_port(), robot.get_input_port())
    builder.Connect(robot_state, crowd.get_robot_states_input_port())
    builder.Connect(states, evaluator.GetInputPort("human_states"))
    builder.Connect(robot_state, evaluator.GetInputPort("robot_state"))
    if kind != "systems":
        loop = builder.AddSystem(
            Loop(humans) if kind == "loop" else WrittenOut(humans)
        )
        builder.Connect(states, loop.GetInputPort("human_states"))
        builder.Connect(robot_state, loop.GetInputPort("robot_state"))
        commands = loop.get_output_port()
    else:
        tree = LoadTree("curious")
        joined = builder.AddSystem(Multiplexer([COMMAND_SIZE] * n))
        commands = joined.get_output_port()
        for i in range(n):
            system = builder.AddNamedSystem(
                f"tree_{i}", BehaviorTree([tree], humans, indices=[i])
            )
            builder.Connect(states, system.GetInputPort("human_states"))
            builder.Connect(robot_state, system.GetInputPort("robot_states"))
            builder.Connect(
                system.GetOutputPort("commands"), joined.get_input_port(i)
            )
    builder.Connect(commands, crowd.get_commands_input_port())
    simulator = Simulator(builder.Build())
    simulator.Initialize()
    start = time.perf_counter()
    simulator.AdvanceTo(30.0)
    return time.perf_counter() - start, crowd.GetMyContextFromRoot(
        simulator.get_context()
    ).get_discrete_state(0).value().copy()


def real_time_factor(n):
    """Returns how fast a whole trial with n curious people is."""
    from hunav_drake import LoadScenario, MakeTrialDiagram, MakeTrialSimulator

    scenario = LoadScenario(filename="crossing")
    humans = [
        HumanConfig(
            pose=(-5.0 + i % 10, -9.0 + 3.5 * (i // 10), 0.0),
            goals=[(4.0, -9.0 + 3.5 * (i // 10)), (-4.0, 0.0)],
            cyclic=True,
            radius=0.3,
            behavior="curious",
        )
        for i in range(n)
    ]
    scenario = dataclasses.replace(
        scenario,
        humans=humans,
        robot=dataclasses.replace(
            scenario.robot, goal_tolerance=1e-6, goal_yaw_tolerance=1e-6
        ),
        simulation=dataclasses.replace(scenario.simulation, stuck_time=1e4),
    )
    best = np.inf
    for _ in range(3):
        simulator = MakeTrialSimulator(MakeTrialDiagram(scenario))
        simulator.Initialize()
        start = time.perf_counter()
        simulator.AdvanceTo(60.0)
        best = min(best, time.perf_counter() - start)
    return 60.0 / best


def build_and_parse(n):
    """Returns how long it takes to build n curious people, and one parse."""
    from hunav_drake import MakeHumans
    from hunav_drake.systems.behavior.library import _parse

    humans = [
        HumanConfig(
            pose=(3.0 * (i % 30), 3.0 * (i // 30), 0.0),
            goals=[(40.0, 0.0)],
            behavior="curious",
        )
        for i in range(n)
    ]
    build = parse = np.inf
    for _ in range(5):
        _parse.cache_clear()
        start = time.perf_counter()
        LoadTree("curious")
        parsed = time.perf_counter()
        _parse.cache_clear()
        MakeHumans(humans)
        parse = min(parse, parsed - start)
        build = min(build, time.perf_counter() - parsed)
    return build, parse


def main():
    build, parse = build_and_parse(1000)
    print(
        f"building 1000 curious people: {build:.2f} s, {build / parse:.0f}"
        f" times a parse of their tree ({1e3 * parse:.1f} ms)"
    )
    trees = {
        "ten nodes": ParseTree(TEN_NODES),
        "regular": LoadTree("regular"),
        "curious": LoadTree("curious"),
    }
    print("us per person and tick in a crowd that stands and walks near goals")
    for n in (200, 2000, 5000):
        print(f"{n:6} people: {us_near_goals(n):.1f}")
    print("us per tick of a tree")
    for name, tree in trees.items():
        print(f"  {name:10s} {us_per_tick(tree):6.2f}")
    print("us per person and step of BehaviorTree in a diagram")
    for n in (5, 20, 50):
        base = us_per_step(n, None)
        for name in ("regular", "curious"):
            cost = (us_per_step(n, trees[name]) - base) / n
            print(f"  n = {n:2d} {name:10s} {cost:6.2f}")
    print("ms per simulated second of crowd, curious people, robot, evaluator")
    kinds = ("systems", "loop", "written out")
    for n in (5, 20, 50):
        best = dict.fromkeys(kinds, np.inf)
        ends = {}
        for _ in range(5):
            for kind in kinds:
                seconds, ends[kind] = seconds_of_a_diagram(n, kind)
                best[kind] = min(best[kind], 1e3 / 30 * seconds)
        for kind in kinds:
            np.testing.assert_allclose(ends[kind], ends["loop"], atol=1e-6)
        systems, loop, written_out = best.values()
        print(
            f"  n = {n:2d}  a system for each tree {systems:6.2f},"
            f" a loop over the trees {loop:6.2f} (ratio {systems / loop:.2f}),"
            f" written out {written_out:6.2f} ({systems / written_out:.2f})"
        )
    print("times real time of a whole trial with curious people")
    for n in (5, 50):
        print(f"  n = {n:2d} {real_time_factor(n):6.0f}")


if __name__ == "__main__":
    main()
