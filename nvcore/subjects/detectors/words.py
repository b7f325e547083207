"""Render detectors, their settings and their training as text for a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import click

from nvcore.cli.models import Models
from nvcore.common.extras import needs
from nvcore.common.wording import UNDEFINED, count_text, listed, one_line

with needs("detectors", "nvcore models needs"):
    from nvcore.subjects.detectors.icf import IcfDetector
    from nvcore.subjects.detectors.icf.settings import OF_A_RUN
    from nvcore.subjects.detectors.registry import (
        DETECTORS,
        open_detector,
        run_settings,
        settings_of,
    )
    from nvcore.subjects.detectors.settings import SettingFacts, value_text
    from nvcore.subjects.detectors.training.run import PRESETS

_ICF: Final = "icf"


def _render_kinds() -> str:
    """Render the kinds of detectors and their built-in models as text."""
    lines = []
    for kind in DETECTORS.values():
        lines.append(f"{kind.key}: {kind.title}")
        lines += [f"  {name:14} {text}" for name, text in kind.built_in.items()]
    return "\n".join(lines)


def _render_training_settings() -> str:
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


def _render_model(text: str, settings: Mapping[str, str]) -> str:
    """Render the labels, the training and the settings of the detector with this name or file."""
    detector = open_detector(text, settings)
    about, kind = detector.about, DETECTORS[detector.about.kind]
    trained_on = "; ".join(map(str, about.trained_on)) or kind.built_in.get(text, "not known")
    lines = [
        f"{one_line(about.name)}: {kind.title}",
        f"detects: {one_line(listed(about.labels))}",
        f"fingerprint: {about.fingerprint}",
        f"trained on: {trained_on.removeprefix('trained on ')}",
    ]
    if isinstance(detector, IcfDetector):
        model, s = detector.model, detector.model.settings
        lowest, highest = (s.object_height * scale for scale in (s.scales[0], s.scales[-1]))
        lines += [
            f"pictures: {'in colour' if model.is_colour else 'grey'}",
            f"finds objects of about {lowest:.0f} to {highest:.0f} px in height",
            f"window: {s.window_width}x{s.window_height} px, with an object of "
            f"{s.object_width:g}x{s.object_height:g} px",
            f"trees: {len(model.trees):,}, over {count_text(len(model.features), 'feature')} in "
            f"{count_text(len(model.channels), 'channel')}: {listed(model.channels)}",
            *model.windows_in_words(),
        ]
    of_run = run_settings(about)
    lines += ["settings:", *_explained(of_run, about.settings)]
    others = {name: value for name, value in about.settings.items() if name not in of_run}
    if others:
        lines.append("settings of its training, which cannot be changed:")
        lines += [f"  {name} = {_value(value)}" for name, value in others.items()]
        lines.append("what they mean: nvcore models icf")
    return "\n".join(lines)


def _explained(facts: Mapping[str, SettingFacts], values: Mapping[str, Any]) -> list[str]:
    """Return lines about settings: value, meaning, range and choices of each."""
    lines = []
    for name, known in facts.items():
        lines.append(f"  {name} = {_value(values.get(name))}")
        low, high = (None if end is None else f"{end:,.12g}" for end in (known.low, known.high))
        span = "" if low is None else f" {low} or more." if high is None else f" {low} to {high}."
        lines.append(f"      {known.meaning}{span}")
        lines += [f"        {word:12} {text}" for word, text in (known.choices or {}).items()]
    return lines


def _value(value: Any) -> str:
    if value in (None, ""):
        return UNDEFINED
    return one_line(value) if isinstance(value, str) else value_text(value)


def _described(model: str, settings: Mapping[str, str]) -> str:
    """Describe the detector `model`, or the settings of a training if `model` is ``icf``."""
    if model != _ICF:
        return _render_model(model, settings)
    if settings:
        raise click.UsageError("--set is about a model; icf is a kind of them")
    return _render_training_settings()


MODELS: Final = Models(
    list_all=_render_kinds,
    has=lambda model: model == _ICF or any(model in kind.built_in for kind in DETECTORS.values()),
    describe=_described,
)
