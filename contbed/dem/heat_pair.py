"""Heat between two spheres: through the fluid around their contact, through the
contact, and in one impact.

Equation numbers are those of Zhou, Hou and Yu 2011 (Zhou, Yu, Zulli 2009,
doi:10.1002/aic.11735; 2010, doi:10.1016/j.powtec.2009.10.012). All functions take
numbers or arrays that broadcast and return conductances [W/K], symmetric in the two
particles.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contbed.arrays import Array

# half gaps above this many radii carry no heat (after Eq. 5: "2H greater than R")
REACH = 0.5
# r_ij = CONE R (1 - eps)^(-1/3): mean radius of the double cone shared by two
# neighbours
CONE = 0.560
# powers of the modulus: contact radius at a given load, and in a given collision
STATIC, IMPACT = 1 / 3, 1 / 5

BATCH = 2000  # pairs that are integrated at once: their arrays stay in a cache
# Gauss-Legendre in t, s = t^3 (10 - 15 t + 6 t^2), which resolves both ends
_GAUSS = np.polynomial.legendre.leggauss(96)
_T = 0.5 * (1.0 + _GAUSS[0])
_NODES = _T**3 * (10.0 - 15.0 * _T + 6.0 * _T**2)
_WEIGHTS = 15.0 * _T**2 * (1.0 - _T) ** 2 * _GAUSS[1]


def correction(modulus: Any, modulus_real: Any, exponent: float = STATIC) -> Any:
    """Evaluate the factor c of a contact radius that was simulated with too soft a
    material [-].

        c = (E / E_0)^exponent

    The paper has 1/5 (Eq. 14), Hertz's radius in a collision of given speed. A contact
    that carries a given load has r_c ~ E^(-1/3) instead, so that beds at rest take
    STATIC, collisions IMPACT. `modulus` is E of the simulation, `modulus_real` that of
    the material, both Young's or both reduced [Pa].
    """
    return (modulus / modulus_real) ** exponent


def contact_radius(
    R_i: ArrayLike, R_j: ArrayLike, distance: ArrayLike, factor: ArrayLike = 1.0
) -> Array:
    """Evaluate Hertz's contact radius c sqrt(R* delta) [m], R* = R_i
    R_j/(R_i + R_j); 0 without overlap (Eq. 13).
    """
    R_i, R_j = np.asarray(R_i, dtype=float), np.asarray(R_j, dtype=float)
    overlap = np.maximum(R_i + R_j - distance, 0.0)
    radius: Array = factor * np.sqrt(R_i * R_j / (R_i + R_j) * overlap)
    return radius


def contact_conductance(r_contact: ArrayLike, k_i: ArrayLike, k_j: ArrayLike) -> Array:
    """Evaluate conduction through a contact at rest (Eq. 6; Batchelor, O'Brien 1977,
    doi:10.1098/rspa.1977.0100).

    G = 4 r_c/(1/k_i + 1/k_j). Contact radius [m], conductivities [W/m/K].
    """
    conductance: Array = (
        4.0 * np.asarray(r_contact, dtype=float) / _resistivity(k_i, k_j)
    )
    return conductance


def gap_conductance(
    R_i: ArrayLike,
    R_j: ArrayLike,
    distance: ArrayLike,
    k_i: ArrayLike,
    k_j: ArrayLike,
    k_fluid: float,
    eps: ArrayLike,
    r_contact: ArrayLike = 0.0,
) -> Array:
    """Evaluate conduction from particle to particle through the fluid between them (Eq.
    5).

        G = int_r_c^r_sf 2 pi r dr/(s_i/k_i + s_j/k_j + gap/k_fluid),
        s_i = sqrt(R_i^2 - r^2) - r D_i/r_ij,  gap = D_i + D_j - sqrt(R_i^2 - r^2) - sqrt(R_j^2 - r^2)

    The heat runs along parallel lines between the surfaces of two cones over the same
    disc, of radius r_ij in the plane of equal power, D_i and D_j from the centres; at
    r_sf the lines within the particles have no length. r_ij = 0.560 R (1 - eps)^(-1/3)
    of the smaller particle. Overlapping particles count as touching. Equal particles:
    in closed form; others, and where it loses digits: quadrature. Relative error below
    1e-12 where particles conduct 0.01 to 1e4 times as well as the fluid and radii
    differ by ten times at most, 1e-11 to 1e6 and thirty times.

    Parameters
    ----------
    R_i, R_j : radii [m]
    distance : of the centres [m]
    k_i, k_j : conductivities of the particles [W/m/K]
    k_fluid : that of the fluid [W/m/K]
    eps : porosity around the pair [-]; the mean of both keeps G symmetric
    r_contact : radius of the contact [m], 0 if there is none: the lower limit (the
        paper prints r_ij)

    Returns
    -------
    G [W/K]; 0 where the gap 2H exceeds the smaller radius.
    """
    R_i, R_j, distance, eps, r_contact, k_i, k_j = np.broadcast_arrays(
        *(
            np.asarray(item, dtype=float)
            for item in (R_i, R_j, distance, eps, r_contact, k_i, k_j)
        )
    )
    small, large = np.minimum(R_i, R_j), np.maximum(R_i, R_j)
    k_small, k_large = np.where(R_i <= R_j, k_i, k_j), np.where(R_i <= R_j, k_j, k_i)
    apart = np.maximum(distance, small + large)
    near = apart - small - large <= 2.0 * REACH * small
    D = (apart**2 + (small - large) * (small + large)) / (2.0 * apart)
    cone = CONE * small * (1.0 - eps) ** (-1 / 3)
    end = small * cone / np.hypot(cone, D)
    out = np.zeros(small.shape)
    equal = near & (small == large)
    if equal.any():
        out[equal] = _equal_spheres(
            small[equal],
            D[equal],
            cone[equal],
            _resistivity(k_i, k_j)[equal],
            k_fluid,
            r_contact[equal],
            end[equal],
        )
    other = apart - D
    numbers = np.flatnonzero(near & ~equal)
    for rest in np.array_split(numbers, 1 + len(numbers) // BATCH):
        first = small.flat[rest], D.flat[rest], k_small.flat[rest]
        second = large.flat[rest], other.flat[rest], k_large.flat[rest]
        out.flat[rest] = _quadrature(
            first,
            second,
            cone.flat[rest],
            k_fluid,
            r_contact.flat[rest],
            end.flat[rest],
        )
    return out


def column_conductance(
    R: ArrayLike,
    distance: ArrayLike,
    face: ArrayLike,
    k_i: ArrayLike,
    k_j: ArrayLike,
    k_fluid: float,
) -> Array:
    """Evaluate conduction between equal particles along parallel columns over their
    common Voronoi face.

        G = int_0^r_f 2 pi r dr/((d - gap) (1/k_i + 1/k_j)/2 + gap/k_fluid),  gap = max(d - 2 sqrt(R^2 - r^2), 0)

    with sqrt(...) = 0 for r > R and r_f = sqrt(face/pi). Where all conductivities are
    equal this is k face/d, the exact flux of a linear temperature between the cells, so
    that a bed conducts as the material does; Eq. 5 gives 36 % too much there.

    Parameters
    ----------
    R : radius [m]
    distance : of the centres [m]
    face : area of the Voronoi face [m2]
    k_i, k_j, k_fluid : conductivities [W/m/K]

    Returns
    -------
    G [W/K], with the overlap of the particles but without the constriction at their contact: see `contact_excess`.
    """
    R, distance, face = (np.asarray(item, dtype=float) for item in (R, distance, face))
    K = _resistivity(k_i, k_j)
    r_face = np.sqrt(face / np.pi)
    lens = np.minimum(np.sqrt(np.maximum(R**2 - 0.25 * distance**2, 0.0)), r_face)
    rim = np.minimum(R, r_face)
    high, low = np.sqrt(R**2 - lens**2), np.sqrt(np.maximum(R**2 - rim**2, 0.0))
    # resistance of a column a + b u with u = sqrt(R^2 - r^2), r dr = -u du
    a, b = distance / k_fluid, K - 2.0 / k_fluid
    ring = 2.0 * np.pi * _mean_over(a + b * low, b * (high - low), low, high)
    inside = np.pi * lens**2 / (0.5 * distance * K)
    outside = np.pi * (r_face**2 - rim**2) * k_fluid / distance
    conductance: Array = inside + ring + outside
    return conductance


def contact_excess(
    r_contact: ArrayLike, k_i: ArrayLike, k_j: ArrayLike, k_fluid: float
) -> Array:
    """Evaluate what a contact adds to columns: Eq. 6 less the same in fluid alone, 2
    r_c (2/(1/k_i + 1/k_j) - k_f).
    """
    return (
        contact_conductance(r_contact, k_i, k_j)
        - 2.0 * np.asarray(r_contact, dtype=float) * k_fluid
    )


def _resistivity(k_i: ArrayLike, k_j: ArrayLike) -> Any:
    return 1.0 / np.asarray(k_i, dtype=float) + 1.0 / np.asarray(k_j, dtype=float)


def _mean_over(start: Array, rise: Array, low: Array, high: Array) -> Array:
    """Integrate u/(start + rise (u - low)/(high - low)) over u from low to high:
    logarithm, or its series.
    """
    span = high - low
    x = rise / start
    small = np.abs(x) < 1e-2
    safe = np.where(small, 1.0, x)
    log = np.log1p(np.where(small, 0.0, x))
    powers = np.arange(10)
    series = (-np.where(small, x, 0.0)[..., None]) ** powers
    zeroth = np.where(small, (series / (powers + 1)).sum(-1), log / safe)
    first = np.where(small, (series / (powers + 2)).sum(-1), (1.0 - zeroth) / safe)
    return span / start * (low * zeroth + span * first)


def _equal_spheres(
    R: Array, D: Array, cone: Array, K: Array, k_fluid: float, low: Array, high: Array
) -> Array:
    """Integrate Eq. 5 for equal particles in closed form, r = R sin(angle): 2 pi R^2
    int s c/(A c + B s + C).
    """
    A, B, C = R * (K - 2.0 / k_fluid), -R * D * K / cone, 2.0 * D / k_fluid
    M, p = A**2 + B**2, C - A
    sum_AC = R * K + 2.0 * (D - R) / k_fluid
    w2 = (C - A) * sum_AC - B**2
    s0, s1 = low / R, high / R
    c0, c1 = np.sqrt((1.0 - s0) * (1.0 + s0)), np.sqrt((1.0 - s1) * (1.0 + s1))
    P0, P1 = A * c0 + B * s0, A * c1 + B * s1
    t0, t1 = p * s0 / (1.0 + c0) + B, p * s1 / (1.0 + c1) + B
    poor = (np.abs(w2) < 1e-2 * np.minimum(t0**2, t1**2)) | (np.abs(p) < 1e-3 * C)
    w = np.sqrt(np.where(poor, 1.0, np.abs(w2)))
    with np.errstate(all="ignore"):
        J = np.where(
            w2 > 0,
            2.0 / w * (np.arctan(t1 / w) - np.arctan(t0 / w)),
            (np.log(np.abs((t1 - w) / (t1 + w))) - np.log(np.abs((t0 - w) / (t0 + w))))
            / w,
        )
    turn = np.arctan2(s1 * c0 - c1 * s0, c1 * c0 + s1 * s0)
    arc = 2.0 * ((A * s1 - B * c1) - (A * s0 - B * c0) - C * turn + C**2 * J) - M * J
    # denominators P + C without cancellation where the particles touch
    D0, D1 = (
        K * (R * c - s * R * D / cone)
        + 2.0 * ((D - R) + R * s**2 / (1.0 + c)) / k_fluid
        for s, c in ((s0, c0), (s1, c1))
    )
    line = P1 - P0 - C * np.log(D1 / D0)
    G = 2.0 * np.pi * R**2 / M**2 * (A * B * arc + (B - A) * (B + A) * line)
    if poor.any():
        R, D, cone, half = R[poor], D[poor], cone[poor], 2.0 / K[poor]
        G[poor] = _quadrature(
            (R, D, half), (R, D, half), cone, k_fluid, low[poor], high[poor]
        )
    return G


def _quadrature(
    first: tuple[Array, Array, Array],
    second: tuple[Array, Array, Array],
    cone: Array,
    k_fluid: float,
    low: Array,
    high: Array,
) -> Array:
    """Integrate Eq. 5 over r = low + (high - low) s, with most nodes at the contact,
    where the gap is narrow, and at the rim, where it is nearly the whole path.

    `first` and `second` are radius, distance to the face and conductivity of the
    particles of each pair.
    """
    R_i, D_i, k_i = (item[..., None] for item in first)
    R_j, D_j, k_j = (item[..., None] for item in second)
    cone, low, span, high = (item[..., None] for item in (cone, low, high - low, high))
    r = low + span * _NODES
    u_i, u_j = np.sqrt((R_i - r) * (R_i + r)), np.sqrt((R_j - r) * (R_j + r))
    # D - u without cancellation where the particles touch
    gap = sum(D - R + r**2 / (R + u) for D, R, u in ((D_i, R_i, u_i), (D_j, R_j, u_j)))
    cone_j = D_j * high / np.sqrt((R_j - high) * (R_j + high))
    solid = (u_i - r * D_i / cone) / k_i + (u_j - r * D_j / cone_j) / k_j
    return (2.0 * np.pi * r * span / (solid + gap / k_fluid)) @ _WEIGHTS
