"""Surroundings that nobody plans: interrupts while modules are imported, odd
variables, folders that are read-only.
"""

import os
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

import pytest
from small_scenes import STEADY

import contbed
from contbed.errors import SceneError, interrupt_in

HOME = str(Path(contbed.__file__).parents[1])


HANGS = 120  # [s] after which a program counts as one that does not end


def python(code: str, *arguments, cwd=None, **options) -> subprocess.CompletedProcess:
    # this process has chosen its own folder for compiled code
    inherited = {
        key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"
    }
    environment = inherited | {"PYTHONPATH": HOME} | options.pop("environment", {})
    command = [sys.executable, "-c", textwrap.dedent(code), *map(str, arguments)]
    options = {"timeout": HANGS} | options
    return subprocess.run(
        command, cwd=cwd, env=environment, capture_output=True, text=True, **options
    )


@pytest.mark.parametrize(
    "module",
    [
        "typer",
        "contbed.errors",
        "pydantic",
        "numpy",
        "contbed.runner",
        "skfem",
        "contbed.packed_bed.run",
    ],
)
def test_an_interrupt_while_modules_are_imported(tmp_path, module):
    (tmp_path / "scene.toml").write_text(STEADY)
    code = """
        import os, signal, sys
        signal.signal(signal.SIGINT, signal.default_int_handler)  # a run in the background may ignore it
        wanted, sys.argv = sys.argv[1], ["contbed", "run", "scene.toml", "--quiet", "--out", "out"]
        class Interrupt:
            def find_spec(self, name, path=None, target=None):
                if name == wanted:
                    os.kill(os.getpid(), signal.SIGINT)
        from contbed.__main__ import main
        sys.meta_path.insert(0, Interrupt())
        sys.exit(main())
    """
    done = python(code, module, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")


def test_errors_that_come_from_an_interrupt():
    try:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise SceneError("cannot be imported") from error
    except SceneError as error:
        assert interrupt_in(error) is not None
    assert interrupt_in(ValueError()) is None


@pytest.mark.parametrize("backend", ["bogus", "agg"])
def test_a_backend_of_matplotlib_that_does_not_exist(tmp_path, backend):
    (tmp_path / "scene.toml").write_text(STEADY)
    code = """
        import contbed as cb
        cb.run(cb.load("scene.toml"), out="out")
        import matplotlib, os
        print(os.environ["MPLBACKEND"], matplotlib.rcParams["backend"] == "agg")
    """
    done = python(code, cwd=tmp_path, environment={"MPLBACKEND": backend})
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "profiles.png").exists()
    assert done.stdout.split()[0] == backend and (
        backend != "agg" or done.stdout.split()[1] == "True"
    )


def test_a_read_only_installation_without_a_home(tmp_path):
    """Compiled code goes to a temporary folder of this user, which is told once."""
    code = """
        import os
        os.access = lambda *arguments, **options: False  # as on a file system that is mounted read-only
        from contbed.two_fluid.compiled import kernel
        from numba.core import config
        print(config.CACHE_DIR)
    """
    environment = {
        "HOME": "/nonexistent",
        "TMPDIR": str(tmp_path),
        "XDG_CACHE_HOME": "",
    }
    done = [python(code, environment=environment) for _ in range(2)]
    for one in done:
        assert (one.returncode, one.stdout) == (
            0,
            f"{tmp_path / f'contbed-{os.getuid()}'}\n",
        ), one.stderr
    assert (
        done[0].stderr.startswith(
            f"contbed: compiled code is kept in {tmp_path}/contbed-"
        )
        and done[1].stderr == ""
    )


def test_an_account_without_a_home(tmp_path):
    """A user id that no account has, as in containers: there is no home folder to
    find.
    """
    code = """
        import os, pathlib
        def none(self): raise RuntimeError("Could not determine home directory.")
        pathlib.Path.expanduser = none
        os.access = lambda *arguments, **options: False
        import contbed
        print(os.environ["NUMBA_CACHE_DIR"])
    """
    done = python(code, environment={"TMPDIR": str(tmp_path), "XDG_CACHE_HOME": ""})
    assert (done.returncode, done.stdout) == (
        0,
        f"{tmp_path / f'contbed-{os.getuid()}'}\n",
    ), done.stderr
    assert "as a home folder cannot be written" in done.stderr


