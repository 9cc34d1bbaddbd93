"""Homogeneous reactions of gases: power laws with published constants, by reaction.

`[reactions.CO_oxidation]` takes the first law of this reaction, `law = "howard"` another.
Reversible reactions run backward at the rate that thermodynamic equilibrium demands:
r (1 - Q/K). Constants are those quoted for the sources in secondary literature.
"""

from __future__ import annotations

from typing import Any

from contbed.chemistry.local import Local, Rate
from contbed.chemistry.power_law import SMALL, PowerLaw, product
from contbed.chemistry.rate_law import Case, RateLaw
from contbed.chemistry.thermo import R_GAS

_CGS = 1e6  # mol/cm3/s in mol/m3/s


def _from_cm(A: float, order: float) -> float:
    """Convert A for mol/cm3 to A for mol/m3."""
    return A * _CGS * float((1e-6) ** order)


def _from_kmol(A: float, order: float) -> float:
    """Convert A for kmol/m3 to A for mol/m3."""
    return A * float(1e3 ** (1.0 - order))


_CAL = 4.184 / R_GAS  # cal/mol in K

BY_REACTION: dict[str, dict[str, PowerLaw]] = {
    "CO_oxidation": {
        "howard": PowerLaw(
            "howard", "CO + 0.5 O2 -> CO2", _from_cm(1.3e14, 2.0), 0.0, 30000 * _CAL,
            {"CO": 1.0, "O2": 0.5, "H2O": 0.5}, (840.0, 2360.0),
            "Howard, Williams, Fine 1973, 14th Symp. (Int.) Combust., 975-986, "
            "doi:10.1016/S0082-0784(73)80089-X",
        ),
        "dryer_glassman": PowerLaw(
            "dryer_glassman", "CO + 0.5 O2 -> CO2", _from_cm(3.98e14, 1.75), 0.0, 40000 * _CAL,
            {"CO": 1.0, "O2": 0.25, "H2O": 0.5}, (1030.0, 1230.0),
            "Dryer, Glassman 1973, 14th Symp. (Int.) Combust., 987-1003, "
            "doi:10.1016/S0082-0784(73)80090-6",
        ),
    },
    "H2_oxidation": {
        "jones_lindstedt": PowerLaw(
            "jones_lindstedt", "H2 + 0.5 O2 -> H2O", _from_kmol(6.8e15, 1.75), -1.0, 20130.0,
            {"H2": 0.25, "O2": 1.5}, (900.0, 2500.0),
            "Jones, Lindstedt 1988, Combust. Flame 73, 233-249, "
            "doi:10.1016/0010-2180(88)90021-1",
        ),
    },
    "CH4_oxidation": {
        "dryer_glassman": PowerLaw(
            "dryer_glassman", "CH4 + 1.5 O2 -> CO + 2 H2O", _from_cm(10**13.2, 1.5), 0.0, 48400 * _CAL,
            {"CH4": 0.7, "O2": 0.8}, (1100.0, 1400.0),
            "Dryer, Glassman 1973, 14th Symp. (Int.) Combust., 987-1003, "
            "doi:10.1016/S0082-0784(73)80090-6",
        ),
    },
    "tar_oxidation": {
        "edelman_fortune": PowerLaw(
            "edelman_fortune", "C6H6 + 3 O2 -> 6 CO + 3 H2", _from_cm(5.52e8, 1.5), 1.0, 12200.0,
            {"C6H6": 0.5, "O2": 1.0}, (800.0, 2500.0),
            "Edelman, Fortune 1969, AIAA Paper 69-86, doi:10.2514/6.1969-86",
        ),
    },
    "H2S_oxidation": {
        "assumed_fast": PowerLaw(
            "assumed_fast", "H2S + 1.5 O2 -> SO2 + H2O", 1e4, 0.0, 5000.0, {"H2S": 1.0, "O2": 1.0}, (700.0, 1600.0),
            "no measurement: fast beside the exchange of gas above 900 K, slow below "
            "600 K",
        ),
    },
    "water_gas_shift": {
        "biba": PowerLaw(
            "biba", "CO + H2O <-> CO2 + H2", 2.78, 0.0, 12560.0 / R_GAS, {"CO": 1.0, "H2O": 1.0}, (800.0, 1400.0),
            "Biba, Macak, Klose, Malecha 1978, Ind. Eng. Chem. Process Des. Dev. 17, "
            "92-98, doi:10.1021/i260065a017",
        ),
    },
    "reforming": {
        "jones_lindstedt": PowerLaw(
            "jones_lindstedt", "CH4 + H2O <-> CO + 3 H2", _from_kmol(3e8, 2.0), 0.0, 15100.0,
            {"CH4": 1.0, "H2O": 1.0}, (900.0, 2500.0),
            "Jones, Lindstedt 1988, Combust. Flame 73, 233-249, "
            "doi:10.1016/0010-2180(88)90021-1",
        ),
    },
}  # fmt: skip
"""Rate laws by reaction and name; the first of each reaction is its default."""


def _small(at: Local) -> Any:
    """Return the concentration below which orders are straight lines [mol/m3]."""
    return SMALL * at.p / (R_GAS * at.T)


def _rate(law: PowerLaw, case: Case) -> Rate:
    """Return the net rate of a law [mol/m3 of gas/s]."""

    def rate(at: Local) -> Any:
        forward = law.rate(at.T, at.c, _small(at))
        if not law.reversible:
            return forward
        made = [
            at.c[name] ** n if n != 1.0 else at.c[name]
            for name, n in case.equation.stoichiometry.items()
            if n > 0
        ]
        back = product(made)
        return forward - law.constant(at.T) * back / case.equilibrium_constant(at.T)

    return rate


def _rate_law(law: PowerLaw) -> RateLaw:
    """Return a law with published constants as one that scenes name."""
    return RateLaw(
        rate=lambda case: _rate(law, case),
        equations=(law.reaction,),
        takes=("equilibrium_factor",),
        gases=tuple(law.orders),
        frequency=lambda at: law.frequency(at.T, at.c, _small(at)),
        published=law,
    )


LAWS: dict[str, RateLaw] = {
    f"{reaction}.{name}": _rate_law(law)
    for reaction, laws in BY_REACTION.items()
    for name, law in laws.items()
}
