"""Render detectors, their settings and their training as text for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import click

from nvcore.cli.models import Models
from nvcore.dataset.provenance import About
from nvcore.extras import needs
from nvcore.wording import UNDEFINED, count_text, listed, one_line

with needs("detectors", "nvcore models needs"):
    from nvcore.detectors.base import Detector
    from nvcore.detectors.icf import IcfDetector, IcfModel
    from nvcore.detectors.icf.settings import OF_A_RUN
    from nvcore.detectors.registry import DETECTORS, open_detector, run_settings, settings_of
    from nvcore.detectors.settings import SettingFacts, value_text
    from nvcore.detectors.training.presets import PRESETS

_ICF: Final = "icf"


def render_detectors() -> str:
    """Render the kinds of detectors and their built-in models as text."""
    lines = []
    for kind in DETECTORS.values():
        lines.append(f"{kind.key}: {kind.title}")
        lines += [f"  {name:14} {text}" for name, text in kind.built_in.items()]
    return "\n".join(lines)


def render_training_settings() -> str:
    """Render the settings of ``nvcore train`` with their values in each preset."""
    values = {name: preset.in_words() for name, preset in PRESETS.items()}
    first, *others = PRESETS
    lines = [
        f"{DETECTORS[_ICF].title}",
        f"settings of nvcore train, with their values in the preset {first}; where another preset "
        "differs, it is named:",
    ]
    for name, facts in settings_of(_ICF).items():
        lines += _explained({name: facts}, values[first])
        differing = [preset for preset in others if values[preset][name] != values[first][name]]
        lines += [f"      {preset}: {_value(values[preset][name])}" for preset in differing]
    lines.append(
        f"nvcore detect can change {listed(sorted(OF_A_RUN))}; the others are the model's."
    )
    return "\n".join(lines)


def render_about(detector: Detector, name: str) -> str:
    """Render a detector's labels, training and settings as text.

    Parameters
    ----------
    name
        By which it was opened.
    """
    about, kind = detector.about, DETECTORS[detector.about.kind]
    trained_on = "; ".join(map(str, about.trained_on)) or kind.built_in.get(name, "not known")
    lines = [
        f"{one_line(about.name)}: {kind.title}",
        f"detects: {one_line(listed(about.labels))}",
        f"fingerprint: {about.fingerprint}",
        f"trained on: {trained_on.removeprefix('trained on ')}",
    ]
    if isinstance(detector, IcfDetector):
        lines += _of_model(detector.model)
    return "\n".join([*lines, *_settings(about, dict(about.settings))])


def _of_model(model: IcfModel) -> list[str]:
    """Return lines about an ICF model: picture type, object sizes, window, trees and training."""
    s, channels = model.settings, listed(model.channels)
    object_size = f"{s.object_width:g}x{s.object_height:g} px"
    heights = [s.object_height * scale for scale in (s.scales[0], s.scales[-1])]
    return [
        f"pictures: {'in colour' if model.is_colour else 'grey'}",
        f"finds objects of about {heights[0]:.0f} to {heights[1]:.0f} px in height",
        f"window: {s.window_width}x{s.window_height} px, with an object of {object_size}",
        f"trees: {len(model.trees):,}, over {count_text(len(model.features), 'feature')} in "
        f"{count_text(len(model.channels), 'channel')}: {channels}",
        *model.windows_in_words(),
    ]


def _settings(about: About, values: Mapping[str, Any]) -> list[str]:
    """Return lines about the settings of a run, then about those fixed by the training."""
    of_run = run_settings(about)
    lines = ["settings:", *_explained(of_run, values)]
    others = {name: value for name, value in values.items() if name not in of_run}
    if others:
        lines.append("settings of its training, which cannot be changed:")
        lines += [f"  {name} = {_value(value)}" for name, value in others.items()]
        lines.append("what they mean: nvcore models icf")
    return lines


def _explained(facts: Mapping[str, SettingFacts], values: Mapping[str, Any]) -> list[str]:
    """Return lines about settings: value, meaning, range and choices of each."""
    lines = []
    for name, known in facts.items():
        lines.append(f"  {name} = {_value(values.get(name))}")
        lines.append(f"      {known.meaning}{_range(known)}")
        lines += [f"        {word:12} {text}" for word, text in (known.choices or {}).items()]
    return lines


def _value(value: Any) -> str:
    if value in (None, ""):
        return UNDEFINED
    return one_line(value) if isinstance(value, str) else value_text(value)


def _range(facts: SettingFacts) -> str:
    if facts.low is None:
        return ""
    low, high = (f"{end:,.12g}" for end in (facts.low, facts.high or 0))
    return f" {low} or more." if facts.high is None else f" {low} to {high}."


def _described(model: str, settings: Mapping[str, str]) -> str:
    """Describe the detector `model`, or the settings of a training if `model` is ``icf``."""
    if model != _ICF:
        return render_about(open_detector(model, settings), model)
    if settings:
        raise click.UsageError("--set is about a model; icf is a kind of them")
    return render_training_settings()


MODELS: Final = Models(
    list_all=render_detectors,
    has=lambda model: model == _ICF or any(model in kind.built_in for kind in DETECTORS.values()),
    describe=_described,
)
