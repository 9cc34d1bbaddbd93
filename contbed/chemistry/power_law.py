"""Power laws with published constants and an Arrhenius factor.

    r = A T^b exp(-E/T) prod_i [i]^(n_i)      [mol/m3/s], concentrations [i] in mol/m3

Orders below one have infinite slopes at zero, where nothing is left to react. They are
continued as straight lines,

    [i]^n  ->  [i] ([i]^2 + s^2)^((n - 1)/2),   s = 1e-5 of all molecules,

which changes r where less than about s is left and lets a slightly negative [i] pull
back; two of them do not.

Gases burn no faster than they mix: with a time tau of mixing, r/(1 + tau sum_i r/[i])
is at most [i]/tau of the scarcest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.equation import stoichiometry

SMALL = 1e-5  # share of all molecules below which fractional orders are straight lines


@dataclass(frozen=True)
class PowerLaw:
    """A rate law with published constants. `A` is in mol, m3 and s; for reactions
    of solids see the module that lists them.
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
