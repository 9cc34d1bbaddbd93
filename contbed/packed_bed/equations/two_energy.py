"""Two energy equations, fluid and solid, of a packed or moving bed (local thermal
non-equilibrium).

    d(eps rho_f h_f)/dt     + div(G_f h_f) = div(K_ff grad T_f + K_fs grad T_s) + h a (T_s - T_f) + q_f
    d((1-eps) rho_s h_s)/dt + div(G_s h_s) = div(K_ss grad T_s + K_fs grad T_f) - h a (T_s - T_f) + q_s

On a line the heat q_w (4/D) through the side of a tube is added to the gain of a phase.

T        temperature [K]                       h_f, h_s  enthalpy [J/kg], dh = c_p dT
G        superficial mass flux [kg/m2/s]       h a       volumetric exchange coefficient [W/m3/K]
K_ff     fluid conductivity with dispersion    K_ss      solid conductivity [W/m/K]
K_fs     cross conduction (tortuosity) [W/m/K] q         heat source per bed volume [W/m3]

Source: Pivem & de Lemos, Int. J. Heat Mass Transfer 55 (2012) 3358,
    doi:10.1016/j.ijheatmasstransfer.2011.11.047,
Eqs 11-14; cross conduction: Nakayama et al., Int. J. Heat Mass Transfer 44 (2001) 4375,
doi:10.1016/S0017-9310(01)00069-2.

Discretisation: continuous elements of degree 1 to 3, convection in conservative form,
    residual-based SUPG with the
second-derivative term. When G comes from a computed flow, its divergence is orthogonal
to piecewise linear functions only; subtracting div(G) times the linear interpolant of
the enthalpy keeps a uniform temperature uniform and leaves the heat balance exact.

Intraparticle conduction: T_s is the mean temperature of a particle, that of its surface
is T_s + sum_m T_m. The modes of conduction T_m, each its share of the temperature at
the surface (`contbed.particle.interior`), move with the solids:

    d((1-eps) rho_s c_s T_m)/dt + div(G_s c_s T_m) = -D_m T_m + g_m h a (T_f - T_s - sum_m T_m)

Heat that is conducted from particle to particle or released in them is spread evenly
over each.

Good values: steam through hot silica, eps 0.4-0.9, particles of 1-10 mm, h a 1e3-1e5
W/m3/K, degree 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

FIELDS = ("T_fluid", "T_solid")
# step of a central difference of the conductivity, over the temperature: errors of 1e-8
# of its slope
DIFFERENCE = 1e-4


@dataclass(frozen=True)
class Phase:
    """One phase on one domain. Functions of temperature work on pointwise values;
    numbers and arrays are fixed.
    """

    mass_flux: Any  # vector [kg/m2/s]; None when the phase rests
    divergence: Any  # of the mass flux, None when it vanishes identically
    enthalpy: Any  # function of T [J/kg]
    heat_capacity: Any  # function of T [J/kg/K]
    # reference heat capacity for the divergence correction and stabilisation [J/kg/K]
    capacity: float
    offset: float  # enthalpy is close to capacity * T + offset [J/kg]
    conductivity: Any  # function of T [W/m/K]
    dispersion: Any  # (across, along minus across, direction) or None
    content: Any  # heat content per bed volume, function of T [J/m3]
    source: Any  # [W/m3]
    # stabilisation parameter [m3 K/W times J/kg/K]; None without stabilisation
    tau: Any
    varies: bool = False  # whether the conductivity depends on temperature
    # a temperature of the scene, for the step of a difference [K]
    reference: float = 300.0


@dataclass(frozen=True)
class Mode:
    """One mode of intraparticle conduction; see the module."""

    name: str
    decay: Any  # D_m as a function of T_solid [W/m3/K]
    gain: float  # g_m
    tau: Any  # as in Phase


@dataclass(frozen=True)
class Coefficients:
    """Both phases, the exchange coefficient h a as a function of (T_fluid, T_solid),
    the cross conductivity.
    """

    fluid: Phase
    solid: Phase
    exchange: Any
    # function of the mean temperature [W/m/K]; None without cross conduction
    cross: Any
    # radiation that the solid takes up as a function of the unknowns [W/m3]; None
    # without
    radiated: Any = None
    modes: tuple[Mode, ...] = ()
    # (1-eps) rho_s as a function of T_solid [kg/m3], for the modes
    capacity: Any = None
    # heat through the side of a line, and the area of the side per volume [1/m]
    sides: tuple[BoundaryTerms, ...] = ()
    perimeter: float = 0.0


def residual(unknowns: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the weak form of the steady part of both balances, without boundary
    terms.
    """
    fluid, solid = unknowns.T_fluid, unknowns.T_solid
    surface = solid
    for mode in c.modes:
        surface = surface + getattr(unknowns, mode.name)
    transfer = c.exchange(fluid, solid) * (surface - fluid)
    cross = None if c.cross is None else c.cross(0.5 * (fluid + solid))
    gains = {"T_fluid": transfer + c.fluid.source, "T_solid": c.solid.source - transfer}
    if c.radiated is not None:
        gains["T_solid"] = gains["T_solid"] + c.radiated(unknowns)
    for wall in c.sides:
        gains[wall.name] = gains[wall.name] + c.perimeter * supplied(unknowns, wall, o)
    total = _balance(fluid, solid, tests.T_fluid, gains["T_fluid"], c.fluid, cross, o)
    total = total + _balance(
        solid, fluid, tests.T_solid, gains["T_solid"], c.solid, cross, o
    )
    for mode in c.modes:
        total = total + _mode(unknowns, tests, transfer, mode, c.solid, o)
    return total


