"""Add to an SBOM (CycloneDX, JSON) the shared libraries that lie inside the packages.

    python -m scripts.sbom sbom.json ENVIRONMENT

Wheels bring libraries that their metadata do not name: libx264 in PyAV's, OpenSSL in OpenCV's. Each
becomes a component of its package, with the hash from the package's own list of files. Wheels do
not state the licences, which are in THIRD_PARTY.md.
"""

from __future__ import annotations

import argparse
import base64
import json
import re
from collections.abc import Iterable
from importlib.metadata import Distribution, PackagePath, distributions
from pathlib import Path
from typing import Any, Final

FILE: Final = re.compile(
    r"(?P<name>.+?)(?:-[0-9a-f]{8,})*(?:\.(?P<version>[\d.]+))?\.(?:so|dylib|dll)(?:\.(?P<after>.+))?"
)
FOLDER: Final = re.compile(r".+\.libs|\.dylibs")
"""Folders for libraries of the tools that make wheels portable."""


def main() -> None:
    """Update the SBOM file."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("sbom", type=Path)
    parser.add_argument("environment", type=Path)
    options = parser.parse_args()
    content = json.loads(options.sbom.read_text(encoding="utf-8"))
    (site,) = {path.parent for path in options.environment.rglob("site-packages/numpy")}
    n_libraries = add_libraries(content, distributions(path=[str(site)]))
    options.sbom.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    print(f"{options.sbom}: {len(content['components'])} packages, {n_libraries} libraries in them")


def add_libraries(sbom: dict[str, Any], packages: Iterable[Distribution]) -> int:
    """Add to each component of the SBOM the libraries of its package, and return their number."""
    of = {canonical(package.name): package for package in packages}
    n_libraries = 0
    for component in sbom["components"]:
        package = of.get(canonical(component["name"]))
        libraries = [] if package is None else libraries_of(package)
        if libraries:
            component["components"] = [
                as_component(component["bom-ref"], library) for library in libraries
            ]
        n_libraries += len(libraries)
    return n_libraries


def libraries_of(package: Distribution) -> list[PackagePath]:
    """Return bundled libraries of a package, sorted by name."""
    files = [
        file
        for file in package.files or ()
        if any(FOLDER.fullmatch(part) for part in file.parts[:-1]) and FILE.fullmatch(file.name)
    ]
    return sorted(files, key=lambda file: file.name)


def name_and_version(file: str) -> tuple[str, str]:
    """Return a library's name and version from its file name, with "" for no version.

    Examples
    --------
    >>> name_and_version("libx264-d6533a8d.so.165")
    ('libx264', '165')
    >>> name_and_version("libssl-8248cfc9.so.1.1.1k"), name_and_version("libavutil.60.26.102.dylib")
    (('libssl', '1.1.1k'), ('libavutil', '60.26.102'))
    """
    match = FILE.fullmatch(file)
    assert match is not None, file
    return match["name"], match["after"] or match["version"] or ""


def as_component(parent: str, file: PackagePath) -> dict[str, Any]:
    """Return a library as a CycloneDX component. `parent` identifies its package."""
    name, version = name_and_version(file.name)
    component: dict[str, Any] = {
        "type": "library",
        "bom-ref": f"{parent}#{file}",
        "name": name,
        "properties": [{"name": "file", "value": str(file)}],
    }
    if version:
        component["version"] = version
    if file.hash is not None and file.hash.mode == "sha256":
        digest = base64.urlsafe_b64decode(file.hash.value + "=").hex()
        component["hashes"] = [{"alg": "SHA-256", "content": digest}]
    return component


def canonical(name: str) -> str:
    """Normalise a package name as package indexes do."""
    return re.sub(r"[-_.]+", "-", name).lower()


if __name__ == "__main__":
    main()
