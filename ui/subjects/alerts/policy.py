"""Alerts page: choice of the policy that turns detections into alerts, and unused settings."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import streamlit as st

from nvcore.comparison.compare import Result, compare
from nvcore.settings.params import SETTINGS
from nvcore.settings.stages import Stage
from nvcore.subjects.alerts.policy import POLICIES, POLICY_SETTINGS, named_policy
from nvcore.subjects.alerts.settings import ALERTS, IN_TIME, SPEEDING
from nvcore.subjects.alerts.steps import alerts_in
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.text import plain


def judged(result: Result) -> Result:
    """Return the comparison with alerts, judged by the current policy if alerts are off.

    The page can then show alerts before a policy is chosen. The verdict, files and other pages
    stay without them. Speed signs have their own alerts instead.
    """
    view = alerts_in(result)
    if view.is_asked or view.speeding is not None:
        return result

    def make() -> Result:
        changed: dict[str, Any] = {"alerts": "policy"}
        params = replace(result.params, **changed)
        x, y = result.names
        with_alerts = compare(result.dataset, params, x=x, y=y, previous=result)
        return replace(with_alerts, as_set=result.as_set)

    found: Result = state.cached("alerts_page", comparison_key(result), make)
    return found


def find_idle() -> frozenset[str]:
    """Return the alert settings that do not affect the page in its current state."""
    result = state.result()
    if result is None:
        return frozenset()
    result = judged(result)
    view = alerts_in(result)
    idle: set[str] = set()
    if not view.is_asked:
        idle |= _settings_of(ALERTS, IN_TIME)
    if view.speeding is None:
        idle |= _settings_of(SPEEDING)
    if not view.has_urgency:
        idle |= _settings_of(IN_TIME)
    if not result.dataset.has_detectability:
        idle.add("alert_oracle")
    if result.params.own_reaction_s is None:
        idle.add("own_reaction_sd_s")
    own = own_policies(result)
    if all(letter in own or view.is_logged(system) for letter, system in result.sides):
        idle |= {*POLICY_SETTINGS}
    return frozenset(idle)


def _settings_of(*stages: Stage) -> set[str]:
    return {name for name, setting in SETTINGS.items() if setting.stage in stages}


def own_policies(result: Result) -> dict[str, str]:
    """Return the policy file of each system that has its own and ignores the page's, by letter."""
    inputs = result.dataset.inputs
    files = dict(zip(inputs["conversion"], inputs["file"], strict=True))
    return {
        letter: files[f"policy of {system.name}"]
        for letter, system in result.sides
        if f"policy of {system.name}" in files
    }


def draw(result: Result, *, is_asked: bool) -> None:
    """Draw buttons for the named policies, marking the one in use.

    Parameters
    ----------
    result
        The comparison that `judged` returns.
    is_asked
        True if other pages judge alerts as well.
    """
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
        if is_asked:
            text = "Alerts are not judged, but for this page."
            if view.speeding is not None:
                text = "Alerts are not judged."
            _choice("Off", {"alerts": "off"}, text, is_in_use=False)
    for letter, file in own.items():
        if not view.is_logged(result.system(letter)):
            st.caption(f"{letter.upper()} follows its own policy file {plain(file)}.")
    hints = []
    if view.is_asked and not is_asked:
        hints.append(
            "Shown on this page alone. Choose a policy to have its alerts on the Timeline, in the "
            "verdict and in files."
        )
    others = [letter.upper() for letter, _ in result.sides if letter not in own]
    if view.is_asked and others:
        whose = f" of {others[0]}" if own else ""
        hints.append(f"Each part of the policy{whose} can be moved in the sidebar, under Alerts.")
    if hints:
        st.caption(" ".join(hints))


def _choice(label: str, values: dict[str, object], text: str, *, is_in_use: bool) -> None:
    st.button(
        label,
        key=f"alerts_policy_{label.lower().replace(' ', '_')}",
        type="primary" if is_in_use else "secondary",
        help=text,
        on_click=state.set_params,
        kwargs=values,
    )
