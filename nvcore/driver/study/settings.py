"""What the conductor of a study decides before it begins."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from itertools import pairwise
from typing import Any, Final, Literal

from nvcore.driver.inputs.trials import LATE_S, is_same_time
from nvcore.errors import InputError
from nvcore.people.form import KEPT_DAYS, check_terms, form_of
from nvcore.wording import listed

Design = Literal["all", "latin"]
DESIGNS: Final[dict[Design, str]] = {
    "all": "Every picture at every time (paper)",
    "latin": "Every picture once (Latin square)",
}
ADAPTATION_S: Final = (0.0, 1.0, 2.5, 4.0, 5.5, 7.0)
"""Seconds from the change of light to the picture's appearance (paper)."""
LONGEST_S: Final = 600.0
MOST_TIMES: Final = 24
"""Times after the change of light."""
CONSENT: Final = """\
You look at pictures of roads at dusk, each for a moment, and touch the place where you saw \
a pedestrian. Before each picture the screen is bright, then dark at once. This may be unpleasant \
for eyes that are sensitive to light: do not take part if flashes of light make you ill.

We keep your answers with their times, what you enter about yourself on this page, and how large \
the pictures are on your screen. We keep no name: you get a code, and only who has the code can \
say which answers are yours. You may stop at any time, without a reason. Tell the person who \
conducts the study your code, and you get a copy of your answers, or they are deleted.
"""
FORM: Final = ("age", "vision", "licence", "screen_inch", "distance_cm")
"""Fields of the form before a study's own questions."""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """How long each part of a run lasts, seconds.

    Attributes
    ----------
    adaptation_s
        From the change of light to the appearance of a picture: an even number of times, rising,
        24 at most.
        A run shows its first picture at one of the first half, and its second at the one that is
        half the list later (paper: 0 and 4, 1 and 5.5, 2.5 and 7; the pairs are ours).
    bright_s
        Bright screen (paper: 30).
    preview_s
        The coarse picture of each scene of the run.
    cross_s
        Bright screen with the cross, before the change of light.
    show_s
        The picture (paper: 0.5).
    answer_s
        Longest time for an answer, from the end of the picture; 0: no limit, then the second
        picture comes late after a late answer, and its trial is marked. The paper gives none.
    again_s
        The cross before the second picture, at least.

    Raises
    ------
    InputError
        If there are too many times, one is outside its range, or the second picture of a run would
        come before the answer to the first has to be there.
    """

    adaptation_s: tuple[float, ...] = ADAPTATION_S
    bright_s: float = 30.0
    preview_s: float = 2.0
    cross_s: float = 1.0
    show_s: float = 0.5
    answer_s: float = 3.0
    again_s: float = 0.5

    def __post_init__(self) -> None:
        if len(self.adaptation_s) > MOST_TIMES:
            raise InputError(
                f"times after the change of light: expected {MOST_TIMES} at most, got "
                f"{len(self.adaptation_s):,}"
            )
        object.__setattr__(self, "adaptation_s", tuple(float(t) for t in self.adaptation_s))
        times = self.adaptation_s
        if len(times) < 2 or len(times) % 2 or list(times) != sorted(set(times)):
            raise InputError(
                "times after the change of light: expected an even number, rising; "
                f"got {len(times):,}: {listed([f'{t:g}' for t in times], most=MOST_TIMES)}"
            )
        near = [t for t, then in pairwise(times) if is_same_time(then - t)]
        if near:
            raise InputError(
                f"times after the change of light: {near[0]:g} s and the next are less than "
                f"{1000 * LATE_S:g} ms apart; a picture could be on time for both"
            )
        if not 0 <= times[0] <= times[-1] <= LONGEST_S:  # NaN too
            raise InputError(f"times after the change of light: expected 0 to {LONGEST_S:g} s")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "adaptation_s" and not 0 <= value <= LONGEST_S:
                raise InputError(f"{field.name}: expected 0 to {LONGEST_S:g} s, got {value:g}")
        if self.show_s <= 0:
            raise InputError("show_s: a picture is shown for more than 0 s")
        if self.answer_s > 0:
            needed_s = self.show_s + self.answer_s + self.again_s
            for first_s, second_s in self.pairs:
                if second_s - first_s < needed_s - 1e-9:
                    raise InputError(
                        f"the second picture comes {second_s - first_s:g} s after the first, "
                        f"which needs {needed_s:g} s (picture, answer, cross); give less time for "
                        "the answer"
                    )

    @property
    def pairs(self) -> list[tuple[float, float]]:
        """The two times of each kind of run, seconds."""
        half = len(self.adaptation_s) // 2
        return list(zip(self.adaptation_s[:half], self.adaptation_s[half:], strict=True))


@dataclass(frozen=True, kw_only=True)
class Facts:
    """What was measured or set where the study takes place; NaN: not known.

    Attributes
    ----------
    screen_inch
        Diagonal of the screen.
    distance_cm
        From the eye to the screen.
    bright_lux, dark_lux
        Light at the eye while the screen is bright, and while it is dark.

    Raises
    ------
    InputError
        If one is not above 0.
    """

    screen_inch: float = math.nan
    distance_cm: float = math.nan
    bright_lux: float = math.nan
    dark_lux: float = math.nan

    def screen_text(self, form: Mapping[str, str]) -> str:
        """Screen and distance in words, as a participant's form has them, else as here.

        Examples
        --------
        >>> Facts(screen_inch=24, distance_cm=60).screen_text({"distance_cm": "55"})
        '24 inch, 55 cm away'
        """
        parts = []
        for name, text in (("screen_inch", "{} inch"), ("distance_cm", "{} cm away")):
            value = getattr(self, name)
            known = form.get(name, "") or ("" if math.isnan(value) else f"{value:g}")
            parts += [text.format(known)] if known else []
        return ", ".join(parts)

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isnan(value) or 0 < value < 1e6):
                raise InputError(f"{field.name}: expected a number above 0, got {value:g}")


@dataclass(frozen=True, kw_only=True)
class StudySettings:
    """A study, as its participants get it; the same for all of them.

    Attributes
    ----------
    design
        ``all``: every picture at every time; ``latin``: every picture once, and over as many
        participants as there are times each picture at each time once.
    timing, facts
        Of runs, and of the place.
    consent
        Text that participants agree to.
    questions
        Own questions of the form, after age, vision and licence.
    n_practice
        Runs with drawn pictures before the first; their answers are not kept.
    keep_days
        After so many days from its beginning the study is deleted with all answers.

    Raises
    ------
    InputError
        If one of them cannot be.
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
        """Label of each field of the form; own questions are numbered."""
        return form_of(FORM, self.questions)

    def to_json(self) -> dict[str, Any]:
        """As values of JSON; what is not known is null."""
        values = asdict(self)
        values["facts"] = {
            name: None if math.isnan(value) else value for name, value in values["facts"].items()
        }
        return values

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> StudySettings:
        """The inverse of `to_json`."""
        facts = {
            name: math.nan if value is None else float(value)
            for name, value in values["facts"].items()
        }
        timing = {**values["timing"], "adaptation_s": tuple(values["timing"]["adaptation_s"])}
        others = {**values, "questions": tuple(values["questions"])}
        return cls(**{**others, "facts": Facts(**facts), "timing": Timing(**timing)})
