"""A reacting bed as a system on a line: unknowns, what enters, first guess, sizes,
results of a state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.arrays import Array, Flags
from contbed.chemistry.kinetics import Reaction
from contbed.chemistry.local import Local, Smoothing
from contbed.chemistry.thermo import R_GAS
from contbed.course.schedule import Schedule
from contbed.fem.line_dg import Ends, Line, System
from contbed.fem.line_projection import projected
from contbed.particle.pellets import Pellets
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.assembled import bed_of, within
from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.cross_section import Parts
from contbed.reacting_bed.equations.section import Section
from contbed.reacting_bed.equations.unknowns import Layout, Role, State, Unknown
from contbed.reacting_bed.inside import Choice, with_inside
from contbed.reacting_bed.medium import Medium, PhaseMedium
from contbed.reacting_bed.phases import species_of
from contbed.reacting_bed.streams import Streams, gas_inlet, streams
from contbed.reacting_bed.substances import Substances

LARGE_T = 1e3  # [K], of the temperatures of most reactors
DEGREE = 3  # of the polynomials in a cell
OF_PARTICLES = (Role.SOLID, Role.POINT)
LITTLE_DROP = 1e-3  # share of the pressure below which its drop is left out


@dataclass(frozen=True, eq=False)
class Problem:
    """The bed of a scene on a line."""

    scene: s.ReactingScene
    species: Substances
    streams: Streams
    reactions: tuple[Reaction, ...]
    bed: Bed
    line: Line
    # of intraparticle adsorption, by phase
    choices: Mapping[str, Choice] = field(default_factory=dict)
    # largest mole fractions of gases that are adsorbed
    peaks: Mapping[str, float] = field(default_factory=dict)
    damping: Array | None = None  # of fields in cells (m, N), see `fem.line_dg`

    @classmethod
    def of(
        cls, scene: s.ReactingScene, vertices: Array, species: Substances | None = None
    ) -> Problem:
        """Build the bed of a scene; `species` if they are known from one with the
        same.
        """
        species = species or species_of(scene)
        entering = streams(scene, species)
        medium = Medium.of(scene, species, entering, True)
        medium = replace(
            medium, with_pressure=_pressure_drops(scene, species, entering, medium)
        )
        bed = bed_of(scene, species, entering, medium)
        degree = scene.solver.degree
        made = cls(
            scene,
            species,
            entering,
            tuple(bed.reactions),
            bed,
            Line(vertices, DEGREE if degree is None else degree),
        )
        return made._with_inside() if scene.adsorbs else made

    def _with_inside(self) -> Problem:
        """Return the problem whose particles take up gas."""
        at_inlet = self.state_entering()
        bed, choices = with_inside(self.scene, self.bed, at_inlet)
        return replace(self, bed=bed, choices=choices).with_peaks(at_inlet.x)

    def with_peaks(self, fractions: Mapping[str, float]) -> Problem:
        """Return the problem whose adsorbed gases are measured by their largest mole
        fractions, where these are known.

        Other gases are measured by the flux of all: reactions make much of what enters
        as a trace.
        """
        known = {
            name: float(x)
            for name, x in fractions.items()
            if name in self.layout.inside and x > 0.0
        }
        return replace(self, peaks={**self.peaks, **known})

    def on(self, vertices: Array) -> Problem:
        """Return the problem on other cells; pressures at which gas is stored are
        the polynomials of these.
        """
        line, pressure = replace(self.line, vertices=vertices), self.bed.gas_pressure
        made = replace(self, line=line, damping=None)
        if not np.ndim(pressure):
            return made
        return made.with_gas_stored(
            projected(
                self.line, pressure.reshape(-1, *self.line.points.shape), line
            ).ravel()
        )

    def within(self, scene: s.ReactingScene) -> Problem:
        """Return the problem with the streams and surroundings of a scene that
        differs in nothing else.
        """
        entering = streams(scene, self.species)
        return replace(
            self, scene=scene, streams=entering, bed=within(self.bed, scene, entering)
        )

    def at_moments(self, scene: s.ReactingScene, schedule: Schedule) -> list[Problem]:
        """Return the problem with the streams of each time at which a series of a
        scene has a value; of the start where there are none.
        """
        moments = schedule.moments() or [0.0]
        return [self.within(schedule.frozen(scene, moment)) for moment in moments]

    def with_strength(self, strength: float) -> Problem:
        """Return the problem with all rates multiplied by a factor."""
        return replace(self, bed=replace(self.bed, strength=strength))

    def with_gas_stored(self, pressure: Any) -> Problem:
        """Return the problem whose gas is stored in time at a pressure [Pa], one
        number or one for each node.
        """
        return replace(self, bed=replace(self.bed, gas_pressure=pressure))

    def with_small(self, small: Smoothing | None) -> Problem:
        """Return the problem with powers between 0 and 1 made straight below other
        shares; None: those of the laws.
        """
        return replace(self, bed=replace(self.bed, small=small))

    def with_most_lost(self, most: Array) -> Problem:
        """Return the problem in which solids lose at most so much at the nodes (m,
        N, p + 1) [mol/m3 bed/s].
        """
        at = dict(zip(self.layout.names, self.at_all_points(most), strict=True))
        found = {name: at[f"n_{name}"] for name in self.layout.solids}
        return replace(self, bed=replace(self.bed, most_lost=found))

    @property
    def layout(self) -> Layout:
        """The unknowns."""
        return self.bed.layout

    @property
    def has_roots(self) -> bool:
        """Whether rates may have powers between 0 and 1, whose slopes are infinite
        where nothing is left.
        """
        return bool(self.layout.solids) or any(
            reaction.has_roots for reaction in self.reactions
        )

    @property
    def pellets(self) -> dict[str, Pellets]:
        """Catalyst pellets whose inside is resolved, by solid phase."""
        return {
            str(each.phase): each.rate
            for each in self.reactions
            if isinstance(each.rate, Pellets)
        }

    def local(self, state: State, reaction: Reaction) -> Local:
        """Return a state as a reaction of a solid phase sees it, nothing of which is
        adsorbed.
        """
        phase = str(reaction.phase)
        transport = self.bed.medium.at(state).phases[phase]
        medium: PhaseMedium = self.bed.phases[phase].medium
        return medium.local(state.phases[phase], transport, reaction, self.bed.small)

    @cached_property
    def system(self) -> System:
        """Equations on the line."""
        point, coupling = self.section or self.bed, self.bed.coupling()
        if coupling is not None and self.rings is not None:
            rings = np.eye(self.ring_count)
            coupling = np.asarray(np.kron(rings, coupling), dtype=float)
        exchanged = (self._directions, self._diffuses, point, self._ends, self._local)
        damping = (
            None if self.damping is None else self.gas_signs[:, None] * self.damping
        )
        return System(self.line, *exchanged, coupling, damping)

    @property
    def gas_signs(self) -> Array:
        """Signs by which unknowns of gas count along its stream: its fluxes are
        negative to the left (m,).
        """
        signs = np.ones(len(self.unknowns))
        if not self.streams.ahead:
            signs[self.rows(Role.GAS)] = -1.0
        return signs

    @cached_property
    def section(self) -> Section | None:
        """Equations of the rings; None in one dimension."""
        return None if self.rings is None else Section(self.bed, self.rings)

    @cached_property
    def rings(self) -> Parts | None:
        """Rings, layers or columns of the section; None in one dimension."""
        section, diameter = self.scene.section, self.scene.mesh.diameter
        if section is None:
            return None
        assert diameter is not None  # `checks` sees to it
        return Parts(section.rings, 0.5 * diameter, section.shape)

    @property
    def ring_count(self) -> int:
        """Number of the parts of the section; 1 in one dimension."""
        return 1 if self.rings is None else self.rings.count

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns of the line: those of the layout, for each ring."""
        return self.layout.names * self.ring_count

    @cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """All unknowns of the line: those of the layout, for each ring."""
        return self.layout.unknowns * self.ring_count

    @property
    def is_gas(self) -> Flags:
        """Whether each unknown is the flux of a gas (m,)."""
        return np.array([each.role is Role.GAS for each in self.unknowns])

    def rows(self, *roles: Role) -> NDArray[np.intp]:
        """Return the rows of the unknowns with these roles."""
        found = [k for k, each in enumerate(self.unknowns) if each.role in roles]
        return np.array(found, dtype=np.intp)

    def mean(self, values: Array) -> Array:
        """Return means over the section of unknowns or fluxes of the line, by the
        names of the layout.
        """
        return values if self.rings is None else self.rings.mean(values)

    def at_all_points(self, u: Array) -> list[Array]:
        """Return each unknown of the layout at all points, those of one ring after
        those of another.
        """
        m = len(self.layout.names)
        by_ring = u.reshape(self.ring_count, m, -1)
        return list(by_ring.swapaxes(0, 1).reshape(m, -1))

    @property
    def _local(self) -> list[int]:
        """Return the unknowns of particles at rest and of films, which are in no
        flux.
        """
        return [
            k
            for k, (name, role, *_) in enumerate(self.unknowns)
            if role is Role.FILM
            or (role in OF_PARTICLES and not self.bed.velocity_of(name))
        ]

    @property
    def _directions(self) -> list[int]:
        gas = 1 if self.streams.ahead else -1
        solid = -1 if self.bed.velocity_solid < 0 else 1
        moved = (*OF_PARTICLES, Role.T_SOLID)
        return [solid if each.role in moved else gas for each in self.unknowns]

    @property
    def _diffuses(self) -> list[bool]:
        closures, heat = self.scene.closures, self.scene.heat is not None
        mass = closures.dispersion_mass not in (None, 0.0)
        fluid = heat and (
            closures.conductivity_gas is not None or closures.dispersion is not None
        )
        solid = heat and closures.conductivity_solids is not None
        by_role = {
            Role.GAS: mass,
            Role.T: fluid or solid,
            Role.T_GAS: fluid,
            Role.T_SOLID: solid,
        }
        return [by_role.get(each.role, False) for each in self.unknowns]

    @cached_property
    def entering(self) -> dict[str, float]:
        """Values of the unknowns in the streams that enter."""
        streams = self.streams
        one = {"T": streams.T_gas, "T_fluid": streams.T_gas, "p": streams.pressure}
        one |= {
            phase.temperature: streams.T_solids[phase.name]
            for phase in self.layout.phases
        }
        molar = streams.pressure / (R_GAS * streams.T_gas)
        one |= {f"g_{name}": g for name, g in streams.gas.items()}
        for film, gas in self.layout.films.items():
            one[f"s_{film}"] = streams.gas[gas] / streams.moles * molar
        unknowns = self.layout.unknowns
        clean = {each.name: 0.0 for each in unknowns if each.role is Role.POINT}
        return one | clean | {f"n_{name}": n for name, n in streams.solid.items()}

    def state_entering(self, warmer: float = 0.0) -> State:
        """Return the state of all that enters, with solid phases so much warmer [K]."""
        values = self.entering
        if warmer:
            values = values | {
                phase.temperature: values[phase.temperature] + warmer
                for phase in self.layout.phases
            }
        return self.bed.state([values[name] for name in self.layout.names])

    def _stream_of(self, phase: str) -> State:
        """Return the state of the particles of a phase as they enter, at their own
        temperature also where gas and particles have one in the bed.
        """
        values = self.entering | {"T": self.streams.T_solids[phase]}
        state = self.bed.state([values[name] for name in self.layout.names])
        return state.phases[phase]

    @cached_property
    def inflow(self) -> dict[str, float]:
        """Fluxes of all equations that enter, signed along x."""
        streams, names = self.streams, self.layout.names
        found = {f"g_{name}": g for name, g in streams.gas.items()}
        v = self.bed.velocity_of
        found |= {f"n_{name}": v(f"n_{name}") * n for name, n in streams.solid.items()}
        h = self.bed.enthalpies
        gas = float(sum(g * h[name](streams.T_gas) for name, g in streams.gas.items()))
        solid = [
            float(phase.velocity * phase.enthalpy(self._stream_of(phase.layout.name)))
            if phase.velocity
            else 0.0
            for phase in self.bed.phases.values()
        ]
        found |= {"T": gas + sum(solid), "T_fluid": gas, "p": streams.pressure}
        found |= dict(
            zip(
                (
                    each.name
                    for each in self.layout.unknowns
                    if each.role is Role.T_SOLID
                ),
                solid,
                strict=False,
            )
        )
        return {name: found.get(name, 0.0) for name in names}

    @property
    def _ends(self) -> Ends:
        names, m = self.names, len(self.names)
        ahead = np.array(self._directions) > 0
        at = np.array([self.inflow[name] for name in names])
        given = [np.zeros(m, dtype=bool), np.zeros(m, dtype=bool)]
        flux = [np.zeros(m), np.zeros(m)]
        value = [np.full(m, np.nan), np.full(m, np.nan)]
        fixed = gas_inlet(self.scene.boundary).fixed_temperature is not None
        for k, (name, role, *_) in enumerate(self.unknowns):
            end = 0 if ahead[k] else 1
            with_gas = role in (Role.GAS, Role.T, Role.T_GAS)
            moves = (
                with_gas or role is Role.PRESSURE or self.bed.velocity_of(name) != 0.0
            )
            if role is Role.FILM:
                continue
            if fixed and with_gas:
                value[end][k] = self.entering[name]
            elif moves or role is Role.T_SOLID:
                given[end][k], flux[end][k] = True, at[k] if moves else 0.0
        return Ends((flux[0], flux[1]), (given[0], given[1]), (value[0], value[1]))

    @property
    def inlet_velocity(self) -> float:
        """Superficial speed of the gas as it enters [m/s]."""
        return self.moles * R_GAS * self.streams.T_gas / self.streams.pressure

    @property
    def gas_residence(self) -> float:
        """Time that the gas as it enters takes through the pores of the bed [s]."""
        scene = self.scene
        return scene.packed_bed.porosity * scene.mesh.length / self.inlet_velocity

    @property
    def mixing_temperature(self) -> float:
        """Temperature of both streams if they were mixed before anything reacts,
        with capacities as they enter [K].
        """
        streams, h = self.streams, self.bed.enthalpies
        rise = 1.0  # [K]
        gas = abs(
            sum(
                g * (h[name](streams.T_gas + rise) - h[name](streams.T_gas))
                for name, g in streams.gas.items()
            )
        )
        states = self.state_entering(), self.state_entering(rise)
        capacity, heat = gas, gas * streams.T_gas
        for name, phase in self.bed.phases.items():
            cold, warm = (phase.enthalpy(state.phases[name]) for state in states)
            solid = float(abs(phase.velocity * (warm - cold)))
            capacity, heat = capacity + solid, heat + solid * streams.T_solids[name]
        return float(heat / capacity)

    def start(self, T: float | None = None) -> Array:
        """Return the state in which everything is as it enters; `T` [K] replaces
        both temperatures.
        """
        out = np.empty((len(self.names), *self.line.points.shape))
        for k, name in enumerate(self.names):
            out[k] = self.entering[name]
            if T is not None and name in self.layout.temperatures:
                out[k] = T
        return out

    def first_point(self) -> list[float]:
        """Return the unknowns of the layout as they enter."""
        return list(self.start()[: len(self.layout.names), 0, 0])

    @property
    def moles(self) -> float:
        """Molar flux of the gas that enters [mol/m2/s]."""
        return abs(self.streams.moles)

    @cached_property
    def sizes(self) -> Array:
        """Typical values of the unknowns (m,); of a constituent that of all in its
        solid phase.
        """
        molar = self.streams.pressure / (R_GAS * self.streams.T_gas)
        by_role = {
            Role.GAS: self.moles,
            Role.PRESSURE: self.streams.pressure,
            Role.FILM: molar,
            Role.POINT: molar,
        }
        of_phase: dict[str, float] = {}
        for phase in self.species.phases.values():
            names = [phase.full(name) for name in phase.solids]
            total = max(sum(self.streams.solid[name] for name in names), 1e-30)
            of_phase |= dict.fromkeys(names, total)
        sizes = [
            of_phase[str(each.species)]
            if each.role is Role.SOLID
            else by_role.get(each.role, LARGE_T)
            for each in self.unknowns
        ]
        return np.array(sizes, dtype=float) * self._shares

    @property
    def _shares(self) -> Array:
        """Mole fractions by which gases that are adsorbed are measured, 1 of all
        others (m,).
        """
        return np.array(
            [self.peaks.get(each.conserved or "", 1.0) for each in self.unknowns]
        )

    @cached_property
    def flux_sizes(self) -> Array:
        """Typical fluxes of the equations (m,)."""
        moles = self.moles
        solids = abs(self.bed.velocity_solid) * max(
            sum(self.streams.solid.values()), 1e-30
        )
        cp = 30.0  # [J/mol/K], of most gases
        by_role = {
            Role.GAS: moles,
            Role.SOLID: max(solids, 1e-9 * moles),
            Role.PRESSURE: self.streams.pressure,
            Role.FILM: moles,
            Role.POINT: moles,
        }
        heat = moles * cp * LARGE_T + solids * 1e5
        sizes = [by_role.get(each.role, heat) for each in self.unknowns]
        return np.array(sizes, dtype=float) * self._shares

    def integral(self, values: Any) -> float:
        """Return the integral along the bed of a value at all points, mean over the
        section.
        """
        line = self.line
        shape = (self.ring_count, *line.points.shape)
        whole = np.broadcast_to(values, np.prod(shape)).reshape(shape)
        table = self.mean(whole)[0]
        return float(np.einsum("cj,j,c->", table, line.weights, line.h))

    def flux_at(self, u: Array) -> Mapping[str, Array]:
        """Return the fluxes of all equations through the vertices, signed along x,
        per area of the bed.
        """
        return dict(
            zip(self.layout.names, self.mean(self.system.fluxes(u)), strict=True)
        )


