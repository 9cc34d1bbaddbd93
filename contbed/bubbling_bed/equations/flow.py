"""Gas of a bubbling bed between emulsion and bubbles, and the size of bubbles, along
the height.

    W_b = W - rho_e A (1 - delta) u_e         flow of the bubbles: what the emulsion does not take
    d_b' = growth(d_b, ...),   d_b(0) = start

W, W_b   mass flow of all gas and of the bubbles [kg/s]      A        section [m2]
delta    share of bubbles in the volume [1]                  u_e      gas through the emulsion, per its section [m/s]
d_b      diameter of the sphere of a bubble's volume [m]     rho_e    density of the emulsion's gas [kg/m3]

u_e, delta, growth and start are closures of the unknowns at the same place. Velocities
follow from the flows, u = (W - W_b) / (rho_e A) + W_b / (rho_b A), so that the volume
of cold bubbles is theirs.

The equations are multiplied by a heat per kg, and per m, so that their residuals
compare with those of heat.

Good values: u 2 to 10 times that at minimum fluidization, bubbles of 10-300 mm, beds of
0.3-3 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass
class Local:
    """Coefficients at the points of one domain; growth and start are None where the
    bubble size is a number.
    """

    flow: Any  # W_b by the closures [kg/s]
    growth: Any = None  # d_b' [1]
    start: Any = None  # d_b at the distributor [m]
    heat: float = 1.0  # [J/kg]
    heat_size: float = 1.0  # [W/m]


def residual(u: Any, tests: Any, c: Local, o: Any) -> Any:
    """Return the weak form of the equations; growth is also tested along the stream
    (SUPG).
    """
    total = c.heat * (u.flow_bubble - c.flow) * tests.flow_bubble
    if c.growth is not None:
        v = tests.d_bubble
        total = total + c.heat_size * (o.grad(u.d_bubble)[0] - c.growth) * (
            v + 0.5 * o.h * o.grad(v)[0]
        )
    return total


def bottom(u: Any, tests: Any, c: Local, o: Any) -> Any:
    """Return the weak form of the bubbles at the distributor."""
    return (
        0.0
        if c.start is None
        else c.heat_size * (u.d_bubble - c.start) * tests.d_bubble
    )
