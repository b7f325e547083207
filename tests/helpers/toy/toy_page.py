from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from ui.shell.messages import needs_comparison


@needs_comparison
def draw(result: Result) -> None:
    st.write(f"{result.of('toy').sum()} long encounters")


st.title("Toys")
draw()
