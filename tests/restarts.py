"""Runs that are stopped and resumed."""

import numpy as np
import pytest

import contbed as cb


def interrupt(scene, folder, owner, name, call, **settings):
    """Run a scene until a call of the method `name` of `owner`, where Ctrl-C ends it."""
    whole, calls = getattr(owner, name), []

    def counted(*arguments, **keys):
        calls.append(1)
        if len(calls) == call:
            raise KeyboardInterrupt
        return whole(*arguments, **keys)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(owner, name, counted)
        with pytest.raises(KeyboardInterrupt):
            cb.run(scene, folder, **settings)


def same_run(found, whole):
    """Assert that two runs have the same numbers, to the last bit."""
    assert found.balances == whole.balances
    assert found.closures == whole.closures
    assert found.qoi.keys() == whole.qoi.keys()
    for name, value in whole.qoi.items():
        assert np.array_equal(found.qoi[name], value, equal_nan=value != value), name
    assert found.tables.keys() == whole.tables.keys()
    for key, table in (whole.tables | {"profiles": whole.profiles}).items():
        other = found.profiles if key == "profiles" else found.tables[key]
        for name, column in table.items():
            equal_nan = np.issubdtype(np.asarray(column).dtype, np.floating)
            assert np.array_equal(other[name], column, equal_nan=equal_nan), name
