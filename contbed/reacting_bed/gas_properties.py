"""Properties of the gas of a reacting bed at a state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.unknowns import LEAST_T, State
from contbed.reacting_bed.substances import Substances


class Properties:
    """Properties of the gas at a state, each computed once, when it is needed."""

    def __init__(
        self,
        scene: s.ReactingScene,
        species: Substances,
        state: State,
        gas: Properties | None = None,
    ):
        self.scene, self.species, self.state = scene, species, state
        self._known: dict[str, Any] = {} if gas is None else gas._known

    def of(self, phase: str) -> Properties:
        """Return the same properties of the gas, at the state as a solid phase sees
        it.
        """
        return Properties(self.scene, self.species, self.state.phases[phase], self)

    def once(self, name: str, make: Callable[[], Any]) -> Any:
        """Return a value of this name, computed by `make` where it is not known yet."""
        if name not in self._known:
            self._known[name] = make()
        return self._known[name]

    @property
    def _x(self) -> list[Any]:
        return [self.state.x[name] for name in self.species.gases]

    @property
    def _T(self) -> Any:
        return self.once("T", lambda: np.maximum(self.state.T_fluid, LEAST_T))

    def _of(self, name: str) -> Any:
        transport = self.species.transport
        if transport is None or getattr(transport, name) is None:
            key = {
                "viscosities": "viscosity",
                "conductivities": "conductivity",
                "diffusivities": "diffusivity",
            }[name]
            raise SceneError(
                f"{self.scene.origin.at(('gas',))}: gas.{key}: is needed by a closure "
                "of this scene and not given; "
                f"give one number, or values in [gas.species.NAME]"
            )
        return transport

    @property
    def viscosity(self) -> Any:
        """Viscosity of the mixture [Pa s]."""
        return self.once(
            "mu", lambda: self._of("viscosities").viscosity(self._T, self._x)
        )

    @property
    def k_fluid(self) -> Any:
        """Conductivity of the mixture [W/m/K]."""
        return self.once(
            "k", lambda: self._of("conductivities").conductivity(self._T, self._x)
        )

    @property
    def diffusivities(self) -> list[Any]:
        """Diffusivities of all gases in the mixture [m2/s]."""
        found: list[Any] = self.once(
            "D",
            lambda: self._of("diffusivities").diffusivity(
                self._T, self.state.p, self._x
            ),
        )
        return found

    @property
    def prandtl(self) -> Any:
        """Prandtl number of the mixture."""

        def make() -> Any:
            cp = sum(
                self.state.x[name] * item.heat_capacity(self._T)
                for name, item in self.species.gases.items()
            )
            return (
                self.viscosity * cp * self.state.moles / self.state.flux / self.k_fluid
            )

        return self.once("Pr", make)

    def reynolds(self, diameter: float, slip: Any) -> Any:
        """Return the Reynolds number of particles by their diameter [m] and the
        velocity relative to them [m/s].
        """
        return self.state.rho * np.abs(slip) * diameter / self.viscosity
