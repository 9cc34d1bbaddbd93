"""Named results of solids that leave: of each kind and of all, and of iron ore."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.reacting_bed.equations.kinds import KindsBed, of_kind
from contbed.reacting_bed.laws import IRON
from contbed.reacting_bed.problem import Problem

ATOMS = dict(zip(IRON, (2.0, 3.0, 1.0, 1.0), strict=True))  # of iron
OXYGEN = dict(zip(IRON, (3.0, 4.0, 1.0, 0.0), strict=True))


def of_iron(amounts: Mapping[str, float]) -> dict[str, float]:
    """Return metallization and degree of reduction of iron oxides, from moles or fluxes of each."""
    iron = sum(ATOMS[name] * amounts.get(name, 0.0) for name in IRON)
    oxygen = sum(OXYGEN[name] * amounts.get(name, 0.0) for name in IRON)
    return {"metallization": amounts["Fe"] / iron, "reduction": 1.0 - oxygen / (1.5 * iron)}


def fill_kinds(problem: Problem, amounts: Mapping[str, float], qoi: dict[str, Any]) -> None:
    """Add what leaves of each kind that moves and of all; `amounts` by constituent and kind [mol/m3 bed]."""
    bed, species = problem.bed, problem.species
    assert isinstance(bed, KindsBed)
    reacting = {name for part in bed.parts.values() for name in part.layout.solids}
    total = 0.0
    leaving: dict[str, float] = {}
    fed: dict[str, float] = {}
    for kind, part in bed.parts.items():
        v, own = abs(part.velocity_solid), species.kinds[kind].solids
        if not v:
            continue
        there = {name: amounts[of_kind(name, kind)] for name in own}
        mass = v * (sum(n * own[name].molar_mass for name, n in there.items()) if own else part.medium.solids_density)
        qoi[f"solids_{kind}_out_kg_m2s"] = mass
        total += mass
        for name, n in there.items():
            leaving[name] = leaving.get(name, 0.0) + v * n
            fed[name] = fed.get(name, 0.0) + v * problem.streams.solid[of_kind(name, kind)]
        if "Fe" in part.layout.solids:
            qoi |= {of_kind(name, kind): value for name, value in of_iron(there).items()}
    qoi["solids_out_kg_m2s"] = total
    for name, n in leaving.items():
        if name in reacting and fed[name] and n < fed[name]:
            qoi[f"conversion_{name}"] = 1.0 - n / fed[name]
    if "Fe" in reacting and "Fe" in leaving:
        qoi |= of_iron(leaving)
