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
    """Bind the closures that a scene names; return them by kind."""
    given = {kind: getattr(scene.closures, kind) for kind in GIVES}
    return {
        kind: bind(spec, kind, GIVES[kind], scene.origin.base)
        for kind, spec in given.items()
        if spec is not None
    }


def bound_tube(tube: g.GasTube) -> BoundClosure:
    """Bind the Nusselt number of a tube."""
    return bind(tube.nusselt, "nusselt_cylinder", AT_TUBE)
