"""The closures of a two-fluid model as functions of all cells.

The very functions of `contbed.closures` are compiled and called cell by cell, see `closures.compiled`. Near packing
the radial distribution is taken at most at DENSEST of eps_max; friction keeps its own distance. What guards and this
limit touch is counted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.closures.binding import BoundClosure
from contbed.closures.compiled import face, kernel, own_values
from contbed.closures.granular_transport import share_drag, share_free_path
from contbed.two_fluid.closures import GIVES, Bound
from contbed.two_fluid.model import Materials
from contbed.two_fluid.rheology import Closures, Rheology

Array = NDArray[np.float64]

DENSEST = 0.997  # of eps_max, up to which the radial distribution follows its law
DILUTEST = 1e-9  # fraction below which the drag on one particle no longer changes
EMPTY = 1e-4  # fraction below which kinetic stress fades: it would heat particles that are not there
GUARDED = 0.99  # a kinetic part counts as guarded where less than this is left
STEP = 1e-7  # of eps_max, for the slope of the pressure
ENTRIES = 4001  # of the tables of friction

THEORY = (
    "radial_distribution",
    "granular_pressure",
    "granular_viscosity",
    "granular_bulk_viscosity",
    "granular_conductivity",
    "granular_dissipation",
)  # fmt: skip
ROOT_PI = np.pi**0.5
COUNTED = ("drag_guard_cells", "free_path_guard_cells", "packed_cells")


@dataclass(frozen=True)
class Particles:
    """What the closures need of the particles besides `Materials`.

    restitution : of two particles [-]
    friction_from : fraction above which particles rub; friction_strength [Pa]; friction_angle [rad]
    free_path : the largest that the guards of dilute flow allow [m]; None without guards
    """

    restitution: float
    friction_from: float = 0.5
    friction_strength: float = 0.05
    friction_angle: float = 0.49742
    free_path: float | None = None


@dataclass(frozen=True)
class Laws:
    """`closures` for the step, made of `bound`; `counts` of cells in steps, in the order of COUNTED."""

    closures: Closures
    bound: Bound
    counts: NDArray[np.int64]


def make(materials: Materials, particles: Particles, bound: Bound) -> Laws:
    """Make the functions of all cells from closures by kind; None where there is no such physics."""
    counts = np.zeros(3, dtype=np.int64)
    drag, own = _drag(bound["drag"]), own_values(bound["drag"])
    theory = tuple(bound[kind] for kind in THEORY)
    granular, constants_of_theory = _granular(theory), tuple(own_values(closure) for closure in theory)
    table = _friction(materials, particles, bound["granular_friction"])
    gas, m = (materials.rho_gas, materials.mu_gas, materials.d_p), materials
    path = particles.free_path if particles.free_path is not None else np.inf
    constants = (m.rho_solid, m.d_p, m.eps_max, particles.restitution, path, particles.friction_from)

    def exchange(eps_s: Array, slip: Array) -> Array:
        out = np.empty_like(eps_s)
        drag(eps_s, slip, gas, own, out)
        return out

    def rheology(eps_s: Array, theta: Array, K: Array) -> Rheology:
        out = Rheology(*(np.empty_like(eps_s) for _ in Rheology._fields))
        granular(eps_s, theta, K, constants, constants_of_theory, table, counts, out)
        return out

    viscosity = bound["granular_friction_viscosity"]
    sheared = viscosity is not None and "shear_rate" in viscosity.takes

    def friction(p: Array, shear_rate: Array) -> Array:
        if viscosity is None:
            return 0.0 * p
        mu = viscosity(p_friction=p, angle=particles.friction_angle, shear_rate=shear_rate)
        return mu if sheared else mu + 0.0 * p  # type: ignore[no-any-return]

    first = particles.friction_from
    packing = (first, (m.eps_max - first) / (ENTRIES - 1), table[1] / m.rho_solid)
    return Laws(Closures(exchange, rheology, friction, sheared, packing), bound, counts)


def _drag(closure: BoundClosure | None) -> Callable[..., None]:
    """K = beta/eps_s in all cells."""
    return kernel(_drag_in_cells, {"beta": face(closure, GIVES["drag"])})


# what the two functions below call: `kernel` puts closures in the place of these names
beta: Any = None
contact = pressure = viscosity = bulk = conductivity = dissipation = by_drag = by_path = beta
packs = True


def _drag_in_cells(eps_s: Any, slip: Any, gas: Any, own: Any, out: Any) -> None:
    rho, mu, d_p = gas
    for i in range(len(eps_s)):
        s = max(eps_s[i], DILUTEST)
        out[i] = beta((1.0 - s) * rho * slip[i] * d_p / mu, 1.0 - s, d_p, mu, own) / s


def _granular(theory: tuple[BoundClosure | None, ...]) -> Callable[..., None]:
    """Compile the kinetic theory of closures in the order of THEORY, and friction from its table."""
    names = ("contact", "pressure", "viscosity", "bulk", "conductivity", "dissipation")
    faces = {name: face(closure, GIVES[kind]) for name, kind, closure in zip(names, THEORY, theory, strict=True)}
    packs = theory[0] is not None and "eps_max" in theory[0].takes
    return kernel(_granular_in_cells, faces | {"by_drag": share_drag, "by_path": share_free_path}, packs=packs)


def _granular_in_cells(
    eps_s: Any, theta: Any, K: Any, constants: Any, own: Any, table: Any, counts: Any, out: Any
) -> None:
    rho, d_p, eps_max, e, path, first = constants
    eta, spacing = 0.5 * (1.0 + e), (eps_max - first) / (ENTRIES - 1)
    dilute_mu, dilute_k = 5.0 / 96.0 * ROOT_PI, 75.0 * ROOT_PI / (48.0 * eta * (41.0 - 33.0 * eta))
    for i in range(len(eps_s)):
        s, t = eps_s[i], theta[i]
        if packs and s > DENSEST * eps_max:
            s = DENSEST * eps_max
            counts[2] += 1
        g0, further = contact(s, eps_max, own[0]), s + STEP * eps_max
        p = pressure(s, g0, e, own[1])
        slope = (pressure(further, contact(further, eps_max, own[0]), e, own[1]) - p) / (STEP * eps_max)
        left_mu = s * s / (s * s + EMPTY * EMPTY)
        left_k = left_mu
        if path < np.inf:
            share = by_drag(K[i], t, s, g0, rho, d_p, dilute_mu, 2.0)
            counts[0] += share < GUARDED
            left_mu *= share
            left_k *= by_drag(K[i], t, s, g0, rho, d_p, dilute_k, 1.2)
            share = by_path(s, g0, d_p, path)
            counts[1] += share < GUARDED
            left_mu *= share
            left_k *= share
        scale = rho * d_p * t**0.5
        out.g0[i] = g0
        out.pressure[i] = p * eps_s[i] / s if s > 0 else p
        out.stiffness[i] = t * slope
        out.mu[i] = scale * viscosity(s, g0, e, left_mu, own[2])
        out.bulk[i] = scale * bulk(s, g0, e, own[3])
        out.conductivity[i] = scale * conductivity(s, g0, e, left_k, own[4])
        out.dissipation[i] = rho / d_p * dissipation(s, g0, e, own[5])
        out.h[i] = 0.0
        out.p_friction[i] = 0.0
        if eps_s[i] > first:
            j = min(int((eps_s[i] - first) / spacing), ENTRIES - 2)
            w = (eps_s[i] - first) / spacing - j
            out.h[i] = table[0, j] + w * (table[0, j + 1] - table[0, j])
            out.stiffness[i] += eps_s[i] * (table[0, j + 1] - table[0, j]) / spacing
            out.p_friction[i] = table[1, j] + w * (table[1, j + 1] - table[1, j])


def _friction(materials: Materials, particles: Particles, closure: BoundClosure | None) -> Array:
    """Integral of d p_friction/(rho_s eps_s), and p_friction, from first contact to densest packing."""
    s, p = np.linspace(particles.friction_from, materials.eps_max, ENTRIES), np.zeros(ENTRIES)
    if closure is not None:
        first, strength = particles.friction_from, particles.friction_strength
        p = closure(eps_s=s, eps_max=materials.eps_max, eps_min=first, strength=strength) * np.ones(ENTRIES)
    h = np.concatenate(([0.0], np.cumsum(2.0 * np.diff(p) / (s[1:] + s[:-1])))) / materials.rho_solid
    return np.stack((h, p))
