"""One step of the two-fluid model.

The solids move with one limited volume flux F that everything after uses; velocities are convected and sheared; forces
and drag act on faces, and one equation gives the pressure; cell velocities follow from the faces; granular temperature
moves with F. Drag, solids pressure, stress and granular temperature are implicit; the step is bound by the Courant
number of the particles, as gas that is faster carries its velocity in several passes, and by the heat of compression.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid import boundary, granular_temperature
from contbed.two_fluid import kernels_faces as kf
from contbed.two_fluid import kernels_solid as ks
from contbed.two_fluid import stress as kt
from contbed.two_fluid.fv import gradient as kc
from contbed.two_fluid.fv import limiter
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.linear import cg as kl
from contbed.two_fluid.pressure import Pressure
from contbed.two_fluid.rheology import Closures

if TYPE_CHECKING:
    from contbed.two_fluid.heat.equations import Heat

ITERATIONS = 500
TOLERANCE = 1e-7  # of the systems of one field; fluxes are made from what was found, and keep what they carry
TANGENTS = 8  # of friction that a step tries at most
EXTENSIONS = 60  # rounds in which gradients extend initial fields to the walls
EXPLICIT = 0.1  # exchange of a cell in a step, as share of its content, below which it is not solved for
PASSES, CROSSED = 4, 0.9  # in which the velocity of the gas is carried at most; share of a cell that it crosses in each
RARE = 1e-8  # fraction below which particles exchange nothing with other cells but by moving
FIELDS = ("eps_s", "u_gas", "u_solid", "theta", "p")


@dataclass(frozen=True)
class Materials:
    """Densities [kg/m3], gas viscosity [Pa s], particle diameter [m], densest packing, gravity [m/s2]."""

    rho_gas: float
    mu_gas: float
    rho_solid: float
    d_p: float
    eps_max: float
    gravity: tuple[float, ...]


@dataclass(frozen=True)
class Options:
    """How to step.

    courant : largest share of a cell that particles cross in a step; with heat, either phase
    dt_max, dt_first [s] : largest and first step; growth : of the step at most
    dt [s] : fixed step, instead of the Courant number
    order : in time, 1 or 2; a step of order 2 extrapolates from one step and two halves, and costs three; where a limit
        acts it does not, and is counted
    limited : limit reconstructions; off keeps full order for smooth fields
    theta : "pde", "algebraic" (production balances dissipation) or "frozen"
    """

    courant: float = 0.5
    dt_max: float = 1e-2
    dt_first: float = 1e-5
    growth: float = 1.1
    dt: float | None = None
    order: Literal[1, 2] = 1
    limited: bool = True
    theta: Literal["pde", "algebraic", "frozen"] = "pde"


@dataclass
class Sources:
    """Sources per volume, zero unless set: of solids and gas volume [1/s], accelerations (nc, dim) [m/s2] of both
    phases, and granular energy [W/m3].
    """

    solid: np.ndarray
    gas: np.ndarray
    force_gas: np.ndarray
    force_solid: np.ndarray
    theta: np.ndarray


class Stepper:
    """Fields and the step of first order; `simulation.TwoFluid` adds time, account and restart.

    The fields are in the order of the grid. `flux_solid` and `flux_total` (nf,) [m3/s] are the volume fluxes of the
    solids and of both phases that the next step starts with, `moved` the solids flux of the last step after limits.
    What else a step remembers of the last one: `lag_*`, rates of change less convection; `force_*`, accelerations;
    `drag` and `stiffness`; `grad_p`, gradients of p, solids pressure and what drives resting particles, on skewed
    meshes; `outflow` for the Courant number and `adiabatic` [1/s] for what compression heats. `heat` is None for an
    isothermal bed; `dense` is the density of the gas over that of `materials`. `near` are the cells at boundary faces,
    `drained` those that the limiter marked, `undrained` marks none; `pull` [N] is the force of the walls on gas and
    solids along the last axis; `faces` (nf, 8) what kernels_faces.py knows of each face, `slip` that of the particles
    at walls, `work` [W] of the last stress.
    """

    def __init__(
        self,
        grid: Grid,
        materials: Materials,
        closures: Closures,
        boundaries: Mapping[str, boundary.Condition],
        options: Options | None = None,
    ):
        self.grid, self.materials, self.closures = grid, materials, closures
        self.options = options if options is not None else Options()
        self.edge = boundary.assemble(grid, boundaries, materials.rho_solid)
        g = grid.geometry
        nc, nf, dim = len(g.volume), len(g.left), grid.dimension
        self.pressure = Pressure(grid, not (self.edge.gas.kind == boundary.OUTLET).any())
        self.gravity = np.array(materials.gravity, dtype=float)
        # nothing flows through, so that at rest the volume flux is zero
        across = g.normal[grid.interior :] @ self.gravity
        self.closed = bool(across.any() and (self.edge.gas.kind == boundary.WALL).all())
        self.rho = (materials.rho_gas, materials.rho_solid)
        self.sources = Sources(np.zeros(nc), np.zeros(nc), np.zeros((nc, dim)), np.zeros((nc, dim)), np.zeros(nc))
        self.eps_s, self.theta, self.p = np.zeros(nc), np.zeros(nc), np.zeros(nc)
        self.u_gas, self.u_solid = np.zeros((nc, dim)), np.zeros((nc, dim))
        self.flux_solid, self.flux_total, self.moved = np.zeros(nf), np.zeros(nf), np.zeros(nf)
        self.lag_g, self.lag_s = np.zeros((nc, dim)), np.zeros((nc, dim))
        self.lag_eps, self.lag_theta = np.zeros((nc, 1)), np.zeros((nc, 1))
        self.force_g, self.force_s = np.zeros((nc, dim)), np.zeros((nc, dim))
        self.drag, self.stiffness = np.zeros(nc), np.zeros(nc)
        self.grad_p, self.own = np.zeros((nc, 3, dim)), np.zeros(nf)
        self.outflow, self.adiabatic = np.zeros((nc, 2)), 0.0
        self.heat: Heat | None = None
        self.dense: float | np.ndarray = 1.0
        self.time, self.steps = 0.0, 0
        names = (
            "limited_faces",
            "limited_steps",
            "limiter_rounds",
            "packing_rounds",
            "first_order_steps",
            "theta_upwind_cells",
            "theta_clipped_cells",
        )
        self.counters = dict.fromkeys(names, 0)

        self.faces, self._moment = np.zeros((nf, 8)), np.zeros((nc, dim, dim))
        self.slip, self._push = np.zeros(nf - grid.interior), np.zeros(nf)
        self.pull = np.zeros(2)
        self.drained, self.undrained = np.zeros(nc, dtype=np.bool_), np.zeros(nc, dtype=np.bool_)
        self._resting = np.zeros(nc, dtype=np.bool_)
        self._mu_gas, self._bulk_gas = np.full(nc, materials.mu_gas), np.zeros(nc)
        self.near = g.left[grid.interior :]

    def settle_fluxes(self, dt: float) -> None:
        """Fluxes and pressure that belong to the fields, as after a step of `dt` [s] without convection."""
        self._evaluate()
        if self.grid.skewed:
            for _ in range(EXTENSIONS):
                self._slopes_of_forces(self.rheology.pressure * self.theta)
        kept = self.u_gas, self.u_solid
        grad = [np.zeros((*u.shape, u.shape[1])) for u in kept]
        self._forces(dt, *kept, *grad)
        self.u_gas, self.u_solid = kept
        self.force_g, self.force_s = np.zeros_like(kept[0]), np.zeros_like(kept[0])
        self.own[:] = 0.0

    def substep(self, dt: float) -> None:
        """One step of first order in time, `dt` [s] long."""
        g = self.grid.geometry
        u_gas, u_solid = self.u_gas, self.u_solid
        gas = self._move_solids(dt)
        if self.heat is not None:
            gas = self.heat.step(dt, gas)
        self._evaluate()
        r = self.rheology
        rate = self.shear_rate() if self.closures.sheared else self.eps_s
        self.mu_friction = self.closures.friction(r.p_friction, rate)
        shear = r.mu + self.mu_friction
        ks.wall_slip(
            g,
            self.edge.solid,
            self.edge,
            self.materials.eps_max,
            self.rho[1],
            self.eps_s,
            self.theta,
            r.g0,
            shear,
            self.slip,
        )
        passes = max(1, int(np.ceil(dt * self.outflow[:, 0].max() / CROSSED * (1.0 - 1e-9))))
        h_g, grad_g, carried_g = self._velocity(dt, 0, gas, 1.0 - self.eps_s, self._mu_gas, self._bulk_gas, passes)
        h_s, grad_s, carried_s = self._velocity(dt, 1, self.moved, self.eps_s, shear, r.bulk, 1)
        ks.recoil(g, self._push, self.materials.eps_max, self.eps_s, h_s)
        self._forces(dt, h_g, h_s, grad_g, grad_s)
        self.lag_g = (self.u_gas - u_gas) / dt - carried_g
        self.lag_s = (self.u_solid - u_solid) / dt - carried_s
        if self.options.theta != "frozen":
            granular_temperature.step(self, dt)

    def _move_solids(self, dt: float) -> np.ndarray:
        """eps_s after the step and the flux `moved` that leads there; returns the volume flux of the gas."""
        g, old, new, source = self.grid.geometry, self.eps_s, np.empty_like(self.eps_s), self.sources.solid
        size = (len(old), 1)
        coef, content, rhs = np.empty((len(g.left), 1)), np.empty(size), np.empty(size)
        flux = self.flux_solid.copy()
        ks.compaction(g, dt, self.rho[1], self.stiffness, self.drag, old, flux, source, coef, content, rhs)
        # everywhere: beside a front, the faint trace that it sends ahead keeps nearly empty cells smooth
        near, shift = np.zeros(size), np.zeros(len(old))
        y = self.solve(coef, near, content, rhs, "eps_s", 0.0)
        for _ in range(TANGENTS):
            if not ks.repack(g, self.closures.packing, old, self.stiffness, near, y, content, rhs, shift):
                break
            self.counters["packing_rounds"] += 1
            y = self.solve(coef, np.zeros(size), content, rhs, "eps_s", 0.0)
        ks.compact(g, dt, coef, content, y, flux, self._push)
        touched, rounds = limiter.limit(g, dt, old, source, self.materials.eps_max, flux, new, self.drained)
        if touched:
            self.counters["limited_faces"] += int(touched)
            self.counters["limited_steps"] += 1
            self.counters["limiter_rounds"] += int(rounds)
        self.lag_eps = self.lag_eps + (new - old).reshape(-1, 1) / dt
        self.eps_s, self.moved = new, flux
        return self.flux_total - flux

    def _evaluate(self) -> None:
        """Closures at the present state."""
        speed = np.empty_like(self.eps_s)
        ks.slip_speed(self.u_gas, self.u_solid, speed)
        # the slip acts through a Reynolds number with the density of `materials`
        self.drag = self.closures.drag(self.eps_s, speed * self.dense)
        r = self.closures.granular(self.eps_s, self.theta, self.drag)
        self.stiffness = r.stiffness
        # the few particles of a nearly empty cell do not push, shear or conduct
        dense = self.eps_s / (self.eps_s + RARE)
        faded = {name: getattr(r, name) * dense for name in ("pressure", "mu", "bulk", "conductivity")}
        self.rheology = r._replace(**faded)

    def shear_rate(self) -> np.ndarray:
        """Square root of the second invariant of the particles' strain rate [1/s]; Johnson and Jackson's walls slip."""
        g, u = self.grid.geometry, self.u_solid
        given, grad = np.empty_like(self.edge.solid.u), np.empty((*u.shape, u.shape[1]))
        kc.edge_velocity(g, self.edge.solid, np.abs(self.edge.solid.slip), u, self.eps_s, given)
        kc.gradient_solid(g, self.eps_s, u, given, grad)
        ring = u[:, 0] / g.radius if self.grid.axisymmetric else np.zeros(len(u))
        strain = 0.5 * (grad + grad.transpose(0, 2, 1))
        trace = np.einsum("cii->c", strain) + ring
        return np.sqrt(0.5 * np.maximum(np.einsum("cij,cij->c", strain, strain) + ring**2 - trace**2 / 3.0, 0.0))

    def _velocity(self, dt, phase, flux, eps, mu, bulk, passes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Velocity of one phase after convection, in so many passes, and stress; its gradient before; and the rate at
        which it was carried.
        """
        g, rho = self.grid.geometry, self.rho[phase]
        if phase == 0:
            side, slip, u, lag, force = self.edge.gas, self.edge.gas.slip, self.u_gas, self.lag_g, self.force_g
            source, low = self.sources.force_gas, self.undrained
        else:
            side, slip, u, lag, force = self.edge.solid, self.slip, self.u_solid, self.lag_s, self.force_s
            source, low = self.sources.force_solid, self.drained
        given, grad, ahead = np.empty_like(side.u), np.empty((*u.shape, u.shape[1])), np.empty_like(u)
        kc.edge_velocity(g, side, slip, u, eps, given)
        if phase == 0:
            kc.gradient(g, u, given, grad)
        else:
            kc.gradient_solid(g, eps, u, given, grad)
        rhs, links, coef = np.zeros_like(u), np.zeros_like(u), np.empty((len(g.left), u.shape[1]))
        dense, content = self.dense if phase == 0 else 1.0, np.empty_like(u)
        volume = ((eps * dense + ks.EMPTY) * g.volume)[:, None]
        v, slopes, part = u, grad, dt / passes
        for k in range(passes):
            if k > 0:
                # the last forces go along, so that a steady flow stays as it is
                v = u + part * (rhs / volume + k * (source + force))
                slopes = np.empty_like(grad)
                kc.gradient(g, v, given, slopes)
            kc.half_ahead(part, v, slopes, v, lag, ahead)
            kc.convect(g, flux, v, slopes, ahead, given, self.options.limited, low, rhs)
        rhs /= passes
        carried = rhs / volume
        # with the last forces the change vanishes in a steady state, which the implicit part then leaves alone
        kc.momentum(dt, rho, rho / dt * volume[:, 0], source, force, rhs, content)
        self.work = np.zeros(len(eps))
        kt.stress(g, side, slip, eps, mu, bulk, u, grad, given, rhs, coef, self.work)
        if self.grid.axisymmetric:
            kt.hoop_stress(g, mu, bulk, u, grad, rhs, links, self.work)
        change = self.solve(coef, links, content, rhs, ("u_gas", "u_solid")[phase])
        walls = side.kind == boundary.WALL
        gone = side.u - (u + change)[self.near]
        self.pull[phase] = np.sum(coef[self.grid.interior :, -1] * gone[:, -1], where=walls)
        return u + change - dt * force, grad, carried

    def _forces(self, dt, h_g, h_s, grad_g, grad_s) -> None:
        """Forces, drag and pressure on faces; sets velocities, pressure and fluxes."""
        g, edge, s, faces, skewed = self.grid.geometry, self.edge, self.eps_s, self.faces, self.grid.skewed
        kinetic = self.rheology.pressure * self.theta
        if skewed:
            self._slopes_of_forces(kinetic)
            grad_g = grad_g + self._slopes(h_g - self.u_gas, 0)
            grad_s = grad_s + self._slopes(h_s - self.u_solid, 1)
        cells = s, self.drag, kinetic, self.rheology.h, self.p, self._resting
        vectors = h_g, h_s, self.u_gas, self.u_solid
        gradients = (grad_g, grad_s, self.grad_p)
        rho = (np.broadcast_to(self.rho[0] * self.dense, s.shape), self.rho[1])
        kf.predict(
            g, edge.gas, edge.solid, edge, dt, self.gravity, rho, cells, vectors, gradients, skewed, self.own, faces
        )
        column = s.reshape(-1, 1)
        grad_eps, ahead = np.empty((len(s), 1, self.grid.dimension)), np.empty((len(s), 1))
        given = np.where(edge.solid.kind == boundary.GIVEN, edge.eps_s, s[self.near])
        kc.gradient(g, column, given.reshape(-1, 1), grad_eps)
        kc.half_ahead(dt, column, grad_eps, self.u_solid, self.lag_eps, ahead)
        kc.fractions(g, edge.gas, edge.solid, edge, s, grad_eps, ahead, self.options.limited, faces)
        if self.closed:
            kf.stratify(g, dt, self.gravity, rho, s, faces)
        coef, rhs = np.empty(len(g.left)), g.volume * (self.sources.solid + self.sources.gas)
        kf.assemble(g, edge.gas, edge.solid, edge, faces, coef, rhs)
        self.p = self.pressure.solve(coef, rhs, self.p)
        kf.correct(g, edge.gas, edge.solid, edge, self.p, faces, self.flux_solid, self.flux_total, self.outflow)
        if self.closed:
            # layers follow buoyancy within a step: on what faces carried its waves would grow, for N dt of about 1
            self.lag_eps = self.lag_eps - 2.0 / dt * ahead
        else:
            net, carried = np.empty_like(s), np.empty_like(s)
            kc.spread(g, faces[:, 1] * g.area, faces[:, 5], s, net, carried)
            self.lag_eps = -(carried / g.volume)[:, None]
        new_g, old_g, new_s, old_s = (np.empty_like(h_g) for _ in range(4))
        kf.gather_gas(g, faces, grad_g, grad_g, False, new_g, old_g)
        kf.gather_solid(g, faces, s, grad_s, grad_s, False, self._moment, new_s, old_s)
        self.force_g, self.force_s = np.empty_like(h_g), np.empty_like(h_s)
        velocities = h_g, h_s, old_g, old_s, new_g, new_s, self.force_g, self.force_s
        if skewed:
            # once more, with the slopes of H and of what became of it
            kf.cell_velocities(dt, rho, s, self.drag, *velocities)
            change_g, change_s = self._slopes(new_g - h_g, 0), self._slopes(new_s - h_s, 1)
            kf.gather_gas(g, faces, grad_g + change_g, grad_g, True, new_g, old_g)
            kf.gather_solid(g, faces, s, grad_s + change_s, grad_s, True, self._moment, new_s, old_s)
            grad_g = grad_g + self._slopes(new_g - h_g, 0)
        kf.remember(g, edge.gas, faces, new_g, grad_g, skewed, self.own)
        kf.cell_velocities(dt, rho, s, self.drag, *velocities)
        self.u_gas, self.u_solid = new_g, new_s

    def _slopes(self, u: np.ndarray, phase: int) -> np.ndarray:
        """Gradient of a cell vector (nc, dim) of a phase that is level at the boundaries."""
        out, g = np.empty((*u.shape, u.shape[1])), self.grid.geometry
        if phase == 0:
            kc.gradient(g, u, u[self.near], out)
        else:
            kc.gradient_solid(g, self.eps_s, u, u[self.near], out)
        return out

    def _slopes_of_forces(self, kinetic: np.ndarray) -> None:
        """Gradients of p, kinetic pressure and what drives resting particles, for skewed meshes; the last ones extend
        the first two to the walls.
        """
        g, outlet = self.grid.geometry, self.edge.gas.kind == boundary.OUTLET
        values = np.stack((self.p, kinetic), axis=1)
        arm = g.arm_left[self.grid.interior :]
        given = values[self.near] + np.einsum("bkd,bd->bk", self.grad_p[self.near, :2], arm)
        given[outlet, 0] = self.edge.p[outlet]
        grad, drive = np.empty((*values.shape, arm.shape[1])), np.empty((len(values), 1, arm.shape[1]))
        kc.gradient(g, values, given, grad)
        kc.gradient_drive(g, self.rheology.h, self.p / self.rho[1], self.gravity, drive, self._resting)
        self.grad_p = np.concatenate((grad, drive), axis=1)

    def solve(self, coef, links, content, rhs, name: str, explicit: float = EXPLICIT) -> np.ndarray:
        """A symmetric system, see kernels_linear.py."""
        x, g = np.empty_like(rhs), self.grid.geometry
        if kl.solve(g, coef, links, content, rhs, explicit, TOLERANCE, ITERATIONS, x) < 0:
            self.check_finite()
            raise ConvergenceError(
                f"t = {self.time:.6g} s, step {self.steps}: {name} did not converge in {ITERATIONS} iterations; "
                "reduce the Courant number"
            )
        return x

    def fields(self) -> dict[str, np.ndarray]:
        """Fields by name, in the order of the grid."""
        found = {name: getattr(self, name) for name in FIELDS}
        return found if self.heat is None else found | self.heat.fields()

    def check_finite(self) -> None:
        """Raise ConvergenceError where a field is not finite, with its name, the cell and its place."""
        for name, values in self.fields().items():
            if not np.isfinite(values.sum()) and (wrong := ~np.isfinite(values)).any():
                cell = int(np.flatnonzero(wrong.reshape(len(values), -1).any(axis=1))[0])
                place = ", ".join(f"{v:.4g}" for v in self.grid.centres[cell])
                number = int(self.grid.cells[cell])
                raise ConvergenceError(
                    f"t = {self.time:.6g} s, step {self.steps}: {name} is not finite in cell {number} at ({place}) m; "
                    "reduce the Courant number, or look at the closures and boundaries there"
                )
