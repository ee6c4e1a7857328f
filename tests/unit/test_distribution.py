"""The sdist and the wheel: contents, a clean installation without extras, size and import time."""

from __future__ import annotations

import os
import subprocess
import sys
import tarfile
import venv
import zipfile
from email.parser import HeaderParser
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# hard dependencies; bytes of a plain installation (pip is not in it); seconds of `import woundon`
HARD, INSTALLED, IMPORT = 12, 460e6, 0.030

pytestmark = pytest.mark.slow


def run(*command: str | Path, **how: object) -> str:
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=600, **how)  # type: ignore[call-overload]
    assert done.returncode == 0, done.stderr
    return str(done.stdout)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Build the sdist, and the wheel from it, as ``pip install`` of a release does.

    The folder DISTRIBUTION, if it is set, holds both: the release tests the files that it uploads.
    """
    if "DISTRIBUTION" in os.environ:
        folder = ROOT / os.environ["DISTRIBUTION"]
        return next(folder.glob("*.tar.gz")), next(folder.glob("*.whl"))
    if find_spec("hatchling") is None:
        pytest.skip("needs hatchling (pip install 'woundon[dev]')")
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", folder, cwd=ROOT)
    (sdist,) = folder.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (source,) = (path for path in folder.iterdir() if path.is_dir())
    run(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, cwd=source)
    (wheel,) = folder.glob("*.whl")
    return sdist, wheel


def test_the_wheel_has_one_package_and_no_tests(built: tuple[Path, Path]) -> None:
    with zipfile.ZipFile(built[1]) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        fields = HeaderParser().parsestr(archive.read(metadata).decode("utf-8"))
    assert {name.partition("/")[0] for name in names} == {
        "woundon", metadata.partition("/")[0],
    }  # fmt: skip
    for needed in ("woundon/py.typed", "woundon/__init__.pyi"):
        assert needed in names
    assert not [name for name in names if "test" in Path(name).name or "__pycache__" in name]
    hard = [one for one in fields.get_all("Requires-Dist", []) if "extra ==" not in one]
    assert len(hard) <= HARD
    assert fields["Version"] == version("woundon")
    assert set(fields.get_all("Provides-Extra", [])) == {
        "all", "app", "dask", "dev", "excel", "instruments", "parquet",
    }  # fmt: skip


def test_the_sdist_holds_sources_tests_and_examples(built: tuple[Path, Path]) -> None:
    with tarfile.open(built[0]) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    for needed in ("pyproject.toml", "LICENSE", "tests/conftest.py", "examples", "README.md"):
        assert any(name.startswith(needed) for name in names), needed


def test_a_clean_installation_solves_an_example(built: tuple[Path, Path], tmp_path: Path) -> None:
    """Without extras: no plain feature needs a package that only contributors have."""
    venv.create(tmp_path / "venv", with_pip=False)
    folder = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    python = folder / "python"
    clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--python",
        python,
        "install",
        "-q",
        "--no-warn-script-location",
    ]
    run(*pip, "--constraint", ROOT / "constraints.txt", built[1], env=clean)

    example = ROOT / "examples" / "newsprint_table2.toml"
    for ending in ("nc", "png"):
        option = "--save" if ending == "nc" else "--plot"
        out = tmp_path / f"result.{ending}"
        text = run(
            folder / "woundon", "solve", example, "--nodes", "33", option, out,
            cwd=tmp_path, env=clean,
        )  # fmt: skip
        assert "wound-on tension" in text
        assert out.stat().st_size > 1000

    packages = Path(
        run(python, "-c", "import woundon; print(woundon.__file__)", cwd=tmp_path, env=clean)
    )
    size = sum(path.stat().st_size for path in packages.parents[1].rglob("*") if path.is_file())
    assert size < INSTALLED
    seconds = min(float(run(python, "-c", IMPORT_TIME, cwd=tmp_path, env=clean)) for _ in range(5))
    assert seconds <= IMPORT


IMPORT_TIME = "import time; t = time.process_time(); import woundon; print(time.process_time() - t)"
