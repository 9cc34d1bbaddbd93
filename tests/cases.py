"""Cases of tests in a TOML file beside the test."""

import tomllib
from pathlib import Path

NO_CHANGE = {"changes": {}, "without": ()}


def cases_of(test, table, *keys):
    """Return the values of the keys for each case of a table: those of
    test_beds.py stand in beds.toml. A case may leave out `changes` and `without`.
    """
    name = Path(test).stem.removeprefix("test_")
    text = Path(test).with_name(f"{name}.toml").read_text(encoding="utf-8")
    cases = [NO_CHANGE | case for case in tomllib.loads(text)[table]]
    return [tuple(case[key] for key in keys) for case in cases]
