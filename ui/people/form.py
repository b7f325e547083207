"""The form in which participants say something about themselves, and what its owner asks."""

from __future__ import annotations

import math
from collections.abc import Mapping

import streamlit as st

from nvcore.people.form import CHOICES, MOST_QUESTION
from nvcore.people.participants import MOST_TEXT
from ui.widgets.text import plain


def ask_questions(label: str, key: str) -> tuple[str, ...]:
    """A field for own questions of the form, one a line."""
    text = st.text_area(label, key=f"{key}_questions", max_chars=MOST_TEXT)
    return tuple(line.strip() for line in text.splitlines() if line.strip())


def draw_form(
    form: Mapping[str, str], key: str, *, usual: Mapping[str, float] | None = None
) -> dict[str, str]:
    """Draw the fields, and give what was entered; what is left empty is not there.

    Parameters
    ----------
    form
        Labels by field (`nvcore.people.form.form_of`).
    key
        Start of the keys of what is drawn.
    usual
        Screen and distance; NaN: not known.
    """
    answers: dict[str, str] = {}
    columns = st.columns(3)
    for number, (field, label) in enumerate(form.items()):
        column, own = columns[number % 3], f"{key}_form_{number}"
        if field in CHOICES:
            answers[field] = column.selectbox(label, CHOICES[field], index=None, key=own) or ""
        elif field == "age":
            age = column.number_input(label, 1, 120, None, key=own)
            answers[field] = "" if age is None else str(age)
        elif field in ("screen_inch", "distance_cm"):
            known = (usual or {}).get(field, math.nan)
            value = None if math.isnan(known) else known
            size = column.number_input(label, 1.0, 1000.0, value, format="%g", key=own)
            answers[field] = "" if size is None else f"{size:g}"
        else:
            answers[field] = st.text_input(plain(label), key=own, max_chars=MOST_QUESTION).strip()
    return {field: text for field, text in answers.items() if text}
