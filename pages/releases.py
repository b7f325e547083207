"""What changed page: what a new version of a system does differently."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.session import state
from ui.shell.messages import draw_warnings, needs_comparison
from ui.subjects.releases import cases, versions
from ui.widgets.text import docs_link


@needs_comparison
def draw(_: Result) -> None:
    """Draw the versions, the cases that changed, the tests, and measures over all versions."""
    result = state.result_as_set()  # as in the gate: a release has its own threshold
    assert result is not None
    versions.draw_choice(result)
    draw_warnings(result, has_point=True)
    cases.draw_tiles(result)
    cases.draw(result)
    versions.draw_tests(result)
    versions.draw_measures(result)


st.title("What changed", help=f"{docs_link('Releases', 'releases', doc='releases')}.")
draw()
