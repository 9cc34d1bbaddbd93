"""What the tests of shares of a mesh run under mpirun: `shares_program.py COMMAND
OUT`, see `COMMANDS`.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from dolfinx_scenes import MESHES
from two_fluid_scenes import BEDS

from contbed.loading import from_dict
from contbed.mesh.build import build
from contbed.ranks import dolfinx
from contbed.ranks.engine import Ranks
from contbed.ranks.group import RankGroup, rank_group, run_on_root
from contbed.ranks.system import Partition
from contbed.runner import run
from contbed.scene.mesh import MeshBox, MeshFile, MeshLine, MeshRectangle

PLANE = {"type": "rectangle", "length": 0.3, "height": 0.2, "cells": (9, 8)}
SPACE = {"type": "box", "length": 0.3, "width": 0.2, "height": 0.1, "cells": (5, 4, 3)}
SHAPES = {
    "line": MeshLine(type="line", length=0.3, cells=17),
    "rectangles": MeshRectangle(**PLANE),
    "triangles": MeshRectangle(**PLANE, shape="triangle"),
    "bricks": MeshBox(**SPACE),
    "tetrahedra": MeshBox(**SPACE, shape="tetrahedron"),
    "refined": MeshRectangle(**PLANE, refine=1),
    "file": MeshFile(type="file", file=str(MESHES / "two_layers.msh")),
}


def placed(all_ranks: RankGroup, root: Any, key: int, ends: Any) -> Any:
    """Middles of the own cells of each rank, and how many facets of it lie on the
    low and high end of each axis.
    """
    from dolfinx.mesh import locate_entities_boundary

    part = all_ranks.objects[key]
    mesh = part.mesh
    dim = mesh.topology.dim
    middles = mesh.geometry.x[dolfinx.geometry_list(mesh)[: part.owned]].mean(axis=1)[
        :, :dim
    ]
    mesh.topology.create_connectivity(dim - 1, dim)
    found = [
        [
            len(
                locate_entities_boundary(
                    mesh, dim - 1, lambda x, d=d, e=e: np.isclose(x[d], e)
                )
            )
            for e in pair
        ]
        for d, pair in enumerate(ends)
    ]
    return all_ranks.comm.gather((middles, found))


def cells(out: Path) -> None:
    """What each rank gives to DOLFINx of meshes of each shape, and where their cells
    and facets are then.
    """
    given: list[Any] = []
    make = dolfinx.create_mesh

    def counted(comm: Any, cell: str, cells: Any, points: Any) -> Any:
        given.append((len(cells), len(points)))
        return make(comm, cell, cells, points)

    dolfinx.create_mesh = counted
    for name, settings in SHAPES.items():

        def main(name: str = name, settings: Any = settings) -> None:
            mesh = build(settings).skfem
            partition = Partition.of(rank_group(), mesh)
            ends = np.stack([mesh.p.min(axis=1), mesh.p.max(axis=1)], axis=1)
            parts = rank_group().run_on_all(placed, partition.key, ends)
            exterior = mesh.p[:, mesh.facets[:, mesh.boundary_facets()]]
            np.savez(
                out / f"{name}.npz",
                middles=np.concatenate([middles for middles, _ in parts]),
                expected=mesh.p[:, mesh.t].mean(axis=1).T[partition.order],
                order=partition.order,
                facets=np.sum([facets for _, facets in parts], axis=0),
                there=[
                    [np.isclose(exterior[d], e).all(axis=0).sum() for e in pair]
                    for d, pair in enumerate(ends)
                ],
                size=(mesh.nelements, mesh.nvertices),
            )

        run_on_root(main)
    (out / f"rank{rank_group().comm.rank}.json").write_text(
        json.dumps(dict(zip(SHAPES, given, strict=True)))
    )


def longest(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Length of the longest array that each rank has of a grid."""
    part = all_ranks.objects[key]
    grid = part.grid
    lists = (*vars(part).values(), *vars(grid).values(), *grid.geometry)
    return all_ranks.comm.gather(
        max(len(x) for x in lists if isinstance(x, np.ndarray))
    )


def grids(out: Path) -> None:
    """How long the lists of a grid of rectangles and one of triangles are on each
    rank, where building it fails.
    """
    from contbed.two_fluid.fv import grid

    def refuse(*arguments: Any) -> Any:
        raise AssertionError("the grid has been built as a whole")

    grid.build = refuse

    def main() -> None:
        found = {}
        for name in ("rectangles", "triangles"):
            scene = BEDS[name] | {"mesh": BEDS[name]["mesh"] | {"cells": [40, 100]}}
            plan = Ranks().plan(from_dict(scene))
            bed, _ = plan.bed()
            # put together, as for a row
            assert len(bed.state.eps_s) == len(plan.grid.cells)
            bed.step_towards(1e3)
            held = {
                key: len(value)
                for key, value in vars(bed._whole).items()
                if isinstance(value, np.ndarray)
            }
            found[name] = {
                "lists": rank_group().run_on_all(longest, plan.place.parts.key),
                "faces": plan.grid.face_count,
                "outline": len(plan.grid.geometry.left),
                "state": max(held.values()),
                "fields": len(bed.state.eps_s),
            }
        (out / "grids.json").write_text(json.dumps(found))

    run_on_root(main)


def points(out: Path) -> None:
    """Whether the first rank has points of the integrals over cells after it has
    assembled, of a box that radiates.
    """
    from contbed.ranks.system import System

    assemble, found = System.assemble, []

    def watched(self: System, *arguments: Any) -> Any:
        made = assemble(self, *arguments)
        found.append(sorted(vars(self.cells).keys() & {"x", "h", "_map"}))
        return made

    System.assemble = watched  # type: ignore[method-assign]
    ends = {
        side: {"radiation": {"temperature": T, "emissivity": 0.8}}
        for side, T in (("left", 900.0), ("top", 400.0))
    }
    tables = {"radiation": {"level": "p1", "absorption": 3.0}, "boundary": ends}
    run(
        from_dict(
            tables | {"mesh": SHAPES["bricks"].model_dump(), "output": {"plots": False}}
        ),
        engine="dolfinx",
    )
    if found:
        (out / "points.json").write_text(json.dumps(found))


COMMANDS = {f.__name__: f for f in (cells, grids, points)}

if __name__ == "__main__":
    COMMANDS[sys.argv[1]](Path(sys.argv[2]))
