"""Draws overlays in Meshcat during a trial, and in its recording."""

from collections.abc import Callable, Mapping, Sequence
import math
from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    EventStatus,
    InputPort,
    LeafSystem,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import (
    COHERENCE_FORCE,
    FORCES_SIZE,
    GAZE_FORCE,
    GOAL_FORCE,
    GROUP_REPULSION_FORCE,
    OBSTACLE_FORCE,
    REACTIVE,
    REPLAY_SIZE,
    REPLAYED,
    ROBOT_REPULSION_FORCE,
    SIGNAL_SIZE,
    SOCIAL_FORCE,
    STATE_SIZE,
    VX,
    VY,
    YAW,
    Signal,
    X,
    Y,
)
from hunav_drake.systems.scene.bounds import port_of
from hunav_drake.systems.scene.overlays.board import (
    COSTMAP_Z,
    MAX_SCAN_DOTS,
    PLAN_DOTS,
    PLAN_Z,
    SCAN_Z,
    WALKED_DOTS,
    Board,
    force_scale,
)
from hunav_drake.systems.scene.overlays.costmaps import (
    RecordCostmap,
    ShowCostmap,
)
from hunav_drake.systems.scene.overlays.reactions import is_calm
from hunav_drake.systems.scene.overlays.tags import (
    ROBOT_TAG_Z,
    activity_text,
    calm_activities,
)
from hunav_drake.systems.scene.scene_config import (
    COSTMAPS,
    STANDING_SPEED,
    WALKED_TIME,
    Overlay,
    Rays,
)
from hunav_drake.systems.world.maps.costs import NO_MAP
from hunav_drake.systems.world.solids import turned

# The number of frames between updates of activities and forces, and of plans
# and scans; each update makes a replay larger.
_FEW = 2
_MANY = 4

# The time between two updates of costmaps, in seconds.
_COSTMAP_PERIOD = 0.5

_SMALL = [1e-3, 1e-3, 1.0]
_FULL = [1.0, 1.0, 1.0]


def AddOverlayPublisher(
    builder: DiagramBuilder,
    board: Board,
    shown: Sequence[Overlay],
    *,
    period: float,
    is_due: Callable[[Context], bool],
    is_recording: Callable[[], bool],
    rays: Mapping[str, Rays],
) -> None:
    """Adds an `OverlayPublisher` to a builder and exports its inputs.

    The builder is that of the scene; the publisher shares its inputs with the
    states of people and robots.
    """
    system = builder.AddNamedSystem(
        "overlays",
        OverlayPublisher(
            board,
            shown,
            period=period,
            is_due=is_due,
            is_recording=is_recording,
            rays=rays,
        ),
    )
    for i in range(system.num_input_ports()):
        port = system.get_input_port(i)
        name = port.get_name()
        shared = name.endswith("robot_state") and "estimated_" not in name
        if name in ("human_states", "social_signals") or shared:
            builder.ConnectInput(name, port)
        else:
            builder.ExportInput(port, name)


class _Robot(NamedTuple):
    """The input ports of a robot: see `OverlayPublisher`."""

    name: str
    state: InputPort
    estimate: InputPort
    path: InputPort
    costmaps: dict[Overlay, InputPort]
    rays: Rays | None
    scan: InputPort | None


