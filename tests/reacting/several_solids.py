"""Scenes of beds with several kinds of particles."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

SHARES = {"coarse": 0.3, "fine": 0.7}


def part_of(name: str, kind: str) -> float:
    """Share that a kind has of a profile of one kind alone: of moles per volume of bed that of its volume."""
    return SHARES[kind] if name.startswith("n_") else 1.0


def split(scene: dict[str, Any], shares: dict[str, float] = SHARES, **changes: dict[str, Any]) -> dict[str, Any]:
    """The particles of a scene as kinds that differ in nothing but their share, or in `changes` by kind."""
    out = deepcopy(scene)
    solid, diameter = out.pop("solid"), out["bed"].pop("particle_diameter")
    out["solids"] = {
        kind: {**deepcopy(solid), "volume_share": share, "particle_diameter": diameter, **changes.get(kind, {})}
        for kind, share in shares.items()
    }
    return out


def split_adsorbing(
    scene: dict[str, Any], shares: dict[str, float] = SHARES, **changes: dict[str, Any]
) -> dict[str, Any]:
    """The particles of a scene that adsorb as kinds, each with the same isotherms or those in `changes`."""
    out = split(scene, shares)
    return _with_each(out, {"adsorption": out.pop("adsorption")}, changes)


def split_pellets(
    scene: dict[str, Any], shares: dict[str, float] = SHARES, **changes: dict[str, Any]
) -> dict[str, Any]:
    """The pellets of a scene as kinds in which all reactions run, with its diffusivities or those in `changes`."""
    out = split(scene, shares)
    out = _with_each(out, {"diffusivity": out["particle"].pop("diffusivity")}, changes)
    running = [kind for kind, table in out["solids"].items() if table["diffusivity"]]
    for reaction in out["reactions"].values():
        reaction["solid"] = running
    return out


def _with_each(scene: dict[str, Any], given: dict[str, Any], changes: dict[str, dict[str, Any]]) -> dict[str, Any]:
    for kind, table in scene["solids"].items():
        table |= deepcopy(given) | changes.get(kind, {})
    return scene
