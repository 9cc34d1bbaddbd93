"""A packed bed without species imports nothing of reacting beds."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
import contbed
from contbed.loading import loads
scene = loads('''
[mesh]
type = "line"
length = 1.0
[gas]
density = 1.0
viscosity = 2e-5
heat_capacity = 1000.0
conductivity = 0.03
[solids.sand]
diameter = 3e-3
density = 2000.0
heat_capacity = 800.0
conductivity = 1.0
[packed_bed]
porosity = 0.4
[heat]
[closures]
nusselt = "nusselt_gunn"
[boundary.left]
gas = { velocity = 0.5, temperature = 300.0 }
[boundary.right]
solids.sand = { velocity = 1e-3, temperature = 600.0 }
''')
contbed.run(scene)
new = ("reacting_bed", "fem.line_dg", "closures.formula", "chemistry")
found = [name for name in sys.modules if name.startswith(tuple("contbed." + part for part in new))]
sys.exit(", ".join(found) or (0 if scene.kind == "packed_bed" else scene.kind))
"""


def test_a_scene_without_species_imports_nothing_of_reacting_beds():
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
