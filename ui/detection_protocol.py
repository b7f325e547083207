"""Detection page: which pedestrians and recordings count."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Final

import streamlit as st

from nvcore.dataset import Dataset
from nvcore.figures.style import count_text
from nvcore.protocols import (
    OCCLUSION_WORDS,
    PROTOCOLS,
    FilteredTruth,
    Protocol,
    filter_truth,
    known_tags,
)
from ui import state
from ui.text import plain

OWN: Final = "own filters"
FURTHEST_PX: Final = 10_000.0
WIDEST: Final = 20.0


def choose(dataset: Dataset) -> Protocol:
    """The chosen protocol, with what its filters leave out told below."""
    left, right = st.columns([1, 1], vertical_alignment="top")
    name = left.selectbox(
        "Protocol", [*PROTOCOLS, OWN], key="protocol", persist_state="session",
        help="Which pedestrians count. The others are ignored: no miss, and no false positive for "
        "who detects them. One set of pedestrians serves both systems.",
    )  # fmt: skip
    tags = known_tags(dataset)
    chosen: list[str] = []
    if tags:
        chosen = right.multiselect(
            "Recordings tagged", tags, key="protocol_tags", placeholder="all recordings",
            persist_state="session", help="Recordings that have all of these tags count.",
        )  # fmt: skip
    protocol = _own_filters(dataset) if name == OWN else PROTOCOLS[name]
    protocol = replace(protocol, tags=tuple(chosen))
    said = "; ".join(protocol.filters)
    st.caption(
        plain(f"{protocol.text} {'Filters: ' + said + '.' if said else 'No filter.'}".strip())
    )
    _draw_left_out(filtered(dataset, protocol))
    return protocol


def filtered(dataset: Dataset, protocol: Protocol) -> FilteredTruth:
    """The ground truth under a protocol, kept while it is shown."""
    return state.workspace().keep(
        "protocol_truth", protocol, lambda: filter_truth(dataset, protocol), most=2
    )


def _own_filters(dataset: Dataset) -> Protocol:
    """The filters one by one, starting with none."""
    height = float(dataset.recordings["height"].max())
    first, second, third, fourth = st.columns(4)
    low = _number(first, "Lowest height (px)", "own_low", 0.0, FURTHEST_PX, 0.0, step=5.0)
    high = _number(
        first, "Highest height (px)", "own_high", 0.0, FURTHEST_PX, None, step=5.0,
        placeholder=f"any ({height:g} is the picture)",
    )  # fmt: skip
    levels = second.pills(
        "Occlusion", range(3), selection_mode="multi", default=[0, 1, 2], key="own_occlusion",
        format_func=OCCLUSION_WORDS.__getitem__, persist_state="session",
        help="Pedestrians whose occlusion is unknown count as not occluded.",
    )  # fmt: skip
    border = _number(
        third, "Margin at the border (px)", "own_border", 0.0, height / 2, 0.0, step=1.0,
        help="The whole box must lie so far inside the picture.",
    )  # fmt: skip
    slim = _number(fourth, "Lowest height / width", "own_slim", 0.0, WIDEST, 0.0, step=0.1)
    tall = _number(
        fourth, "Highest height / width", "own_tall", 0.0, WIDEST, None, step=0.1,
        placeholder="any",
    )  # fmt: skip
    return Protocol(
        name=OWN,
        height_px=_span(low, high),
        occlusion=tuple(sorted(levels)) or (0, 1, 2),
        border_px=None if not border else (border,) * 4,
        aspect=_span(slim, tall),
    )


def _number(place: Any, label: str, key: str, low: float, high: float, value: float | None,
            **more: Any) -> float | None:  # fmt: skip
    number: float | None = place.number_input(
        label, low, high, value, key=key, persist_state="session", **more
    )
    return number


def _span(low: float | None, high: float | None) -> tuple[float, float]:
    """Both ends; the lower one gives way where they cross."""
    top = math.inf if high is None else high
    return min(low or 0.0, top), top


def _draw_left_out(truth: FilteredTruth) -> None:
    out = [f"{name} {n:,}" for name, n in truth.n_left_out.items() if n]
    words = (
        f"{count_text(truth.n_truth, 'pedestrian')} in {count_text(truth.n_images, 'image')} count"
    )
    words += f"; ignored: {', '.join(out)}" if out else "; none is ignored"
    asks_occlusion = set(truth.protocol.occlusion) != {0, 1, 2}
    if asks_occlusion and truth.n_unknown_occlusion:
        words += (
            f". The occlusion of {truth.n_unknown_occlusion:,} is unknown: they count as not "
            "occluded"
        )
    st.caption(f"{words}.")