def _pressure_drops(
    scene: s.ReactingScene, species: Substances, entering: Streams, medium: Medium
) -> bool:
    """Return whether the pressure is an unknown."""
    if scene.packed_bed.pressure_drop != "auto":
        return scene.packed_bed.pressure_drop == "ergun"
    return _drop(scene, species, entering, medium) > LITTLE_DROP * entering.pressure


def _drop(
    scene: s.ReactingScene, species: Substances, entering: Streams, medium: Medium
) -> float:
    """Return the pressure drop of the gas as it enters, at the hottest temperature
    given [Pa].
    """
    if species.transport is None or species.transport.viscosities is None:
        return 0.0
    hottest = max(entering.T_gas, *entering.T_solids.values())
    gases = tuple(species.gases)
    bed = Bed(
        Layout(gases, (), False),
        species.molar_masses,
        {},
        (),
        medium,
        {},
        entering.pressure,
        hottest,
    )
    state = bed.state([entering.gas[name] for name in gases])
    return abs(float(medium.resistance(state))) * scene.mesh.length


def isothermal_drop(problem: Problem) -> float | None:
    """Return the pressure drop of the gas as it enters, expanding at its
    temperature [Pa]; None if it cannot pass.
    """
    drop = _drop(problem.scene, problem.species, problem.streams, problem.bed.medium)
    p = problem.streams.pressure
    square = p * p - 2.0 * p * drop  # p dp/dx is constant along an isothermal ideal gas
    return None if square <= 0.0 else float(p - square**0.5)
