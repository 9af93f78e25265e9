"""A planner beyond ROS 2's topics, such as Nav2."""

from collections.abc import Iterator
import functools
import importlib.util
import math
import os
import re
import socket
import time
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import AfterValidator, Field, StrictBool, StrictFloat
from pydantic.dataclasses import dataclass
from pydantic_core import PydanticCustomError

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import CONFIG, Integer, Name, within
from hunav_drake.systems.common.suggest import shown
from hunav_drake.systems.planning.cycles import is_interrupted
from hunav_drake.systems.planning.planner import (
    Plan,
    PlannerStatus,
    PlanningTask,
    View,
    register_planner,
)
from hunav_drake.systems.planning.planner_error import PlannerError
from hunav_drake.systems.planning.pure_planner import Planner
from hunav_drake.systems.world.obstacles import Obstacles


def _namespace(text: str) -> str:
    if text and not re.fullmatch("[A-Za-z][A-Za-z0-9_]*", text, re.ASCII):
        rule = "must begin with a letter, followed by letters, digits or _"
        raise PydanticCustomError("namespace", rule)
    return text


# How long a trial listens for another one with the same topics, in seconds:
# those that wait tell their observation again each second.
_LISTENING = 1.5


class BridgeMemory(NamedTuple):
    """What is left of the last cycle.

    Attributes:
        goal: The goal that was told last; empty before.
        stamp: The time of the last command, in nanoseconds; -1 before.
        command: That command (v, omega), in m/s and rad/s.
    """

    goal: tuple[float, ...] = ()
    stamp: int = -1
    command: tuple[float, float] = (0.0, 0.0)


