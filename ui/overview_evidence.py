"""Overview page: whether the differences are more than chance, and where they lie."""

from __future__ import annotations

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.analysis import Result
from nvcore.figures.forest import subgroup_forest
from nvcore.figures.style import CONFIG
from nvcore.scorecard import number
from nvcore.subgroups import subgroup_table
from nvcore.verdict import SIGNIFICANT
from ui import state
from ui.overview_scorecard import BETTER
from ui.text import UNDEFINED, docs_link, plain

FIGURE_FORM = ".4f"


def draw(result: Result, evidence: pd.DataFrame) -> None:
    """The table of evidence, and the same by groups of encounters."""
    st.header("Is the difference real?")
    st.dataframe(
        shown_evidence(evidence), hide_index=True, key="evidence", height="content", row_height=30,
        column_config={
            "figure": st.column_config.TextColumn(width=310),
            **{
                name: st.column_config.TextColumn(width=width, alignment="right")
                for name, width in (
                    ("X", 70), ("Y", 70), ("X - Y", 80), ("95 % interval", 150), ("p", 70),
                    ("p (Holm)", 75), ("effect", 95),
                )
            },
        },
    )  # fmt: skip
    notes = dict.fromkeys(note for row in evidence["note"] if row for note in row.split("; "))
    has_blocks = (evidence["unit"] == "blocks").any()
    units = "stretches of these recordings" if has_blocks else "recordings"
    for note in notes:
        st.caption(plain(f"{UNDEFINED} {note[0].upper()}{note[1:]}."))
    st.caption(
        "Both systems saw the same pedestrians, so differences are judged in pairs: how far they "
        f"would vary with other {units} (interval), and how often chance alone would "
        f"make them as large (p; at most {SIGNIFICANT} is called more than chance). p (Holm) "
        "allows for all the rows being looked at together. effect: size of the difference, "
        "Cohen's d or, with ×, the odds ratio "
        f"({docs_link('Significance', 'significance', doc='significance')})."
    )
    with st.expander("How it was computed"):
        for label, method in zip(evidence["label"], evidence["method"], strict=True):
            if method:
                st.markdown(f"- {plain(label)}: {plain(method)}")
    theme = state.theme()
    table = state.workspace().keep(
        "subgroups", (result.params, result.x.name, result.y.name), lambda: subgroup_table(result)
    )
    st.plotly_chart(subgroup_forest(table, theme=theme), theme=None, config=CONFIG, key="subgroups")
    st.caption(
        "Groups are made by the ground truth alone. Many groups give some large differences by "
        "chance: point at one for its p, corrected for all of them."
    )


def shown_evidence(evidence: pd.DataFrame) -> pd.DataFrame:
    """The table of evidence as text; a dash where nothing can be given."""
    rows = []
    for row in evidence.to_dict("records"):
        interval = f"{row['low']:+.4f} to {row['high']:+.4f}"
        rows.append(
            (
                row["label"] + BETTER[row["better"]],
                number(row["x"], FIGURE_FORM),
                number(row["y"], FIGURE_FORM),
                number(row["difference"], "+.4f"),
                interval if np.isfinite(row["low"]) else UNDEFINED,
                number(row["p"], ".2g"),
                number(row["p_holm"], ".2g"),
                number(row["effect"], ".2f") + (" ×" if row["effect_name"] == "odds ratio" else ""),
            )
        )
    return pd.DataFrame(
        rows, columns=["figure", "X", "Y", "X - Y", "95 % interval", "p", "p (Holm)", "effect"]
    )
