"""The process of the editor that checks scenarios and runs trials."""

from hunav_drake.editor.worker.worker import Worker

__all__ = ["Worker"]
