"""Spheres and their materials, and the tables that a pair of materials needs in
contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contbed.arrays import Array, Integers
from contbed.dem.kernel_arrays import PAIR, Table
from contbed.errors import SceneError


@dataclass(frozen=True)
class Material:
    """What a solid brings into a contact.

    Parameters
    ----------
    density [kg/m3]; youngs_modulus [Pa]; poisson_ratio [-]
    restitution [-] : of a normal impact, independent of its speed
    sliding_friction [-] : Coulomb coefficient
    rolling_friction [-] : arm of the resisting torque over the effective radius of the
        contact
    """

    density: float = 2500.0
    youngs_modulus: float = 1e7
    poisson_ratio: float = 0.3
    restitution: float = 0.9
    sliding_friction: float = 0.3
    rolling_friction: float = 0.0

    def __post_init__(self) -> None:
        problems = []
        for name in ("density", "youngs_modulus"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                problems.append(
                    f"material: {name} = {value:g} must be positive and finite"
                )
        if not -1.0 < self.poisson_ratio <= 0.5:
            problems.append(
                f"material: poisson_ratio = {self.poisson_ratio:g} must lie in (-1, "
                "0.5]"
            )
        if not 0.0 < self.restitution <= 1.0:
            problems.append(
                f"material: restitution = {self.restitution:g} must lie in (0, 1]"
            )
        for name in ("sliding_friction", "rolling_friction"):
            value = getattr(self, name)
            if not 0.0 <= value < np.inf:
                problems.append(
                    f"material: {name} = {value:g} must be zero or positive"
                )
        if problems:
            raise SceneError(problems)

    @classmethod
    def of(cls, table: Any, modulus: float) -> Material:
        """Return the material of a table [solids.NAME], with the `modulus` of a
        simulation [Pa].
        """
        return cls(
            table.density,
            modulus,
            table.poisson_ratio,
            table.restitution,
            table.sliding_friction,
            table.rolling_friction,
        )

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def contact_modulus(self) -> float:
        """E* = E / (2 (1 - nu^2)) [Pa] of two of this material."""
        return self.youngs_modulus / (2.0 * (1.0 - self.poisson_ratio**2))


def damping_ratio(restitution: ArrayLike) -> Array:
    """Find the share b of critical damping of a Hertz contact from e = exp(-pi
    b / sqrt(1 - b^2)).

    The dashpot is 2 sqrt(5/6) b sqrt(m k_n) with the tangent stiffness k_n.
    Source: Tsuji, Tanaka, Ishida (1992), Powder Technology 71, 239, in closed form by
        Antypov and Elliott (2011),
    EPL 94, 50004.

    >>> float(damping_ratio(1.0))
    0.0
    """
    log = -np.log(np.asarray(restitution, dtype=np.float64))
    return log / np.hypot(log, np.pi) + 0.0


def pair_table(materials: Sequence[Material]) -> Table:
    """Tabulate the constants of all pairs of materials, shape (m, m), columns as in
    `kernel_arrays.PAIR`.

    1/E* = sum (1 - nu^2)/E, 1/G* = sum (2 - nu)/G. Restitution and friction of a pair
    are geometric means.
    """
    column = {
        name: np.array([getattr(material, name) for material in materials])
        for name in (
            "youngs_modulus",
            "shear_modulus",
            "poisson_ratio",
            "restitution",
            "sliding_friction",
        )
    }
    rolling = np.array([material.rolling_friction for material in materials])
    compliance = (1.0 - column["poisson_ratio"] ** 2) / column["youngs_modulus"]
    shear_compliance = (2.0 - column["poisson_ratio"]) / column["shear_modulus"]
    damping = 2.0 * np.sqrt(5.0 / 6.0) * damping_ratio(_mean(column["restitution"]))
    table = np.empty((len(materials), len(materials)), PAIR)
    table["youngs_modulus"] = 1.0 / np.add.outer(compliance, compliance)
    table["shear_modulus"] = 1.0 / np.add.outer(shear_compliance, shear_compliance)
    table["damping_normal"] = damping * np.sqrt(2.0 * table["youngs_modulus"])
    table["damping_tangential"] = damping * np.sqrt(8.0 * table["shear_modulus"])
    table["sliding_friction"] = _mean(column["sliding_friction"])
    table["rolling_friction"] = _mean(rolling)
    return table


def _mean(values: Array) -> Array:
    return np.sqrt(np.multiply.outer(values, values))


@dataclass
class Particles:
    """Spheres: `position` [m], `velocity` [m/s], `spin` [rad/s] of shape (n, 3);
        `radius` [m], index of `material` (n).

    A scalar radius or material holds for all; velocity and spin start at zero.
    """

    position: Array
    radius: Array
    material: Integers
    velocity: Array
    spin: Array

    def __init__(
        self,
        position: ArrayLike,
        radius: ArrayLike,
        material: ArrayLike = 0,
        velocity: ArrayLike = 0.0,
        spin: ArrayLike = 0.0,
    ):
        self.position = np.array(position, dtype=np.float64, order="C", ndmin=2)
        if self.position.ndim != 2 or self.position.shape[1] != 3:
            raise SceneError(
                f"particles: position has shape {self.position.shape}, (n, 3) is needed"
            )
        n = len(self.position)
        self.radius = _filled(radius, (n,), np.float64, "radius")
        self.material = _filled(material, (n,), np.int64, "material")
        self.velocity = _filled(velocity, (n, 3), np.float64, "velocity")
        self.spin = _filled(spin, (n, 3), np.float64, "spin")
        for name in ("position", "radius", "velocity", "spin"):
            array = getattr(self, name)
            bad = ~np.isfinite(array).all(axis=tuple(range(1, array.ndim)))
            if bad.any():
                raise SceneError(
                    f"particles: {name} of particle {int(bad.argmax())} is not finite"
                )
        if n and not self.radius.min() > 0.0:
            raise SceneError(
                f"particles: radius {self.radius.min():g} m of particle "
                f"{int(self.radius.argmin())}"
            )

    def __len__(self) -> int:
        return len(self.position)

    @property
    def volume(self) -> Array:
        """Volume of each sphere [m3]."""
        return 4.0 / 3.0 * np.pi * self.radius**3


def _filled(
    values: ArrayLike, shape: tuple[int, ...], dtype: type, name: str
) -> NDArray[Any]:
    array: NDArray[Any] = np.asarray(values, dtype=dtype)
    try:
        return np.array(np.broadcast_to(array, shape), order="C")
    except ValueError:
        raise SceneError(
            f"particles: {name} has shape {array.shape}, {shape} is needed"
        ) from None
