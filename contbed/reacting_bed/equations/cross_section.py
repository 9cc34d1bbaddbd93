"""What a section is cut into: rings of a tube, layers between plane walls, columns of a
square duct.

All are finite volumes of equal width from the axis, or the planes of symmetry, to the
wall at `radius`, half of the diameter of the tube, of the distance of the plane walls
or of the side of the duct. Of a duct a quarter is resolved, 0 < y < R and 0 < z < R, by
`number` columns along each; column i of y and j of z has the index i + number j.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from contbed.arrays import Array


class Join(NamedTuple):
    """A face between two parts: its area per volume of the bed over the distance of
    their middles [1/m2].
    """

    inner: int
    outer: int
    area: float


class WallFace(NamedTuple):
    """A face at the wall: its area per volume of the bed [1/m], and the length of
    conduction to it [m].
    """

    part: int
    area: float
    distance: float


@dataclass(frozen=True)
class Parts:
    """The parts of a section, `number` of them between the axis and the wall at
    `radius` [m].
    """

    number: int
    radius: float
    shape: Literal["tube", "plane", "duct"]

    @property
    def count(self) -> int:
        """How many there are."""
        return self.number**2 if self.shape == "duct" else self.number

    @property
    def edges(self) -> Array:
        """Distances of the faces from the axis [m], (number + 1,)."""
        return np.linspace(0.0, self.radius, self.number + 1)

    @property
    def middles(self) -> Array:
        """Distances of the middles from the axis [m], (number,)."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])

    @property
    def shares(self) -> Array:
        """Shares of the section, (count,), of sum 1."""
        if self.shape == "tube":
            return np.diff((self.edges / self.radius) ** 2)
        return np.full(self.count, 1.0 / self.count)

    @cached_property
    def joins(self) -> list[Join]:
        """The faces between parts."""
        n, R = self.number, self.radius
        if self.shape == "tube":
            return [
                Join(k, k + 1, 2.0 * float(r) * n / R**3)
                for k, r in enumerate(self.edges[1:-1])
            ]
        if self.shape == "plane":
            return [Join(k, k + 1, n / R**2) for k in range(n - 1)]
        return [
            Join(i + n * j, i + 1 + n * j, 1.0 / R**2)
            for j in range(n)
            for i in range(n - 1)
        ] + [
            Join(i + n * j, i + n * (j + 1), 1.0 / R**2)
            for j in range(n - 1)
            for i in range(n)
        ]

    @cached_property
    def walls(self) -> list[WallFace]:
        """The faces at the wall; the outermost column of a duct in the corner has
        two.
        """
        n, R, outer = self.number, self.radius, float(self.middles[-1])
        if self.shape == "tube":
            return [WallFace(n - 1, 2.0 / R, R * float(np.log(R / outer)))]
        if self.shape == "plane":
            return [WallFace(n - 1, 1.0 / R, R - outer)]
        sides = [n - 1 + n * j for j in range(n)] + [i + n * (n - 1) for i in range(n)]
        return [WallFace(part, 1.0 / (n * R), R - outer) for part in sides]

    def mean(self, u: Array) -> Array:
        """Return the means over the section, (m, ...), of values by part and unknown
        (count m, ...).
        """
        found: Array = np.tensordot(
            self.shares, u.reshape(self.count, -1, *u.shape[1:]), axes=1
        )
        return found

    @property
    def to_axis(self) -> Array:
        """Weights of the parts (count,) in the value at the axis, of a parabola
        without slope there.
        """
        square = self.middles**2
        ahead = square[0] / (square[1] - square[0])
        line = np.zeros(self.number)
        line[:2] = 1.0 + ahead, -ahead
        return np.outer(line, line).ravel() if self.shape == "duct" else line

    @property
    def to_wall(self) -> Array:
        """Weights of the parts (count,) in the value at the wall, of a duct in the
        middle of a side.
        """
        square = self.middles**2
        ahead = (self.radius**2 - square[-1]) / (square[-1] - square[-2])
        line = np.zeros(self.number)
        line[-2:] = -ahead, 1.0 + ahead
        if self.shape != "duct":
            return line
        between = Parts(self.number, self.radius, "plane").to_axis
        return np.outer(between, line).ravel()
