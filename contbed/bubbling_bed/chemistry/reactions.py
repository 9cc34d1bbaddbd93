"""The reactions of a bed as functions of its local state; see `equations.species`
for their arguments.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.bubbling_bed.chemistry import scene as t
from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.equations.species import SourceTerms, State
from contbed.chemistry import char_and_lime as rs
from contbed.chemistry.char_and_lime import BAR
from contbed.chemistry.elements import ATOMIC_WEIGHTS
from contbed.chemistry.kinetics import Reaction, rates_of
from contbed.chemistry.local import Local
from contbed.chemistry.power_law import SMALL, PowerLaw, power, product
from contbed.chemistry.thermo import R_GAS

CARBON = ATOMIC_WEIGHTS["C"]
# [Pa] over which the release of SO2 falls to 0 at equilibrium; beds hold 10 Pa of CO
# and more
SMALL_CO = 0.1
# [bar2] of pressures of products over K, (1e-6 atm)^2, below which a root of it is a
# straight line
TRACE = 1.01325e-6**2
OF_LIME = {
    "calcination": rs.CALCINATION,
    "sulphation": rs.SULPHATION,
    "sulphate_reduction": rs.SULPHATE_REDUCTION,
}


def law_of(name: str, table: t.CharReaction) -> PowerLaw:
    """Return the rate law of a reaction of char."""
    laws = rs.CHAR_LAWS[name]
    return laws[table.law] if table.law is not None else next(iter(laws.values()))


def equilibrium_quotient(law: PowerLaw, T: Any, p: dict[str, Any]) -> Any:
    """Return the product of the pressures of the products [bar] over K, in bar to
    the order of the reactants.
    """
    made = [
        p[name]
        for name, count in law.stoichiometry.items()
        if name in p
        for _ in range(round(max(count, 0.0)))
    ]
    return np.exp(-thermo.equilibrium(law.stoichiometry).ln_K(T)) * product(made)


@dataclass(frozen=True)
class Place:
    """The particles in which reactions of gases run.

    species : the solid phase
    share : of the volume of all particles
    """

    species: str
    share: float
    diameter: float
    density: float


@dataclass(frozen=True)
class OfGases:
    """A reaction of gases, in the gas of each phase, or in particles of the emulsion.

    mixing : time in which gases mix, which limits the rate [s]
    voidage : of the emulsion
    """

    reaction: Reaction
    mixing: float
    voidage: float
    place: Place | None = None

    @property
    def name(self) -> str:
        """Key of the scene."""
        return self.reaction.name

    @property
    def names(self) -> tuple[str, ...]:
        """Keys of the scene."""
        return (self.name,)

    @property
    def in_gas(self) -> bool:
        """Whether it runs in the gas, and not in particles."""
        return self.place is None

    @property
    def needs(self) -> set[str]:
        """Gases without which it does not run."""
        moles = self.reaction.stoichiometry
        return {name for name in self.reaction.gases if moles.get(name, 0.0) <= 0.0}

    @property
    def makes(self) -> set[str]:
        """Gases that it makes or takes."""
        return set(self.reaction.stoichiometry)

    def __call__(self, state: State, terms: SourceTerms) -> None:
        """Add the reaction in the gas of each phase, or in the particles."""
        moles = self.reaction.stoichiometry
        if self.place is not None:
            T = state.T[self.place.species]
            rate = self._per_height(state, "emulsion", T)
            made = {name: count * rate for name, count in moles.items()}
            terms.particle(self.place.species, made, {}, state)
            return
        for phase in state.x:
            rate = self._per_height(state, phase, state.T[phase])
            terms.homogeneous(phase, moles, rate)

    def _per_height(self, state: State, phase: str, T: Any) -> Any:
        """Return the rate at temperature T in a phase [mol/s/m]."""
        molar = state.pressure / (R_GAS * state.T[phase])
        x = state.x[phase]
        c = {name: share * molar for name, share in x.items()}
        rate = self.rate(T, c, state.pressure, x)
        return state.volume[phase] * rate

    def rate(self, T: Any, c: Mapping[str, Any], p: float, x: Mapping[str, Any]) -> Any:
        """Return the net rate per volume of gas [mol/m3/s] at concentrations c."""
        place = self.place
        solids = radius = catalyst = 0.0
        if place is not None:
            solids = place.share * (1.0 - self.voidage) / self.voidage
            radius, catalyst = 0.5 * place.diameter, solids * place.density
        at = Local(T, p, c, x, {}, 1.0, solids, radius, catalyst, {})
        (rate,) = rates_of([self.reaction], lambda reaction: at)
        if not self.mixing or place is not None:
            return rate
        return rate / (1.0 + self.mixing * self._frequency(at, rate))

    def _frequency(self, at: Local, rate: Any) -> Any:
        """Return the rate over the amount of the scarcest gas that it takes [1/s]."""
        if self.reaction.frequency is not None:
            return self.reaction.frequency(at)
        small = SMALL * at.all_gases
        total: Any = 0.0
        for name, count in self.reaction.stoichiometry.items():
            c = at.c[name]
            if count < 0.0:
                total = total + np.abs(rate) * (-count) / (c * c + small * small) ** 0.5
        return total


@dataclass(frozen=True)
class Release:
    """Release of first order of a constituent as gas; `yields` [mol] per unit of it."""

    in_gas = False
    name: str
    species: str
    constituent: str
    time: float
    yields: Mapping[str, float]

    @property
    def names(self) -> tuple[str, ...]:
        """Keys of the scene."""
        return (self.name,)

    @property
    def makes(self) -> set[str]:
        """Gases that it makes."""
        return set(self.yields)

    def __call__(self, state: State, terms: SourceTerms) -> None:
        """Add the gas that is released."""
        rate = state.solid[self.constituent] / self.time
        made = {name: amount * rate for name, amount in self.yields.items()}
        terms.particle(self.species, made, {self.constituent: -rate}, state)


@dataclass(frozen=True)
class Char:
    """Char in mixed flow; film diffusion and kinetics act in series for each
    reaction.
    """

    in_gas = False
    species: str
    diameter: float
    density: float
    model: str
    sherwood: float
    reactions: dict[str, tuple[PowerLaw, t.CharReaction]]

    @property
    def names(self) -> tuple[str, ...]:
        """Keys of the scene."""
        return tuple(self.reactions)

    @property
    def makes(self) -> set[str]:
        """Gases that it makes or takes."""
        made = {
            name for law, _ in self.reactions.values() for name in law.stoichiometry
        }
        if "char_combustion" in self.reactions:
            made.add("CO")
        return made - {"C"}

    @property
    def surface(self) -> float:
        """Surface per mole of carbon [m2/mol]."""
        return (
            rs.POPULATIONS[self.model].surface / self.diameter * CARBON / self.density
        )

    def film(self, gas: str, T: Any, p: float) -> Any:
        """Return the mass transfer coefficient of the gas film [m/s]."""
        M = thermo.table()[gas].molar_mass
        diameter = rs.POPULATIONS[self.model].film * self.diameter
        return self.sherwood * rs.diffusion_in_nitrogen(gas, M, T, p) / diameter

    def carbon_per_oxygen(self, T: Any) -> Any:
        """Return the moles of carbon that one mole of O2 burns."""
        products = self.reactions["char_combustion"][1].products  # type: ignore[attr-defined]
        if products == "arthur":
            return rs.carbon_per_oxygen(T)
        return 1.0 if products == "CO2" else 2.0

    def combustion_rate(self, T: Any, T_gas: Any, concentration: Any, p: float) -> Any:
        """Return the rate of combustion per amount of carbon [1/s] at a
        concentration of O2 [mol/m3].
        """
        law, table = self.reactions["char_combustion"]
        k = table.factor * law.constant(T)
        mean = 0.5 * (T + T_gas)
        speed = rs.char_combustion(
            k, self.film("O2", mean, p), self.carbon_per_oxygen(T)
        )
        return self.surface * speed * concentration

    def gasification_rate(
        self, name: str, T: Any, T_gas: Any, x: dict[str, Any], p: float
    ) -> Any:
        """Return the rate of gasification per amount of carbon [1/s], net of the
        backward reaction.
        """
        law, table = self.reactions[name]
        ((agent, order),) = law.orders.items()
        count = -law.stoichiometry[agent]
        pressure = x[agent] * (p / BAR)
        small = SMALL * p / BAR
        slope = (
            table.factor
            * law.constant(T)
            * (pressure * pressure + small * small) ** (0.5 * (order - 1.0))
        )
        mean = 0.5 * (T + T_gas)
        film = self.surface * self.film(agent, mean, p) * (BAR / R_GAS) / mean / count
        bar = {key: value * (p / BAR) for key, value in x.items()}
        back = equilibrium_quotient(law, T, bar)
        # K = prod p_made / p_agent^count, so the agent's pressure in equilibrium is
        # back^(1/count)
        if count != 1.0:
            back = power(back, 1.0 / count, TRACE)
        return rs.in_series(slope, film) * (pressure - back)

    def __call__(self, state: State, terms: SourceTerms) -> None:
        """Add combustion and gasification of char."""
        T = state.T[self.species]
        T_gas = state.T["emulsion"]
        p = state.pressure
        x = state.x["emulsion"]
        carbon = state.solid["char"]
        for name, (law, _) in self.reactions.items():
            if name == "char_combustion":
                rate = carbon * self.combustion_rate(
                    T, T_gas, x["O2"] * p / (R_GAS * T_gas), p
                )
                oxygen = 1.0 / self.carbon_per_oxygen(T)
                gases = {
                    "O2": -oxygen * rate,
                    "CO2": (2.0 * oxygen - 1.0) * rate,
                    "CO": (2.0 - 2.0 * oxygen) * rate,
                }
                gases = {key: value for key, value in gases.items() if key in x}
            else:
                rate = carbon * self.gasification_rate(name, T, T_gas, x, p)
                gases = {
                    key: count * rate
                    for key, count in law.stoichiometry.items()
                    if key != "C"
                }
            terms.particle(self.species, gases, {"char": -rate}, state)


@dataclass(frozen=True)
class Lime:
    """Calcination towards equilibrium, uptake of SO2 by lime, and its release by CO."""

    in_gas = False
    species: str
    diameter: float
    density: float  # of limestone
    calcination: float | None  # factors
    sulphation: float | None
    maximum: float
    # rate constant of sulphate with CO at 850 degC [1/Pa/s]
    reduction: float | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Keys of the scene."""
        wanted = (
            ("calcination", self.calcination),
            ("sulphation", self.sulphation),
            ("sulphate_reduction", self.reduction),
        )
        return tuple(name for name, factor in wanted if factor is not None)

    @property
    def makes(self) -> set[str]:
        """Gases that it makes or takes."""
        laws = [OF_LIME[name].stoichiometry for name in self.names]
        return {gas for law in laws for gas in law if gas in thermo.GASES}

    @property
    def volume(self) -> float:
        """Molar volume of limestone [m3/mol]."""
        return thermo.table()["CaCO3"].molar_mass / self.density

    def __call__(self, state: State, terms: SourceTerms) -> None:
        """Add calcination, and the uptake and release of SO2."""
        T = state.T[self.species]
        T_gas = state.T["emulsion"]
        p = state.pressure
        x = state.x["emulsion"]
        if self.calcination is not None:
            rate = self.calcination_rate(
                T, x["CO2"] * p, state.solid["CaCO3"], state.solid["CaO"]
            )
            terms.particle(
                self.species, {"CO2": rate}, {"CaCO3": -rate, "CaO": rate}, state
            )
        if self.sulphation is not None:
            small = SMALL * p / (R_GAS * T_gas)
            SO2, O2 = (x[name] * p / (R_GAS * T_gas) for name in ("SO2", "O2"))
            rate = self.sulphation_rate(
                T, SO2, state.solid["CaO"], state.solid["CaSO4"]
            )
            rate = rate * O2 / (O2 * O2 + (10.0 * small) ** 2) ** 0.5
            terms.particle(
                self.species,
                {"SO2": -rate, "O2": -0.5 * rate},
                {"CaO": -rate, "CaSO4": rate},
                state,
            )
        if self.reduction is not None:
            pressures = {name: x[name] * p for name in ("CO", "CO2", "SO2")}
            rate = self.reduction_rate(T, pressures, state.solid["CaSO4"])
            gases = {"CO": -rate, "CO2": rate, "SO2": rate}
            terms.particle(self.species, gases, {"CaSO4": -rate, "CaO": rate}, state)

    def calcination_rate(self, T: Any, p_CO2: Any, CaCO3: Any, CaO: Any) -> Any:
        """Return the net rate at which amounts of solids form CaO [amount/s]."""
        law = rs.CALCINATION
        equal = np.exp(thermo.equilibrium(law.stoichiometry).ln_K(T)) * BAR
        over = rs.positive(equal - p_CO2, 1.0)
        k = (
            (self.calcination or 0.0)
            * law.constant(T)
            * 6.0
            / self.diameter
            * self.volume
        )
        return k * (over * CaCO3 - (over - (equal - p_CO2)) * CaO)

    def sulphation_rate(self, T: Any, SO2: Any, CaO: Any, CaSO4: Any) -> Any:
        """Return the rate at which amounts of solids take up SO2 [amount/s].

        It is linear in the unreacted CaO up to the greatest conversion.
        """
        k = (self.sulphation or 0.0) * rs.SULPHATION.constant(T) * rs.lime_surface(T)
        left = CaO + CaSO4 - CaSO4 / self.maximum
        return k * SO2 * self.volume * rs.positive(left, 1e-9)

    def reduction_rate(self, T: Any, p: dict[str, Any], CaSO4: Any) -> Any:
        """Return the rate at which amounts of sulphate give off SO2 [amount/s], by
        pressures of CO, CO2 and SO2 [Pa].

        It falls to 0 where these are in equilibrium, and what lies beyond is the
        uptake's.
        """
        law = rs.SULPHATE_REDUCTION
        equal = (
            p["CO2"]
            * p["SO2"]
            * np.exp(-thermo.equilibrium(law.stoichiometry).ln_K(T))
            / BAR
        )
        return (
            (self.reduction or 0.0)
            * law.constant(T)
            * CaSO4
            * rs.positive(p["CO"] - equal, SMALL_CO)
        )


def used_laws(reactions: tuple[Any, ...]) -> Iterator[tuple[str, str, PowerLaw]]:
    """Yield (reaction, phase whose temperature counts, law) of all reactions that
    run.
    """
    for item in reactions:
        if isinstance(item, OfGases):
            if (law := item.reaction.published) is not None:
                yield item.name, "gas", law
        elif isinstance(item, Char):
            for name, (law, _) in item.reactions.items():
                yield name, item.species, law
        elif isinstance(item, Lime):
            for name in item.names:
                yield name, item.species, OF_LIME[name]
