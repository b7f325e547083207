"""Pictures and answers that the browser of a participant may ask for and send."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final, Literal

from nvcore.common.errors import InputError
from nvcore.pictures.stretch import png
from nvcore.subjects.driver.study.pictures import FIGURES, coarse, load_picture, practice_picture
from nvcore.subjects.driver.study.touch_task import Answer, DetectabilityStore, DetectabilityStudy

PRACTICE: Final = "practice-"
"""Prefix for names of practice pictures."""
POINTERS: Final = ("touch", "pen", "mouse", "keyboard")
MOST_BYTES: Final = 2000
"""Maximum size of an answer."""
View = Literal["full", "coarse"]


@dataclass(frozen=True)
class OnScreen:
    """Study on a participant's screen, which `screen` describes in words."""

    store: DetectabilityStore
    study: DetectabilityStudy
    name: str
    folder: Path
    screen: str = ""
    page: ClassVar[str] = "study"

    def picture(self, name: str, view: View) -> bytes:
        """Return a picture, by its index or from the practice, as PNG."""
        is_practice = name.startswith(PRACTICE)
        index = name.removeprefix(PRACTICE)
        known = FIGURES if is_practice else self.study.pictures
        if not (index.isascii() and index.isdigit() and len(index) < 6 and int(index) < len(known)):
            raise InputError("there is no such picture")
        if is_practice:
            picture, box = practice_picture(int(index)), FIGURES[int(index)]
        else:
            scene = self.study.pictures[int(index)]
            picture, box = load_picture(self.folder, scene), (scene.x, scene.y, scene.w, scene.h)
        return png(picture if view == "full" else coarse(picture, box))

    @property
    def whose(self) -> str:
        """Owner of this participant's answers. The browser may still hold those of others."""
        return f"{self.study.token} {self.name}"

    def keep(self, place: int, kind: str, content: bytes) -> bool:
        """Store an answer, or the report that a picture appeared, as sent by the browser.

        Return False, and store nothing, if it belongs to another participant.
        """
        sent = sent_by_browser(content)
        if sent.get("whose", self.whose) != self.whose:
            return False
        if kind == "answer":
            self.store.answer(self.study, self.name, place, answer_of(sent, self.screen))
        else:
            report = sent.get("name")
            report = report if isinstance(report, str) else ""
            self.store.note_showing(self.study, self.name, place, report)
        return True


def sent_by_browser(content: bytes) -> Mapping[str, Any]:
    """Parse the fields that a browser sends, with numbers as floats."""
    try:
        sent = json.loads(content, parse_int=float)
    except (ValueError, RecursionError) as error:
        raise InputError("this is no answer") from error
    if not isinstance(sent, Mapping):
        raise InputError("this is no answer")
    return sent


def answer_of(sent: Mapping[str, Any], screen: str = "") -> Answer:
    """Validate the fields that a browser sends, and return them as an answer."""
    touch = sent.get("touch")
    if touch is not None and not (isinstance(touch, list) and len(touch) == 2):
        raise InputError("this is no answer: a touch has two places")
    named: dict[str, Any] = {name: sent.get(name) for name in ("measured_s", "shown_s")}
    named |= {} if touch is None else dict(zip(("touch_x", "touch_y"), touch, strict=True))
    if sent.get("response_s") is not None:
        named["response_s"] = sent["response_s"]
    for name, value in named.items():
        if not _is_number(value):
            raise InputError(f"this is no answer: {name} is no number")
    device = [sent["pointer"]] if sent.get("pointer") in POINTERS else []
    widths: list[Any] = [sent.get("shown_px"), sent.get("screen_px")]
    if all(_is_number(width) and 0 < width < 100_000 for width in widths):
        device.append("picture {:.0f} px of a screen of {:.0f} px".format(*widths))
    device += [screen] if screen else []
    is_answered = sent.get("is_answered") is True
    return Answer(**named, is_answered=is_answered, device=", ".join(device))


def _is_number(value: Any) -> bool:
    is_any = isinstance(value, int | float) and not isinstance(value, bool)
    return is_any and math.isfinite(value)
