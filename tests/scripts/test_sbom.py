"""The SBOM names the libraries inside the packages, and THIRD_PARTY.md their licences."""

from __future__ import annotations

import hashlib
import re
from importlib.metadata import Distribution, distribution
from pathlib import Path

import pytest
from places import ROOT

from scripts.sbom import add_libraries, libraries_of, name_and_version

PAGE = (ROOT / "THIRD_PARTY.md").read_text(encoding="utf-8")
SECTIONS = {
    "av": "## PyAV",
    "opencv-python-headless": "## OpenCV",
    "numpy": "## NumPy",
    "scipy": "## NumPy",
    "pillow": "## NumPy",
    "scikit-learn": "## scikit-learn",
}


def package(folder: Path) -> Distribution:
    """An installed package with a library of somebody else's."""
    info = folder / "night_vision-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: night_vision\nVersion: 1.0\n")
    digest = "47DEQpj8HBSa-_TImW-5JCeuQeRkm5NMpJWZG3hSuFU"  # of no bytes
    (info / "RECORD").write_text(
        "night_vision/own.so,,\n"
        f"night_vision.libs/libx264-d6533a8d.so.165,sha256={digest},0\n"
        "night_vision-1.0.dist-info/RECORD,,\n"
    )
    return Distribution.at(info)


def test_the_libraries_of_a_package_are_its_components(tmp_path: Path):
    sbom = {"components": [{"name": "Night.Vision", "bom-ref": "nv"}, {"name": "other"}]}
    assert add_libraries(sbom, [package(tmp_path)]) == 1
    ((library,), other) = sbom["components"][0]["components"], sbom["components"][1]
    assert (library["name"], library["version"]) == ("libx264", "165")
    assert library["hashes"] == [{"alg": "SHA-256", "content": hashlib.sha256().hexdigest()}]
    assert library["bom-ref"] == "nv#night_vision.libs/libx264-d6533a8d.so.165"
    assert other == {"name": "other"}


@pytest.mark.parametrize(
    ("file", "expected"),
    [
        ("libssl-8248cfc9.so.1.1.1k", ("libssl", "1.1.1k")),
        ("libscipy_openblas64_-32a4b2a6.so", ("libscipy_openblas64_", "")),
        ("libgfortran-040039e1-0352e75f.so.5.0.0", ("libgfortran", "5.0.0")),
        ("libopenblasp-r0-59ffcd50.3.15.so", ("libopenblasp-r0", "3.15")),
        ("libavutil.60.26.102.dylib", ("libavutil", "60.26.102")),
    ],
)
def test_a_library_s_name_and_version_are_in_its_file_s(file: str, expected: tuple[str, str]):
    assert name_and_version(file) == expected


@pytest.mark.parametrize("name", SECTIONS)
def test_every_library_in_a_wheel_has_its_licence_on_the_page(name: str):
    (section,) = re.findall(rf"^{SECTIONS[name]}.*?(?=^## |\Z)", PAGE, re.DOTALL | re.MULTILINE)
    cells = " ".join(re.findall(r"^\| (.*?) \|", section, re.MULTILINE))
    listed = set(re.findall(r"lib[\w-]+", cells))
    assert {name_and_version(file.name)[0] for file in libraries_of(distribution(name))} <= listed
