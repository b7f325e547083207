"""Alerts page: the policy that makes alerts of detections."""

from __future__ import annotations

import streamlit as st

from nvcore.alerts.policy import POLICIES, named_policy
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from ui.session import state
from ui.widgets.text import plain


def own_policies(result: Result) -> dict[str, str]:
    """File of the policy that a system follows whatever policy is chosen, by its letter."""
    inputs = result.dataset.inputs
    files = dict(zip(inputs["conversion"], inputs["file"], strict=True))
    return {
        letter: files[f"policy of {system.name}"]
        for letter, system in result.sides
        if f"policy of {system.name}" in files
    }


def draw(result: Result) -> None:
    """The named policies, of which the one in use is marked; a click takes another."""
    params, view, own = result.params, alerts_in(result), own_policies(result)
    if view.speeding is not None:
        st.header("Alerts by a policy")
    if not view.is_asked:
        st.info("Alerts are off. Choose a policy to judge them.")
    with st.container(horizontal=True, vertical_alignment="center"):
        st.markdown("**Policy**", width="content")
        for name, (text, _) in POLICIES.items() if len(own) < len(result.sides) else ():
            values = {"alerts": "policy", **named_policy(name)}
            is_in_use = all(getattr(params, key) == value for key, value in values.items())
            _choice(name.capitalize(), values, text, is_in_use=is_in_use)
        if len(own) == len(result.sides):
            text = "The policies that the session names for the two systems."
            _choice("Own", {"alerts": "policy"}, text, is_in_use=params.alerts == "policy")
        if any(view.has_log(system) for _, system in result.sides):
            text = "The alerts that the systems themselves have logged, where they have."
            _choice("Own log", {"alerts": "log"}, text, is_in_use=params.alerts == "log")
        if view.is_asked:
            _choice("Off", {"alerts": "off"}, "Alerts are not judged.", is_in_use=False)
    for letter, file in own.items():
        if not view.is_logged(result.system(letter)):
            st.caption(f"{letter.upper()} follows its own policy file {plain(file)}.")
    others = [letter.upper() for letter, _ in result.sides if letter not in own]
    if view.is_asked and others:
        whose = f" of {others[0]}" if own else ""
        st.caption(f"Each part of the policy{whose} can be moved in the sidebar, under Alerts.")


def _choice(label: str, values: dict[str, object], text: str, *, is_in_use: bool) -> None:
    st.button(
        label,
        key=f"alerts_policy_{label.lower().replace(' ', '_')}",
        type="primary" if is_in_use else "secondary",
        help=text,
        on_click=state.set_params,
        kwargs=values,
    )
