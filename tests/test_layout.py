"""A listing of each package fits on a screen."""

from __future__ import annotations

from places import ROOT

ASIDE = {"__init__.py", "__main__.py", "__pycache__", "py.typed"}


def test_packages_have_at_most_sixteen_entries():
    packages = [
        path.parent for base in ("nvcore", "ui") for path in (ROOT / base).rglob("__init__.py")
    ]
    entries = {str(package): {path.name for path in package.iterdir()} for package in packages}
    assert len(entries) > 100
    assert not {
        package: len(names) for package, names in entries.items() if len(names - ASIDE) > 16
    }
