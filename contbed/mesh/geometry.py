"""Mesh a geometry of gmsh, as a program of its own: an endless loop in the geometry
cannot hold up whoever waits for the mesh.

    python -m contbed.mesh.geometry SOURCE TARGET DIMENSION SIZE

SIZE is that of the cells in units of the file, 0 for its own. The mesh is written as
gmsh 4.1. The last line on stderr says what failed.
"""

from __future__ import annotations

import os
import sys

from contbed.compiled.orphans import end_with


def main(source: str, target: str, dimension: str, size: str) -> int:
    """Mesh a geometry and return the exit status."""
    import gmsh

    end_with(os.getppid())
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.logger.start()
        gmsh.open(source)
        gmsh.option.setNumber("General.Terminal", 0)
        for option in ("Mesh.SaveAll", "Mesh.SaveParametric"):
            gmsh.option.setNumber(option, 0)
        gmsh.option.setNumber("Mesh.ElementOrder", 1)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        if float(size):
            for option in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
                gmsh.option.setNumber(option, float(size))
        gmsh.model.mesh.generate(int(dimension))
        gmsh.write(target)
    except Exception as error:  # gmsh raises bare Exception
        errors = [line for line in gmsh.logger.get() if line.startswith("Error")]
        print(" ".join((errors[0] if errors else str(error)).split()), file=sys.stderr)
        return 1
    finally:
        gmsh.finalize()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
