"""Coefficients of a bubbling bed from its scene: frozen numbers, or functions of the
state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

from contbed.bubbling_bed import scene as b
from contbed.bubbling_bed.equations import coefficients as model
from contbed.bubbling_bed.solids import Solid
from contbed.bubbling_bed.tables import Freeboard, Release
from contbed.closures import optics
from contbed.errors import SceneError
from contbed.materials.constants import mixture_of

# temperature at which layers are predicted where the scene gives lower ones [K]
HOT = 1000.0


FLOW = ("boundary", "bottom", "gas", "mass_flow")  # key of the gas that enters


def coefficients(
    scene: b.BubblingScene, typical: dict[str, Any] | None = None
) -> model.Coefficients:
    """Return the coefficients of the model, and the albedo of the emulsion where it
    radiates.

    `typical` are known numbers in place of those that layers are predicted from, where
    coefficients follow the state.
    """
    bed, present, level = scene.bubbling_bed, scene.present, scene.radiation.level
    surface = scene.surface_of_particles
    absorption, diffusion, albedo, eps_bed = np.zeros(len(present)), 0.0, None, 0.0
    if level != "none":
        found = optics_of(scene.radiation, scene.solids, bed.solids_fraction)
        absorption, albedo = found.absorption, float(found.albedo)
        eps_bed = float(optics.radiation_emissivity_half_space(albedo))
        if level in ("p1", "two_flux"):
            diffusion = float(found.diffusion(level))
    section = bed.section
    computed = computed_of(scene)
    if computed is None:
        number = _frozen(scene)
    elif typical is not None:
        number = typical
    else:
        _fluidized(scene, computed)
        number = typical_numbers(scene, computed)
    species = {
        name: model.Species(
            _solids(
                name, item, bed.height, section, number["conduction"][name], computed
            ),
            number["gas"][name],
            surface[name] / sum(surface.values()),
            float(absorption[k]),
            item.emissivity or 1.0,
        )
        for k, (name, item) in enumerate(present.items())
    }
    surfaces = {
        name: model.Surface(
            item.perimeter,
            number["contact"][name],
            HOT if item.temperature is None else item.temperature,
            float(optics.emissivity_immersed(eps_bed, item.emissivity))
            if eps_bed and item.emissivity
            else 0.0,
            None if item.steam is None else f"T_{name}",
        )
        for name, item in bed.surfaces.items()
    }
    plate = None
    if (table := bed.distributor) is not None:
        plate = model.Plate(
            table.coefficient,
            float(-np.expm1(-table.preheat_NTU)),
            table.emissivity or 0.0,
        )
    gases = {
        name: model.Stream(constant(flow)) for name, flow in number["flows"].items()
    }
    emulsion = replace(gases["T_emulsion"], release=_release(bed.release, section))
    return model.Coefficients(
        section,
        number["delta"],
        scene.inlet.temperature,
        species,
        number["pairs"],
        emulsion,
        gases.get("T_bubble"),
        number["exchange"],
        surfaces,
        plate,
        level if level not in ("p1", "two_flux") else "field",
        diffusion,
        _radiosity(bed.freeboard),
        scene.solver.degree,
        computed,
        albedo,
        computed.fields if computed is not None else (),
        (computed.parts if computed is not None else ()) + _water(scene),
    )


def typical_numbers(scene: b.BubblingScene, computed: Any) -> dict[str, Any]:
    """Return coefficients that follow the state at the highest temperature that the
    scene gives.
    """
    from contbed.bubbling_bed.frozen import frozen

    found: dict[str, Any] = frozen(computed, hottest(scene), scene.bubbling_bed.height)
    return found


def _water(scene: b.BubblingScene) -> tuple[Any, ...]:
    """Return the water sides of surfaces."""
    surfaces = scene.bubbling_bed.surfaces
    if all(item.steam is None for item in surfaces.values()):
        return ()
    from contbed.bubbling_bed.equations.steam import Steam
    from contbed.materials.steam import steam

    out = []
    for name, item in surfaces.items():
        table = item.steam
        if table is None:
            continue
        water = steam(table.pressure)
        conductance = item.perimeter * table.coefficient
        out.append(
            Steam(
                name,
                table.mass_flow,
                water.enthalpy(table.temperature),
                conductance,
                water.temperature,
                table.direction == "up",
            )
        )
    return tuple(out)


def computed_of(scene: b.BubblingScene) -> Any:
    """Return the coefficients as functions of the state; None where the scene gives
    frozen ones.
    """
    if not scene.computed:
        return None
    from contbed.bubbling_bed.coefficients import Computed

    return Computed(scene, mixture_of(scene.mixture, scene.origin.base))


def _fluidized(scene: b.BubblingScene, computed: Any) -> None:
    """Raise SceneError if the gas does not fluidize the bed at the temperature where
    Newton's method starts.
    """
    T, flow = scene.initial.temperature, computed.flow
    state, _ = computed.state(
        SimpleNamespace(**{f"T_{name}": T for name in scene.present}), flow
    )
    needed = float(state["rho_gas"] * state["u_mf"]) * scene.bubbling_bed.section
    if scene.bubbling_bed.bubbles is not None and flow <= needed:
        raise SceneError(
            f"{scene.origin.place(FLOW)} = {flow:g}: below minimum "
            "fluidization, "
            f"{needed:.4g} kg/s at {T:g} K, where the search for its temperatures "
            "begins; allowed: more, no [bubbling_bed.bubbles] or, if the bed is hotter, "
            "initial.temperature near to its own"
        )


def _frozen(scene: b.BubblingScene) -> dict[str, Any]:
    """Return the coefficients of a scene that gives them all as numbers."""
    present: dict[str, Any] = scene.present
    bed, bubbles = scene.bubbling_bed, scene.bubbling_bed.bubbles
    if bubbles is not None and bubbles.fraction == 0:
        bubbles = None
    return {
        "delta": bubbles.fraction if bubbles else 0.0,
        "gas": {
            name: surface * present[name].gas_coefficient
            for name, surface in scene.surface_of_particles.items()
        },
        "conduction": {
            name: bed.section * item.mixing_conductivity
            for name, item in present.items()
        },
        "pairs": {
            (name, other): value
            for name, item in present.items()
            for other, value in item.exchange.items()
            if other in present
        },
        "exchange": bubbles.exchange if bubbles else 0.0,
        "contact": {name: item.coefficient for name, item in bed.surfaces.items()},
        "flows": {"T_emulsion": scene.inlet.capacity_flow}
        | ({"T_bubble": bubbles.capacity_flow} if bubbles else {}),
    }


def optics_of(
    radiation: b.Radiation, solids: Mapping[str, Solid], solids_fraction: float
) -> optics.Optics:
    """Return the optical coefficients of the emulsion, which holds a volume fraction of
    solids.
    """
    particles = [
        optics.Species(
            name,
            solids_fraction * item.volume_share,
            item.diameter,
            float(item.emissivity or 0.0),
        )
        for name, item in solids.items()
        if item.volume_share > 0.0
    ]
    exchanges = radiation.level in ("paper", "pairwise")
    default = "independent" if exchanges else "close_packed"
    return optics.optics(
        particles, radiation.correction or default, radiation.anisotropy
    )


def constant(value: float) -> Any:
    """Return a constant function of height."""
    return lambda z: value + 0.0 * z


def _solids(
    name: str,
    item: Solid,
    height: float,
    section: float,
    conduction: float,
    computed: Any,
) -> model.Stream:
    heat: dict[str, Any] = {
        "conduction": conduction,
        "release": _release(item.release, section),
    }
    if computed is not None:
        heat |= {
            "enthalpy": partial(computed.enthalpy, name),
            "heat_capacity": partial(computed.heat_capacity, name),
        }
    feed = item.inert_feed
    flow = 0.0 if feed is None else feed.capacity_flow or feed.mass_flow
    if feed is None or not flow:
        return model.Stream(constant(0.0), **heat)
    share, below = feed.shares(height)
    drained = flow if feed.drain == "bottom" else 0.0
    return model.Stream(
        lambda z: flow * below(z) - drained,
        lambda z: flow * share(z),
        feed.temperature,
        **heat,
    )


def _release(table: Release | None, section: float) -> Any:
    if table is None or not table.rate:
        return None

    def release(z: Any, T: Any) -> Any:
        rate = (
            section
            * table.rate
            * (1.0 if table.length is None else np.exp(-z / table.length))
            + 0.0 * z
        )
        if table.activation is None or table.reference is None:
            return rate
        return rate * np.exp(-table.activation * (1.0 / T - 1.0 / table.reference))

    return release


def _radiosity(table: Freeboard | None) -> float | None:
    if table is None or table.height is not None:
        return None
    return (
        table.radiosity
        if table.temperature is None
        else optics.SIGMA * table.temperature**4
    )


def hottest(scene: b.BubblingScene) -> float:
    """Return the highest temperature that the scene gives [K]."""
    given = [scene.inlet.temperature]
    given += [item.temperature or 0.0 for item in scene.bubbling_bed.surfaces.values()]
    feeds = [item.inert_feed for item in scene.present.values()]
    given += [feed.temperature for feed in feeds if feed is not None]
    return max(*given, HOT)
