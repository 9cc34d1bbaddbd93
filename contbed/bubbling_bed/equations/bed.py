"""Heat of a steady bubbling bed along its height: solid species, emulsion gas, bubble
gas, distributor, radiation.

    (W_m h_m)' - (A k_m T_m')' = W_m' h_m(T_f,m) + Q_m + A (1 - delta) [a_m h_gm (T_e - T_m) + sum_n H_mn (T_n - T_m)
                                 + K_a,m (G - 4 E_m)] + sum_x p_x h_x f_m (T_x - T_m)            species m
    (W_e h_e)'                 = Q_e + A (1 - delta) sum_m a_m h_gm (T_m - T_e) + A delta H_be (T_b - T_e) - X h_X
    (W_b h_b)'                 = A delta H_be (T_e - T_b) + X h_X
    -(A D G')'                 = A (1 - delta) sum_m K_a,m (4 E_m - G) + sum_x p_x (eps_x/4) (4 E_x - G)

    z = 0:  -A k_m T_m' = A h_d f_m (T_d - T_m),   T_e = T_b = T_in + (1 - exp(-NTU)) (T_d - T_in)
            -A D G' = A eps_d/(2 (2 - eps_d)) (4 E_d - G)
            A h_d sum_m f_m (T_m - T_d) + A eps_d/(2 (2 - eps_d)) (G - 4 E_d) = (W_e + W_b) (h_e - h(T_in))
    z = H:  T_m' = 0,   A D G' = A (4 J - G)/2

z        height above the distributor [m]       '        d/dz
T_m      temperature of species m [K]           T_e, T_b of emulsion gas and bubble gas      T_d of the distributor
W        mass flow upward [kg/s]; W_m grows by what is fed at T_f,m           h        enthalpy [J/kg]
X        gas that passes from the emulsion to the bubbles [kg/s/m], W_b' less what reactions make in the bubbles
h_X      h_e(T_e) where X > 0, else h_b(T_b)
A        section [m2]                           delta    share of bubbles in the volume [1]
k_m      conductivity of axial mixing [W/m/K]   Q        heat release per height [W/m]
a_m h_gm surface per emulsion volume times particle-gas coefficient [W/m3/K]
H_mn     exchange between species [W/m3/K]      H_be     exchange of bubble and emulsion gas [W/m3/K]
f_m      share of m in the surface of all particles [1]
G        incident radiation [W/m2]              E        sigma T^4 [W/m2]
K_a,m    absorption coefficient [1/m]           D        of the emulsion, radiation/equations/p1.py; bubbles are windows
x        tubes, walls: perimeter p [m], coefficient h [W/m2/K], effective emissivity eps in the bulk field [1]
J        radiosity of the freeboard [W/m2]      NTU      transfer units of the gas in the distributor [1]

With frozen coefficients W is a capacity flow [W/K], h = T, and X = 0. Computed
coefficients are functions of the unknowns at the same place, see `Local`; bubbles then
bring the fields of equations/flow.py.

Without transport of radiation ("paper", "pairwise") G is the algebraic 4 sum K_a,m
E_m / sum K_a,m, surfaces cool the species by their shares, p_x (eps_x/4) (K_a,m/K_a) 4
(E_m - E_x), and neither distributor nor freeboard take part. "pairwise" exchanges
between species by the network of pairs that the paper replaces, see closures.enclosure.

Source: Rabi & de Souza-Santos, Incorporation of a two-flux model for radiative heat
    transfer in a comprehensive
fluidized bed simulator, part I. Their balances march solids upward from unknown T_m(0);
with mixing along the height and conditions at both ends they are a well-posed
boundary-value problem for all unknowns at once.

Discretisation: continuous elements of degree 1 to 3, convection in conservative form
    with weak inflow, residual-based
SUPG. The sum of all heat residuals is the energy balance of the bed, so it closes with
the nonlinear solver.

Good values: particles of 0.3-5 mm, beds of 0.3-3 m, mixing 1e2-1e5 W/m/K, entry layers
of gas and radiation of 1 mm.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.bubbling_bed.equations import flow as bubbling_flow
from contbed.bubbling_bed.equations.coefficients import (
    Coefficients,
    Local,
    Stream,
    Surface,
    unit_heat_capacity,
)
from contbed.chemistry.sums import Sums
from contbed.closures.enclosure import (
    exchange_equilibrium,
    exchange_pairwise,
    irradiation_equilibrium,
)
from contbed.closures.optics import marshak
from contbed.fem.stabilisation import tau
from contbed.radiation.equations import p1 as radiation


def temperatures(u: Any, c: Coefficients) -> list[Any]:
    """Return the temperatures of the species."""
    return [getattr(u, f"T_{name}") for name in c.species]


def incident(u: Any, c: Coefficients) -> Any:
    """Return the incident radiation [W/m2]: the unknown field, or its algebraic
    value at each height.
    """
    if c.level == "field":
        return u.G
    return irradiation_equilibrium(
        [item.absorption for item in c.species.values()], temperatures(u, c)
    )


def convected(u: Any, c: Coefficients, name: str, local: Local) -> Any:
    """Return the heat that particles transfer to a surface by contact [W/m]."""
    x, each = c.surfaces[name], zip(c.species.values(), temperatures(u, c), strict=True)
    return sum(
        x.perimeter * local.contact[name] * item.share * (T - x.surface_temperature(u))
        for item, T in each
    )


def radiated(u: Any, c: Coefficients, x: Surface) -> Any:
    """Return the radiation into a surface [W/m]."""
    if c.level == "none" or not x.emissivity:
        return 0.0
    return x.radiated(u, incident(u, c))


def released(u: Any, stream: Stream, name: str, o: Any) -> Any:
    """Return the heat release of a phase [W/m]."""
    return 0.0 if stream.release is None else stream.release(o.x[0], getattr(u, name))


def crossflow_heat(u: Any, c: Coefficients, local: Local) -> Any:
    """Return the heat that gas carries from the emulsion into the bubbles [W/m]."""
    up, down = np.maximum(local.crossing, 0.0), np.minimum(local.crossing, 0.0)
    return up * local.h("T_emulsion", u.T_emulsion) + down * local.h(
        "T_bubble", u.T_bubble
    )


def gains(u: Any, c: Coefficients, local: Local, o: Any) -> dict[str, Any]:
    """Return the heat that each phase gains per height, without transport along the
    height [W/m].
    """
    T = {name: getattr(u, name) for name in c.streams}
    gain = Sums(
        {name: released(u, stream, name, o) for name, stream in c.streams.items()}
    )
    volume = c.volume(local)

    def pass_on(one: str, other: str, coefficient: Any) -> None:
        gain.move(one, other, coefficient * (T[one] - T[other]))

    for name, item in c.species.items():
        pass_on(f"T_{name}", "T_emulsion", volume * local.gas[name])
        for surface, x in c.surfaces.items():
            contact = x.perimeter * local.contact[surface] * item.share
            lost = contact * (T[f"T_{name}"] - x.surface_temperature(u))
            gain.add(f"T_{name}", -lost)
    for (one, other), coefficient in local.pairs.items():
        pass_on(f"T_{one}", f"T_{other}", volume * coefficient)
    if c.bubbles is not None:
        pass_on("T_bubble", "T_emulsion", c.section * local.delta * local.exchange)
    if local.crossing is not None:
        gain.move("T_emulsion", "T_bubble", crossflow_heat(u, c, local))
    if c.level != "none":
        for name, taken in zip(c.species, net_absorption(u, c, local), strict=True):
            gain.add(f"T_{name}", taken)
    for part in c.parts:
        for name, heat in part.gains(u, c, local, o).items():
            gain.add(name, heat)
    return gain


def net_absorption(u: Any, c: Coefficients, local: Local) -> list[Any]:
    """Return the radiation that each species absorbs less what it emits [W/m]."""
    T, volume = temperatures(u, c), c.volume(local)
    absorption = [item.absorption for item in c.species.values()]
    if c.level == "field":
        absorption = [
            local.shares.get(name, 1.0) * item.absorption
            for name, item in c.species.items()
        ]
        return [
            volume * radiation.absorbed(t, u.G, K)
            for K, t in zip(absorption, T, strict=True)
        ]
    if c.level == "pairwise":
        emissivity = [item.emissivity for item in c.species.values()]
        extinction = [K / eps for K, eps in zip(absorption, emissivity, strict=True)]
        taken = [
            -volume * lost for lost in exchange_pairwise(extinction, emissivity, T)
        ]
    else:
        taken = [-volume * lost for lost in exchange_equilibrium(absorption, T)]
    for x in c.surfaces.values():
        factor = 0.25 * x.perimeter * x.emissivity / sum(absorption)
        cold = radiation.emitted(x.surface_temperature(u))
        taken = [
            old - factor * K * (radiation.emitted(t) - cold)
            for old, K, t in zip(taken, absorption, T, strict=True)
        ]
    return taken


def residual(u: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of all balances between the ends."""
    local = c.at(u, o)
    total: Any = 0.0
    for name, gain in gains(u, c, local, o).items():
        if name in c.gases:
            balance = _gas(u, name, getattr(tests, name), gain, c, local, o)
        else:
            balance = _solid(u, name, getattr(tests, name), gain, c, local, o)
        total = total + balance
    if local.gas_flow is not None:
        total = total + bubbling_flow.residual(u, tests, local.gas_flow, o)
    for part in c.parts:
        total = total + part.residual(u, tests, c, local, o)
    if c.level != "field":
        return total
    sinks = [
        (0.25 * x.perimeter * x.emissivity, x.surface_temperature(u))
        for x in c.surfaces.values()
    ]
    volume = c.volume(local)
    optics = radiation.Coefficients(
        {
            f"T_{name}": volume * local.shares.get(name, 1.0) * item.absorption
            for name, item in c.species.items()
        },
        c.section * c.diffusion,
        emission=sum(factor * radiation.emitted(T) for factor, T in sinks),
        passive=sum(factor for factor, _ in sinks),
    )
    return total + radiation.residual(u, tests, optics, o)


