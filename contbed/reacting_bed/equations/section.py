"""Rings of a tube, layers of a plane bed or columns of a duct, that exchange heat and
species across the flow.

    dF/dx = S + (1/r^s) d(r^s N)/dr          s = 1 in a tube, 0 between plane walls
    heat        N = K_r dT/dr + sum_k N_k h_k/M_k
    species k   N_k = eps rho ( D_k dw_k/dr - w_k sum_j D_j dw_j/dr )
    wall        N = (T_a - T)/(1/h_w + delta/K_r), or the given flux
    axis        N = 0

In a duct heat and species pass along y and along z, each as between plane walls. F and
S are those of `equations.bed` at each point: rings are coupled only through the radial
fluxes N. Finite volumes of equal width (`equations.parts`), whose exchange is of second
order: what one ring gains through a face its neighbour loses to rounding. delta is the
length from the middle of a ring to the wall, R ln(R/r) in a tube. The N_k sum to zero:
there is no radial mass flow, and each ring keeps its inlet mass flux or, in transients
with gas hold-up, satisfies its own axial continuity. Each solid phase conducts across
by its share of the volume. The pressure is one over the section: its gradient is the
area mean over the rings.

Source: Froment, Bischoff, De Wilde 2011, Chemical Reactor Analysis and Design, ch.
    11.7.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.reacting_bed.equations.bed import Bed
from contbed.reacting_bed.equations.cross_section import Parts
from contbed.reacting_bed.equations.unknowns import State


@dataclass(frozen=True, eq=False)
class Section:
    """The equations of all rings as those of one line: unknowns ring by ring, from
    the axis to the wall.
    """

    bed: Bed
    rings: Parts

    def __call__(
        self, u: Sequence[Any], q: Sequence[Any], x: Any
    ) -> tuple[list[Any], list[Any], list[Any]]:
        """Return convective fluxes, diffusive fluxes and sources of all equations at
        points.
        """
        values, slopes = self._joined(u), self._joined(q)
        C, D, S = self.bed(values, slopes, x)
        sources = self._parted(S)
        self._exchange(values, sources)
        return self._flat(C), self._flat(D), [part for ring in sources for part in ring]

    def held(
        self, u: Sequence[Any], by_bed: Callable[[list[Any]], list[Any]]
    ) -> list[Any]:
        """Return the content per volume of bed by equation at points; `by_bed` gives
        that of all rings as of one.
        """
        return self._flat(by_bed(self._joined(u)))

    def convective(self, u: Sequence[Any]) -> list[Any]:
        """Return the convective fluxes of all equations at points."""
        return self._flat(self.bed.convective(self._joined(u)))

    def diffusive(self, u: Sequence[Any], q: Sequence[Any]) -> list[Any]:
        """Return the diffusive fluxes of all equations at points."""
        return self._flat(self.bed.diffusive(self._joined(u), self._joined(q)))

    def damped(self, u: Sequence[Any], J: Sequence[Any]) -> list[Any]:
        """Return the fluxes of all equations that come with those which damp fields
        in their cells.
        """
        return self._flat(self.bed.damped(self._joined(u), self._joined(J)))

    def _joined(self, u: Sequence[Any]) -> list[Any]:
        """Return the unknowns of one ring at the points of all rings, one after the
        other.

        Derivatives are those to the unknowns of the own ring: each closure and law is
        evaluated once for all rings.
        """
        m = len(self.bed.layout.names)
        out = []
        for f in range(m):
            parts = [u[ring * m + f] for ring in range(self.rings.count)]
            value = np.concatenate(
                [np.atleast_1d(getattr(part, "value", part)) for part in parts]
            )
            slots = [slot[0] for slot in getattr(parts[0], "tangents", {})]
            seeds = {(kind, f): np.ones(value.shape) for kind in slots}
            out.append(type(parts[0])(value, seeds) if slots else value)
        return out

    def _parted(self, parts: Sequence[Any]) -> list[list[Any]]:
        """Return values at the points of all rings as those of each ring, with
        derivatives to its own unknowns.
        """
        return [
            [self._of_ring(part, ring) for part in parts]
            for ring in range(self.rings.count)
        ]

    def _of_ring(self, part: Any, ring: int) -> Any:
        m = len(self.bed.layout.names)
        tangents = getattr(part, "tangents", None)
        if tangents is None:
            return self._piece(part, ring)
        own = {
            (kind, ring * m + f): self._piece(t, ring)
            for (kind, f), t in tangents.items()
        }
        return type(part)(self._piece(part.value, ring), own)

    def _piece(self, value: Any, ring: int) -> Any:
        value = np.asarray(value)
        if value.size == 1:
            return value
        length = len(value) // self.rings.count
        return value[ring * length : (ring + 1) * length]

    def _flat(self, parts: Sequence[Any]) -> list[Any]:
        """Return values at the points of all rings as those of one ring after another."""
        return [part for ring in self._parted(parts) for part in ring]

    def _mean(self, value: Any, inner: int, outer: int) -> Any:
        """Return the mean of values of two rings."""
        return 0.5 * (self._of_ring(value, inner) + self._of_ring(value, outer))

    def _exchange(self, values: list[Any], sources: list[list[Any]]) -> None:
        """Add to the sources of the rings what they gain through their faces and
        through the wall.
        """
        bed, rings, names = self.bed, self.rings, self.bed.layout.names
        state = bed.state(values)
        radial = bed.medium.radial(state)
        gases = bed.layout.gases
        temperatures = bed.layout.temperatures
        fields: dict[str, list[Any]] = {}
        if len(temperatures) == 1:
            fields["T"] = self._pairs(state.T_fluid, radial.conductivity)
        elif temperatures:
            fields["T_fluid"] = self._pairs(state.T_fluid, radial.conductivity_fluid)
            for phase, own in bed.with_states(state):
                K = radial.phases[phase.layout.name].conductivity_solid
                fields[phase.layout.temperature] = self._pairs(own.T_solid, K)
        shares = rings.shares
        for inner, outer, area in rings.joins:
            gained: dict[str, Any] = {}
            for name, pairs in fields.items():
                (T_a, K_a), (T_b, K_b) = pairs[inner], pairs[outer]
                gained[name] = 0.5 * (K_a + K_b) * (T_b - T_a)
            if radial.dispersion is not None:
                moved = self._moved(state, radial.dispersion, inner, outer)
                gained |= {f"g_{name}": moved[name] for name in gases}
                if temperatures:
                    h = {name: bed.enthalpies[name](state.T_fluid) for name in gases}
                    carried: Any = sum(
                        moved[name] * self._mean(h[name], inner, outer)
                        for name in gases
                    )
                    gained[temperatures[0]] = gained[temperatures[0]] + carried
            for name, amount in gained.items():
                k = names.index(name)
                sources[inner][k] = sources[inner][k] + amount * (area / shares[inner])
                sources[outer][k] = sources[outer][k] - amount * (area / shares[outer])
        if temperatures:
            k, pairs = names.index(temperatures[0]), fields[temperatures[0]]
            coefficients = bed.medium.wall_coefficient(state)
            for ring, area, distance in rings.walls:
                heat = bed.medium.through_wall(
                    pairs[ring][0],
                    self._of_ring(coefficients, ring),
                    pairs[ring][1],
                    distance,
                )
                sources[ring][k] = sources[ring][k] + heat * (area / shares[ring])
        if bed.layout.pressure:
            k = names.index("p")
            mean: Any = sum(
                float(share) * part[k]
                for share, part in zip(shares, sources, strict=True)
            )
            for part in sources:
                part[k] = mean

    def _pairs(self, *fields: Any) -> list[Any]:
        return [
            tuple(self._of_ring(field, ring) for field in fields)
            for ring in range(self.rings.count)
        ]

    def _moved(
        self, state: State, dispersion: Any, inner: int, outer: int
    ) -> dict[str, Any]:
        """Return what goes of each gas from a ring's outer neighbour to it, over
        area and distance [mol/m/s].
        """
        eps = self.bed.medium.porosity
        slopes, shares, coefficients = {}, {}, {}
        for name, g in state.g.items():
            w, D = g / state.flux, eps * state.rho * dispersion[name]
            slopes[name] = self._of_ring(w, outer) - self._of_ring(w, inner)
            shares[name] = self._mean(w, inner, outer)
            coefficients[name] = self._mean(D, inner, outer)
        masses = self.bed.masses
        common: Any = sum(
            masses[name] * coefficients[name] * slope for name, slope in slopes.items()
        )
        return {
            name: coefficients[name] * slope - shares[name] * common
            for name, slope in slopes.items()
        }
