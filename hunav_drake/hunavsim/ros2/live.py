"""Trials that run while others watch and drive them over ROS 2's topics."""

from collections.abc import Callable
import dataclasses
import sys
import time
from typing import Any

import numpy as np
from pydrake.systems.framework import Context

from hunav_drake.hunavsim.ros2.topics import LATCHED, TrialTopics
from hunav_drake.scenario.fleet import RobotPart, robot_parts, with_parts
from hunav_drake.scenario.schema import Scenario
from hunav_drake.systems.common.plain_errors import ConfigError
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.planning.ros2 import messages as m
from hunav_drake.systems.planning.ros2.bridge import BridgePlanner
from hunav_drake.systems.planning.ros2.dds import DdsNode, Reader
from hunav_drake.systems.planning.ros2.message_types import text_of, to_cdr
from hunav_drake.trial.diagram import MakeTrialDiagram, TrialDiagram
from hunav_drake.trial.result import TrialResult
from hunav_drake.trial.simulation import RunTrial

# Behind real time by more than this, in seconds, a run tells so.
_BEHIND, _TOLD_AGAIN = 0.5, 5.0


def with_bridge(scenario: Scenario, planner: BridgePlanner) -> Scenario:
    """Returns a scenario whose robots are all driven over topics.

    Period, perception and localization are those of their own planners; each
    robot has its name as namespace, and publishes the scan of its first lidar.

    Raises:
        ValueError: If a robot has no goal.
    """
    from hunav_drake.scenario.checks import first_lidar

    parts = []
    for part in robot_parts(scenario):
        own = part.scenario.planner
        if part.scenario.robot.goal is None:
            raise ValueError(
                f"the robot {part.name}".rstrip() + " has no goal, so its"
                " planner is never asked; set robot.goal, which /goal_pose may"
                " change later"
            )
        mine = dataclasses.replace(
            planner,
            period=own.period,
            sees=own.sees,
            localization=own.localization,
            namespace="" if part.name else planner.namespace,
            scan=own.sees.by_lidar or first_lidar(part.scenario) is not None,
        )
        changed = dataclasses.replace(part.scenario, planner=mine)
        parts.append(part._replace(scenario=changed))
    return with_parts(scenario, parts)


def RunBridge(
    scenario: Scenario,
    planner: BridgePlanner | None = None,
    *,
    tell: Callable[[str], None] | None = None,
    progress: Callable[[float], None] | None = None,
) -> TrialResult:
    """Runs a trial whose robots are driven by another program, such as Nav2.

    Besides the topics of its planner (see `BridgePlanner`), it publishes `/map`
    and `/tf_static` (also for those who come later), `/human_states`,
    `/robot_states`, `/people`, `/markers`, and the scans of further lidars. A
    goal on `/goal_pose` replaces that of the robot. Without lockstep, it runs
    in real time.

    Args:
        scenario: The scenario. Its planners are replaced.
        planner: The settings of the bridge; its period, perception,
            localization and scan are those of the scenario, and the namespace
            is the name of each of several robots.
        tell: Takes lines of text, when the trial falls behind real time or a
            goal cannot be taken; by default, they are written to the standard
            error.
        progress: Called after each step with the time, in seconds.

    Returns:
        The result; a missing command is a planner that failed.

    Raises:
        ImportError: If rosbags or Cyclone DDS is not installed.
        ScenarioError: If the scenario cannot be simulated.
        ValueError: If a robot has no goal, or the network interface is not
            there.
    """
    planner = planner or BridgePlanner()
    scenario = with_bridge(scenario, planner)
    diagram = MakeTrialDiagram(scenario)
    node = DdsNode(planner.domain, planner.network)
    say = tell or (lambda line: print(line, file=sys.stderr))
    publish = _Publisher(diagram, node, say, planner.namespace)
    pace = _Pace(say)

    def watch(context: Context) -> bool:
        publish(context)
        if not planner.lockstep:
            pace(context.get_time())
        return True

    return RunTrial(
        scenario,
        diagram=diagram,
        realtime_rate=0.0 if planner.lockstep else 1.0,
        watch=watch,
        progress=progress,
    )


