"""A planner in a process of its own that knows its trial by DDS alone.

    python -m tests.dds_planner SCENARIO [KEY=VALUE ...]

As Nav2 has its map and its parameters, it has the scenario, of which it takes
the walls, the robot's limits and the planner. It answers each observation with
a stamped command, from its memory of the cycle before. HUNAV_TEST_FAULT makes
it answer late, never, nonsense, or with stale stamps, from the fifth cycle on.
"""

import os
import sys
import time

import numpy as np

from hunav_drake import LoadScenario
from hunav_drake.systems.common.layout import OUTSIDE, STATE_SIZE
from hunav_drake.systems.planning import PlanningTask, View
from hunav_drake.systems.planning.ros2 import DdsNode, message, messages as m

TWIST = "geometry_msgs/msg/TwistStamped"


def task_of(scenario):
    robot = scenario.robot
    return PlanningTask(
        limits=robot.limits,
        robot_radius=robot.radius,
        goal_tolerance=robot.goal_tolerance,
        goal_yaw_tolerance=robot.goal_yaw_tolerance,
        obstacles=scenario.world.obstacles(),
        num_humans=len(scenario.humans),
        time_step=scenario.simulation.time_step,
    )


def view_of(observation, goal, count, seconds):
    robot = m.row_of(observation.agents[0])
    humans = np.zeros((count, STATE_SIZE))
    humans[:, :2] = OUTSIDE
    for told in observation.agents[1:]:
        humans[told.id - 1] = m.row_of(told)
    return View(np.array(robot), humans, np.array(goal), None, seconds)


def serve(scenario, fault=""):
    planner, task = scenario.planner, task_of(scenario)
    period = round(planner.period * 1e9)
    memories = {0: planner.initial_memory}
    node = DdsNode()
    observations = node.subscribe("/observation", "hunav_msgs/msg/Agents")
    goals = node.subscribe("/goal_pose", "geometry_msgs/msg/PoseStamped")
    node.advertise("/cmd_vel", TWIST)
    goal, cycles = None, 0
    while True:
        time.sleep(1e-4)
        for told in goals.take():
            at = told.pose
            yaw = m.yaw_of(at.orientation)
            goal = (at.position.x, at.position.y, yaw)
        if goal is None:
            continue
        for told in observations.take():
            stamp = m.nanoseconds(told.header.stamp)
            seconds = stamp * 1e-9
            view = view_of(told, goal, task.num_humans, seconds)
            # (One that comes in between begins anew.)
            memory = memories.get(stamp, planner.initial_memory)
            plan = planner.plan(task, view, memory)
            memories[stamp + period] = plan.memory
            cycles += 1
            command = m.twist(plan.v, 0.0, plan.omega)
            if cycles >= 5 and fault:
                if fault == "never":
                    continue
                if fault == "late":
                    time.sleep(0.05)
                if fault == "nonsense":
                    command = m.twist(np.nan, 0.0, 1.0)
            header = m.header(0.0, "base_link")
            if fault != "stale" or cycles < 5:
                header.stamp = told.header.stamp
            node.publish(
                "/cmd_vel", message(TWIST, header=header, twist=command)
            )


if __name__ == "__main__":
    serve(
        LoadScenario(filename=sys.argv[1], overrides=sys.argv[2:]),
        os.environ.get("HUNAV_TEST_FAULT", ""),
    )
