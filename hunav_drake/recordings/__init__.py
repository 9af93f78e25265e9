"""Reads recordings, also those of other programs."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.recordings.readers import (
        ReadRecording,
    )

__all__ = [
    "ReadRecording",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "ReadRecording": "hunav_drake.recordings.readers",
    },
)
