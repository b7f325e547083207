"""Notes on a recording's features: assumptions made, and warnings."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.fixation import FixedPoint, Gaze
from nvcore.driver.illumination import Light, LightSettings, LightSource
from nvcore.driver.illumination.clock import AdaptationClock
from nvcore.driver.illumination.meter import LEAST_HELD_S
from nvcore.driver.recording import DriverRecording
from nvcore.wording import capitalised, count_text, percent

MANY_DARK: Final = 0.1
"""From this share of readings below `least_lux` on it is said how many are: a wrong unit; ours."""
LEAST_COVERED: Final = 0.9
"""Readings of a smaller part of a recording may be of another clock; ours."""
MOST_LUX: Final = 200_000.0
"""Direct sun has about 130,000 lx: readings above this are of another unit; ours."""
MOST_OUTSIDE: Final = 0.5
"""From this share of its points outside of the pictures on, gaze may be of other ones; ours."""
_NO_LIGHT: Final = "Nothing is known of the light: no adaptation period."


def picture_notes(recording: DriverRecording, faults: list[str], n_unseen: int) -> list[str]:
    """Which pictures were used, and what is wrong with them.

    Parameters
    ----------
    faults
        Of pictures that cannot be read.
    n_unseen
        Pedestrian boxes in frames without a picture.
    """
    notes = []
    if recording.pictures is not None and not recording.is_visible:
        notes.append("Features are of its own pictures: none of visible light are named.")
        if recording.may_be_of_heat:
            notes.append("They are grey; far-infrared ones say nothing about what eyes see.")
    notes += recording.doubts
    if n_unseen:
        boxes = count_text(n_unseen, "box is", "boxes are")
        notes.append(f"{boxes} in frames without a picture. {recording.picture_note}".strip())
    if faults:
        cannot = count_text(len(faults), "picture")
        notes.append(f"{cannot} cannot be read: {faults[0]}.")
    return notes


def outside_note(recording: DriverRecording, n_outside: int, n_seen: int) -> str:
    """How many boxes lie outside the picture of their frame; empty if none."""
    if not n_outside:
        return ""
    by = "with its visible_map " if recording.has_map else ""
    boxes = count_text(n_seen, "box", "boxes")
    which = "all boxes" if n_outside == n_seen else f"{n_outside:,} of {boxes}"
    return f"{by}{which} lie outside the picture"


def other_frames(gaze: Gaze, frames: NDArray[np.int64]) -> str:
    """Why no gaze point belongs to a frame of the recording (n,); empty if some do."""
    if not len(gaze.frame):
        return "the gaze file has no row"
    if not len(frames) or not np.isnan(gaze.at(frames)).all():
        return ""
    return (
        f"the gaze file has frames {gaze.frame[0]} to {gaze.frame[-1]}, the recording "
        f"{frames[0]} to {frames[-1]}"
    )


def fixation_note(
    recording: DriverRecording,
    assumed: FixedPoint,
    frames: NDArray[np.int64],
    with_boxes: NDArray[np.int64],
) -> str:
    """Where the driver is assumed to look.

    Parameters
    ----------
    frames, with_boxes
        Numbers of the recording's frames, and of those of them with pedestrians, ascending.
    """
    gaze = recording.gaze
    if gaze is None:
        return f"Fixation assumed: {assumed.words}."
    if fault := other_frames(gaze, frames):
        return f"{capitalised(fault)}: no fixation is known."
    is_known = ~np.isnan(gaze.at(with_boxes)[:, 0])
    n_known = int(np.count_nonzero(is_known))
    text = "Fixation by the gaze file."
    if n_known < len(with_boxes):
        n_without = len(with_boxes) - n_known
        of_frames = f"{n_without:,} of {len(with_boxes):,} frames with boxes"
        text = f"Fixation by the gaze file, which has none in {of_frames}."
    if recording.picture_px is None:
        return text
    n_outside = _count_outside(recording, assumed, with_boxes[is_known])
    if n_outside:
        width, height = recording.picture_px
        text += (
            f" {n_outside:,} of its {count_text(n_known, 'point')} in frames with boxes "
            f"{'lies' if n_outside == 1 else 'lie'} outside the picture of {width} x {height} px."
        )
    return text


def picture_doubt(
    recording: DriverRecording, assumed: FixedPoint, with_boxes: NDArray[np.int64]
) -> str:
    """Signs that pictures or gaze belong to another recording, in sentences; empty if none.

    Parameters
    ----------
    with_boxes
        Numbers of the recording's frames with pedestrians, ascending.
    """
    doubts = list(recording.doubts)
    if recording.gaze is not None and recording.picture_px is not None:
        known = with_boxes[~np.isnan(recording.gaze.at(with_boxes)[:, 0])]
        n_outside = _count_outside(recording, assumed, known)
        if n_outside and n_outside >= MOST_OUTSIDE * len(known):
            doubts.append(
                f"{n_outside:,} of {count_text(len(known), 'point')} of the gaze file lie outside "
                "the picture."
            )
    return " ".join(doubts)


def _count_outside(
    recording: DriverRecording, assumed: FixedPoint, frames: NDArray[np.int64]
) -> int:
    """Number of these frames in which the gaze is outside the picture."""
    assert recording.picture_px is not None
    points = recording.fixations(frames, assumed, recording.picture_px)
    return int(np.count_nonzero(((points < 0) | (points > recording.picture_px)).any(axis=1)))


def light_note(
    light: Light | None,
    clock: AdaptationClock | None,
    frames: NDArray[np.int64],
    fps: float,
    settings: LightSettings,
) -> str:
    """Source of the brightness, and how often it became dark.

    Parameters
    ----------
    light, clock
        None: nothing is known.
    frames
        Numbers of the recording's frames, ascending.
    """
    if light is not None and not len(light.time_s):
        return f"The file of the light has no reading. {_NO_LIGHT}"
    if light is None or clock is None or not len(frames):
        return _NO_LIGHT
    begin_s, end_s = float(frames[0]) / fps, float(frames[-1] + 1) / fps
    n_within = int(np.count_nonzero((clock.change_s >= 0) & (clock.change_s < end_s - begin_s)))
    changes = count_text(n_within, "change") + " from bright to dark"
    if n_before := int(np.count_nonzero(clock.change_s < 0)):
        changes += f", {n_before:,} before the first frame"
    if light.source is LightSource.PICTURE:
        sparse = _sparse(light, "picture", settings)
        text = f"No light meter: the pictures' mean luminance stands in for one: {changes}{sparse}"
        return (
            "; ".join(filter(None, [text, _gaps(light, "picture", begin_s, end_s, settings)])) + "."
        )
    times = (
        f"from {_amount(light.time_s[0])} to {_amount(light.time_s[-1])} s, the recording from "
        f"{_amount(begin_s)} to {_amount(end_s)} s"
    )
    if light.time_s[0] >= end_s or light.end_s < begin_s:
        return f"The light meter's readings are {times}. {_NO_LIGHT}"
    is_short = light.time_s[0] > begin_s + LEAST_HELD_S or light.end_s < frames[-1] / fps
    parts = [
        f"Light by the light meter: {changes}{_sparse(light, 'reading', settings)}",
        _levels(light, settings),
        _gaps(light, "reading", begin_s, end_s, settings),
        f"they are {times}" if is_short else "",
    ]
    return "; ".join(filter(None, parts)) + "."


def light_doubt(
    light: Light | None, frames: NDArray[np.int64], fps: float, settings: LightSettings
) -> str:
    """Signs of another unit or clock of the light meter, as a clause; empty if none.

    Parameters
    ----------
    light
        None: nothing is known.
    frames
        Numbers of the recording's frames, ascending.
    """
    if light is None or light.source is LightSource.PICTURE:
        return ""
    if not len(light.time_s):
        return "no reading"
    if not len(frames):
        return ""
    highest = float(light.level.max())
    if highest > MOST_LUX:
        return f"a reading of {_amount(highest)} lx, more than direct sun has"
    n, n_dark = len(light.level), int(np.count_nonzero(light.level < settings.least_lux))
    if n_dark >= MANY_DARK * n:
        return f"{n_dark:,} of {count_text(n, 'reading')} below {settings.least_lux:g} lx"
    if _sparse(light, "reading", settings):
        return f"one reading in {_amount(light.step_s)} s"
    times_s = frames / fps
    is_covered = (times_s >= light.time_s[0]) & (times_s <= light.end_s)
    if is_covered.mean() < LEAST_COVERED:
        return f"readings in {percent(float(is_covered.mean()))} of the recording"
    return ""


def _levels(light: Light, settings: LightSettings) -> str:
    """Range of a light meter's readings, in which a wrong unit shows."""
    low, high = _amount(light.level.min()), _amount(light.level.max())
    text = f"readings of {low} to {high} lx" if low != high else f"readings of {low} lx"
    n_dark = int(np.count_nonzero(light.level < settings.least_lux))
    if n_dark >= MANY_DARK * len(light.level):
        of_all = f"{n_dark:,} of {len(light.level):,}"
        text += f", {of_all} below {settings.least_lux:g} lx, which count as that"
    return text


