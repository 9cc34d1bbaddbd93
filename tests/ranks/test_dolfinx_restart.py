"""A run that is interrupted and continued gives the numbers of the whole run, also on
another number of ranks.

On the same number of ranks sums have the same order, so the numbers are the same to the
last bit. On another number they differ by rounding: 1e-10 as in test_dolfinx_agree.
"""

import numpy as np
import pytest

KEYS = ("nodal.", "series.", "profile.")


@pytest.mark.parametrize(("first", "then"), [(1, 1), (1, 2), (2, 1)])
def test_continued_on_other_ranks(results, first: int, then: int) -> None:
    folder = results("stop", first, "transient_gas", 25.0)
    assert (folder / "checkpoint.npz").is_file()
    continued = np.load(results("resume", then, "transient_gas", folder) / "found.npz")
    whole = np.load(results("agree", then) / "transient_gas.npz")
    assert int(whole["nodal.T_solid"].size) and continued.files == whole.files
    for key in (key for key in whole.files if key.startswith(KEYS)):
        if first == then:
            assert np.array_equal(continued[key], whole[key]), key
        else:
            assert (
                np.abs(continued[key] - whole[key]).max()
                <= 1e-10 * np.abs(whole[key]).max()
            ), key
