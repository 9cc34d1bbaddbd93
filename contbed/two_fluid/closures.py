"""The closures of a two-fluid model, by name, made into functions of all cells.

The very functions of `contbed.closures` are compiled and called cell by cell. Near packing the radial distribution is
taken at most at DENSEST of eps_max; friction keeps its own distance. What guards and this limit touch is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import FunctionType

import numpy as np
from numba import njit

from contbed import closures
from contbed.closures.granular_transport import share_drag, share_free_path
from contbed.two_fluid.rheology import Closures, Rheology
from contbed.two_fluid.step import Materials

DENSEST = 0.997  # of eps_max, up to which the radial distribution follows its law
DILUTEST = 1e-9  # fraction below which the drag on one particle no longer changes
EMPTY = 1e-4  # fraction below which kinetic stress fades: it would heat particles that are not there
GUARDED = 0.99  # a kinetic part counts as guarded where less than this is left
STEP = 1e-7  # of eps_max, for the slope of the pressure
ENTRIES = 4001  # of the tables of friction

USUAL = {
    "drag": "drag_wen_yu",
    "radial_distribution": "g0_sinclair_jackson",
    "granular_pressure": "granular_pressure_lun",
    "granular_viscosity": "granular_viscosity_gidaspow",
    "granular_bulk_viscosity": "granular_bulk_lun",
    "granular_conductivity": "granular_conductivity_syamlal",
    "granular_dissipation": "granular_dissipation_lun",
    "granular_friction": "friction_johnson_jackson",
    "granular_friction_viscosity": "friction_viscosity_newtonian",
}
THEORY = tuple(USUAL)[1:-2]  # what a kernel of the kinetic theory is made of
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
    """`closures` for the step; `counts` of cells in steps, in the order of COUNTED."""

    closures: Closures
    counts: np.ndarray


def make(
    materials: Materials,
    particles: Particles,
    names: Mapping[str, str | None] | None = None,
    drag_options: Mapping[str, float] | None = None,
) -> Laws:
    """The laws of `names`, closure by kind, the USUAL ones where nothing is named; None where there is no such physics.

    Raises
    ------
    SceneError : no closure of that name and kind
    """
    wanted = USUAL | dict(names or {})
    chosen = {kind: closures.get(name, kind=kind) for kind, name in wanted.items() if name is not None}
    counts = np.zeros(3, dtype=np.int64)
    law = chosen.get("drag", _nothing)
    drag, options = _drag(law), tuple(float(value) for value in (_options(law) | dict(drag_options or {})).values())
    granular = _granular(*(chosen.get(kind, _nothing) for kind in THEORY))
    table = _friction(materials, particles, chosen.get("granular_friction", _nothing))
    gas, m = (materials.rho_gas, materials.mu_gas, materials.d_p), materials
    path = particles.free_path if particles.free_path is not None else np.inf
    constants = (m.rho_solid, m.d_p, m.eps_max, particles.restitution, path, particles.friction_from)

    def exchange(eps_s: np.ndarray, slip: np.ndarray) -> np.ndarray:
        out = np.empty_like(eps_s)
        drag(eps_s, slip, gas, options, out)
        return out

    def rheology(eps_s: np.ndarray, theta: np.ndarray, K: np.ndarray) -> Rheology:
        out = Rheology(*(np.empty_like(eps_s) for _ in Rheology._fields))
        granular(eps_s, theta, K, constants, table, counts, out)
        return out

    viscosity = chosen.get("granular_friction_viscosity", _nothing)
    sheared = hasattr(viscosity, "sheet") and "shear_rate" in viscosity.sheet.arguments
    angle = particles.friction_angle

    def friction(p: np.ndarray, shear_rate: np.ndarray) -> np.ndarray:
        return viscosity(p, angle, shear_rate) if sheared else viscosity(p, angle) + 0.0 * p

    first = particles.friction_from
    packing = (first, (m.eps_max - first) / (ENTRIES - 1), table[1] / m.rho_solid)
    return Laws(Closures(exchange, rheology, friction, sheared, packing), counts)


def compiled(function: Callable) -> Callable:
    """A closure compiled, and with it the closures that it calls."""
    known = function.__globals__
    called = {name: compiled(known[name]) for name in function.__code__.co_names if hasattr(known.get(name), "sheet")}
    plain = FunctionType(function.__code__, known | called, function.__name__, function.__defaults__)
    return njit(plain, error_model="numpy")


def _nothing(*_):
    return 0.0


def _options(closure: Callable) -> dict[str, float]:
    return dict(closure.sheet.options) if hasattr(closure, "sheet") else {}


@cache
def _drag(closure: Callable) -> Callable:
    """K = beta/eps_s in all cells."""
    beta = compiled(closure)

    @njit
    def kernel(eps_s, slip, gas, options, out):
        rho, mu, d_p = gas
        for i in range(len(eps_s)):
            s = max(eps_s[i], DILUTEST)
            out[i] = beta((1.0 - s) * rho * slip[i] * d_p / mu, 1.0 - s, d_p, mu, *options) / s

    return kernel


@cache
def _granular(*theory: Callable) -> Callable:
    """The kinetic theory in all cells, of closures in the order of THEORY, and friction from its table."""
    packs = "eps_max" in theory[0].sheet.arguments  # type: ignore[attr-defined]
    contact, pressure, viscosity, bulk, conductivity, dissipation = (compiled(closure) for closure in theory)
    contact_at = contact if packs else njit(lambda eps_s, _: contact(eps_s))
    by_drag, by_path = compiled(share_drag), compiled(share_free_path)
    root = np.pi**0.5

    @njit
    def kernel(eps_s, theta, K, constants, table, counts, out):
        rho, d_p, eps_max, e, path, first = constants
        eta, spacing = 0.5 * (1.0 + e), (eps_max - first) / (ENTRIES - 1)
        dilute_mu, dilute_k = 5.0 / 96.0 * root, 75.0 * root / (48.0 * eta * (41.0 - 33.0 * eta))
        for i in range(len(eps_s)):
            s, t = eps_s[i], theta[i]
            if packs and s > DENSEST * eps_max:
                s = DENSEST * eps_max
                counts[2] += 1
            g0, further = contact_at(s, eps_max), s + STEP * eps_max
            p = pressure(s, g0, e)
            slope = (pressure(further, contact_at(further, eps_max), e) - p) / (STEP * eps_max)
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
            out.mu[i] = scale * viscosity(s, g0, e, left_mu)
            out.bulk[i] = scale * bulk(s, g0, e)
            out.conductivity[i] = scale * conductivity(s, g0, e, left_k)
            out.dissipation[i] = rho / d_p * dissipation(s, g0, e)
            out.h[i] = 0.0
            out.p_friction[i] = 0.0
            if eps_s[i] > first:
                j = min(int((eps_s[i] - first) / spacing), ENTRIES - 2)
                w = (eps_s[i] - first) / spacing - j
                out.h[i] = table[0, j] + w * (table[0, j + 1] - table[0, j])
                out.stiffness[i] += eps_s[i] * (table[0, j + 1] - table[0, j]) / spacing
                out.p_friction[i] = table[1, j] + w * (table[1, j + 1] - table[1, j])

    return kernel


def _friction(materials: Materials, particles: Particles, closure: Callable) -> np.ndarray:
    """Integral of d p_friction/(rho_s eps_s), and p_friction, from first contact to densest packing."""
    s = np.linspace(particles.friction_from, materials.eps_max, ENTRIES)
    p = closure(s, materials.eps_max, particles.friction_from, particles.friction_strength) * np.ones(ENTRIES)
    h = np.concatenate(([0.0], np.cumsum(2.0 * np.diff(p) / (s[1:] + s[:-1])))) / materials.rho_solid
    return np.stack((h, p))
