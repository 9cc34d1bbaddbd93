"""What is wrong with a scene of particles although every single value is right."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contbed.dem import scene as p
from contbed.dem.heat import VORONOI
from contbed.dem.particle_files import (
    FileParticles,
    read_particles,
    tells_radii,
)
from contbed.dem.particles import Material
from contbed.dem.plan import porosity_of
from contbed.dem.sizes import CUT
from contbed.dem.softness import DENSER, too_soft
from contbed.dem.walls import REACHES, SKIN
from contbed.errors import SceneError
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.solids import the_only
from contbed.scene.toml_lines import KeyPath, Origin

# diameters: a packing has hot and cold layers of three together, and a slope is read
# between them
LOWEST = 5.0
LATTICE: KeyPath = ("particles", "lattice")
PACKING: KeyPath = ("particles", "packing")
LAYERS: KeyPath = ("particles", "layers")
PATHS: KeyPath = ("particles", "paths")
Solids = Mapping[str, p.Solid]


def one_source(particles: p.Particles) -> Mistakes:
    """Require one of a lattice, a file of particles and a packing."""
    sources = ("file", "lattice", "packing")
    given = [name for name in sources if getattr(particles, name) is not None]
    if not given:
        yield ("particles",), "give one of file, lattice, packing"
    for name in given[1:]:
        yield ("particles", name), f"there is a {given[0]} already; remove one"


def lattice_has_no_layers(particles: p.Particles, see: See) -> Mistakes:
    """Refuse layers of fixed temperature in a lattice, which is a periodic cell."""
    if particles.lattice is not None and particles.layers is not None:
        lattice = see("particles.lattice")
        yield LAYERS, f"a lattice is a periodic cell and has no layers; see {lattice}"


def spheres_have_a_diameter(particles: p.Particles, solids: Solids) -> Mistakes:
    """Require the diameter of spheres that the scene places."""
    name, solid = the_only(solids)
    placed = particles.lattice is not None or particles.packing is not None
    if placed and solid.diameter is None:
        yield ("solids", name, "diameter"), "missing; allowed: a number > 0 m"
    if particles.packing is None and solid.size_spread:
        yield ("solids", name, "size_spread"), "is for spheres of a packing"


def contact_is_small(particles: p.Particles, solids: Solids, see: See) -> Mistakes:
    """Require contacts smaller than the spheres of a lattice."""
    (name, solid), lattice = the_only(solids), particles.lattice
    if lattice is None or solid.radius is None:
        return
    if lattice.contact_radius >= solid.radius:
        diameter = see(f"solids.{name}.diameter")
        text = f"is not below the radius of the particles; see {diameter}"
        yield (*LATTICE, "contact_radius"), text


def packing_is_complete(particles: p.Particles, solids: Solids, see: See) -> Mistakes:
    """Require one size of the bed and one number of spheres, in a bed that they fit
    into.
    """
    packing, (name, solid) = particles.packing, the_only(solids)
    if packing is None:
        return
    if (packing.count is None) == (packing.height is None):
        yield PACKING, "give either count, the number of spheres, or height"
    if (packing.width is None) == (packing.cylinder is None):
        text = "give either width, of a box, or cylinder, the radius of a round bed"
        yield PACKING, text
        return
    if packing.cylinder is not None and packing.periodic:
        cylinder = see("particles.packing.cylinder")
        yield (
            (*PACKING, "periodic"),
            f"a cylinder has no periodic sides; see {cylinder}",
        )
    if solid.diameter is not None:
        yield from _fits_into_the_bed(packing, name, solid, see)


def _fits_into_the_bed(
    packing: p.Packing, name: str, solid: p.Solid, see: See
) -> Mistakes:
    """Require a bed that is wide enough for its spheres, and high enough to measure
    heat.
    """
    diameter = solid.diameter or 0.0
    key = "width" if packing.width is not None else "cylinder"
    narrow = 2.0 * (packing.cylinder or 0.0)
    if packing.width is not None:
        narrow = min(packing.width)
    largest = diameter * (1.0 + CUT * solid.size_spread)
    least, what = largest, "one of the largest spheres"
    if packing.periodic:
        least = REACHES * largest * (1.0 + 0.5 * SKIN)
        what = "three of the largest spheres and room"
    if narrow < least:
        yield (
            (*PACKING, key),
            f"the bed is {narrow:.4g} m wide; it must be {least:.4g} m at least, "
            f"{what}; see {see(f'solids.{name}.diameter')}",
        )
        return
    number = packing.number(solid)
    if not number:
        return
    height = packing.expected_height(solid)
    if height < LOWEST * diameter:
        yield (
            (*PACKING, "height" if packing.count is None else "count"),
            f"{number} spheres make a bed about {height:.3g} m high; heat is measured "
            f"in beds of {LOWEST:g} diameters, {LOWEST * diameter:.3g} m, at least",
        )


def packing_conducts(particles: p.Particles, solids: Solids) -> Mistakes:
    """Require paths of heat that a packing has, and the area of a bed from a file."""
    layers, packing, paths = particles.layers, particles.packing, particles.paths
    if layers is not None and particles.file is not None and layers.area is None:
        text = "missing; give the cross-section of the bed in m2"
        yield (*LAYERS, "area"), text
    if packing is None:
        return
    name, solid = the_only(solids)
    if layers is not None and layers.area is not None:
        text = f"is that of the packing, {packing.area:.4g} m2; remove this line"
        yield (*LAYERS, "area"), text
    if paths in VORONOI and solid.size_spread > 0.0:
        spread = f"solids.{name}.size_spread"
        yield PATHS, f"{paths} are for equal particles; use cones, or {spread} = 0"
    if paths in VORONOI and packing.cylinder is not None:
        yield PATHS, f"{paths} end at flat walls; use cones, or a packing in a box"


def contacts_have_a_stiffness(
    particles: p.Particles, solids: Solids, see: See
) -> Mistakes:
    """Require Young's modulus of the material where contacts are of a simulation."""
    name, solid = the_only(solids)
    simulated = particles.simulated_modulus
    if simulated is None or solid.youngs_modulus is not None:
        return
    text = (
        "missing; give Young's modulus of the material (glass 6.9e10 Pa, alumina "
        "4.16e11 Pa), or a material of the library. The contacts of the simulation, "
        f"at {simulated:g} Pa, are too large and would conduct several times too "
        "much. The same value as particles.modulus takes them as they are"
    )
    if particles.modulus is not None:
        text += f"; see {see('particles.modulus')}"
    yield ("solids", name, "youngs_modulus"), text


