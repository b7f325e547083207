"""Notes on a recording's pictures, gaze and light: assumptions and doubts.

`nvcore.notes.phrase` renders them. A file name at the beginning of a note keeps its case.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.fixation import Gaze
from nvcore.driver.illumination import Light, LightSettings, LightSource
from nvcore.driver.illumination.clock import AdaptationClock
from nvcore.driver.illumination.meter import LEAST_HELD_S
from nvcore.notes import Note

if TYPE_CHECKING:
    from nvcore.driver.run import DriverRecording

MANY_DARK: Final = 0.1
"""Minimum share of readings below `least_lux` for a warning about the unit. (Our choice.)"""
LEAST_COVERED: Final = 0.9
"""Minimum share of a recording that readings should cover on the same clock. (Our choice.)"""
MOST_LUX: Final = 200_000.0
"""Largest plausible reading: direct sun has about 130,000 lx. (Our choice.)"""
MOST_OUTSIDE: Final = 0.5
"""Share of gaze points outside the pictures that suggests other pictures. (Our choice.)"""


def picture_notes(recording: DriverRecording, faults: list[str], n_unseen: int) -> list[Note]:
    """Return notes on the pictures that were used, and on their faults.

    Parameters
    ----------
    faults
        Faults of pictures that cannot be read.
    n_unseen
        Pedestrian boxes in frames without a picture.
    """
    notes = []
    if recording.pictures is not None and not recording.is_visible:
        notes.append(Note("driver.own_pictures"))
        notes += [Note("driver.grey_pictures")] if recording.may_be_of_heat else []
    notes += recording.doubts
    if n_unseen:
        why = recording.picture_note or None
        notes.append(Note("driver.boxes_without_picture", n=n_unseen, why=why))
    if faults:
        notes.append(Note("driver.unreadable_pictures", n=len(faults), fault=faults[0]))
    return notes


def other_frames(gaze: Gaze, frames: NDArray[np.int64]) -> Note | None:
    """Return a clause on why no gaze point belongs to any of these frames (n,), or None."""
    if not len(gaze.frame):
        return Note("driver.no_gaze")
    if not len(frames) or not np.isnan(gaze.at(frames)).all():
        return None
    ends = {"gaze_first": gaze.frame[0], "gaze_last": gaze.frame[-1]}
    return Note("driver.gaze_of_other_frames", **ends, first=frames[0], last=frames[-1])


def fixation_notes(recording: DriverRecording) -> tuple[Note, Note | None]:
    """Return a note on the driver's fixation, and a doubt about the gaze file or None."""
    assumed, with_boxes = recording.settings.fixation, recording.with_boxes
    gaze, size_px, n_outside, doubt = recording.gaze, recording.picture_px, 0, None
    if gaze is None:
        return Note("driver.fixation_assumed", x=assumed.x, y=assumed.y), None
    known = with_boxes[~np.isnan(gaze.at(with_boxes)[:, 0])]
    if size_px is not None:
        points = recording.fixations(known, size_px)
        n_outside = int(((points < 0) | (points > size_px)).any(axis=1).sum())
    counts = {"n_outside": n_outside, "n_known": len(known)}
    if n_outside and n_outside >= MOST_OUTSIDE * len(known):
        doubt = Note("driver.gaze_outside", n_outside=n_outside, n=len(known))
    if fault := other_frames(gaze, recording.frame):
        return Note("driver.fixation_unknown", why=fault), doubt
    return Note("driver.fixation", n=len(with_boxes), **counts, size_px=size_px), doubt


