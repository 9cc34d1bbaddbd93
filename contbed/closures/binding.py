"""Which closure a scene means: the kind's prefix may be left out, further keys are the closure's own parameters."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from contbed.closures import registry
from contbed.errors import SceneError
from contbed.scene.quantities import ClosureFile
from contbed.scene.tables import Closure

PHASE = "conductivity_phase"
# Arguments that a model knows and passes by itself, by kind; all others without a default come from the scene.
_STREAM = frozenset({"Re", "Pr", "Pe", "eps", "T", "d_p", "D_bed", "k_fluid"})
_PACKING = frozenset({"d_p", "eps"})
# of a bubbling bed, at one height
_BUBBLING = frozenset({
    "Ar", "Pr", "Re", "eps", "eps_mf", "T", "p", "d_p", "D_bed", "sphericity", "rho_gas", "mu", "cp_gas", "k_gas",
    "molar_mass", "D_gas", "rho_solid", "cp_solid", "k_solid", "u", "u_mf", "u_excess", "u_b", "u_t", "u_gas", "d_b",
    "delta", "slip", "f_1", "f_2", "d_1", "d_2", "rho_1", "rho_2", "cp_1", "cp_2", "k_1", "k_2",
})  # fmt: skip
SUPPLIED = {
    "nusselt": _STREAM,
    "dispersion": _STREAM,
    "wall": _STREAM | {"k_stagnant"},
    "conductivity": frozenset({"k_fluid", "k_solid", "eps", "T", "d_p"}),
    "tortuosity": frozenset({"k_fluid", "k_solid", "eps"}),
    "drag": frozenset({"Re", "eps", "d_p", "mu"}),
    **dict.fromkeys(
        (
            "minimum_fluidization",
            "bubble_size",
            "bubble_start",
            "bubble_growth",
            "bubble_rise",
            "bubble_fraction",
            "emulsion_gas",
            "bubble_heat",
            "gas_exchange",
            "solids_mixing",
            "solid_exchange",
            "bed_tube",
            "terminal_velocity",
            "expansion",
            "ejection",
            "decay",
            "elutriation",
        ),
        _BUBBLING,
    ),
    "permeability": _PACKING,
    "forchheimer": _PACKING,
    **dict.fromkeys(
        (
            "radial_distribution",
            "granular_pressure",
            "granular_viscosity",
            "granular_bulk_viscosity",
            "granular_conductivity",
            "granular_dissipation",
            "granular_friction",
        ),
        frozenset({"eps_s", "eps_max", "g0", "e"}),
    ),
    "granular_friction_viscosity": frozenset({"p_friction", "angle", "shear_rate"}),
}

Function = Callable[..., Any]


def is_phase(spec: object) -> bool:
    """Whether the conductivity is that of the phase times its share of the volume, which is no closure."""
    name = spec.name if isinstance(spec, Closure) else spec
    return name in (PHASE, "phase")


def resolve_closure(
    spec: str | Closure | ClosureFile, kind: str, base: Path = Path()
) -> tuple[Function, dict[str, Any]]:
    """The function that a scene names, "gunn" or "nusselt_gunn", and the parameters set beside the name.

    A closure's file is looked for in `base`, the folder of the scene.
    """
    if isinstance(spec, ClosureFile):
        from contbed.closures.file import closure_of

        return closure_of(spec.file, base, kind), {}
    name, parameters = _split(spec)
    function = registry.get(_full_name(name, kind, registry.names(kind)), kind)
    _check(name, parameters, [function])
    return function, parameters


def resolve_dispersion(spec: str | Closure) -> tuple[Function, Function, dict[str, Any]]:
    """The axial and the transverse function of a dispersion closure, and the parameters set beside the name."""
    name, parameters = _split(spec)
    stems = [known.removesuffix("_axial") for known in registry.names("dispersion") if known.endswith("_axial")]
    pair = registry.dispersion_pair(_full_name(name, "dispersion", stems))
    _check(name, parameters, [pair.axial, pair.transverse])
    return pair.axial, pair.transverse, parameters


def own_parameters(function: Function, parameters: dict[str, Any]) -> dict[str, Any]:
    """Those of the parameters that this function takes; the two of a dispersion pair may differ."""
    return {key: value for key, value in parameters.items() if key in inspect.signature(function).parameters}


def _split(spec: str | Closure) -> tuple[str, dict[str, Any]]:
    return (spec, {}) if isinstance(spec, str) else (spec.name, dict(spec.model_extra or {}))


def _full_name(name: str, kind: str, known: tuple[str, ...] | list[str]) -> str:
    prefixed = f"{kind}_{name}"
    if name in known or name in registry.names():
        return name
    # An unknown short name is looked for with its prefix, so that the nearest names are found.
    return prefixed if prefixed in known or not name.startswith(f"{kind}_") else name


def _check(name: str, parameters: dict[str, Any], functions: list[Function]) -> None:
    sheets = [function.sheet for function in functions]  # type: ignore[attr-defined]
    supplied = SUPPLIED[sheets[0].kind]
    options = {key: value for sheet in sheets for key, value in sheet.options.items()}
    arguments = dict.fromkeys(argument for sheet in sheets for argument in sheet.arguments)
    for key, value in parameters.items():
        if key not in options and key not in arguments:
            known = ", ".join([*(key for key in arguments if key not in supplied), *options]) or "none"
            raise SceneError(f"closure {name!r} has no parameter {key!r}; its parameters: {known}")
        if isinstance(options.get(key), str):
            if not isinstance(value, str):
                raise SceneError(f"parameter {key!r} of closure {name!r} is a text, found {value!r}")
        elif isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise SceneError(f"parameter {key!r} of closure {name!r} is a finite number in SI, found {value!r}")
    if missing := [key for key in arguments if key not in supplied and key not in parameters]:
        example = ", ".join(f"{key} = ..." for key in missing)
        raise SceneError(f'closure {name!r} needs {", ".join(missing)}: {{name = "{name}", {example}}}')
