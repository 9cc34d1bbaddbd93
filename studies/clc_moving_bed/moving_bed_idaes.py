"""The moving bed in IDAES' unit model MBR: results and user CPU on given elements.

    moving_bed_idaes.py INPUTS.json

INPUTS.json has what enters (`length`, `diameter` of the vessel [m], `gas` {species:
mol/s}, `pressure` [Pa], `T_gas`, `T_solid` [K], `solids` [kg/s], `fractions` by mass,
`porosity` of the particles), `samples`, and `runs`: pairs of the Radau points of an
element, 0 for backward differences, and the ends of the elements from 0 to 1. Prints a
line of JSON for each run: unknowns, results, and medians of the user CPU [s] of model
and scaling, of the initialization of IDAES, of the solution from there, and of Ipopt in
all of them. Needs `pip install idaes-pse`, then `idaes get-extensions`.
"""

import json
import logging
import resource
import statistics
import sys
from itertools import pairwise
from pathlib import Path

import pyomo.environ as pyo
from idaes.core import FlowsheetBlock
from idaes.core.solvers import get_solver
from idaes.core.util.model_statistics import (
    number_unfixed_variables_in_activated_equalities,
)
from idaes.core.util.scaling import calculate_scaling_factors
from idaes.models_extra.gas_solid_contactors.properties.methane_iron_OC_reduction.gas_phase_thermo import (
    GasPhaseParameterBlock,
)
from idaes.models_extra.gas_solid_contactors.properties.methane_iron_OC_reduction.hetero_reactions import (
    HeteroReactionParameterBlock,
)
from idaes.models_extra.gas_solid_contactors.properties.methane_iron_OC_reduction.solid_phase_thermo import (
    SolidPhaseParameterBlock,
)
from idaes.models_extra.gas_solid_contactors.unit_models.moving_bed import MBR

# tolerance of Ipopt in the initialization, as in the example of IDAES, and at the end
FIRST, LAST = 1e-5, 1e-8
TRACE = 1e-9  # mass fraction of a solid that is absent, as in the example of IDAES


def user_time() -> tuple[float, float]:
    """User CPU of this process and of its children, which are runs of Ipopt [s]."""
    own, children = (
        resource.getrusage(who).ru_utime
        for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own + children, children


def model_of(inputs: dict, points: int, ends: list[float]) -> pyo.ConcreteModel:
    """The bed with what enters it, discretized and scaled."""
    model = pyo.ConcreteModel()
    model.fs = FlowsheetBlock(dynamic=False)
    model.fs.gas, model.fs.solids = GasPhaseParameterBlock(), SolidPhaseParameterBlock()
    model.fs.reaction = HeteroReactionParameterBlock(
        gas_property_package=model.fs.gas, solid_property_package=model.fs.solids
    )
    method = (
        {"transformation_method": "dae.collocation", "collocation_points": points}
        if points
        else {}
    )
    model.fs.bed = bed = MBR(
        finite_elements=len(ends) - 1,
        length_domain_set=ends,
        gas_phase_config={"property_package": model.fs.gas},
        solid_phase_config={
            "property_package": model.fs.solids,
            "reaction_package": model.fs.reaction,
        },
        **method,
    )
    bed.bed_height.fix(inputs["length"])
    bed.bed_diameter.fix(inputs["diameter"])
    moles = sum(inputs["gas"].values())
    bed.gas_inlet.flow_mol[0].fix(moles)
    bed.gas_inlet.pressure[0].fix(inputs["pressure"])
    bed.gas_inlet.temperature[0].fix(inputs["T_gas"])
    for name, flow in inputs["gas"].items():
        bed.gas_inlet.mole_frac_comp[0, name].fix(flow / moles)
    bed.solid_inlet.flow_mass[0].fix(inputs["solids"])
    bed.solid_inlet.temperature[0].fix(inputs["T_solid"])
    bed.solid_inlet.particle_porosity[0].fix(inputs["porosity"])
    for name, fraction in inputs["fractions"].items():
        bed.solid_inlet.mass_frac_comp[0, name].fix(fraction or TRACE)
    calculate_scaling_factors(model)
    return model


def initialize(model: pyo.ConcreteModel, inputs: dict) -> None:
    """Start from what enters, with the gas as hot as the solids, by the routine of
    IDAES.
    """
    moles = sum(inputs["gas"].values())
    model.fs.bed.initialize(
        outlvl=logging.ERROR,
        optarg={"tol": FIRST},
        gas_phase_state_args={
            "flow_mol": moles,
            "temperature": inputs["T_solid"],
            "pressure": inputs["pressure"],
            "mole_frac": {name: flow / moles for name, flow in inputs["gas"].items()},
        },
        solid_phase_state_args={
            "flow_mass": inputs["solids"],
            "temperature": inputs["T_solid"],
            "particle_porosity": inputs["porosity"],
            "mass_frac": inputs["fractions"],
        },
    )


def results_of(model: pyo.ConcreteModel, inputs: dict) -> dict[str, float]:
    """Results by the names of contbed."""
    gas, solids = model.fs.bed.gas_outlet, model.fs.bed.solid_outlet
    left = {
        "conversion_CH4": gas.flow_mol[0]
        * gas.mole_frac_comp[0, "CH4"]
        / inputs["gas"]["CH4"],
        "conversion_Fe2O3": solids.flow_mass[0]
        * solids.mass_frac_comp[0, "Fe2O3"]
        / (inputs["solids"] * inputs["fractions"]["Fe2O3"]),
    }
    return {name: 1.0 - pyo.value(share) for name, share in left.items()} | {
        "pressure_drop_Pa": inputs["pressure"] - pyo.value(gas.pressure[0]),
        "T_solid_out_K": pyo.value(solids.temperature[0]),
    }


def once(
    inputs: dict, points: int, ends: list[float]
) -> tuple[dict[str, float], list[float]]:
    """Results, and user CPU of the parts and of Ipopt [s]."""
    times = [user_time()]
    model = model_of(inputs, points, ends)
    times.append(user_time())
    initialize(model, inputs)
    times.append(user_time())
    pyo.assert_optimal_termination(get_solver(options={"tol": LAST}).solve(model))
    times.append(user_time())
    found = {
        "unknowns": number_unfixed_variables_in_activated_equalities(model),
        **results_of(model, inputs),
    }
    parts = [after[0] - before[0] for before, after in pairwise(times)]
    return found, [*parts, times[-1][1] - times[0][1]]


def main() -> None:
    logging.disable(logging.WARNING)
    if not pyo.SolverFactory("ipopt").available(exception_flag=False):
        sys.exit("IDAES finds no ipopt; install it with: idaes get-extensions")
    inputs = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    once(inputs, *inputs["runs"][0])  # warms up
    for points, ends in inputs["runs"]:
        found, times = zip(
            *(once(inputs, points, ends) for _ in range(inputs["samples"])), strict=True
        )
        parts = [statistics.median(column) for column in zip(*times, strict=True)]
        names = ("build_s", "initialize_s", "solve_s", "ipopt_s")
        print(json.dumps(found[-1] | dict(zip(names, parts, strict=True))), flush=True)


main()
