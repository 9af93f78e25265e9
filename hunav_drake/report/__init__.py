"""Reports in HTML, on a run or on many."""

from typing import TYPE_CHECKING

from hunav_drake.systems.lazy import lazy_exports

if TYPE_CHECKING:
    from hunav_drake.report.writing import (
        WriteReport,
    )

__all__ = [
    "WriteReport",
]

__getattr__ = lazy_exports(
    __name__,
    {
        "WriteReport": "hunav_drake.report.writing",
    },
)
