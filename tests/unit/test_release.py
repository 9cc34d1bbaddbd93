"""A release: one place for the version, and a wheel that installs into a fresh
environment and holds all it needs.
"""

import os
import shutil
import site
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import contbed
from contbed.models import MODELS

ROOT = Path(__file__).parents[2]


def test_the_version_stands_in_one_place():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert (
        "version" not in project["project"]
        and "version" in project["project"]["dynamic"]
    )
    assert project["tool"]["setuptools"]["dynamic"]["version"] == {
        "attr": "contbed.__version__"
    }
    # these two are read by people and by repositories, which cannot run Python
    assert f"\nversion: {contbed.__version__}\n" in (ROOT / "CITATION.cff").read_text(
        encoding="utf-8"
    )
    assert f"## [{contbed.__version__}]" in (ROOT / "CHANGELOG.md").read_text(
        encoding="utf-8"
    )


@pytest.mark.slow
def test_a_wheel_installs_and_runs(tmp_path):
    """Built from the files of the project; libraries are those of this environment,
    so that no network is needed.
    """
    pytest.importorskip(
        "build", reason="build is not installed: pip install 'contbed[dev]'"
    )
    source = tmp_path / "source"
    source.mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    shutil.copytree(
        ROOT / "contbed",
        source / "contbed",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [
        sys.executable,
        "-m",
        "build",
        "--wheel",
        "--no-isolation",
        "--outdir",
        str(tmp_path),
        str(source),
    ]
    subprocess.run(command, check=True, capture_output=True, env=clean)
    (wheel,) = tmp_path.glob("*.whl")
    assert f"-{contbed.__version__}-" in wheel.name
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "fresh")], check=True)
    python = tmp_path / "fresh" / "bin" / "python"
    pip = [
        str(python),
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--no-index",
        str(wheel),
    ]
    subprocess.run(pip, check=True, capture_output=True, env=clean)
    (packages,) = (tmp_path / "fresh").glob("lib/python*/site-packages")
    # behind its own
    (packages / "libraries.pth").write_text("\n".join(site.getsitepackages()) + "\n")

    def run(*words):
        found = [str(tmp_path / "fresh" / "bin" / "contbed"), *words]
        return subprocess.run(
            found, cwd=tmp_path, env=clean, check=True, capture_output=True, text=True
        ).stdout

    where = subprocess.run(
        [str(python), "-c", "import contbed; print(contbed.__file__)"],
        cwd=tmp_path,
        env=clean,
        capture_output=True,
        text=True,
    ).stdout
    assert str(packages) in where
    assert run("--version") == f"contbed {contbed.__version__}\n"
    for kind in MODELS:
        assert run("new", kind)
    run("new", "packed_bed", "--out", "bed.toml")
    assert "status     ok" in run("run", "bed.toml", "--out", "bed")
    assert (
        "beaulieu_2020" in run("list")
        or (packages / "contbed" / "validation" / "cases" / "beaulieu_2020").is_dir()
    )
    pytest.importorskip(
        "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
    )
    run("report", "bed")
    assert (tmp_path / "bed" / "report.html").stat().st_size > 1_000_000
