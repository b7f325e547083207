"""Settings that the conductor of a study chooses before it begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from itertools import pairwise
from typing import Any, Final, Literal

from nvcore.common.errors import InputError
from nvcore.common.records import decode
from nvcore.common.wording import listed
from nvcore.subjects.driver.inputs.study_tables import LATE_S, is_same_time
from nvcore.subjects.people.form import KEPT_DAYS, check_terms, form_of

Design = Literal["all", "latin"]
DESIGNS: Final[dict[Design, str]] = {
    "all": "Every picture at every time (paper)",
    "latin": "Every picture once (Latin square)",
}
ADAPTATION_S: Final = (0.0, 1.0, 2.5, 4.0, 5.5, 7.0)
"""Seconds from the change of light to the picture's appearance (paper)."""
LONGEST_S: Final = 600.0
MOST_TIMES: Final = 24
"""Maximum number of times after the change of light."""
CONSENT: Final = """\
You look at pictures of roads at dusk, each for a moment, and touch the place where you saw \
a pedestrian. Before each picture the screen is bright, then dark at once. This may be unpleasant \
for eyes that are sensitive to light: do not take part if flashes of light make you ill.

We keep your answers with their times, what you enter about yourself on this page, and how large \
the pictures are on your screen. We keep no name. Tables show a random pseudonym; with your code, \
or the day you joined, the person who conducts the study can find your answers. You may stop at \
any time, without a reason. Tell that person your code, and you get a copy of your answers, or \
they are deleted.
"""
FORM: Final = ("age", "vision", "licence", "screen_inch", "distance_cm")
"""Fields of the form before a study's own questions."""


def _asked(label: str, default: Any) -> Any:
    """Declare a field that the conductor fills in under this label."""
    return field(default=default, metadata={"label": label})