def _coupling(c: Coefficients, name: str, local: Local) -> Any:
    """Return the linear exchange coefficient of a phase with all others [W/m/K]."""
    gases, volume = c.section * local.delta * local.exchange, c.volume(local)
    if name == "T_bubble":
        return gases
    if name == "T_emulsion":
        return gases + volume * sum(local.gas.values())
    species = name.removeprefix("T_")
    others = sum(value for pair, value in local.pairs.items() if species in pair)
    contact = (
        sum(x.perimeter * local.contact[key] for key, x in c.surfaces.items())
        * c.species[species].share
    )
    return volume * (local.gas[species] + others) + contact


def _gas(
    u: Any, name: str, v: Any, gain: Any, c: Coefficients, local: Local, o: Any
) -> Any:
    """Return the weak form of the balance of a gas, which does not conduct."""
    T, slope, flow = getattr(u, name), o.grad(v)[0], local.flows[name]
    capacity = flow * local.heat_capacity.get(name, unit_heat_capacity)(T)
    strong = capacity * o.grad(T)[0] + local.changed(name, T) - gain
    stable = tau(capacity, 0.0, _coupling(c, name, local), 1.0, o.h, c.degree)
    return (
        -flow * local.h(name, T) * slope - gain * v + stable * strong * capacity * slope
    )


