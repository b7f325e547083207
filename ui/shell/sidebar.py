"""Sidebar of every page: the compared recordings and the live parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import streamlit as st

from nvcore.common.errors import ParameterError
from nvcore.common.wording import capitalised
from nvcore.evidence.operating_points import moved_of
from nvcore.figures.inputs import proximity_plot
from nvcore.figures.maps import cost_plot
from nvcore.settings.params import SETTINGS, settings_for
from nvcore.settings.params.traffic import count_contexts
from nvcore.settings.stages import MATCH, PROXIMITY, THRESHOLD, Setting
from ui.session import settings, state, store
from ui.shell import live_params, operating_point, presets, recordings_filter
from ui.subject import Page
from ui.widgets.charts import draw_chart, kept_figure
from ui.widgets.drawing import cost_map_of
from ui.widgets.text import plain

SLIDER_OF_HEIGHT: Final = {"midpoint": (0.0, 0.5, 0.1), "spread": (1.0, 0.15, 0.1)}
"""Lowest value (px), highest value as a share of the picture's height, and step (px)."""
SHORT_GROUPS: Final = {MATCH.group: "Matching"}
"""Headings of advanced settings that are only a part of their group."""
FOLDED: Final = "show_settings"
GREY: Final = "Settings in grey have no effect on this page."


def draw(wrong: str, page: Page) -> None:
    """Draw the sidebar of a page with the error message `wrong`. Call this after drawing the page.

    Folded settings are drawn only on request. `ui.shell.systems` draws X and Y before the page.
    """
    shown, moved = page.stages(), presets.changed()
    quiet = {name for name, setting in SETTINGS.items() if not setting.moves(shown)}
    with st.sidebar:
        recordings_filter.draw()
        is_folded = page.is_folded or not shown
        if not is_folded or _is_unfolded(len(moved)):
            _Settings(page, quiet | page.idle(), moved).draw()
        if wrong:
            st.error(f"{plain(wrong)}. The last settings that worked stay in use.")


def _is_unfolded(n_moved: int) -> bool:
    words = f"Settings ({n_moved} changed)" if n_moved else "Settings"
    return st.toggle(words, key=FOLDED, persist_state="session")