def _sparse(light: Light, noun: str, settings: LightSettings) -> str:
    """Interval between readings if a change could fall between two; else empty."""
    is_sparse = light.step_s > settings.bright_for_s / 2
    return f", with one {noun} in {_amount(light.step_s)} s" if is_sparse else ""


def _gaps(light: Light, noun: str, begin_s: float, end_s: float, settings: LightSettings) -> str:
    """Gaps in the readings in which the light is unknown; empty if none.

    Parameters
    ----------
    begin_s, end_s
        Of the recording, on the axis of the light.
    """
    gaps_s = light.gaps_s
    unknown_until_s = gaps_s[:, 1] + settings.bright_for_s
    gaps_s = gaps_s[(gaps_s[:, 0] + light.held_s < end_s) & (unknown_until_s > begin_s)]
    if not len(gaps_s):
        return ""
    before_s, after_s = gaps_s[np.diff(gaps_s, axis=1).argmax()]
    where = f"from {_amount(before_s)} to {_amount(after_s)} s"
    if len(gaps_s) == 1:
        unknown = (
            f"{_amount(before_s + light.held_s)} to {_amount(after_s + settings.bright_for_s)} s"
        )
        return f"no {noun} {where}: the light is not known from {unknown}"
    return (
        f"{count_text(len(gaps_s), 'gap')} between {noun}s, the longest {where}: the light is not "
        f"known from {_amount(light.held_s)} s after each begins to "
        f"{_amount(settings.bright_for_s)} s after it ends"
    )


def _amount(value: float) -> str:
    """A number with three figures, or all before the point."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
