"""Closures of a fully developed flow: their keys in [closures], and the arguments
available to them.
"""

from __future__ import annotations

from contbed.closures.binding import BoundClosure, bind
from contbed.developed_flow import scene as d

KINDS = {
    "drag": "drag",
    "radial_distribution": "radial_distribution",
    "granular_pressure": "granular_pressure",
    "granular_viscosity": "granular_viscosity",
    "granular_conductivity": "granular_conductivity",
    "granular_dissipation": "granular_dissipation",
    "granular_production": "granular_production",
    "turbulence": "eddy_viscosity",
}
_THEORY = frozenset({"eps_s", "eps_max", "e", "g0"})
GIVES: dict[str, frozenset[str]] = {
    "drag": frozenset({"Re", "eps", "d_p", "mu"}),
    "radial_distribution": _THEORY - {"g0"},
    **dict.fromkeys(
        (kind for kind in KINDS.values() if kind.startswith("granular_")), _THEORY
    ),
    "eddy_viscosity": frozenset(
        {"y", "radius", "u_friction", "nu", "shear_rate", "drag_rate", "eps_s"}
    ),
}
"""The arguments that closures of each kind can have."""


def bound(scene: d.DevelopedScene) -> dict[str, BoundClosure]:
    """Return the closures of a scene by kind."""
    base = scene.origin.base
    named = {kind: getattr(scene.closures, key) for key, kind in KINDS.items()}
    return {
        kind: bind(name, kind, GIVES[kind], base)
        for kind, name in named.items()
        if name is not None
    }
