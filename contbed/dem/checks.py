"""What is wrong with a scene of particles although every single value is right."""

from __future__ import annotations

import numpy as np

from contbed.dem import dumps
from contbed.dem import scene as p
from contbed.dem.heat import VORONOI
from contbed.dem.particle_files import FileParticles, missing_step, read_particles, tells_radii
from contbed.dem.particles import Material
from contbed.dem.plan import porosity_of
from contbed.dem.sizes import CUT
from contbed.dem.softness import DENSER, too_soft
from contbed.dem.walls import REACHES, SKIN
from contbed.scene.checking import Check, Mistakes, See
from contbed.scene.toml_lines import Origin

LOWEST = 5.0  # diameters: a packing has hot and cold layers of three together, and a slope is read between them


def one_source(
    lattice: p.Lattice | None, particles: p.Particles | None, packing: p.Packing | None, see: See
) -> Mistakes:
    """Require one of a lattice, a file of particles and a packing."""
    if packing is not None:
        for name, other in (("lattice", lattice), ("particles", particles)):
            if other is not None:
                yield ("packing",), f"the particles are given already; remove one; see {see(name)}"
    if lattice is not None and particles is not None:
        yield ("particles",), f"there is a lattice already; remove one; see {see('lattice')}"
    if lattice is None and particles is None and packing is None:
        yield ("particles",), "this table is missing; give [particles] with a file, [packing] or [lattice]"


def lattice_has_no_layers(lattice: p.Lattice | None, layers: p.Layers | None, see: See) -> Mistakes:
    """Refuse layers of fixed temperature in a lattice, which is a periodic cell."""
    if lattice is not None and layers is not None:
        yield ("layers",), f"a lattice is a periodic cell and has no layers; see {see('lattice')}"


def contact_is_small(lattice: p.Lattice | None, see: See) -> Mistakes:
    """Require contacts smaller than the spheres of a lattice."""
    if lattice is not None and lattice.contact_radius >= lattice.radius:
        yield ("lattice", "contact_radius"), f"is not below the radius; see {see('lattice.radius')}"


def packing_is_complete(packing: p.Packing | None, see: See) -> Mistakes:
    """Require one size of the bed and one number of spheres, in a bed that they fit into."""
    if packing is None:
        return
    if (packing.count is None) == (packing.height is None):
        yield ("packing",), "give either count, the number of spheres, or height"
    if (packing.width is None) == (packing.cylinder is None):
        yield ("packing",), "give either width, of a box, or cylinder, the radius of a round bed"
        return
    if packing.cylinder is not None and packing.periodic:
        yield ("packing", "periodic"), f"a cylinder has no periodic sides; see {see('packing.cylinder')}"
    key = "width" if packing.width is not None else "cylinder"
    narrow = min(packing.width) if packing.width is not None else 2.0 * (packing.cylinder or 0.0)
    largest = 2.0 * packing.radius * (1.0 + CUT * packing.spread)
    least = REACHES * largest * (1.0 + 0.5 * SKIN) if packing.periodic else largest
    if narrow < least:
        yield (
            ("packing", key),
            f"the bed is {narrow:.4g} m wide; it must be {least:.4g} m at least, "
            f"{'three of the largest spheres and room' if packing.periodic else 'one of the largest spheres'}; "
            f"see {see('packing.radius')}",
        )
        return
    if packing.number and packing.expected_height < LOWEST * 2.0 * packing.radius:
        yield (
            ("packing", "height" if packing.count is None else "count"),
            f"{packing.number} spheres make a bed about {packing.expected_height:.3g} m high; heat is measured in "
            f"beds of {LOWEST:g} diameters, {LOWEST * 2.0 * packing.radius:.3g} m, at least",
        )


def packing_conducts(
    packing: p.Packing | None, layers: p.Layers | None, conduction: p.Conduction, particles: p.Particles | None
) -> Mistakes:
    """Require paths of heat that a packing has, and the area of a bed from a file."""
    if layers is not None and particles is not None and layers.area is None:
        yield ("layers", "area"), "missing; give the cross-section of the bed in m2"
    if packing is None:
        return
    if layers is not None and layers.area is not None:
        yield ("layers", "area"), f"is that of the packing, {packing.area:.4g} m2; remove this line"
    if conduction.paths in VORONOI and packing.spread > 0.0:
        yield ("conduction", "paths"), f"{conduction.paths} are for equal particles; use cones, or packing.spread = 0"
    if conduction.paths in VORONOI and packing.cylinder is not None:
        yield ("conduction", "paths"), f"{conduction.paths} end at flat walls; use cones, or a packing in a box"


def layers_are_apart(layers: p.Layers | None, see: See) -> Mistakes:
    """Require that the hot layer lies below the cold one and is hotter."""
    if layers is None:
        return
    if layers.bottom >= layers.top:
        yield ("layers", "bottom"), f"is not below the top; see {see('layers.top')}"
    if layers.T_hot <= layers.T_cold:
        yield ("layers", "T_hot"), f"is not above T_cold = {layers.T_cold:g} K; see {see('layers.T_cold')}"


