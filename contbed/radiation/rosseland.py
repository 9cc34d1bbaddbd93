"""Radiation in thick beds as heat conduction: a conducting stand-alone medium.

    -div((k + 16 sigma T^3 D) grad T) = 0,   T = T_w on walls        (all particles have the temperature T)

What it leaves out is the temperature slip at walls, a resistance of about a mean free
path.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.closures.optics import conductivity
from contbed.fem import system as make_system
from contbed.mesh.mesh import Mesh
from contbed.radiation.equations import p1 as radiation
from contbed.radiation.optics import optics
from contbed.radiation.problem import RadiationProblem, surfaces
from contbed.radiation.scene import Radiating


class RosselandProblem(RadiationProblem):
    """A conducting medium with the Rosseland conductivity: unknown `T_solid`."""

    def __init__(self, scene: Radiating, mesh: Mesh, section: float = 1.0):
        table = scene.radiation
        assert table is not None
        self.scene, self.mesh, self.optics = scene, mesh, optics(scene)
        self.conductivity = table.conductivity or 0.0
        degree = scene.solver.degree
        self.system = make_system(
            mesh, {"T_solid": (degree, 0)}, 2 * degree + 3, section
        )
        self.surfaces = surfaces(scene, mesh, self.system)
        self.forms = [(self._conduction, self.system.cells, None)]
        self.fixed, self.fixed_values, self.fixed_owner = self._fixed()

    def _conduction(self, unknowns: Any, tests: Any, c: Any, o: Any) -> Any:
        T = unknowns.T_solid
        return (self.conductivity + conductivity(T, self.optics.diffusion)) * o.dot(
            o.grad(T), o.grad(tests.T_solid)
        )

    def start(self) -> Any:
        """Return the mean of the temperatures of the walls."""
        state = np.full(self.system.size, 0.5 * sum(self.T_span))
        state[self.fixed] = self.fixed_values
        return state

    @property
    def space(self) -> Any:
        """The space of the temperature."""
        return self.system.fields["T_solid"][0]

    def incident(self, state: Any) -> Any:
        """Return G at the nodes [W/m2], that of black radiation."""
        return radiation.emitted(self.temperature(state))

    def flux(self, state: Any, probe: Any) -> Any:
        """Return the radiative flux along the axis at the points of a probe [W/m2]."""
        T = self.temperature(state)
        slope = probe.slope(self.space, T, self.mesh.axis)
        return -conductivity(probe(self.space, T), self.optics.diffusion) * slope

    def fluxes(self, state: Any) -> dict[str, float]:
        """Return no fluxes besides what the medium conducts at its walls [W]."""
        return dict.fromkeys(self.mesh.boundaries, 0.0)

    def released(self, state: Any) -> float:
        """Return 0: no species has a temperature of its own [W]."""
        return 0.0
