"""Scenes of beds with several kinds of particles."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

SHARES = {"coarse": 0.3, "fine": 0.7}


def part_of(name: str, kind: str) -> float:
    """Share that a kind has of a profile of one kind alone: of moles per volume of
    bed that of its volume.
    """
    return SHARES[kind] if name.startswith("n_") else 1.0


def split(
    scene: dict[str, Any], shares: dict[str, float] = SHARES, **changes: dict[str, Any]
) -> dict[str, Any]:
    """The particles of a scene as kinds that differ in nothing but their share, or
    in `changes` by kind.
    """
    out = deepcopy(scene)
    solid = out["solids"].pop("particles")
    out["solids"] = {
        kind: {**deepcopy(solid), "volume_share": share, **changes.get(kind, {})}
        for kind, share in shares.items()
    }
    for table in out["boundary"].values():
        if "solids" in table:
            stream = table["solids"].pop("particles")
            table["solids"] = {kind: deepcopy(stream) for kind in shares}
    return out


def split_pellets(
    scene: dict[str, Any], shares: dict[str, float] = SHARES, **changes: dict[str, Any]
) -> dict[str, Any]:
    """The pellets of a scene as phases in which all reactions run, with its
    diffusivities or those in `changes`.
    """
    out = split(scene, shares, **changes)
    running = [
        phase
        for phase, table in out["solids"].items()
        if table["inside"]["diffusivity"]
    ]
    for reaction in out["reactions"].values():
        reaction["solid"] = running
    return out
