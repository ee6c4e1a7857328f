"""Run a script with version 0.2 of the program, for comparisons and for timing in pairs.

    python benchmarks/version_0_2.py SCRIPT [ARGUMENT ...]    run a script
    python benchmarks/version_0_2.py -c CODE, -m MODULE       as for the Python interpreter
    python benchmarks/version_0_2.py --source                 print the folder src of version 0.2

``speed.py`` uses it for timing in pairs.

Version 0.2 is the commit ``COMMIT`` of this repository.  The first call creates a git worktree of
that commit in ``.version-0.2`` and in it a virtual environment ``.venv`` with the package versions
of its ``constraints.txt``; further calls use both.  ``--at FOLDER`` places them elsewhere, so that
several worktrees can share them.

Without access to a package index, ``--offline`` creates an environment without packages of its own:
it imports NumPy, SciPy and the others from the environment that runs this script.  Both versions
then use the same packages, which is also the better choice for timing.

The script sees version 0.2 as ``woundon``, and the modules in ``benchmarks`` of that commit.  BLAS
uses one thread.  The exit code is that of the script.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import sysconfig
import venv
from collections.abc import Mapping, Sequence
from pathlib import Path

__all__ = ["COMMIT", "create", "environment_variables", "python", "source"]

COMMIT = "d9136d6b3d083144c736b3b8514f04f8a2f23c4b"
HERE = Path(__file__).resolve().parents[1]
TREE = HERE / ".version-0.2"


def source(tree: Path = TREE) -> Path:
    """Return the folder that holds the package ``woundon`` of version 0.2."""
    return tree / "src"


def python(tree: Path = TREE) -> Path:
    """Return the interpreter of the virtual environment."""
    windows = os.name == "nt"
    return (
        tree / ".venv" / ("Scripts" if windows else "bin") / ("python.exe" if windows else "python")
    )


def environment_variables(tree: Path = TREE) -> Mapping[str, str]:
    """Return the environment variables with which version 0.2 runs."""
    # PYTHONPATH precedes the installed packages, so that a PYTHONPATH of the caller, which usually
    # names the present version, has no effect
    path = os.pathsep.join([str(source(tree)), str(tree / "benchmarks")])
    return os.environ | {"PYTHONPATH": path, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def create(tree: Path = TREE, *, offline: bool = False) -> None:
    """Create the worktree and its virtual environment, unless they exist.

    Raises
    ------
    subprocess.CalledProcessError
        If the commit is missing, as in a shallow clone, or the packages cannot be installed.
    RuntimeError
        If the folder holds another commit.
    """
    git = ["git", "-C", str(HERE)]
    if not source(tree).is_dir():
        # --force: a worktree whose folder was deleted stays registered
        command = [*git, "worktree", "add", "--force", "--quiet", "--detach", str(tree), COMMIT]
        subprocess.run(command, check=True, stdout=sys.stderr)
    command = ["git", "-C", str(tree), "rev-parse", "HEAD"]
    found = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    if found != COMMIT:
        raise RuntimeError(f"{tree} holds the commit {found}, not {COMMIT}; delete it")
    complete = tree / ".venv" / "complete"
    if complete.exists():
        return
    print(f"creating {complete.parent} ...", file=sys.stderr, flush=True)
    venv.create(complete.parent, clear=True, with_pip=not offline)
    if offline:
        packages = sysconfig.get_paths()["purelib"]
        command = [str(python(tree)), "-c", "import sysconfig as s; print(s.get_path('purelib'))"]
        own = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
        Path(own, "shared_packages.pth").write_text(packages + "\n", encoding="utf-8")
        # hides the plug-ins of a woundon that is installed among the shared packages
        metadata = Path(own, "woundon-0.2.0.dist-info", "METADATA")
        metadata.parent.mkdir()
        metadata.write_text("Metadata-Version: 2.1\nName: woundon\nVersion: 0.2.0\n", "utf-8")
    else:
        pip = [str(python(tree)), "-m", "pip", "install", "-qq"]
        constraints = ["--constraint", str(tree / "constraints.txt")]
        subprocess.run([*pip, *constraints, "--editable", str(tree)], check=True, stdout=sys.stderr)
    complete.touch()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code of the script."""
    options = argparse.ArgumentParser(
        description=(__doc__ or "").partition("\n")[0],
        usage="%(prog)s [options] SCRIPT [ARGUMENT ...]",
    )
    options.add_argument("--at", type=Path, default=TREE, help="folder of the worktree")
    options.add_argument(
        "--offline", action="store_true", help="use the packages of this environment"
    )
    options.add_argument("--source", action="store_true", help="print the folder src and stop")
    # everything from the script's name on belongs to the script
    given = list(sys.argv[1:] if arguments is None else arguments)
    own = 0
    while own < len(given) and given[own] in ("--at", "--offline", "--source", "-h", "--help"):
        own += 2 if given[own] == "--at" else 1
    asked, script = options.parse_args(given[:own]), given[own:]
    tree = asked.at.resolve()
    create(tree, offline=asked.offline)
    if asked.source:
        print(source(tree))
        return 0
    if not script:
        options.error("the script is missing")
    return subprocess.call([str(python(tree)), *script], env=environment_variables(tree))


if __name__ == "__main__":
    sys.exit(main())