def test_each_layout_of_the_package_has_its_own_compiled_code(tmp_path, monkeypatch):
    """Code that was compiled before a module or a tuple of a kernel was renamed names
    what is gone.
    """
    from contbed.compiled import cache

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    found = []
    for key, value in (
        ("ROOMS", cache.ROOMS),
        ("TUPLE", b"(Enum):"),
        ("ROOMS", cache.ROOMS[1:]),
    ):
        monkeypatch.setattr(cache, key, value)
        monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
        cache.choose_cache()
        found.append(Path(os.environ["NUMBA_CACHE_DIR"]))
    assert len(set(found)) == 3
    assert all(folder.parent == tmp_path / "contbed" for folder in found)


def test_a_home_folder_that_may_not_be_entered(tmp_path):
    """That of root, named by HOME for another user; and a cache of another user in
    one's own home folder.
    """
    code = """
        import os, pathlib
        real = pathlib.Path.exists
        def exists(self):
            if "locked" in self.parts[:-1]:
                raise PermissionError(13, "Permission denied", str(self))
            return real(self)
        pathlib.Path.exists = exists
        import contbed
        print(os.environ["NUMBA_CACHE_DIR"])
    """
    (tmp_path / "locked").mkdir()
    places = {"HOME": str(tmp_path / "locked"), "XDG_CACHE_HOME": ""}
    done = python(code, environment={"TMPDIR": str(tmp_path)} | places)
    assert (done.returncode, done.stdout) == (
        0,
        f"{tmp_path / f'contbed-{os.getuid()}'}\n",
    ), done.stderr


def test_compiled_code_has_a_limit_and_can_be_removed(tmp_path, monkeypatch):
    """The oldest files go first; runs in other processes compile again what they
    miss.
    """
    from contbed import cli
    from contbed.compiled import cache

    files = [tmp_path / "contbed" / f"{k}" / "code.nbc" for k in range(4)]
    for age, path in enumerate(files):
        path.parent.mkdir(parents=True)
        path.write_bytes(b"x" * 100)
        os.utime(path, (1e9 - age, 1e9 - age))
    assert cache.remove_oldest(tmp_path / "contbed", 250) == 200
    assert [path.exists() for path in files] == [True, True, False, False]
    assert all(path.parent.is_dir() for path in files)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "contbed" / "0"))
    assert cli.main(["warm", "--clear"]) == 0
    assert not (tmp_path / "contbed").exists()
    other = tmp_path / "other" / "code.nbc"
    other.parent.mkdir()
    other.write_bytes(b"x")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(other.parent))
    assert cli.main(["warm", "--clear"]) == 1 and other.exists()


def test_compiling_is_told_once(tmp_path):
    code = """
        from contbed.compiled.cache import tell_when_compiling
        tell_when_compiling()
        from numba import njit
        one = njit(lambda x: x + 1.0, cache=False)
        print("before", flush=True)
        assert one(1.0) == 2.0 and one(1) == 2
    """
    done = python(code, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (
        done.stderr.count("contbed: compiling for this processor") == 1
        and "contbed warm" in done.stderr
    )


@pytest.mark.slow
def test_nothing_is_left_to_compile_after_warm(tmp_path):
    """The second `contbed warm` compiles nothing, in a new folder of compiled code."""
    code = """
        from numba.core import event
        from contbed.cli.warm import scenes, warm
        with event.install_recorder("numba:compile") as record:
            names = [name for name, seconds in warm()]
        assert names == list(scenes())
        print(len(record.buffer))
    """
    environment = {"NUMBA_CACHE_DIR": str(tmp_path)}
    # everything anew takes 144 s of processor here
    first, second = (
        python(code, environment=environment, timeout=10 * HANGS) for _ in range(2)
    )
    assert first.returncode == 0 and int(first.stdout) > 100, first.stderr
    assert second.returncode == 0 and int(second.stdout) == 0, second.stderr


def test_the_folder_of_another_user_is_not_taken(tmp_path, monkeypatch):
    from contbed.compiled import cache

    planted = tmp_path / f"contbed-{os.getuid()}"
    planted.mkdir(mode=0o777)
    os.chmod(planted, 0o777)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(cache, "_can_write", lambda folder: False)
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    cache.choose_cache()
    chosen = Path(os.environ["NUMBA_CACHE_DIR"])
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")
    assert chosen.parent == tmp_path and chosen != planted
