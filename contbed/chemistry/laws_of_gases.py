"""Rates of homogeneous reactions in the gas of fluidized beds: power laws with an
Arrhenius factor, as data.

    r = A T^b exp(-E/T) prod_i [i]^(n_i)      [mol/m3/s], concentrations [i] in mol/m3

Orders below one have infinite slopes at zero, where nothing is left to react. They are
continued as straight lines,

    [i]^n  ->  [i] ([i]^2 + s^2)^((n - 1)/2),   s = 1e-5 of all molecules,

which changes r where less than about s is left and lets a slightly negative [i] pull
back; two of them do not.

Gases burn no faster than they mix: with a time tau of mixing, r/(1 + tau sum_i r/[i])
is at most [i]/tau of the scarcest. Reversible reactions run backward at the rate that
thermodynamic equilibrium demands: r (1 - Q/K).

Constants are those quoted for the sources in secondary literature; `share_outside`
reports where a run left `T_range`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.equation import stoichiometry
from contbed.chemistry.thermo import R_GAS

SMALL = 1e-5  # share of all molecules below which fractional orders are straight lines


@dataclass(frozen=True)
class Law:
    """A rate law. `A` is in mol, m3 and s; for reactions of solids see the module
    that lists them.
    """

    name: str
    reaction: str  # "CO + 0.5 O2 -> CO2"; "<->" where it is reversible
    A: float
    b: float
    E: float  # activation temperature [K]
    orders: Mapping[str, float]
    T_range: tuple[float, float]
    source: str
    unit: str = "mol/m3/s"

    @property
    def reversible(self) -> bool:
        """Whether it also runs backward."""
        return "<->" in self.reaction

    @property
    def stoichiometry(self) -> dict[str, float]:
        """Moles made per mole of reaction, negative for what is consumed."""
        return stoichiometry(self.reaction)

    def constant(self, T: Any) -> Any:
        """Return the rate constant A T^b exp(-E/T)."""
        k = self.A * np.exp(-self.E / T)
        return k * T**self.b if self.b else k

    def rate(self, T: Any, concentration: Mapping[str, Any], small: Any) -> Any:
        """Forward rate [mol/m3/s] at concentrations [mol/m3]; `small` is s of the
        module's docstring [mol/m3].
        """
        return self.constant(T) * product(
            [power(concentration[name], n, small) for name, n in self.orders.items()]
        )

    def frequency(self, T: Any, concentration: Mapping[str, Any], small: Any) -> Any:
        """Sum over the reactants of forward rate over amount [1/s]; the scarcest
        decides.
        """
        total: Any = 0.0
        for name in self.orders:
            others: Any = 1.0
            for other, n in self.orders.items():
                c = concentration[other]
                if other == name:
                    others = others * (
                        1.0
                        if n == 1.0
                        else (c * c + small * small) ** (0.5 * (n - 1.0))
                    )
                else:
                    others = others * np.maximum(power(c, n, small), 0.0)
            total = total + others
        return self.constant(T) * total


def product(factors: Sequence[Any]) -> Any:
    """Their product where at most one is negative, else 0: what two reactants lack
    is not taken from both.
    """
    up = [np.maximum(factor, 0.0) for factor in factors]
    total: Any = 1.0
    for factor in up:
        total = total * factor
    for k, factor in enumerate(factors):
        lacking = np.minimum(factor, 0.0)
        for j, other in enumerate(up):
            if j != k:
                lacking = lacking * other
        total = total + lacking
    return total


def power(c: Any, order: float, small: Any) -> Any:
    """c^order for c >> small, a straight line through 0 below, odd in c."""
    if order == 1.0:
        return c
    return c * (c * c + small * small) ** (0.5 * (order - 1.0))


_CGS = 1e6  # mol/cm3/s in mol/m3/s


def _from_cm(A: float, order: float) -> float:
    """Convert A for mol/cm3 to A for mol/m3."""
    return A * _CGS * float((1e-6) ** order)


def _from_kmol(A: float, order: float) -> float:
    """Convert A for kmol/m3 to A for mol/m3."""
    return A * float(1e3 ** (1.0 - order))


_CAL = 4.184 / R_GAS  # cal/mol in K

LAWS: dict[str, dict[str, Law]] = {
    "CO_oxidation": {
        "howard": Law(
            "howard", "CO + 0.5 O2 -> CO2", _from_cm(1.3e14, 2.0), 0.0, 30000 * _CAL,
            {"CO": 1.0, "O2": 0.5, "H2O": 0.5}, (840.0, 2360.0),
            "Howard, Williams, Fine 1973, 14th Symp. (Int.) Combust., 975-986, "
            "doi:10.1016/S0082-0784(73)80089-X",
        ),
        "dryer_glassman": Law(
            "dryer_glassman", "CO + 0.5 O2 -> CO2", _from_cm(3.98e14, 1.75), 0.0, 40000 * _CAL,
            {"CO": 1.0, "O2": 0.25, "H2O": 0.5}, (1030.0, 1230.0),
            "Dryer, Glassman 1973, 14th Symp. (Int.) Combust., 987-1003, "
            "doi:10.1016/S0082-0784(73)80090-6",
        ),
    },
    "H2_oxidation": {
        "jones_lindstedt": Law(
            "jones_lindstedt", "H2 + 0.5 O2 -> H2O", _from_kmol(6.8e15, 1.75), -1.0, 20130.0,
            {"H2": 0.25, "O2": 1.5}, (900.0, 2500.0),
            "Jones, Lindstedt 1988, Combust. Flame 73, 233-249, "
            "doi:10.1016/0010-2180(88)90021-1",
        ),
    },
    "CH4_oxidation": {
        "dryer_glassman": Law(
            "dryer_glassman", "CH4 + 1.5 O2 -> CO + 2 H2O", _from_cm(10**13.2, 1.5), 0.0, 48400 * _CAL,
            {"CH4": 0.7, "O2": 0.8}, (1100.0, 1400.0),
            "Dryer, Glassman 1973, 14th Symp. (Int.) Combust., 987-1003, "
            "doi:10.1016/S0082-0784(73)80090-6",
        ),
    },
    "tar_oxidation": {
        "edelman_fortune": Law(
            "edelman_fortune", "C6H6 + 3 O2 -> 6 CO + 3 H2", _from_cm(5.52e8, 1.5), 1.0, 12200.0,
            {"C6H6": 0.5, "O2": 1.0}, (800.0, 2500.0),
            "Edelman, Fortune 1969, AIAA Paper 69-86, doi:10.2514/6.1969-86",
        ),
    },
    "H2S_oxidation": {
        "assumed_fast": Law(
            "assumed_fast", "H2S + 1.5 O2 -> SO2 + H2O", 1e4, 0.0, 5000.0, {"H2S": 1.0, "O2": 1.0}, (700.0, 1600.0),
            "no measurement: fast beside the exchange of gas above 900 K, slow below "
            "600 K",
        ),
    },
    "water_gas_shift": {
        "biba": Law(
            "biba", "CO + H2O <-> CO2 + H2", 2.78, 0.0, 12560.0 / R_GAS, {"CO": 1.0, "H2O": 1.0}, (800.0, 1400.0),
            "Biba, Macak, Klose, Malecha 1978, Ind. Eng. Chem. Process Des. Dev. 17, "
            "92-98, doi:10.1021/i260065a017",
        ),
    },
    "reforming": {
        "jones_lindstedt": Law(
            "jones_lindstedt", "CH4 + H2O <-> CO + 3 H2", _from_kmol(3e8, 2.0), 0.0, 15100.0,
            {"CH4": 1.0, "H2O": 1.0}, (900.0, 2500.0),
            "Jones, Lindstedt 1988, Combust. Flame 73, 233-249, "
            "doi:10.1016/0010-2180(88)90021-1",
        ),
    },
}  # fmt: skip
"""Rate laws by reaction and name; the first of each reaction is its default."""
