"""Closures of particles in a gas, and the arguments that the gas around each
particle gives them.
"""

from __future__ import annotations

from contbed.cfd_dem import scene as g
from contbed.closures.binding import BoundClosure, bind

GIVES: dict[str, frozenset[str]] = {
    "drag": frozenset({"Re", "eps", "d_p", "mu"}),
    "nusselt": frozenset({"Re", "Pr", "eps"}),
}
"""The arguments that closures of each kind can have."""

AT_TUBE = frozenset({"Re", "Pr"})
"""Those of a tube."""


def bound(scene: g.GasScene) -> dict[str, BoundClosure]:
    """Bind the closures of a scene; return them by kind."""
    return {
        kind: bind(getattr(scene.closures, kind), kind, gives, scene.origin.base)
        for kind, gives in GIVES.items()
    }


def bound_tube(tube: g.GasTube) -> BoundClosure:
    """Bind the Nusselt number of a tube."""
    return bind(tube.nusselt, "nusselt_cylinder", AT_TUBE)
