"""Heat of gas and particles, each with its own temperature, on the mass fluxes of the flow.

    d(eps_g rho_g cp_g T_g)/dt + div(rho_g F_g cp_g T_g) = div(k_g grad T_g) + h a (T_s - T_g) + eps_g dp0/dt
    d(eps_s rho_s cp_s T_s)/dt + div(rho_s F_s cp_s T_s) = div(k_s grad T_s) + h a (T_g - T_s),   a = 6 eps_s/d_p

F [m/s] are the volume fluxes of the phases that the step moves, k_g and k_s [W/m/K] effective conductivities of each
phase per area of the bed, h [W/m2/K] the coefficient of a particle. Heat of friction, of collisions and of radiation
is left out. An ideal gas at a low Mach number has rho_g = rho_ref (T_ref/T_g) (p0/p_ref) with the thermodynamic
pressure p0 [Pa] uniform: that outside of the outlet or, in a closed bed, the one at which the mass of gas fills the
volume; its expansion is the divergence that the equation of pressure keeps,

    div(F_g + F_s) = 1/(rho_g cp_g T_g) (conducted and exchanged heat + eps_g dp0/dt) - eps_g/p0 dp0/dt

(Majda and Sethian 1985, Combust. Sci. Technol. 42, 185-205, doi:10.1080/00102208508960376). What the last step left
open between mass, temperature and volume joins the divergence, so that it does not add up.

Convection is explicit and limited to second order, conduction implicit, first order in time. Exchange weighs the new
and the old difference of the temperatures by w = 1/(1 - exp(-z)) - 1/z, z = dt (sum of the rates of both phases): exact
for constant h in a closed suspension at any dt, and with heat that moves or is given at a constant rate (exponential
fitting, Liniger and Willoughby 1970, SIAM J. Numer. Anal. 7, 47-66). Mass and heat change by the
fluxes of faces alone, so both close to rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from contbed.errors import ConvergenceError
from contbed.two_fluid import boundary
from contbed.two_fluid import kernels_solid as ks
from contbed.two_fluid.fv import gradient as kc
from contbed.two_fluid.heat import kernels as kh
from contbed.two_fluid.kernels_faces import two_phase

if TYPE_CHECKING:
    from contbed.two_fluid.step import Stepper

FIELDS = ("T_gas", "T_solid")
MEMORY = (*FIELDS, "mass", "lag_gas", "lag_solid")
TOLERANCE, ITERATIONS = 1e-10, 500
EXPLICIT = 0.1  # conduction of a cell in a step, as share of its content, below which it is not solved for
SLOW = 1e-3  # dt times rate below which the weight of the new difference is its series


@dataclass(frozen=True)
class Physics:
    """What gas and particles are.

    cp_gas, cp_solid [J/kg/K] : heat capacities
    coefficient : h [W/m2/K] of a particle from eps_s, slip speed [m/s], density of the gas over the usual one, T_gas
    conductivity : (k_g, k_s) [W/m/K] (nc,) from eps_s and the temperatures; None where nothing is conducted
    density : "constant", or that of an "ideal_gas" which is the usual one at T_reference [K] and `pressure` [Pa]
    """

    cp_gas: float
    cp_solid: float
    coefficient: Callable[[np.ndarray, np.ndarray, Any, np.ndarray], np.ndarray]
    conductivity: Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None
    density: Literal["constant", "ideal_gas"] = "constant"
    T_reference: float = 293.15
    pressure: float = 101325.0


@dataclass(frozen=True)
class Thermal:
    """Heat at a boundary: temperatures [K] of gas and solids that enter, of a wall, or the flux [W/m2] into the bed,
    which the phases share by their fractions. What is not given is adiabatic; what comes back through an outlet has the
    temperature of the cell.
    """

    T_gas: float | None = None
    T_solid: float | None = None
    wall: float | None = None
    flux: float = 0.0


class Heat:
    """Temperatures of a bed and what they are made of.

    T_gas, T_solid (nc,) [K]; mass (nc,) [kg/m3] of the gas per volume of the bed; p0 [Pa]
    account : heat [J] that came in and went out with the phases and through walls, gas [kg] that came in and went out
    """

    def __init__(self, bed: Stepper, physics: Physics, conditions: Mapping[str, Thermal]):
        self.bed, self.physics = bed, physics
        nc = len(bed.eps_s)
        self.T_gas, self.T_solid, self.mass = np.full(nc, physics.T_reference), np.empty(nc), np.empty(nc)
        self.T_solid[:] = self.T_gas
        self.lag_gas, self.lag_solid = np.zeros((nc, 1)), np.zeros((nc, 1))
        self.p0 = physics.pressure
        self.account = dict.fromkeys(("heat_in", "heat_out", "walls", "gas_in", "gas_out"), 0.0)
        self.ideal = physics.density == "ideal_gas"
        self.closed = self.ideal and bed.pressure.floating
        self.impose(conditions)

    def impose(self, conditions: Mapping[str, Thermal]) -> None:
        """Conditions by boundary name; boundaries without one are adiabatic."""
        grid = self.bed.grid
        nb = len(grid.geometry.left) - grid.interior
        self.enters = np.full((2, nb), np.nan)
        self.wall, self.flux = np.full(nb, np.nan), np.zeros(nb)
        for name, c in conditions.items():
            at = grid.boundaries[name] - grid.interior
            for values, given in ((self.enters[0], c.T_gas), (self.enters[1], c.T_solid), (self.wall, c.wall)):
                if given is not None:
                    values[at] = given
            self.flux[at] = c.flux

    def start(self) -> None:
        """Mass of the gas that belongs to the temperatures."""
        self.mass = (1.0 - self.bed.eps_s) * (self.rho_T / self.T_gas if self.ideal else self.bed.rho[0])
        self._thin()

    @property
    def rho_T(self) -> float:
        """Density times temperature [kg K/m3] of an ideal gas at p0."""
        p = self.physics
        return self.bed.materials.rho_gas * p.T_reference * self.p0 / p.pressure

    def stored(self) -> float:
        """Heat in the bed [J] from 0 K; in a closed one filled with an ideal gas the internal energy."""
        bed, p, volume = self.bed, self.physics, self.bed.grid.geometry.volume
        total = (p.cp_gas * self.mass * self.T_gas + p.cp_solid * bed.rho[1] * bed.eps_s * self.T_solid) @ volume
        return float(total - (self.p0 * (1.0 - bed.eps_s) @ volume if self.closed else 0.0))

    def fields(self) -> dict[str, np.ndarray]:
        """Fields by name."""
        return {name: getattr(self, name) for name in FIELDS}

    def state(self) -> dict[str, Any]:
        """Everything that the next step depends on."""
        return {name: getattr(self, name).copy() for name in MEMORY} | {"p0": self.p0, "heat": dict(self.account)}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go back to a `state`, bit for bit."""
        for name in MEMORY:
            setattr(self, name, np.array(state[name]))
        self.p0, self.account = float(state["p0"]), dict(state["heat"])
        self._thin()

    def step(self, dt: float, volume_flux: np.ndarray) -> np.ndarray:
        """One step of `dt` [s] after the solids have moved and the gas with `volume_flux` (nf,) [m3/s]; leaves density
        and expansion with the bed and returns the mass flux of the gas over the usual density [m3/s].
        """
        bed, p, g = self.bed, self.physics, self.bed.grid.geometry
        rho_s, s, volume = bed.rho[1], bed.eps_s, g.volume
        gas, face_g = self._carried(dt, 0, volume_flux)
        solid, face_s = self._carried(dt, 1, bed.moved)
        net, moved_g, moved_s = (np.empty_like(s) for _ in range(3))
        kc.spread(g, solid, face_s, self.T_solid, net, moved_s)
        kc.spread(g, gas, face_g, self.T_gas, net, moved_g)
        self.mass = self.mass - dt * net / volume
        self._book(dt, gas, p.cp_gas * gas * face_g + p.cp_solid * solid * face_s)

        content = np.stack((p.cp_gas * self.mass * volume, p.cp_solid * rho_s * s * volume), axis=1)
        rates = np.stack((p.cp_gas * moved_g, p.cp_solid * moved_s), axis=1)
        self._warm_walls(dt, rates)
        coef = self._conduct(dt, content, rates)
        lift = _over(dt * rates, content)
        at_gas, at_solid = self._exchange(dt, content, lift)
        change, through = self._implicit(content, coef, lift, at_gas, at_solid)
        old = self.rho_T
        if self.closed:
            room = np.zeros_like(lift)
            room[:, 0] = (1.0 - s) * volume / content[:, 0]
            rise, further = self._fill(change, *self._implicit(content, coef, room, at_gas, at_solid))
            change, through = change + rise, through + further
        self.account["walls"] -= through
        if self.ideal:
            self._expand(dt, self.mass * change[:, 0], dt * moved_g / volume, 1.0 - old / self.rho_T)
        self._remember(dt, change, moved_g / (self.mass * volume), moved_s / (rho_s * (s + ks.EMPTY) * volume))
        self._thin()
        return gas / bed.rho[0] if self.ideal else volume_flux

    def _carried(self, dt: float, phase: int, flux: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mass flux [kg/s] and temperature on faces."""
        bed, g = self.bed, self.bed.grid.geometry
        T, lag, u = ((self.T_gas, self.lag_gas, bed.u_gas), (self.T_solid, self.lag_solid, bed.u_solid))[phase]
        column, ahead, face = T[:, None], np.empty((len(T), 1)), np.empty_like(flux)
        given, grad = self._slope(phase, T, self.enters[phase])
        kc.half_ahead(dt, column, grad, u, lag, ahead)
        kh.carried(g, flux, T, grad, ahead, given, bed.drained if phase else bed.undrained, face)
        if phase == 1 or not self.ideal:
            return bed.rho[phase] * flux, face
        return self.rho_T / face * flux, face

    def _slope(self, phase: int, T: np.ndarray, outside: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Temperature at boundaries, `outside` or level, and gradient (nc, 1, dim) of one phase."""
        bed = self.bed
        given = np.where(np.isnan(outside), T[bed.near], outside)
        grad = np.empty((len(T), 1, bed.grid.dimension))
        if phase == 0:
            kc.gradient(bed.grid.geometry, T[:, None], given[:, None], grad)
        else:
            kc.gradient_solid(bed.grid.geometry, bed.eps_s, T[:, None], given[:, None], grad)
        return given, grad

    def _warm_walls(self, dt: float, rates: np.ndarray) -> None:
        """Adds the flux that is given at walls; the phases share it by their fractions."""
        near, area = self.bed.near, self.bed.grid.geometry.area[self.bed.grid.interior :]
        s = self.bed.eps_s[near]
        np.add.at(rates, near, (self.flux * area)[:, None] * np.stack((1.0 - s, s), axis=1))
        self.account["walls"] += dt * float(self.flux @ area)

    def _conduct(self, dt: float, content: np.ndarray, rates: np.ndarray) -> np.ndarray | None:
        """Adds what is conducted now; returns what a kelvin more would conduct through each face in a step [J/K], None
        if that is little beside the `content` of the cells and need not be solved for.
        """
        if self.physics.conductivity is None:
            return None
        bed, g = self.bed, self.bed.grid.geometry
        k_gas, k_solid = self.physics.conductivity(bed.eps_s, self.T_gas, self.T_solid)
        side = bed.edge.solid._replace(kind=np.where(np.isnan(self.wall), boundary.WALL, boundary.GIVEN))
        edge = bed.edge._replace(theta=self.wall)
        # the few particles of a nearly empty cell hold too little heat to conduct any
        k_solid = k_solid * np.minimum(1.0, bed.eps_s / kc.FEW)
        coef = np.empty((len(g.left), 2))
        for phase, (k, T) in enumerate(((k_gas, self.T_gas), (k_solid, self.T_solid))):
            grad = self._slope(phase, T, self.wall)[1]
            out, one = np.zeros((len(T), 1)), np.empty((len(g.left), 1))
            ks.conduct(g, side, edge, k, T, grad, bed.grid.skewed, out, one)
            rates[:, phase] += out[:, 0]
            coef[:, phase] = dt * one[:, 0]
            # what cells give each other cancels in the sum
            self.account["walls"] += dt * float(out.sum())
        return coef if (self._links(coef) > EXPLICIT * content).any() else None

    def _links(self, coef: np.ndarray) -> np.ndarray:
        """Sums (nc, 2) of `coef` over the faces of each cell."""
        g = self.bed.grid.geometry
        count = len(g.volume)
        both = [np.bincount(g.left, one, count) + np.bincount(g.right, one[: len(g.right)], count) for one in coef.T]
        return np.stack(both, axis=1)

    def _exchange(self, dt: float, content: np.ndarray, lift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Adds the exchange at the present temperatures to the `lift` [K] of a step; returns dt times the rates at
        which each phase follows the other, weighed.
        """
        bed, p = self.bed, self.physics
        speed = np.empty_like(bed.eps_s)
        ks.slip_speed(bed.u_gas, bed.u_solid, speed)
        h = p.coefficient(bed.eps_s, speed, bed.dense, self.T_gas)
        of_solid = dt * 6.0 * h / (bed.materials.d_p * bed.rho[1] * p.cp_solid)
        of_gas = of_solid * content[:, 1] / content[:, 0]
        apart = self.T_solid - self.T_gas
        lift[:, 0] += of_gas * apart
        lift[:, 1] -= of_solid * apart
        z = of_gas + of_solid
        weight = np.where(z < SLOW, 0.5 + z / 12.0, 0.0)
        fast = z >= SLOW
        weight[fast] = -1.0 / np.expm1(-z[fast]) - 1.0 / z[fast]
        return weight * of_gas, weight * of_solid

    def _implicit(
        self, content: np.ndarray, coef: np.ndarray | None, lift: np.ndarray, at_gas: np.ndarray, at_solid: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Changes of the temperatures (nc, 2) [K] with implicit conduction and exchange, from the explicit `lift`; and
        the heat that the change drives out through walls [J].
        """
        through = 0.0
        if coef is not None:
            conducted = self._conjugate(content, coef, lift, at_gas, at_solid)
            # exchange follows exactly whatever the iteration has left
            lift = lift - _over(conducted, content)
            through = float(conducted.sum())
        return np.stack(two_phase(lift[:, 0], lift[:, 1], at_gas, at_solid), axis=1), through

    def _conjugate(self, content, coef, lift, at_gas, at_solid) -> np.ndarray:
        """What the changes conduct out of cells (nc, 2) [J], by conjugate gradients preconditioned with the two
        temperatures of a cell.
        """
        g, size = self.bed.grid.geometry, content.shape
        both, out = content[:, 0] * at_gas, np.empty(size)
        diagonal = content + both[:, None] + self._links(coef)
        diagonal[diagonal == 0.0] = 1.0  # no particles
        scale = 1.0 / (diagonal[:, 0] * diagonal[:, 1] - both**2)

        def product(x: np.ndarray) -> np.ndarray:
            x = x.reshape(size)
            kh.conducted(g, coef, x, out)
            return (content * x + out + both[:, None] * (x - x[:, ::-1])).ravel()

        def inverse(x: np.ndarray) -> np.ndarray:
            x = x.reshape(size)
            return (scale[:, None] * (diagonal[:, ::-1] * x + both[:, None] * x[:, ::-1])).ravel()

        n = content.size
        rhs = (content * lift).ravel()
        x, left = cg(
            LinearOperator((n, n), product),
            rhs,
            inverse(rhs),
            rtol=TOLERANCE,
            maxiter=ITERATIONS,
            M=LinearOperator((n, n), inverse),
        )
        if left:
            raise ConvergenceError(f"t = {self.bed.time:.6g} s: heat did not converge in {ITERATIONS} iterations")
        kh.conducted(g, coef, x.reshape(size), out)
        return out

    def _fill(self, change: np.ndarray, response: np.ndarray, through: float) -> tuple[np.ndarray, float]:
        """Sets p0 to what the gas fills a closed volume with; its change with that of the pressure, by the `response`
        to 1 Pa.
        """
        p, bed, volume = self.physics, self.bed, self.bed.grid.geometry.volume
        R = p.pressure / (bed.materials.rho_gas * p.T_reference)
        gas, pores = R * self.mass * volume, float((1.0 - bed.eps_s) @ volume)
        rise = (gas @ (self.T_gas + change[:, 0]) - self.p0 * pores) / (pores - gas @ response[:, 0])
        self.p0 += float(rise)
        return rise * response, rise * through

    def _expand(self, dt: float, gained: np.ndarray, carried: np.ndarray, compressed: float) -> None:
        """Expansion of the gas that the equation of pressure keeps in this step: what the heat of the last one made of
        it, and what was left open between mass, temperature and volume. `gained` is the change of mass times
        temperature over the step, `carried` the part of it that came with the gas, `compressed` the share of p0 that
        is new.
        """
        bed, pores, volume = self.bed, 1.0 - self.bed.eps_s, self.bed.grid.geometry.volume
        still_open = (self.mass * self.T_gas + gained) / self.rho_T - pores
        bed.sources.gas = (still_open + (gained - carried) / self.rho_T - compressed * pores) / dt
        if self.closed:
            bed.sources.gas -= bed.sources.gas @ volume / volume.sum()

    def _remember(self, dt: float, change: np.ndarray, *carried: np.ndarray) -> None:
        bed = self.bed
        for k, (T, lag) in enumerate(((self.T_gas, self.lag_gas), (self.T_solid, self.lag_solid))):
            lag[:, 0] = change[:, k] / dt - carried[k]
            T += change[:, k]
        if not (self.T_gas.min() > 0.0 and self.T_solid.min() > 0.0):
            bed.check_finite()
            raise ConvergenceError(f"t = {bed.time:.6g} s, step {bed.steps}: a temperature is not above 0 K")

    def _thin(self) -> None:
        """Density of the gas over the usual one."""
        if self.ideal:
            self.bed.dense = self.mass / (self.bed.rho[0] * (1.0 - self.bed.eps_s))

    def _book(self, dt: float, gas: np.ndarray, heat: np.ndarray) -> None:
        """What crossed the boundary in this step with the phases."""
        for name, rate in (("gas", gas[self.bed.grid.interior :]), ("heat", heat[self.bed.grid.interior :])):
            self.account[f"{name}_out"] += dt * float(np.sum(rate, where=rate > 0))
            self.account[f"{name}_in"] -= dt * float(np.sum(rate, where=rate < 0))


def _over(heat: np.ndarray, content: np.ndarray) -> np.ndarray:
    """heat/content, 0 where there is nothing."""
    return np.divide(heat, content, out=np.zeros_like(heat), where=content > 0.0)
