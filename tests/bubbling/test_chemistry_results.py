"""What a reacting bed reports: char that does not fit, laws out of their range, amounts that are rounding."""

import numpy as np
import pytest
from reacting_scenes import combustor, tube

import contbed as cb
from contbed.bubbling_bed.chemistry.results import _fits, without_rounding
from contbed.errors import ConvergenceError
from contbed.fields import unit_of
from contbed.result import Result


def test_char_beyond_the_volume_of_the_solids_is_no_result():
    result = Result(cb.plan(combustor()))
    _fits(combustor(), 0.9, result)
    with pytest.raises(ConvergenceError, match=r"scene:1: fuel: .* 171 % of the volume.*drain\.time") as error:
        _fits(combustor(), 1.71, result)
    assert error.value.exit_code == 3


def test_a_law_out_of_its_range_is_a_warning_and_fractions_have_no_unit():
    found = cb.run(tube("CH4:0.01, O2:0.2, N2:0.79", {"CH4_oxidation": {}}, walls=None, solver={"guess": 900.0},
                        gas={"mass_flow": 0.02, "composition": "CH4:0.001, O2:0.2, N2:0.799", "temperature": 900.0},
                        tubes={"perimeter": 1.0, "coefficient": 1e6, "temperature": 900.0}))  # fmt: skip
    assert any(
        text.startswith("reactions.CH4_oxidation: dryer_glassman is used out of its range on 100 % of the height, 900")
        for text in found.warnings
    )
    names = [name for name in found.qoi if name.endswith(("_wet", "_dry"))]
    assert len(names) > 6 and {unit_of(name) for name in names} == {"1"}
    assert all(value == 0 or abs(value) > 1e-15 for name, value in found.qoi.items() if name in names)


def test_rounding_is_zero_and_undershoots_stay():
    amounts = np.array([-1e-40, 3e-16, -1e-5, 0.2])
    assert without_rounding(amounts, 1.0).tolist() == [0.0, 0.0, -1e-5, 0.2]
