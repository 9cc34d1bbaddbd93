"""Results of a reacting bed: element balances, conversion, gas composition,
efficiencies, ranges of rate laws.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from contbed.balance import Balance
from contbed.bubbling_bed.chemistry import reactions as cr
from contbed.bubbling_bed.chemistry import thermo
from contbed.bubbling_bed.chemistry.of_boilers import (
    boiler_findings,
    unburnt_fuel,
    unburnt_sulphur,
)
from contbed.bubbling_bed.chemistry.problem import Chemistry
from contbed.bubbling_bed.chemistry.streams import streams_of
from contbed.chemistry.elements import ATOMIC_WEIGHTS
from contbed.chemistry.thermo import T_STANDARD, Thermo
from contbed.errors import ConvergenceError
from contbed.materials.common import share_outside
from contbed.result import Result

ELEMENTS = ("C", "H", "O", "N", "S", "Ca")
SOLIDS = {
    "moisture": "H2O(l)",
    "char": "C",
    "CaCO3": "CaCO3",
    "CaO": "CaO",
    "CaSO4": "CaSO4",
}
# mole fraction either side of zero that balances of the others do not resolve
ROUNDING = 1e-14
# share of the volume of the solids by which char may differ from its volume_share
FAR_FROM_DECLARED = 0.1


def profiles(chemistry: Chemistry, values: dict[str, Any]) -> dict[str, Any]:
    """Return the mole fractions of both phases and the inventory of each solid."""
    part, out = chemistry.part, dict[str, Any]()
    for phase in part.phases:
        out |= mole_fractions(part, values, phase)
    for name in part.solids:
        out[f"{name} [{'kg' if name == 'volatiles' else 'mol'}/m]"] = values[
            f"n_{name}"
        ]
    return out


def mole_fractions(part: Any, values: dict[str, Any], phase: str) -> dict[str, Any]:
    """Return the mole fractions of a phase by header."""
    flows = {name: values[f"N_{name}_{phase}"] for name in part.gases}
    total = sum(flows.values())
    return {
        f"x_{name}_{phase} [1]": without_rounding(flow, total) / total
        for name, flow in flows.items()
    }


def fill(problem: Any, chemistry: Chemistry, state: Any, result: Result) -> None:
    """Fill in balances, named results and warnings."""
    part, data, scene = chemistry.part, chemistry.data, problem.plan.scene
    streams = streams_of(problem, chemistry, state)
    entering, leaving = (
        {name: sum(flows[name] for flows in each.values()) for name in part.gases}
        for each in (streams.entering, streams.leaving)
    )
    drained = streams.drained
    _elements(chemistry, (entering, streams.fed), (leaving, drained), result)

    total = sum(leaving.values())
    dry = total - leaving.get("H2O", 0.0)
    qoi = result.qoi
    qoi["gas_out_mol_s"] = total
    shown = {name: float(without_rounding(n, total)) for name, n in leaving.items()}
    qoi |= {f"x_{name}_wet": n / total for name, n in shown.items()}
    qoi |= {f"x_{name}_dry": n / dry for name, n in shown.items() if name != "H2O"}
    if data is not None:
        lost = _fuel(chemistry, entering, leaving, drained, qoi)
        boiler_findings(problem, chemistry, state, streams, qoi)
        result.warnings += unburnt_fuel(lost, qoi, scene.reactions)
        result.warnings += unburnt_sulphur(qoi, scene.reactions)
    held = {
        name: problem.total(lambda u, o, n=name: getattr(u, f"n_{n}"), state)
        for name in part.solids
    }
    qoi |= {
        f"held_{name}_{'kg' if name == 'volatiles' else 'mol'}": amount
        for name, amount in held.items()
    }
    if scene.limestone is not None:
        calcium = sum(drained.get(name, 0.0) for name in ("CaCO3", "CaO", "CaSO4"))
        if calcium > 0:
            qoi["calcined"] = 1.0 - drained["CaCO3"] / calcium
            qoi["lime_sulphated"] = drained["CaSO4"] / calcium
        if data is not None and data.elements["S"] > 0:
            qoi["Ca_S"] = calcium / data.elements["S"]
    _warnings(problem, chemistry, state, held, result)


def contents(chemistry: Chemistry) -> dict[str, dict[str, float]]:
    """Return the elements in a mole of each gas and solid, and in a kg of volatiles."""
    species = thermo.table()
    out: dict[str, dict[str, float]] = {
        name: dict(gas.composition) for name, gas in chemistry.part.gases.items()
    }
    out |= {
        name: dict(species[SOLIDS[name]].composition)
        for name in chemistry.part.solids
        if name in SOLIDS
    }
    if chemistry.data is not None and chemistry.data.volatiles is not None:
        out["volatiles"] = dict(chemistry.data.volatiles.elements)
    return out


def _elements(
    chemistry: Chemistry, entering: Any, leaving: Any, result: Result
) -> None:
    inside = contents(chemistry)
    others = {element for atoms in inside.values() for element in atoms}
    for element in (*ELEMENTS, *sorted(others - set(ELEMENTS))):
        brought, taken = (
            sum(
                amount * inside[name].get(element, 0.0)
                for stream in streams
                for name, amount in stream.items()
            )
            for streams in (entering, leaving)
        )
        if brought > 0:
            result.balances[element] = Balance(
                brought, taken, "mol/s", scale=brought
            ).as_dict()


def heating_value(fuel: Thermo) -> float:
    """Return the lower heating value at 298.15 K [J/mol]."""
    species, T0, atoms = thermo.table(), T_STANDARD, fuel.composition
    burnt = {
        "CO2": atoms.get("C", 0.0),
        "H2O": 0.5 * atoms.get("H", 0.0),
        "SO2": atoms.get("S", 0.0),
    }
    left = sum(n * species[key].enthalpy(T0) for key, n in burnt.items())
    return float(fuel.enthalpy(T0) - left)


FUELS = ("CO", "H2", "CH4", "C6H6", "H2S")
BURNS = {"C": 1.0, "H": 0.25, "S": 1.0, "O": -0.5}  # O2 per atom


def _fuel(
    chemistry: Chemistry, entering: Any, leaving: Any, drained: Any, qoi: dict[str, Any]
) -> dict[str, float]:
    """Fill in what becomes of the fuel; return the heating value of each gas and solid
    that leaves unburnt [W].
    """
    data, inside = chemistry.data, contents(chemistry)
    assert data is not None
    carbon = sum(
        drained[name] * inside[name].get("C", 0.0)
        for name in ("char", "volatiles")
        if name in drained
    )
    qoi["carbon_conversion"] = 1.0 - carbon / data.elements["C"]
    gases, coke = chemistry.part.gases, heating_value(thermo.table()["C"])
    burning = [name for name in (*FUELS, *gases) if name in gases]
    values = {
        name: heating_value(gases[name])
        for name in dict.fromkeys(burning)
        if name in FUELS or name not in thermo.GASES
    }
    gas = {name: leaving[name] * value for name, value in values.items()}
    # gas that enters may be fuel as well
    power, needed = data.rate * data.lower, data.oxygen
    for name, value in values.items():
        atoms, amount = inside[name], entering.get(name, 0.0)
        power += amount * value
        needed += amount * sum(n * atoms.get(key, 0.0) for key, n in BURNS.items())
    solids = {"char": drained.get("char", 0.0) * coke}
    per_kg = 0.0
    if data.volatiles is not None:
        fixed = 1.0 - data.volatile / data.rate
        per_kg = data.lower - fixed / ATOMIC_WEIGHTS["C"] * coke
        per_kg *= data.rate / data.volatile
    solids["volatiles"] = drained.get("volatiles", 0.0) * per_kg
    in_gas, unburnt = sum(gas.values()), sum(solids.values())
    qoi["fuel_power_W"] = power
    qoi["cold_gas_efficiency"] = in_gas / power
    oxygen = qoi["oxygen_ratio"] = entering.get("O2", 0.0) / needed
    burnt = 1.0 - (in_gas + unburnt) / power
    sulphur = data.elements["S"]
    if sulphur > 0 and "CaSO4" in drained:
        qoi["sulphur_capture"] = drained["CaSO4"] / sulphur
    if oxygen > 0.0:
        qoi["combustion_efficiency"] = burnt
        qoi["ignited"] = float(burnt > 0.5 * min(1.0, oxygen))
    return gas | solids


def _fits(scene: Any, share: float, result: Result) -> None:
    """Raise ConvergenceError where the char that the balances leave does not fit
    between the particles of the bed.
    """
    if share > 1.0:
        key = ("solids", scene.fuel, "fuel")
        raise ConvergenceError(
            f"{scene.origin.place(key)}: the bed cannot hold its char, which would fill "
            f"{100 * share:.3g} % of the volume of the solids (char_volume_fraction): "
            "if bubbles carry the oxygen through the bed, give smaller ones "
            "(bubbling_bed.bubbles.size as a number); else feed less fuel, more oxygen "
            "or steam, drain faster by bubbling_bed.drain.time, or enlarge "
            "bubbling_bed.section",
            result.history,
        )


def _beside_declared(scene: Any, share: float) -> list[str]:
    """Return the warning that the bed holds another share of char than it declares."""
    declared = scene.solids[scene.fuel].volume_share
    if abs(share - declared) <= FAR_FROM_DECLARED:
        return []
    key = f"solids.{scene.fuel}.volume_share"
    return [
        f"char fills {100 * share:.3g} % of the volume of the solids "
        f"(char_volume_fraction), {key} = {declared:g} declares "
        f"{100 * declared:.3g} %: minimum fluidization, mean diameter and the surfaces "
        f"of other solids are those of the declared share; give {key} between both "
        "with the shares of the others, and run again"
    ]


def without_rounding(amounts: Any, total: Any) -> Any:
    """Return amounts, zero where they are below `ROUNDING` of the total either way;
    larger negative ones stay.
    """
    return np.where(np.abs(amounts) <= ROUNDING * np.abs(total), 0.0, amounts)


def _below_zero(
    gases: Iterable[str], phases: Iterable[str], profiles: Mapping[str, Any], plan: Any
) -> str | None:
    """Return the warning about the least mole fraction; None where it is within the
    error of automatic meshes.
    """
    scene, chosen = plan.scene, plan.mesh.skfem.nelements
    tolerance = scene.solver.tolerance
    advice = "give more mesh.cells, or none for a mesh that is chosen"
    if scene.mesh.cells is None:
        advice = f"give mesh.cells, more than the {chosen} that are chosen"
    columns = {
        (name, phase): profiles[f"x_{name}_{phase} [1]"]
        for phase in phases
        for name in gases
    }
    # a phase of the bed has none above it
    (name, phase), x = min(columns.items(), key=lambda item: np.nanmin(item[1]))
    if not np.nanmin(x) < -tolerance:
        return None
    z = profiles["z [m]"][np.nanargmin(x)]
    return (
        f"{name} in the {phase} falls to a mole fraction of {np.nanmin(x):.2g} at z = "
        f"{z:.3g} m, further below zero than "
        f"solver.tolerance = {tolerance:g}: {advice}"
    )


def _warnings(
    problem: Any,
    chemistry: Chemistry,
    state: Any,
    held: dict[str, float],
    result: Result,
) -> None:
    part, scene = chemistry.part, problem.plan.scene
    for name in chemistry.idle:
        result.warnings.append(
            f"reactions.{name} does not run: a gas that it needs neither enters nor is "
            "made"
        )
    phases = part.phases if problem.above is None else (*part.phases, "freeboard")
    below = _below_zero(part.gases, phases, result.profiles, problem.plan)
    if below is not None:
        result.warnings.append(below)
    if scene.fuel is not None:
        fuel = scene.solids[scene.fuel].fuel
        volume = held.get("char", 0.0) * ATOMIC_WEIGHTS["C"] / fuel.char_density
        delta = (
            problem.total(lambda u, o: problem.c.at(u, o).delta, state)
            / chemistry.height
        )
        solids = part.section * chemistry.height * (1.0 - delta) * (1.0 - part.voidage)
        result.qoi["char_volume_fraction"] = volume / solids
        _fits(scene, volume / solids, result)
        result.warnings += _beside_declared(scene, volume / solids)
    for name, where, law in cr.used_laws(chemistry.reactions):
        fields = (
            [f"T_{phase}" for phase in phases] if where == "gas" else [f"T_{where}"]
        )
        T = np.concatenate([problem.system.part(state, field) for field in fields])
        outside = share_outside(T, law.T_range)
        if outside > 0:
            low, high = law.T_range
            result.warnings.append(
                f"reactions.{name}: {law.name} is used out of its range on "
                f"{100 * outside:.3g} % of the height, "
                f"{T.min():.4g} to {T.max():.4g} K, declared {low:g} to {high:g} K"
            )
        kind = "gas reaction" if where == "gas" else "reaction of particles"
        result.closures.append(
            {
                "name": f"{name}: {law.name}",
                "kind": kind,
                "source": law.source,
                "share_outside": outside,
                "ranges": {
                    "T": {
                        "declared": list(law.T_range),
                        "used": [float(T.min()), float(T.max())],
                        "share_outside": outside,
                    }
                },
            }
        )
