"""The configuration of recorded people who are replayed."""

from typing import Annotated, Literal, Self

from pydantic import Field, StrictFloat, StrictStr, model_validator
from pydantic.dataclasses import dataclass

from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    FilePath,
    Integer,
    PositiveLength,
    fault,
    within,
)

ReplayMode = Literal["blind", "hand_over", "reactive"]

_Time = Annotated[StrictFloat, within(-1e9, 1e9, "s")]


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class TracksConfig:
    """Recorded people of a file, and how they are replayed."""

    file: FilePath
    """File of recorded people, in a format that `ReadTracks` reads; relative to
    the scenario file."""

    format: StrictStr = "auto"
    """Format of the file: see `ReadTracks`; by default its content tells."""

    fps: Annotated[StrictFloat, within(0, 1e6, low_open=True)] | None = None
    """Frames per second, where the file does not say."""

    unit: Literal["m", "cm", "mm"] | None = None
    """Unit of length, where the file does not say."""

    start: _Time = 0.0
    """Time of the recording at which the trial begins, in seconds."""

    end: _Time | None = None
    """Time of the recording at which the replay ends, in seconds; by default,
    where the recording ends."""

    smooth: Annotated[StrictFloat, within(0, 1, "m")] | None = None
    """Standard deviation of the noise to take out, in meters; 0 for the
    estimated one. By default, paths are not smoothed."""

    mode: ReplayMode = "hand_over"
    """Whether people follow the recording whatever the robot does ("blind"),
    walk by the motion model while the robot is near ("hand_over"), or as long
    as they are there ("reactive")."""

    on: PositiveLength = 2.0
    """Distance from the robot's center below which the motion model takes over,
    in meters."""

    off: PositiveLength = 3.0
    """Distance from the robot's center above which a person goes back to the
    recording, in meters; at least `on`."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.off < self.on:
            raise fault(
                f"off must be at least on ({self.on:g} m), got {self.off:g}"
            )
        if self.end is not None and self.end <= self.start:
            raise fault(
                f"end must be after start ({self.start:g} s), got {self.end:g}"
            )
        return self


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class TrackConfig(TracksConfig):
    """One recorded person of a file, and how it is replayed."""

    id: Annotated[Integer, Field(ge=0)]
    """Number of the person in the file. Who is missing in it for more than a
    second returns with another number: see `hunav tracks`."""
