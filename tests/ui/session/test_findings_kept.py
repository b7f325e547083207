"""The audit's findings, which the dashboard keeps in parts, are those of the whole audit."""

from dataclasses import replace

from streamlit.testing.v1 import AppTest

from nvcore import auditing
from nvcore.auditing import audit, audit_inputs
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from pages import TIMEOUT_S
from ui.session.state import SAMPLE

SCRIPT = """
import streamlit as st
from ui.session import settings, state
from ui.session.results import input_findings
from ui.shell import live_params
settings.begin_run()
live_params.read()
st.session_state["findings"] = input_findings()
"""


def test_findings_follow_the_threshold_and_those_of_the_files_are_made_once(monkeypatch):
    dataset = load(read_session(SAMPLE))
    params = replace(dataset.params_of(), threshold_x=2.0)
    as_opened, moved = audit(dataset), audit(dataset, params)
    audited = []
    monkeypatch.setattr(
        auditing, "audit_inputs", lambda dataset: audited.append(dataset) or audit_inputs(dataset)
    )
    app = AppTest.from_string(SCRIPT, default_timeout=TIMEOUT_S).run()
    assert app.session_state["findings"] == as_opened
    for threshold in (0.9, 2.0):  # the latter above every score
        app.session_state["settings"] = {"threshold_x": threshold}
        app.run()
        assert not app.exception
    assert app.session_state["findings"] == moved
    assert "threshold-keeps-nothing" in {finding.code for finding in app.session_state["findings"]}
    assert len(audited) <= 2  # of the sample as it opens, for all sessions; with other settings
