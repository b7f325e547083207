"""Detectors and their runs in words, for a terminal."""

from __future__ import annotations

from typing import Any

from nvcore.dataset.provenance import About, TrainedOn
from nvcore.detectors.base import Detector
from nvcore.detectors.facts import run_settings
from nvcore.detectors.icf import IcfDetector, IcfModel
from nvcore.detectors.registry import DETECTORS
from nvcore.detectors.run import DetectorRun, Expectation
from nvcore.detectors.settings import SettingFacts
from nvcore.detectors.training.run import Training
from nvcore.wording import count_text, duration_text, listed, one_line

_FINGERPRINT = 12
"""Digits of a fingerprint that are shown."""


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
    trained_on = [trained_on_text(part) for part in about.trained_on] or ["not known"]
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
        *_windows(model),
    ]


def trained_on_text(part: TrainedOn) -> str:
    """A part of what a detector was trained on."""
    if not part.recording:
        return f"crops and scenes ({part.fingerprint[:_FINGERPRINT]})"
    if part.first_frame is None and part.last_frame is None:
        return one_line(part.recording)
    first, last = ("" if end is None else end for end in (part.first_frame, part.last_frame))
    return f"{one_line(part.recording)}, frames {first}:{last}"


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
    if isinstance(value, bool):
        return "yes" if value else "no"
    return one_line(str(value)) if value not in (None, "") else "–"


def _range(facts: SettingFacts) -> str:
    if facts.low is None:
        return ""
    return (
        f" {facts.low:g} or more." if facts.high is None else f" {facts.low:g} to {facts.high:g}."
    )


def render_expectation(expectation: Expectation, n_recordings: int) -> str:
    """How long a run will take."""
    threads = count_text(expectation.n_threads, "thread")
    return (
        f"{count_text(expectation.n_pictures, 'picture')} of "
        f"{count_text(n_recordings, 'recording')} on {threads}: about "
        f"{duration_text(expectation.seconds)} ({expectation.seconds_each:.2g} s a picture)"
    )


def render_run(run: DetectorRun) -> str:
    """What came out of a run, and which frames were not seen."""
    rate = run.n_pictures / run.seconds if run.seconds > 0 else 0.0
    n_run = sum(len(part.frames) > 0 for part in run.recordings)
    lines = [
        f"{run.n_boxes:,} boxes in {count_text(run.n_pictures, 'picture')} of "
        f"{count_text(n_run, 'recording')}, in {duration_text(run.seconds)} "
        f"({rate:.1f} pictures a second)"
    ]
    if run.n_without:
        lines.append(
            f"{run.n_without:,} of {run.n_without + run.n_pictures:,} evaluated frames were not "
            "seen, and count as missed where they are compared:"
        )
        lines += [
            f"  {one_line(part.name)}: {part.n_listed - len(part.frames):,} of {part.n_listed:,}. "
            f"{part.note}".rstrip()
            for part in run.recordings
            if len(part.frames) < part.n_listed
        ]
    return "\n".join(lines)


def render_training(training: Training) -> str:
    """What a model was trained on, how its error fell, and what it keeps of the held-out."""
    model, gathered = training.model, training.gathered
    objects = count_text(training.n_objects, "object")
    boxes = count_text(training.n_held_out, "box", "boxes")
    pictures = count_text(training.n_pictures, "picture")
    if gathered.every > 1:
        pictures += f", one of {gathered.every} evaluated frames"
    lines = [
        f"{one_line(model.name)}: {objects} in {pictures}",
        f"held out: {one_line(gathered.held_out)} ({boxes})",
        *_windows(model),
        _held_out(training),
        f"trained in {duration_text(training.seconds)}",
    ]
    if training.faults:
        n_faults = count_text(len(training.faults), "picture")
        lines.append(f"{n_faults} could not be read: {training.faults[0]}")
    lines += [f"not trained on {note}" for note in gathered.notes]
    return "\n".join(lines)


def _held_out(training: Training) -> str:
    """How many held-out boxes come through; a calibrated cascade is made to keep its share."""
    settings = training.model.settings
    n = f"{training.n_held_out:,}"
    at_threshold = f"{training.n_found:,} of {n} at the threshold of {settings.threshold:g}"
    if settings.cascade in ("calibrated", "hard"):
        share = f"{100 * settings.kept_share:g} %"
        return f"held-out boxes: {at_threshold}; calibrated on them, the cascade keeps {share}"
    return f"held-out boxes: {at_threshold}; the cascade keeps {training.n_kept:,}"


def _windows(model: IcfModel) -> list[str]:
    """Windows of a training, and its error at the end of each round."""
    lines = [f"windows: {model.n_objects:,} of objects, {model.n_background:,} of background"]
    start = 0
    for number, end in enumerate(model.round_ends.tolist(), 1):
        trees = count_text(end - start, "tree")
        lines.append(f"  round {number}: {trees}, training error {model.error[end - 1]:.2%}")
        start = end
    return lines
