"""Records a scene's visualizer for a replay."""

from collections.abc import Iterator
from contextlib import contextmanager

from pydrake.geometry import MeshcatVisualizer

from hunav_drake.systems.scene.overlays.viewer import MeshcatViewer


@contextmanager
def RecordReplay(
    visualizer: MeshcatViewer | MeshcatVisualizer, *, live: bool = False
) -> Iterator[None]:
    """Records a visualizer while the block runs.

    Afterwards the recording is in the visualizer's Meshcat, for SaveReplay,
    also if the block raises an error. It replaces a previous recording.

    Args:
        visualizer: The visualizer of a scene, `ScenePorts.visualizer`.
        live: Whether browsers show the run while it is recorded.
    """
    visualizer.DeleteRecording()
    visualizer.StartRecording(set_transforms_while_recording=live)
    try:
        yield
    finally:
        visualizer.StopRecording()
        visualizer.PublishRecording()
