"""Install into .venv from the locked versions, then run `tuner` or the tests. Needs Python alone.

python3 bootstrap.py run kownacki2010     any arguments of the `tuner` command
python3 bootstrap.py test                 any arguments of pytest may follow
"""

import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent
HOME = ROOT / ".venv"
BIN = HOME / ("Scripts" if os.name == "nt" else "bin")
PYTHON = BIN / ("python.exe" if os.name == "nt" else "python")
UV = BIN / ("uv.exe" if os.name == "nt" else "uv")


def main(arguments: list[str]) -> int:
    """Install what the arguments need, then do what they say."""
    if sys.version_info < (3, 11):  # noqa: UP036  # pip would say so less plainly
        print(f"filter-tuner needs Python 3.11 or later, this is {sys.version.split()[0]}")
        return 2
    testing = arguments[:1] == ["test"]
    install("constraints-dev.txt" if testing else "constraints.txt")
    if testing:
        # One process per file: what its tests share is computed once.
        pytest = (PYTHON, "-m", "pytest", "-n", "auto", "--dist", "loadfile")
        return call(*pytest, *arguments[1:], folder=ROOT)
    return call(BIN / "tuner", *(arguments or ["--help"]), folder=Path.cwd())


def install(locked: str) -> None:
    """Make .venv, if it is not there, and install the locked versions and this project."""
    if not PYTHON.exists():
        venv.create(HOME, with_pip=True)
    pip = (PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps")
    if not UV.exists():
        call(*pip, "--require-hashes", "-r", "constraints-uv.txt", folder=ROOT)
    # uv takes a tenth of pip's time, and does not know pip's settings: where these name a mirror of
    # the packages, say, it may fail where pip does not.
    if not (UV.exists() and installed(by_uv(), locked)) and not installed(pip, locked):
        sys.exit("the installation failed; the lines above say why")


def by_uv() -> tuple[str | Path, ...]:
    """The command of uv; this folder is read anew, whatever uv built from it before."""
    uv = (UV, "pip", "install", "--quiet", "--python", PYTHON, "--no-deps")
    compiled = ("--compile-bytecode",) if sys.dont_write_bytecode else ()
    return (*uv, *compiled, "--reinstall-package", "filter-tuner")


def installed(command: tuple[str | Path, ...], locked: str) -> bool:
    """Install both, and say whether that is done: hashes cannot be checked for a folder."""
    return not (
        call(*command, "--require-hashes", "-r", locked, folder=ROOT)
        or call(*command, "--no-build-isolation", ".", folder=ROOT)
    )


def call(*command: str | Path, folder: Path) -> int:
    """Run a command in a folder and return its exit code; its output goes where ours goes."""
    return subprocess.run([str(part) for part in command], cwd=folder, check=False).returncode


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