def layers_are_apart(particles: p.Particles, see: See) -> Mistakes:
    """Require that the hot layer lies below the cold one and is hotter."""
    layers = particles.layers
    if layers is None:
        return
    if layers.bottom >= layers.top:
        top = see("particles.layers.top")
        yield (*LAYERS, "bottom"), f"is not below the top; see {top}"
    if layers.T_hot <= layers.T_cold:
        cold = see("particles.layers.T_cold")
        yield (
            (*LAYERS, "T_hot"),
            f"is not above T_cold = {layers.T_cold:g} K; see {cold}",
        )


def gas_is_there(particles: p.Particles, gas: p.Gas | None) -> Mistakes:
    """Require a gas where columns or a closure need one."""
    if gas is not None:
        return
    if particles.paths in VORONOI:
        yield (
            PATHS,
            f"{particles.paths} are paths through the gas; give gas.conductivity",
        )
    if particles.closure is not None:
        text = (
            "its ratios are those to the gas, which is missing; give gas.conductivity"
        )
        yield ("particles", "closure"), text


def closure_has_points(particles: p.Particles, see: See) -> Mistakes:
    """Require more ratios than the polynomial of a closure has terms."""
    closure = particles.closure
    if closure is None:
        return
    count = len(set(closure.ratios))
    if count < closure.degree + 2:
        degree = see("particles.closure.degree")
        yield (
            ("particles", "closure", "ratios"),
            f"{count} ratios are too few to fit {closure.degree + 1} terms "
            f"and their errors; give more, or lower {degree}",
        )


def radiation_suits(
    particles: p.Particles, solids: Solids, radiation: p.Radiation | None, see: See
) -> Mistakes:
    """Refuse columns together with radiation, and radiation without an emissivity."""
    if radiation is None:
        return
    if particles.paths == "columns":
        text = "columns are for equal particles without [radiation]; use cones"
        yield PATHS, f"{text}; see {see('radiation')}"
    name, solid = the_only(solids)
    if solid.emissivity is None:
        text = f"missing; radiation needs it; see {see('radiation')}"
        yield ("solids", name, "emissivity"), text


def spreading_suits(
    particles: p.Particles, solids: Solids, gas: p.Gas | None, see: See
) -> Mistakes:
    """Require particles that conduct no worse than the gas where heat spreads into
    them.
    """
    if particles.paths != "spreading" or gas is None:
        return
    name, solid = the_only(solids)
    if solid.conductivity < gas.conductivity:
        yield (
            ("solids", name, "conductivity"),
            "is below that of the gas, and spreading paths are for particles "
            f"that conduct better than the gas; see {see('gas.conductivity')}",
        )
    closure = particles.closure
    if closure is not None and min(closure.ratios) < 1.0:
        text = f"go below 1, where spreading paths end; see {see('particles.paths')}"
        yield ("particles", "closure", "ratios"), text


