"""Cases of tests in a TOML file beside the test."""

import tomllib
from pathlib import Path

import pytest

NO_CHANGE = {"changes": {}, "without": ()}


def cases_of(test, table, *keys):
    """Return the values of the keys for each case of a table of the file beside a
    test. A case may leave out `changes` and `without`.
    """
    cases = [NO_CHANGE | case for case in _tables(test)[table]]
    return [tuple(case[key] for key in keys) for case in cases]


def each_case(test, table):
    """Parametrize a test by the cases of a table, whose keys are the arguments; one
    that a case leaves out is None.
    """
    cases = _tables(test)[table]
    keys = list(dict.fromkeys(key for case in cases for key in case))
    values = [[case.get(key, NO_CHANGE.get(key)) for key in keys] for case in cases]
    return pytest.mark.parametrize(keys, values)


def _tables(test):
    """Return the tables of the file beside a test: beds.toml of test_beds.py."""
    name = Path(test).stem.removeprefix("test_")
    text = Path(test).with_name(f"{name}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
