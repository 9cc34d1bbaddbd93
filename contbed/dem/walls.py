"""Walls at rest: planes, boxes, cylinders around the bed, tubes in it; and the
domain that particles may not leave.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from contbed.dem.kernel_arrays import WALL, Table
from contbed.errors import SceneError

Vector = tuple[float, float, float]
INFINITE = float("inf")
# of a contact, that periodic sides are at least apart: a pair meets through one side
# only
REACHES = 3.0
SKIN = 0.1  # of the smallest radius, unless given: room of the neighbour list


@dataclass(frozen=True)
class Plane:
    """Through `point` [m]; `normal` points into the bed. `material` is an index."""

    point: Vector
    normal: Vector
    material: int = 0

    def row(self) -> tuple[float, ...]:
        """Return the wall as a row of `kernel_arrays.WALL`."""
        return (
            0.0,
            *self.point,
            *_unit(self.normal, "plane: normal"),
            0.0,
            self.material,
        )


@dataclass(frozen=True)
class _Round:
    """A point of the axis [m], direction of the axis, radius [m]."""

    point: Vector
    axis: Vector
    radius: float
    material: int = 0
    side: ClassVar[float]  # of the axis that the bed is on: 1 inside, -1 outside

    def row(self) -> tuple[float, ...]:
        """Return the wall as a row of `kernel_arrays.WALL`."""
        name = type(self).__name__.lower()
        axis = _unit(self.axis, f"{name}: axis")
        radius = _positive(self.radius, f"{name}: radius")
        return (self.side, *self.point, *axis, radius, self.material)


class Cylinder(_Round):
    """Round wall around the bed."""

    side = 1.0


class Tube(_Round):
    """Round tube in the bed, as long as the bed is wide."""

    side = -1.0


Wall = Plane | Cylinder | Tube


@dataclass(frozen=True)
class Domain:
    """Corners [m] and periodic sides; a particle whose centre leaves through a side
    that is not periodic is lost.
    """

    lower: Vector = (-INFINITE,) * 3
    upper: Vector = (INFINITE,) * 3
    periodic: tuple[bool, bool, bool] = (False,) * 3

    def __post_init__(self) -> None:
        for axis, name in enumerate("xyz"):
            low, high = self.lower[axis], self.upper[axis]
            if not low < high:
                raise SceneError(f"domain: {name} from {low:g} to {high:g} m")
            if self.periodic[axis] and not np.isfinite(high - low):
                raise SceneError(
                    f"domain: the periodic sides in {name} need finite corners, not "
                    f"{low:g} to {high:g} m"
                )

    def require_wide(self, width: float) -> None:
        """Refuse periodic sides closer than REACHES times `width` [m], the reach of
        a contact.
        """
        for axis, name in enumerate("xyz"):
            length = self.upper[axis] - self.lower[axis]
            if self.periodic[axis] and length < REACHES * width:
                raise SceneError(
                    f"domain: periodic length {length:g} m in {name}, at least "
                    f"{REACHES * width:.4g} m is needed "
                    "(three largest diameters and skins)"
                )


def box(domain: Domain, material: int = 0, open_top: bool = True) -> list[Plane]:
    """Put planes on the finite sides of a domain that are not periodic, with
    `open_top` none on the upper side of z.
    """
    planes = []
    for axis in range(3):
        for corner, sign in ((domain.lower, 1.0), (domain.upper, -1.0)):
            if (
                domain.periodic[axis]
                or not np.isfinite(corner[axis])
                or (open_top and axis == 2 and sign < 0.0)
            ):
                continue
            point, normal = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
            point[axis], normal[axis] = corner[axis], sign
            planes.append(
                Plane(
                    (point[0], point[1], point[2]),
                    (normal[0], normal[1], normal[2]),
                    material,
                )
            )
    return planes


def wall_table(walls: Sequence[Wall]) -> Table:
    """Tabulate walls for the kernels, shape (w,), columns as in
    `kernel_arrays.WALL`.
    """
    return np.array([wall.row() for wall in walls], dtype=WALL)


def _unit(direction: Vector, name: str) -> list[float]:
    vector = np.asarray(direction, dtype=np.float64)
    length = float(np.linalg.norm(vector))
    if not 0.0 < length < INFINITE:
        raise SceneError(f"{name} {direction} has no direction")
    return list(vector / length)


def _positive(value: float, name: str) -> float:
    if not 0.0 < value < INFINITE:
        raise SceneError(f"{name} = {value:g} m must be positive")
    return value
