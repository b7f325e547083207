"""The wheel of the project, built, and installed outside the checkout with exact dependencies.

The environment holds nvcore alone. What it may import beside it is a folder of links to packages
of the running environment: those that the wheel's metadata name, and what these need in turn.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement
from places import ROOT

RUN_EACH = """
import json
from click.testing import CliRunner
from nvcore.cli import main
done = [CliRunner().invoke(main, arguments) for arguments in json.loads({!r})]
print(json.dumps([(of.exit_code, of.stdout, of.stderr) for of in done]))
"""
SCRIPTS = "Scripts" if os.name == "nt" else "bin"
LOOP = "loop.nbi"
"""File that stands for the machine code of a release."""


@dataclass(frozen=True)
class Installed:
    """An environment with the wheel in it.

    Attributes
    ----------
    folder
        Of the environment, and of all that belongs to it; processes run here.
    site
        Its site-packages.
    """

    folder: Path
    site: Path

    @property
    def dashboard(self) -> Path:
        """Where the dashboard lies."""
        return self.site / "nvcore" / "dashboard"

    @property
    def sample(self) -> Path:
        """The session file of the sample recordings in it."""
        return self.dashboard / "sample_data" / "session.toml"

    def command(self, *arguments: object) -> list[str]:
        """``nvcore`` as it was installed."""
        return [str(self.folder / SCRIPTS / "nvcore"), *map(str, arguments)]

    def environment(self, *extras: str) -> dict[str, str]:
        """Variables with which a process sees the light core and these extras, and nothing else."""
        packages = self.folder / "-".join(("packages", *extras))
        if not packages.exists():
            _link_packages(Requirement(f"nvcore[{','.join(extras)}]"), self.site, packages)
        environment = {name: value for name, value in os.environ.items() if "PYTHON" not in name}
        return {**environment, "PYTHONPATH": str(packages)}

    def run(self, *arguments: object, extras: tuple[str, ...] = ()) -> subprocess.CompletedProcess:
        """``nvcore`` with these arguments, in an environment with these extras."""
        return self._run(self.command(*arguments), extras)

    def run_each(self, *commands: Sequence[object]) -> list[tuple[int, str, str]]:
        """Exit code, output and errors of ``nvcore`` with each of these arguments, in one process.

        In an environment without extras.
        """
        given = json.dumps([[*map(str, arguments)] for arguments in commands])
        return [*map(tuple, json.loads(self.python(RUN_EACH.format(given)).stdout))]

    def python(self, code: str, *, extras: tuple[str, ...] = ()) -> subprocess.CompletedProcess:
        """Python with this code, likewise."""
        return self._run([str(self.folder / SCRIPTS / "python"), "-c", code], extras)

    def _run(self, command: list[str], extras: tuple[str, ...]) -> subprocess.CompletedProcess:
        return subprocess.run(
            command, capture_output=True, text=True, cwd=self.folder, env=self.environment(*extras)
        )


def install(folder: Path) -> Installed:
    """Build the wheel and install it; needs no network."""
    (code := folder / "code").mkdir()
    (code / LOOP).write_bytes(b"")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)]
    _do(build, ROOT, NVCORE_MACHINE_CODE=str(code))
    _do([sys.executable, "-m", "venv", "--without-pip", str(folder)], folder)
    python = folder / SCRIPTS / "python"
    into = [sys.executable, "-m", "pip", "--python", str(python), "install", "--no-index"]
    _do([*into, "--no-deps", *map(str, folder.glob("*.whl"))], folder)
    where = [str(python), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]
    return Installed(folder, Path(_do(where, folder).strip()))


def _do(command: list[str], cwd: Path, **environment: str) -> str:
    done = subprocess.run(
        command, capture_output=True, text=True, cwd=cwd, env=os.environ | environment
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _link_packages(requirement: Requirement, site: Path, folder: Path) -> None:
    folder.mkdir()
    (metadata,) = site.glob("nvcore-*.dist-info")
    for needed in _needed(requirement, Distribution.at(metadata)):
        for name in {file.parts[0] for file in needed.files or ()} - {"..", "__pycache__"}:
            if not (folder / name).exists():
                (folder / name).symlink_to(Path(str(needed.locate_file(name))))


def _needed(requirement: Requirement, root: Distribution) -> Iterator[Distribution]:
    """All that a requirement needs, itself left out."""
    todo, seen = [requirement], set()
    while todo:
        wanted = todo.pop()
        is_root = wanted.name == requirement.name
        installed = root if is_root else distribution(wanted.name)
        for extra in wanted.extras or {""}:
            if (wanted.name, extra) in seen:
                continue
            seen.add((wanted.name, extra))
            further = map(Requirement, installed.requires or ())
            todo += [
                need
                for need in further
                if need.marker is None or need.marker.evaluate({"extra": extra})
            ]
        if not is_root:
            yield installed
