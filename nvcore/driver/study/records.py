"""A study, its participants and their answers, as the file of answers holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime

from nvcore.driver.inputs.trials import LONGEST_S
from nvcore.driver.study.pictures import StudyPicture
from nvcore.driver.study.plan import Trial
from nvcore.driver.study.settings import StudySettings
from nvcore.errors import InputError


@dataclass(frozen=True)
class DetectabilityStudy:
    """A study, as it was begun.

    Attributes
    ----------
    token
        Name of the study for participants; cannot be guessed.
    conductor
        Its name for whoever conducts it; cannot be derived from `token`.
    settings
        What the conductor decided.
    pictures
        What is shown.
    folder
        Where the pictures are, as whoever began the study names it.
    begun_at, ends_at
        Beginning, and when it is deleted with all answers; UTC.
    """

    token: str
    conductor: str
    settings: StudySettings
    pictures: tuple[StudyPicture, ...]
    folder: str
    begun_at: datetime
    ends_at: datetime


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a participant answered to a picture, and when it was shown.

    Attributes
    ----------
    measured_s
        From the change of light to the picture's appearance, by the clock of the animation.
    shown_s
        How long the picture was to be seen, by the same clock.
    touch_x, touch_y
        Where the pedestrian was, px of the picture; NaN: not seen, or no answer.
    response_s
        From the picture's appearance to the answer, 3,600 s at most; NaN: there is none.
    is_answered
        Whether there is an answer: a touch, or that nobody was seen.
    device
        What it was answered with, in words.

    Raises
    ------
    InputError
        If a number is none or outside its range, or one of the two places is missing.
    """

    measured_s: float
    shown_s: float
    touch_x: float = math.nan
    touch_y: float = math.nan
    response_s: float = math.nan
    is_answered: bool = True
    device: str = ""

    def __post_init__(self) -> None:
        for name in ("measured_s", "shown_s"):
            if not 0 <= getattr(self, name) <= LONGEST_S:
                raise InputError(
                    f"{name}: expected 0 to {LONGEST_S:g} s, got {getattr(self, name):g}"
                )
        if not (math.isnan(self.response_s) or 0 <= self.response_s <= LONGEST_S):
            raise InputError(f"response_s: expected 0 to {LONGEST_S:g} s, got {self.response_s:g}")
        place = (self.touch_x, self.touch_y)
        if not all(map(math.isnan, place)) and not all(abs(value) < 1e6 for value in place):
            raise InputError("a touch has two places, px of the picture")
        if self.is_seen and not self.is_answered:
            raise InputError("a touch is an answer")

    @property
    def is_seen(self) -> bool:
        """Whether the participant says where the pedestrian was."""
        return not math.isnan(self.touch_x)


@dataclass(frozen=True)
class Participant:
    """Somebody who takes part.

    Attributes
    ----------
    code
        Pseudonym; the subject of the trials.
    number
        0-based, the row of the design.
    consented_at
        When they agreed, UTC.
    form
        What they entered, by the field.
    plan
        Their trials.
    has_practised
        Whether the practice was seen to its end.
    """

    code: str
    number: int
    consented_at: datetime
    form: Mapping[str, str]
    plan: tuple[Trial, ...]
    has_practised: bool
