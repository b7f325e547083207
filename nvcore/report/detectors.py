"""Detectors in words, for a terminal."""

from __future__ import annotations

from typing import Any

from nvcore.dataset.provenance import About
from nvcore.detectors.base import Detector
from nvcore.detectors.facts import run_settings
from nvcore.detectors.icf import IcfDetector, IcfModel
from nvcore.detectors.registry import DETECTORS
from nvcore.detectors.settings import SettingFacts, value_text
from nvcore.wording import UNDEFINED, count_text, listed, one_line


def render_detectors() -> str:
    """All detectors that need no model, and what models there may be."""
    lines = []
    for kind in DETECTORS.values():
        lines.append(f"{kind.key}: {kind.title}")
        lines += [f"  {name:14} {text}" for name, text in kind.built_in.items()]
    return "\n".join(lines)


def render_about(detector: Detector) -> str:
    """What a detector is: labels, training, and its settings with their range and meaning."""
    about, kind = detector.about, DETECTORS[detector.about.kind]
    trained_on = [*map(str, about.trained_on)] or ["not known"]
    lines = [
        f"{one_line(about.name)}: {kind.title}",
        f"detects: {one_line(listed(about.labels))}",
        f"fingerprint: {about.fingerprint}",
        f"trained on: {'; '.join(trained_on)}",
    ]
    if isinstance(detector, IcfDetector):
        lines += _of_model(detector.model)
    return "\n".join([*lines, *_settings(about)])


def _of_model(model: IcfModel) -> list[str]:
    """What a model is made of, and how its training went."""
    s, channels = model.settings, listed(model.channels)
    object_size = f"{s.object_width:g}x{s.object_height:g} px"
    return [
        f"window: {s.window_width}x{s.window_height} px, with an object of {object_size}",
        f"trees: {len(model.trees):,}, over {count_text(len(model.features), 'feature')} in "
        f"{count_text(len(model.channels), 'channel')}: {channels}",
        *model.windows_in_words(),
    ]


def _settings(about: About) -> list[str]:
    """Those of a run with their meaning and range, and those that made the model what it is."""
    of_run = run_settings(about)
    lines = ["settings:"]
    for name, facts in of_run.items():
        lines.append(f"  {name} = {_value(about.settings.get(name))}")
        lines.append(f"      {facts.meaning}{_range(facts)}")
        lines += [f"        {word:12} {text}" for word, text in (facts.choices or {}).items()]
    others = {name: value for name, value in about.settings.items() if name not in of_run}
    if others:
        lines.append("settings of its training, which cannot be changed:")
        lines += [f"  {name} = {_value(value)}" for name, value in others.items()]
    return lines


def _value(value: Any) -> str:
    if value in (None, ""):
        return UNDEFINED
    return one_line(value) if isinstance(value, str) else value_text(value)


def _range(facts: SettingFacts) -> str:
    if facts.low is None:
        return ""
    return (
        f" {facts.low:g} or more." if facts.high is None else f" {facts.low:g} to {facts.high:g}."
    )