def light_note(
    light: Light | None,
    clock: AdaptationClock | None,
    frames: NDArray[np.int64],
    fps: float,
    settings: LightSettings,
) -> Note:
    """Return a note on where the brightness comes from, and how often it became dark.

    Parameters
    ----------
    light, clock
        None: the light is unknown.
    frames
        Numbers of the recording's frames, ascending.
    """
    is_empty = light is not None and not len(light.time_s)
    if light is None or is_empty or clock is None or not len(frames):
        return Note("driver.no_light", is_empty=is_empty)
    begin_s, end_s = float(frames[0]) / fps, float(frames[-1] + 1) / fps
    first_s, is_meter = light.time_s[0], light.source is LightSource.METER
    ends_s = {"first": first_s, "last": light.time_s[-1], "begin": begin_s, "end": end_s}
    times = Note("driver.light_times", **{name: _amount(of) for name, of in ends_s.items()})
    if is_meter and (first_s >= end_s or light.end_s < begin_s):
        return Note("driver.no_light", is_empty=False, times=times)
    is_short = first_s > begin_s + LEAST_HELD_S or light.end_s < frames[-1] / fps
    n_dark = int(np.count_nonzero(light.level < settings.least_lux))
    return Note(
        "driver.light",
        noun="reading" if is_meter else "picture",
        n_changes=int(np.count_nonzero((clock.change_s >= 0) & (clock.change_s < end_s - begin_s))),
        n_before=int(np.count_nonzero(clock.change_s < 0)),
        every_s=_sparse(light, settings),
        low=_amount(light.level.min()),
        high=_amount(light.level.max()),
        n=len(light.level),
        n_dark=n_dark if n_dark >= MANY_DARK * len(light.level) else 0,
        least_lux=settings.least_lux,
        gaps=_gaps(light, begin_s, end_s, settings),
        times=times if is_short else None,
    )


def light_doubt(
    light: Light | None, frames: NDArray[np.int64], fps: float, settings: LightSettings
) -> Note | None:
    """Return a clause that suggests another unit or clock of the light meter, or None.

    Parameters are as of `light_note`.
    """
    if light is None or light.source is LightSource.PICTURE:
        return None
    if not len(light.time_s):
        return Note("driver.light_doubt")
    if not len(frames):
        return None
    highest = float(light.level.max())
    if highest > MOST_LUX:
        return Note("driver.light_doubt", lux=_amount(highest))
    n, n_dark = len(light.level), int(np.count_nonzero(light.level < settings.least_lux))
    if n_dark >= MANY_DARK * n:
        return Note("driver.light_doubt", n_dark=n_dark, n=n, least_lux=settings.least_lux)
    if every_s := _sparse(light, settings):
        return Note("driver.light_doubt", every_s=every_s)
    times_s = frames / fps
    share = float(((times_s >= light.time_s[0]) & (times_s <= light.end_s)).mean())
    return Note("driver.light_doubt", share=share) if share < LEAST_COVERED else None


def _sparse(light: Light, settings: LightSettings) -> str | None:
    """Return the seconds between readings if they could miss a change of light, else None."""
    return _amount(light.step_s) if light.step_s > settings.bright_for_s / 2 else None


def _gaps(light: Light, begin_s: float, end_s: float, settings: LightSettings) -> Note | None:
    """Return a note on gaps in the readings that leave the light unknown, or None.

    Parameters
    ----------
    begin_s, end_s
        Times of the recording, on the clock of the light meter.
    """
    gaps_s = light.gaps_s
    unknown_until_s = gaps_s[:, 1] + settings.bright_for_s
    gaps_s = gaps_s[(gaps_s[:, 0] + light.held_s < end_s) & (unknown_until_s > begin_s)]
    if not len(gaps_s):
        return None
    before_s, after_s = gaps_s[np.diff(gaps_s, axis=1).argmax()]
    of_s = {
        "before": before_s,
        "after": after_s,
        "unknown_from": before_s + light.held_s,
        "unknown_to": after_s + settings.bright_for_s,
        "held": light.held_s,
        "bright_for": settings.bright_for_s,
    }
    noun = "picture" if light.source is LightSource.PICTURE else "reading"
    amounts = {name: _amount(value) for name, value in of_s.items()}
    return Note("driver.light_gaps", n=len(gaps_s), noun=noun, **amounts)


def _amount(value: float) -> str:
    """Format a number with three significant digits, or as a whole number from 100 on."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"
