"""The audit's findings, which the dashboard keeps in parts, are those of the whole audit."""

from dataclasses import replace

from streamlit.testing.v1 import AppTest

from nvcore.auditing import audit
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from pages import TIMEOUT_S
from ui.session.state import SAMPLE

SCRIPT = """
import streamlit as st
from ui.session import state
from ui.shell import live_params
state.begin_run()
live_params.read()
st.session_state["found"] = state.findings()
st.session_state["inputs"] = id(state.workspace().cached("audit_inputs", (), lambda: None))
"""


def test_findings_follow_the_threshold_and_those_of_the_files_are_made_once():
    dataset = load(read_session(SAMPLE))
    app = AppTest.from_string(SCRIPT, default_timeout=TIMEOUT_S).run()
    assert app.session_state["found"] == audit(dataset)
    inputs = app.session_state["inputs"]
    app.session_state["threshold_x"] = 2.0  # above every score
    app.run()
    assert not app.exception
    params = replace(dataset.params_of(), threshold_x=2.0)
    assert app.session_state["found"] == audit(dataset, params)
    assert "threshold-keeps-nothing" in {one.code for one in app.session_state["found"]}
    assert app.session_state["inputs"] == inputs
