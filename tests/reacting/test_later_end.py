"""A run to some time that is continued to a later end has the numbers of one run to
that end, to the last bit: no step depends on where a run ends.
"""

import copy
import random

import pytest
from adsorption_scenes import adsorber
from reacting_bed_scenes import fixed_bed

import contbed as cb
from contbed.loading import from_dict
from tests.restarts import same_run
from tests.scene_text import scene_of
from tests.verification.test_dense_series import SCENES, bed

ADSORBER, UNIT = adsorber(100.0, 10.0, 3.0)
ADSORBER["mesh"]["cells"] = 4
ADSORBER["time"] |= {"end": 3.0 * UNIT, "tolerance": 1e-3}
CORES = fixed_bed("bohart_adams", 0.0, 0.0, 0.0, 2.0, 0.8)
CORES["mesh"]["cells"] = 10
CORES["time"] = {"end": 800.0, "times": [50.0, 300.0]}
STORE = bed()
STORE["boundary"]["left"]["gas"] = scene_of("""
    velocity = { times = [0.0, 2222.0, 3333.0], values = [0.3, 0.0, 0.2] }

    [temperature]
    times = [0.0, 2222.0]
    values = [400.0, 350.0]
    form = "step"
""")
STEPS = copy.deepcopy(STORE)
del STEPS["time"]["tolerance"]
STEPS["time"] |= {"step": 70.0}
BEDS = {
    "store": STORE,
    "steps of one length": STEPS,
    "dense series": SCENES["several"],
    "intraparticle": SCENES["inside"],
    "adsorber": ADSORBER,
    "cores": CORES,
}


@pytest.mark.parametrize("name", BEDS)
def test_a_later_end_is_taken_bit_for_bit(tmp_path, name):
    """Twice, at random moments."""
    scene = copy.deepcopy(BEDS[name])
    end, seed = scene["time"]["end"], random.Random(name)
    moments = sorted(seed.uniform(0.05, 0.95) * end for _ in range(2))
    whole = cb.run(from_dict(scene), quiet=True)
    given, before = scene["time"].get("times", []), None
    for k, moment in enumerate([*moments, end]):
        scene["time"]["end"] = moment
        scene["time"]["times"] = [time for time in given if time <= moment]
        out = tmp_path / str(k)
        found = cb.run(from_dict(scene), quiet=True, out=out, restart=before)
        before = out
    same_run(found, whole)
