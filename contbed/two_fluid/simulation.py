"""The two-fluid model with kinetic theory of granular flow: state, steps, account.

    d eps_s/dt + div(eps_s u_s) = 0,   eps_g = 1 - eps_s,   div(eps_g u_g + eps_s u_s) = 0
    eps_g rho_g D u_g/dt = -eps_g grad p + div tau_g - beta (u_g - u_s) + eps_g rho_g g
    eps_s rho_s D u_s/dt = -eps_s grad p - grad p_s + div tau_s + beta (u_g - u_s) + eps_s rho_s g
    3/2 rho_s eps_s D theta/dt = -p_s div u_s + tau_s : grad u_s + div(k grad theta) - gamma - 3 beta theta

with p_s = rho_s eps_s theta (1 + 2 (1 + e) eps_s g0) and friction near packing (Gidaspow 1994, Multiphase Flow and
Fluidization, Academic Press). A step, in order: the solids move with one limited flux F that everything after uses;
velocities are convected and sheared; forces and drag act on faces, and one equation gives the pressure; cell velocities
follow from the faces; granular temperature moves with F. Drag, solids pressure, stress and granular temperature are
implicit; the step is bound by the Courant number alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid import boundary, limiter
from contbed.two_fluid import kernels_faces as kf
from contbed.two_fluid import kernels_fields as kc
from contbed.two_fluid import kernels_solid as ks
from contbed.two_fluid.grid import Grid
from contbed.two_fluid.pressure import Pressure
from contbed.two_fluid.rheology import Closures

ITERATIONS = 500
TOLERANCE = 1e-10
EXTENSIONS = 60  # rounds in which gradients extend initial fields to the walls
EXPLICIT = 0.1  # viscous exchange of a cell in a step, as share of its content, below which it is not solved for


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

    courant : largest share of a cell that a phase crosses in a step
    dt_max, dt_first [s] : largest and first step; growth : of the step at most
    limited : limit reconstructions; off keeps full order for smooth fields
    theta : "pde", "algebraic" (production balances dissipation) or "frozen"
    dt [s] : fixed step, instead of the Courant number
    """

    courant: float = 0.5
    dt_max: float = 1e-2
    dt_first: float = 1e-5
    growth: float = 1.1
    limited: bool = True
    theta: Literal["pde", "algebraic", "frozen"] = "pde"
    dt: float | None = None


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


FIELDS = ("eps_s", "u_gas", "u_solid", "theta", "p")


