"""The physics of contbed: the package of each, and the choice of the physics for a
scene.

Every physics is a package with the same modules, which are imported when they are used:

    scene.py    tables and keys of its scenes, with unit, bounds, default and meaning
    checks.py   CHECKS, mistakes in a scene that remain although every single value is valid, and WARNINGS, what is
                possible but seldom meant
    plan.py     plan(scene) -> Plan: what is built, what is left out and why, unknowns and cost
    run.py      run(plan, result, folder, quiet, start): solves and fills the result; RESTART_MAY_CHANGE, keys that may
                differ after a restart, if the plan has steps
    results.py  named results, profiles, tables and balances of a run
    plots.py    plot(result, folder): the plots of a run
    equations/  the equations, each file with its PDEs, symbols, units and source
    template.toml   a commented scene that runs as it is, for `contbed new`

Derivatives of results by keys need tangent.py with of(result) beside.
A new physics is such a package and one entry of MODELS; CONTRIBUTING.md lists the tests,
pages and tables that name it beside.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Protocol

from contbed.errors import SceneError


class Plan(Protocol):
    """The objects that a run builds before it solves."""

    @property
    def scene(self) -> Any:
        """The scene as written."""

    @property
    def mesh(self) -> Any:
        """The mesh that the run solves on; None without one."""

    @property
    def built(self) -> tuple[tuple[str, str], ...]:
        """Names of what is built, each with a description."""

    @property
    def skipped(self) -> tuple[tuple[str, str], ...]:
        """Names of what is left out, each with the reason."""

    @property
    def steps(self) -> bool:
        """Whether the run takes time steps, so that it can be restarted from a
        checkpoint.
        """

    @property
    def policy(self) -> Any:
        """Choice of the linear solver."""

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns of each part that is solved."""


@dataclass(frozen=True)
class Model:
    """One physics.

    package : its folder in contbed
    name : of the key `model` in a scene; several physics that are one model to a user
        have the same, and the tables decide between them
    settings : name of the pydantic model of its scenes in scene.py
    means : whether the top-level tables of a file make it a scene of this physics
    decides : the tables and keys by which it differs from others of its name
    equations : modules in the package whose docstrings `contbed explain` shows, by name
    compiles : whether its loops are compiled at their first use, which takes a while
    scatters : whether its results scatter with the start of the particles, so that
        small changes cannot be distinguished
    """

    package: str
    name: str
    settings: str
    means: Callable[[Mapping[str, Any]], bool]
    equations: Mapping[str, str]
    decides: str = ""
    compiles: bool = False
    scatters: bool = False

    def find(self, module: str, name: str) -> Any:
        """Import a module of the package and return its attribute `name`."""
        return getattr(import_module(f"contbed.{self.package}.{module}"), name)

    @property
    def scene(self) -> Any:
        """The pydantic model of the scenes of this physics."""
        return self.find("scene", self.settings)

    @property
    def template(self) -> Path:
        """The file of a commented scene that runs as it is, for `contbed new`."""
        return Path(__file__).parent / self.package / "template.toml"

    def sheets(self) -> dict[str, Path]:
        """Return the file of each set of equations by name, without importing it;
        with a slash it is that of another room.
        """
        rooms = Path(__file__).parent
        found = {}
        for name, module in self.equations.items():
            folder = rooms if "/" in module else rooms / self.package
            found[name] = folder / f"{module.replace('.', '/')}.py"
        return found


def _has(*tables: str) -> Callable[[Mapping[str, Any]], bool]:
    return lambda values: any(table in values for table in tables)


def _is_two_fluid(values: Mapping[str, Any]) -> bool:
    """Return whether a file has the table of two fluids, or a mesh with solids whose
    collisions it describes.
    """
    collide = any(
        {"restitution", "packing_limit"} <= each.keys()
        for each in _tables(*_items(values.get("solids")))
    )
    resolved = "mesh" in values and "particles" not in values
    return "two_fluid" in values or (collide and resolved)


def _is_bubbling_bed(values: Mapping[str, Any]) -> bool:
    # a misspelt name is reported itself, rather than all tables of the bed as unknown
    return any(
        get_close_matches(name.lower(), ["bubbling_bed"], n=1, cutoff=0.6)
        for name in values
    )


def _is_particles_in_gas(values: Mapping[str, Any]) -> bool:
    return "particles" in values and _has("boundary", "time", "fluid")(values)


def _is_particles(values: Mapping[str, Any]) -> bool:
    return _has("particles", "lattice", "packing")(values) or (
        "mesh" not in values and "conduction" in values
    )


def _is_one_particle(values: Mapping[str, Any]) -> bool:
    boundary = values.get("boundary")
    return _has("single_particle", "surroundings")(values) or (
        isinstance(boundary, dict) and "surface" in boundary
    )


def _only_radiates(values: Mapping[str, Any]) -> bool:
    return "radiation" in values and not _has(
        "heat", "gas", "fluid", "flow", "solid", "time", "region"
    )(values)


def _reacts(values: Mapping[str, Any]) -> bool:
    """Return whether the tables of a packed bed speak of species, and not of heat
    alone.
    """
    if any(get_close_matches(name, ["reactions"], cutoff=0.8) for name in values):
        return True
    # former names, which the reacting bed reports
    if _has("mass", "adsorption", "guess")(values):
        return True
    gas = _tables(values.get("gas"), values.get("fluid"))
    solids = _tables(values.get("solid"), *_items(values.get("solids")))
    # particles of several sizes, of which the other packed bed has one; those that
    # radiate have shares as well
    several = sum("volume_share" in each for each in solids) > 1
    if several and "radiation" not in values:
        return True
    entering = _tables(
        values.get("flow"),
        *(each.get("gas") for each in _tables(*_items(values.get("boundary")))),
    )
    return (
        any(each.get("model") == "ideal_gas" or "species" in each for each in gas)
        or any(
            {"composition", "constituent", "adsorption"} & each.keys()
            for each in solids
        )
        or (
            # such a gas has no species, whatever flux enters
            not any(_is_of_one_substance(each) for each in gas)
            and any(
                {"mass_flux", "molar_flux", "composition"} & each.keys()
                for each in entering
            )
        )
        or any(
            {"sherwood", "dispersion_mass"} & each.keys()
            for each in _tables(values.get("closures"))
        )
    )


