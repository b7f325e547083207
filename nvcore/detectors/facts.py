"""What is known of the settings of a run, whatever the kind of detector."""

from __future__ import annotations

from dataclasses import fields

from nvcore.dataset.provenance import About
from nvcore.detectors.registry import DETECTORS
from nvcore.detectors.settings import SettingFacts, facts_of


def run_settings(about: About) -> dict[str, SettingFacts]:
    """The settings whose values a run of this detector may choose, by name."""
    settings = DETECTORS[about.kind].settings()
    if settings is None:
        from nvcore.detectors.icf.settings import OF_A_RUN

        return {name: facts for name, facts in model_settings().items() if name in OF_A_RUN}
    return {spec.name: facts_of(spec) for spec in fields(settings)}


def model_settings() -> dict[str, SettingFacts]:
    """All settings of a model that is trained here, by name: of its training and of its runs."""
    from nvcore.detectors.icf.settings import IcfSettings

    return {spec.name: facts_of(spec) for spec in fields(IcfSettings)}
