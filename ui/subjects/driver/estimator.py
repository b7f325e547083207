"""Driver page: choice and description of the detectability estimator."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.subjects.driver.estimators.model_file import MAX_BYTES, SAMPLE_ESTIMATOR
from ui.session import state
from ui.shell.messages import error_text, shown_error
from ui.subjects.driver.confined import EstimatorSpec, describe_estimator, on_estimator
from ui.widgets.models import ModelKind, draw_field, model_files
from ui.widgets.text import docs_link

SAMPLE: Final = "sample"
SAMPLE_WORDS: Final = "sample: trained on a simulated observer, not on people"


def described(spec: EstimatorSpec) -> str:
    """Describe an estimator as Markdown.

    Raises
    ------
    NvcoreError
        If the file cannot be used.
    """
    space, what = state.workspace(), "opening the estimator"
    call = partial(space.model_process.call, on_estimator, spec, describe_estimator, what=what)
    text: str = space.cached("estimator", spec, call, most=8)
    return text


def _check(path: Path) -> None:
    described(EstimatorSpec(path, ""))


KIND: Final = ModelKind("estimator", (".npz",), MAX_BYTES, _check)


def draw() -> EstimatorSpec | None:
    """Draw the choice and return it, or draw the reason and return None if it cannot be used."""
    left, right = st.columns([3, 2], gap="large")
    with right, st.expander("An estimator of your own"):
        _draw_field()
    options = _options()  # again, as the field may have accepted a file
    with left:
        key = st.selectbox(
            "Estimator",
            list(options),
            format_func=lambda option: options[option][0],
            key=KIND.name,
            persist_state="session",
        )
        spec = options[key][1]
        try:
            st.caption(described(spec))
        except NvcoreError as error:
            st.error(shown_error(error), icon=":material/error:")
            return None
    return spec


def _options() -> dict[str, tuple[str, EstimatorSpec]]:
    """Return the label and the estimator of each choice. The sample's comes last for other data."""
    options = {
        key: (file.name, EstimatorSpec(file.path, file.version))
        for key, file in model_files(KIND).items()
    }
    sample = {SAMPLE: (SAMPLE_WORDS, EstimatorSpec(SAMPLE_ESTIMATOR, SAMPLE))}
    is_of_sample = state.opened().session.folder == state.SAMPLE.parent
    return {**sample, **options} if is_of_sample else {**options, **sample}


def _draw_field() -> None:
    draw_field(KIND, "Estimator (.npz, as nvcore driver train writes it)", shown=error_text)
    st.caption(
        "It stays on this server while the tab is open. How one is trained: by trials of the page "
        f"Study ({docs_link('how', 'estimators', doc='driver-reference')})."
    )
