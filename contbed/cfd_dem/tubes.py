"""Horizontal tubes across a bed of particles in a gas: an obstacle to both, and a
surface that exchanges heat.

A tube of one temperature lies along y. Cells of the gas that lie in it are blocked. Its
surface is cut into sectors, and between a sector and the bed, per kelvin [W/K],

    G = sum over the spheres at it of (G_contact + G_gap) + h A,   h = Nu(Re, Pr) k/D

A sphere at a surface of one temperature conducts as half of a pair with its mirror
image, twice what the pair does (Eqs. 5 and 6 of Zhou, Hou and Yu 2011,
`dem.heat_pair`); Re is that of the superficial velocity of the gas in the open cells
beside the sector, on the diameter D of the tube. Tubes do not radiate.

Source: Zhou, Hou, Yu 2011, sec. 3.3; Wong, Seville 2006, doi:10.1002/aic.11012 (angles
    from the bottom of the tube).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from contbed.arrays import Array, Flags, Integers
from contbed.cfd_dem import kernels
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.gas import MIN_SOLIDS, Gas
from contbed.cfd_dem.gas_quantities import Motion
from contbed.cfd_dem.grid import Grid
from contbed.closures.binding import BoundClosure
from contbed.dem import heat_pair
from contbed.dem.simulation import Simulation
from contbed.dem.walls import Tube
from contbed.errors import SceneError

SECTORS = 12  # of 30 degrees, the first one around the bottom
# of the smallest particle's diameter beyond the surface, within which cells are
# blocked: less than the radius, so that the cell of a particle's centre is never
# blocked
NEAR = 0.49


class Around(NamedTuple):
    """Heat between a tube and the bed now: of `near` spheres (k,) and of sectors
    (SECTORS,).

    `contact`, `gap` (k,) [W/K] of spheres in `sector` (k,); `h` [W/m2/K] of the gas;
    `touching` number of contacts; `eps` porosity within a diameter of a particle of the
    surface.
    """

    near: Integers
    sector: Integers
    contact: Array
    gap: Array
    h: Array
    touching: Array
    eps: Array


@dataclass(frozen=True)
class BedTube:
    """A tube in the bed.

    `x`, `z` of its axis, `radius`, `length` [m]; `nusselt` a closure of kind
    "nusselt_cylinder"; `T` [K], None without an energy equation: its coefficients are
    found all the same.
    """

    name: str
    x: float
    z: float
    radius: float
    length: float
    nusselt: BoundClosure
    T: float | None = None

    @property
    def wall(self) -> Tube:
        """The tube as a wall of the particles."""
        return Tube((self.x, 0.0, self.z), (0.0, 1.0, 0.0), self.radius)

    @property
    def area(self) -> float:
        """Area of a sector [m2]."""
        return 2.0 * np.pi * self.radius * self.length / SECTORS

    def distance(self, x: Array) -> Array:
        """Distance (n,) of points (n, 3) from the axis [m]."""
        return np.hypot(x[:, 0] - self.x, x[:, 2] - self.z)

    def sector(self, x: Array) -> Integers:
        """Sector (n,) of points (n, 3), counterclockwise from the bottom."""
        turn = np.arctan2(x[:, 0] - self.x, self.z - x[:, 2]) / (2.0 * np.pi)
        return np.round(turn * SECTORS).astype(np.int64) % SECTORS


def angles() -> Array:
    """Middle of the sectors from the bottom of a tube [deg]."""
    return np.arange(SECTORS) * 360.0 / SECTORS


def blocked(
    size: Array, count: tuple[int, int, int], tubes: Sequence[BedTube], d_p: float
) -> Flags | None:
    """Find the cells (count) that lie in tubes, so that the smallest particle
    (`d_p` [m]) is in none; None of none.
    """
    if not tubes:
        return None
    inside = np.zeros(count, bool)
    x, z = ((np.arange(count[axis]) + 0.5) * size[axis] for axis in (0, 2))
    for tube in tubes:
        far = np.hypot(
            (np.abs(x - tube.x) + 0.5 * size[0])[:, None],
            (np.abs(z - tube.z) + 0.5 * size[2])[None, :],
        )
        inside |= (far < tube.radius + NEAR * d_p)[:, None, :]
    return inside


def beside(grid: Grid, tube: BedTube) -> tuple[Integers, Array]:
    """Find the open cells within a cell of the surface (k,), and weights (SECTORS, k)
    of their means by sector.

    A sector takes the cells at its own angles and at those of its neighbours, so that
    coarse cells leave none empty.

    Raises
    ------
    SceneError : beside a sector there is no open cell
    """
    centres, width = grid.centres, float(max(grid.size[0], grid.size[2]))
    ring = np.flatnonzero(
        grid.open_cells & (tube.distance(centres) < tube.radius + width)
    )
    apart = np.abs(tube.sector(centres[ring])[None, :] - np.arange(SECTORS)[:, None])
    near = np.minimum(apart, SECTORS - apart) <= 1
    if not near.any(axis=1).all():
        raise SceneError(
            f"tubes.{tube.name}: no open cell of the gas beside a part of it: cells of "
            f"{width:.3g} m are too coarse "
            f"for a tube of {2.0 * tube.radius:.3g} m, or it lies too near to a wall; "
            "make gas.cell smaller or move it"
        )
    return ring, near / near.sum(axis=1, keepdims=True)


class TubeHeat:
    """Heat of one tube to particles and gas.

    `ring` are the cells beside it, `weight` (SECTORS, ring) their shares in the means
    of sectors.
    """

    def __init__(self, tube: BedTube, grid: Grid, solid: Solid):
        self.tube, self.grid, self.solid = tube, grid, solid
        self.ring, self.weight = beside(grid, tube)

    def around(self, simulation: Simulation, gas: Gas, motion: Motion) -> Around:
        """Find the conductances of spheres and the coefficients of the gas around
        the tube.
        """
        tube, x, R = self.tube, simulation.position, simulation.radius
        off = tube.distance(x)
        gap, d_p = off - tube.radius - R, 2.0 * float(R.max())
        close = off < tube.radius + d_p
        eps = 1.0 - np.bincount(
            tube.sector(x[close]), motion.volume[close], SECTORS
        ) / self._ring_volume(d_p)
        near = np.flatnonzero(gap < heat_pair.REACH * R)
        # the spheres near the tube as pairs with their mirror images
        here, apart = R[near], 2.0 * (R[near] + gap[near])
        porosity = np.zeros(0)
        if len(near):
            where, share, _ = self.grid.shares(x[near], here)
            porosity = np.minimum(
                kernels.gather(where, share, gas.eps), 1.0 - MIN_SOLIDS
            )
        soft, k = simulation.materials[0].youngs_modulus, self.solid.conductivity
        factor = heat_pair.correction(
            soft, self.solid.modulus or soft, self.solid.exponents[0]
        )
        r_c = heat_pair.contact_radius(here, here, apart, factor)
        contact = 2.0 * heat_pair.contact_conductance(r_c, k, k)
        k_fluid = float(self._gas(gas, "conductivity").mean())
        fluid = 2.0 * heat_pair.gap_conductance(
            here, here, apart, k, k, k_fluid, porosity, r_c
        )
        sector = tube.sector(x[near])
        touching = np.bincount(sector[gap[near] < 0.0], minlength=SECTORS).astype(float)
        return Around(
            near, sector, contact, fluid, self._convection(gas), touching, eps
        )

    def _ring_volume(self, d_p: float) -> float:
        """Volume within a diameter of the surface, of a sector [m3]."""
        tube = self.tube
        return (
            np.pi * ((tube.radius + d_p) ** 2 - tube.radius**2) * tube.length / SECTORS
        )

    def _gas(self, gas: Gas, what: str) -> Array:
        """Evaluate a property of the gas beside each sector."""
        return np.broadcast_to(
            getattr(gas.fluid, what)(self.weight @ gas.T[self.ring]), (SECTORS,)
        )

    def _convection(self, gas: Gas) -> Array:
        """Evaluate the coefficient of the gas at each sector [W/m2/K]."""
        rho, mu, c, k = (
            self._gas(gas, what)
            for what in ("density", "viscosity", "heat_capacity", "conductivity")
        )
        q = gas.q[self.grid.cell_face[self.ring]]
        speed = self.weight @ np.linalg.norm(0.5 * (q[:, ::2] + q[:, 1::2]), axis=1)
        D = 2.0 * self.tube.radius
        return np.asarray(
            self.tube.nusselt(Re=rho * speed * D / mu, Pr=mu * c / k) * k / D
        )

    def heat(
        self, simulation: Simulation, gas: Gas, motion: Motion, T: Array
    ) -> tuple[Array, Array]:
        """Find the heat from the tube [W] to each particle (n,), of temperatures
        `T` [K], and to each cell (c,).
        """
        found = self.around(simulation, gas, motion)
        to_particles, to_cells = np.zeros(len(T)), np.zeros(self.grid.cells)
        to_particles[found.near], to_sectors = self._given(found, gas, T)
        to_cells[self.ring] = to_sectors @ self.weight
        return to_particles, to_cells

    def flux(self, found: Around, gas: Gas, T: Array) -> Array:
        """Find the heat flux from each sector [W/m2] to particles of temperatures
        `T` (n,) and gas.
        """
        to_particles, to_gas = self._given(found, gas, T)
        return (
            np.bincount(found.sector, to_particles, SECTORS) + to_gas
        ) / self.tube.area

    def _given(self, found: Around, gas: Gas, T: Array) -> tuple[Array, Array]:
        """Find the heat to the spheres near the tube (k,) and to the gas beside each
        sector [W].
        """
        hot = self.tube.T
        assert hot is not None
        to_particles = (found.contact + found.gap) * (hot - T[found.near])
        return to_particles, found.h * self.tube.area * (
            hot - self.weight @ gas.T[self.ring]
        )


class TubeAverage:
    """Time average of what is around a tube: call it with a bed at even intervals.

    `sums` (6, SECTORS): coefficients of contacts, gaps and gas [W/m2/K], number of
    contacts, porosity, flux [W/m2].
    """

    def __init__(self, heat: TubeHeat):
        self.heat, self.count = heat, 0
        self.sums: Array = np.zeros((6, SECTORS))

    def __call__(self, simulation: Simulation, gas: Gas, motion: Motion) -> None:
        """Take the bed as it is now into the average."""
        found = self.heat.around(simulation, gas, motion)
        self.heat.tube.nusselt.record()
        by_sector = (
            np.bincount(found.sector, G, SECTORS) / self.heat.tube.area
            for G in (found.contact, found.gap)
        )
        flux = np.zeros(SECTORS)
        if self.heat.tube.T is not None and motion.T is not None:
            flux = self.heat.flux(found, gas, motion.T)
        self.sums += np.array([*by_sector, found.h, found.touching, found.eps, flux])
        self.count += 1

    def table(self) -> dict[str, Array]:
        """Return the columns of the table of the tube, a row for each sector."""
        contact, gap, gas, touching, eps, flux = self.sums / self.count
        columns = {
            "angle [deg]": angles(),
            "h [W/m2/K]": contact + gap + gas,
            "h_contact [W/m2/K]": contact,
            "h_gap [W/m2/K]": gap,
            "h_convection [W/m2/K]": gas,
            "contacts [1]": touching,
            "eps [1]": eps,
        }
        return columns if self.heat.tube.T is None else columns | {"q [W/m2]": flux}

    def state(self) -> dict[str, Array]:
        """Return the sums for a checkpoint."""
        tube = self.heat.tube
        kept = {
            "sums": self.sums.copy(),
            "count": np.array(self.count),
            "ranges": tube.nusselt.state(),
        }
        return {f"tube_{tube.name}_{what}": value for what, value in kept.items()}

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays of `state`."""
        sums, count, ranges = (
            state[f"tube_{self.heat.tube.name}_{what}"]
            for what in ("sums", "count", "ranges")
        )
        self.sums, self.count = np.array(sums), int(count)
        self.heat.tube.nusselt.restore(ranges)