@dataclass(frozen=True)
class _Settings:
    """The settings as they are drawn beside a page.

    Attributes
    ----------
    quiet
        Settings without effect on the page, which are grey.
    moved
        Settings that differ from the preset, and its values.
    """

    page: Page
    quiet: set[str]
    moved: dict[str, Any]

    def draw(self) -> None:
        """Draw the page's own settings, then thresholds, then settings for the weight of a miss.

        Every new comparison needs thresholds.
        """
        has_told = self._draw_own()
        for name in settings_for(THRESHOLD):
            self._threshold(name)
        operating_point.draw()
        presets.draw(self.moved)
        if not has_told and any(not setting.is_advanced for setting in self._quiet_settings()):
            st.caption(GREY)
        for name, setting in SETTINGS.items():
            if name == "proximity":
                self._proximity()
            elif not setting.is_advanced and setting.stage not in (PROXIMITY, THRESHOLD):
                self._widget(name)
        self._advanced()
        st.button("Reset all parameters", width="stretch", on_click=_reset)

    def _draw_own(self) -> bool:
        """Draw the page's own settings by stage, and return whether any of them is grey."""
        stages = self.page.own
        if not stages:
            return False
        names = [
            name
            for stage in stages
            for name, setting in SETTINGS.items()
            if setting.stage is stage and name not in self.page.controls
        ]
        st.markdown(f"**{stages[0].group}**")
        is_any_quiet = not self.quiet.isdisjoint(names)
        if is_any_quiet:
            st.caption(GREY)
        for name in names:
            self._widget(name)
        return is_any_quiet

    def _label(self, name: str) -> str:
        """Return the label of a setting's widget, with a mark if it differs from the preset."""
        label = state.say(SETTINGS[name].label_with_unit)
        return f"{label} {presets.MARK}" if name in self.moved else label

    def _quiet_settings(self) -> list[Setting]:
        """Return the active settings that have no effect on this page."""
        quiet = (SETTINGS[name] for name in self.quiet)
        return [setting for setting in quiet if live_params.is_used(setting)]

    def _quietness(self, name: str, text: str = "") -> dict[str, Any]:
        """Return `help` and `disabled` for a widget, disabled if its setting has no effect here."""
        setting, is_quiet = SETTINGS[name], name in self.quiet
        start = "Grey: no effect on this page. " if is_quiet else ""
        return {
            "help": f"{start}{state.say(text or setting.meaning)} Acts on: {setting.acts_on}.",
            "disabled": is_quiet,
        }

    def _proximity(self) -> None:
        kind = self._widget("proximity")
        if kind == "horizon":
            self._horizon()
        for name in settings_for(PROXIMITY):
            setting = SETTINGS[name]
            if name in ("proximity", "horizon") or not live_params.is_used(setting):
                continue
            if setting.height_share is not None:
                low, high_share, step = SLIDER_OF_HEIGHT[name]
                self._number_slider(
                    name,
                    low=low,
                    high=high_share * live_params.picture_height(),
                    value=live_params.slider_start(name),
                    step=step,
                )
            else:
                self._widget(name)
        if kind != "none":
            _proximity_plot()
        _cost_map()

    def _horizon(self) -> None:
        value = live_params.value_of("horizon")
        settings.give("horizon", value)
        st.number_input(
            self._label("horizon"),
            value=value,
            key="horizon",
            placeholder="each recording's own",
            on_change=settings.take,
            args=("horizon",),
            **self._quietness("horizon"),
        )

    def _threshold(self, name: str) -> None:
        """Draw a slider over the scores of X or Y. At the lowest score every detection counts."""
        letter = name[-1]
        if state.systems()["xy".index(letter)] is None:
            return
        scale = live_params.threshold_scale(letter)
        if scale is None:
            if getattr(state.params(), name) is None:
                st.caption(f"{letter.upper()} has no scores that differ: every detection counts.")
            return
        low, high, step = scale
        session_value = getattr(state.session_params(), name)
        self._number_slider(
            name,
            low=low,
            high=high,
            value=low if session_value is None else session_value,
            step=step,
            help_text=SETTINGS[name].meaning + " At the left end all count.",
        )
        result = state.result()
        if result is not None and result.as_set is not None and moved_of(result) == letter:
            threshold = result.system(letter).threshold
            in_use = "every detection counts" if threshold is None else f"**{threshold:g}**"
            st.caption(f"In use at equal false alarms: {in_use}.")
        elif live_params.counts_all(letter):
            st.caption(f"Every detection of {letter.upper()} counts.")

    def _advanced(self) -> None:
        """Draw rarely changed parameters. While folded, they cost no time."""
        place = st.expander("Advanced", key="advanced", on_change="rerun")
        names_of: dict[str, list[str]] = {}
        for name, setting in SETTINGS.items():
            if setting.is_advanced and setting.stage not in self.page.own:
                names_of.setdefault(setting.group, []).append(name)
        quiet = self._quiet_settings()
        if place.open and quiet and all(setting.is_advanced for setting in quiet):
            place.caption(GREY)
        for group, names in names_of.items():
            if place.open and any(live_params.is_used(SETTINGS[name]) for name in names):
                with place:
                    st.markdown(f"**{SHORT_GROUPS.get(group, group)}**")
                    for name in names:
                        if live_params.is_used(SETTINGS[name]):
                            self._widget(name)

    def _widget(self, name: str) -> Any:
        """Draw the widget of a parameter as `Params` describes it, and return its value."""
        setting = SETTINGS[name]
        if setting.unset and not self._is_set(name, setting):
            return None
        choices = setting.words
        if choices is None:
            self._slider(name, setting)
            return live_params.value_of(name)
        settings.give(name, live_params.value_of(name))
        return st.selectbox(
            self._label(name),
            list(choices),
            format_func=lambda value: state.say(choices[value]),
            key=name,
            on_change=settings.take,
            args=(name,),
            **self._quietness(name),
        )

    def _is_set(self, name: str, setting: Setting) -> bool:
        """Draw the switch of an optional parameter, and return whether the parameter is set."""
        value = live_params.value_of(name) is None
        key = settings.key_of(f"{name}_unset", value)
        is_unset = st.checkbox(
            f"{state.say(setting.label)}: {setting.unset}",
            value=value,
            key=key,
            on_change=_switch,
            args=(name, key),
            **self._quietness(name),
        )
        if is_unset and name == "edge_weight":
            contexts = state.opened().dataset.frame_columns.context
            st.caption(f"Context of recordings: {count_contexts(contexts)}.")
        return not is_unset

    def _slider(self, name: str, setting: Setting) -> None:
        low = setting.step if setting.is_above_low else setting.low
        high = setting.high if setting.slider_high is None else setting.slider_high
        value = live_params.slider_start(name)
        self._number_slider(
            name,
            low=float(low),
            high=max(float(high), value),
            value=value,
            step=setting.step,
            format=setting.slider_format,
        )

    def _number_slider(
        self,
        name: str,
        *,
        low: float,
        high: float,
        value: float,
        step: float,
        help_text: str = "",
        **more: Any,
    ) -> None:
        # a session or a link may set any valid value: the slider is extended to it and stays so,
        # because a slider with other ends is a new widget and loses its value
        made = live_params.value_of(name)
        given = float(value if made is None else made)
        reached = store.SLIDER_ENDS.of(name)
        base, (least, most) = reached.get()
        if base != (low, high, step):
            least, most = low, high
        ends = min(least, given), max(most, given, low + step)
        settings.give(name, given)
        reached.set(((low, high, step), ends))
        st.slider(
            self._label(name),
            min_value=ends[0],
            max_value=ends[1],
            # a browser misses the value set by one run if the next run overtakes it
            value=given,
            step=float(step),
            key=name,
            on_change=settings.take,
            args=(name,),
            **self._quietness(name, help_text),
            **more,
        )