class TwoFluid:
    """State and steps of one bed.

    Parameters
    ----------
    grid : cells and faces
    materials, closures : of gas and particles
    boundaries : condition of each named boundary
    options : how to step

    Attributes
    ----------
    eps_s, theta, p (nc,), u_gas, u_solid (nc, dim) : fields in the order of the grid, set by `start`
    flux_solid, flux_total (nf,) [m3/s] : volume fluxes of the solids and of both phases from left to right
    time, dt, steps : now, the last step, and their number
    counters : how often a limiter or guard acted
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
        nb = nf - grid.interior
        self.pressure = Pressure(grid, not (self.edge.gas.kind == boundary.OUTLET).any())
        self.gravity = np.array(materials.gravity, dtype=float)
        self.rho = (materials.rho_gas, materials.rho_solid)
        self.sources = Sources(np.zeros(nc), np.zeros(nc), np.zeros((nc, dim)), np.zeros((nc, dim)), np.zeros(nc))
        self.eps_s, self.theta, self.p = np.zeros(nc), np.zeros(nc), np.zeros(nc)
        self.u_gas, self.u_solid = np.zeros((nc, dim)), np.zeros((nc, dim))
        self.flux_solid, self.flux_total = np.zeros(nf), np.zeros(nf)
        self.time, self.dt, self.steps = 0.0, 0.0, 0
        self.counters: dict[str, int] = dict.fromkeys(
            ("limited_faces", "limited_steps", "limiter_rounds", "theta_upwind_cells", "theta_clipped_cells"), 0
        )
        self.account = {"solid_in": 0.0, "solid_out": 0.0, "gas_in": 0.0, "gas_out": 0.0}

        # what the next step remembers of the last one
        self.lag_g, self.lag_s, self.lag_theta = np.zeros((nc, dim)), np.zeros((nc, dim)), np.zeros((nc, 1))
        self.force_g, self.force_s = np.zeros((nc, dim)), np.zeros((nc, dim))
        self.gain_eps, self.carried = np.zeros((nc, 1)), np.zeros((nc, 1))
        self.drag, self.stiffness = np.zeros(nc), np.zeros(nc)
        self.grad_p, self.grad_theta = np.zeros((nc, 3, dim)), np.zeros((nc, 1, dim))
        self.outflow = np.zeros((nc, 2))

        self._faces = np.zeros((nf, 8))
        self._slip, self._drained = np.zeros(nb), np.zeros(nc, dtype=np.bool_)
        self._none = np.zeros(nc, dtype=np.bool_)
        self._presence, self._all = np.ones(nf), np.ones(nf)
        self._speed = np.zeros(nc)

    # ------------------------------------------------------------------ start and state

    def start(self, **fields: Any) -> None:
        """Set fields (arrays or numbers) and find the fluxes that belong to them."""
        for name, value in fields.items():
            getattr(self, name)[...] = value
        self._evaluate()
        if self.grid.skewed:
            for _ in range(EXTENSIONS):
                self._slopes_of_forces(self.rheology.pressure * self.theta)
        kept = self.u_gas, self.u_solid
        grad = [np.zeros((*u.shape, u.shape[1])) for u in kept]
        self._faces_step(self.options.dt or self.options.dt_first, *kept, *grad)
        self.u_gas, self.u_solid = kept

    def state(self) -> dict[str, Any]:
        """Everything that the next step depends on."""
        kept = {name: getattr(self, name).copy() for name in _STATE}
        return kept | {"time": self.time, "dt": self.dt, "steps": self.steps} | {
            "counters": dict(self.counters), "account": dict(self.account)
        }  # fmt: skip

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go back to a `state`, bit for bit."""
        for name in _STATE:
            getattr(self, name)[...] = state[name]
        self.time, self.dt, self.steps = float(state["time"]), float(state["dt"]), int(state["steps"])
        self.counters, self.account = dict(state["counters"]), dict(state["account"])

    # ------------------------------------------------------------------ time

    def advance(self, end: float, callback: Callable[[TwoFluid], None] | None = None) -> None:
        """Step until `end` [s]; `callback` sees the state after each step.

        Raises
        ------
        ConvergenceError : a field is not finite; says where
        """
        while self.time < end * (1 - 1e-14):
            dt = min(self.next_step(), end - self.time)
            if self.time + 2 * dt > end > self.time + dt:
                dt = 0.5 * (end - self.time)
            self.step(dt)
            if callback is not None:
                callback(self)

    def next_step(self) -> float:
        """Length of the next step [s]."""
        o = self.options
        if o.dt is not None:
            return o.dt
        fastest = float(np.max(self.outflow[:, 0], initial=0.0))
        fastest = max(fastest, float(np.max(self.outflow[:, 1], where=self.eps_s > 1e-6, initial=0.0)))
        longest = min(o.dt_max, o.courant / fastest if fastest > 0 else np.inf)
        return min(longest, self.dt * o.growth if self.dt > 0 else o.dt_first)

    def step(self, dt: float) -> None:
        """One step of `dt` [s]."""
        g, m, edge, source = self.grid.geometry, self.materials, self.edge, self.sources
        rho_s = self.rho[1]
        eps_old, theta_old = self.eps_s, self.theta.copy()
        nc, nf = len(g.volume), len(g.left)

        # solids
        flux, new = self.flux_solid.copy(), np.empty(nc)
        coef, diagonal, rhs, y = np.empty((nf, 1)), np.empty((nc, 1)), np.empty((nc, 1)), np.empty((nc, 1))
        ks.compaction(g, dt, rho_s, self.stiffness, self.drag, flux, source.solid, coef, diagonal, rhs)
        self._check(kc.conjugate(g, coef, diagonal, rhs, y, TOLERANCE, ITERATIONS), "eps_s")
        ks.compact(g, dt, coef, y, flux)
        touched, rounds = limiter.limit(g, dt, eps_old, source.solid, m.eps_max, flux, new, self._drained)
        if touched:
            self.counters["limited_faces"] += int(touched)
            self.counters["limited_steps"] += 1
            self.counters["limiter_rounds"] += int(rounds)
        self._book(dt, flux)
        self.gain_eps = (new - eps_old).reshape(-1, 1) / dt
        self.eps_s = new
        gas = self.flux_total - flux

        # closures at the new fractions
        self._evaluate()
        r = self.rheology
        ks.wall_slip(g, edge.solid, edge, m.eps_max, rho_s, new, theta_old, r.g0, r.mu + r.mu_friction, self._slip)

        # convection and stress
        h_g, grad_g = self._momentum(dt, 0, gas, 1.0 - new)
        h_s, grad_s = self._momentum(dt, 1, flux, new)
        before = self.u_gas, self.u_solid

        # forces, drag, pressure
        divergence = self._faces_step(dt, h_g, h_s, grad_g, grad_s)

        # memory for the half step ahead
        for lag, u, last, grad in zip(
            (self.lag_g, self.lag_s), (self.u_gas, self.u_solid), before, (grad_g, grad_s), strict=True
        ):
            kc.advance_rate(last, grad, last, lag)
            lag += (u - last) / dt
        # granular temperature
        if self.options.theta != "frozen":
            self._theta(dt, flux, grad_s, divergence)
        self.time += dt
        self.dt = dt
        self.steps += 1
        self._check_finite()

    # ------------------------------------------------------------------ parts of a step

    def _evaluate(self) -> None:
        """Closures at the present state."""
        ks.slip_speed(self.u_gas, self.u_solid, self._speed)
        self.drag = self.closures.drag(self.eps_s, self._speed)
        self.rheology = self.closures.granular(self.eps_s, self.theta, self.drag)
        self.stiffness = self.rheology.stiffness

    def _edge_velocity(self, phase: int, eps: np.ndarray) -> np.ndarray:
        side = (self.edge.gas, self.edge.solid)[phase]
        u = (self.u_gas, self.u_solid)[phase]
        out = np.empty_like(side.u)
        kc.edge_velocity(self.grid.geometry, side, self._slip if phase else side.slip, u, eps, out)
        return out

    def _momentum(self, dt: float, phase: int, flux: np.ndarray, eps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Velocity of one phase after convection and stress, and its gradient before."""
        g, side, r = self.grid.geometry, (self.edge.gas, self.edge.solid)[phase], self.rheology
        u, lag = ((self.u_gas, self.lag_g), (self.u_solid, self.lag_s))[phase]
        slip = self._slip if phase else side.slip
        mu = r.mu + r.mu_friction if phase else np.full(len(eps), self.materials.mu_gas)
        bulk = r.bulk if phase else np.zeros(len(eps))
        given = self._edge_velocity(phase, eps)
        grad = np.empty((*u.shape, u.shape[1]))
        kc.gradient(g, u, given, grad)
        ahead = np.empty_like(u)
        kc.advance_rate(u, grad, u, ahead)
        ahead = 0.5 * dt * (lag - ahead)
        rhs = np.zeros_like(u)
        kc.convect(g, flux, u, grad, ahead, given, self.options.limited, self._drained if phase else self._none, rhs)
        rho = self.rho[phase]
        rhs *= rho
        rhs += (self.sources.force_gas, self.sources.force_solid)[phase] * (rho * eps * g.volume)[:, None]
        coef = np.empty((len(g.left), u.shape[1]))
        kc.stress(g, side, slip, mu, bulk, u, grad, given, rhs, coef)
        content = rho * (eps + ks.EMPTY) * g.volume / dt
        links = np.zeros_like(u)
        if self.grid.axisymmetric:
            kc.hoop_stress(g, mu, bulk, u, grad, rhs, links)
        kc.add_links(g, coef, links)
        diagonal = links + content[:, None]
        change = np.empty_like(u)
        force = (self.force_g, self.force_s)[phase]
        if (links <= EXPLICIT * content[:, None]).all():
            change = rhs / content[:, None]
        else:
            # with the last forces the change vanishes in a steady state, which the implicit part then leaves alone
            rhs += (dt * content)[:, None] * force
            name = ("u_gas", "u_solid")[phase]
            self._check(kc.conjugate(g, coef, diagonal, rhs, change, TOLERANCE, ITERATIONS), name)
            change -= dt * force
        return u + change, grad

    def _faces_step(self, dt, h_g, h_s, grad_g, grad_s) -> np.ndarray:
        """Forces, drag and pressure on faces; sets velocities, pressure and fluxes, returns div u_solid."""
        g, edge, s, r, faces = self.grid.geometry, self.edge, self.eps_s, self.rheology, self._faces
        skewed, limited = self.grid.skewed, self.options.limited
        nc, nf = len(s), len(g.left)
        dim = self.grid.dimension
        kinetic = r.pressure * self.theta
        if skewed:
            self._slopes_of_forces(kinetic)
            grad_g = grad_g + self._slopes(h_g - self.u_gas)
            grad_s = grad_s + self._slopes(h_s - self.u_solid)
        grad_eps = self._eps_gradient()
        carried = np.empty((nc, 1))
        kc.advance_rate(s.reshape(-1, 1), grad_eps, self.u_solid, carried)
        ahead = 0.5 * dt * (self.gain_eps + self.carried - carried).ravel()
        self.carried = carried
        coef, rhs = np.empty(nf), g.volume * (self.sources.solid + self.sources.gas)
        cells = (s, ahead, self.drag, kinetic, r.h, self.p)
        kf.predict(
            g, edge.gas, edge.solid, edge, dt, self.gravity, self.rho, cells, (h_g, h_s, self.u_gas, self.u_solid),
            (grad_eps, grad_g, grad_s, self.grad_p), skewed, limited, faces, coef, rhs,
        )  # fmt: skip
        self.p = self.pressure.solve(coef, rhs)
        divergence = np.empty(nc)
        kf.correct(
            g, edge.gas, edge.solid, edge, self.p, faces, coef,
            self.flux_solid, self.flux_total, self.outflow, divergence,
        )  # fmt: skip
        kf.presence(faces, self._presence)
        new = [np.empty((nc, dim)) for _ in range(4)]
        for phase, (weight, grad) in enumerate(((self._all, grad_g), (self._presence, grad_s))):
            u, before = new[2 * phase], new[2 * phase + 1]
            kf.gather(g, faces, phase, weight, grad, False, u)
            kf.gather(g, faces, 6 + phase, weight, grad, False, before)
            if skewed:
                # once more, with the slopes of H and of the change by forces
                change = self._slopes(u - before)
                kf.gather(g, faces, phase, weight, grad + change, True, u)
                kf.gather(g, faces, 6 + phase, weight, grad, True, before)
        kf.cell_velocities(dt, self.rho, s, self.drag, h_g, h_s, new[1], new[3], new[0], new[2])
        self.u_gas, self.u_solid = new[0], new[2]
        self.force_g, self.force_s = (new[0] - h_g) / dt, (new[2] - h_s) / dt
        return divergence

    def _slopes(self, u: np.ndarray) -> np.ndarray:
        """Gradient of a cell vector (nc, dim) that is level at the boundaries."""
        g = self.grid.geometry
        out = np.empty((*u.shape, u.shape[1]))
        kc.gradient(g, u, u[g.left[self.grid.interior :]], out)
        return out

    def _eps_gradient(self) -> np.ndarray:
        g, solid = self.grid.geometry, self.edge.solid
        values = self.eps_s.reshape(-1, 1)
        given = np.where(solid.kind == boundary.GIVEN, self.edge.eps_s, self.eps_s[g.left[self.grid.interior :]])
        out = np.empty((len(values), 1, self.grid.dimension))
        kc.gradient(g, values, given.reshape(-1, 1), out)
        return out

    def _slopes_of_forces(self, kinetic: np.ndarray) -> None:
        """Gradients of p, kinetic pressure and h for skewed meshes; the last ones extend the fields to the walls."""
        g = self.grid.geometry
        ni = self.grid.interior
        values = np.stack((self.p, kinetic, self.rheology.h), axis=1)
        inner = g.left[ni:]
        given = values[inner] + np.einsum("bkd,bd->bk", self.grad_p[inner], g.arm_left[ni:])
        outlet = self.edge.gas.kind == boundary.OUTLET
        given[outlet, 0] = self.edge.p[outlet]
        kc.gradient(g, values, given, self.grad_p)

    def _theta(self, dt: float, flux: np.ndarray, grad_s: np.ndarray, divergence: np.ndarray) -> None:
        """Granular temperature: convected with the solids flux, conducted, produced, dissipated."""
        g, edge, r, s, rho_s = self.grid.geometry, self.edge, self.rheology, self.eps_s, self.rho[1]
        old = self.theta
        made = np.empty(len(s))
        ks.production(g, r.mu, r.bulk, self.u_solid, grad_s, divergence, made)
        made += self.sources.theta
        sink = r.dissipation * np.sqrt(old) + 3.0 * self.drag * s
        if self.options.theta == "algebraic":
            self.theta = self._balanced(made, divergence)
            return
        values = old.reshape(-1, 1)
        inner = g.left[self.grid.interior :]
        given = np.where(edge.solid.kind == boundary.GIVEN, edge.theta, old[inner]).reshape(-1, 1)
        grad = np.empty((len(s), 1, self.grid.dimension))
        kc.gradient(g, values, given, grad)
        carried = np.empty((len(s), 1))
        kc.advance_rate(values, grad, self.u_solid, carried)
        ahead = 0.5 * dt * (self.lag_theta - carried)
        low, marked = self._drained.copy(), int(self._drained.sum())
        while True:
            rhs = np.zeros((len(s), 1))
            kc.convect(g, flux, values, grad, ahead, given, self.options.limited, low, rhs)
            negative = s * g.volume * old + dt * rhs[:, 0] < 0.0
            if not (negative & ~low).any():
                break
            low |= negative
            low[g.left[: len(g.right)][negative[g.right]]] = True
            low[g.right[negative[g.left[: len(g.right)]]]] = True
        self.counters["theta_upwind_cells"] += int(low.sum()) - marked
        rhs *= 1.5 * rho_s
        coef, diagonal = np.empty((len(g.left), 1)), np.zeros((len(s), 1))
        ks.conduct(g, edge.solid, edge, r.conductivity, old, grad, self.grid.skewed, rhs, coef)
        ks.theta_system(
            g, edge, edge.solid, self._slip, dt, rho_s, self.materials.eps_max, s, old, r.g0, sink,
            rho_s * r.pressure, divergence, made, self.u_solid, rhs, diagonal,
        )  # fmt: skip
        kc.add_links(g, coef, diagonal)
        change = np.empty((len(s), 1))
        self._check(kc.conjugate(g, coef, diagonal, rhs, change, TOLERANCE, ITERATIONS), "theta")
        self.theta = old + change[:, 0]
        below = self.theta < 0.0
        if below.any():
            self.counters["theta_clipped_cells"] += int(below.sum())
            self.theta[below] = 0.0
        self.lag_theta = carried + (self.theta - old).reshape(-1, 1) / dt

    def _balanced(self, made: np.ndarray, divergence: np.ndarray) -> np.ndarray:
        """Granular temperature at which production balances dissipation, a quadratic for its square root."""
        r, s, rho_s = self.rheology, self.eps_s, self.rho[1]
        root = np.sqrt(self.theta)
        factor = np.where(root > 0, made / np.maximum(root, 1e-150), 0.0)
        linear = rho_s * r.pressure * divergence + 3.0 * self.drag * s
        y = 2.0 * factor / (linear + np.sqrt(linear**2 + 4.0 * r.dissipation * factor) + 1e-300)
        return np.maximum(y, 0.0) ** 2

    def _book(self, dt: float, flux: np.ndarray) -> None:
        """What crossed the boundary in this step [m3]."""
        ni = self.grid.interior
        solid = flux[ni:]
        gas = self.flux_total[ni:] - solid
        for name, rate in (("solid", solid), ("gas", gas)):
            self.account[f"{name}_out"] += dt * float(np.sum(rate, where=rate > 0))
            self.account[f"{name}_in"] -= dt * float(np.sum(rate, where=rate < 0))

    def _check(self, iterations: int, name: str) -> None:
        if iterations < 0:
            self._check_finite()
            raise ConvergenceError(
                f"t = {self.time:.6g} s, step {self.steps}: {name} did not converge in {ITERATIONS} iterations; "
                "reduce the Courant number"
            )

    def _check_finite(self) -> None:
        for name in FIELDS:
            values = getattr(self, name)
            wrong = ~np.isfinite(values)
            if wrong.any():
                cell = int(np.flatnonzero(wrong.reshape(len(values), -1).any(axis=1))[0])
                x = ", ".join(f"{v:.4g}" for v in self.grid.centres[cell])
                number = int(self.grid.cells[cell])
                raise ConvergenceError(
                    f"t = {self.time:.6g} s, step {self.steps}: {name} is not finite in cell {number} at ({x}) m; "
                    "reduce the Courant number, or look at the closures and boundaries there"
                )


_STATE = (
    *FIELDS, "flux_solid", "flux_total", "lag_g", "lag_s", "lag_theta", "force_g", "force_s", "gain_eps", "carried", "drag", "stiffness",
    "grad_p", "grad_theta", "outflow",
)  # fmt: skip
