"""Parts of the floor."""

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass
import shapely

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.plain_errors import plain_errors
from hunav_drake.systems.common.schema import (
    CONFIG,
    Point,
    Points,
    Rectangle,
    fault,
)


@plain_errors
@dataclass(kw_only=True, slots=True, config=CONFIG)
class Area:
    """A part of the floor, or a point of it: exactly one key is given."""

    rectangle: Rectangle | None = None
    """Sides (x_min, y_min, x_max, y_max) of a rectangle, in meters."""

    polygon: Annotated[Points, Field(min_length=3)] | None = None
    """Corners of a simple polygon, in either direction, in meters; the last
    joins the first."""

    point: Point | None = None
    """Point (x, y), in meters."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        given = [self.rectangle, self.polygon, self.point]
        if sum(part is not None for part in given) != 1:
            raise fault("must have one of rectangle, polygon and point")
        if self.rectangle is not None:
            x_min, y_min, x_max, y_max = self.rectangle
            if not (x_min < x_max and y_min < y_max):
                raise fault(
                    "rectangle must be (x_min, y_min, x_max, y_max) with"
                    " x_min < x_max and y_min < y_max"
                )
        if self.polygon is not None:
            shape = shapely.Polygon(self.polygon)
            if not (shape.is_valid and shape.area > 0):
                raise fault(
                    "polygon must enclose an area, and not cross itself"
                )
        return self

    def vertices(self) -> Array:
        """Returns the corners in W, shape (k, 2), in meters; 1 of a point."""
        if self.rectangle is not None:
            x_min, y_min, x_max, y_max = self.rectangle
            return np.array(
                [[x_min, y_min], [x_max, y_min], [x_max, y_max], [x_min, y_max]]
            )
        corners = self.polygon if self.polygon is not None else [self.point]
        return np.array(corners, dtype=float)
