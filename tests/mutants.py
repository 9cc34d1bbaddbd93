"""Break the package on purpose, one line at a time, and see that a test fails: `make
mutants`.

`tests/mutants.toml` lists the mutants: `file` in contbed/, its `old` text, the `new`
text in its place, and the `test` that must fail. Each is applied to a copy of the
package in a temporary folder, with compiled kernels of its own. A mutant survives if
its test passes. The tests must pass with the copy as it is, or their failing would mean
nothing.

    python tests/mutants.py            all mutants
    python tests/mutants.py TEXT ...   those whose file or test contains one of the texts
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "contbed"
LIMIT = 900  # seconds for a mutant; one that never ends is seen as well
# what pytest returns; anything else says nothing about the mutant
PASSED, FAILED = 0, 1


@dataclass(frozen=True)
class Mutant:
    """One change of one file of the package, and the test that must fail with it."""

    file: str
    old: str
    new: str
    test: str

    @property
    def found(self) -> int:
        """How often the old text occurs in the file."""
        path = ROOT / PACKAGE / self.file
        return path.read_text(encoding="utf-8").count(self.old) if path.is_file() else 0

    def __str__(self) -> str:
        return f"{self.file}: {self.old.strip()!r} -> {self.new.strip()!r}, {self.test}"


def read() -> list[Mutant]:
    """Return all mutants of tests/mutants.toml."""
    table = tomllib.loads((ROOT / "tests" / "mutants.toml").read_text(encoding="utf-8"))
    return [Mutant(**item) for item in table["mutant"]]


def result_of(
    tests: Sequence[str], mutant: Mutant | None = None, jobs: int = 1
) -> tuple[int, str]:
    """Return what pytest returns for some tests with a copy of the package, mutated or
    as it is, and its output, with so many tests at a time.

    Tests of the package as it is may take as long as they do.
    """
    with tempfile.TemporaryDirectory(prefix="mutant_") as folder:
        copy = Path(folder) / PACKAGE
        shutil.copytree(
            ROOT / PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__")
        )
        if mutant is not None:
            path = copy / mutant.file
            path.write_text(
                path.read_text(encoding="utf-8").replace(mutant.old, mutant.new),
                encoding="utf-8",
            )
        environment = {
            **os.environ,
            "PYTHONPATH": folder,
            "OMP_NUM_THREADS": "1",
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        environment["NUMBA_CACHE_DIR"] = str(Path(folder) / "compiled")
        # the copy comes first: -P keeps the folder of the repository from going before
        # it
        command = [
            sys.executable,
            "-P",
            "-m",
            "pytest",
            "-q",
            "-x",
            "-p",
            "no:cacheprovider",
            "-m",
            "",
        ]
        if jobs > 1:
            command += ["-n", str(jobs), "--dist", "worksteal"]
        command += ["-o", f"pythonpath={folder} {ROOT}", *tests]
        try:
            limit = None if mutant is None else LIMIT
            done = subprocess.run(
                command,
                cwd=ROOT,
                env=environment,
                capture_output=True,
                text=True,
                timeout=limit,
            )
        except subprocess.TimeoutExpired:
            return FAILED, f"longer than {LIMIT} s"
        return done.returncode, done.stdout + done.stderr


def judge(mutant: Mutant) -> tuple[bool, str]:
    """Return whether a mutant is seen, and a line about it."""
    if mutant.found != 1:
        return False, f"STALE     {mutant}: the old text is found {mutant.found} times"
    start = time.perf_counter()
    code, output = result_of([mutant.test], mutant)
    word = {PASSED: "SURVIVED", FAILED: "seen"}.get(code, f"BROKEN ({code})")
    line = f"{word:<9} {time.perf_counter() - start:4.0f} s  {mutant}"
    return code == FAILED, line if code in (
        PASSED,
        FAILED,
    ) else f"{line}\n{output[-2000:]}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Try the mutants; 0 if every one is seen."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "texts", nargs="*", metavar="TEXT", help="part of the file or of the test"
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=min(2, os.cpu_count() or 1),
        help="mutants at a time",
    )
    given = parser.parse_args(arguments)
    chosen = [
        m
        for m in read()
        if not given.texts
        or any(text in m.file or text in m.test for text in given.texts)
    ]
    if not chosen:
        parser.error(f"no mutant whose file or test contains {', '.join(given.texts)}")
    start = time.perf_counter()
    tests = sorted({mutant.test for mutant in chosen})
    code, output = result_of(tests, jobs=given.jobs)
    if code != PASSED:
        print(f"{output}\nthe tests do not pass with the package as it is")
        return 1
    print(
        f"{len(chosen)} mutants; their tests pass without them "
        f"({time.perf_counter() - start:.0f} s)",
        flush=True,
    )
    seen = 0
    with ThreadPoolExecutor(given.jobs) as pool:
        for good, line in pool.map(judge, chosen):
            print(line, flush=True)
            seen += good
    print(f"{seen} of {len(chosen)} are seen ({time.perf_counter() - start:.0f} s)")
    return 0 if seen == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main())
