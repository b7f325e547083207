"""Remedies as the pages word them: by their fields."""

from __future__ import annotations

from typing import Final

from nvcore.findings import Remedy, RemedyTexts

_READING: Final = "under “How to read”"
_RECORDINGS: Final = "of the recording in the table “Recordings”"
TEXTS: Final[RemedyTexts] = {
    Remedy.CLASSES: (f"enter {{value}} as “Classes that count” {_READING}", "the names"),
    Remedy.SIZE: ("enter {value} as the size of the pictures", "width and height"),
    Remedy.RATE: ("enter {value} as the frame rate", "frames per second"),
    Remedy.FRAMES: ("enter {value} as “Evaluated frames”", "first:last:step"),
    Remedy.FRAME_NAMES: (f"choose “{{value}}” as “Names of pictures” {_READING}", "another way"),
    Remedy.FRAME_STEP: ("apply the factor {value} to the frame numbers", "that fits"),
    Remedy.FORMAT: (f"choose {{value}} as the format {_READING}", "another one"),
    Remedy.BOXES: (f"choose “{{value}}” as “Numbers of a box” {_READING}", "corners"),
    Remedy.ACCEPT: ("if this is meant ({value}), click “This is meant”", "its code"),
    Remedy.TABLE: ("convert the files to CSV with the header {value}", "frame,x,y,w,h,score"),
    Remedy.PICTURES: (f"choose {{value}} as “Pictures” {_RECORDINGS}", "others"),
    Remedy.FIRST_PICTURE: (f"enter {{value}} as “First picture” {_RECORDINGS}", "its frame"),
}

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
"""Labels of the buttons that do it, where `nvcore.inputs.remedies.applied` can."""
