"""Freeboard of a bubbling bed: gas that reacts, particles thrown up and falling back,
radiation, walls; a `Part` of the bed.

    N_i,y                  = S_i                                                                    gas i
    (m h)_y                = A sum_d a_d h_gp (T_d - T_f) + sum_x p_x h_x (T_x - T_f)               gas
    F_y                    = -a (F - F_inf),  F(0) = F_0                                            particles upward
    A F c T_u,y            = A [a_u h_gp (T_f - T_u) + K_u (G - 4 E_u)]
    -A (F - F_out) c T_d,y = A F_y (h_d - h_u) + A [a_d h_gp (T_f - T_d) + K_d (G - 4 E_d)]         and downward
    -(A D G_y)_y           = A sum_d K_d (4 E_d - G) + sum_x p_x (eps_x/4) (4 E_x - G)

    y = 0:  N_i = N_ie + N_ib,  m h = W_e h_e + W_b h_b,  h_u = mean of the bed's particles,
            G and A D G_y those of the bed
    y = L:  h_d = h_u,  F_out = F,  A D G_y = A (4 E_top - G)/2

y        height above the surface of the bed [m]      L        height of the freeboard [m]
N        mole flow of a gas [mol/s]                   S        made by reactions of gases [mol/s/m]
m        mass flow of the gas [kg/s]                  h        enthalpy [J/kg], h_u at T_u, h_d at T_d; of the gas
                                                               with heats of formation where it reacts
F, F_inf flow of particles upward, and far up [kg/m2/s]; F - F_out fall back into the bed      a    decay [1/m]
a_d      surface of particles per volume [1/m], that of f = F/(rho u_gas) of the volume;  K_d = eps a_d / 4
h_gp     particle-gas coefficient [W/m2/K]            x        walls, tubes

The bed gives A F h_u(0) to the freeboard and gets A (F - F_out) h_d(0) back, by mass
from all species. Particles rise and fall as fast as the gas rises; F_y is that of the
solution, so that the sum over all streams closes. The gas is transparent. Radiation is
one diffusion equation in a thin medium: P1 is off by 5 to 20 % of the flux where
optical depths are of order one.

The freeboard is solved on the mesh of the bed, upside down: y = (H - z) L/H, so that
both meet at one node and all unknowns belong to one Newton's method. Below, r = L/H,
d/dy = -(1/r) d/dz and dy = r dz.

Source: Kunii, Levenspiel 1991, Fluidization Engineering, 2nd edition, chapter 7, for
    the flows; heat by balances.

Good values: L 1-10 m, F_0 1-100 kg/m2/s, a 1-10 1/m.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from contbed.bubbling_bed.equations.coefficients import Part, Surface
from contbed.bubbling_bed.equations.species import HEAT, flow_balance
from contbed.chemistry.sums import Sums
from contbed.chemistry.thermo import Thermo
from contbed.closures.optics import SIGMA, marshak
from contbed.fem.stabilisation import tau
from contbed.radiation.equations import p1 as radiation

CLEAR = 1e-3  # optical depth of a freeboard without particles
# radiation through the surface of the bed over the jump of (G / 4 sigma)^(1/4) there
# [W/m2/K]
JOINED = 1e8
# flow of particles whose heat passes to the gas over L in any case [kg/m2/s]: where
# none fly, T is T_f; a hundred times what rounding makes of F_y in cells of
# micrometres, below which T_down there follows the rounding
LEAST = 1e-7
TEMPERATURES = ("T_freeboard", "T_up", "T_down")


def flow_of(name: str) -> str:
    """Return the unknown mole flow of a gas in the freeboard."""
    return f"N_{name}_freeboard"


@dataclass
class LocalCoefficients:
    """Coefficients at the points of a domain: numbers, arrays or functions of the
    unknowns.
    """

    flow: Any  # m [kg/s]
    enthalpy: Any  # of the gas, function of T [J/kg]
    heat_capacity: Any
    decay: Any  # a [1/m]
    carried: Any  # F_inf [kg/m2/s]
    # rho u_gas: flow of particles over their share of the volume [kg/m2/s]
    density_flow: Any
    exchange: Any  # h_gp [W/m2/K]


@dataclass(frozen=True)
class Freeboard(Part):
    """Coefficients and equations of the freeboard.

    Functions of the unknowns: `local_coefficients` (u, o) gives `LocalCoefficients`,
    `ejected` (local) gives F_0.
    """

    section: float  # A [m2]
    height: float  # L [m]
    bed: float  # H [m]
    local_coefficients: Callable[[Any, Any], LocalCoefficients]
    ejected: Callable[[Any], Any]
    shares: dict[str, float]  # of the species in the mass of the particles
    enthalpy: Callable[[str, Any], Any]  # of a species, (name, T) [J/kg]
    heat_capacity: Callable[[str, Any], Any]
    surface: float  # of particles over their volume [1/m]
    emissivity: float  # of particles
    surfaces: dict[str, Surface]
    radiates: bool
    diffusion: float  # D times the extinction: 1/3 or 1/4
    # sigma T^4 of what closes the freeboard [W/m2]; None for a mirror
    above: float | None
    heat: float  # what makes a flow of particles compare with heat [J m2/kg]
    degree: int
    gases: Mapping[str, Thermo]  # none where nothing reacts
    made: Callable[[Any], Mapping[str, Any]]  # S by gas, function of the unknowns
    scalars = ("carryover",)

    @property
    def fields(self) -> tuple[str, ...]:
        """Unknowns along the height."""
        radiation = ("G_freeboard",) if self.radiates else ()
        return (*TEMPERATURES, "flow_up", *radiation, *map(flow_of, self.gases))

    @property
    def stretch(self) -> float:
        """Ratio r of the heights of freeboard and bed, L/H."""
        return self.height / self.bed

    def solids(self, T: Any) -> Any:
        """Return the enthalpy of the mixture of particles [J/kg]."""
        return sum(
            share * self.enthalpy(name, T) for name, share in self.shares.items()
        )

    def content(self, u: Any, tests: Any, c: Any, o: Any) -> Any:
        """Return a tested content by which the freeboard approaches its steady
        state.
        """
        heat = sum(
            (getattr(u, name) * getattr(tests, name) for name in TEMPERATURES),
            start=0.0,
        )
        for name in map(flow_of, self.gases):
            heat = heat + 1e-3 * HEAT * getattr(u, name) * getattr(tests, name)
        return 1e3 * heat + self.heat * u.flow_up * tests.flow_up

    def capacity(self, T: Any) -> Any:
        """Return the heat capacity of the mixture of particles [J/kg/K]."""
        return sum(
            share * self.heat_capacity(name, T) for name, share in self.shares.items()
        )

    def exchanged(self, u: Any, here: LocalCoefficients) -> Sums:
        """Return the heat that phases gain per height y, radiation and surfaces
        included [W/m].
        """
        gain = Sums()
        for name, flow in (("T_up", u.flow_up), ("T_down", u.flow_up - u.carryover)):
            surface = self.section * self.surface * flow / here.density_flow
            passed = (surface * here.exchange + self._least(getattr(u, name))) * (
                u.T_freeboard - getattr(u, name)
            )
            gain.add("T_freeboard", -passed)
            gain.add(name, passed)
            if self.radiates:
                black = radiation.emitted(getattr(u, name))
                absorbed = 0.25 * self.emissivity * surface * (u.G_freeboard - black)
                gain.add(name, absorbed)
        for name in self.surfaces:
            gain.add("T_freeboard", -self.convected(u, name))
        return gain

    def _least(self, T: Any) -> Any:
        """Return the exchange with particles where none fly [W/m/K]."""
        return LEAST * self.section * self.capacity(T) / self.height

    def convected(self, u: Any, name: str) -> Any:
        """Return the heat that the gas transfers to a surface [W/m]."""
        x = self.surfaces[name]
        return x.perimeter * x.coefficient * (u.T_freeboard - x.temperature)

    def radiated(self, u: Any, name: str) -> Any:
        """Return the radiation into a surface [W/m]."""
        x = self.surfaces[name]
        if not self.radiates or not x.emissivity:
            return 0.0
        return x.radiated(u, u.G_freeboard)

    def residual(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form of all balances over the height."""
        r, A, here = self.stretch, self.section, self.local_coefficients(u, o)
        gain = self.exchanged(u, here)
        up, down, slope = u.flow_up, u.flow_up - u.carryover, o.grad(u.flow_up)[0]
        # over the flow of particles
        rate = A * self.surface * here.exchange / here.density_flow
        v, T = tests.T_freeboard, u.T_freeboard
        total = (
            here.flow * here.enthalpy(T) * o.grad(v)[0] - r * gain["T_freeboard"] * v
        )
        capacity = here.flow * here.heat_capacity(T)
        strong = capacity * o.grad(T)[0] + r * gain["T_freeboard"]
        for name, gas in self.gases.items():
            strong = strong + gas.enthalpy(T) * o.grad(getattr(u, flow_of(name)))[0]
        total = total + self._upwind(strong, capacity, rate * (up + down), v, o)
        for name, flow, sense in (("T_up", up, 1.0), ("T_down", down, -1.0)):
            T, v, gained = getattr(u, name), getattr(tests, name), r * gain[name]
            # what turns round comes with the enthalpy of those that rise
            if name == "T_down":
                gained = gained + A * slope * (self.solids(u.T_up) - self.solids(T))
            capacity = sense * A * flow * self.capacity(T)
            strong = capacity * o.grad(T)[0] + gained
            coupling = (
                rate * flow
                + self._least(T)
                + (0.0 if name == "T_up" else A * here.decay * up * self.capacity(T))
            )
            total = total - strong * v + self._upwind(strong, capacity, coupling, v, o)
        turned = -here.decay * (up - here.carried)
        v = tests.flow_up
        total = total - self.heat * (o.grad(up)[0] + r * turned) * (
            v - 0.5 * o.h * o.grad(v)[0]
        )
        total = total + self._species(u, tests, o)
        if not self.radiates:
            return total
        G, w = u.G_freeboard, tests.G_freeboard
        each = [
            (self.surface * flow / here.density_flow, T)
            for flow, T in ((up, u.T_up), (down, u.T_down))
        ]
        taken = sum(
            0.25 * self.emissivity * a * A * (G - radiation.emitted(T)) for a, T in each
        )
        taken = taken + sum(self.radiated(u, name) for name in self.surfaces)
        extinction = 0.25 * sum(a for a, _ in each) + CLEAR / self.height
        return (
            total
            + A * self.diffusion / (r * extinction) * o.grad(G)[0] * o.grad(w)[0]
            + r * taken * w
        )

    def _species(self, u: Any, tests: Any, o: Any) -> Any:
        """Return the weak form of the balances of gases."""
        if not self.gases:
            return 0.0
        total, made = 0.0, self.made(u)
        amount = sum(getattr(u, flow_of(name)) for name in self.gases)
        for name in self.gases:
            N, v = (getattr(each, flow_of(name)) for each in (u, tests))
            source = self.stretch * made[name]
            total = total + flow_balance(N, v, source, amount, -1.0, o, self.degree)
        return total

    def _upwind(self, strong: Any, capacity: Any, coupling: Any, v: Any, o: Any) -> Any:
        """Return the SUPG term for the residual r (gain - (carried)_y), which is
        `strong`.
        """
        stable = tau(capacity, 0.0, coupling, 1.0, self.stretch * o.h, self.degree)
        return stable / self.stretch * strong * capacity * o.grad(v)[0]

    def ejected_enthalpy(self, u: Any) -> Any:
        """Return the enthalpy of the particles at the surface of the bed [J/kg]."""
        return sum(
            share * self.enthalpy(name, getattr(u, f"T_{name}"))
            for name, share in self.shares.items()
        )

    def surface_radiation(self, u: Any) -> Any:
        """Return the radiation through the surface of the bed [W]; a penalty keeps G
        continuous there.
        """
        if not self.radiates:
            return 0.0
        below, above = ((G / (4.0 * SIGMA)) ** 0.25 for G in (u.G, u.G_freeboard))
        return self.section * JOINED * (below - above)

    def top_of_bed(self, u: Any, c: Any, local: Any) -> Any:
        """Return the heat that gas brings to the surface of the bed [W]."""
        return sum(
            local.flows[name] * local.h(name, getattr(u, name)) for name in c.gases
        )

    def top(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form at the surface of the bed, z = H and y = 0."""
        A, turned = self.section, u.flow_up - u.carryover
        total = -self.top_of_bed(u, c, local) * tests.T_freeboard
        total = (
            total
            + A
            * u.flow_up
            * (self.solids(u.T_up) - self.ejected_enthalpy(u))
            * tests.T_up
        )
        total = total + self.heat * (u.flow_up - self.ejected(local)) * tests.flow_up
        for name in self.gases:
            rising = sum(
                getattr(u, f"N_{name}_{gas.removeprefix('T_')}") for gas in c.gases
            )
            total = total - HEAT * rising * getattr(tests, flow_of(name))
        for name, share in self.shares.items():
            lost = self.enthalpy(name, getattr(u, f"T_{name}")) - self.enthalpy(
                name, u.T_down
            )
            total = total + A * turned * share * lost * getattr(tests, f"T_{name}")
        if not self.radiates:
            return total
        return (
            total
            + self.surface_radiation(u) * tests.G
            - self.surface_radiation(u) * tests.G_freeboard
        )

    def bottom(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form at the end of the freeboard, z = 0 and y = L."""
        here = self.local_coefficients(u, o)
        total = here.flow * here.enthalpy(u.T_freeboard) * tests.T_freeboard
        total = total + self.heat * (u.carryover - u.flow_up) * tests.carryover
        for name in map(flow_of, self.gases):
            total = total + HEAT * getattr(u, name) * getattr(tests, name)
        return (
            total + self.exit_radiation(u) * tests.G_freeboard
            if self.radiates
            else total
        )

    def exit_radiation(self, u: Any) -> Any:
        """Return the radiation out of the end of the freeboard [W]."""
        if not self.radiates or self.above is None:
            return 0.0
        return self.section * marshak(1.0) * (u.G_freeboard - 4.0 * self.above)