def fluid_is_there(conduction: p.Conduction, closure: p.Closure | None, see: See) -> Mistakes:
    """Require a fluid where columns or a closure need one."""
    if conduction.fluid is not None:
        return
    if conduction.paths in VORONOI:
        yield ("conduction", "paths"), f"{conduction.paths} lead through a fluid; see {see('conduction.fluid')}"
    if closure is not None:
        yield ("closure",), f"its ratios are those to the fluid, which is missing; see {see('conduction.fluid')}"


def closure_has_points(closure: p.Closure | None, see: See) -> Mistakes:
    """Require more ratios than the polynomial of a closure has terms."""
    if closure is not None and len(set(closure.ratios)) < closure.degree + 2:
        yield (
            ("closure", "ratios"),
            f"{len(set(closure.ratios))} ratios cannot give {closure.degree + 1} terms and their errors; "
            f"see {see('closure.degree')}",
        )


def columns_have_no_radiation(conduction: p.Conduction, radiation: p.Radiation | None, see: See) -> Mistakes:
    """Refuse columns together with radiation."""
    if conduction.paths == "columns" and radiation is not None:
        yield (
            ("conduction", "paths"),
            f"columns are for equal particles without [radiation]; use cones; see {see('radiation')}",
        )


def spreading_suits(
    conduction: p.Conduction, surface: p.Surface | None, closure: p.Closure | None, see: See
) -> Mistakes:
    """Require particles that conduct no worse than the fluid, and spreading paths for rough surfaces."""
    if surface is not None and conduction.paths != "spreading":
        yield ("surface",), f'is for paths = "spreading" alone; see {see("conduction.paths")}'
    if conduction.paths != "spreading" or conduction.fluid is None:
        return
    if conduction.particles < conduction.fluid:
        yield (
            ("conduction", "particles"),
            f"is below that of the fluid; spreading paths are for better conductors; see {see('conduction.fluid')}",
        )
    if closure is not None and min(closure.ratios) < 1.0:
        yield ("closure", "ratios"), f"go below 1, where spreading paths end; see {see('conduction.paths')}"


def file_can_be_used(
    particles: p.Particles | None, layers: p.Layers | None, conduction: p.Conduction, origin: Origin
) -> Mistakes:
    """Read the file as for a run, so that both say the same."""
    if particles is None:
        return
    path = origin.base / particles.file
    if "\0" in particles.file or not path.is_file():
        yield ("particles", "file"), f"no such file; looked for {path.absolute()}"
        return
    if particles.step is not None and dumps.is_dump(path):
        frames = dumps.read_dump(path)
        if particles.step not in [frame.step for frame in frames]:
            yield ("particles", "step"), missing_step(frames)
            return
    if particles.radius is None and not tells_radii(path):
        yield ("particles", "radius"), f"missing; {particles.file} has none"
        return
    found = read_particles(path, particles.radius, particles.step)
    yield from _fits(found, particles, layers, conduction)


def _fits(found: FileParticles, particles: p.Particles, layers: p.Layers | None, conduction: p.Conduction) -> Mistakes:
    """Require that the other tables suit the particles of the file."""
    if conduction.paths in VORONOI and np.ptp(found.radius) > 0:
        yield ("conduction", "paths"), f"{conduction.paths} are for equal particles without [radiation]; use cones"
    if layers is not None and layers.area is None:
        return
    if layers is None:
        if not all(found.periodic):
            yield (
                ("layers",),
                f"this table is missing; the box of {particles.file} is not periodic on all sides",
            )
        return
    hot, cold = found.x[:, 2] < layers.bottom, found.x[:, 2] > layers.top
    if not hot.any() or not cold.any():
        yield (
            ("layers", "top" if hot.any() else "bottom"),
            f"layers of {hot.sum()} hot and {cold.sum()} cold particles; each needs particles of its own; "
            f"centres are from {found.x[:, 2].min():.4g} to {found.x[:, 2].max():.4g} m",
        )
    elif conduction.porosity is None and not 0.0 < (eps := porosity_of(layers, *found[:2], found.box)) < 1.0:
        yield ("layers", "area"), f"gives a porosity of {eps:.3g} between the layers; it must lie in (0, 1)"


CHECKS = (
    one_source,
    lattice_has_no_layers,
    contact_is_small,
    packing_is_complete,
    packing_conducts,
    layers_are_apart,
    fluid_is_there,
    closure_has_points,
    columns_have_no_radiation,
    spreading_suits,
    file_can_be_used,
)


def packing_bears_itself(packing: p.Packing | None) -> Mistakes:
    """Look for spheres so soft that the packing is denser under its weight than one of hard spheres."""
    if packing is None or not packing.number:
        return
    material = Material(packing.density, packing.modulus, packing.poisson_ratio)
    if found := too_soft(packing.expected_height, packing.radius, material):
        denser, enough = found
        yield (
            ("packing", "modulus"),
            f"so soft that a packing about {packing.expected_height:.2g} m high is {denser:.1%} denser by its weight, "
            f"with more and larger contacts; {enough:.2g} Pa keep that to {DENSER:.0%}",
        )


WARNINGS: tuple[Check, ...] = (packing_bears_itself,)