def asked_of(settings: type[Timing | Facts]) -> list[tuple[str, str, Any]]:
    """Return name, label and default of each field that the conductor fills in."""
    return [(of.name, of.metadata["label"], of.default) for of in fields(settings) if of.metadata]


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Duration of each part of a run, seconds (paper: 30 bright, and 0.5 for the picture).

    Attributes
    ----------
    adaptation_s
        Times from the change of light to the appearance of a picture, ascending, an even number of
        at most 24. A run shows its first picture at a time in the first half of the list, and its
        second picture half the list later (paper: 0 and 4, 1 and 5.5, 2.5 and 7, with our pairing).
    answer_s
        Time limit for an answer, from the end of the picture. Without a limit, a late answer delays
        the second picture, and its trial is marked. The paper gives no limit.

    Raises
    ------
    InputError
        If there are too many times, a value is outside its range, or the second picture of a run
        would appear before the time limit of the first answer.
    """

    adaptation_s: tuple[float, ...] = ADAPTATION_S
    bright_s: float = _asked("Bright screen", 30.0)
    preview_s: float = _asked("Coarse picture", 2.0)
    cross_s: float = _asked("Cross before dark", 1.0)
    show_s: float = _asked("Picture", 0.5)
    answer_s: float = _asked("Answer (0: no limit)", 3.0)
    again_s: float = _asked("Cross before the second picture", 0.5)

    def __post_init__(self) -> None:
        times = tuple(float(t) for t in self.adaptation_s)
        object.__setattr__(self, "adaptation_s", times)
        near = [t for t, then in pairwise(times) if is_same_time(then - t)]
        fault = ""
        if len(times) > MOST_TIMES:
            fault = f"expected {MOST_TIMES} at most, got {len(times):,}"
        elif len(times) < 2 or len(times) % 2 or list(times) != sorted(set(times)):
            listed_times = listed([f"{t:g}" for t in times], most=MOST_TIMES)
            fault = f"expected an even number, rising; got {len(times):,}: {listed_times}"
        elif near:
            fault = (
                f"{near[0]:g} s and the next are less than {1000 * LATE_S:g} ms apart; a picture "
                "could be on time for both"
            )
        elif not 0 <= times[0] <= times[-1] <= LONGEST_S:  # also rejects NaN
            fault = f"expected 0 to {LONGEST_S:g} s"
        if fault:
            raise InputError(f"times after the change of light: {fault}")
        for name, value in vars(self).items():
            if name != "adaptation_s" and not 0 <= value <= LONGEST_S:
                raise InputError(f"{name}: expected 0 to {LONGEST_S:g} s, got {value:g}")
        if self.show_s <= 0:
            raise InputError("show_s: a picture is shown for more than 0 s")
        needed_s = self.show_s + self.answer_s + self.again_s
        least_s = min(second_s - first_s for first_s, second_s in self.pairs)
        if self.answer_s > 0 and least_s < needed_s - 1e-9:
            raise InputError(
                f"the second picture comes {least_s:g} s after the first, which needs "
                f"{needed_s:g} s (picture, answer, cross); give less time for the answer"
            )

    @property
    def pairs(self) -> list[tuple[float, float]]:
        """Two times of each kind of run, seconds."""
        half = len(self.adaptation_s) // 2
        return list(zip(self.adaptation_s[:half], self.adaptation_s[half:], strict=True))


@dataclass(frozen=True, kw_only=True)
class Facts:
    """Facts measured or set at the place of the study. None: unknown.

    Raises
    ------
    InputError
        If a value is not above 0.
    """

    screen_inch: float | None = _asked("Diagonal of the screen, inches", None)
    distance_cm: float | None = _asked("Eyes to screen, cm", None)
    bright_lux: float | None = _asked("Bright, lux at the eye", None)
    dark_lux: float | None = _asked("Dark, lux at the eye", None)

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value is not None and not 0 < value < 1e6:
                raise InputError(f"{name}: expected a number above 0, got {value:g}")

    def screen_text(self, form: Mapping[str, str]) -> str:
        """Return screen and distance in words, from a participant's form or else from these facts.

        Examples
        --------
        >>> Facts(screen_inch=24, distance_cm=60).screen_text({"distance_cm": "55"})
        '24 inch, 55 cm away'
        """
        known = {name: f"{value:g}" for name, value in vars(self).items() if value is not None}
        known |= {name: text for name, text in form.items() if text}
        words = {"screen_inch": "{} inch", "distance_cm": "{} cm away"}
        return ", ".join(text.format(known[name]) for name, text in words.items() if name in known)


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """Settings of a study, the same for all participants.

    Attributes
    ----------
    design
        ``all``: every picture at every time. ``latin``: every picture once, and each picture at
        each time once over as many participants as there are times.
    timing, facts
        Timing of runs, and facts about the place.
    consent
        Text that participants agree to.
    questions
        Additional questions of the form, after age, vision and licence.
    n_practice
        Number of runs with drawn pictures before the first. Their answers are discarded.
    keep_days
        Days after the beginning of a study at which it is deleted with all answers.

    Raises
    ------
    InputError
        If a value is invalid.
    """

    design: Design = "latin"
    timing: Timing = Timing()
    facts: Facts = Facts()
    consent: str = CONSENT
    questions: tuple[str, ...] = ()
    n_practice: int = 1
    keep_days: int = KEPT_DAYS

    def __post_init__(self) -> None:
        if self.design not in DESIGNS:
            raise InputError(f"design: expected {' or '.join(DESIGNS)}, got {self.design}")
        check_terms(self.consent, self.keep_days, self.questions)
        if not 0 <= self.n_practice <= 10:
            raise InputError(f"expected 0 to 10 practice runs, got {self.n_practice}")

    @property
    def form(self) -> dict[str, str]:
        """Label of each field of the form. Additional questions are numbered."""
        return form_of(FORM, self.questions)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> StudySettings:
        """Parse settings from the JSON values of `dataclasses.asdict`.

        Raises
        ------
        InputError
            If a value is invalid.
        """
        try:
            return decode(cls, values, "settings of the study")
        except ValueError as error:
            raise InputError(str(error)) from error