def _mode(
    unknowns: Any, tests: Any, transfer: Any, mode: Mode, solid: Phase, o: Any
) -> Any:
    """Return the weak form of one mode of conduction inside; `transfer` is the heat
    given to the fluid [W/m3].
    """
    T, v = getattr(unknowns, mode.name), getattr(tests, mode.name)
    loss = mode.decay(unknowns.T_solid) * T + mode.gain * transfer
    total = loss * v
    if solid.mass_flux is None:
        return total
    capacity = solid.heat_capacity(unknowns.T_solid)
    slope = o.dot(solid.mass_flux, o.grad(v))
    total = total - capacity * T * slope
    if mode.tau is not None:
        strong = capacity * o.dot(solid.mass_flux, o.grad(T)) + loss
        total = total + mode.tau * strong * slope
    return total


def _balance(
    T: Any, other: Any, v: Any, gain: Any, c: Phase, cross: Any, o: Any
) -> Any:
    slope = o.grad(v)
    total = o.dot(conduction(T, c, o), slope) - gain * v
    if cross is not None:
        total = total + cross * o.dot(o.grad(other), slope)
    if c.mass_flux is None:
        return total
    total = total - c.enthalpy(T) * o.dot(c.mass_flux, slope)
    if c.divergence is not None:
        total = total - c.divergence * (c.capacity * o.low(T) + c.offset) * v
    if c.tau is not None:
        strong = (
            c.heat_capacity(T) * o.dot(c.mass_flux, o.grad(T))
            - _conduction_divergence(T, c, o)
            - gain
        )
        if cross is not None:
            # gradients of the cross conductivity are left out
            strong = strong - cross * o.laplacian(other)
        total = total + c.tau * strong * o.dot(c.mass_flux, slope)
    return total


def conduction(T: Any, c: Phase, o: Any) -> Any:
    """Return K grad T [W/m2], minus the conducted heat flux."""
    gradient = o.grad(T)
    flux = c.conductivity(T) * gradient
    if c.dispersion is not None:
        across, extra, direction = c.dispersion
        flux = (
            flux + across * gradient + (extra * o.dot(direction, gradient)) * direction
        )
    return flux


