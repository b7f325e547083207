"""Wording of suggested fixes on the pages, in terms of their fields."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

from nvcore.common.findings import Remedy, RemedyTexts, Step, steps_text
from nvcore.settings.objects import PEDESTRIAN, Objects
from nvcore.settings.params import SETTINGS

_READING: Final = "under “How to read”"
_RECORDINGS: Final = "of the recording in the table “Recordings”"
TEXTS: Final[RemedyTexts] = {
    Remedy.CLASSES: (f"enter {{value}} as “Classes that count” {_READING}", "the names"),
    Remedy.SIZE: ("enter {value} as the size of the pictures", "width and height"),
    Remedy.RATE: ("enter {value} as the frame rate", "frames per second"),
    Remedy.FRAMES: ("enter {value} as “Evaluated frames”", "first:last:step"),
    Remedy.FRAME_LIST: ("give this file as “Evaluated frames”", ""),
    Remedy.FRAME_NAMES: (f"choose “{{value}}” as “Names of pictures” {_READING}", "another way"),
    Remedy.FRAME_STEP: ("apply the factor {value} to the frame numbers", "that fits"),
    Remedy.FORMAT: (f"choose {{value}} as the format {_READING}", "another one"),
    Remedy.THRESHOLD: ("set the threshold{of} to {value}", "such a score"),
    Remedy.BOX_BASE: (f"choose “the first pixel is {{value}}” {_READING}", "0"),
    Remedy.BOXES: (f"choose “{{value}}” as “Numbers of a box” {_READING}", "corners"),
    Remedy.ACCEPT: ("if this is meant ({value}), click “This is meant”", "its code"),
    Remedy.TABLE: ("convert the files to CSV with the header {value}", "frame,x,y,w,h,score"),
    Remedy.PICTURES: (f"choose {{value}} as “Pictures” {_RECORDINGS}", "others"),
    Remedy.FIRST_PICTURE: (f"enter {{value}} as “First picture” {_RECORDINGS}", "its frame"),
    Remedy.OPTION: ("{of}", ""),
}
_OPTIONS: Final = {
    "objects": "choose {value} as “The boxes are of”, above the fields",
    "only": "choose recordings by their tags in the sidebar",
    "recordings": "fill in the table “Recordings”",
}
"""Options that are not settings, but that messages on pages can suggest."""


def ways_text(
    steps: Iterable[Step],
    systems: Sequence[str | None] = (),
    objects: Objects = PEDESTRIAN,
    *,
    are_all_needed: bool = False,
) -> str:
    """Return suggested fixes as a sentence.

    Parameters
    ----------
    systems
        Names of X and Y.
    objects
        Kind of object in the boxes.
    are_all_needed
        See `steps_text`.

    Examples
    --------
    >>> ways_text([Step(Remedy.OPTION, "ground", "distance")])
    'Set “Distance” to “foot points in the picture”, under “Advanced”.'
    """

    def mark(step: Step) -> str:
        if step.remedy is not Remedy.OPTION:
            ends = {name: f" of {letter}" for name, letter in zip(systems, "XY", strict=False)}
            return ends.get(step.subject, "")
        if step.subject in _OPTIONS:
            return _OPTIONS[step.subject].format(value=step.value)
        setting = SETTINGS[step.subject]
        words = setting.words or {}
        value = objects.say(words[step.value]) if step.value in words else step.value
        where = ", under “Advanced”" * setting.is_advanced
        return f"set “{setting.label}”{f' to “{value}”' * bool(value)}{where}"

    return steps_text(steps, TEXTS, mark, are_all_needed=are_all_needed)


BUTTONS: Final = {
    Remedy.CLASSES: "Count {value}",
    Remedy.SIZE: "Take {value} as the size",
    Remedy.RATE: "Take {value} frames per second",
    Remedy.FRAMES: "Evaluate frames {value}",
    Remedy.FRAME_NAMES: "Read names as {value}",
    Remedy.FORMAT: "Read as {value}",
    Remedy.BOXES: "Read boxes as {value}",
    Remedy.ACCEPT: "This is meant",
    Remedy.PICTURES: "Take {value}",
    Remedy.FIRST_PICTURE: "First picture shows frame {value}",
}
"""Labels of buttons for the fixes that `nvcore.inputs.session.changes.applied` can apply."""
