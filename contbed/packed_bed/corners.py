"""Corners in which unlike prescribed temperatures meet.

Near such a corner the solution of Laplace's equation depends on the angle phi only, T = T_1 + (T_2 - T_1) phi/(pi/2),
so that the heat conducted through either side, k (T_2 - T_1)/(pi/2) times the integral of dr/r, has no limit.
"""

from __future__ import annotations

from itertools import combinations

from contbed.packed_bed import scene as s
from contbed.scene.checking import Mistakes
from contbed.scene.mesh import Mesh, MeshFile, MeshLine


def prescribed_temperatures_agree_in_corners(
    mesh: Mesh, boundary: dict[str, s.Boundary], heat: s.Heat | None
) -> Mistakes:
    """Look for sides with unlike prescribed temperatures that meet, where the conducted heat has no limit."""
    if isinstance(mesh, MeshFile | MeshLine) or heat is None:
        return
    direction = {name: k for k, names in enumerate(mesh.sides) for name in names}
    for phase in ("fluid", "solid"):
        if getattr(heat, f"conductivity_{phase}") == 0.0:
            continue
        conditions = {name: getattr(table, phase) for name, table in boundary.items() if name in direction}
        fixed = {
            name: condition.fixed
            for name, condition in conditions.items()
            if condition is not None and isinstance(condition.fixed, float)
        }
        for (name, value), (other, unlike) in combinations(fixed.items(), 2):
            if direction[name] != direction[other] and value != unlike:
                yield (
                    ("boundary", other, phase, "fixed"),
                    f"{unlike:g} K meets {value:g} K of boundary.{name} in a corner, where heat_{name}_W and "
                    f"heat_{other}_W grow without limit as cells get smaller, and T_{phase} has no value; the "
                    "estimated error counts there by the distance only. For a heat that means something give one of "
                    "both sides a coefficient and ambient, or equal temperatures",
                )