def _is_of_one_substance(gas: Mapping[str, Any]) -> bool:
    """Return whether a table of a gas speaks of constants, a material or one fluid."""
    return bool(
        gas.get("model") in ("constant", "coolprop")
        or {"density", "material", "name"} & gas.keys()
    )


def _tables(*values: Any) -> list[dict[str, Any]]:
    """Return those of some values that are tables."""
    return [value for value in values if isinstance(value, dict)]


def _items(values: Any) -> list[Any]:
    """Return the values of a table of tables."""
    return list(values.values()) if isinstance(values, dict) else []


# the first that a scene fits; the packed bed takes all others
MODELS: dict[str, Model] = {
    "two_fluid": Model(
        "two_fluid",
        "two_fluid",
        "TwoFluidScene",
        _is_two_fluid,
        {
            "two_fluid": "equations",
            "two_fluid_heat": "heat.equations",
            "two_fluid_walls": "heat.wall_layer",
        },
        compiles=True,
        scatters=True,
    ),
    "developed_flow": Model(
        "developed_flow",
        "developed_flow",
        "DevelopedScene",
        _has("developed_flow", "fully_developed"),
        {"developed_flow": "equations"},
    ),
    "bubbling_bed": Model(
        "bubbling_bed",
        "bubbling_bed",
        "BubblingScene",
        _is_bubbling_bed,
        {
            "bubbling_bed": "equations.bed",
            "bubbling_flow": "equations.flow",
            "bubbling_species": "equations.species",
            "freeboard": "equations.freeboard",
            "steam": "equations.steam",
        },
    ),
    "particles_gas": Model(
        "cfd_dem",
        "particles",
        "GasScene",
        _is_particles_in_gas,
        {"particles_gas": "gas"},
        "[particles] beside [time] or [boundary]",
        compiles=True,
        scatters=True,
    ),
    "particles": Model(
        "dem",
        "particles",
        "ParticleScene",
        _is_particles,
        {"particles": "network"},
        compiles=True,
        scatters=True,
    ),
    "single_particle": Model(
        "single_particle",
        "single_particle",
        "SingleParticleScene",
        _is_one_particle,
        {"single_particle": "equations"},
    ),
    "radiation": Model(
        "radiation",
        "radiation",
        "RadiationScene",
        _only_radiates,
        {"radiation": "equations.p1", "ordinates": "equations.ordinates"},
    ),
    "reacting_bed": Model(
        "reacting_bed",
        "packed_bed",
        "ReactingScene",
        _reacts,
        {
            "reacting_bed": "equations.bed",
            "surface_mechanisms": "chemistry/surface",
            "gas_inside_particles": "particle/adsorption",
            "reacting_section": "equations.section",
            "amounts_above_zero": "steady_positivity",
            "amounts_above_zero_in_time": "positivity_in_time",
            "cells_in_time": "time_cells",
            "cells_in_time_hold_the_same": "remap",
            "cyclic_steady_state": "cycle",
        },
        "[reactions], [gas.species], solids.NAME.adsorption or a gas.composition that enters",
    ),
    "packed_bed": Model(
        "packed_bed",
        "packed_bed",
        "Scene",
        lambda values: True,
        {
            "two_energy": "equations.two_energy",
            "porous_flow": "equations.porous_flow",
            "schumann": "schumann",
        },
    ),
}


class Kind(Protocol):
    """A scene, as far as the choice of its physics needs it."""

    kind: ClassVar[str]


def model_of(scene: Kind) -> Model:
    """Return the physics that a scene is for.

    Raises
    ------
    SceneError : a file or tables in place of a scene
    """
    if not hasattr(scene, "kind"):
        text = f'"{scene}"' if isinstance(scene, str | Path) else "..."
        raise SceneError(f"a scene is needed here; contbed.load({text}) makes one")
    return MODELS[scene.kind]


def solver_of(scene: Kind) -> Callable[..., None]:
    """Return what runs plans of the physics of a scene, with one thread of BLAS, see
    `threads.single_blas`.
    """
    from contbed.compiled.blas import single_blas

    run: Callable[..., None] = model_of(scene).find("run", "run")
    return single_blas()(run)


def names() -> list[str]:
    """Return what the key `model` of a scene may hold."""
    return list(dict.fromkeys(model.name for model in MODELS.values()))


def kind_of(values: Mapping[str, Any]) -> str:
    """Return the kind of scene that the key `model` or else the tables of a file name.

    An unknown name counts as none, so that the schema refuses it with those that exist.
    """
    named = values.get("model")
    kinds = [kind for kind, model in MODELS.items() if model.name == named]
    fits = [kind for kind in kinds or MODELS if MODELS[kind].means(values)]
    return fits[0] if fits else kinds[-1]


def plan(scene: Any) -> Any:
    """Decide what a scene needs and build its mesh.

    Raises
    ------
    SceneError : mesh, flow or closures of the scene cannot be used

    Examples
    --------
    >>> from contbed.loading import load
    >>> plan(load(MODELS["packed_bed"].template)).unknowns()["heat"] > 100
    True
    """
    return model_of(scene).find("plan", "plan")(scene)
