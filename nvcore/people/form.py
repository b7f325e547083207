"""What participants say about themselves: fields that studies share, and own questions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from nvcore.errors import InputError

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
"""Fields with few answers."""
MOST_QUESTIONS: Final = 20
MOST_QUESTION: Final = 300
MOST_ANSWER: Final = 2000
"""Characters of a field of the form."""


def form_of(fields: Iterable[str], questions: Sequence[str]) -> dict[str, str]:
    """Label of each field of a form; own questions are numbered.

    Examples
    --------
    >>> form_of(["age"], ["Shoe size"])
    {'age': 'Age in years', '1. Shoe size': 'Shoe size'}
    """
    own = {f"{n}. {text}": text for n, text in enumerate(questions, start=1)}
    return {**{field: FIELDS[field] for field in fields}, **own}


def check_questions(questions: Sequence[str]) -> None:
    """Refuse own questions that cannot be.

    Raises
    ------
    InputError
        If there are too many, one is empty or too long, or two are the same.
    """
    if len(questions) > MOST_QUESTIONS:
        raise InputError(f"a form has {MOST_QUESTIONS} own questions at most")
    if any(not 0 < len(text.strip()) <= MOST_QUESTION for text in questions):
        raise InputError(f"a question has 1 to {MOST_QUESTION} characters")
    if len(set(questions)) < len(questions):
        raise InputError("two questions of the form are the same")


def check_answers(form: Mapping[str, str], answers: Mapping[str, str]) -> None:
    """Refuse answers to what the form does not ask, or that are too long.

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