def _solid(
    u: Any, name: str, v: Any, gain: Any, c: Coefficients, local: Local, o: Any
) -> Any:
    """Return the weak form of the balance of a species."""
    T, slope, s = getattr(u, name), o.grad(v)[0], c.streams[name]
    flow, gradient = s.flow(o.x[0]), o.grad(T)[0]
    fed = 0.0 if s.fed is None else s.fed(o.x[0])
    brought = s.enthalpy(s.feed_temperature)
    conduction = local.conduction[name.removeprefix("T_")]
    capacity = flow * s.heat_capacity(T)
    total = (
        conduction * gradient * slope
        - flow * s.enthalpy(T) * slope
        - (gain + fed * brought) * v
    )
    strong = (
        capacity * gradient
        + fed * (s.enthalpy(T) - brought)
        - conduction * o.laplacian(T)
        - gain
    )
    stable = tau(capacity, conduction, _coupling(c, name, local), 1.0, o.h, c.degree)
    return total + stable * strong * capacity * slope


def gas_entry(u: Any, c: Coefficients) -> Any:
    """Return the temperature of the gas above the distributor [K]."""
    return (
        c.inlet
        if c.plate is None
        else c.inlet + c.plate.effectiveness * (u.T_distributor - c.inlet)
    )


def heat_to_distributor(u: Any, c: Coefficients) -> tuple[Any, Any]:
    """Return the heat into the distributor [W] from the particles by contact, and by
    radiation.
    """
    if c.plate is None:
        return 0.0, 0.0
    each = zip(c.species.values(), temperatures(u, c), strict=True)
    contact = sum(
        c.section * c.plate.coefficient * item.share * (T - u.T_distributor)
        for item, T in each
    )
    if c.level != "field":
        return contact, 0.0
    return contact, c.section * marshak(c.plate.emissivity) * (
        u.G - radiation.emitted(u.T_distributor)
    )


def bottom(u: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of the conditions at the distributor, and of its own
    balance.
    """
    local, total = c.at(u, o), 0.0
    entry = gas_entry(u, c)
    for name, item in c.species.items():
        T, v = getattr(u, f"T_{name}"), getattr(tests, f"T_{name}")
        total = total - item.stream.flow(o.x[0]) * item.stream.enthalpy(T) * v
        if c.plate is not None:
            total = (
                total
                + c.section
                * c.plate.coefficient
                * item.share
                * (T - u.T_distributor)
                * v
            )
    carried: Any = 0.0
    for name in c.gases:
        flow, brought = local.flows[name], local.h(name, entry)
        total = total - flow * brought * getattr(tests, name)
        carried = carried + flow * (brought - local.h(name, c.inlet))
    if local.gas_flow is not None:
        total = total + bubbling_flow.bottom(u, tests, local.gas_flow, o)
    for part in c.parts:
        total = total + part.bottom(u, tests, c, local, o)
    if c.plate is None:
        return total
    contact, radiative = heat_to_distributor(u, c)
    total = total + (carried - contact - radiative) * tests.T_distributor
    return total + radiative * tests.G if c.level == "field" else total


def to_freeboard(u: Any, c: Coefficients) -> Any:
    """Return the radiation that leaves through the top [W]."""
    if c.level != "field" or c.radiosity is None:
        return 0.0
    return c.section * -radiation.supplied(u, radiation.Surface(1.0, c.radiosity), None)


def top(u: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of the streams that leave, and of the radiation from and
    to the freeboard.
    """
    local, total = c.at(u, o), 0.0
    for name, stream in c.streams.items():
        T = getattr(u, name)
        carried = (
            local.flows[name] * local.h(name, T)
            if name in c.gases
            else stream.flow(o.x[0]) * stream.enthalpy(T)
        )
        total = total + carried * getattr(tests, name)
    for part in c.parts:
        total = total + part.top(u, tests, c, local, o)
    return total + to_freeboard(u, c) * tests.G if c.level == "field" else total
