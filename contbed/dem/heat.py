"""Heat in an assembly of particles: who exchanges with whom, and how much by each
mechanism.

Conduction follows Zhou, Hou and Yu 2011, Eqs. 5-6, radiation Eqs. 8-9, convection Eq.
4. A box is (low, high), its corners [m]; `periodic` says for each axis whether it
closes on itself, other sides are adiabatic walls.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import Voronoi, cKDTree

from contbed.arrays import Array, Flags
from contbed.dem import heat_pair
from contbed.dem.heat_spreading import spreading_conductance
from contbed.dem.surface import Surface

Box = tuple[ArrayLike, ArrayLike]

STEFAN_BOLTZMANN = 5.670374419e-8  # [W/m2/K4]
# radius of a particle's radiating environment over its diameter (below Eq. 9)
VIEW = 1.5
# of the sum of their radii: distances of particles that touch carry the rounding of
# their coordinates
TOUCHING = 1.0 + 1e-12
CLOSED = (False, False, False)
Paths = Literal["cones", "columns", "spreading"]
VORONOI = ("columns", "spreading")  # paths that need the faces of Voronoi cells


@dataclass(frozen=True)
class Pairs:
    """Every pair once: indices `i`, `j` and the vector from i to j [m], through the
    periodic side if shorter.

    `face` is the area [m2] that the Voronoi cells of i and j share, None if they were
    not asked for.
    """

    i: NDArray[np.intp]
    j: NDArray[np.intp]
    vector: Array
    face: Array | None = None

    @property
    def distance(self) -> Array:
        """Distance of the centres [m]."""
        return np.asarray(np.linalg.norm(self.vector, axis=1))


class Conduction(NamedTuple):
    """How particles conduct: conductivities [W/m/K], porosity at the particles (one or
    each), contact correction c.

    `k_fluid` None leaves out the fluid, `contact_radius` [m] is given to touching pairs
    instead of Hertz's. `paths`: cones are the paper's Eq. 5; columns over Voronoi faces
    are exact where fluid and particles conduct alike; spreading columns draw heat
    together at the contact as well, which counts where the particles conduct far better
    than the fluid, and may have a rough `surface` with a gas between.
    """

    k_particle: ArrayLike
    k_fluid: float | None
    eps: ArrayLike = 0.4
    factor: float = 1.0
    contact_radius: float | None = None
    paths: Paths = "cones"
    surface: Surface | None = None


def near_pairs(
    x: Array, reach: float, box: Box | None = None, periodic: tuple[bool, ...] = CLOSED
) -> Pairs:
    """Find pairs not further apart than `reach` [m]; a small periodic cell may pair
    a particle with itself.
    """
    x = np.asarray(x, dtype=float)
    if box is None or not any(periodic):
        i, j = cKDTree(x).query_pairs(reach, output_type="ndarray").T
        return Pairs(i, j, x[j] - x[i])
    where, owner, shift = _images(x, box, periodic, reach, mirror=False)
    # i < image: copies come last
    i, image = cKDTree(where).query_pairs(reach, output_type="ndarray").T
    order = np.lexsort((image, i))
    i, image = i[order], image[order]
    j = owner[image]
    once = (i < len(x)) & ((i < j) | ((i == j) & _positive(shift[image])))
    return Pairs(i[once], j[once], (where[image] - where[i])[once])


def voronoi_pairs(x: Array, box: Box, periodic: tuple[bool, ...] = CLOSED) -> Pairs:
    """Find pairs whose Voronoi cells share a face, with its area; mirrored particles
    close the cells at walls.
    """
    x = np.asarray(x, dtype=float)
    low, high = (np.asarray(corner, dtype=float) for corner in box)
    reach = 4.0 * float(np.cbrt(np.prod(high - low) / len(x)))
    where, owner, shift = _images(x, box, periodic, reach, mirror=True)
    cells = Voronoi(where)
    first, second = cells.ridge_points.T
    inner = (first < len(x)) | (second < len(x))
    first, second = np.where(first < second, (first, second), (second, first))[:, inner]
    loops = [
        loop for loop, kept in zip(cells.ridge_vertices, inner, strict=True) if kept
    ]
    area = _areas(cells.vertices, loops)
    j, moved = owner[second], shift[second]
    # the particles themselves come first among the images; mirrored ones have the owner
    # -1
    once = (j >= 0) & (
        (second < len(x)) | (first < j) | ((first == j) & _positive(moved))
    )
    i = first[once]
    return Pairs(i, j[once], where[second[once]] - x[i], area[once])


def conductances(pairs: Pairs, radius: ArrayLike, heat: Conduction) -> dict[str, Array]:
    """Find the conductance [W/K] of each pair by mechanism: `contact`,
    `fluid_touching`, `fluid_apart`.

    The last two are the particle-fluid-particle path of pairs that do and do not touch;
    absent without a fluid.
    """
    R = np.asarray(radius, dtype=float)
    R_i, R_j = (R, R) if R.ndim == 0 else (R[pairs.i], R[pairs.j])
    k = np.asarray(heat.k_particle, dtype=float)
    k_i, k_j = (k, k) if k.ndim == 0 else (k[pairs.i], k[pairs.j])
    distance = pairs.distance
    touching = distance <= (R_i + R_j) * TOUCHING
    r_c = contact_radii(pairs, R, heat)
    found = {"contact": heat_pair.contact_conductance(r_c, k_i, k_j)}
    if heat.k_fluid is None:
        return found
    if heat.paths != "cones":
        if pairs.face is None or (R.ndim and np.ptp(R) > 0):
            raise ValueError(
                f"{heat.paths} need equal particles and the Voronoi faces of "
                "`voronoi_pairs`"
            )
        if heat.paths == "spreading":
            fluid, found["contact"] = _spreading(
                distance, pairs.face, float(R.flat[0]), r_c, heat
            )
        else:
            fluid = heat_pair.column_conductance(
                R_i, distance, pairs.face, k_i, k_j, heat.k_fluid
            )
            found["contact"] = heat_pair.contact_excess(r_c, k_i, k_j, heat.k_fluid)
    else:
        eps = np.asarray(heat.eps, dtype=float)
        mean = eps if eps.ndim == 0 else 0.5 * (eps[pairs.i] + eps[pairs.j])
        fluid = heat_pair.gap_conductance(
            R_i, R_j, distance, k_i, k_j, heat.k_fluid, mean, r_c
        )
    return found | {
        "fluid_touching": np.where(touching, fluid, 0.0),
        "fluid_apart": np.where(touching, 0.0, fluid),
    }


def contact_radii(pairs: Pairs, radius: ArrayLike, heat: Conduction) -> Array:
    """Find the radius of the contact of each pair [m], 0 of those that do not touch."""
    R = np.asarray(radius, dtype=float)
    R_i, R_j = (R, R) if R.ndim == 0 else (R[pairs.i], R[pairs.j])
    distance = pairs.distance
    if heat.contact_radius is None:
        return heat_pair.contact_radius(R_i, R_j, distance, heat.factor)
    given = heat.factor * heat.contact_radius
    return np.where(distance <= (R_i + R_j) * TOUCHING, given, 0.0)


def _spreading(
    distance: Array, face: Array, R: float, r_contact: Array, heat: Conduction
) -> tuple[Array, Array]:
    """Find the conductances [W/K] through fluid and contact along spreading paths."""
    k, k_fluid = np.asarray(heat.k_particle, dtype=float), heat.k_fluid
    if k.ndim or k_fluid is None:
        raise ValueError(
            "spreading paths need a fluid and particles of one conductivity"
        )
    both = (float(k), float(k))
    if heat.surface is None:
        return spreading_conductance(R, distance, face, both, k_fluid, r_contact)
    joint, jump = heat.surface.resistances(r_contact, R, float(k), k_fluid)
    return spreading_conductance(
        R, distance, face, both, k_fluid, r_contact, joint, jump
    )


def convection(Re: Any, Pr: Any, k_fluid: Any, d_p: Any) -> Any:
    """Evaluate the coefficient between a particle and the fluid [W/m2/K], Nu = 2 +
    1.2 Re^0.5 Pr^(1/3) (Eq. 4).

    Re on the local superficial relative velocity; the factor is 0.6 to 1.8 in Kunii
    and Levenspiel (1991).
    """
    return (2.0 + 1.2 * Re**0.5 * Pr ** (1 / 3)) * k_fluid / d_p


def radiation_conductance(
    pairs: Pairs, count: int, T: float, d_p: float, emissivity: float, eps: ArrayLike
) -> Array:
    """Return the reciprocal conductances [W/K] of the pairs within 1.5 d_p that have the
    slope of Eqs. 8-9.

        G_ij = 4 sigma e T^3 pi d^2 (1 - eps) (1/n_i + 1/n_j)/2

    with n the number of neighbours and the fluid at the temperature of the particle;
    other pairs get 0. In a vacuum, eps = 0 here, neighbours are all that is seen. Eqs.
    8-9 themselves do not keep the energy: particles would lose heat to a gas that does
    not take it. Pairs exchange G_ij (T_j^4 - T_i^4)/(4 T^3), by which nothing is lost.
    """
    seen = pairs.distance <= VIEW * d_p
    neighbours = (np.bincount(end, seen, count) for end in (pairs.i, pairs.j))
    n = np.maximum(sum(neighbours), 1.0)
    whole = 4.0 * STEFAN_BOLTZMANN * emissivity * T**3 * np.pi * d_p**2
    share = 1.0 - np.asarray(eps, dtype=float)
    return (
        seen
        * whole
        * (share if share.ndim == 0 else 0.5 * (share[pairs.i] + share[pairs.j]))
        * (0.5 / n[pairs.i] + 0.5 / n[pairs.j])
    )


def total(parts: Mapping[str, Array]) -> Array:
    """Sum the mechanisms [W/K]."""
    return np.asarray(np.sum(list(parts.values()), axis=0))


def _positive(shift: NDArray[np.int_]) -> Flags:
    """Check whether the first component that is not 0 is positive: of a shift and
    its opposite exactly one is.
    """
    return np.asarray(shift @ np.array([10000, 100, 1]) > 0)


def _images(
    x: Array, box: Box, periodic: tuple[bool, ...], reach: float, mirror: bool
) -> tuple[Array, NDArray[np.intp], NDArray[np.int_]]:
    """List the particles, then copies within `reach` of the box: positions, owners
    (-1 if mirrored), periods moved.
    """
    low, high = (np.asarray(corner, dtype=float) for corner in box)
    where, owner, shift = x, np.arange(len(x)), np.zeros((len(x), 3), dtype=int)
    for axis in range(3):
        size = high[axis] - low[axis]
        copies = [(where, owner, shift)]
        if periodic[axis]:
            most = int(np.ceil(reach / size))
            for n in (*range(-most, 0), *range(1, most + 1)):
                step = np.eye(3, dtype=int)[axis] * n
                copies.append((where + step * size, owner, shift + step))
        elif mirror:
            for wall in (low[axis], high[axis]):
                image = where.copy()
                image[:, axis] = 2.0 * wall - image[:, axis]
                copies.append((image, np.full(len(where), -1), shift))
        where, owner, shift = (
            np.concatenate(part) for part in zip(*copies, strict=True)
        )
        kept = (where[:, axis] >= low[axis] - reach) & (
            where[:, axis] <= high[axis] + reach
        )
        kept[: len(x)] = True
        where, owner, shift = where[kept], owner[kept], shift[kept]
    return where, owner, shift


def _areas(vertices: Array, loops: list[list[int]]) -> Array:
    """Find the areas of plane polygons given by the indices of their corners in
    order.
    """
    sizes = np.array([len(loop) for loop in loops])
    corners = np.concatenate([np.asarray(loop) for loop in loops])
    start = np.concatenate([[0], np.cumsum(sizes)[:-1]])
    following = np.arange(1, len(corners) + 1)
    following[start + sizes - 1] = start
    base = np.repeat(vertices[corners[start]], sizes, axis=0)
    cross = np.cross(vertices[corners] - base, vertices[corners[following]] - base)
    return np.asarray(0.5 * np.linalg.norm(np.add.reduceat(cross, start), axis=1))