@explain
@register_planner("bridge")
@dataclass(kw_only=True, config=CONFIG)
class BridgePlanner(Planner):
    """Asks another program for commands, over ROS 2's topics (DDS).

    In each cycle it publishes what it observes: `/observation` (the robot and
    the people that it perceives, as hunav_msgs/Agents), `/odom`, `/tf`,
    `/scan`, `/goal_pose` when the goal is new, and then `/clock`. In lockstep
    it then waits for the command of this cycle on `/cmd_vel`; else it takes the
    last one that has come. In lockstep, a trial is as repeatable as the other
    program is.
    """

    initial_memory: ClassVar[Any] = BridgeMemory()

    lockstep: StrictBool = True
    """Whether each cycle waits for its command; otherwise the trial goes on
    with the last one."""

    time_limit: Annotated[StrictFloat, within(0, 3600, "s", low_open=True)] = (
        10.0
    )
    """Longest wait for a command in lockstep, and at the start for somebody who
    publishes commands, in seconds of wall-clock time."""

    hold_time: Annotated[StrictFloat, within(0, 3600, "s", low_open=True)] = 0.5
    """Without lockstep, time until the robot stops if no new command comes, in
    seconds."""

    command_type: Literal["Twist", "TwistStamped"] = "Twist"
    """Type of the commands. Stamped ones are matched by their stamps: in
    lockstep, those before the time of the cycle do not count."""

    namespace: Annotated[Name, AfterValidator(_namespace)] = ""
    """First part of the names of topics and frames; by default, the name of one
    of several robots. `/clock` and the frame `map` have none."""

    scan: StrictBool = False
    """Whether it publishes the scan of the robot's first lidar."""

    domain: Annotated[Integer, Field(ge=0, le=232)] | None = None
    """Number of the DDS domain; by default that of the environment variable
    ROS_DOMAIN_ID, or 0."""

    network: Annotated[str, Field(min_length=1, max_length=60)] = "lo"
    """Network interface; `lo` is this machine alone."""

    def find_faults(
        self, obstacles: Obstacles, start: Array, goal: Array
    ) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yields what is missing on this machine."""
        for package in ("rosbags", "cyclonedds"):
            if importlib.util.find_spec(package) is None:
                yield (
                    (),
                    f"bridge needs {package}: pip install 'hunav_drake[ros]'",
                )
                return
        from hunav_drake.systems.planning.ros2.dds import default_domain

        try:
            default_domain()
        except ValueError as error:
            if self.domain is None:
                yield ("domain",), str(error)
        known = [name for _, name in socket.if_nameindex()]
        if self.network not in known and not os.environ.get("CYCLONEDDS_URI"):
            yield (
                ("network",),
                f"there is no network interface {shown(self.network)};"
                f" valid: {', '.join(known)}",
            )

    # (A property in place of a class variable.)
    @property
    def scan_size(self) -> int | None:  # type: ignore[override]
        """See `Planner`."""
        return None if self.scan else 0

    def link(self, robot_name: str) -> "Link":
        """Returns the topics of a robot; all trials of a process share them."""
        from hunav_drake.systems.planning.ros2.dds import default_domain
        from hunav_drake.systems.planning.ros2.messages import ros_name

        domain = default_domain() if self.domain is None else self.domain
        namespace = ros_name(self.namespace or robot_name)
        return _link(domain, self.network, namespace, self.command_type)

    def plan(self, task: PlanningTask, view: View, memory: Any) -> Plan:
        """Decides the command of one cycle: see `Planner.plan`."""
        assert isinstance(memory, BridgeMemory)
        link = self.link(task.robot_name)
        link.check_robot(view.time, task.robot_name)
        if view.scan is not None:
            link.advertise_scan()
        link.meet(view.time, self.time_limit, answers=self.lockstep)
        link.check_alone(view.time)
        link.forget_commands()
        if memory == self.initial_memory:
            # (It was meant for the trial before.)
            link.last_command = None
        goal = tuple(view.goal.tolist())
        link.tell(task, view, with_goal=goal != memory.goal)
        now = round(view.time * 1e9)
        if self.lockstep:
            found = link.wait_for(task, view, self.time_limit)
        else:
            found, link.last_command = link.last_command, None
        if found is not None:
            memory = BridgeMemory(goal, now, found)
        v, omega = memory.command
        reason = ""
        if memory.stamp < 0 or now - memory.stamp > self.hold_time * 1e9:
            v = omega = 0.0
            reason = link.why_silent() or f"no command comes on {link.topic}"
        memory = memory._replace(goal=goal)
        if not (math.isfinite(v) and math.isfinite(omega)):
            text = f"v = {v}, omega = {omega}"
            text = f"a command on {link.topic} is not finite: {text}"
            raise PlannerError("bridge", view.time, text)
        return Plan(
            v, omega, PlannerStatus.DRIVING, memory=memory, reason=reason
        )


class Link:
    """The topics of a bridge. What it holds belongs to the other program."""

    def __init__(
        self, domain: int, network: str, namespace: str, kind: str
    ) -> None:
        from hunav_drake.systems.planning.ros2.dds import DdsNode

        self._prefix = f"/{namespace}" if namespace else ""
        self._frame = f"{namespace}/" if namespace else ""
        self.topic = f"{self._prefix}/cmd_vel"
        self._stamped = kind == "TwistStamped"
        self._kind = f"geometry_msgs/msg/{kind}"
        self._node = DdsNode(domain, network)
        self._commands = self._node.subscribe(self.topic, self._kind)
        self._goal = f"{self._prefix}/goal_pose"
        self._goal_arrivals = 0
        self._observation = f"{self._prefix}/observation"
        for topic, kind in (
            ("/clock", "rosgraph_msgs/msg/Clock"),
            ("/tf", "tf2_msgs/msg/TFMessage"),
            (self._goal, "geometry_msgs/msg/PoseStamped"),
            (f"{self._prefix}/odom", "nav_msgs/msg/Odometry"),
            (self._observation, "hunav_msgs/msg/Agents"),
        ):
            self._node.advertise(topic, kind)
        self.last_command: tuple[float, float] | None = None
        self._others = self._node.subscribe(
            self._observation, "hunav_msgs/msg/Agents", reliable=False
        )
        self._checked = -math.inf
        self._listened = self._met = False
        self._asked = (-1.0, "")

    def read_goals(self) -> Any:
        """Returns a reader of the goals that others set."""
        return self._node.subscribe(self._goal, "geometry_msgs/msg/PoseStamped")

    def advertise_scan(self) -> None:
        """Lets others find the scan before its first message."""
        kind = "sensor_msgs/msg/LaserScan"
        self._node.advertise(f"{self._prefix}/scan", kind)

    def meet(self, now: float, limit: float, *, answers: bool) -> None:
        """Waits, the first time, with `answers`, for who publishes commands.

        If another process has the same topics, it first listens whether a trial
        runs there; an idle one, as in a notebook, does no harm.
        """
        if self._met or (self._listened and not answers):
            return
        begin = time.monotonic()
        while True:
            self.check_alone(now)
            _check_interrupt(now)
            waited = time.monotonic() - begin
            if not (why := self.why_silent() if answers else ""):
                if waited > _LISTENING or not self._has_others():
                    break
            elif waited > limit:
                raise PlannerError(
                    "bridge", now, f"{why} (after time_limit = {limit:g} s)"
                )
            time.sleep(0.01)
        self._listened = True
        if answers:
            # (Until its readers are found, too.)
            time.sleep(0.1)
            self._met = True

    def check_robot(self, now: float, robot_name: str) -> None:
        """Raises PlannerError if another robot has the topics at this time."""
        time_asked, other = self._asked
        if time_asked == now and other != robot_name:
            raise PlannerError(
                "bridge",
                now,
                f"the robots {other!r} and {robot_name!r} have the same topics;"
                " give their planners other namespaces",
            )
        self._asked = (now, robot_name)

    def check_alone(self, now: float) -> None:
        """Raises PlannerError if a trial runs now with the same topics.

        It would get the same commands.
        """
        before, self._checked = self._checked, time.monotonic()
        heard = self._others.take()
        # (What was told while this one rested does no harm.)
        if heard and self._checked < before + 1.0 and self._has_others():
            raise PlannerError(
                "bridge",
                now,
                f"another trial publishes {self._observation} on DDS domain"
                f" {self._node.domain}, network {self._node.network}; run one"
                " after the other (`--workers 1`), or each with a ROS_DOMAIN_ID"
                " of its own",
            )

    def _has_others(self) -> bool:
        """Returns whether another process publishes the same topics."""
        return bool(self._node.published_types(self._observation, beyond=True))

    def why_silent(self) -> str:
        """Returns why no command can come; empty if one may come."""
        if self._commands.num_writers:
            return ""
        found = self._node.published_types(self.topic)
        if others := [it for it in found if it != self._kind]:
            return (
                f"{self.topic} is published as {', '.join(others)}, not as"
                f" {self._kind}; choose the other command_type (`hunav bridge"
                " --stamped` takes TwistStamped)"
            )
        if found:
            return f"{self.topic} is published best effort; make it reliable"
        return (
            f"nobody publishes {self.topic} on DDS domain"
            f" {self._node.domain}, network {self._node.network}; start the"
            " other program first, with the same ROS_DOMAIN_ID"
        )

    def tell(self, task: PlanningTask, view: View, *, with_goal: bool) -> None:
        """Publishes what a cycle observes."""
        from hunav_drake.systems.planning.ros2 import messages as m

        now, robot = view.time, view.robot
        node, prefix, frame = self._node, self._prefix, self._frame
        odom, base = f"{frame}odom", f"{frame}base_link"
        arrivals = node.num_arrivals(self._goal)
        # (Also for who begins to read it now.)
        if with_goal or arrivals > self._goal_arrivals:
            goal = m.pose_stamped(now, "map", view.goal.tolist())
            node.publish(self._goal, goal)
        self._goal_arrivals = arrivals
        node.publish(f"{prefix}/odom", m.odometry(now, robot, odom, base))
        poses = m.transforms(
            m.transform(now, "map", odom),
            m.transform(now, odom, base, robot[:3].tolist()),
        )
        node.publish("/tf", poses)
        if view.scan is not None:
            assert task.lidar is not None
            scan = m.laser_scan(now, f"{frame}laser", task.lidar, view.scan)
            node.publish(f"{prefix}/scan", scan)
        seen = m.observation(now, robot, view.humans)
        node.publish(self._observation, seen)
        node.publish("/clock", m.clock(now))

    def forget_commands(self) -> None:
        """Takes commands that came before now; the last one is kept."""
        from hunav_drake.systems.planning.ros2.messages import command

        for told in self._commands.take():
            self.last_command = command(told)

    def wait_for(
        self, task: PlanningTask, view: View, limit: float
    ) -> tuple[float, float] | None:
        """Waits for the command of a cycle that has been told.

        It is told again each second: somebody may have come anew. Commands
        without stamps cannot tell that they answer the same again, so then only
        if somebody has.
        """
        from hunav_drake.systems.planning.ros2 import messages as m

        now = round(view.time * 1e9)
        told_at = time.monotonic()
        arrivals = self._node.num_arrivals()
        end = told_at + limit
        others: list[int] = []
        while True:
            for told in self._commands.take():
                if not self._stamped:
                    return m.command(told)
                stamp = m.nanoseconds(told.header.stamp)
                if now <= stamp < now + round(task.time_step * 1e9):
                    return m.command(told)
                others.append(stamp)
            self.check_alone(view.time)
            _check_interrupt(view.time)
            waited = time.monotonic()
            if waited > end:
                late = _late(self.topic, limit, others)
                raise PlannerError("bridge", view.time, late)
            if waited > told_at + 1.0:
                told_at, before = waited, arrivals
                arrivals = self._node.num_arrivals()
                if self._stamped or arrivals > before:
                    self.tell(task, view, with_goal=True)
            time.sleep(5e-5)


def _check_interrupt(now: float) -> None:
    """Raises PlannerError after Ctrl-C: the trial ends it after the step."""
    if is_interrupted.get()():
        raise PlannerError("bridge", now, "interrupted")


def _late(topic: str, limit: float, others: list[int]) -> str:
    text = f"no command on {topic} within time_limit = {limit:g} s"
    if others:
        text += (
            f"; {len(others)} came for other times, the last for"
            f" {others[-1] * 1e-9:g} s: do nodes there have use_sim_time?"
        )
    return text


@functools.cache
def _link(*settings: Any) -> Link:
    """Returns the topics of a bridge, once for each settings."""
    return Link(*settings)
