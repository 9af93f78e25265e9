"""The parameters of sensors: mounts and measurements."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, StrictBool, StrictFloat, model_validator
from pydantic.dataclasses import dataclass as checked_dataclass

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.field_docs import explain
from hunav_drake.systems.common.schema import (
    CONFIG,
    Integer,
    Name,
    Pose,
    fault,
    within,
)

Height = Annotated[StrictFloat, within(0, 100, "m", low_open=True)]
Range = Annotated[StrictFloat, within(0, 1000, "m", low_open=True)]
Period = Annotated[StrictFloat, within(0, 10, "s", low_open=True)]
Lag = Annotated[StrictFloat, within(0, 5, "s")]
Chance = Annotated[StrictFloat, within(0, 1)]
ChancePerMeter = Annotated[StrictFloat, within(0, 1, "1/m")]
Deviation = Annotated[StrictFloat, within(0, 10, "m")]
DeviationPerMeter = Annotated[StrictFloat, within(0, 1, "m/m")]
Pitch = Annotated[StrictFloat, within(-math.pi / 2, math.pi / 2, "rad")]
Turn = Annotated[StrictFloat, within(0, 2 * math.pi, "rad", low_open=True)]
Pixels = Annotated[Integer, Field(ge=16, le=4096)]

# The highest plane, in meters, that cuts only legs, for all gaits.
LEG_HEIGHT = 0.7


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class Mount:
    """Mount of a sensor."""

    name: Name = ""
    """Name of the sensor in the diagram; by default its type, with a number if
    that is taken."""

    mount: Literal["robot", "world"] = "robot"
    """Mount of the sensor: the robot, or the ground ("world")."""

    pose: Pose = (0.0, 0.0, 0.0)
    """Pose (x, y, yaw) of the sensor relative to its mount, in meters and
    radians."""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class Delayed:
    """Latency of measurements."""

    delay: Lag = 0.0
    """Time from a measurement until its output, in seconds; a multiple of the
    trial's time step. Until the first one arrives, the output is that of the
    start."""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class LidarParameters(Mount):
    """Parameters of a lidar that scans a horizontal plane."""

    height: Height = 0.3
    """Height of the scanned plane above the floor, in meters."""

    num_rays: Annotated[Integer, Field(ge=1, le=100_000)] = 360
    """Number of rays of a scan. They are evenly spaced and counterclockwise,
    and the center of the field of view is straight ahead. A full turn begins
    straight back."""

    field_of_view: Turn = 2 * math.pi
    """Horizontal field of view, in radians."""

    range_min: Annotated[StrictFloat, within(0, 1000, "m")] = 0.05
    """Minimum range, in meters. A ray with a nearer hit gives this."""

    range_max: Range = 10.0
    """Maximum range, in meters. A ray without a hit gives this."""

    period: Period = 0.1
    """Time between two scans, in seconds; a multiple of the trial's time step.
    """

    noise: Deviation = 0.0
    """Standard deviation of the distances, in meters; 0 for exact ones."""

    noise_per_meter: DeviationPerMeter = 0.0
    """Increase of this standard deviation with the distance, in m/m."""

    dropout: Chance = 0.0
    """Probability that a ray has no return, and so gives `range_max`."""

    people: Literal["legs", "discs"] = "legs"
    """Model of people: two walking legs, as the figures have, or the discs of
    the crowd."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_ranges(self.range_min, self.range_max)
        if self.people == "legs" and self.height > LEG_HEIGHT:
            raise fault(
                f"height must be at most {LEG_HEIGHT:g} m where it meets legs,"
                f" got {self.height:g}; lower it, or set people: discs"
            )
        return self

    @property
    def is_noisy(self) -> bool:
        """Whether the distances have errors."""
        return self.noise > 0.0 or self.noise_per_meter > 0.0

    def deviation(self, distances: Array) -> Array:
        """Returns the standard deviations of distances, all in meters."""
        reach = np.minimum(distances, self.range_max)
        return self.noise + self.noise_per_meter * reach

    @property
    def angle_step(self) -> float:
        """The angle from a ray to the next one, in radians."""
        full = self.field_of_view > 2 * math.pi - 1e-9
        return self.field_of_view / max(self.num_rays - (not full), 1)

    @property
    def first_angle(self) -> float:
        """The angle of the first ray from straight ahead, in radians."""
        return -0.5 * self.field_of_view if self.num_rays > 1 else 0.0

    def angles(self) -> Array:
        """Returns the angle of each ray from straight ahead, in radians."""
        steps = np.arange(self.num_rays, dtype=float)
        return self.first_angle + self.angle_step * steps


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class Sight:
    """Range and field of view for the detection of people."""

    range_max: Range = 10.0
    """Range, in meters."""

    field_of_view: Turn = 2 * math.pi
    """Horizontal field of view, in radians."""

    hidden_by_people: StrictBool = False
    """Whether people occlude people behind them; walls always do."""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class VisibleParameters(Sight, Mount):
    """Parameters of a detector of people."""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class DetectorErrors:
    """Rate and errors of detections of people."""

    period: Period = 0.1
    """Time between two detections, in seconds; a multiple of the trial's time
    step."""

    missed: Chance = 0.05
    """Probability that a person in view is missed in a detection."""

    missed_per_meter: ChancePerMeter = 0.01
    """Increase of this probability with the distance, in 1/m."""

    noise: Deviation = 0.05
    """Standard deviation of x and of y of a person, in meters."""

    noise_per_meter: DeviationPerMeter = 0.01
    """Increase of this standard deviation with the distance, in m/m."""

    velocity_noise: Annotated[StrictFloat, within(0, 10, "m/s")] = 0.1
    """Standard deviation of each component of the velocity, in m/s."""

    false_rate: Annotated[StrictFloat, within(0, 100, "1/s")] = 0.1
    """Rate at which false detections begin, in 1/s: people at rest, placed at
    random in view, with a radius of 0.3 m."""

    false_duration: Annotated[
        StrictFloat, within(0, 1000, "s", low_open=True)
    ] = 1.0
    """Mean duration of a false detection, in seconds."""

    max_false: Annotated[Integer, Field(ge=1, le=100)] = 5
    """Largest number of false detections at a time; those beyond do not
    begin."""

    @property
    def num_false_rows(self) -> int:
        """The number of rows for false detections, after those of people."""
        return self.max_false if self.false_rate > 0.0 else 0


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class DetectorParameters(DetectorErrors, VisibleParameters):
    """Parameters of a detector of people with errors."""


@explain
@checked_dataclass(kw_only=True, config=CONFIG)
class CameraParameters(Mount):
    """Parameters of a camera."""

    height: Height = 1.0
    """Height of the camera above the floor, in meters."""

    pitch: Pitch = 0.0
    """Downward pitch of the camera, in radians."""

    image_size: tuple[Pixels, Pixels] = (640, 480)
    """Width and height of images, in pixels."""

    field_of_view_y: Annotated[
        StrictFloat, within(0, 3.0, "rad", low_open=True)
    ] = math.pi / 4
    """Vertical field of view, in radians."""

    range_min: Annotated[StrictFloat, within(1e-3, 1000, "m")] = 0.1
    """Minimum depth, in meters. Nearer points give 0. Below a millimeter, a
    renderer does not know what is before what."""

    range_max: Range = 20.0
    """Maximum depth, in meters. Farther points give infinity."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_ranges(self.range_min, self.range_max)
        return self


def _check_ranges(low: float, high: float) -> None:
    if high <= low:
        raise fault(
            f"range_max must be above range_min ({low:g} m), got {high:g}"
        )
