"""Intraparticle gas of a bed: it diffuses in their pores, is adsorbed and reacts.

    dm/dt = r^-s d/dr( r^s D dc/dr ),   m = eps_p c + rho_p q(p, T_s)     per volume of particles [mol/m3]
    D dc/dr = k_f (c_bulk - c)          at the surface, r = R;  s = 2 of a sphere, 1 of a long cylinder

at the points of `particle.interior`, with its weights w and conduction matrix K, and
n = s + 1,

    w_i dm_i/dt = -(D/R^2) sum_j K_ij c_j + (n/R) k_f (c_bulk - c_i) [i is the surface]

One concentration per particle is the same with one point and the film in series with
R/((n + 2) D): the linear driving force of Glueckauf. With the external film only
nothing resists inside. Isotherms, p_k = c_k R T_s the partial pressure:

    linear      q = H p                       H, b = their values at T_0 times exp(-dH/R (1/T_s - 1/T_0))
    Langmuir    q_k = q_s b_k p_k/(1 + sum_j b_j p_j)

Reactions in the particles run at the concentrations of their points, and add sum_j
nu_kj r_j(c_i, T_s) to dm_i/dt; gases that are not adsorbed are there as around the
particles.

Before a front reaches them points are below zero by 3e-4, 2e-3 and 4e-3 of its height
for Bi = k_f R/D of 0.5, 3 and 10 with three points, by 5e-4 for 3 with six, up to D
t/R^2 = 0.02 of a straight isotherm. What the particle holds is not below zero and
misses 1e-5, 3e-4 and 2e-3. Points moved towards their mean until none is below zero
would miss more: 1.1 to 2.4 times as much with three, 10 times with six.

Gases of Langmuir isotherms compete for the same sites. Below 0, within an iteration or
behind a front that undershoots, an isotherm is a straight line.

Source: Glueckauf, Trans. Faraday Soc. 51 (1955) 1540, doi:10.1039/TF9555101540; Ruthven
    1984, Principles of Adsorption
and Adsorption Processes, ch. 8.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.chemistry.thermo import R_GAS

# iterations, which are few: the error is squared near the root and falls from above
MOST_NEWTON = 100
ROUNDED = 1e-15  # relative change below which it is rounding
# concentrations [mol/m3 of pores] at the points of a particle, by gas
Inner = Mapping[str, Sequence[Any]]


@dataclass(frozen=True)
class Isotherm:
    """Moles adsorbed per mass of particles at a partial pressure.

    affinity : H [mol/kg/Pa] where `capacity` is None, else b [1/Pa], at T_reference [K]
    capacity : q_s [mol/kg] of Langmuir's isotherm
    enthalpy : of adsorption [J/mol], negative where heat is released
    """

    affinity: float
    capacity: float | None
    enthalpy: float
    T_reference: float

    def affinity_at(self, T: Any) -> Any:
        """Return H or b at a temperature."""
        if self.enthalpy == 0.0:
            return self.affinity
        return self.affinity * np.exp(
            (1.0 / self.T_reference - 1.0 / T) * (self.enthalpy / R_GAS)
        )


def adsorbed(
    isotherms: Mapping[str, Isotherm], c: Mapping[str, Any], T: Any
) -> dict[str, Any]:
    """Return the moles of each gas that are adsorbed per mass of particles, at
    concentrations in the pores [mol/m3].
    """
    found, sites = {}, 1.0
    for name, isotherm in isotherms.items():
        found[name] = c[name] * (R_GAS * T) * isotherm.affinity_at(T)
        if isotherm.capacity is not None:
            sites = sites + np.maximum(found[name], 0.0)
    return {
        name: value
        if isotherms[name].capacity is None
        else value * isotherms[name].capacity / sites
        for name, value in found.items()
    }


@dataclass(frozen=True, eq=False)
class Inside:
    """The particles of a bed whose inside takes up gas.

    gases : that are adsorbed
    diffusivities : effective, in the pores [m2/s]
    weights, stiffness, surface : of the points of a particle, see the module; one point
        for one concentration
    resistance : share of R/D that adds to the film, 0 where the inside is resolved
    porosity, density : of the particles, [kg/m3]
    solids : volume of particles per volume of bed
    """

    gases: tuple[str, ...]
    isotherms: Mapping[str, Isotherm]
    diffusivities: Mapping[str, float]
    weights: Array
    stiffness: Array
    surface: int
    resistance: float
    radius: float
    porosity: float
    density: float
    solids: float

    @property
    def count(self) -> int:
        """Number of points in a particle."""
        return len(self.weights)

    def held(self, inner: Inner, T: Any) -> tuple[dict[str, list[Any]], Any]:
        """Return what each point holds of each gas [mol/m3 bed], and the heat of
        adsorption of all [J/m3 bed].

        The sum over the points is what the particles hold.
        """
        out: dict[str, list[Any]] = {name: [] for name in self.gases}
        heat: Any = 0.0
        for i, weight in enumerate(self.weights):
            c = {name: inner[name][i] for name in self.gases}
            share = float(weight) * self.solids
            for name, q in adsorbed(self.isotherms, c, T).items():
                out[name].append(share * (self.porosity * c[name] + self.density * q))
                if self.isotherms[name].enthalpy:
                    heat = (
                        heat
                        + (share * self.density * self.isotherms[name].enthalpy) * q
                    )
        return out, heat

    def concentrations(
        self, loadings: Mapping[str, Array], T: Array
    ) -> dict[str, Array]:
        """Return the concentrations in the pores at which particles hold so much, the
        same at all points [mol/m3].

        With S = 1 + sum_j b_j p_j each loading is straight in its concentration, and S
        the root of a concave function that Newton's method finds from above. NaN where
        no concentration is enough.

        Parameters
        ----------
        loadings : moles in the particles, adsorbed and in their pores, per mass of
            them [mol/kg] (points,)
        T : temperature of the particles [K] (points,)
        """
        pores = self.porosity / self.density
        slopes = {
            name: isotherm.affinity_at(T) * (R_GAS * T)
            for name, isotherm in self.isotherms.items()
        }
        sites = {
            name: isotherm.capacity
            for name, isotherm in self.isotherms.items()
            if isotherm.capacity is not None
        }
        S: Array = np.ones_like(T)
        if sites:
            filled: Any = sum(
                loadings[name] / capacity for name, capacity in sites.items()
            )
            emptier = {
                name: pores / (slopes[name] * capacity)
                for name, capacity in sites.items()
            }
            with np.errstate(divide="ignore", invalid="ignore"):
                S = np.where(filled < 1.0, 1.0 / (1.0 - filled), np.inf)
                if pores:
                    S = np.minimum(
                        S,
                        1.0
                        + sum(loadings[name] * slopes[name] / pores for name in sites),
                    )
                for _ in range(MOST_NEWTON):
                    parts = {
                        name: loadings[name] / capacity * S / (1.0 + emptier[name] * S)
                        for name, capacity in sites.items()
                    }
                    off: Any = 1.0 + sum(parts.values()) - S
                    fall: Any = (
                        sum(
                            part / (S * (1.0 + emptier[name] * S))
                            for name, part in parts.items()
                        )
                        - 1.0
                    )
                    step = off / fall
                    S = S - step
                    if not np.any(np.abs(step) > ROUNDED * S):
                        break
        bound = {
            name: slope * sites[name] / S if name in sites else slope
            for name, slope in slopes.items()
        }
        return {name: loadings[name] / (pores + bound[name]) for name in self.gases}

    def taken(
        self, inner: Inner, bulk: Mapping[str, Any], films: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Return what the surface of particles takes of each gas through the
        film [mol/m3 bed/s].

        Parameters
        ----------
        inner : concentrations at the points
        bulk : concentrations around the particles [mol/m3]
        films : coefficients of the films [m/s]
        """
        area, out = self.solids * self.surface / self.radius, {}
        for name in self.gases:
            through = films[name]
            if self.resistance:
                through = through / (
                    1.0
                    + through
                    * (self.resistance * self.radius / self.diffusivities[name])
                )
            out[name] = area * through * (bulk[name] - inner[name][-1])
        return out

    def conduction(self, gas: str) -> Array:
        """Return what points gain of a gas per concentration at the points (n,
        n) [m3/m3 bed/s].
        """
        return -self.solids * self.diffusivities[gas] / self.radius**2 * self.stiffness
