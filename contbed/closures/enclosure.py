"""Radiation among the species at one place of a bed, without transport from place to
place: two algebraic closures.

    equilibrium   E_R,m = K_a,m (4 sigma T_m^4 - G),  G = (4 sigma / K_a) sum_n K_a,n T_n^4          eqs. 32 and 34
    pairwise      E_R,m = sum_n 4 kappa_m f''_n eps_mn sigma (T_m^4 - T_n^4),  eps_mn by eq. 3         eqs. 2-11

E_R,m is the heat that species m loses [W/m3 of emulsion] and sums to zero over the
species; times the section of the emulsion it is the term of the paper [W/m].
f''_m = kappa_m / sum kappa is the share of m in the surface of all particles, and 4
kappa_m its surface per volume (coefficients of packing "independent"). All particles
are bathed in one mixture, so the view factor from any species to n is f''_n. Then
equilibrium is the enclosure of N gray surfaces, for any number of species; pairwise
equals it for two and differs for more, since eq. 3 rewritten,

    1/eps_mn = (f''_m eps_m + f''_n eps_n + (1 - f''_m - f''_n) eps_m eps_n) / (eps_m eps_n)

counts every third species with the emissivity eps_m eps_n instead of its own.

Temperatures and coefficients hold the species along their first axis; further axes are
positions. A list of dual numbers, one for each species, gives a list of dual numbers.
At least one emissivity must be above zero.

Source: Rabi, de Souza-Santos, Incorporation of a two-flux model for radiative heat
    transfer in a comprehensive
fluidized bed simulator, part I. Areas and volumes in eqs. 5-7 are those of one
particle, and the sums in the denominators of eq. 7 run over the species: printed
otherwise there.
"""

from __future__ import annotations

from typing import Any

from contbed.closures.optics import SIGMA, per_species


def irradiation_equilibrium(absorption: Any, T: Any) -> Any:
    """Incident radiation G [W/m2] at which all species together absorb what they emit,
    eq. 34.

    Parameters
    ----------
    absorption : [1/m] K_a,m
    T : [K] temperature of each species
    """
    return sum(
        K * (4 * SIGMA * t**4) for K, t in zip(absorption, T, strict=True)
    ) / sum(absorption)


def exchange_equilibrium(absorption: Any, T: Any) -> Any:
    """Heat lost by each species [W/m3], eqs. 32 and 34; the cost grows with the number
    of species, not its square.

    Example
    -------
    >>> import numpy as np
    >>> exchange_equilibrium(np.array([100.0, 300.0]), np.array([1500.0, 1100.0])).round(-2)
    array([ 61212800., -61212800.])
    """
    G = irradiation_equilibrium(absorption, T)
    return per_species(
        T, [K * (4 * SIGMA * t**4 - G) for K, t in zip(absorption, T, strict=True)]
    )


def exchange_pairwise(extinction: Any, emissivity: Any, T: Any) -> Any:
    """Heat lost by each species [W/m3] by the older network of pairs, eqs. 2-11. Exact
    for two species only.

    Parameters
    ----------
    extinction : [1/m] kappa_m
    emissivity : [-] eps_m
    T : [K] temperature of each species
    """
    total = sum(extinction)
    share = [kappa / total for kappa in extinction]
    power = [SIGMA * t**4 for t in T]
    lost = [0.0 * each for each in power]
    for m in range(len(power)):
        for n in range(m):
            # each pair once: what one species loses the other gains (eqs. 8 and 9)
            f_m, f_n, both = share[m], share[n], emissivity[m] * emissivity[n]
            eps_mn = both / (
                f_m * emissivity[m] + f_n * emissivity[n] + (1 - f_m - f_n) * both
            )
            passed = 4 * extinction[m] * f_n * eps_mn * (power[m] - power[n])
            lost[m], lost[n] = lost[m] + passed, lost[n] - passed
    return per_species(T, lost)
