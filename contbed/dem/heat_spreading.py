"""Heat between two equal spheres whose columns spread within the particles: contact,
gap and constriction together.

Columns over a Voronoi face that do not exchange heat within the particles
(`heat_pair.column_conductance`) grow with pi R k_f ln(k_s/k_f), half of what Batchelor
and O'Brien found for spheres that nearly touch: heat draws together towards the contact
over a distance r and not along the whole radius. Here each half of the pair is a
cylinder of the particle's material on the disc of the Voronoi face, heated over its end
through a sheet of what the fluid adds:

    T_i - T_j = (g(r) + M)/k_f q - g(r) (1/k_i + 1/k_j)/2 q + (1/k_i + 1/k_j) S q,     G = integral of q over T_i - T_j

with q the heat flux at radius r, g the gap between the spheres, M the temperature jump
as a length, and S the temperature of the cylinder's end over q for a conductivity of 1:
tanh(lambda L)/lambda in each mode of the disc, L half the distance of the centres.
Within the contact the sheet is 1/h of the joint.

Exact limits: k face/d where all conductivities are equal; pi R k_f (2 ln(k_s/k_f) + K)
for touching spheres and large ratios, with Batchelor and O'Brien's constant; ln of the
gap where the gap is wide for the ratio; 2 k r_c for a smooth contact without a fluid.
Against a simple cubic lattice resolved in three dimensions: +4 % at a ratio of 2, +5 %
at 10, -1 % at 100, -2 % at 1555.

Source: Batchelor and O'Brien 1977, Proc. R. Soc. A 355, 313-333,
    doi:10.1098/rspa.1977.0100.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contbed.arrays import Array

RINGS = 96  # of the disc, in geometric progression; G is within 3e-4 of 192 rings
# innermost disc over R k_f/k_s, the radius at which spheres and gap share the
# resistance
FINEST = 1e-2
SMALLEST, LARGEST = 1e-8, 1e-5  # bounds of the innermost disc over that of the face
DEEP = 20.0  # lambda L above which tanh is 1 to the last digit
BATCH = 256  # pairs that are solved at once: 20 MB
# resistance of a perfect joint over that of the particle, in place of 0
PERFECT = 1e-12

_GAUSS = np.polynomial.legendre.leggauss(4)
_NODES, _WEIGHTS = 0.5 * (1.0 + _GAUSS[0]), 0.5 * _GAUSS[1]


class Disc(NamedTuple):
    """Rings of the unit disc: edges (n + 1), square roots of the eigenvalues (n),
    ring means of the modes (n, n).
    """

    edges: Array
    root: Array
    modes: Array


class Spreading(NamedTuple):
    """Conductance [W/K] through the fluid and through the contact of each pair; G is
    their sum.
    """

    fluid: Array
    contact: Array


def spreading_conductance(
    R: float,
    distance: ArrayLike,
    face: ArrayLike,
    k: tuple[float, float],
    k_fluid: float,
    r_contact: ArrayLike = 0.0,
    joint: ArrayLike = np.inf,
    jump: float = 0.0,
) -> Spreading:
    """Evaluate the conductance between equal spheres in a fluid.

    Parameters
    ----------
    R : radius [m]
    distance : of the centres [m]; overlapping spheres have the gap of touching ones
    face : area of the common Voronoi face [m2]
    k, k_fluid : conductivities of both spheres and of the fluid [W/m/K], which is not
        above those of the spheres
    r_contact : radius of the contact [m], 0 if there is none
    joint : coefficient of the joint within the contact [W/m2/K], asperities and the
        fluid between them; inf: perfect
    jump : M [m], what the temperature jumps of the gas at both surfaces add to the gap

    Raises
    ------
    ValueError : a fluid that conducts better than the particles
    """
    mean = 0.5 * (1.0 / k[0] + 1.0 / k[1])
    if k_fluid * mean > 1.0 + 1e-12:
        raise ValueError(
            "spreading columns are for fluids that conduct no better than the particles"
        )
    distance, face, r_contact, joint = (
        np.atleast_1d(item)
        for item in np.broadcast_arrays(
            *(
                np.asarray(item, dtype=float)
                for item in (distance, face, r_contact, joint)
            )
        )
    )
    disc = _disc(float(np.clip(FINEST * k_fluid * mean, SMALLEST, LARGEST)))
    fluid, contact = np.empty(distance.shape), np.empty(distance.shape)
    for start in range(0, distance.size, BATCH):
        part = slice(start, start + BATCH)
        r_face = np.sqrt(face[part] / np.pi)
        edges = r_face[:, None] * disc.edges
        gas, solid = _sheet(
            R, distance[part], edges, r_contact[part], joint[part], mean, k_fluid, jump
        )
        heat = _solve(
            1.0 / (gas + solid), 2.0 * mean, 0.5 * distance[part], r_face, disc
        )
        share = solid / (gas + solid)
        fluid[part] = np.sum(heat * (1.0 - share), axis=1)
        contact[part] = np.sum(heat * share, axis=1)
    return Spreading(fluid, contact)


@lru_cache(maxsize=8)
def _disc(innermost: float) -> Disc:
    """Find the modes of heat in a cylinder of radius 1 with insulated sides, by
    finite volumes on rings.
    """
    edges = np.concatenate([[0.0], np.geomspace(innermost, 1.0, RINGS)])
    area = np.pi * np.diff(edges**2)
    middle = np.sqrt(0.5 * (edges[1:] ** 2 + edges[:-1] ** 2))
    between = 2.0 * np.pi / np.log(middle[1:] / middle[:-1])
    matrix = (
        np.diag(np.append(between, 0.0) + np.append(0.0, between))
        - np.diag(between, 1)
        - np.diag(between, -1)
    )
    values, vectors = np.linalg.eigh(matrix / np.sqrt(np.outer(area, area)))
    # the uniform mode, free of rounding
    values[0], vectors[:, 0] = 0.0, np.sqrt(area / area.sum())
    return Disc(
        edges, np.sqrt(np.maximum(values, 0.0)), vectors / np.sqrt(area)[:, None]
    )


def _sheet(
    R: float,
    distance: Array,
    edges: Array,
    r_contact: Array,
    joint: Array,
    mean: float,
    k_fluid: float,
    jump: float,
) -> tuple[Array, Array]:
    """Find the conductance [W/K] of each ring of the sheet through fluid and through
    contact, (pairs, rings).

    edges : of the rings (pairs, rings + 1) [m]
    """
    inner, outer = edges[:, :-1], edges[:, 1:]
    start = np.maximum(inner, r_contact[:, None])
    rim = np.maximum(outer, r_contact[:, None])
    r2 = start[..., None] ** 2 + (rim**2 - start**2)[..., None] * _NODES
    half_chord = np.sqrt(np.maximum(R**2 - r2, 0.0))
    opening = np.maximum(distance - 2.0 * R, 0.0)[:, None, None]
    # 2 (R - half_chord) without cancellation; beyond the spheres the gap is the whole
    # distance
    gap = np.where(
        r2 < R**2, opening + 2.0 * r2 / (R + half_chord), distance[:, None, None]
    )
    least = PERFECT * R * mean
    resistance = gap * (1.0 / k_fluid - mean) + jump / k_fluid + least
    fluid = np.pi * (rim**2 - start**2) * ((1.0 / resistance) @ _WEIGHTS)
    covered = np.pi * (
        np.minimum(outer, r_contact[:, None]) ** 2
        - np.minimum(inner, r_contact[:, None]) ** 2
    )
    return fluid, covered / (1.0 / joint + least)[:, None]


def _solve(
    sheet: Array, resistivity: float, depth: Array, r_face: Array, disc: Disc
) -> Array:
    """Solve for the heat [W/K] of each ring at a unit difference of temperature;
    `sheet` is the resistance [K/W].
    """
    with np.errstate(divide="ignore"):
        end = 1.0 / disc.root
    end[0] = 0.0
    # of the modes only the first few reach the far end of the cylinder
    reach = int(np.searchsorted(disc.root * float((depth / r_face).min()), DEEP))
    low = disc.root[:reach]
    tail = np.tanh(low * (depth / r_face)[:, None]) - 1.0
    tail[:, 1:] *= end[1:reach]
    tail[:, 0] = depth / r_face
    modes = disc.modes
    deep = (modes * end) @ modes.T
    solid = deep + np.einsum(
        "ak,pk,bk->pab", modes[:, :reach], tail, modes[:, :reach], optimize=True
    )
    matrix = solid * (resistivity / r_face)[:, None, None]
    index = np.arange(sheet.shape[1])
    matrix[:, index, index] += sheet
    return np.asarray(np.linalg.solve(matrix, np.ones((*sheet.shape, 1)))[..., 0])
