"""The freeboard of a bubbling bed from its scene: coefficients, a first guess, heat
duties.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.bubbling_bed.closures import FREEBOARD, archimedes, gas_state
from contbed.bubbling_bed.equations import freeboard as model
from contbed.bubbling_bed.equations.coefficients import Local, Surface
from contbed.bubbling_bed.equations.species import SourceTerms
from contbed.closures.optics import SIGMA


class FreeboardProblem:
    """The freeboard above a bed: the `part` of the model, typical values of its
    unknowns and a first guess.
    """

    def __init__(self, scene: Any, computed: Any):
        self.scene = scene
        self.computed = computed
        # share of the rates of reactions, below 1 on the way to a state only
        self.rate = 1.0
        chemistry = getattr(computed, "chemistry", None)
        # gases as in the bed, in the one phase above it
        self.species = (
            replace(chemistry.part, phases=("freeboard",)) if chemistry else None
        )
        self.table = scene.bubbling_bed.freeboard
        self.coefficients = computed.coefficients
        names = computed.names
        total = sum(computed.share[name] * computed.density[name] for name in names)
        self.shares = {
            name: computed.share[name] * computed.density[name] / total
            for name in names
        }
        surface = sum(computed.surface.values()) / computed.solids
        radiates = scene.radiation.level in ("p1", "two_flux")
        emissivity = sum(
            computed.surface[name] * (scene.solids[name].emissivity or 0.0)
            for name in names
        )
        surfaces = {
            name: Surface(
                item.perimeter,
                item.coefficient,
                item.temperature,
                item.emissivity or 0.0,
            )
            for name, item in (
                ("freeboard_tubes", self.table.tubes),
                ("freeboard_walls", self.table.walls),
            )
            if item is not None
        }
        above = self.table.temperature_above
        self.part = model.Freeboard(
            computed.section,
            self.table.height,
            scene.bubbling_bed.height,
            self.local_coefficients,
            self.ejected,
            self.shares,
            computed.enthalpy,
            computed.heat_capacity,
            surface,
            emissivity / sum(computed.surface.values()),
            surfaces,
            radiates,
            1.0 / 3.0 if scene.radiation.level == "p1" else 0.25,
            SIGMA * above**4 if above is not None else None,
            1e6 * computed.flow / (0.02 * computed.rho_solid),
            scene.solver.degree,
            self.species.gases if self.species is not None else {},
            self.made,
        )

    def gas(self, u: Any) -> tuple[Any, Any]:
        """Return the mass flow [kg/s] and properties of the gas."""
        if self.species is None:
            return self.computed.flow, self.computed.gas
        from contbed.bubbling_bed.chemistry.problem import Mixture

        moles = self.species.flow(u, "freeboard")
        mass = self.species.mass(u, "freeboard")
        return mass, Mixture.of(self.computed.gas, moles, self.species.gases)

    @property
    def reacts(self) -> bool:
        """Whether reactions run in the gas above the bed."""
        return self.species is not None and any(
            reaction.in_gas for reaction in self.species.reactions
        )

    def made(self, u: Any) -> Mapping[str, Any]:
        """Return what reactions of gases make of each [mol/s/m]; particles do not
        react above the bed.
        """
        assert self.species is not None
        state, terms = self.species.state(u, None), SourceTerms(self.species)
        for reaction in self.species.reactions:
            if reaction.in_gas:
                reaction(state, terms)
        return {name: self.rate * made for name, made in terms.gas["freeboard"].items()}

    def state(self, u: Any) -> tuple[dict[str, Any], Any, Any]:
        """Return the arguments for closures at the temperature of the gas, its mass
        flow and its properties.
        """
        flow, gas = self.gas(u)
        computed, T = self.computed, u.T_freeboard
        state = gas_state(gas, T)
        state |= {
            "u_gas": flow / (state["rho_gas"] * computed.section),
            "eps": 1.0,
            "D_bed": computed.D_bed,
        }
        return state, flow, gas

    def _of(self, state: dict[str, Any], name: str, diameter: float) -> dict[str, Any]:
        """Return the state with particles of one solid phase and size."""
        item, rho = self.scene.solids[name], self.computed.density[name]
        Ar = archimedes(state, diameter, rho)
        return state | {
            "d_p": diameter,
            "sphericity": item.sphericity,
            "rho_solid": rho,
            "Ar": Ar,
        }

    def rates(self, state: dict[str, Any], name: str) -> list[Any]:
        """Return the elutriation rate constants of the sizes of a solid phase in a
        `state` [kg/m2/s].
        """
        item, out = self.scene.solids[name], []
        for diameter in (
            (item.diameter,) if item.sizes is None else item.sizes.diameters
        ):
            own = self._of(state, name, diameter)
            own["u_t"] = self._call("terminal_velocity", own)
            out.append(self._call("elutriation", own))
        return out

    def _call(self, key: str, state: dict[str, Any]) -> Any:
        return self.coefficients[*FREEBOARD, key](state, self.computed.ranges)

    def local_coefficients(self, u: Any, o: Any) -> model.LocalCoefficients:
        """Return the coefficients at the points of a domain."""
        state, flow, gas = self.state(u)
        computed, carried = self.computed, 0.0
        for name, share in self.shares.items():
            item = self.scene.solids[name]
            shares = (1.0,) if item.sizes is None else item.sizes.bed or item.sizes.feed
            for part, rate in zip(shares, self.rates(state, name), strict=True):
                carried = carried + share * part * rate
        mixed = state | {
            "d_p": computed.d_p,
            "Re": state["rho_gas"] * state["u_gas"] * computed.d_p / state["mu"],
        }
        nusselt = self.coefficients[*FREEBOARD, "gas_coefficient"]
        exchange = nusselt(mixed, computed.ranges)
        if nusselt.value is None:
            exchange = exchange * state["k_gas"] / computed.d_p
        return model.LocalCoefficients(
            flow,
            gas.enthalpy,
            gas.heat_capacity,
            self._call("decay", mixed),
            carried,
            computed.rho_solid * state["u_gas"],
            exchange,
        )

    def ejected(self, local: Local) -> Any:
        """Return the flow of particles from the surface of the bed [kg/m2/s]."""
        return self._call("ejection", local.state)

    @property
    def sizes(self) -> dict[str, float]:
        """Typical values of unknowns that are no temperatures."""
        flow = self.computed.rho_solid * 0.1
        return {"flow_up": flow, "carryover": flow} | self.flows

    @property
    def flows(self) -> dict[str, float]:
        """Typical values of the flows of gases."""
        whole = self.computed.flow / 0.03  # [mol/s] by the molar mass of air
        return {model.flow_of(name): whole for name in self.part.gases}

    def start(self, T: float, z: Any) -> dict[str, Any]:
        """Return a first guess: particles that fall back at the decay rate of the
        guess, gas as it enters.
        """
        flow = self.computed.flow
        out: dict[str, Any] = {}
        if self.species is not None:
            entering = self.species.as_entering(flow)
            out |= {
                model.flow_of(name): np.array([amount])
                for name, amount in entering.items()
            }
        here = self.local_coefficients(
            SimpleNamespace(T_freeboard=np.full(1, T), **out), None
        )
        ejected = self._call("ejection", self.computed.surface_state(T))
        y = (self.scene.bubbling_bed.height - z) * self.part.stretch
        out["flow_up"] = here.carried + (ejected - here.carried) * np.exp(
            -here.decay * y
        )
        return out | {"carryover": out["flow_up"][np.argmax(y)]}

    def duties(self, problem: Any, state: Any) -> dict[str, float]:
        """Return the heat that leaves the freeboard by mechanism [W]; positive
        outward.
        """
        part, out = self.part, {}
        for name in part.surfaces:
            out[f"{name}_convection_W"] = part.stretch * problem.total(
                lambda u, o, n=name: part.convected(u, n), state
            )
            out[f"{name}_radiation_W"] = part.stretch * problem.total(
                lambda u, o, n=name: part.radiated(u, n), state
            )
        out["freeboard_top_radiation_W"] = problem.at(
            lambda u, o: part.exit_radiation(u), problem.bottom, state
        )
        return out

    def carried(self, problem: Any, state: Any) -> dict[str, tuple[float, float]]:
        """Return the heat [W] that the gas takes away, and that of the particles.

        Particles bring heat from the bed, where it is part of the drain, and take away
        what is carried over.
        """
        part = self.part

        def gas(u: Any, o: Any) -> Any:
            here = part.local_coefficients(u, o)
            return here.flow * here.enthalpy(u.T_freeboard)

        def brought(u: Any, o: Any) -> Any:
            return part.section * u.carryover * part.ejected_enthalpy(u)

        taken = problem.at(
            lambda u, o: part.section * u.flow_up * part.solids(u.T_up),
            problem.bottom,
            state,
        )
        return {
            "freeboard": (0.0, problem.at(gas, problem.bottom, state)),
            "carryover": (problem.at(brought, problem.top, state), taken),
        }
