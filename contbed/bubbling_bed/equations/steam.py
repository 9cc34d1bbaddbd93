"""Water or steam inside of the tubes or walls of a bubbling bed; a `Part` of the bed.

    +-m h'                     = q               upward or downward, h(inlet) given
    p h_i (T_x - T_w(h))       = q               metal
    q                          = p h_x (T - T_x) + radiation          what the bed gives to the surface at T_x

m        mass flow of the water [kg/s]           h        enthalpy [kJ/kg]
T_w      temperature of water, steam or both at the given pressure as a function of h [K]
p        perimeter [m]                           h_i      coefficient inside, on the outer surface, metal included
T_x      temperature of the outer surface [K], an unknown of the bed's `Surface`

Good values: h_i 2-10 kW/m2/K where water boils, 0.5-2 kW/m2/K in superheaters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from contbed.bubbling_bed.equations.bed import convected, radiated
from contbed.bubbling_bed.equations.coefficients import Part

KILO = 1e3


@dataclass(frozen=True)
class Steam(Part):
    """The water side of the surface `name`."""

    name: str
    flow: float  # m [kg/s]
    inlet: float  # [kJ/kg]
    conductance: float  # p h_i [W/m/K]
    temperature: Callable[[Any], Any]  # T_w, function of h [kJ/kg]
    upward: bool

    @property
    def fields(self) -> tuple[str, ...]:
        """Enthalpy of the water and temperature of the surface."""
        return (f"h_{self.name}", f"T_{self.name}")

    @property
    def initial(self) -> dict[str, float]:
        """Values that Newton's method starts from."""
        return {
            f"h_{self.name}": self.inlet,
            f"T_{self.name}": float(self.temperature(self.inlet)) + 10.0,
        }

    def content(self, u: Any, tests: Any, c: Any, o: Any) -> Any:
        """Return a tested content by which the water approaches its steady state."""
        return KILO * sum(
            (getattr(u, name) * getattr(tests, name) for name in self.fields), start=0.0
        )

    def gained(self, u: Any, c: Any, local: Any) -> Any:
        """Return the heat q that the water takes up [W/m]."""
        return convected(u, c, self.name, local) + radiated(u, c, c.surfaces[self.name])

    def residual(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form of both balances; that of the water is also tested
        along its stream (SUPG).
        """
        h = getattr(u, f"h_{self.name}")
        T = getattr(u, f"T_{self.name}")
        # the heat that particles lose is in the bed's own balances
        q = self.gained(u, c, local)
        sense = 1.0 if self.upward else -1.0
        v = getattr(tests, f"h_{self.name}")
        total = (sense * KILO * self.flow * o.grad(h)[0] - q) * (
            v + 0.5 * sense * o.h * o.grad(v)[0]
        )
        return total + (self.conductance * (T - self.temperature(h)) - q) * getattr(
            tests, f"T_{self.name}"
        )

    def _enters(self, u: Any, tests: Any) -> Any:
        h = getattr(u, f"h_{self.name}")
        return KILO * self.flow * (h - self.inlet) * getattr(tests, f"h_{self.name}")

    def bottom(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form of the inlet of water that flows upward."""
        return self._enters(u, tests) if self.upward else 0.0

    def top(self, u: Any, tests: Any, c: Any, local: Any, o: Any) -> Any:
        """Return the weak form of the inlet of water that flows downward."""
        return 0.0 if self.upward else self._enters(u, tests)
