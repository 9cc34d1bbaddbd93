"""Run of a scene of particles: conductances of pairs, the network of resistors, a
closure over conductivities.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.dem import extract, heat, network, plausibility
from contbed.dem.heat_pair import correction
from contbed.dem.particle_files import write_particles
from contbed.dem.plan import ParticlePlan, settled
from contbed.dem.results import fill
from contbed.dem.scene import ParticleScene
from contbed.dem.surface import Surface
from contbed.result import Result

# relative reach of contacts beyond touching, for the rounding of a lattice's
# coordinates
TOUCH = 1e-9
# of the porosity: packings of the same spheres from other random starts differ by less
SCATTER = 0.01


def run(
    plan: ParticlePlan, result: Result, folder: Path | None, quiet: bool, start: Any
) -> None:
    """Solve the network and fill the result; files go into `folder`, `start` has no
    use.

    A packing is settled first. `folder` gets a closure file, and the spheres of a
    packing.

    Raises
    ------
    SceneError : the network has no solution, or the ratios do not determine the closure
    EngineError, ConvergenceError : the packing does not settle
    """
    scene = plan.scene
    if scene.particles.packing is not None:
        with result.timed("packing"):
            plan = settled(plan, folder, quiet)
        if folder is not None:
            write_particles(folder / "packing.vtu", plan.x, {"radius": plan.radius})
    with result.timed("heat"):
        _conduct(plan, result, folder)


def _conduct(plan: ParticlePlan, result: Result, folder: Path | None) -> None:
    """Solve the network of the particles and fill the result."""
    scene = plan.scene
    pairs = _pairs(plan)
    parts = _conductances(plan, pairs, scene.solid.conductivity)
    found = _solve(plan, pairs, parts)
    fill(
        result,
        plan,
        found,
        int((parts["contact"] > 0).sum()),
        _correction(scene),
    )
    _judge_contacts(plan, pairs, result)
    conducted = {}
    if scene.particles.closure is not None:
        conducted = _fit_closure(plan, pairs, result, folder)
    if scene.k_gas is not None:
        ratio = scene.solid.conductivity / scene.k_gas
        k = _by_conduction(plan, pairs, parts, found.mean)
        judged = {ratio: k / scene.k_gas} | conducted
        result.warnings += plausibility.judge(
            judged, plan.porosity, scene.particles.paths, _radii(plan).ndim == 0
        )
    result.warnings += plausibility.of_radiation(result.qoi.get("share_radiation", 0.0))


def _pairs(plan: ParticlePlan) -> heat.Pairs:
    """Find the pairs that exchange heat: with a fluid or radiation within 1.5
    diameters, else those that touch.
    """
    table = plan.scene.particles
    if table.paths in heat.VORONOI:
        return heat.voronoi_pairs(plan.x, plan.box, plan.periodic)
    reach = 2.0 * float(plan.radius.max())
    reach *= (
        heat.VIEW
        if plan.scene.gas is not None or plan.scene.radiation is not None
        else 1.0 + TOUCH
    )
    return heat.near_pairs(plan.x, reach, plan.box, plan.periodic)


def _conductances(plan: ParticlePlan, pairs: heat.Pairs, k: float) -> dict[str, Array]:
    """Find the conductances [W/K] by mechanism of particles of conductivity
    k [W/m/K].
    """
    scene = plan.scene
    parts = heat.conductances(pairs, _radii(plan), _conduction(plan, k))
    if scene.radiation is not None:
        d = 2.0 * float(plan.radius.mean())
        emissivity = scene.solid.emissivity
        assert emissivity is not None
        parts["radiation"] = heat.radiation_conductance(
            pairs,
            len(plan.x),
            scene.radiation.temperature,
            d,
            emissivity,
            0.0 if scene.gas is None else plan.porosity,
        )
    return parts


def _conduction(plan: ParticlePlan, k: float) -> heat.Conduction:
    """Return how particles of conductivity k [W/m/K] conduct."""
    scene = plan.scene
    lattice = scene.particles.lattice
    return heat.Conduction(
        k,
        scene.k_gas,
        plan.porosity,
        _correction(scene),
        None if lattice is None else lattice.contact_radius,
        scene.particles.paths,
        _surface(scene),
    )


def _radii(plan: ParticlePlan) -> Array:
    """Return one radius [m] of equal particles, else that of each."""
    equal = np.ptp(plan.radius) == 0
    return np.asarray(plan.radius[0] if equal else plan.radius)


def _judge_contacts(plan: ParticlePlan, pairs: heat.Pairs, result: Result) -> None:
    """Report the ranges in which the closures of rough contacts were used, and warn
    of contacts that bear more than the solid can.
    """
    scene = plan.scene
    how = _conduction(plan, scene.solid.conductivity)
    if how.surface is None:
        return
    R = float(plan.radius[0])
    r_contact = heat.contact_radii(pairs, R, how)
    result.closures += [use.to_dict() for use in how.surface.uses(r_contact, R)]
    result.warnings += how.surface.judge(r_contact, R)


def _solve(
    plan: ParticlePlan, pairs: heat.Pairs, parts: dict[str, Array]
) -> network.Layers | network.Cell:
    layers, z = plan.layers, plan.x[:, 2]
    if layers is None:
        return network.periodic_cell(
            len(plan.x), pairs, parts, float(np.prod(plan.box[1] - plan.box[0]))
        )
    assert layers.area is not None
    hot, cold = z < layers.bottom, z > layers.top
    return network.between_layers(
        plan.x, pairs, parts, hot, cold, layers.area, (layers.T_hot, layers.T_cold)
    )


def _by_conduction(
    plan: ParticlePlan, pairs: heat.Pairs, parts: dict[str, Array], k: float
) -> float:
    """Return the conductivity [W/m/K] without radiation, where `k` includes it."""
    if "radiation" not in parts:
        return k
    rest = {name: part for name, part in parts.items() if name != "radiation"}
    return _solve(plan, pairs, rest).mean


def _correction(scene: ParticleScene) -> float:
    """Return the contact radius of the material over that of a softer simulation."""
    simulated, real = scene.particles.simulated_modulus, scene.solid.youngs_modulus
    if simulated is None or real is None:
        return 1.0
    return float(correction(simulated, real, scene.particles.exponents[0]))


def _surface(scene: ParticleScene) -> Surface | None:
    """Return the rough surface of the particles and the gas at it; None of smooth
    ones.
    """
    solid, gas = scene.solid, scene.gas
    if solid.roughness is None:
        return None
    assert solid.asperity_slope is not None and solid.microhardness is not None
    assert solid.youngs_modulus is not None
    assert gas is not None and gas.mean_free_path is not None
    return Surface(
        solid.roughness,
        solid.asperity_slope,
        solid.microhardness,
        solid.youngs_modulus,
        solid.poisson_ratio,
        gas.mean_free_path,
        gas.accommodation,
        gas.heat_capacity_ratio,
        gas.prandtl,
    )


def _fit_closure(
    plan: ParticlePlan, pairs: heat.Pairs, result: Result, folder: Path | None
) -> dict[float, float]:
    """Fit the effective conductivity over ratios of conductivity and write
    closure.toml; return k_eff/k_fluid by conduction at each ratio.
    """
    from contbed.scene.identity import scene_hash

    scene = plan.scene
    table, fluid = scene.particles.closure, scene.k_gas
    assert table is not None and fluid is not None
    ratios = np.unique(table.ratios)
    k, conducted = [], {}
    for ratio in ratios:
        parts = _conductances(plan, pairs, ratio * fluid)
        found = _solve(plan, pairs, parts).mean
        k.append(found / fluid)
        conducted[float(ratio)] = _by_conduction(plan, pairs, parts, found) / fluid
    eps = plan.porosity + SCATTER * np.linspace(-1.0, 1.0, len(ratios))
    data = {extract.RATIO: ratios, "eps": eps}
    fit = extract.fit_log_polynomial(
        "conductivity", data, k, {extract.RATIO: "log"}, (table.degree,)
    )
    result.qoi["closure_residual"] = fit.content["residuals"]["largest"]
    if folder is not None:
        fit.write(
            folder / "closure.toml",
            {"scene": Path(scene.origin.name).name, "scene_hash": scene_hash(scene)},
        )
    return conducted
