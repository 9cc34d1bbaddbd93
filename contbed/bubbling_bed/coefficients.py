"""Coefficients of a bubbling bed as functions of its state: properties of gas and
particles, and closures by name.

Everything in the emulsion is taken at the mean temperature of the particles, weighted
with their volumes: gas meets it within millimetres of the distributor. Only the volume
of the bubbles' gas follows its own temperature. Properties of the mixture of particles:
density by volume, heat capacity by mass, diameter and conductivity as the surface sees
them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.closures import (
    BUBBLES,
    CONDUCTIVITY,
    EXPANSION,
    MINIMUM_FLUIDIZATION,
    Coefficient,
    archimedes,
    gas_state,
    surface_key,
    uses,
)
from contbed.bubbling_bed.equations import coefficients as model
from contbed.bubbling_bed.equations import flow as bubbling_flow
from contbed.chemistry.char_and_lime import diffusion_in_nitrogen
from contbed.materials.curve import function_of, integral_of
from contbed.scene.toml_lines import KeyPath

# share of u_mf over which the excess of gas bends to zero where there is none
SMOOTHED = 1e-3
# share of u_mf that bubbles and emulsion carry at least, so that both have a
# temperature
LEAST = 1e-6
STEPS = 200  # of the march that gives a first guess of the bubbles


class Computed:
    """`Local` of equations/bed.py from a scene; a list in `ranges` collects how
    closures were used.
    """

    def __init__(self, scene: b.BubblingScene, gas: Any):
        self.scene, self.gas = scene, gas
        self.ranges: list[Any] | None = None
        self.smoothed = SMOOTHED
        self.mixtures: Callable[[Any], dict[str, Any]] = lambda u: {
            "emulsion": gas,
            "bubble": gas,
        }
        self.flow = scene.gas_flow
        bed, present = scene.bubbling_bed, scene.present
        base = scene.origin.base
        self.bubbling = bed.bubbling
        self.coefficients = {
            path: Coefficient(path, spec, kind, self.bubbling, base)
            for path, spec, kind in uses(scene)
        }
        self.section, self.solids = bed.section, bed.solids_fraction
        self.eps = 1.0 - bed.solids_fraction
        self.D_bed = float(np.sqrt(4.0 * bed.section / np.pi))
        self.names = list(present)
        self.share = {name: item.volume_share for name, item in present.items()}
        self.density = {
            name: float(item.density or 0.0) for name, item in present.items()
        }
        given = {name: item.heat_capacity for name, item in present.items()}
        self.capacity = {name: function_of(cp) for name, cp in given.items() if cp}
        self.content = {name: integral_of(cp) for name, cp in given.items() if cp}
        self.surface = scene.surface_of_particles
        total = sum(item.volume_share / item.diameter for item in present.values())
        self.d_p = 1.0 / total
        self.sphericity = 6.0 * self.solids * total / sum(self.surface.values())
        self.rho_solid = sum(
            self.share[name] * self.density[name] for name in self.names
        )
        self.conductivity = {
            name: function_of(item.conductivity) for name, item in present.items()
        }
        self.grows = self.bubbling and self.coefficients[*BUBBLES, "size"].value is None
        self.chemistry = self._chemistry() if scene.reactions is not None else None
        self.above = None
        if bed.freeboard is not None and bed.freeboard.height is not None:
            from contbed.bubbling_bed.freeboard import FreeboardProblem

            self.above = FreeboardProblem(scene, self)

    def _chemistry(self) -> Any:
        """Return the reacting part, whose gas makes the mixtures and the flows."""
        from contbed.bubbling_bed.chemistry.problem import chemistry

        mixing = {name: partial(self._dispersion, name) for name in self.names}
        found = chemistry(self.scene, mixing, self._gas_exchange)
        self.mixtures = lambda u: found.mixtures(u, self.gas)
        return found

    def _dispersion(self, name: str, local: model.Local) -> Any:
        """Axial mixing of a solid phase [m2/s]: its conductivity over its heat
        capacity per height.
        """
        emulsion = self.section * (1.0 - local.delta) * self.solids * self.share[name]
        content = (
            emulsion * self.density[name] * self.heat_capacity(name, local.state["T"])
        )
        return local.state["conduction"][name] / content

    def _gas_exchange(self, local: model.Local, state: Any) -> Any:
        """Gas between bubbles and emulsion per volume of bubbles [1/s]."""
        D = diffusion_in_nitrogen("O2", 0.031998, local.state["T"], self.gas.pressure)
        return self._call((*BUBBLES, "gas_exchange"), local.state | {"D_gas": D})

    @property
    def fields(self) -> tuple[str, ...]:
        """The unknowns of equations/flow.py."""
        there = (("flow_bubble", self.bubbling), ("d_bubble", self.grows))
        return tuple(name for name, wanted in there if wanted)

    def _by_surface(self, values: dict[str, Any]) -> Any:
        return sum(self.surface[name] * value for name, value in values.items()) / sum(
            self.surface.values()
        )

    def heat_capacity(self, name: str, T: Any) -> Any:
        """[J/kg/K] of a solid phase."""
        return self.capacity[name](T)

    def enthalpy(self, name: str, T: Any) -> Any:
        """[J/kg] of a solid phase, 0 at 0 K."""
        return self.content[name](T)

    def temperature(self, u: Any) -> Any:
        """Mean temperature of the particles [K]."""
        return sum(self.share[name] * getattr(u, f"T_{name}") for name in self.names)

    def state(self, u: Any, flow: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return what closures may ask for, and the gases, where all gas flows at
        `flow` [kg/s].
        """
        T, gases = self.temperature(u), self.mixtures(u)
        gas = gases["emulsion"]
        cp_solid = (
            sum(
                self.share[n] * self.density[n] * self.heat_capacity(n, T)
                for n in self.names
            )
            / self.rho_solid
        )
        state = gas_state(gas, T)
        rho, mu = state["rho_gas"], state["mu"]
        state |= {
            "p": gas.pressure,
            "molar_mass": gas.molar_mass,
            "eps": self.eps,
            "eps_mf": self.eps,
            "d_p": self.d_p,
            "sphericity": self.sphericity,
            "D_bed": self.D_bed,
            "rho_solid": self.rho_solid,
            "cp_solid": cp_solid,
            "k_solid": self._by_surface(
                {name: k(T) for name, k in self.conductivity.items()}
            ),
            "Ar": archimedes(state, self.d_p, self.rho_solid),
        }
        found = self._call(MINIMUM_FLUIDIZATION, state)
        given = self.coefficients[MINIMUM_FLUIDIZATION].value is not None
        state["u_mf"] = found if given else found * mu / (rho * self.d_p)
        if not self.bubbling:
            state["u"] = state["u_e"] = flow / (rho * self.section)
            state["u_excess"] = _positive(
                state["u"] - state["u_mf"], self.smoothed * state["u_mf"]
            )
        state["slip"] = state.get("u_excess")
        return state, gases

    def bubbles(
        self,
        state: dict[str, Any],
        rho_bubble: Any,
        flow: Any,
        flow_bubble: Any,
        d_b: Any,
    ) -> Any:
        """Put velocities and volume of bubbles into the state; the flow of bubbles that
        the closures give [kg/s].

        Where the emulsion would take more gas than there is, the bed is not fluidized:
        all gas flows through the emulsion. Where a closure lets gas flow down it rests;
        `u_emulsion_closure` keeps that, by which such a bed is refused.
        """
        rho, A = state["rho_gas"], self.section
        state["u"] = (flow - flow_bubble) / (rho * A) + flow_bubble / (rho_bubble * A)
        bend = self.smoothed * state["u_mf"]
        state["u_excess"] = state["slip"] = _positive(state["u"] - state["u_mf"], bend)
        state["u"] = state["u_mf"] + state["u_excess"]
        state["d_b"] = d_b
        state["u_b"] = self._call((*BUBBLES, "rise"), state)
        state["delta"] = self._call((*BUBBLES, "fraction"), state)
        state["u_emulsion_closure"] = self._call((*BUBBLES, "emulsion_gas"), state)
        least = LEAST * state["u_mf"]
        all_gas = flow / (rho * A * (1.0 - state["delta"]))
        rising = least + _bent(state["u_emulsion_closure"] - least, bend)
        bubbles = least + _bent(all_gas - rising - least, bend)
        state["u_e"] = all_gas - bubbles
        return rho * A * (1.0 - state["delta"]) * bubbles

    def _call(self, path: KeyPath, state: dict[str, Any]) -> Any:
        return self.coefficients[path](state, self.ranges)

    def __call__(self, u: Any, o: Any) -> model.Local:
        """Return the coefficients at the points of a domain."""
        scene = self.scene
        flow = self.flow
        part = self.chemistry.part if self.chemistry is not None else None
        if part is not None and part.known(u):
            flow = sum(part.mass(u, phase) for phase in part.phases)
        state, gases = self.state(u, flow)
        flows = {"T_emulsion": flow}
        slopes = {"T_emulsion": 0.0}
        crossing = None
        unknown = None
        # a kg of gas heated by 1000 K
        heat = 1e3 * gases["emulsion"].heat_capacity(scene.initial.temperature)
        if self.bubbling:
            d_b = (
                u.d_bubble if self.grows else self.coefficients[*BUBBLES, "size"].value
            )
            target = self.bubbles(
                state, gases["bubble"].density(u.T_bubble), flow, u.flow_bubble, d_b
            )
            growth = self._call((*BUBBLES, "size"), state) if self.grows else None
            start = self._call((*BUBBLES, "start"), state) if self.grows else None
            flows = {"T_emulsion": flow - u.flow_bubble, "T_bubble": u.flow_bubble}
            crossing = o.grad(u.flow_bubble)[0]
            slopes = {"T_emulsion": -crossing, "T_bubble": crossing}
            unknown = bubbling_flow.Local(
                target, growth, start, heat, heat * self.flow / self.D_bed
            )
        delta = state.get("delta", 0.0)
        changes = {}
        if part is not None and part.known(u):
            state["entering"] = (
                {"T_emulsion": self.flow}
                if not self.bubbling
                else {
                    "T_emulsion": self.flow - u.flow_bubble,
                    "T_bubble": u.flow_bubble,
                }
            )
            flows = {f"T_{phase}": part.mass(u, phase) for phase in part.phases}
            changes = {
                f"T_{phase}": partial(part.changed, u, phase, o)
                for phase in part.phases
            }
        local = model.Local(
            delta,
            {name: self._to_gas(name, state) for name in self.names},
            {name: self._mixing(name, state) for name in self.names},
            self._pairs(state),
            self._call((*BUBBLES, "exchange"), state) if self.bubbling else 0.0,
            {key: self._contact(key, state) for key in scene.bubbling_bed.surfaces},
            flows,
            slopes,
            crossing,
            {f"T_{phase}": gas.enthalpy for phase, gas in gases.items()},
            {f"T_{phase}": gas.heat_capacity for phase, gas in gases.items()},
            unknown,
            state,
            changes,
        )
        if changes:
            self._inventory(u, local)
        return local

    def _inventory(self, u: Any, local: model.Local) -> None:
        """Scale what goes by the surface of the fuel from its volume_share to what
        the bed holds.
        """
        state = local.state
        assert self.chemistry is not None
        state["conduction"] = dict(local.conduction)
        for name, surface in self.chemistry.surfaces(u).items():
            share = surface / (self.section * (1.0 - local.delta) * self.surface[name])
            local.gas[name] = share * local.gas[name]
            local.conduction[name] = share * local.conduction[name]
            local.pairs = {
                pair: share * value if name in pair else value
                for pair, value in local.pairs.items()
            }
            local.shares[name] = share

    def recorded(self, values: dict[str, Any], z: Any) -> tuple[model.Local, list[Any]]:
        """Return the coefficients at heights where the unknowns have `values`, and
        how they used their closures.
        """
        self.ranges = []
        local = self(
            SimpleNamespace(**values),
            SimpleNamespace(grad=lambda field: (np.zeros_like(z),), x=(z,)),
        )
        found, self.ranges = self.ranges, None
        return local, found

    def expansion(self, u: Any, o: Any) -> Any:
        """Height of the bed over that at minimum fluidization."""
        return self._call(EXPANSION, self(u, o).state)

    def _to_gas(self, name: str, state: dict[str, Any]) -> Any:
        d_p = self.scene.solids[name].diameter
        Re = state["rho_gas"] * state["u_e"] * d_p / state["mu"]
        number = self.scene.solids[name].gas_coefficient
        if number is not None:
            return self.surface[name] * number
        nusselt = self.coefficients["solids", name, "nusselt"]
        found = nusselt(state | {"Re": Re, "d_p": d_p}, self.ranges)
        return self.surface[name] * (found * state["k_gas"] / d_p)

    def _mixing(self, name: str, state: dict[str, Any]) -> Any:
        """Section times conductivity of a solid phase [W m/K]."""
        coefficient = self.coefficients["solids", name, "mixing_conductivity"]
        found = coefficient(state, self.ranges)
        emulsion = self.section * (1.0 - state.get("delta", 0.0)) * self.share[name]
        if coefficient.value is None:
            content = self.density[name] * self.heat_capacity(name, state["T"])
            mixing = emulsion * self.solids * content * found
        else:
            mixing = self.section * found
        if self.scene.bubbling_bed.conductivity is None:
            return mixing
        return mixing + emulsion * self._call(CONDUCTIVITY, state)

    def _pairs(self, state: dict[str, Any]) -> dict[tuple[str, str], Any]:
        out = {}
        for name in self.names:
            for other in self.scene.solids[name].exchange:
                if other not in self.names:
                    continue
                pair = (
                    state
                    | self._of_pair(name, 1, state)
                    | self._of_pair(other, 2, state)
                )
                out[name, other] = self.coefficients["solids", name, "exchange", other](
                    pair, self.ranges
                )
        return out

    def _of_pair(self, name: str, k: int, state: dict[str, Any]) -> dict[str, Any]:
        item = self.scene.solids[name]
        return {
            f"f_{k}": self.solids * self.share[name],
            f"d_{k}": item.diameter,
            f"rho_{k}": self.density[name],
            f"cp_{k}": self.heat_capacity(name, state["T"]),
            f"k_{k}": self.conductivity[name](state["T"]),
        }

    def _contact(self, key: str, state: dict[str, Any]) -> Any:
        return self.coefficients[*surface_key(key), "coefficient"](state, self.ranges)

    def _uniform(self, T: float) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the state and the gases of a bed of one temperature."""
        names = (*self.names, "emulsion", "bubble")
        u = SimpleNamespace(**{f"T_{name}": np.full(1, T) for name in names})
        return self.state(u, self.flow)

    def surface_state(self, T: float) -> dict[str, Any]:
        """Return what closures see at the surface of a bed of one temperature."""
        state, gases = self._uniform(T)
        if self.bubbling:
            flows, sizes = self.march(T, np.array([self.scene.bubbling_bed.height]))
            self.bubbles(state, gases["bubble"].density(T), self.flow, flows, sizes)
        return state

    def march(self, T: float, z: Any) -> tuple[Any, Any]:
        """Flow and size of bubbles over the height in a bed of one temperature:
        where Newton's method starts.
        """
        flow = self.flow
        heights = np.linspace(0.0, float(np.max(z)), STEPS + 1)
        steps, sizes, bubbles = np.diff(heights), [], []
        d_b: Any = (
            0.01 * self.D_bed
            if self.grows
            else self.coefficients[*BUBBLES, "size"].value
        )
        flow_bubble: Any = 0.5 * flow
        state, gases = self._uniform(T)
        rho_bubble = gases["bubble"].density(T)
        for k in range(STEPS + 1):
            for _ in range(40 if k == 0 else 2):
                wanted = self.bubbles(state, rho_bubble, flow, flow_bubble, d_b)
                flow_bubble = 0.5 * flow_bubble + 0.5 * np.clip(
                    wanted, 0.02 * flow, 0.98 * flow
                )
                if k == 0 and self.grows:
                    d_b = self._call((*BUBBLES, "start"), state)
            sizes.append(float(np.squeeze(d_b)))
            bubbles.append(float(np.squeeze(flow_bubble)))
            if self.grows and k < STEPS:
                d_b = np.maximum(
                    d_b + steps[k] * self._call((*BUBBLES, "size"), state),
                    1e-3 * self.D_bed,
                )
        return np.interp(z, heights, bubbles), np.interp(z, heights, sizes)

    @property
    def sizes(self) -> dict[str, float]:
        """Typical values of the unknown fields."""
        typical = {"flow_bubble": self.flow, "d_bubble": self.D_bed}
        out = {name: typical[name] for name in self.fields}
        for item in (self.chemistry, self.above):
            out |= item.sizes if item is not None else {}
        return out

    def start(self, T: float, z: Any) -> dict[str, Any]:
        """Return the unknown fields in a bed of one temperature."""
        out: dict[str, Any] = {}
        if self.bubbling:
            out["flow_bubble"], out["d_bubble"] = self.march(T, z)
        out = {name: out[name] for name in self.fields}
        if self.chemistry is not None:
            bubbles = {"bubble": out["flow_bubble"]} if self.bubbling else {}
            flows = {"emulsion": self.flow - bubbles.get("bubble", 0.0)} | bubbles
            out |= self.chemistry.start(T, z, flows)
        return out | (self.above.start(T, z) if self.above is not None else {})

    @property
    def parts(self) -> tuple[Any, ...]:
        """Physics joined to the bed."""
        return tuple(
            item.part for item in (self.chemistry, self.above) if item is not None
        )


def _positive(x: Any, bend: Any) -> Any:
    """Return x where it is far above `bend`, zero far below; positive everywhere."""
    return 0.5 * (x + (x**2 + bend**2) ** 0.5)


def _bent(x: Any, bend: Any) -> Any:
    """Return exactly x above `bend`, zero below -`bend`, and a parabola with the
    same slopes between.
    """
    between = np.minimum(np.maximum(x, -bend), bend)
    return (between + bend) ** 2 / (4.0 * bend) + np.maximum(x - bend, 0.0)
