"""Optical coefficients of beds of large opaque gray spheres, from the data of each
solid species.

    kappa_m = 1.5 f_V,m / d32,m     K_a,m = eps_m kappa_m     K_s,m = (1 - eps_m) kappa_m     beta = sum kappa_m

f_V,m is the share of the emulsion's volume that species m fills, d32,m its Sauter mean
diameter, eps_m the emissivity of its surface. Equation numbers are those of Rabi and de
Souza-Santos, Incorporation of a two-flux model for radiative heat transfer in a
comprehensive fluidized bed simulator, part I, who take the coefficients from Brewster
1992, Thermal Radiative Transfer and Properties. Arrays hold the species along their
first axis; further axes are positions. Lists of dual numbers, one for each species,
give such lists.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.closures.registry import Value, closure
from contbed.errors import SceneError

SIGMA = 5.670374419e-8  # Stefan-Boltzmann constant [W/m2/K4], CODATA 2018
# mean cosine of scattering by a large sphere that reflects diffusely [-]
ANISOTROPY_DIFFUSE_SPHERES = -4 / 9
PACKINGS = ("close_packed", "independent")
LEVELS = ("p1", "two_flux")
_ROSSELAND = (
    "Rosseland 1931, Astrophysik auf atomtheoretischer Grundlage, Springer, Berlin"
)
_SCHUSTER = "Schuster 1905, Astrophys. J. 21, 1-22, doi:10.1086/141186"


@dataclass(frozen=True)
class Species:
    """One kind of particle: `volume_fraction` of the emulsion, Sauter mean
    diameter [m], emissivity.
    """

    name: str
    volume_fraction: float
    d_32: float
    emissivity: float

    def __post_init__(self) -> None:
        problems = []
        if not 0 <= self.volume_fraction < 1:
            problems.append(
                f"{self.name}: volume_fraction = {self.volume_fraction} must be within "
                "0 and 1, 1 excluded"
            )
        if not 0 < self.d_32 < np.inf:
            problems.append(
                f"{self.name}: d_32 = {self.d_32} must be above 0 and finite [m]"
            )
        if not 0 < self.emissivity <= 1:
            problems.append(
                f"{self.name}: emissivity = {self.emissivity} must be above 0 and at "
                "most 1"
            )
        if problems:
            raise SceneError(problems)


@dataclass(frozen=True)
class Optics:
    """Coefficients of a bed: K_a,m and K_s,m [1/m] with the species along the first
    axis, and the mean cosine g [-].
    """

    absorption: Any
    scattering: Any
    anisotropy: float = 0.0

    @property
    def absorption_total(self) -> Any:
        """K_a [1/m], eq. 26."""
        return sum(self.absorption)

    @property
    def scattering_total(self) -> Any:
        """K_s [1/m], eq. 26."""
        return sum(self.scattering)

    @property
    def extinction(self) -> Any:
        """Extinction beta = K_a + K_s [1/m]."""
        return self.absorption_total + self.scattering_total

    @property
    def albedo(self) -> Any:
        """Albedo omega = K_s / beta [-]."""
        return self.scattering_total / self.extinction

    @property
    def transport(self) -> Any:
        """K_a + K_s (1 - g) [1/m]."""
        return self.absorption_total + self.scattering_total * (1 - self.anisotropy)

    def diffusion(self, level: str = "p1") -> Any:
        """D [m] of -div(D grad G) + K_a G = 4 sum K_a,m sigma T_m^4.

        "p1": 1 / (3 (K_a + K_s (1 - g))). "two_flux": 1 / (4 beta), eqs. 29-31 for one
        unknown, g ignored.
        """
        _known("level", level, LEVELS)
        return 1 / (3 * self.transport) if level == "p1" else 1 / (4 * self.extinction)


def optical_coefficients(
    volume_fraction: Any,
    d_32: Any,
    emissivity: Any,
    packing: str = "close_packed",
    anisotropy: float = 0.0,
) -> Optics:
    """Absorption and scattering of all species.

        K_a,m = 1.5 f_V,m eps_m / (d32,m v)        K_s,m = 1.5 f_V,m (1 - eps_m) / (d32,m v)

    "independent" (v = 1) takes the particles for points, eqs. 16 and 25. "close_packed"
    divides by the voidage of the emulsion, v = 1 - sum f_V,m: the volume of the
    particles shortens the paths between them while albedo and phase function stay,
    Brewster 2004, Volume scattering of radiation in packed beds of large, opaque
    spheres, J. Heat Transfer 126(6). Both agree as f_V -> 0. Emission per volume, 4
    K_a,m sigma T^4, is that of the surface 6 f_V,m / d32,m if independent; close-packed
    it is 1/v times as much, and so is the exchange among species at one place: for that
    alone take the independent coefficients.

    Parameters
    ----------
    volume_fraction : [-] f_V,m, of the emulsion
    d_32 : [m] Sauter mean diameter of each species
    emissivity : [-] of each species; K_a = 0 at 0 and K_s = 0 at 1
    packing : "close_packed" or "independent"
    anisotropy : [-] mean cosine g of scattering

    Example
    -------
    >>> bed = optical_coefficients(np.array([0.3, 0.2]), np.array([1e-3, 5e-4]), np.array([0.9, 0.6]))
    >>> (bed.absorption + bed.scattering).round(6), round(float(bed.albedo), 6)
    (array([ 900., 1200.]), 0.271429)
    """
    _known("packing", packing, PACKINGS)
    if not -1 <= anisotropy <= 1:
        raise SceneError(f"anisotropy = {anisotropy} must be within -1 and 1")
    voidage = 1 - sum(volume_fraction) if packing == "close_packed" else 1.0
    kappa = [
        1.5 * f / (d * voidage) for f, d in zip(volume_fraction, d_32, strict=True)
    ]
    absorption = [eps * each for eps, each in zip(emissivity, kappa, strict=True)]
    scattering = [(1 - eps) * each for eps, each in zip(emissivity, kappa, strict=True)]
    return Optics(
        per_species(volume_fraction, absorption),
        per_species(volume_fraction, scattering),
        anisotropy,
    )


def optics(
    species: Sequence[Species], packing: str = "close_packed", anisotropy: float = 0.0
) -> Optics:
    """Return the coefficients of a bed of these species; arrays of shape
    (nspecies,).
    """
    if not species:
        raise SceneError("radiation needs at least one solid species")
    fractions = np.array([each.volume_fraction for each in species])
    if not 0 < fractions.sum() < 1:
        raise SceneError(
            f"volume fractions of all species sum to {fractions.sum():.6g}, must be "
            "above 0 and below 1"
        )
    sizes, emissivities = np.array([(each.d_32, each.emissivity) for each in species]).T
    return optical_coefficients(fractions, sizes, emissivities, packing, anisotropy)


@closure(
    kind="radiation",
    unit="W/m/K",
    ranges={"T": (0, float("inf")), "beta": (0, float("inf"))},
    source=_ROSSELAND,
    bounds={"beta": "(0, inf)"},
)
def radiation_rosseland(T: Value, beta: Value) -> Value:
    """Rosseland (1931): radiation in a thick medium as heat conduction.

        k = 16 sigma T^3 / (3 beta)

    T : [K] temperature, the same for all species
    beta : [1/m] transport coefficient K_a + K_s (1 - g), the extinction coefficient
        when scattering is isotropic

    Result: radiative conductivity
    Fitted to: nothing: exact as the mean free path shrinks. For a layer between walls
        see error_rosseland
    Limits: beta -> 0: diverges, since radiation then depends on the walls.
    Source: As given in Modest 2013, Radiative Heat Transfer, section 15.2.

    >>> round(float(radiation_rosseland(T=1200.0, beta=1000.0)), 6)
    0.522582
    """
    return 16 * SIGMA * T**3 / (3 * beta)


@closure(kind="radiation", unit="-", ranges={"albedo": (0, 1)}, source=_SCHUSTER)
def radiation_emissivity_half_space(albedo: Value) -> Value:
    """Schuster (1905): emissivity of a deep isothermal bed by the two-flux method.

        eps_bed = 2 s / (1 + s),  s = sqrt(1 - albedo)

    Result: hemispherical emissivity of the surface of the bed
    Fitted to: nothing: exact for isotropic scattering and two streams; transport theory
        gives .8832 where this gives .8622
    Limits: albedo -> 0: 1. albedo -> 1: 0, with infinite slope.

    >>> round(float(radiation_emissivity_half_space(albedo=0.36)), 6)
    0.888889
    """
    s = (1 - albedo) ** 0.5
    return 2 * s / (1 + s)


def emissivity_immersed(emissivity_bed: Any, emissivity: Any) -> Any:
    """Effective emissivity [-] between a bed and a surface immersed in it,
    1 / (1/eps_bed + 1/eps - 1).

    The surface receives eps_eff (G/4 - sigma T^4) [W/m2] from the field G of the bulk.
    G falls within a mean free path of a cold surface, which a Marshak condition with
    the bulk G misses.
    """
    return 1 / (1 / emissivity_bed + 1 / emissivity - 1)


def marshak(emissivity: Any) -> Any:
    """Factor h [-] of D dG/dn = h (4 sigma T^4 - G) on a wall, n outward: eps / (2
    (2 - eps)).

    G is that at the wall, resolved by the mesh. Equivalent to I+(0) = eps sigma
    T^4 / pi + (1 - eps) I-(0).
    """
    return emissivity / (2 * (2 - emissivity))


def conductivity(T: Any, diffusion: Any) -> Any:
    """Radiative conductivity [W/m/K] of a thick bed, 16 sigma T^3 D.

    With D of P1 that is radiation_rosseland, with the D of the two-flux method 4 sigma
    T^3 / beta, a quarter less.
    """
    return 16 * SIGMA * T**3 * diffusion


def error_rosseland(tau: Any, emissivity_1: Any = 1.0, emissivity_2: Any = 1.0) -> Any:
    """Relative error [-] of the heat flux when P1 with its walls gives way to the
    Rosseland conductivity without slip.

        (1/eps_1 + 1/eps_2 - 1) / (3/4 tau)

    Exact for a layer in radiative equilibrium between two gray walls, whose flux by P1
    is sigma (T_1^4 - T_2^4) / (3/4 tau + 1/eps_1 + 1/eps_2 - 1). `tau` is the transport
    coefficient times the thickness [-].
    """
    return (1 / emissivity_1 + 1 / emissivity_2 - 1) / (0.75 * tau)


def per_species(given: Any, parts: list[Any]) -> Any:
    """One entry for each species: an array where an array was given, else the list."""
    return np.array(parts) if isinstance(given, np.ndarray) else parts


def _known(what: str, name: str, choices: Sequence[str]) -> None:
    if name not in choices:
        raise SceneError(f"{what} = {name!r} must be one of: {', '.join(choices)}")