class OverlayPublisher(LeafSystem):
    """Draws overlays in Meshcat.

    .. pydrake_system::

        name: OverlayPublisher
        input_ports:
        - human_states
        - robot_state
        - behavior_status
        - replay (only with recorded people)
        - social_signals (only if people show signals)
        - forces
        - estimated_robot_state
        - planner_path
        - local_costmap
        - global_costmap
        - scan

    Port `human_states` takes the states of `n` people (size 7n), `robot_state`
    that of the robot (size 7), `behavior_status` n numbers, 0 for people who do
    not react, `replay` n rows of `layout.REPLAY_SIZE`, `social_signals` n rows
    of `layout.Signal`, `forces` 16n numbers
    (see `layout.FORCES`), `estimated_robot_state` the state of the robot as its
    planner knows it, `planner_path`, abstract, an array (k, 2) or (k, 3)
    of points in W, `local_costmap` and `global_costmap`, abstract, a `Costmap`
    each, and `scan` the distances of a lidar's rays (only if there are rays).
    Without a robot there are no ports of it and its planner; of several robots,
    each has such ports, with its name and "_" before theirs. All ports except
    the states may be unconnected.

    It has no state; Meshcat holds what is drawn. It publishes every `period`,
    if that is due (see `MeshcatViewer`), and while Meshcat records, into the
    recording, too.
    """

    def __init__(
        self,
        board: Board,
        shown: Sequence[Overlay],
        *,
        period: float,
        is_due: Callable[[Context], bool] = lambda context: True,
        is_recording: Callable[[], bool] = lambda: False,
        rays: Mapping[str, Rays] | None = None,
    ) -> None:
        """Constructs an OverlayPublisher.

        `shown` are the overlays that are visible initially; `is_due` returns
        whether to draw the frame of a Context, if it is not forced.
        `rays` are by the name of a robot, empty for a single one.
        """
        super().__init__()
        self._board = board
        self._shown = tuple(shown)
        self._period = period
        self._is_due = is_due
        self._is_recording = is_recording
        n = len(board.names)
        declare = self.DeclareVectorInputPort
        self._humans = declare("human_states", STATE_SIZE * n)
        self._status = declare("behavior_status", n)
        self._forces = declare("forces", FORCES_SIZE * n)
        self._replay = None
        if any(board.recorded):
            self._replay = declare("replay", REPLAY_SIZE * n)
        self._signals = None
        if board.sayings:
            self._signals = declare("social_signals", SIGNAL_SIZE * n)
        self._robots = [
            self._Declare(name, (rays or {}).get(name)) for name in board.robots
        ]
        self.DeclareInitializationPublishEvent(self._Draw)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._PublishIfDue)
        self.DeclareForcedPublishEvent(self._Publish)

    def _Declare(self, name: str, rays: Rays | None) -> "_Robot":
        """Declares the input ports of a robot."""

        def declare(port: str, model: AbstractValue) -> InputPort:
            return self.DeclareAbstractInputPort(port_of(name, port), model)

        vector = self.DeclareVectorInputPort
        return _Robot(
            name=name,
            state=vector(port_of(name, "robot_state"), STATE_SIZE),
            estimate=vector(port_of(name, "estimated_robot_state"), STATE_SIZE),
            path=declare("planner_path", Value(np.zeros((0, 3)))),
            costmaps={
                it: declare(it, AbstractValue.Make(NO_MAP)) for it in COSTMAPS
            },
            rays=rays,
            scan=None
            if rays is None
            else vector(port_of(name, "scan"), len(rays.angles)),
        )

    def _Draw(self, context: Context) -> EventStatus:
        rays = {
            it.name: min(MAX_SCAN_DOTS, len(it.rays.angles))
            for it in self._robots
            if it.rays is not None
        }
        self._board.Draw(self._shown, rays)
        for it in self._robots:
            if it.estimate.HasValue(context):
                self._board.DrawEstimate(it.name)
        return EventStatus.Succeeded()

    def _PublishIfDue(self, context: Context) -> EventStatus:
        if self._is_due(context):
            return self._Publish(context)
        return EventStatus.DidNothing()

    def _Publish(self, context: Context) -> EventStatus:
        time = context.get_time()
        frame = round(time / self._period)
        humans: Array = np.zeros((0, STATE_SIZE))
        if self._board.names:
            humans = self._humans.Eval(context).reshape(-1, STATE_SIZE)
        robots = [it.state.Eval(context) for it in self._robots]
        board = self._board
        live = board.meshcat.GetNumActiveConnections() > 0
        every = max(round(WALKED_TIME / WALKED_DOTS / self._period), 1)
        if frame % every == 0:
            self._LayDots(time, frame // every, humans, robots, live=live)
        for it, row in zip(self._robots, robots, strict=True):
            X_WB = upright(*row[: YAW + 1])
            board.meshcat.SetTransform(board.Frame(it.name), X_WB, time)
            if it.estimate.HasValue(context):
                X_WE = upright(*it.estimate.Eval(context)[: YAW + 1])
                path = board.OfAll("estimate", it.name)
                board.meshcat.SetTransform(path, X_WE, time)
        if live:
            self._TurnTags(humans, robots)
        if frame % _FEW == 0:
            self._PublishPeople(context, time, humans)
            self._PublishSpeech(context, time)
        many = max(round(_COSTMAP_PERIOD / self._period), 1)
        for it, row in zip(self._robots, robots, strict=True):
            if frame % _MANY == 0:
                self._PublishPath(context, time, it)
                self._PublishScan(context, time, it, row)
            if frame % many == 0:
                times = (time, time + many * self._period)
                self._PublishCostmaps(context, it, frame // many, times)
        return EventStatus.Succeeded()

    def _LayDots(
        self,
        time: float,
        count: int,
        humans: Array,
        robots: Sequence[Array],
        *,
        live: bool,
    ) -> None:
        """Places the next dot of each walked path; older dots shrink."""
        board, meshcat = self._board, self._board.meshcat
        last = time + WALKED_TIME - self._period
        for walker in board.walkers:
            row = (robots if walker.is_robot else humans)[walker.row]
            path = board.Walked(walker, count % WALKED_DOTS)
            place = board.hidden
            if not math.isnan(row[X]):
                place = [row[X], row[Y], walker.height]
            # In a recording, it shrinks to nothing just before its object is
            # reused.
            keys = [(last, _SMALL), (time, _FULL)]
            if count and count < WALKED_DOTS:
                keys.insert(0, (time - self._period, _SMALL))
            for when, scale in keys:
                meshcat.SetProperty(path, "position", place, when)
                meshcat.SetProperty(path, "scale", scale, when)
            if not live:
                continue
            for age in range(1, WALKED_DOTS):
                older = board.Walked(walker, (count - age) % WALKED_DOTS)
                rest = 1.0 - age / WALKED_DOTS
                meshcat.SetProperty(older, "scale", [rest, rest, 1.0])

    def _TurnTags(self, humans: Array, robots: Sequence[Array]) -> None:
        """Turns the name tags to the initial position of the camera."""
        board = self._board
        of_figure = dict(zip(board.names, humans, strict=True))
        tagged = [
            (path, of_figure[path.split("/")[-3]], height)
            for path, height in board.boards
        ]
        tagged += [
            (board.NameOf(name), row, ROBOT_TAG_Z)
            for name, row in zip(board.robots, robots, strict=True)
        ]
        for path, row, height in tagged:
            if not math.isnan(row[X]):
                R_BW = RotationMatrix.MakeZRotation(-row[YAW])
                X_BT = RigidTransform(R_BW @ board.R_WT, [0.0, 0.0, height])
                board.meshcat.SetTransform(path, X_BT)

    def _PublishPeople(
        self, context: Context, time: float, humans: Array
    ) -> None:
        """Shows the activities of people and the forces on them."""
        board, meshcat = self._board, self._board.meshcat
        n = len(board.names)
        if not n:
            return
        reacts = np.zeros(n, dtype=np.bool_)
        if self._status.HasValue(context):
            reacts = self._status.Eval(context) != 0
        mode = np.zeros(n)
        if self._replay is not None and self._replay.HasValue(context):
            mode = self._replay.Eval(context)[::REPLAY_SIZE]
            reacts |= mode == REACTIVE
        stands = np.hypot(humans[:, VX], humans[:, VY]) < STANDING_SPEED
        signals = self._EvalSignals(context)
        words = calm_activities(signals, n)
        if signals is not None:
            reacts &= ~is_calm(signals.reshape(n, -1))
        for i, name in enumerate(board.names):
            word = activity_text(words[i], bool(stands[i]))
            if reacts[i] and not words[i]:
                word = "reacts"
            activity = board.activities.index(word)
            for k in range(len(board.activities)):
                tag = board.Tag(name, k)
                meshcat.SetProperty(tag, "visible", k == activity, time)
            signs = [bool(reacts[i])]
            if board.recorded[i]:
                signs.append(bool(mode[i] == REPLAYED and not reacts[i]))
            for k, visible in enumerate(signs):
                sign = f"{board.OfPerson('reactions', name)}/{k}"
                meshcat.SetProperty(sign, "visible", visible, time)
        if not self._forces.HasValue(context):
            return
        rows = self._forces.Eval(context).reshape(n, FORCES_SIZE)
        for i, name in enumerate(board.names):
            for kind, force in enumerate(_kinds_of_forces(rows[i])):
                path = board.Force(name, kind)
                length, angle = force_scale(force)
                # The arrow turns with the figure.
                turn = angle - humans[i, YAW]
                if not math.isfinite(turn):
                    continue
                c, s = math.cos(turn / 2), math.sin(turn / 2)
                quaternion = [0.0, 0.0, s, c]
                meshcat.SetProperty(path, "quaternion", quaternion, time)
                meshcat.SetProperty(path, "scale", [length, 1.0, 1.0], time)

    def _EvalSignals(self, context: Context) -> Array | None:
        """Returns what people show, if it is known."""
        if self._signals is None or not self._signals.HasValue(context):
            return None
        signals: Array = self._signals.Eval(context)
        return signals

    def _PublishSpeech(self, context: Context, time: float) -> None:
        """Shows the bubbles of what people say."""
        signals = self._EvalSignals(context)
        if signals is None:
            return
        board, said = self._board, signals[Signal.UTTERANCE :: SIGNAL_SIZE]
        for name, texts, code in zip(
            board.names, board.sayings, said, strict=True
        ):
            for k, text in enumerate(texts):
                board.meshcat.SetProperty(
                    board.Bubble(name, k), "visible", bool(text == code), time
                )

    def _PublishPath(
        self, context: Context, time: float, robot: "_Robot"
    ) -> None:
        if not robot.path.HasValue(context):
            return
        path = np.asarray(robot.path.Eval(context), dtype=float)
        places = np.tile(self._board.hidden, (PLAN_DOTS, 1))
        if len(path):
            places[:, :2] = spread(path, PLAN_DOTS)
            places[:, 2] = PLAN_Z
        for k, place in enumerate(places):
            self._board.meshcat.SetProperty(
                self._board.Plan(k, robot.name), "position", place, time
            )

    def _PublishCostmaps(
        self,
        context: Context,
        robot: "_Robot",
        count: int,
        times: tuple[float, float],
    ) -> None:
        board, meshcat = self._board, self._board.meshcat
        records = self._is_recording()
        live = not records and meshcat.GetNumActiveConnections() > 0
        for name, port in robot.costmaps.items():
            if not port.HasValue(context):
                continue
            if name not in self._shown and not live:
                continue
            place = (meshcat, board.OfAll(name, robot.name), count)
            picture = (port.Eval(context), COSTMAP_Z[name])
            if records:
                RecordCostmap(*place, *picture, times)
            else:
                ShowCostmap(*place, *picture)

    def _PublishScan(
        self, context: Context, time: float, robot: "_Robot", row: Array
    ) -> None:
        rays, port = robot.rays, robot.scan
        if rays is None or port is None or not port.HasValue(context):
            return
        ranges = port.Eval(context)
        dots = min(MAX_SCAN_DOTS, len(ranges))
        shown = np.linspace(0, len(ranges) - 1, dots).round().astype(int)
        ranges, angles = ranges[shown], rays.angles[shown]
        meets = ranges < rays.range_max
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        hits = rays.begin + np.where(meets, ranges, 0.0)[:, None] * directions
        if rays.on_robot:
            hits = turned(hits, (row[X], row[Y], row[YAW]))
        for k, (x, y) in enumerate(hits.tolist()):
            place = [x, y, SCAN_Z] if meets[k] else self._board.hidden
            self._board.meshcat.SetProperty(
                self._board.Scan(k, robot.name), "position", place, time
            )


def upright(x: float, y: float, yaw: float) -> RigidTransform:
    """Returns a pose on the floor, in m and rad."""
    return RigidTransform(RotationMatrix.MakeZRotation(yaw), [x, y, 0.0])


def _kinds_of_forces(row: Array) -> tuple[Array, Array, Array]:
    """Returns the forces to the goal, from people, and from walls."""
    of_people = (
        SOCIAL_FORCE,
        GAZE_FORCE,
        COHERENCE_FORCE,
        GROUP_REPULSION_FORCE,
        ROBOT_REPULSION_FORCE,
    )
    people = np.sum([row[i : i + 2] for i in of_people], axis=0)
    goal = row[GOAL_FORCE : GOAL_FORCE + 2]
    return goal, people, row[OBSTACLE_FORCE : OBSTACLE_FORCE + 2]


def spread(path: Array, count: int) -> Array:
    """Returns evenly spaced points (count, 2) along a path with rows (x, y).

    They go from its first to its last point.
    """
    points = path[:, :2]
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, along[-1], count)
    return np.column_stack(
        [np.interp(at, along, points[:, 0]), np.interp(at, along, points[:, 1])]
    )
