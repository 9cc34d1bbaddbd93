"""A release: one place for the version, exact versions of the libraries, a changelog, and
a wheel that installs into a fresh environment and holds all it needs.
"""

import os
import re
import shutil
import site
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

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


def test_the_changelog_keeps_its_convention():
    lines = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) <= 150
    releases = [line for line in lines if line.startswith("## ")]
    assert all(
        re.fullmatch(r"## \[\d+\.\d+\.\d+\] - \d{4}-\d\d-\d\d", line)
        for line in releases
    )
    sections = {line[4:] for line in lines if line.startswith("### ")}
    assert sections <= {
        "Added",
        "Changed",
        "Deprecated",
        "Removed",
        "Fixed",
        "Security",
    }
    date = releases[0].rpartition(" ")[2]
    assert f"\ndate-released: {date}\n" in (ROOT / "CITATION.cff").read_text(
        encoding="utf-8"
    )


def locked():
    """The version of each library in requirements.lock, by its normalized name."""
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    pairs = [line.split("==") for line in lines if not line.startswith("#")]
    return {normalized(name): version for name, version in pairs}


def normalized(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def test_the_locked_versions_satisfy_the_project():
    """Only NAME==VERSION: no address of a registry, no file of some machine."""
    versions = locked()
    assert "contbed" not in versions
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    wanted = list(project["project"]["dependencies"])
    for extra in ("test", "forms", "dev", "docs", "report", "notebook"):
        wanted += extras[extra]
    for each in map(Requirement, wanted):
        version = versions[normalized(each.name)]
        assert re.fullmatch(r"[\w.+!]+", version), each.name
        assert each.specifier.contains(version), f"{each} but {version} is locked"


def test_the_image_is_reproducible_and_has_no_root():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    steps = re.findall(
        r"^([A-Z]+) (.*?)$(?<!\\)", text.replace("\\\n", " "), re.MULTILINE
    )
    words = [word for word, _ in steps]
    assert set(words) <= {"FROM", "RUN", "USER", "WORKDIR", "COPY", "CMD"}
    bases = [argument for word, argument in steps if word == "FROM"]
    assert all(re.fullmatch(r"python:3\.\d+-[\w-]+", base) for base in bases) and bases
    assert "latest" not in text
    users = [argument for word, argument in steps if word == "USER"]
    assert users and users[-1] not in ("root", "0")
    packages = [argument for _, argument in steps if "apt-get install" in argument]
    assert all("rm -rf /var/lib/apt/lists/*" in argument for argument in packages)
    for argument in (argument for word, argument in steps if word == "COPY"):
        source = argument.split()[-2]
        assert (ROOT / source).exists()
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for command in ("make heater", "make test"):
        assert f"docker run contbed {command}\n" in text and command in readme


@pytest.mark.slow
def test_a_wheel_installs_and_runs(tmp_path):
    """Built from the sdist, which is built from the files of the project; libraries are
    those of this environment, so that no network is needed.
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
        "--no-isolation",
        "--outdir",
        str(tmp_path),
        str(source),
    ]
    subprocess.run(command, check=True, capture_output=True, env=clean)
    (wheel,) = tmp_path.glob("*.whl")
    assert f"-{contbed.__version__}-" in wheel.name
    assert list(tmp_path.glob(f"contbed-{contbed.__version__}.tar.gz"))
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
    cases = packages / "contbed" / "many" / "validate" / "cases"
    assert (cases / "beaulieu_2020").is_dir()
    pytest.importorskip(
        "plotly", reason="plotly is not installed: pip install 'contbed[report]'"
    )
    run("report", "bed")
    assert (tmp_path / "bed" / "report.html").stat().st_size > 1_000_000
