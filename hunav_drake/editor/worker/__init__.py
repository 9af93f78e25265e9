"""The process beside the editor that knows names and runs trials."""

from hunav_drake.editor.worker.worker import Worker

__all__ = ["Worker"]
