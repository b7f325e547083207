"""Data page: pictures that cannot be used are listed at their field, never dropped silently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import streamlit as st

from nvcore.wording import MOST_NAMED, listed
from ui.data.missing_inputs import check_pictures
from ui.session.opening import guess_pictures
from ui.widgets.text import plain


@dataclass(frozen=True)
class ChosenPictures:
    """Pictures of a form that can be opened, by label, and why nothing is opened yet."""

    usable: Mapping[str, Path]
    stops: str = ""


def draw_checked(
    place: str, paths: Mapping[str, Path], recordings: Sequence[str], refused: Sequence[str] = ()
) -> ChosenPictures:
    """What is wrong with the pictures of a form, and whether to go on without those.

    Files that were `refused` were not even taken.
    """
    checks = {label: check_pictures(path) for label, path in paths.items()}
    usable = {label: path for label, path in paths.items() if not checks[label].trouble}
    troubles = [
        *refused,
        *(f"{label}: {check.trouble}" for label, check in checks.items() if check.trouble),
    ]
    _draw_unmatched(usable, recordings)
    if not troubles:
        return ChosenPictures(usable)
    text = "\n".join(f"- {plain(trouble)}" for trouble in troubles)
    st.error(f"These pictures were refused:\n{text}", icon=":material/error:")
    goes_on = st.checkbox(
        "Go on without the refused pictures",
        key=f"without_{place}_{hash(tuple(troubles))}",
        help="Pictures are not needed for the numbers: boxes are then drawn on an empty frame.",
    )
    if goes_on:
        return ChosenPictures(usable)
    return ChosenPictures(
        usable,
        "Some pictures were refused; the reason stands at their field. Remove them and choose "
        "others, or tick “Go on without the refused pictures” there.",
    )


def _draw_unmatched(usable: Mapping[str, Path], recordings: Sequence[str]) -> None:
    if not recordings or not usable:
        return
    whose = guess_pictures(recordings, usable)
    if taken := [f"{label} for {name}" for name, label in whose.items() if len(recordings) > 1]:
        st.caption(f"By their names: {plain(listed(taken, most=MOST_NAMED))}.")
    left = [label for label in usable if label not in whose.values()]
    if left:
        st.caption(
            f"Of no recording by their names: {plain(', '.join(left))}. After opening, choose "
            "whose they are in the table “Recordings”."
        )
