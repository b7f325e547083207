"""What the light core does without: which packages, and what is said where one is missing."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import packages_distributions

import pytest
from places import ROOT

from nvcore.common.errors import MissingExtraError, NvcoreError
from nvcore.common.extras import PACKAGES, needs

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def named(requirements: list[str]) -> set[str]:
    return {re.split(r"[\[<>=]", text)[0] for text in requirements}


def test_the_extras_bring_what_their_parts_import():
    extras = PROJECT["optional-dependencies"]
    distributions = packages_distributions()
    of = {
        extra: {distributions[name][0].lower() for name in names}
        for extra, names in PACKAGES.items()
    }
    assert of["report"] == named(extras["report"])
    assert of["driver"] == named(extras["driver"])
    assert of["app"] == named(extras["app"]) - {"nvcore"} | of["report"] | of["driver"]
    assert of["login"] == named(extras["login"]) - {"nvcore"} | of["app"]
    assert of["detectors"] == named(extras["detectors"]) <= of["report"]
    assert of["onnx"] == named(extras["onnx"]) - {"nvcore"} | of["detectors"]
    assert not of["login"] & named(PROJECT["dependencies"])


def test_a_missing_package_is_told_with_its_extra():
    with pytest.raises(MissingExtraError) as caught, needs("report", "figures need"):
        raise ModuleNotFoundError("No module named 'plotly'", name="plotly.graph_objects")
    assert str(caught.value) == "figures need more packages: pip install 'nvcore[report]'"
    assert isinstance(caught.value, NvcoreError)
    assert isinstance(caught.value, ImportError)


def test_the_outermost_need_is_told():
    with (
        pytest.raises(MissingExtraError, match=r"^the dashboard needs .*\[app\]'$"),
        needs("app", "the dashboard needs"),
        needs("report", "figures need"),
    ):
        raise ModuleNotFoundError(name="cv2")


def test_another_module_that_is_missing_stays_a_fault():
    with pytest.raises(ModuleNotFoundError, match=r"nvcore\.gone"), needs("report", "figures need"):
        raise ModuleNotFoundError("No module named 'nvcore.gone'", name="nvcore.gone")
