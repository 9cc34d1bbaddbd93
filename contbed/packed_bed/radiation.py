"""Radiation in a packed bed: the level that its plan takes, and the coupling with
the temperatures of the solid.
"""

from __future__ import annotations

from typing import Any

from contbed.packed_bed import scene as s


def cheapest(scene: s.Scene) -> tuple[s.Scene, str]:
    """Return the scene, with a Rosseland conductivity where allowed and accurate,
    and the reason.
    """
    if scene.radiation is None or not scene.radiation.allow_rosseland:
        return scene, ""
    from contbed.radiation.rosseland import choose

    return choose(scene)


def described_level(scene: s.Scene, thick: str) -> tuple[str, str]:
    """Describe the level of the radiation.

    `thick` says how accurate Rosseland would be where that is allowed.
    """
    table = scene.radiation
    if table is None:
        return "radiation", "no [radiation] table"
    if table.level == "rosseland":
        how = "Rosseland limit: a conductivity of the solid"
    else:
        from contbed.radiation.plan import level_name

        how = f"{level_name(table)}, coupled to the solid"
    return "radiation", f"{how}; {thick}" if thick else how


def coupling(scene: s.Scene) -> Any:
    """Return the coupling with incident radiation, a further unknown; None for
    scenes without.
    """
    if scene.radiation is None or scene.radiation.level == "rosseland":
        return None
    from contbed.radiation.problem import RadiationCoupling

    return RadiationCoupling(scene)