def rough_surfaces_are_complete(
    particles: p.Particles, solids: Solids, gas: p.Gas | None, see: See
) -> Mistakes:
    """Require spreading paths for rough particles, and all properties of their
    contacts.
    """
    name, solid = the_only(solids)
    keys = ("asperity_slope", "microhardness")
    roughness = see(f"solids.{name}.roughness")
    if solid.roughness is None:
        for key in keys:
            if getattr(solid, key) is not None:
                yield ("solids", name, key), "has no use without a roughness"
        return
    if particles.paths != "spreading":
        path = see("particles.paths")
        text = f'is for paths = "spreading" alone; see {path}'
        yield ("solids", name, "roughness"), text
    for key in (*keys, "youngs_modulus"):
        if getattr(solid, key) is None:
            yield (
                ("solids", name, key),
                f"missing; rough contacts need it; see {roughness}",
            )
    if gas is None or gas.mean_free_path is None:
        text = f"missing; rough contacts need it; see {roughness}"
        yield ("gas", "mean_free_path"), text


def file_can_be_used(
    particles: p.Particles, solids: Solids, origin: Origin
) -> Mistakes:
    """Read the file as for a run, so that both say the same."""
    if particles.file is None:
        return
    try:
        yield from _mistakes_in_file(particles, solids, origin)
    except SceneError as error:
        yield from ((("particles", "file"), text) for text in error.problems)


def _mistakes_in_file(
    particles: p.Particles, solids: Solids, origin: Origin
) -> Mistakes:
    assert particles.file is not None
    name, solid = the_only(solids)
    path, key = origin.base / particles.file, ("particles", "file")
    if "\0" in particles.file or not path.is_file():
        yield key, f"no such file; looked for {path.absolute()}"
        return
    if solid.diameter is None and not tells_radii(path):
        text = f"missing; {particles.file} has no radii"
        yield ("solids", name, "diameter"), text
        return
    found = read_particles(path, solid.radius)
    yield from _fits(found, particles)


def _fits(found: FileParticles, particles: p.Particles) -> Mistakes:
    """Require that the other tables suit the particles of the file."""
    layers = particles.layers
    if particles.paths in VORONOI and np.ptp(found.radius) > 0:
        text = "are for equal particles without [radiation]; use cones"
        yield PATHS, f"{particles.paths} {text}"
    if layers is not None and layers.area is None:
        return
    if layers is None:
        if not all(found.periodic):
            text = "this table is missing; the box of"
            yield LAYERS, f"{text} {particles.file} is not periodic on all sides"
        return
    z = found.x[:, 2]
    hot, cold = z < layers.bottom, z > layers.top
    if not hot.any() or not cold.any():
        yield (
            (*LAYERS, "top" if hot.any() else "bottom"),
            f"layers of {hot.sum()} hot and {cold.sum()} cold particles; each needs "
            f"particles of its own; centres are from {z.min():.4g} to {z.max():.4g} m",
        )
    elif particles.porosity is None:
        eps = porosity_of(layers, *found[:2], found.box)
        if not 0.0 < eps < 1.0:
            text = f"gives a porosity of {eps:.3g} between the layers"
            yield (*LAYERS, "area"), f"{text}; it must lie in (0, 1)"


CHECKS = (
    one_source,
    lattice_has_no_layers,
    spheres_have_a_diameter,
    contact_is_small,
    packing_is_complete,
    packing_conducts,
    contacts_have_a_stiffness,
    layers_are_apart,
    gas_is_there,
    closure_has_points,
    radiation_suits,
    spreading_suits,
    rough_surfaces_are_complete,
    file_can_be_used,
)


def packing_bears_itself(particles: p.Particles, solids: Solids) -> Mistakes:
    """Look for spheres so soft that the packing is denser under its weight than one
    of hard spheres.
    """
    packing, solid = particles.packing, the_only(solids)[1]
    radius, modulus = solid.radius, particles.simulated_modulus
    if packing is None or radius is None or modulus is None:
        return
    if not packing.number(solid):
        return
    height = packing.expected_height(solid)
    if found := too_soft(height, radius, Material.of(solid, modulus)):
        denser, enough = found
        yield (
            ("particles", "modulus"),
            f"so soft that a packing about {height:.2g} m high is {denser:.1%} denser "
            f"by its weight, with more and larger contacts; {enough:.2g} Pa keep that "
            f"to {DENSER:.0%}",
        )


WARNINGS: tuple[Check, ...] = (packing_bears_itself,)
