"""Records what a scene's visualizer shows, for a replay."""

from collections.abc import Iterator
from contextlib import contextmanager

from pydrake.geometry import MeshcatVisualizer

from hunav_drake.systems.scene.overlays.viewer import MeshcatViewer


@contextmanager
def RecordReplay(
    visualizer: MeshcatViewer | MeshcatVisualizer, *, live: bool = False
) -> Iterator[None]:
    """Records what a visualizer shows while the block runs.

    Afterwards the recording is in the visualizer's Meshcat, for SaveReplay,
    also if the block ends with an error. A recording of before is replaced.

    Args:
        visualizer: That of a scene, `ScenePorts.visualizer`.
        live: Whether browsers show the run while it is recorded.
    """
    visualizer.DeleteRecording()
    visualizer.StartRecording(set_transforms_while_recording=live)
    try:
        yield
    finally:
        visualizer.StopRecording()
        visualizer.PublishRecording()
