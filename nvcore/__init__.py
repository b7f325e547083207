"""Compare two pedestrian-detection systems by what the driver notices.

    import nvcore as nv
    result = nv.compare("session.toml", alpha=0.8)
    print(result)

Names are loaded on first use, so that the command line's help need not wait for numpy.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from itertools import chain
from typing import TYPE_CHECKING, Any

from nvcore.common.subject import subjects as _subjects  # nvcore.subjects is a package

__version__ = "0.1.0"
"""Version of the program, written into every output."""

__all__ = [
    "PROTOCOLS",
    "Dataset",
    "NvcoreError",
    "Params",
    "Protocol",
    "Result",
    "Session",
    "Source",
    "SystemSource",
    "__version__",
    "audit",
    "compare",
    "convert",
    "dataset_from_tables",
    "detect",
    "driver_features",
    "estimate_driver",
    "evaluate_driver",
    "gate",
    "groups",
    "image_features",
    "judge_alerts",
    "load",
    "read_session",
    "train",
    "train_driver",
    "what_changed",
]

_HOMES = {
    "nvcore.api.calls": ("audit", "compare", "gate", "groups"),
    "nvcore.api.inputs": ("load",),
    "nvcore.common.errors": ("NvcoreError",),
    "nvcore.comparison.compare": ("Result",),
    "nvcore.dataset": ("Dataset",),
    "nvcore.dataset.tables": ("dataset_from_tables",),
    "nvcore.inputs.conversion": ("convert",),
    "nvcore.inputs.session": ("Session", "Source", "SystemSource"),
    "nvcore.inputs.session.toml": ("read_session",),
    "nvcore.settings.params": ("Params",),
    "nvcore.settings.protocols": ("PROTOCOLS", "Protocol"),
}
"""Names of the core by the module that defines them."""
_PACKAGES = {
    "detection": "nvcore.metrics.detection",
    "evidence": "nvcore.evidence",
    "figures": "nvcore.figures",
    "metrics": "nvcore.metrics",
    "pictures": "nvcore.pictures",
    "stability": "nvcore.evidence.stability",
    "tables": "nvcore.tables",
}
"""Packages by their public names."""

if TYPE_CHECKING:
    from nvcore import evidence as evidence
    from nvcore import figures as figures
    from nvcore import metrics as metrics
    from nvcore import pictures as pictures
    from nvcore import tables as tables
    from nvcore.api.calls import audit, compare, gate, groups
    from nvcore.api.inputs import load
    from nvcore.common.errors import NvcoreError
    from nvcore.comparison.compare import Result
    from nvcore.dataset import Dataset
    from nvcore.dataset.tables import dataset_from_tables
    from nvcore.evidence import stability as stability
    from nvcore.inputs.conversion import convert
    from nvcore.inputs.session import Session, Source, SystemSource
    from nvcore.inputs.session.toml import read_session
    from nvcore.metrics import detection as detection
    from nvcore.settings.params import Params
    from nvcore.settings.protocols import PROTOCOLS, Protocol
    from nvcore.subjects.alerts.calls.python import judge_alerts
    from nvcore.subjects.detectors.calls.python import detect, train
    from nvcore.subjects.driver.calls.python import (
        driver_features,
        estimate_driver,
        evaluate_driver,
        image_features,
        train_driver,
    )
    from nvcore.subjects.releases.calls import what_changed


@cache
def _homes() -> dict[str, str]:
    """Return the module of each public name, of the core and of subjects."""
    known = [*_HOMES.items(), *chain(*(subject.names.items() for subject in _subjects()))]
    return {name: module for module, names in known for name in names}


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return import_module(_PACKAGES[name])
    if name not in _homes():
        raise AttributeError(f"module 'nvcore' has no attribute {name!r}")
    value = getattr(import_module(_homes()[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*__all__, *_PACKAGES, *_homes()})
