"""Ideal gas mixtures of frozen composition: Cantera's polynomials, evaluated by
numpy for all points at once.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from contbed.errors import SceneError
from contbed.scene.mechanism import mechanism_file

from .common import (
    Range,
    checked_positive,
    integrated,
    nearest,
    polynomial,
    share_outside,
)
from .composition import mole_fractions
from .forms import Ranges, forms_of, has_nasa7
from .pointwise import analytic

# K; the transport fits are re-expanded about it, where their terms no longer cancel
T_FIT = 1000.0


@dataclass(frozen=True, eq=False)
class GasMixture:
    """Mixture-averaged properties at fixed pressure and composition; made by
    `gas_mixture`.

    Heat capacity is one polynomial between every two mid temperatures of the species,
    so its cost hardly grows with the number of species. `enthalpy` is the exact
    integral of it: Cantera's own up to the lowest mid temperature and continuous above,
    where Cantera's jumps by the rounding of the published coefficients (some 10 J/kg).
    """

    constant: ClassVar[bool] = False
    name: str
    T_range: Range
    source: str
    pressure: float
    molar_mass: float
    mole_fractions: Mapping[str, float]
    _density_T: float = field(repr=False)
    _T_mid: tuple[float, ...] = field(repr=False)
    _heat_capacity: tuple[tuple[float, ...], ...] = field(repr=False)
    _enthalpy: tuple[tuple[float, ...], ...] = field(repr=False)
    _viscosity_fits: tuple[tuple[float, ...], ...] = field(repr=False)
    _wilke_weights: tuple[float, ...] = field(repr=False)
    _wilke_pairs: tuple[tuple[int, int, float, float], ...] = field(repr=False)
    _conductivity_fits: tuple[tuple[float, ...], ...] = field(repr=False)
    _conductivity_mean: tuple[float, ...] = field(repr=False)
    # of all species with their mole fractions, where one has no NASA polynomials of 7
    # coefficients
    _thermo: tuple[tuple[float, Ranges], ...] = field(default=(), repr=False)
    # constants in place of transport data
    _viscosity: float | None = field(default=None, repr=False)
    _conductivity: float | None = field(default=None, repr=False)

    def density(self, T: Any) -> Any:
        """Return the density [kg/m3], p W / (R T)."""
        return self._density_T / T

    def heat_capacity(self, T: Any) -> Any:
        """Return the heat capacity [J/kg/K] by the thermodynamics of the species."""
        if self._thermo:
            molar = sum(x * each.heat_capacity(T) for x, each in self._thermo)
            return molar / self.molar_mass
        return analytic(partial(_by_range, self._T_mid, self._heat_capacity), T)

    def enthalpy(self, T: Any) -> Any:
        """Return the enthalpy [J/kg], heats of formation included."""
        if self._thermo:
            molar = sum(x * each.enthalpy(T) for x, each in self._thermo)
            return molar / self.molar_mass
        return analytic(partial(_by_range, self._T_mid, self._enthalpy), T)

    def viscosity(self, T: Any) -> Any:
        """Return the viscosity [Pa s] by Wilke (1950), J. Chem. Phys. 18, 517,
        doi:10.1063/1.1747673.

        With v_k = (T M_k)^(1/4) / mu_k^(1/2) and w_k = x_k M_k^(1/2) the rule is
        symmetric in each pair of species, mu = sqrt(T) sum_k w_k / (sum_j w_j
        (v_k + v_j)^2 / sqrt(8 (M_k + M_j))), which halves its cost.
        """
        if self._viscosity is not None:
            return self._viscosity
        return analytic(self._wilke, T)

    def _wilke(self, T: Any) -> Any:
        L = np.log(T * (1.0 / T_FIT))
        v = [1.0 / polynomial(fit, L) for fit in self._viscosity_fits]
        x = self.mole_fractions.values()
        below = [x_k * (v_k * v_k) for x_k, v_k in zip(x, v, strict=True)]
        for k, j, w_kj, w_jk in self._wilke_pairs:
            both = v[k] + v[j]
            both = both * both
            below[k] = below[k] + w_kj * both
            below[j] = below[j] + w_jk * both
        total = sum(w / b for w, b in zip(self._wilke_weights, below, strict=True))
        return np.sqrt(T) * total

    def conductivity(self, T: Any) -> Any:
        """Return the conductivity [W/m/K], the mean of the arithmetic and the harmonic
        mole average.

        Mathur, Tondon and Saxena (1967), Mol. Phys. 12, 569,
        doi:10.1080/00268976700100731.
        """
        if self._conductivity is not None:
            return self._conductivity
        return analytic(self._mathur, T)

    def _mathur(self, T: Any) -> Any:
        L = np.log(T * (1.0 / T_FIT))
        mean = polynomial(self._conductivity_mean, L)
        if len(self._conductivity_fits) == 1:
            return np.sqrt(T) * mean
        x = self.mole_fractions.values()
        below = sum(
            x_k / polynomial(fit, L)
            for x_k, fit in zip(x, self._conductivity_fits, strict=True)
        )
        return np.sqrt(T) * (0.5 * (mean + 1.0 / below))

    def compressibility(self, T: float) -> float:
        """Return by how much the density rises with the pressure, over itself [1/Pa]."""
        return 1.0 / self.pressure

    def share_outside(self, T: Any) -> float:
        """Return the share of the points of T outside T_range."""
        return share_outside(T, self.T_range)


def gas_mixture(
    composition: str | Mapping[str, float],
    pressure: float,
    mechanism: str = "gri30.yaml",
    viscosity: float | None = None,
    conductivity: float | None = None,
) -> GasMixture:
    """Build an ideal gas mixture with the properties of Cantera's mixture-averaged
    transport.

    Parameters
    ----------
    composition : mole fractions, "N2:0.79, O2:0.21" or {"N2": 0.79, "O2": 0.21};
        normalised
    pressure : [Pa]
    mechanism : a Cantera input file with ideal-gas thermodynamics, and transport data
        unless viscosity and conductivity are given
    viscosity, conductivity : constants [Pa s, W/m/K] in place of transport data

    Source
    ------
    Cantera, https://cantera.org/stable/reference/transport/index.html, `mixture-averaged`
    """
    x = mole_fractions(composition)
    p = checked_positive(pressure, "gas: pressure", "Pa")
    gas, gas_constant = cantera_gas(
        mechanism, viscosity is None or conductivity is None
    )
    unknown = [s for s in x if s not in gas.species_names]
    if unknown:
        file = Path(mechanism).name
        raise SceneError(
            [
                f"gas: no species {s!r} in {file}{nearest(s, gas.species_names)}"
                for s in unknown
            ]
        )
    index = [gas.species_index(s) for s in x]
    data = [gas.species(i).thermo for i in index]
    M = [float(gas.molecular_weights[i]) for i in index]
    molar_mass = sum(x_k * M_k for x_k, M_k in zip(x.values(), M, strict=True))
    T_mid: tuple[float, ...] = ()
    heat_capacity: tuple[tuple[float, ...], ...] = ()
    enthalpy: tuple[tuple[float, ...], ...] = ()
    thermo: tuple[tuple[float, Ranges], ...] = ()
    if all(has_nasa7(each) for each in data):
        T_mid, heat_capacity, enthalpy = _nasa(
            [gas.species(i) for i in index], list(x.values()), gas_constant / molar_mass
        )
    else:
        thermo = tuple(
            (x_k, Ranges(name, {}, 1e-3 * M_k, forms, ends, pressure))
            for (name, x_k), M_k, each in zip(x.items(), M, data, strict=True)
            for ends, forms in [forms_of(name, each)]
        )
    w = [x_k * math.sqrt(M_k) for x_k, M_k in zip(x.values(), M, strict=True)]
    pairs = []
    for k in range(len(M)):
        for j in range(k + 1, len(M)):
            s = 1.0 / math.sqrt(8.0 * (M[k] + M[j]))
            pairs.append((k, j, w[j] * s, w[k] * s))
    mu_fits: list[tuple[float, ...]] = []
    k_fits: list[tuple[float, ...]] = []
    k_mean = np.empty(0)
    if viscosity is None:
        mu_fits = [
            recentred(gas.get_viscosity_polynomial(i), M_k**-0.25)
            for i, M_k in zip(index, M, strict=True)
        ]
    if conductivity is None:
        k_fits = [
            recentred(gas.get_thermal_conductivity_polynomial(i), 1.0) for i in index
        ]
        k_mean = np.array(list(x.values())) @ np.array(k_fits)
    return GasMixture(
        name=", ".join(f"{s}:{x_k:.6g}" for s, x_k in x.items()),
        # transport data are fitted from the lowest to the highest of all species
        T_range=(gas.min_temp, gas.max_temp),
        source=f"Cantera, {Path(mechanism).name}: thermodynamics and mixture-averaged "
        "transport",
        pressure=p,
        molar_mass=molar_mass / 1000.0,
        mole_fractions=x,
        _density_T=p * molar_mass / gas_constant,
        _T_mid=T_mid,
        _heat_capacity=heat_capacity,
        _enthalpy=enthalpy,
        _viscosity_fits=tuple(mu_fits),
        _wilke_weights=tuple(w),
        _wilke_pairs=tuple(pairs),
        _conductivity_fits=tuple(k_fits),
        _conductivity_mean=tuple(k_mean.tolist()),
        _thermo=thermo,
        _viscosity=viscosity,
        _conductivity=conductivity,
    )


def _by_range(
    T_mid: Sequence[float], polynomials: Sequence[Sequence[float]], T: Any
) -> Any:
    """Evaluate the polynomial of the range that T lies in.

    A mid temperature belongs to the range below it, as in Cantera.
    """
    result = polynomial(polynomials[0], T)
    for T_m, coefficients in zip(T_mid, polynomials[1:], strict=True):
        result = np.where(T_m < T, polynomial(coefficients, T), result)
    return result


def cantera_gas(mechanism: str, transport: bool = True) -> tuple[Any, float]:
    """Return the ideal gas phase of a mechanism, with mixture-averaged `transport` if
    wanted, and the gas constant [J/kmol/K].
    """
    try:
        import cantera
    except ImportError as error:
        raise SceneError(
            "gas: the package cantera is needed for gas mixtures and cannot be "
            f"imported ({error}); "
            "install it (pip install cantera) or give the gas constant properties"
        ) from error
    try:
        gas = cantera.Solution(mechanism)
    except cantera.CanteraError as error:
        known = {
            path.name
            for folder in cantera.get_data_directories()
            for path in Path(folder).glob("*.yaml")
        }
        path = mechanism_file(mechanism, Path()) or Path(mechanism)
        if path.is_file() and b"phases" not in path.read_bytes():
            raise SceneError(
                f"gas: {mechanism!r} is no mechanism: expected a YAML file of Cantera "
                f"with the keys phases and species{_phase_of_species(path)}"
            ) from error
        if mechanism not in known and not path.is_file() and "not found" in str(error):
            raise SceneError(
                f"gas: no mechanism file {mechanism!r}{nearest(mechanism, known)}; "
                "looked in "
                f"{', '.join(cantera.get_data_directories())}"
            ) from error
        raise SceneError(
            f"gas: Cantera cannot read {mechanism!r}: {_reason(error)}"
        ) from error
    if gas.thermo_model != "ideal-gas":
        raise SceneError(
            f"gas: {mechanism} holds a phase of the kind {gas.thermo_model}; an "
            "ideal-gas phase is needed, "
            "such as that of gri30.yaml; for real fluids use CoolProp"
        )
    if transport:
        require_transport(gas, mechanism)
    return gas, float(cantera.gas_constant)


def _phase_of_species(file: Path) -> str:
    """Return how a file with species alone is used; empty for another one."""
    if re.search(rb"^species\s*:", file.read_bytes(), re.MULTILINE) is None:
        return ""
    phase = (
        "phases: [{name: gas, thermo: ideal-gas, species: "
        f"[{{{file.name}/species: [CH4, O2, N2]}}]}}]"
    )
    return (
        ". It has species and no phase of them: write a file beside the scene, such as "
        f"gas.yaml, with the line `{phase}` and your species, and give it as the "
        "mechanism, with viscosity and conductivity if transport data are missing; or "
        "take gri30.yaml"
    )


def require_transport(gas: Any, mechanism: str) -> None:
    """Give a gas of Cantera mixture-averaged transport.

    Raises
    ------
    SceneError : the mechanism has no transport data
    """
    import cantera

    try:
        gas.transport_model = "mixture-averaged"
    except cantera.CanteraError as error:
        raise SceneError(
            f"gas: {mechanism} has no transport data ({_reason(error)}); use one that "
            "has, or give gas.viscosity and gas.conductivity"
        ) from error


def _reason(error: Exception) -> str:
    """Return Cantera's message on one line, without its frame of stars."""
    return " ".join(line for line in str(error).split("\n") if line.strip("* "))


