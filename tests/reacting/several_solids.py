"""Scenes of beds with several kinds of particles."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

SHARES = {"coarse": 0.3, "fine": 0.7}


def split(scene: dict[str, Any], shares: dict[str, float] = SHARES, **changes: dict[str, Any]) -> dict[str, Any]:
    """The particles of a scene as kinds that differ in nothing but their share, or in `changes` by kind."""
    out = deepcopy(scene)
    solid, diameter = out.pop("solid"), out["bed"].pop("particle_diameter")
    out["solids"] = {
        kind: {**deepcopy(solid), "volume_share": share, "particle_diameter": diameter, **changes.get(kind, {})}
        for kind, share in shares.items()
    }
    return out
