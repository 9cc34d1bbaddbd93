"""Coefficients of the two-energy equations of one scene: velocities, exchange,
stabilisation, sources, walls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.closures.optics import SIGMA
from contbed.fem.ad.dual import Components, plain
from contbed.fem.domain import Domain
from contbed.fem.skfem import Ops, System
from contbed.fem.stabilisation import tau
from contbed.packed_bed import scene as s
from contbed.packed_bed.equations import two_energy
from contbed.packed_bed.inside import Mode, modes
from contbed.packed_bed.plan import Plan
from contbed.scene.mesh import SIDE

if TYPE_CHECKING:
    from contbed.packed_bed.flow import Flow

# speed or mass flux squared that keeps the direction of a vanishing stream finite
TINY = 1e-30


def enters(mass_flux: Any, part: Domain) -> bool:
    """Return whether a stream enters through some of a boundary; None is no stream."""
    if mass_flux is None:
        return False
    return bool(np.min(plain(Ops.dot(mass_flux, part.n))) < 0)


class HeatCoefficients:
    """Coefficients of the forms of `equations.two_energy` on any domain.

    Velocities are uniform vectors, or a computed `flow` for the fluid; `share` is the
    mass flux of the fluid over that at the density of the medium. `radiation` couples
    radiation.
    """

    def __init__(self, plan: Plan, flow: Flow | None, system: System, radiation: Any):
        self.scene, self.mesh, self.medium = plan.solved, plan.mesh, plan.medium
        self.velocities = {
            "fluid": plan.velocity,
            "solid": plan.velocity_solid,
            "comoving": plan.medium.comoving(plan.velocity_solid),
        }
        self.flow, self.system, self.radiation = flow, system, radiation
        self.share = 1.0

    def condition(
        self, name: str, phase: str, boundary: Mapping[str, s.Boundary] | None = None
    ) -> s.PhaseCondition | None:
        """Return the thermal condition of one phase on one boundary, of tables at a
        time if given.
        """
        table = (boundary or self.scene.boundary).get(name)
        if table is None or (phase == "solid" and self._heats_gas_alone(name)):
            return None
        return table.thermal(phase)

    def _heats_gas_alone(self, boundary: str) -> bool:
        """Whether a boundary is the side of a line, whose heat for the bed is that of
        its gas, as in beds with reactions.
        """
        table = self.scene.boundary[boundary]
        line = self.mesh.skfem.dim() == 1
        return line and boundary == SIDE and table.passes_heat

    def _velocity(self, phase: str, where: Domain) -> Any:
        """Return the velocity of a phase, or of a gas that moves with the particles,
        on a domain; None when it rests.
        """
        flow = self.flow
        if phase == "fluid" and flow is not None:
            velocity = flow.velocity * (self.share / flow.share)
            return self.system.known(where, flow.system.fields["u"][0], velocity)
        vector = self.velocities[phase]
        if phase == "fluid":
            vector = vector * self.share
        return Components(float(v) for v in vector) if np.any(vector) else None

    def _speed(self, where: Domain) -> Callable[[Any], Any]:
        """Return the relative superficial speed as a function of the fluid's density.

        The mass flux of the fluid is what the scene gives.
        """
        scale = self.medium.mass_flux_scale()
        fluid = self._velocity("fluid", where)
        comoving = self._velocity("comoving", where)
        if self.flow is None and self.medium.fluid.constant:
            relative = self.velocities["fluid"] - self.velocities["comoving"]
            speed = float(np.linalg.norm(relative))
            return lambda density: speed
        if fluid is None and comoving is None:
            return lambda density: 0.0  # without the kink of the norm at 0
        still = Components([0.0] * self.mesh.skfem.dim())

        def speed_of(density: Any) -> Any:
            w = (still if fluid is None else fluid) * (scale / density) - (
                still if comoving is None else comoving
            )
            return np.sqrt(Ops.dot(w, w))

        return speed_of

    def of(self, where: Domain) -> two_energy.Coefficients:
        """Return the coefficients of the balances on a domain."""
        medium, speed = self.medium, self._speed(where)
        spread = medium.dispersion(medium.T_fluid_in, speed)
        exchange = plain(medium.exchange(medium.T_fluid_in, speed))
        return two_energy.Coefficients(
            fluid=self._phase("fluid", where, spread, exchange),
            solid=self._phase("solid", where, None, exchange),
            exchange=lambda T_fluid, T_solid: medium.exchange(T_fluid, speed),
            cross=medium.cross_conductivity,
            radiated=None if self.radiation is None else self.radiation.net_absorption,
            modes=tuple(
                self._mode(mode, where, exchange) for mode in modes(self.scene)
            ),
            capacity=lambda T: (
                (1.0 - self.scene.packed_bed.porosity) * medium.solid.density(T)
            ),
        )

    def in_stream(
        self, share: float, start: two_energy.Coefficients, where: Domain
    ) -> tuple[HeatCoefficients, two_energy.Coefficients]:
        """Return what makes coefficients for another mass flux of the fluid, and those
        of the balances on a domain.

        The functions that test the balances stay those of `start`, so that the rate of
        the content is tested as the content is.
        """
        build = copy(self)
        build.share = share
        now, fluid = build.of(where), start.fluid
        tested = None if fluid.tau is None else fluid.tau / share
        fluid = replace(
            fluid,
            mass_flux=now.fluid.mass_flux,
            divergence=now.fluid.divergence,
            dispersion=now.fluid.dispersion,
            tau=tested,
        )
        return build, replace(start, fluid=fluid, exchange=now.exchange)

    def _mode(self, mode: Mode, where: Domain, exchange: Any) -> two_energy.Mode:
        """Return the coefficients of one mode of intraparticle conduction."""
        solid, T_ref = self.medium.solid, self.medium.T_fluid_in
        velocity, stabilisation = self._velocity("solid", where), None
        if velocity is not None and self.scene.solver.stabilisation:
            capacity = float(solid.heat_capacity(T_ref))
            speed = np.sqrt(plain(Ops.dot(velocity, velocity)) + TINY)
            h = where.length_along(
                Components(plain(part) / speed for part in velocity.items)
            )
            rate = mode.decay * float(solid.conductivity(T_ref)) + mode.gain * exchange
            flux = speed * self._density("solid") * capacity
            stabilisation = plain(
                tau(flux, 0.0, rate, capacity, h, self.scene.solver.degree)
            )
        return two_energy.Mode(
            mode.name,
            lambda T: mode.decay * solid.conductivity(T),
            mode.gain,
            stabilisation,
        )

    def mode_wall(self, mode: Mode, where: Domain) -> two_energy.BoundaryTerms | None:
        """Return what carries a mode through a boundary; particles enter with a
        uniform temperature.
        """
        wall = self.wall("", "solid", where)
        if wall.mass_flux is None:
            return None
        return two_energy.BoundaryTerms(
            mode.name,
            wall.mass_flux,
            None,
            inflow=0.0 if enters(wall.mass_flux, where) else None,
            capacity=self.medium.solid.heat_capacity,
        )

    def _phase(
        self, phase: str, where: Domain, spread: Any, exchange: Any
    ) -> two_energy.Phase:
        """Return the coefficients of one phase.

        `spread` holds the dispersion along and across the flow; the stabilisation also
        uses `exchange` at the reference temperature.
        """
        material, T_ref = getattr(self.medium, phase), self.medium.T_fluid_in
        conductivity = partial(self.medium.conductivity, phase)
        velocity, density = self._velocity(phase, where), self._density(phase)
        flux = None if velocity is None else velocity * density
        capacity = float(material.heat_capacity(T_ref))
        dispersion, along = None, 0.0
        if spread is not None and velocity is not None:
            along, across = spread
            size = np.sqrt(Ops.dot(velocity, velocity) + TINY)
            dispersion = (across, along - across, velocity / size)
        stabilisation = None
        if flux is not None and self.scene.solver.stabilisation:
            speed = np.sqrt(plain(Ops.dot(flux, flux)) + TINY)
            h = where.length_along(
                Components(plain(part) / speed for part in flux.items)
            )
            stagnant = conductivity(T_ref) + along
            stabilisation = plain(
                tau(
                    speed * capacity,
                    stagnant,
                    exchange,
                    capacity,
                    h,
                    self.scene.solver.degree,
                )
            )
        computed = phase == "fluid" and self.flow is not None
        return two_energy.Phase(
            mass_flux=flux,
            divergence=Ops(where).div(velocity) * density if computed else None,
            enthalpy=material.enthalpy,
            heat_capacity=material.heat_capacity,
            capacity=capacity,
            offset=float(material.enthalpy(T_ref)) - capacity * T_ref,
            conductivity=conductivity,
            dispersion=dispersion,
            content=getattr(self.medium, f"content_{phase}"),
            source=self._source(phase),
            tau=stabilisation,
            varies=not self.medium.constant
            and float(conductivity(1.01 * T_ref)) != float(conductivity(T_ref)),
            reference=T_ref,
        )

    def _density(self, phase: str) -> float:
        """Return the density that turns the velocity of a phase into its mass
        flux [kg/m3].
        """
        medium = self.medium
        return (
            medium.mass_flux_scale()
            if phase == "fluid"
            else float(medium.solid.density(medium.T_fluid_in))
        )

    def _source(self, phase: str) -> Any:
        values = {
            name: region.heat_source(phase)
            for name, region in self.scene.region.items()
        }
        if not any(values.values()):
            return 0.0
        field = np.zeros((self.mesh.skfem.nelements, 1))
        for name, value in values.items():
            field[self.mesh.skfem.subdomains[name]] += value
        return field

    def wall(self, name: str, phase: str, where: Domain) -> two_energy.BoundaryTerms:
        """Return the condition of one phase on a boundary domain."""
        material = getattr(self.medium, phase)
        velocity = self._velocity(phase, where)
        flux = None
        if velocity is not None and name != SIDE:
            normal = plain(Ops.dot(velocity, where.n))
            if np.abs(normal).max() > 1e-12 * max(
                np.abs(plain(v)).max() for v in velocity.items
            ):
                flux = velocity * self._density(phase)
        condition = self.condition(name, phase)
        if condition is None:
            return two_energy.BoundaryTerms(f"T_{phase}", flux, material.enthalpy)
        options = self.given(phase, condition, enters(flux, where))
        if condition.coefficient is not None:
            spec, speed = condition.coefficient, self._speed(where)
            options["coefficient"] = lambda unknowns: self.medium.wall(
                spec, unknowns.T_fluid, speed
            )
        if self.scene.boundary[name].passes_heat and not self._heats_gas_alone(name):
            options["share"] = self._share_of_heat(phase, where)
        if condition.emissivity is not None:
            options["emission"] = condition.emissivity * SIGMA
        return two_energy.BoundaryTerms(
            f"T_{phase}", flux, material.enthalpy, **options
        )

    def _share_of_heat(self, phase: str, where: Domain) -> Callable[[Any], Any]:
        """Return the conductivity of a phase across the flow over that of the bed, as
        a function of the unknowns.
        """
        medium = self.medium
        spread = medium.dispersion(medium.T_fluid_in, self._speed(where))
        across = 0.0 if spread is None else spread[1]

        def share(unknowns: Any) -> Any:
            gas = medium.conductivity("fluid", unknowns.T_fluid) + across
            solid = medium.conductivity("solid", unknowns.T_solid)
            return (gas if phase == "fluid" else solid) / (gas + solid)

        return share

    def given(
        self, phase: str, condition: s.PhaseCondition, inflow: bool
    ) -> dict[str, Any]:
        """Return the values of a condition that may change with time; the
        temperature of a stream only with `inflow`.
        """
        options: dict[str, Any] = {}
        if condition.temperature is not None and inflow:
            options["inflow"] = float(
                getattr(self.medium, phase).enthalpy(condition.temperature)
            )
        if condition.heat_flux is not None:
            options["flux"] = condition.heat_flux
        if condition.ambient is not None:
            options["ambient"] = condition.ambient
        return options
