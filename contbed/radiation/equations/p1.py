"""Gray thermal radiation in a bed as one diffusion equation for the incident radiation.

    -div(D grad G) + K_a G = 4 sum_m K_a,m sigma T_m^4            q = -D grad G
    D dG/dn = eps/(2 (2 - eps)) (4 sigma T_w^4 - G)               on a wall, n outward
    D dG/dn = (4 J - G)/2                                         where the radiosity J enters, from a freeboard
    E_R,m = K_a,m (4 sigma T_m^4 - G)                             heat that species m gives to the radiation

G        incident radiation, the intensity integrated over all directions [W/m2]
q        radiative heat flux [W/m2]            E_R,m    radiated by species m [W/m3]
K_a,m    absorption coefficient of species m [1/m]      K_s      scattering coefficient [1/m]
D        1/(4 beta) for the two-flux method, 1/(3 (K_a + K_s (1 - g))) for P1 [m], beta = K_a + K_s
eps      emissivity of a wall [1]              g        mean cosine of scattering [1]

Both hemispherical fluxes follow: pi I(+-) = G/4 +- q/2. With D = 1/(4 beta) the
equation is the two-flux method of Rabi & de Souza-Santos (part I), written for one
unknown; with D = 1/(3 beta) it is P1, which also holds in two and three dimensions
(Modest, Radiative Heat Transfer, 2013, chapter 16).

Good values: particles of 0.3-10 mm, volume fractions 0.1-0.6, 600-2000 K; cells of 0.05
mean free paths on walls.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from contbed.closures.optics import SIGMA, marshak

FIELDS = ("G",)


@dataclass(frozen=True)
class Coefficients:
    """Optics of one domain.

    `absorption` holds K_a,m [1/m] of the species whose temperature is a field, by the
    name of that field. `emission` is 4 sum K_a,m sigma T_m^4 of species of given
    temperature [W/m3] and `passive` their K_a [1/m].
    """

    absorption: dict[str, Any]
    diffusion: Any
    emission: Any = 0.0
    passive: Any = 0.0


def emitted(T: Any) -> Any:
    """Return the black emissive power times four, 4 sigma T^4 [W/m2]."""
    return 4.0 * SIGMA * T**4


def absorbed(T: Any, G: Any, absorption: Any) -> Any:
    """Return the radiation that a species absorbs less what it emits, -E_R [W/m3]."""
    return absorption * (G - emitted(T))


def residual(unknowns: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of the balance of the incident radiation, without
    boundary terms.
    """
    G, w = unknowns.G, tests.G
    taken = c.passive * G - c.emission
    for name, absorption in c.absorption.items():
        taken = taken + absorbed(getattr(unknowns, name), G, absorption)
    return c.diffusion * o.dot(o.grad(G), o.grad(w)) + taken * w


@dataclass(frozen=True)
class Surface:
    """A radiating boundary.

    It is a gray wall of `emissivity` with emissive power `power` = sigma T^4 [W/m2], or
    an opening that `power` enters, with emissivity 1.
    """

    emissivity: float
    power: float


def supplied(unknowns: Any, c: Surface, o: Any) -> Any:
    """Return the radiation into the bed through a boundary [W/m2]."""
    return marshak(c.emissivity) * (4.0 * c.power - unknowns.G)


def boundary(unknowns: Any, tests: Any, c: Surface, o: Any) -> Any:
    """Return the weak form of walls and openings."""
    return -supplied(unknowns, c, o) * tests.G


@dataclass(frozen=True)
class Tubes:
    """Surfaces immersed in a region: effective area per bed volume, eps_eff p [1/m],
    and power, sigma T^4 [W/m2].

    A tube receives the bulk field through the bed around it, so it takes eps_eff
    (G/4 - sigma T^4) per surface, with 1/eps_eff = 1/eps_bed + 1/eps_tube - 1.
    """

    area: Any
    power: Any


def taken_by_tubes(unknowns: Any, c: Tubes, o: Any) -> Any:
    """Return the radiation that immersed tubes take out of the bed [W/m3]."""
    return c.area * (0.25 * unknowns.G - c.power)


def tubes(unknowns: Any, tests: Any, c: Tubes, o: Any) -> Any:
    """Return the weak form of the sink of incident radiation in tubes."""
    return taken_by_tubes(unknowns, c, o) * tests.G
