"""Radiation in a packed bed: its level in words, and the coupling with the
temperatures of the solid.
"""

from __future__ import annotations

from typing import Any

from contbed.packed_bed import scene as s


def described_level(scene: s.Scene) -> tuple[str, str]:
    """Describe the level of the radiation."""
    table = scene.radiation
    if table is None:
        return "radiation", "no [radiation] table"
    if table.level == "rosseland":
        return "radiation", "Rosseland limit: a conductivity of the solid"
    from contbed.radiation.plan import level_name

    return "radiation", f"{level_name(table)}, coupled to the solid"


def coupling(scene: s.Scene) -> Any:
    """Return the coupling with incident radiation, a further unknown; None for
    scenes without.
    """
    if scene.radiation is None or scene.radiation.level == "rosseland":
        return None
    from contbed.radiation.problem import RadiationCoupling

    return RadiationCoupling(scene)
