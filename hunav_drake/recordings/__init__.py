"""Recordings from elsewhere, in their formats."""

from hunav_drake.recordings.readers import ReadRecording

__all__ = [
    "ReadRecording",
]
