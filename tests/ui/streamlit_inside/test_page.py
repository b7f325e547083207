"""What our scripts and types take for granted of Streamlit's page; and that no other room does."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
import streamlit as st
from places import ROOT

from ui.streamlit_inside import SCRIPTS, types
from ui.streamlit_inside.server import STATIC

PUBLIC = "streamlit.typing"
APP = [ROOT / "app.py", *(ROOT / "ui").rglob("*.py"), *(ROOT / "pages").rglob("*.py")]


@pytest.fixture(scope="module")
def bundle() -> str:
    """All scripts of Streamlit's page."""
    files = sorted((STATIC / "static" / "js").glob("*.js"))
    return "".join(file.read_text(encoding="utf-8") for file in files)


@pytest.mark.parametrize(
    ("script", "names"),
    [
        ("history.js", ("history.pushState",)),
        ("narrow.js", ("stSidebarCollapseButton", "aria-expanded", "stSidebarCollapsed-")),
        ("theme.js", ("stApp",)),
    ],
)
def test_a_script_relies_on_names_that_the_page_has(
    script: str, names: tuple[str, ...], bundle: str
):
    text = (SCRIPTS / script).read_text(encoding="utf-8")
    for name in names:
        assert name in text
        assert name in bundle


def test_the_types_are_those_of_what_streamlit_returns():
    assert isinstance(st.container(), types.DeltaGenerator)
    assert isinstance(st.Page(lambda: None, url_path="one"), types.StreamlitPage)


def private_imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.startswith("streamlit."))
        elif isinstance(node, ast.ImportFrom) and node.module != PUBLIC:
            yield from re.findall(r"^streamlit\b.*", str(node.module))


def test_no_other_room_imports_from_the_inside_of_streamlit():
    rooms = {path.parent for path in APP if [*private_imports(path)]}
    assert rooms == {SCRIPTS}
