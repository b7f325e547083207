"""What a participant has on the screen: which pictures and answers the browser may ask and send."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Final, Literal

from nvcore.driver.study.pictures import FIGURES, coarse, load_picture, practice_picture
from nvcore.driver.study.touch_task import Answer, DetectabilityStore, DetectabilityStudy
from nvcore.errors import InputError
from nvcore.pictures.stretch import png

PRACTICE: Final = "practice-"
"""Start of the names of pictures for practice."""
POINTERS: Final = ("touch", "pen", "mouse", "keyboard")
MOST_BYTES: Final = 2000
"""Of an answer."""
View = Literal["full", "coarse"]


@dataclass(frozen=True)
class OnScreen:
    """A study while one of its participants is before the screen.

    Attributes
    ----------
    store, study, name
        Where answers go, to which study, of whom.
    folder
        Of the study's pictures.
    screen
        Size and distance of the screen, in words.
    page
        On which this is.
    """

    store: DetectabilityStore
    study: DetectabilityStudy
    name: str
    folder: Path
    screen: str = ""
    page: ClassVar[str] = "study"

    def picture(self, name: str, view: View) -> bytes:
        """A picture, by its index or of the practice, as PNG.

        Raises
        ------
        InputError
            If there is none of that name, or it is no longer what the study began with.
        """
        index = name.removeprefix(PRACTICE)
        if not (index.isascii() and index.isdigit() and len(index) < 6):
            raise InputError("there is no such picture")
        if name.startswith(PRACTICE):
            if int(index) >= len(FIGURES):
                raise InputError("there is no such picture")
            picture, box = practice_picture(int(index)), FIGURES[int(index)]
        else:
            if int(index) >= len(self.study.pictures):
                raise InputError("there is no such picture")
            scene = self.study.pictures[int(index)]
            picture, box = load_picture(self.folder, scene), (scene.x, scene.y, scene.w, scene.h)
        return png(picture if view == "full" else coarse(picture, box))

    @property
    def whose(self) -> str:
        """Whose answers these are, in each of them: the browser may have kept those of others."""
        return f"{self.study.token} {self.name}"

    def keep(self, place: int, kind: str, content: bytes) -> bool:
        """Keep an answer, or the report that a picture appears, as the browser sends it.

        False: it is another participant's, and nothing is kept.

        Raises
        ------
        InputError
            If it is none, or the participant has no such trial.
        StoreError
            If it cannot be kept now.
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
    """The fields of what a browser sends.

    Raises
    ------
    InputError
        If it has none.
    """
    try:
        sent = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise InputError("this is no answer") from error
    if not isinstance(sent, Mapping):
        raise InputError("this is no answer")
    return sent


def answer_of(sent: Mapping[str, Any], screen: str = "") -> Answer:
    """An answer from the fields that a browser sends, of which nothing is believed unseen.

    Raises
    ------
    InputError
        If it is no answer.
    """
    touch = sent.get("touch")
    x = y = math.nan
    if isinstance(touch, list) and len(touch) == 2:
        x, y = (_number(value, "touch") for value in touch)
    elif touch is not None:
        raise InputError("this is no answer: a touch has two places")
    response = sent.get("response_s")
    return Answer(
        measured_s=_number(sent.get("measured_s"), "measured_s"),
        shown_s=_number(sent.get("shown_s"), "shown_s"),
        touch_x=x,
        touch_y=y,
        response_s=math.nan if response is None else _number(response, "response_s"),
        is_answered=sent.get("is_answered") is True,
        device=_device(sent, screen),
    )


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"this is no answer: {name} is no number")
    try:
        number = float(value)
    except OverflowError as error:
        raise InputError(f"this is no answer: {name} is too large") from error
    if not math.isfinite(number):
        raise InputError(f"this is no answer: {name} is no number")
    return number


def _device(sent: Mapping[str, Any], screen: str) -> str:
    """With what it was answered, and how large the picture was: text of ours, numbers of theirs."""
    pointer = sent.get("pointer")
    parts = [pointer] if isinstance(pointer, str) and pointer in POINTERS else []
    shown, whole = sent.get("shown_px"), sent.get("screen_px")
    if _is_size(shown) and _is_size(whole):
        parts.append(f"picture {shown} px of a screen of {whole} px")
    return ", ".join([*parts, screen] if screen else parts)


def _is_size(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value < 100_000
