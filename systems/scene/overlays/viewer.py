"""Publishes figures to Meshcat while a browser shows it or it records."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from pydrake.geometry import (
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    SceneGraph,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    EventStatus,
    InputPort,
    LeafSystem,
)
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat, MeshcatAnimation

# Without viewers, one of this many frames is published, so that a page opened
# later shows roughly the current state.
_UNSEEN = 64


class MeshcatViewer(LeafSystem):
    """Publishes the geometry of a plant to Meshcat when it is of use.

    .. pydrake_system::

        name: MeshcatViewer
        input_ports:
        - positions

    Port `positions` takes the generalized positions of the plant. It publishes
    every `period`, but less often while no browser is connected and nothing is
    recorded, because publishing is most of the cost. A forced publish is always
    done.

    It records like Drake's MeshcatVisualizer, with methods of the same names.

    It has no state. Geometry and poses belong to an internal diagram with a
    SceneGraph, whose Context is overwritten for each frame. Whether it records
    is, like what is drawn, a state of Meshcat, not of a trial.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        scene_graph: SceneGraph,
        meshcat: "Meshcat",
        *,
        period: float,
    ) -> None:
        """Constructs a MeshcatViewer.

        The finalized plant is a source of the SceneGraph, which is copied;
        `period` is the time between two frames, in seconds.
        """
        super().__init__()
        self._meshcat = meshcat
        self._period = period
        self._records = False
        builder = DiagramBuilder()
        shown = builder.AddSystem(scene_graph.Clone())
        poses = builder.AddSystem(MultibodyPositionToGeometryPose(plant))
        builder.Connect(
            poses.get_output_port(),
            shown.get_source_pose_port(plant.get_source_id()),
        )
        builder.ExportInput(poses.get_input_port(), "positions")
        self._visualizer = MeshcatVisualizer.AddToBuilder(
            builder,
            shown,
            meshcat,
            MeshcatVisualizerParams(publish_period=period),
        )
        self._shown = builder.Build()
        self._scratch = self._shown.CreateDefaultContext()
        self._positions = self.DeclareVectorInputPort(
            "positions", plant.num_positions()
        )
        self.DeclareInitializationPublishEvent(self._Clear)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._PublishIfDue)
        self.DeclareForcedPublishEvent(self._Publish)

    def get_positions_input_port(self) -> InputPort:
        """Returns the port for the positions of the plant."""
        return self._positions

    def is_due(self, context: Context) -> bool:
        """Returns whether the current frame should be published.

        All frames are while a browser shows the Meshcat, and while it records.
        """
        return (
            self._records
            or self._meshcat.GetNumActiveConnections() > 0
            or round(context.get_time() / self._period) % _UNSEEN == 0
        )

    def is_recording(self) -> bool:
        """Returns whether each frame is recorded."""
        return self._records

    def StartRecording(self, **options: bool) -> None:
        """Starts to record each frame; see Drake's MeshcatVisualizer."""
        self._visualizer.StartRecording(**options)
        self._records = True

    def StopRecording(self) -> None:
        """Stops the recording."""
        self._visualizer.StopRecording()
        self._records = False

    def PublishRecording(self) -> None:
        """Publishes the recording to Meshcat."""
        self._visualizer.PublishRecording()

    def DeleteRecording(self) -> None:
        """Deletes the recording."""
        self._visualizer.DeleteRecording()

    def get_mutable_recording(self) -> "MeshcatAnimation":
        """Returns the recording."""
        return self._visualizer.get_mutable_recording()

    def _Clear(self, context: Context) -> EventStatus:
        self._visualizer.Delete()
        return EventStatus.Succeeded()

    def _PublishIfDue(self, context: Context) -> EventStatus:
        if self.is_due(context):
            return self._Publish(context)
        return EventStatus.DidNothing()

    def _Publish(self, context: Context) -> EventStatus:
        self._scratch.SetTime(context.get_time())
        self._shown.get_input_port().FixValue(
            self._scratch, self._positions.Eval(context)
        )
        self._shown.ForcedPublish(self._scratch)
        return EventStatus.Succeeded()


@contextmanager
def RecordReplay(
    visualizer: MeshcatViewer | MeshcatVisualizer, *, live: bool = False
) -> Iterator[None]:
    """Records a visualizer (`ScenePorts.visualizer`) while the block runs.

    Afterwards the recording is in the visualizer's Meshcat, for SaveReplay,
    also if the block raises an error. It replaces a previous recording. `live`
    is whether browsers show the run while it is recorded.
    """
    visualizer.DeleteRecording()
    visualizer.StartRecording(set_transforms_while_recording=live)
    try:
        yield
    finally:
        visualizer.StopRecording()
        visualizer.PublishRecording()