def _conduction_divergence(T: Any, c: Phase, o: Any) -> Any:
    """Return div(K grad T) [W/m3], with the change of K with temperature; dispersion is
    taken as uniform.

    Without dK/dT the residual of the exact solution would not vanish, and the method
    would be of second order only.
    """
    total = c.conductivity(T) * o.laplacian(T)
    if c.varies:
        step = DIFFERENCE * c.reference
        slope = (c.conductivity(T + step) - c.conductivity(T - step)) / (2.0 * step)
        total = total + slope * o.dot(o.grad(T), o.grad(T))
    if c.dispersion is not None:
        across, extra, direction = c.dispersion
        total = (
            total
            + across * o.laplacian(T)
            + extra * o.dot(direction, o.mul(o.hess(T), direction))
        )
    return total


def storage(unknowns: Any, tests: Any, c: Coefficients, o: Any) -> Any:
    """Return the heat content of both phases, tested as the steady part is."""
    total = 0.0
    for name, phase in (("T_fluid", c.fluid), ("T_solid", c.solid)):
        content, v = phase.content(getattr(unknowns, name)), getattr(tests, name)
        total = content * v + total
        if phase.tau is not None:
            total = total + phase.tau * content * o.dot(phase.mass_flux, o.grad(v))
    for mode in c.modes:
        solid, v = unknowns.T_solid, getattr(tests, mode.name)
        content = (
            c.capacity(solid)
            * c.solid.heat_capacity(solid)
            * getattr(unknowns, mode.name)
        )
        total = content * v + total
        if mode.tau is not None:
            total = total + mode.tau * content * o.dot(c.solid.mass_flux, o.grad(v))
    return total


@dataclass(frozen=True)
class BoundaryTerms:
    """One phase on one boundary domain; heat fluxes are counted into the bed."""

    name: str
    mass_flux: Any  # None where no stream crosses
    enthalpy: Any  # function of T [J/kg]
    # enthalpy of the entering Danckwerts stream [J/kg], None otherwise
    inflow: Any = None
    flux: float = 0.0  # [W/m2]
    coefficient: Any = None  # function of the unknowns [W/m2/K]
    ambient: float = 0.0  # [K]
    emission: float = 0.0  # emissivity times the Stefan-Boltzmann constant [W/m2/K4]
    # what this phase takes of a heat that is given for the bed, as a function of the
    # unknowns; None is all
    share: Any = None
    # heat capacity as a function of T_solid [J/kg/K], of a mode in place of the
    # enthalpy
    capacity: Any = None

    @property
    def phase(self) -> str:
        """The phase, "fluid" or "solid"."""
        return self.name.removeprefix("T_")

    @property
    def crossed(self) -> bool:
        """Whether heat may cross; an adiabatic wall costs nothing."""
        return (
            self.mass_flux is not None
            or self.coefficient is not None
            or bool(self.flux or self.emission)
        )


def boundary(unknowns: Any, tests: Any, c: BoundaryTerms, o: Any) -> Any:
    """Return the weak form of convection through a boundary, prescribed flux and
    wall coefficient.
    """
    return (convected(unknowns, c, o) - supplied(unknowns, c, o)) * getattr(
        tests, c.name
    )


def convected(unknowns: Any, c: BoundaryTerms, o: Any) -> Any:
    """Return the heat carried out of the bed by the stream [W/m2]."""
    if c.mass_flux is None:
        return 0.0
    if c.inflow is not None:
        enthalpy = c.inflow
    elif c.capacity is not None:
        enthalpy = c.capacity(unknowns.T_solid) * getattr(unknowns, c.name)
    else:
        enthalpy = c.enthalpy(getattr(unknowns, c.name))
    return o.dot(c.mass_flux, o.n) * enthalpy


def supplied(unknowns: Any, c: BoundaryTerms, o: Any) -> Any:
    """Return the heat given to the bed by flux, wall coefficient and radiation from
    the surroundings [W/m2].
    """
    total, T = c.flux, getattr(unknowns, c.name)
    if c.coefficient is not None:
        total = total + c.coefficient(unknowns) * (c.ambient - T)
    if c.emission:
        total = total + c.emission * (c.ambient**4 - T**4)
    return total if c.share is None else c.share(unknowns) * total