def _reset() -> None:
    store.PRESET.pop()  # changes are again relative to the open session
    store.WANTS_RESET.set(True)


def _proximity_plot() -> None:
    """Plot the proximity weight against the heights of pedestrians."""
    dataset, theme = state.opened().dataset, state.theme()
    names = state.params().only_for(PROXIMITY)
    figure = kept_figure(  # it stays while other sliders move
        "proximity_plot",
        (names, theme),
        lambda: proximity_plot(dataset, names, theme=theme),
        most=8,
    )
    draw_chart(figure, "proximity_plot")


def _switch(name: str, key: str) -> None:
    if not settings.is_chosen(f"{name}_unset", key):
        return
    value = None if store.widget(key).get() else live_params.slider_start(name)
    state.set_params(**{name: value})


def _cost_map() -> None:
    """Draw the cost of missing a pedestrian over the picture of the current recording."""
    place = st.expander("What a miss costs, by place", key="cost_map", on_change="rerun")
    if not place.open:  # folded, it costs neither server nor browser time
        return
    recording = state.recording()
    try:
        cost = cost_map_of(recording)
    except ParameterError:  # reported below in the sidebar
        return
    with place:
        draw_chart(
            cost_plot(cost, theme=state.theme(), objects=state.opened().dataset.objects),
            "cost_plot",
            help=state.say(
                "k × border of {a_one} with the {feet} there, 0 to 1, in {where}. {cost}. "
                "Over the picture: Timeline, key c.",
                where=plain(state.recording_names()[recording]),
                cost=plain(capitalised(state.say(cost.text))),
            ),
        )
