"""Gas between the particles: momentum and energy on a coarse grid, porosity-weighted
projection, implicit drag.

With eps the porosity, u the intrinsic velocity, q = eps u, and sums over the particles
i in a volume V (model A):

    d(eps rho)/dt + div(rho q) = 0
    eps rho (du/dt + u.grad u) = -eps grad p - sum f_i/V + eps mu lap u + eps rho g
    d(eps rho h)/dt + div(rho h q) = div(k_eff grad T) + sum h_i A_i (T_i - T)/V,  k_eff = (1 - sqrt(1 - eps)) k
    f_i = beta_i V_i/(1 - eps_i) (u - v_i),   force on a particle: f_i - V_i grad p

Drag is that of q at the particle, which is continuous where the porosity jumps, at the
particle's own porosity. It is implicit in u, diagonal on faces, and what the particles
get is what the gas gives, to rounding: a particle's weights on the faces give its drag
to the gas, its velocity to the particle, and its volume to the porosity in -eps grad p.
Pressure holds the volume: a cell's mass and enthalpy need, at the pressure of the
fluid, as much room as there is, so that heat expands the gas (low Mach number), and
what a step misses the next one corrects. Mass and enthalpy are advanced by their fluxes
alone and are conserved to rounding.

The inlet is below, with a mass flux and a temperature for every column; p = 0 above;
sides slip, stick or are periodic. Particles above the grid feel no gas, nor does it
feel them; those that cross its top count with the part below it. A jet is a slot of the
inlet: `gas.inlet(background, T, slot=(x0, x1), slot_velocity=..., slot_T=...)`. Steps
are explicit in convection: `courant` should stay below one, which `coupling.Bed` sees
to.

Source: Zhou, Kuang, Chu, Yu 2010, J. Fluid Mech. 661, 482-510,
    doi:10.1017/S002211201000306X (model A); k_eff:
Syamlal and Gidaspow 1985, as in Patil, Peters, Kuipers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem import kernels
from contbed.cfd_dem.gas_quantities import Drag, Local, Motion, Places, Prediction
from contbed.cfd_dem.grid import INLET, INNER, OUTLET, Grid
from contbed.cfd_dem.pressure import Pressure
from contbed.errors import ConvergenceError, SceneError

# of a cell or a face; lower ones, of overlapping spheres on small cells, are counted
# and raised
MIN_POROSITY = 0.2
# at a particle; one that is hardly in the gas leaves less in its cells, and drag is
# beta/(1 - eps)
MIN_SOLIDS = 1e-12
# from enthalpy to temperature; a step of 100 K in air of 300 to 1500 K leaves 3e-15 of
# T
NEWTON_ITERATIONS = 3
_STATE = ("u", "q", "p", "eps", "mass", "heat", "T", "inlet_mass", "inlet_T")


class Gas:
    """State and steps of the gas.

    Parameters
    ----------
    grid : cells
    fluid : from `contbed.materials`
    drag : a closure of kind "drag", called with Re, eps, d_p, mu
    nusselt : a closure of kind "nusselt", called with the arguments it names; None: no
        energy equation
    T : initial temperature [K]
    isothermal : no energy equation in spite of `nusselt`, which then only gives
        coefficients
    gravity [m/s2] (3,)
    no_slip : sides stick
    tolerance : largest residual of the pressure equation over its largest right-hand
        side

    Attributes: intrinsic and superficial velocity `u`, `q` (f,) [m/s]; `p` [Pa],
        `T` [K], `eps`, `mass` [kg] and `heat`
    [J] of the cells; `given` (f,) force on the particles [N]; `sums` of mass and heat
    that entered and left and heat gained from the particles; `counts` of steps,
    iterations, porosities below MIN_POROSITY.
    """

    def __init__(
        self,
        grid: Grid,
        fluid: Any,
        drag: Callable[..., Any],
        nusselt: Callable[..., Any] | None = None,
        T: float = 300.0,
        isothermal: bool = False,
        gravity: Any = (0.0, 0.0, -9.81),
        no_slip: bool = False,
        tolerance: float = 1e-7,
    ):
        self.grid, self.fluid, self.drag, self.nusselt = grid, fluid, drag, nusselt
        self.energy = nusselt is not None and not isothermal
        self.gravity, self.no_slip = np.array(gravity, dtype=float), bool(no_slip)
        self.tolerance, self._pressure = float(tolerance), Pressure(grid)
        faces = len(grid.face_kind)
        self._base = float(fluid.enthalpy(T))
        # of a partial function, which carries options, the sheet is that of its
        # function
        law: Any = getattr(nusselt, "func", nusselt)
        known = set(Local.__dataclass_fields__)
        self._names = (
            ()
            if law is None
            else tuple(name for name in law.sheet.arguments if name in known)
        )
        self._area, self._below = grid.area[grid.face_axis], grid.face_kind == INLET
        self.open_volume = np.where(grid.open_cells, grid.volume, 0.0)
        self.inlet_mass, self.inlet_T = np.zeros(faces), np.full(faces, np.nan)
        self.inlet_T[self._below] = T
        self.u, self.q, self.p = np.zeros(faces), np.zeros(faces), np.zeros(grid.cells)
        self.T, self.eps = np.full(grid.cells, float(T)), np.ones(grid.cells)
        self.mass, self.heat = self.density * self.open_volume, np.zeros(grid.cells)
        self.started = False
        self.sums = dict.fromkeys(
            ("mass_in", "mass_out", "heat_in", "heat_out", "gained"), 0.0
        )
        self.counts = {"raised": 0, "iterations": 0, "steps": 0}

    @property
    def density(self) -> Array:
        """Of the gas in each cell [kg/m3]."""
        return self._on_cells(self.fluid.density)

    @property
    def courant(self) -> float:
        """Largest share of a cell that the gas crosses in a second [1/s], at an
        inlet that has changed as well.
        """
        grid, speed, below = self.grid, np.abs(self.u), self._below
        porosity = kernels.face_means(self.eps, grid.face_cell[below])
        entering = self.inlet_mass[below] / (
            self.fluid.density(self.inlet_T[below]) * porosity
        )
        speed[below] = np.maximum(speed[below], entering)
        return float(np.max(speed / grid.size[grid.face_axis]))

    @property
    def pressure_drop(self) -> float:
        """Mean pressure at the inlet [Pa], from the two lowest cells of every open
        column.
        """
        p = self.p.reshape(self.grid.count)
        low = (
            1.5 * p[:, :, 0] - 0.5 * p[:, :, 1]
            if self.grid.count[2] > 1
            else p[:, :, 0]
        )
        return float(low[self.grid.open_cells.reshape(self.grid.count)[:, :, 0]].mean())

    def inlet(
        self,
        velocity: float,
        T: float,
        slot: tuple[float, float] | None = None,
        slot_velocity: float = 0.0,
        slot_T: float | None = None,
    ) -> None:
        """Set superficial velocity [m/s] and temperature [K] at the inlet; in a slot x0
        to x1 [m] those of a jet.

        Columns that the slot covers in part get both streams, mixed by mass, and by
        enthalpy to first order in T.
        """
        grid, faces = self.grid, self.grid.bottom
        main = self.fluid.density(T) * velocity
        flux, warmth = np.full(faces.shape, main), np.full(faces.shape, main * T)
        if slot is not None:
            jet = T if slot_T is None else slot_T
            edges = grid.lower[0] + np.arange(grid.count[0] + 1) * grid.size[0]
            share = (
                np.clip(
                    np.minimum(edges[1:], slot[1]) - np.maximum(edges[:-1], slot[0]),
                    0.0,
                    None,
                )
                / grid.size[0]
            )
            if not share.any():
                raise SceneError(
                    f"gas: the slot from {slot[0]:g} to {slot[1]:g} m is outside of "
                    "the bed"
                )
            strong = self.fluid.density(jet) * slot_velocity
            flux += share[:, None] * (strong - flux)
            warmth += share[:, None] * (strong * jet - warmth)
        self.inlet_mass[faces] = np.where(grid.face_kind[faces] == INLET, flux, 0.0)
        self.inlet_T[faces] = np.divide(
            warmth, flux, out=np.full(faces.shape, float(T)), where=flux != 0.0
        )

    def start(self, bed: Motion) -> None:
        """Fill the room between the particles with gas that rises everywhere with
        the mean superficial velocity.
        """
        grid = self.grid
        where, share, inside = grid.shares(bed.x, bed.radius)
        self.eps, _ = self._porosity(bed.volume * inside, where, share)
        self.mass = self.density * self.eps * self.open_volume
        self.heat = self.mass * (self._on_cells(self.fluid.enthalpy) - self._base)
        self.q = np.where(
            grid.active & (grid.face_axis == 2),
            self.inlet_mass[grid.bottom].mean(),
            0.0,
        )
        self.q /= self._on_faces(self.density)
        self.u = self.q / kernels.face_means(self.eps, grid.face_cell)
        self.started = True

    def step(
        self, dt: float, bed: Motion, heat: Array | None = None
    ) -> tuple[Array, Array]:
        """Advance by dt [s]: force of the gas on the particles [N] (n, 3), heat that
        they receive from it [W] (n,).

        `heat` (c,) [W] is what cells get from other surfaces.

        Raises
        ------
        ConvergenceError : the pressure is not found
        """
        if not self.started:
            self.start(bed)
        places = self._locate(bed)
        rho = self._set_inlet_velocity(places.eps_face)
        local, drag = self._find_drag(bed, places)
        gained, received = self._exchange(dt, bed, places, local)
        if heat is not None:
            gained = gained + heat
        predicted = self._predict(dt, rho, places, drag)
        slope = self._project(dt, places, predicted, gained)
        self._transport(dt, gained)
        self.given = drag.resisted * self.q - drag.pushed - places.solid * slope
        slip = kernels.gather(places.faces, places.weight, self.q) - drag.carried
        steep = kernels.gather(places.faces, places.weight, slope)
        force = drag.coefficient[:, None] * slip - places.volume[:, None] * steep
        return force, received

    def around(self, bed: Motion) -> Local:
        """Return the gas around each particle."""
        where, share, inside = self.grid.shares(bed.x, bed.radius)
        eps = kernels.gather(where, share, self.eps)
        faces, weight = self.grid.weights(bed.x)
        slip = kernels.gather(faces, weight, self.q) - eps[:, None] * bed.v
        return self._local(where, share, inside, eps, slip, 2.0 * bed.radius)

    def state(self) -> dict[str, Array]:
        """Return all that a step depends on as arrays for a checkpoint."""
        arrays = {name: np.array(getattr(self, name)) for name in _STATE}
        numbers = [*self.sums.values(), *self.counts.values(), self.started]
        return arrays | {"numbers": np.array(numbers, dtype=float)}

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays of `state`, bit for bit."""
        for name in _STATE:
            setattr(self, name, np.array(state[name]))
        *numbers, started = state["numbers"].tolist()
        self.sums = dict(zip(self.sums, numbers, strict=False))
        self.counts = {
            name: int(n)
            for name, n in zip(self.counts, numbers[len(self.sums) :], strict=True)
        }
        self.started = bool(started)

    def _locate(self, bed: Motion) -> Places:
        """Find the cells and faces around each particle, and the porosities."""
        where, share, inside = self.grid.shares(bed.x, bed.radius)
        faces, weight = self.grid.weights(bed.x)
        volume = bed.volume * inside
        eps, eps_at = self._porosity(volume, where, share)
        solid = kernels.scatter(faces, weight, volume, len(self.u))
        return Places(
            where,
            share,
            inside,
            volume,
            faces,
            weight,
            eps,
            eps_at,
            solid,
            self._face_porosity(solid, eps),
        )

    def _set_inlet_velocity(self, eps_face: Array) -> Array:
        """Set the velocities at the inlet from the mass flux; return the density on
        faces (f,) [kg/m3].
        """
        rho = self._on_faces(self.density)
        rho[self._below] = self.fluid.density(self.inlet_T[self._below])
        self.u[self._below] = (self.inlet_mass / (rho * eps_face))[self._below]
        self.q = eps_face * self.u
        return rho

    def _find_drag(self, bed: Motion, places: Places) -> tuple[Local, Drag]:
        """Find the gas around each particle and its drag, on the particles and
        summed on faces.
        """
        where = places.where
        share = places.share
        faces = places.faces
        weight = places.weight
        d_p, eps_at = 2.0 * bed.radius, places.eps_at
        carried = eps_at[:, None] * bed.v
        slip = kernels.gather(faces, weight, self.q) - carried
        local = self._local(where, share, places.inside, eps_at, slip, d_p)
        beta = self.drag(Re=local.Re, eps=local.eps, d_p=d_p, mu=local.mu)
        coefficient = beta * places.volume / ((1.0 - eps_at) * eps_at)
        sums = (
            kernels.scatter(faces, weight, each, len(self.u))
            for each in (coefficient, coefficient[:, None] * carried)
        )
        return local, Drag(coefficient, carried, *sums)

    def _predict(self, dt: float, rho: Array, places: Places, drag: Drag) -> Prediction:
        """Predict the velocity without the pressure gradient: explicit convection
        and stress, implicit drag.
        """
        grid, eps_face = self.grid, places.eps_face
        room = np.where(grid.face_volume > 0.0, grid.face_volume, 1.0)
        viscosity = self._on_faces(self._on_cells(self.fluid.viscosity))
        load = (
            rho * self.u / dt
            + drag.pushed / (eps_face * room)
            + kernels.momentum(
                self.u,
                rho * self.q,
                eps_face,
                rho,
                viscosity,
                self.gravity,
                grid.tables,
                self.no_slip,
            )
        )
        resistance = rho / dt + drag.resisted / room
        return Prediction(np.where(grid.active, load / resistance, self.u), resistance)

    def _project(
        self, dt: float, places: Places, predicted: Prediction, gained: Array
    ) -> Array:
        """Solve for the pressure that holds the volume and correct the velocity; return
        grad p on faces [Pa/m].

        Raises
        ------
        ConvergenceError : the pressure is not found
        """
        grid, eps_face = self.grid, places.eps_face
        gap = np.where(grid.face_kind == OUTLET, 0.5, 1.0) * grid.size[grid.face_axis]
        conductance = np.where(
            grid.active, self._area * eps_face / (predicted.resistance * gap), 0.0
        )
        source = (
            self.mass / self.density - places.eps * self.open_volume
        ) / dt + self._expansion() * gained
        source -= kernels.divergence(
            self._area * eps_face * predicted.u, grid.cell_face
        )
        self.p, iterations = self._pressure.solve(
            self.p, conductance, source, self.tolerance
        )
        if iterations < 0:
            raise ConvergenceError(
                f"gas: the pressure was not found to {self.tolerance:.2g}; shorten the "
                "step"
            )
        self.counts["steps"] += 1
        self.counts["iterations"] += iterations
        slope = np.asarray(kernels.slopes(self.p, grid.tables))
        self.u = predicted.u - slope / predicted.resistance
        self.eps, self.q = places.eps, eps_face * self.u
        return slope

    def _porosity(self, volume: Array, where: Any, share: Array) -> tuple[Array, Array]:
        """Find the porosity of the cells, and at the particles, of which `volume`
        (n,) [m3] is in the gas.
        """
        solid = kernels.scatter(where, share, volume, self.grid.cells)
        eps = self._raised(1.0 - solid / self.grid.volume)
        return eps, np.minimum(kernels.gather(where, share, eps), 1.0 - MIN_SOLIDS)

    def _face_porosity(self, solid: Array, eps: Array) -> Array:
        """Find the porosity of the volumes of faces; a face without volume takes
        that of the cells beside.
        """
        volume = self.grid.face_volume
        own = kernels.face_means(eps, self.grid.face_cell)
        return self._raised(
            1.0 - np.divide(solid, volume, out=1.0 - own, where=volume > 0.0)
        )

    def _raised(self, eps: Array) -> Array:
        low = eps < MIN_POROSITY
        self.counts["raised"] += int(low.sum())
        return np.where(low, MIN_POROSITY, eps)

    def _local(
        self,
        where: Any,
        share: Array,
        inside: Array,
        eps: Array,
        slip: Array,
        d_p: Array,
    ) -> Local:
        def at(of: Callable[[Array], Any]) -> Any:
            if self.fluid.constant:
                return np.full(len(eps), of(self.T))
            return kernels.gather(where, share, self._on_cells(of))

        fluid, speed = self.fluid, np.linalg.norm(slip, axis=1)
        mu, k = at(fluid.viscosity), at(fluid.conductivity)
        T = kernels.gather(where, share, self.T)
        return Local(
            eps,
            at(fluid.density) * speed * d_p / mu,
            mu * at(fluid.heat_capacity) / k,
            mu,
            k,
            T,
            inside,
        )

    def convection(self, local: Local, d_p: Array) -> Array:
        """Evaluate the heat transfer coefficient of every particle [W/m2/K], over
        all of its surface.
        """
        assert self.nusselt is not None
        arguments = {name: getattr(local, name) for name in self._names}
        return np.asarray(self.nusselt(**arguments) * local.k / d_p * local.inside)

    def _exchange(
        self, dt: float, bed: Motion, places: Places, local: Local
    ) -> tuple[Array, Array]:
        """Heat that cells gain from particles and neighbours [W], and that particles
        receive; implicit in the gas.
        """
        if not self.energy:
            return np.zeros(self.grid.cells), np.zeros(len(bed.x))
        assert bed.T is not None
        grid, where, share = self.grid, places.where, places.share
        c = self._on_cells(self.fluid.heat_capacity)
        exchange = (
            self.convection(local, 2.0 * bed.radius) * 4.0 * np.pi * bed.radius**2
        )
        own, from_bed = (
            kernels.scatter(where, share, value, grid.cells)
            for value in (exchange, exchange * bed.T)
        )
        flux = self._on_faces(self.density) * self.q * self._area
        upwind = kernels.limited(self.T, self.inlet_T, flux, grid.tables)
        carried = kernels.divergence(
            flux * upwind, grid.cell_face
        ) - self.T * kernels.divergence(flux, grid.cell_face)
        conducted = self._conduction(places.eps_face)
        held = np.where(grid.open_cells, self.mass, 1.0) * c / dt
        T = (held * self.T - c * carried + conducted + from_bed) / (held + own)
        given = np.where(grid.open_cells, from_bed - own * T, 0.0)
        self.sums["gained"] += dt * float(given.sum())
        return given + conducted, exchange * (kernels.gather(where, share, T) - bed.T)

    def _conduction(self, eps_face: Array) -> Array:
        """Find the heat that cells get from their neighbours by conduction of the
        gas [W].
        """
        grid = self.grid
        k = self._on_faces(self._on_cells(self.fluid.conductivity)) * (
            1.0 - np.sqrt(1.0 - np.minimum(eps_face, 1.0))
        )
        inner = grid.face_kind == INNER
        low = np.where(inner, grid.face_cell[:, 0], 0)
        high = np.where(inner, grid.face_cell[:, 1], 0)
        flux = k * self._area / grid.size[grid.face_axis] * (self.T[low] - self.T[high])
        return np.asarray(-kernels.divergence(flux, grid.cell_face))

    def _transport(self, dt: float, gained: Array) -> None:
        """Advance mass and enthalpy of the cells by their fluxes, then find
        temperatures.
        """
        grid = self.grid
        upwind = kernels.limited(self.T, self.inlet_T, self.q, grid.tables)
        mass = self.fluid.density(upwind) * self.q * self._area
        self._count(dt, "mass", mass)
        self.mass = self.mass - dt * kernels.divergence(mass, grid.cell_face)
        if not (self.mass[grid.open_cells] > 0.0).all():
            raise ConvergenceError(
                f"gas: more leaves a cell in a step of {dt:.3g} s than it holds; "
                "shorten gas.step"
            )
        if not self.energy:
            return
        heat = mass * (self.fluid.enthalpy(upwind) - self._base)
        self._count(dt, "heat", heat)
        self.heat = self.heat + dt * (gained - kernels.divergence(heat, grid.cell_face))
        wanted = self.heat / np.where(grid.open_cells, self.mass, 1.0) + self._base
        for _ in range(NEWTON_ITERATIONS):
            miss = np.where(grid.open_cells, wanted - self.fluid.enthalpy(self.T), 0.0)
            self.T = self.T + miss / self.fluid.heat_capacity(self.T)
            if self.fluid.constant:
                break

    def _count(self, dt: float, what: str, flux: Array) -> None:
        outlet = self.grid.face_kind == OUTLET
        self.sums[f"{what}_in"] += dt * float(flux[self._below].sum())
        self.sums[f"{what}_out"] += dt * float(flux[outlet].sum())

    def _expansion(self) -> Array:
        """Find the volume that a cell gains per heat [m3/J], -(d rho/dT)/(rho^2 c)."""
        if self.fluid.constant:
            return np.zeros(self.grid.cells)
        rho, step = self.density, 1e-4 * self.T
        slope = (
            self.fluid.density(self.T + step) - self.fluid.density(self.T - step)
        ) / (2.0 * step)
        return np.asarray(-slope / (rho**2 * self._on_cells(self.fluid.heat_capacity)))

    def _on_cells(self, of: Callable[[Array], Any]) -> Array:
        return np.broadcast_to(of(self.T), self.T.shape).astype(float)

    def _on_faces(self, cells: Array) -> Array:
        return np.asarray(kernels.face_means(cells, self.grid.face_cell))