class _Publisher:
    """Publishes what planners do not, and takes goals."""

    def __init__(
        self,
        diagram: TrialDiagram,
        node: DdsNode,
        tell: Callable[[str], None],
        namespace: str,
    ) -> None:
        self._diagram, self._node, self._tell = diagram, node, tell
        self._topics = TrialTopics(diagram, namespace)
        self._goals: list[tuple[RobotPart, Reader]] = []
        self._faults: dict[str, str] = {}
        self._skip = {"/clock", "/tf"}
        for part in robot_parts(diagram.scenario):
            prefix, _ = self._topics.frames_of(part)
            self._skip |= {prefix + it for it in ("/odom", "/goal_pose")}
            planner = part.scenario.planner
            assert isinstance(planner, BridgePlanner)
            if planner.scan:
                self._skip.add(f"{prefix}/scan")
            # (Not those that the planner itself tells.)
            self._goals.append((part, planner.link(part.name).read_goals()))
        for topic, told in self._topics.constants():
            if topic not in self._skip:
                node.publish(topic, told, latched=topic in LATCHED)

    def __call__(self, context: Context) -> None:
        found = self._topics.at(
            context, commands=False, wanted=self._node.is_read
        )
        for topic, told in found:
            if topic not in self._skip:
                self._node.publish(topic, told)
        for part, reader in self._goals:
            for told in reader.take():
                self._take_goal(context, part, told)

    def _take_goal(self, context: Context, part: RobotPart, told: Any) -> None:
        """Sets a goal, or tells, once, why it cannot be taken."""
        prefix, frame = self._topics.frames_of(part)
        at, where = told.pose, told.header.frame_id.removeprefix("/")
        yaw = m.yaw_of(at.orientation)
        goal = (at.position.x, at.position.y, yaw)
        # (The frame odom is always at that of the map.)
        if where not in ("", "map", f"{frame}odom"):
            fault = f"is in the frame {shown(where)}; send it in map"
        else:
            fault = ""
            try:
                dataclasses.replace(part.scenario.robot, goal=goal)
            except ConfigError as error:
                _, _, fault = " ".join(str(error).split()).partition(": ")
        if fault and fault != self._faults.get(part.name):
            self._tell(f"the goal on {prefix}/goal_pose is not taken: {fault}")
        self._faults[part.name] = fault
        if not fault:
            SetGoal(self._diagram, context, np.array(goal), part.prefix)


def SetGoal(
    diagram: TrialDiagram, context: Context, goal: Any, prefix: str = ""
) -> None:
    """Sets the goal (x, y, yaw) of a robot that has one, in its Context."""
    source = diagram.GetSubsystemByName(f"{prefix}goal")
    own = source.GetMyMutableContextFromRoot(context)
    source.get_mutable_source_value(own).SetFromVector(goal)


class _Pace:
    """Tells when a trial falls behind real time."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell = tell
        self._begin: float | None = None
        self._last = -_TOLD_AGAIN

    def __call__(self, seconds: float) -> None:
        now = time.monotonic()
        if self._begin is None:
            self._begin = now - seconds
        behind = now - self._begin - seconds
        if behind > _BEHIND and now - self._last > _TOLD_AGAIN:
            self._last = now
            self._tell(
                f"at {seconds:.1f} s the trial is {behind:.1f} s behind real"
                " time"
            )


class FoxgloveTopics:
    """Shows a running trial in Foxglove: publishes its topics on a port.

    Only this machine can connect, at `address`.
    """

    def __init__(self, diagram: TrialDiagram, port: int = 8765) -> None:
        """Constructs FoxgloveTopics, and starts to listen.

        Raises:
            ImportError: If foxglove-sdk or rosbags is not installed.
            OSError: If the port is taken.
        """
        try:
            import foxglove
        except ImportError as error:
            raise ImportError(
                "Foxglove needs foxglove-sdk: pip install 'hunav_drake[ros]'"
            ) from error
        self._topics = TrialTopics(diagram)
        self._constants = list(self._topics.constants())
        self._channels: dict[str, Any] = {}
        self._sent = -np.inf
        self._context = foxglove.Context()
        try:
            self._server = foxglove.start_server(
                name="hunav_drake", port=port, context=self._context
            )
        except RuntimeError as error:
            raise OSError(f"port {port} cannot be used: {error}") from error
        self.address = f"ws://127.0.0.1:{self._server.port}"

    def Publish(self, context: Context) -> bool:
        """Publishes the topics at the time of a Context; returns true.

        What does not change is sent once a second, for those who come later.
        """
        time = context.get_time()
        told = list(self._topics.at(context))
        if not 0 <= time - self._sent < 1.0:
            self._sent = time
            told = [*self._constants, *told]
        for topic, sent in told:
            if topic not in self._channels:
                self._channels[topic] = self._channel(topic, sent.__msgtype__)
            stamp = m.nanoseconds(m.stamp(time))
            self._channels[topic].log(to_cdr(sent), log_time=stamp)
        return True

    def Close(self) -> None:
        """Ends the connections."""
        self._server.stop()

    def _channel(self, topic: str, type_name: str) -> Any:
        import foxglove

        schema = foxglove.Schema(
            name=type_name, encoding="ros2msg", data=text_of(type_name).encode()
        )
        return foxglove.Channel(
            topic, message_encoding="cdr", schema=schema, context=self._context
        )
