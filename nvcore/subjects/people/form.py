"""Terms that participants agree to, and the form in which they describe themselves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from nvcore.common.errors import InputError

FIELDS: Final = {
    "age": "Age in years",
    "sex": "Sex",
    "vision": "Vision",
    "licence": "Driving licence",
    "night_driving": "Driving at night",
    "screen_inch": "Diagonal of the screen, inches",
    "distance_cm": "Distance from your eyes to the screen, cm",
}
"""Fields that a form may have, with labels; none has to be filled in."""
CHOICES: Final = {
    "sex": ("female", "male", "other"),
    "vision": ("normal", "corrected by glasses or lenses", "impaired"),
    "licence": ("yes", "no"),
    "night_driving": ("never", "less than once a month", "every month", "every week", "every day"),
}
"""Answers of the fields with a fixed choice."""
MOST_TEXT: Final = 20_000
"""Maximum number of characters of a text of consent."""
KEPT_DAYS: Final = 365
"""Default number of days that answers are kept."""
LONGEST_KEPT_DAYS: Final = 3650
MOST_QUESTIONS: Final = 20
MOST_QUESTION: Final = 300
MOST_ANSWER: Final = 2000
"""Maximum number of characters of an answer in the form."""


def check_terms(consent: str, keep_days: int, questions: Sequence[str] = ()) -> None:
    """Refuse an invalid text of consent, number of days, or own question.

    Raises
    ------
    InputError
        If a text is missing, too long or asked twice, or answers are kept too briefly or too long.
    """
    if not 0 < len(consent.strip()) <= MOST_TEXT:
        raise InputError(f"the text of consent has 1 to {MOST_TEXT:,} characters")
    if not 1 <= keep_days <= LONGEST_KEPT_DAYS:
        raise InputError(f"answers are kept 1 to {LONGEST_KEPT_DAYS} days")
    if len(questions) > MOST_QUESTIONS:
        raise InputError(f"a form has {MOST_QUESTIONS} own questions at most")
    if any(not 0 < len(text.strip()) <= MOST_QUESTION for text in questions):
        raise InputError(f"a question has 1 to {MOST_QUESTION} characters")
    if len(set(questions)) < len(questions):
        raise InputError("two questions of the form are the same")


def form_of(fields: Iterable[str], questions: Sequence[str]) -> dict[str, str]:
    """Return the label of each field of a form. Own questions are numbered.

    Examples
    --------
    >>> form_of(["age"], ["Shoe size"])
    {'age': 'Age in years', '1. Shoe size': 'Shoe size'}
    """
    own = {f"{n}. {text}": text for n, text in enumerate(questions, start=1)}
    return {**{field: FIELDS[field] for field in fields}, **own}


def check_answers(form: Mapping[str, str], answers: Mapping[str, str]) -> None:
    """Refuse answers that are too long, or to a field that the form does not have.

    Raises
    ------
    InputError
        If there is one.
    """
    unknown = [field for field in answers if field not in form]
    if unknown:
        raise InputError(f"the form has no field {unknown[0][:MOST_QUESTION]}")
    if any(len(text) > MOST_ANSWER for text in answers.values()):
        raise InputError(f"an answer of the form has {MOST_ANSWER:,} characters at most")
