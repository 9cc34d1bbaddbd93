"""Named results of solids that leave: of each solid phase and of all, and of iron
ore.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.chemistry.laws.three_interfaces import IRON
from contbed.reacting_bed.problem import Problem

OXYGEN = dict(zip(IRON, (3.0, 4.0, 1.0, 0.0), strict=True))


def of_iron(amounts: Mapping[str, float]) -> dict[str, float]:
    """Return metallization and degree of reduction of iron oxides, from moles or
    fluxes of each.
    """
    iron = sum(atoms * amounts.get(name, 0.0) for name, atoms in IRON.items())
    oxygen = sum(OXYGEN[name] * amounts.get(name, 0.0) for name in IRON)
    return {
        "metallization": amounts["Fe"] / iron,
        "reduction": 1.0 - oxygen / (1.5 * iron),
    }


def fill_phases(
    problem: Problem, amounts: Mapping[str, float], qoi: dict[str, Any]
) -> None:
    """Add what leaves of each solid phase that moves and of all; `amounts` by full
    name [mol/m3 bed].
    """
    bed, species = problem.bed, problem.species
    several = len(bed.phases) > 1
    total = 0.0
    leaving: dict[str, float] = {}
    fed: dict[str, float] = {}
    reacting: set[str] = set()
    for name, phase in bed.phases.items():
        v, own = abs(phase.velocity), species.phases[name]
        reacting |= set(phase.layout.solids)
        if not v:
            continue
        there = {each: amounts[own.full(each)] for each in own.solids}
        density = sum(n * own.solids[each].molar_mass for each, n in there.items())
        mass = v * (density if there else phase.medium.density)
        total += mass
        if several:
            qoi[f"solids_{name}_out_kg_m2s"] = mass
        for each, n in there.items():
            leaving[each] = leaving.get(each, 0.0) + v * n
            fed[each] = fed.get(each, 0.0) + v * problem.streams.solid[own.full(each)]
        if "Fe" in phase.layout.solids:
            qoi |= {own.full(key): value for key, value in of_iron(there).items()}
    qoi["solids_out_kg_m2s"] = total
    if not several:
        return
    for name, n in leaving.items():
        if name in reacting and fed[name] and n < fed[name]:
            qoi[f"conversion_{name}"] = 1.0 - n / fed[name]
    if "Fe" in reacting and "Fe" in leaving:
        qoi |= of_iron(leaving)
