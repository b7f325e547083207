"""Alerts page: the policy that makes alerts of detections."""

from __future__ import annotations

import streamlit as st

from nvcore.alerts.policy import POLICIES, named_policy
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from ui.session import state


def draw(result: Result) -> None:
    """The named policies, of which the one in use is marked; a click takes another."""
    params, view = result.params, alerts_in(result)
    if not view.is_asked:
        st.info("Alerts are off. Choose a policy to judge them.")
    with st.container(horizontal=True, vertical_alignment="center"):
        st.markdown("**Policy**", width="content")
        for name, policy in POLICIES.items():
            values = {"alerts": "policy", **named_policy(name)}
            is_in_use = all(getattr(params, key) == value for key, value in values.items())
            _choice(name.capitalize(), values, policy.text, is_in_use=is_in_use)
        if any(view.has_log(system) for _, system in result.sides):
            text = "The alerts that the systems themselves have logged, where they have."
            _choice("Own log", {"alerts": "log"}, text, is_in_use=params.alerts == "log")
        if view.is_asked:
            _choice("Off", {"alerts": "off"}, "Alerts are not judged.", is_in_use=False)
    if view.is_asked:
        st.caption("Each part of the policy can be moved in the sidebar, under Alerts.")


def _choice(label: str, values: dict[str, object], text: str, *, is_in_use: bool) -> None:
    st.button(
        label,
        key=f"alerts_policy_{label.lower().replace(' ', '_')}",
        type="primary" if is_in_use else "secondary",
        help=text,
        on_click=state.set_params,
        kwargs=values,
    )
