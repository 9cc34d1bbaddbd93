"""What is wrong with a scene of particles although every single value is right."""

from __future__ import annotations

from contbed.dem import scene as p
from contbed.scene.checking import Mistakes, See
from contbed.scene.toml_lines import Origin


def one_source(lattice: p.Lattice | None, particles: p.Particles | None, see: See) -> Mistakes:
    if lattice is not None and particles is not None:
        yield ("particles",), f"there is a lattice already; remove one; see {see('lattice')}"
    if lattice is None and particles is None:
        yield ("particles",), "this table is missing; give [particles] with a file, or [lattice]"


def lattice_has_no_layers(lattice: p.Lattice | None, layers: p.Layers | None, see: See) -> Mistakes:
    if lattice is not None and layers is not None:
        yield ("layers",), f"a lattice is a periodic cell and has no layers; see {see('lattice')}"


def contact_is_small(lattice: p.Lattice | None, see: See) -> Mistakes:
    if lattice is not None and lattice.contact_radius >= lattice.radius:
        yield ("lattice", "contact_radius"), f"is not below the radius; see {see('lattice.radius')}"


def file_exists(particles: p.Particles | None, origin: Origin) -> Mistakes:
    if particles is not None and ("\0" in particles.file or not (origin.base / particles.file).is_file()):
        yield ("particles", "file"), f"no such file; looked for {(origin.base / particles.file).absolute()}"


def layers_are_apart(layers: p.Layers | None, see: See) -> Mistakes:
    if layers is None:
        return
    if layers.bottom >= layers.top:
        yield ("layers", "bottom"), f"is not below the top; see {see('layers.top')}"
    if layers.T_hot <= layers.T_cold:
        yield ("layers", "T_hot"), f"is not above T_cold = {layers.T_cold:g} K; see {see('layers.T_cold')}"


def fluid_is_there(conduction: p.Conduction, closure: p.Closure | None, see: See) -> Mistakes:
    if conduction.fluid is not None:
        return
    if conduction.paths == "columns":
        yield ("conduction", "paths"), f"columns lead through a fluid; see {see('conduction.fluid')}"
    if closure is not None:
        yield ("closure",), f"its ratios are those to the fluid, which is missing; see {see('conduction.fluid')}"


def closure_has_points(closure: p.Closure | None, see: See) -> Mistakes:
    if closure is not None and len(set(closure.ratios)) < closure.degree + 2:
        yield (
            ("closure", "ratios"),
            f"{len(set(closure.ratios))} ratios cannot give {closure.degree + 1} terms and their errors; "
            f"see {see('closure.degree')}",
        )


CHECKS = (
    one_source,
    lattice_has_no_layers,
    contact_is_small,
    file_exists,
    layers_are_apart,
    fluid_is_there,
    closure_has_points,
)
