"""The closures of a two-fluid model as functions of all cells.

The very functions of `contbed.closures` are compiled and called cell by cell, see
`closures.compiled`. Near packing the radial distribution is evaluated at most at
MAX_RADIAL_FRACTION of eps_max; friction has a limit of its own. The cells in which this
limit or a guard of dilute flow acts are counted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array
from contbed.closures.binding import BoundClosure
from contbed.closures.compiled import Face, kernel, own_values
from contbed.closures.granular_transport import share_drag, share_free_path
from contbed.compiled.threads import parallel
from contbed.two_fluid.closures import GIVES, Bound
from contbed.two_fluid.model import Materials
from contbed.two_fluid.rheology import Closures, Rheology

Counter = NDArray[np.int64]

# eps_s/eps_max [-] up to which the radial distribution, singular at 1, is evaluated
MAX_RADIAL_FRACTION = 0.997
MIN_DRAG_FRACTION = 1e-9  # eps_s [-] below which K = beta/eps_s is that of one particle
MIN_KINETIC_FRACTION = (
    # eps_s [-] below which kinetic viscosity and conductivity fade: they do not vanish
    # with eps_s
    1e-4
)
# share of a kinetic part [-] below which its cell counts as guarded
MIN_UNGUARDED_SHARE = 0.99
# step of eps_s over eps_max [-] in the difference quotient of the pressure
SLOPE_STEP = 1e-7
TABLE_SIZE = 4001  # entries of the friction tables, evenly spaced in eps_s

KINETIC_THEORY = (
    "radial_distribution",
    "granular_pressure",
    "granular_viscosity",
    "granular_bulk_viscosity",
    "granular_conductivity",
    "granular_dissipation",
)  # fmt: skip
ROOT_PI = np.pi**0.5


class FrictionTables(NamedTuple):
    """Friction at TABLE_SIZE solids fractions from friction_from to eps_max.

    potential [m2/s2] : integral of d p_friction/(rho_s eps_s)
    p_friction [Pa] : frictional pressure
    """

    potential: Array
    p_friction: Array


class GuardCounts(NamedTuple):
    """Cells, summed over all steps, in which a limit acted; arrays of one number each.

    drag_guard_cells, free_path_guard_cells : guards of dilute flow left less than
        MIN_UNGUARDED_SHARE
    packed_cells : above MAX_RADIAL_FRACTION
    """

    drag_guard_cells: Counter
    free_path_guard_cells: Counter
    packed_cells: Counter


class GranularConstants(NamedTuple):
    """Numbers that the granular closures take in all cells.

    dissipative : restitution of the dissipation; free_path [m] : infinite without
        guards
    """

    rho_solid: float
    d_p: float
    eps_max: float
    restitution: float
    dissipative: float
    free_path: float
    friction_from: float


@dataclass(frozen=True)
class ParticleProperties:
    """What the closures need of the particles besides `Materials`.

    restitution : of two particles [-]; dissipative_restitution : that of the
        dissipation
    friction_from : fraction above which particles rub; friction_strength [Pa];
        friction_angle [rad]
    free_path : the largest that the guards of dilute flow allow [m]; None without
        guards
    """

    restitution: float
    dissipative_restitution: float
    friction_from: float = 0.5
    friction_strength: float = 0.05
    friction_angle: float = 0.49742
    free_path: float | None = None


@dataclass(frozen=True)
class CompiledClosures:
    """`closures` are what the step calls, made of the `bound` closures by kind;
    `counts` are added to by each call.
    """

    closures: Closures
    bound: Bound
    counts: GuardCounts


def make(
    materials: Materials, particles: ParticleProperties, bound: Bound
) -> CompiledClosures:
    """Compile the bound closures into functions of all cells; a closure that is None
    contributes nothing.
    """
    counts = GuardCounts(*(np.zeros(1, dtype=np.int64) for _ in GuardCounts._fields))
    drag, own = _drag(bound["drag"]), own_values(bound["drag"])
    theory = tuple(bound[kind] for kind in KINETIC_THEORY)
    granular, parameters = (
        _granular(theory),
        tuple(own_values(closure) for closure in theory),
    )
    tables = _friction(materials, particles, bound["granular_friction"])
    gas, m = (materials.rho_gas, materials.mu_gas, materials.d_p), materials
    path = particles.free_path if particles.free_path is not None else np.inf
    e, dissipative = particles.restitution, particles.dissipative_restitution
    constants = GranularConstants(
        m.rho_solid, m.d_p, m.eps_max, e, dissipative, path, particles.friction_from
    )

    def drag_coefficient(eps_s: Array, slip: Array) -> Array:
        """K = beta/eps_s (nc,) [kg/m3/s]."""
        out = np.empty_like(eps_s)
        parallel(drag, len(out), eps_s, slip, gas, own, out)
        return out

    def rheology(eps_s: Array, theta: Array, K: Array) -> Rheology:
        """Kinetic theory and frictional pressure in all cells."""
        out = Rheology(*(np.empty_like(eps_s) for _ in Rheology._fields))
        found = parallel(
            granular, len(eps_s), (eps_s, theta, K), constants, parameters, tables, out
        )
        for number, of_parts in zip(counts, zip(*found, strict=True), strict=True):
            number += sum(of_parts)
        return out

    viscosity = bound["granular_friction_viscosity"]
    sheared = viscosity is not None and "shear_rate" in viscosity.takes

    def friction_viscosity(p: Array, shear_rate: Array) -> Array:
        """Frictional viscosity (nc,) [Pa s] from the frictional pressure p [Pa] and
        the shear rate [1/s].
        """
        if viscosity is None:
            return 0.0 * p
        mu = viscosity(
            p_friction=p, angle=particles.friction_angle, shear_rate=shear_rate
        )
        return mu if sheared else mu + 0.0 * p  # type: ignore[no-any-return]

    first = particles.friction_from
    packing = (
        first,
        (m.eps_max - first) / (TABLE_SIZE - 1),
        tables.p_friction / m.rho_solid,
    )
    return CompiledClosures(
        Closures(drag_coefficient, rheology, friction_viscosity, sheared, packing),
        bound,
        counts,
    )


def _drag(closure: BoundClosure | None) -> Callable[..., None]:
    """Compile the kernel that evaluates K = beta/eps_s in all cells."""
    return kernel(_drag_in_cells, {"beta": Face(closure, GIVES["drag"])})


# names that the two kernels below call; `kernel` binds them to the closures of a scene
beta: Any = None
radial_distribution = pressure = viscosity = bulk = conductivity = dissipation = beta
drag_guard = free_path_guard = beta
singular = True  # whether the radial distribution is singular at eps_max


def _drag_in_cells(
    begin: int, end: int, eps_s: Any, slip: Any, gas: Any, own: Any, out: Any
) -> None:
    """Set out = K (nc,) [kg/m3/s]; gas = (rho, mu, d_p), own = parameters of the
    closure.
    """
    rho, mu, d_p = gas
    for i in range(begin, end):
        s = max(eps_s[i], MIN_DRAG_FRACTION)
        out[i] = beta((1.0 - s) * rho * slip[i] * d_p / mu, 1.0 - s, d_p, mu, own) / s


def _granular(theory: tuple[BoundClosure | None, ...]) -> Callable[..., None]:
    """Compile the kinetic theory of closures in the order of KINETIC_THEORY, and
    friction from its table.
    """
    names = (
        "radial_distribution",
        "pressure",
        "viscosity",
        "bulk",
        "conductivity",
        "dissipation",
    )
    faces = {
        name: Face(closure, GIVES[kind])
        for name, kind, closure in zip(names, KINETIC_THEORY, theory, strict=True)
    }
    singular = theory[0] is not None and "eps_max" in theory[0].takes
    guards: dict[str, Any] = {
        "drag_guard": share_drag,
        "free_path_guard": share_free_path,
    }
    return kernel(_granular_in_cells, faces | guards, singular=singular)


def _granular_in_cells(
    begin: int, end: int, fields: Any, constants: Any, own: Any, tables: Any, out: Any
) -> tuple[int, int, int]:
    """Set the `Rheology` out and return the numbers of `GuardCounts`.

    `fields` are eps_s, theta and K; `own` are the parameters of the closures in the
    order of KINETIC_THEORY.

    The guards limit the kinetic parts of viscosity and conductivity in dilute flow;
    they take the dilute limits of both over rho_s d_p sqrt(theta). The factor of
    `share_drag` is 2 for viscosity and 1.2 for conductivity.
    """
    eps_s, theta, K = fields
    rho, d_p, eps_max, e = (
        constants.rho_solid,
        constants.d_p,
        constants.eps_max,
        constants.restitution,
    )
    path, first = constants.free_path, constants.friction_from
    h_table, p_table = tables.potential, tables.p_friction
    eta, spacing = 0.5 * (1.0 + e), (eps_max - first) / (TABLE_SIZE - 1)
    dilute_mu, dilute_k = (
        5.0 / 96.0 * ROOT_PI,
        75.0 * ROOT_PI / (48.0 * eta * (41.0 - 33.0 * eta)),
    )
    few_by_drag = few_by_path = packed = 0
    for i in range(begin, end):
        s, t = eps_s[i], theta[i]
        if singular and s > MAX_RADIAL_FRACTION * eps_max:
            s = MAX_RADIAL_FRACTION * eps_max
            packed += 1
        g0, s_ahead = radial_distribution(s, eps_max, own[0]), s + SLOPE_STEP * eps_max
        p = pressure(s, g0, e, own[1])
        slope = (
            pressure(s_ahead, radial_distribution(s_ahead, eps_max, own[0]), e, own[1])
            - p
        ) / (SLOPE_STEP * eps_max)
        kinetic_mu = s * s / (s * s + MIN_KINETIC_FRACTION * MIN_KINETIC_FRACTION)
        kinetic_k = kinetic_mu
        if path < np.inf:
            share = drag_guard(K[i], t, s, g0, rho, d_p, dilute_mu, 2.0)
            few_by_drag += share < MIN_UNGUARDED_SHARE
            kinetic_mu *= share
            kinetic_k *= drag_guard(K[i], t, s, g0, rho, d_p, dilute_k, 1.2)
            share = free_path_guard(s, g0, d_p, path)
            few_by_path += share < MIN_UNGUARDED_SHARE
            kinetic_mu *= share
            kinetic_k *= share
        scale = rho * d_p * t**0.5
        out.g0[i] = g0
        out.pressure[i] = p * eps_s[i] / s if s > 0 else p
        out.stiffness[i] = t * slope
        out.mu[i] = scale * viscosity(s, g0, e, kinetic_mu, own[2])
        out.bulk[i] = scale * bulk(s, g0, e, own[3])
        out.conductivity[i] = scale * conductivity(s, g0, e, kinetic_k, own[4])
        out.dissipation[i] = (
            rho / d_p * dissipation(s, g0, constants.dissipative, own[5])
        )
        out.potential[i] = 0.0
        out.p_friction[i] = 0.0
        if eps_s[i] > first:
            j = min(int((eps_s[i] - first) / spacing), TABLE_SIZE - 2)
            w = (eps_s[i] - first) / spacing - j
            out.potential[i] = h_table[j] + w * (h_table[j + 1] - h_table[j])
            out.stiffness[i] += eps_s[i] * (h_table[j + 1] - h_table[j]) / spacing
            out.p_friction[i] = p_table[j] + w * (p_table[j + 1] - p_table[j])
    return few_by_drag, few_by_path, packed


def _friction(
    materials: Materials, particles: ParticleProperties, closure: BoundClosure | None
) -> FrictionTables:
    """Tabulate friction from its onset to the packing limit; zero without a closure."""
    s, p = (
        np.linspace(particles.friction_from, materials.eps_max, TABLE_SIZE),
        np.zeros(TABLE_SIZE),
    )
    if closure is not None:
        first, strength = particles.friction_from, particles.friction_strength
        p = closure(
            eps_s=s, eps_max=materials.eps_max, eps_min=first, strength=strength
        ) * np.ones(TABLE_SIZE)
    h = (
        np.concatenate(([0.0], np.cumsum(2.0 * np.diff(p) / (s[1:] + s[:-1]))))
        / materials.rho_solid
    )
    return FrictionTables(h, p)
