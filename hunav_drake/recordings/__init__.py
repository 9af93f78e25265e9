"""Reads recordings, also those of other programs."""

from hunav_drake.recordings.readers import ReadRecording

__all__ = ["ReadRecording"]
