"""Detection page: selection of the pedestrians and recordings that count."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

import streamlit as st

from nvcore.common.wording import capitalised, count_text
from nvcore.dataset import Dataset
from nvcore.metrics.detection.filtered_truth import FilteredTruth, filter_truth, known_tags
from nvcore.metrics.detection.miss_rate import explain_few
from nvcore.settings.protocols import OCCLUSION_WORDS, OWN, PROTOCOLS, Protocol, protocol_from
from ui.session import state, store
from ui.widgets.text import plain

OF_SESSION: Final = "filters of the session"
SIDES: Final = ("left", "top", "right", "bottom")


def choose(dataset: Dataset) -> Protocol:
    """Draw the choice of a protocol and what its filters exclude, and return the protocol."""
    start = _start()
    left, middle, right = st.columns([1, 1, 1], vertical_alignment="top")
    name = left.selectbox(
        "Protocol",
        [*([OF_SESSION] if start.name == OWN else []), *PROTOCOLS, OWN],
        key="protocol",
        persist_state="session",
        help=state.say(
            "Which {many} count. The others are ignored: no miss, and no false positive for "
            "whoever detects them. One set of {many} serves both systems. The Overview and the "
            "reports use the same. Own filters start as those of the protocol chosen before."
        ),
    )
    tags = sorted({*known_tags(dataset), *start.tags})
    tagged: list[str] = []
    if tags:
        tagged = middle.multiselect(
            "Recordings tagged",
            tags,
            key="protocol_tags",
            placeholder="all recordings",
            persist_state="session",
            help="Recordings that have all of these tags count.",
        )
    names = list(dict.fromkeys([*state.recording_names(), *start.recordings]))
    chosen: list[str] = []
    if len(names) > 1:
        chosen = (right if tags else middle).multiselect(
            "Recordings",
            names,
            key=store.PROTOCOL_RECORDINGS.key,
            placeholder="all recordings",
            persist_state="session",
            help="Only these count, such as those at night.",
        )
    if name == OWN and store.PROTOCOL_SHOWN.get() != OWN:
        _start_own(state.protocol())
    store.PROTOCOL_SHOWN.set(name)
    if name == OF_SESSION:
        filters = start
    else:
        filters = _own_filters(dataset) if name == OWN else PROTOCOLS[name]
    filters = replace(filters, tags=tuple(tagged), recordings=tuple(chosen))
    protocol = protocol_from(filters.given())
    state.set_protocol(protocol)
    effect = f"Filters: {'; '.join(protocol.filters)}." if protocol.filters else "No filter."
    st.caption(plain(f"{state.say(protocol.text)} {effect}".strip()))
    _draw_left_out(filtered(dataset, protocol))
    return protocol


def _start() -> Protocol:
    """Return the protocol that the open session began with.

    The fields show the one in use if they have no value yet: after opening, and after a reload,
    when a new browser session takes over a workspace with an earlier choice.
    """
    space = state.workspace()
    known: tuple[int, Protocol] | None = space.notes.get("protocol_start")
    if known is None or known[0] != space.n_opened:
        known = space.notes["protocol_start"] = space.n_opened, state.protocol()
    start = known[1]
    shown_of = space.token, space.n_opened
    if store.PROTOCOL_SHOWN_OF.get() == shown_of:
        return start
    live = state.protocol()
    is_start = replace(live, tags=start.tags, recordings=start.recordings) == start
    store.PROTOCOL_SHOWN_OF.set(shown_of)
    store.PROTOCOL_SHOWN.set(None)
    store.set_widgets(
        protocol=OF_SESSION if live.name == OWN and is_start else live.name,
        protocol_tags=list(live.tags),
        protocol_recordings=list(live.recordings),
    )
    return start


def filtered(dataset: Dataset, protocol: Protocol) -> FilteredTruth:
    """Return the ground truth under a protocol, cached while it is shown."""
    return state.cached("protocol_truth", protocol, lambda: filter_truth(dataset, protocol), most=2)


def _start_own(before: Protocol) -> None:
    """Initialise the fields of the custom filters from another protocol."""
    margins = before.border_px or (None,) * 4
    store.set_widgets(
        own_low=before.height_px[0] or None,
        own_high=_limit(before.height_px[1]),
        own_occlusion=list(before.occlusion),
        own_border=margins[0],
        own_slim=before.aspect[0] or None,
        own_tall=_limit(before.aspect[1]),
        own_expand=before.expand,
        own_has_sides=len(set(margins)) > 1,
        **{f"own_border_{side}": margin for side, margin in zip(SIDES, margins, strict=True)},
    )


def _limit(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _own_filters(dataset: Dataset) -> Protocol:
    """Draw the custom filters and return their protocol, or the current one if they conflict."""
    height = float(dataset.recordings["height"].max())
    first, second, third, fourth = st.columns(4)
    low = _number(first, "Lowest height (px)", "own_low", 0.0, step=5.0)
    high = _number(
        first,
        "Highest height (px)",
        "own_high",
        0.0,
        step=5.0,
        placeholder=f"any ({height:g} is the picture)",
    )
    levels = second.pills(
        "Occlusion",
        range(3),
        selection_mode="multi",
        key="own_occlusion",
        format_func=OCCLUSION_WORDS.__getitem__,
        persist_state="session",
        help=state.say(
            "{Many} whose occlusion is unknown count as not occluded. None chosen: all "
            "levels count."
        ),
    )
    border = _margins(third)
    expand = _number(
        third,
        "Detections beyond the heights",
        "own_expand",
        1.0,
        step=0.05,
        placeholder="all",
        help="With 1.25, detections lower than the lowest height / 1.25 or higher than the "
        "highest x 1.25 are left out before matching: no false positives. Empty: all take part.",
    )
    slim = _number(fourth, "Lowest height / width", "own_slim", 0.0, step=0.1)
    tall = _number(fourth, "Highest height / width", "own_tall", 0.0, step=0.1)
    heights, aspect = (low or 0.0, _or_any(high)), (slim or 0.0, _or_any(tall))
    wrong = [place for place, (least, most) in ((first, heights), (fourth, aspect)) if least > most]
    for place in wrong:
        place.error("The lowest is above the highest: the filters stay as they were.")
    if wrong:
        return state.protocol()
    return Protocol(
        name=OWN,
        height_px=heights,
        occlusion=tuple(sorted(levels)) or (0, 1, 2),
        border_px=border,
        aspect=aspect,
        expand=expand,
    )


def _margins(place: Any) -> tuple[float, float, float, float] | None:
    """Draw fields for the margins: one for all sides, or four if the previous protocol has four."""
    help_text = "The whole box must lie so far inside the picture; with 0, up to its edge. Empty: "
    if not store.HAS_SIDES.get():
        margin = _number(
            place,
            "Margin at the border (px)",
            "own_border",
            0.0,
            step=1.0,
            placeholder="none",
            help=f"{help_text}anywhere.",
        )
        return None if margin is None else (margin, margin, margin, margin)
    margins = [
        _number(
            column,
            f"Margin {side} (px)",
            f"own_border_{side}",
            0.0,
            step=1.0,
            placeholder="0",
            help=f"{help_text}0; all four empty: anywhere.",
        )
        for column, side in zip(st.columns(4), SIDES, strict=True)
    ]
    if all(margin is None for margin in margins):
        return None
    left, top, right, bottom = (margin or 0.0 for margin in margins)
    return left, top, right, bottom


def _or_any(high: float | None) -> float:
    return math.inf if high is None else high


def _number(
    place: Any, label: str, key: str, low: float, placeholder: str = "any", **more: Any
) -> float | None:
    number: float | None = place.number_input(
        label, low, None, None, key=key, placeholder=placeholder, persist_state="session", **more
    )
    return number


def _draw_left_out(truth: FilteredTruth) -> None:
    objects = state.opened().dataset.objects
    words = (
        f"{count_text(truth.n_truth, objects.singular, objects.plural)} in "
        f"{count_text(truth.n_images, 'image')} "
        f"count; {truth.left_out or 'none is ignored'}"
    )
    asks_occlusion = set(truth.protocol.occlusion) != {0, 1, 2}
    if asks_occlusion and truth.n_unknown_occlusion:
        words += (
            f". The occlusion of {truth.n_unknown_occlusion:,} is unknown: they count as not "
            "occluded"
        )
    st.caption(f"{words}.")
    few = explain_few(truth.n_truth, objects)
    if few:
        st.warning(f"{capitalised(few)}.", icon=":material/warning:")