def _nasa(
    species: Sequence[Any], x: Sequence[float], R: float
) -> tuple[
    tuple[float, ...], tuple[tuple[float, ...], ...], tuple[tuple[float, ...], ...]
]:
    """Return mid temperatures, and the mixture's polynomials of heat capacity and
    enthalpy between them.
    """
    data = [s.thermo.coeffs for s in species]
    T_mid = tuple(sorted({float(c[0]) for c in data}))
    heat_capacity = []
    for i in range(len(T_mid) + 1):
        high = [i > 0 and c[0] <= T_mid[i - 1] for c in data]
        terms = [
            x_k * (c[1:6] if h else c[8:13])
            for x_k, c, h in zip(x, data, high, strict=True)
        ]
        heat_capacity.append(tuple((R * sum(terms)).tolist()))
    enthalpy = [
        integrated(
            heat_capacity[0],
            R * sum(x_k * float(c[13]) for x_k, c in zip(x, data, strict=True)),
        )
    ]
    for T_m, cp in zip(T_mid, heat_capacity[1:], strict=True):
        step = polynomial(enthalpy[-1], T_m) - polynomial(integrated(cp), T_m)
        enthalpy.append(integrated(cp, float(step)))
    return T_mid, tuple(heat_capacity), tuple(enthalpy)


def recentred(fit: Sequence[float], factor: float) -> tuple[float, ...]:
    """Return factor times a polynomial in log(T) as one in log(T / T_FIT), by exact
    arithmetic.
    """
    a, shift = [Fraction(float(c)) for c in fit], Fraction(math.log(T_FIT))
    return tuple(
        factor
        * float(
            sum(
                (math.comb(n, m) * a[n] * shift ** (n - m) for n in range(m, len(a))),
                Fraction(0),
            )
        )
        for m in range(len(a))
    )
