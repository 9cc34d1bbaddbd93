"""Gas species, char, moisture, volatiles and limestone of a bubbling bed along its
height; a `Part` of the bed's heat.

    N_ie' = S_ie + J_i - X w_iX/M_i              mole flow of gas i in the emulsion [mol/s]
    N_ib' = S_ib - J_i + X w_iX/M_i              in the bubbles
    (v n_k)' - (D n_k')' = F_k + R_k             inventory of solid k per height [mol/m], volatiles [kg/m]

J_i      A delta K rho (w_ib - w_ie)/M_i, exchange without net mass [mol/s/m]; K [1/s] by a closure, w mass fractions
X        gas that passes into the bubbles [kg/s/m], of the emulsion's composition where X > 0, else of the bubbles'
S        made by reactions: homogeneous per volume of gas of a phase, those of particles into the emulsion's gas
v        upward velocity of the solids that are drained [m/s]: height over residence time, negative to the bottom
D        mixing of the species' particles [m2/s]
F, R     fed, and made by reactions

Heat: enthalpies include those of formation, so heats of reaction appear nowhere. What
    passes from one phase to another
takes along the enthalpy that it has where it comes from; what is consumed in a particle
comes from the gas at the gas's temperature, what is made leaves at the particle's. J
carries enthalpies at the mean temperature of both gases: their exchange of sensible
heat is that of the bed's model. The solids' streams carry sum_k (v n_k - D n_k')
h_k(T). Ash leaves where it is fed, at the particle's temperature.

Equations of mole flows are multiplied by a heat per mole so that their residuals
compare with those of heat.

Good values: O2 burns off char within 10-300 mm; char in a combustor is 0.5-3 % of the
particles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from contbed.bubbling_bed.equations.coefficients import Part
from contbed.chemistry.sums import Sums
from contbed.chemistry.thermo import R_GAS, Thermo
from contbed.fem.stabilisation import tau

HEAT = 4e5  # [J/mol]


@dataclass(frozen=True)
class Solid:
    """One constituent of the particles of `species`; `fed` [mol/m/s] is a function
    of height or None.
    """

    species: str
    enthalpy: Callable[[Any], Any]  # [J/mol]
    fed: Any = None
    feed_temperature: float = 298.15
    scale: float = 1.0  # moles that count as one in the residual's scale
    typical: float = 1.0  # inventory [mol/m]


@dataclass(frozen=True)
class Ash:
    """Ash of a feed [kg/s/m as a function of height] that leaves where it is fed,
    with enthalpy [J/kg] of T.
    """

    species: str
    fed: Any
    feed_temperature: float
    enthalpy: Callable[[Any], Any]


@dataclass
class Sources:
    """Source terms of reactions and exchange at the points of a domain."""

    gas: Mapping[str, Sums]  # by phase and species [mol/s/m]
    solid: Sums  # [mol/s/m]
    gain: Sums  # by field of temperature [W/m]


@dataclass
class State:
    """Temperatures, compositions and inventories that reactions depend on, at the
    points of a domain.
    """

    T: dict[str, Any]  # by phase and species [K]
    x: dict[str, dict[str, Any]]  # mole fractions by phase
    w: dict[str, dict[str, Any]]  # mass fractions
    molar_mass: dict[str, Any]  # [kg/mol]
    volume: dict[str, Any]  # of gas per height [m2]
    pressure: float
    solid: dict[str, Any]  # inventories [mol/m]
    local: Any = None


Reactions = Callable[[State, "SourceTerms"], None]


class SourceTerms:
    """Sum of the source terms of all reactions, with the enthalpy that passes
    between phases.
    """

    def __init__(self, part: Species):
        self.part = part
        none = dict.fromkeys(part.gases, 0.0)
        self.gas = {phase: Sums(none) for phase in part.phases}
        self.solid = Sums(dict.fromkeys(part.solids, 0.0))
        self.gain = Sums()

    def homogeneous(
        self, phase: str, stoichiometry: Mapping[str, float], rate: Any
    ) -> None:
        """Add a reaction at `rate` [mol/s/m] within the gas of a phase."""
        for name, count in stoichiometry.items():
            self.gas[phase].add(name, count * rate)

    def particle(
        self,
        species: str,
        gases: Mapping[str, Any],
        solids: Mapping[str, Any],
        state: State,
    ) -> None:
        """Add gases made by particles (negative if consumed) and solids
        made [mol/s/m].
        """
        T, T_gas = state.T[species], state.T["emulsion"]
        for name, made in gases.items():
            self.gas["emulsion"].add(name, made)
            enthalpy = self.part.gases[name].enthalpy
            # a reversible reaction changes sides: made at T, consumed at T_gas
            heat = np.maximum(made, 0.0) * enthalpy(T) + np.minimum(
                made, 0.0
            ) * enthalpy(T_gas)
            self.gain.add("T_emulsion", heat)
            self.gain.add(f"T_{species}", -heat)
        for name, made in solids.items():
            self.solid.add(name, made)

    def passed(self, moles: Mapping[str, Any], T: Any) -> None:
        """Add the gas that passes from the bubbles to the emulsion [mol/s/m], with
        its enthalpy at T.
        """
        for name, amount in moles.items():
            self.to_emulsion(name, amount)
            heat = amount * self.part.gases[name].enthalpy(T)
            self.gain.add("T_emulsion", heat)
            self.gain.add("T_bubble", -heat)

    def to_emulsion(self, name: str, amount: Any) -> None:
        """Add what passes of a gas from the bubbles to the emulsion [mol/s/m]."""
        self.gas["emulsion"].add(name, amount)
        self.gas["bubble"].add(name, -amount)


@dataclass(frozen=True)
class Species(Part):
    """Coefficients and equations. `inlet` are mole fractions, `exchange` a function
    of `Local` [1/s].
    """

    gases: Mapping[str, Thermo]
    phases: tuple[str, ...]
    inlet: dict[str, float]
    pressure: float
    section: float
    voidage: float  # of the emulsion
    solids: dict[str, Solid]
    ash: tuple[Ash, ...]
    velocity: float  # v [m/s]
    mixing: dict[str, Callable[[Any], Any]]  # D by species, function of `Local` [m2/s]
    reactions: tuple[Reactions, ...]
    exchange: Callable[[Any, State], Any] | None
    degree: int

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the unknown fields."""
        flows = [f"N_{name}_{phase}" for phase in self.phases for name in self.gases]
        return (*flows, *(f"n_{name}" for name in self.solids))

    @cached_property
    def inlet_molar_mass(self) -> float:
        """Molar mass of the gas that enters [kg/mol]."""
        return sum(self.gases[name].molar_mass * x for name, x in self.inlet.items())

    def known(self, u: Any) -> bool:
        """Return whether flows of gases are among the unknowns `u`; they are not in
        a first estimate of a bed.
        """
        return hasattr(u, f"N_{next(iter(self.gases))}_emulsion")

    def flow(self, u: Any, phase: str) -> dict[str, Any]:
        """Return the mole flows of a phase [mol/s]."""
        return {name: getattr(u, f"N_{name}_{phase}") for name in self.gases}

    def mass(self, u: Any, phase: str) -> Any:
        """Return the mass flow of a phase [kg/s]."""
        return sum(
            self.gases[name].molar_mass * amount
            for name, amount in self.flow(u, phase).items()
        )

    def changed(self, u: Any, phase: str, o: Any, T: Any) -> Any:
        """Return sum_i N_i' h_i [W/m]."""
        return sum(
            o.grad(amount)[0] * self.gases[name].enthalpy(T)
            for name, amount in self.flow(u, phase).items()
        )

    def state(self, u: Any, local: Any) -> State:
        """Return the compositions and temperatures."""
        T = {
            name.removeprefix("T_"): getattr(u, name)
            for name in vars(u)
            if name.startswith("T_")
        }
        x, w, M = {}, {}, {}
        for phase in self.phases:
            N = self.flow(u, phase)
            total, mass = sum(N.values()), self.mass(u, phase)
            x[phase] = {name: amount / total for name, amount in N.items()}
            w[phase] = {
                name: self.gases[name].molar_mass * amount / mass
                for name, amount in N.items()
            }
            M[phase] = mass / total
        delta = 0.0 if local is None else local.delta
        volume = {
            "emulsion": self.section * (1.0 - delta) * self.voidage,
            "bubble": self.section * delta,
            "freeboard": self.section,
        }
        solid = {name: getattr(u, f"n_{name}") for name in self.solids}
        return State(T, x, w, M, volume, self.pressure, solid, local)

    def sources(self, u: Any, local: Any) -> Sources:
        """Return the sources by reactions and exchange; kept with `local`, which
        belongs to one evaluation.
        """
        if "sources" not in local.state:
            state, terms = self.state(u, local), SourceTerms(self)
            for reactions in self.reactions:
                reactions(state, terms)
            if "bubble" in self.phases:
                self._exchange(state, terms)
            local.state["sources"] = Sources(terms.gas, terms.solid, terms.gain)
        sources: Sources = local.state["sources"]
        return sources

    def _exchange(self, state: State, terms: SourceTerms) -> None:
        assert self.exchange is not None
        local, w = state.local, state.w
        T = 0.5 * (state.T["emulsion"] + state.T["bubble"])
        rho = (
            self.pressure
            * 0.5
            * (state.molar_mass["emulsion"] + state.molar_mass["bubble"])
            / (R_GAS * T)
        )
        mass = self.section * local.delta * self.exchange(local, state) * rho
        terms.passed(
            {
                name: mass * (w["bubble"][name] - w["emulsion"][name]) / gas.molar_mass
                for name, gas in self.gases.items()
            },
            T,
        )
        if local.crossing is not None:  # its enthalpy is in the bed's model
            up, down = np.maximum(local.crossing, 0.0), np.minimum(local.crossing, 0.0)
            for name, gas in self.gases.items():
                crossed = (
                    up * w["emulsion"][name] + down * w["bubble"][name]
                ) / gas.molar_mass
                terms.to_emulsion(name, -crossed)

    def gains(self, u: Any, c: Any, local: Any, o: Any) -> dict[str, Any]:
        """Return the heat per height [W/m] by the field of the phase."""
        gain = Sums(self.sources(u, local).gain)
        for ash in self.ash:
            name = f"T_{ash.species}"
            heat = ash.fed(o.x[0]) * (
                ash.enthalpy(ash.feed_temperature) - ash.enthalpy(getattr(u, name))
            )
            gain.add(name, heat)
        return gain

    def flux(self, u: Any, name: str, local: Any, o: Any) -> Any:
        """Return the upward flow of a solid [mol/s]."""
        n = getattr(u, f"n_{name}")
        return (
            self.velocity * n
            - self.mixing[self.solids[name].species](local) * o.grad(n)[0]
        )

    def residual(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form of all balances between the ends."""
        sources, total = self.sources(u, local), 0.0
        for phase in self.phases:
            amount = sum(self.flow(u, phase).values())
            for name in self.gases:
                N, v = (getattr(each, f"N_{name}_{phase}") for each in (u, tests))
                made = sources.gas[phase][name]
                total = total + flow_balance(N, v, made, amount, 1.0, o, self.degree)
        for name, solid in self.solids.items():
            v = getattr(tests, f"n_{name}")
            flux, slope = self.flux(u, name, local, o), o.grad(v)[0]
            fed = solid.fed(o.x[0]) if solid.fed is not None else 0.0
            total = total - HEAT * solid.scale * (
                flux * slope + (sources.solid[name] + fed) * v
            )
            T = getattr(u, f"T_{solid.species}")
            test = getattr(tests, f"T_{solid.species}")
            brought = (
                fed * solid.enthalpy(solid.feed_temperature)
                if solid.fed is not None
                else 0.0
            )
            total = total - (
                flux * solid.enthalpy(T) * o.grad(test)[0] + brought * test
            )
        return total

    def content(self, u: Any, tests: Any, c: Any, o: Any) -> Any:
        """Return the tested content of the bed: solids, and gas at 1 m/s."""
        held = sum(
            (
                HEAT
                * getattr(u, f"N_{name}_{phase}")
                * getattr(tests, f"N_{name}_{phase}")
                for phase in self.phases
                for name in self.gases
            ),
            start=0.0,
        )
        for name, solid in self.solids.items():
            held = held + HEAT * solid.scale * getattr(u, f"n_{name}") * getattr(
                tests, f"n_{name}"
            )
        return held

    def bottom(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form at the distributor: the gas that enters, and solids
        drained below.

        The gas brings the enthalpy of the entering gas in place of that of the unknown
        flows.
        """
        from contbed.bubbling_bed.equations.bed import gas_entry

        total, entry, carried = 0.0, gas_entry(u, c), 0.0
        for phase in self.phases:
            entering = self.entering(local, phase)
            for name, gas in self.gases.items():
                lacking = entering[name] - getattr(u, f"N_{name}_{phase}")
                total = total - HEAT * entering[name] * getattr(
                    tests, f"N_{name}_{phase}"
                )
                total = total - lacking * gas.enthalpy(entry) * getattr(
                    tests, f"T_{phase}"
                )
                carried = carried + lacking * (
                    gas.enthalpy(entry) - gas.enthalpy(c.inlet)
                )
        if c.plate is not None:
            total = total + carried * tests.T_distributor
        return total + self._drained(u, tests, local, o, -1.0)

    def entering(self, local: Any, phase: str) -> dict[str, Any]:
        """Return the mole flows into a phase [mol/s]: `inlet` times the flow that
        the bed's model gives it.
        """
        return self.as_entering(local.state["entering"][f"T_{phase}"])

    def as_entering(self, flow: Any) -> dict[str, Any]:
        """Return the mole flows [mol/s] of a mass flow [kg/s] of the gas that
        enters.
        """
        mean = self.inlet_molar_mass
        return {name: flow * self.inlet.get(name, 0.0) / mean for name in self.gases}

    def top(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form of what leaves at the top."""
        total = 0.0
        for phase in self.phases:
            for name, amount in self.flow(u, phase).items():
                total = total + HEAT * amount * getattr(tests, f"N_{name}_{phase}")
        return total + self._drained(u, tests, local, o, 1.0)

    def _drained(self, u: Any, tests: Any, local: Any, o: Any, normal: float) -> Any:
        total: Any = 0.0
        for name, solid in self.solids.items():
            leaving = max(normal * self.velocity, 0.0) * getattr(u, f"n_{name}")
            test = getattr(tests, f"T_{solid.species}")
            total = total + HEAT * solid.scale * leaving * getattr(tests, f"n_{name}")
            total = (
                total
                + leaving * solid.enthalpy(getattr(u, f"T_{solid.species}")) * test
            )
        return total


def flow_balance(
    N: Any, v: Any, made: Any, amount: Any, sense: float, o: Any, degree: int
) -> Any:
    """Return the weak form of `sense` N' = made for a mole flow, stabilised along it;
    `amount` is the flow of all gases.
    """
    slope = o.grad(v)[0]
    stable = tau(1.0, 0.0, _loss(made, amount), 1.0, o.h, degree)
    strong = o.grad(N)[0] - sense * made
    return HEAT * ((stable * strong - sense * N) * slope - made * v)


def _loss(made: Any, amount: Any) -> Any:
    """Return how fast a source can change a flow [1/m]; for the stabilisation only."""
    value = np.abs(getattr(made, "value", made))
    return value / np.maximum(0.1 * np.abs(getattr(amount, "value", amount)), 1e-300)
