"""Pages run by AppTest, and the small sessions that they are shown."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final
from xml.etree.ElementTree import Element, fromstring

import pandas as pd
import pytest
from inputs import drive, session_of
from inputs import write as write_lines
from places import ROOT
from streamlit.testing.v1 import AppTest

from nvcore.inputs.session import Session
from ui.session import sample, state
from ui.session.workspace import Workspace
from ui.shell.pages import START
from ui.shell.sidebar import FOLDED

TIMEOUT_S: Final = 600
"""Of a run that hangs: a fresh clone compiles first, and the machine may do other work too."""
BEGINNING: Final = """import streamlit as st
from ui.session import settings, state
from ui.shell import live_params, pages
settings.begin_run()
wrong = live_params.read()
"""
"""What every run begins with; `wrong` is what the sidebar says of impossible settings."""


def opened(
    name: str = START, *, is_folded: bool = False, space: Workspace | None = None, **address: str
) -> AppTest:
    """The app, opened at this address on this page: no other is drawn before it.

    The sidebar's settings are unfolded on every page, unless `is_folded`. What is open is in this
    workspace, where one is given.
    """
    app = AppTest.from_file(str(ROOT / "ui" / "main.py"), default_timeout=TIMEOUT_S)
    app.session_state[FOLDED] = not is_folded
    if space is not None:
        app.session_state["workspace"] = space
    for key, value in address.items():
        app.query_params[key] = value
    return app.run() if name == START else to_page(app, name)


def to_page(app: AppTest, name: str) -> AppTest:
    return app.switch_page(str(ROOT / "pages" / f"{name}.py")).run()


def alone(name: str, **address: str) -> AppTest:
    """A page without navigation and sidebar."""
    path = str(ROOT / "pages" / f"{name}.py")
    return scripted(f"{BEGINNING}import runpy\nrunpy.run_path({path!r})", **address)


def part(*calls: str, space: Workspace | None = None, **address: str) -> AppTest:
    """Parts of a page by themselves: "ui.views.saliency.figures.draw_numbers(RESULT)".

    In this workspace, where one is given.
    """
    script = "\n".join(calls)
    modules = re.findall(r"\b((?:nvcore|ui)\.[.\w]+)\.\w+\(", script)
    lines = [
        *map("import {}".format, modules),
        BEGINNING,
        script.replace("RESULT", "state.result()"),
    ]
    page = scripted("\n".join(lines), **address)
    if space is not None:
        page.session_state["workspace"] = space
    return page


def space_of(page: AppTest) -> Workspace:
    space: Workspace = page.session_state["workspace"]
    return space


def sidebar(*, page: str = "metrics", is_folded: bool = False, **address: str) -> AppTest:
    """Systems and settings as beside this page, without the page."""
    calls = "ui.shell.systems.draw()", "ui.session.state.write_address()"
    drawn = part(*calls, f"ui.shell.sidebar.draw(wrong, pages.PAGE_OF[{page!r}])", **address)
    drawn.session_state[FOLDED] = not is_folded
    return checked(drawn.run())


def scripted(script: str, **address: str) -> AppTest:
    app = AppTest.from_string(script, default_timeout=TIMEOUT_S)
    for key, value in address.items():
        app.query_params[key] = value
    return app


def begin_with(comparison: Session | Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the app open this, or a session file, instead of the sample."""
    path = comparison
    if isinstance(comparison, Session):
        monkeypatch.setattr(sample, "read_session", lambda _: comparison)
        path = comparison.folder / "session.toml"
    monkeypatch.setattr(state, "SAMPLE", path)


def checked(page: AppTest) -> AppTest:
    assert [error.message for error in page.exception] == []
    return page


def press(page: AppTest, key: str) -> AppTest:
    return checked(page.button(key=key).click().run())


def shown(page: AppTest, kind: str, name: str) -> Any:
    """The widget that now shows what others change, too (`ui.session.settings.key_of`)."""
    form = re.compile(rf"{name}(_\d+)?")
    (widget,) = [widget for widget in page.get(kind) if form.fullmatch(str(widget.key))]
    return widget


def texts(page: AppTest) -> str:
    """All that is said in words, also behind question marks; markup taken away."""
    kinds = (
        *(page.markdown, page.caption, page.error, page.warning, page.info, page.success),
        page.header,
    )
    items = [item for kind in kinds for item in kind]
    behind = [getattr(item.proto, "help", "") for item in [*page.title, *items]]
    shown = "\n".join([*(item.value for item in items), *behind])
    for data in _sent(page, "spec"):
        shown += "\n".join(["", *filter(None, [*data["meta"][:2], data["help"]])])
    return shown.replace("\\", "").replace(":small[]", "")


def tables(page: AppTest) -> list[pd.DataFrame]:
    """Rows and columns of the tables on the page, as the browser gets them; `attrs`: headings."""
    shown = []
    for data in _sent(page, "nRows"):
        table = pd.DataFrame(dict(zip(data["names"], data["values"], strict=True)))
        table.attrs["labels"] = [column["label"] for column in data["columns"]]
        shown.append(table)
    return shown


def figures(page: Any) -> list[dict[str, Any]]:
    """Plotly's JSON of the figures on the page; `layout.meta`: the heading."""
    drawn = [(data["meta"], json.loads(data["spec"])) for data in _sent(page, "spec")]
    return [{**spec, "layout": {**spec["layout"], "meta": meta}} for meta, spec in drawn]


def _sent(page: Any, name: str) -> list[dict[str, Any]]:
    """The data of the components that have such an entry."""
    texts = (item.proto.json or "{}" for item in page.get("bidi_component"))
    every = (json.loads(text, parse_constant=_refuse) or {} for text in texts)
    return [data for data in every if name in data]


def _refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is no JSON")


def measures(page: AppTest, key: str) -> dict[str, tuple[str, ...]]:
    """The cells of a table of measures by the label of their row, its footnotes in brackets."""
    (body,) = [item.proto.body for item in page.get("html") if f'nv-{key}"' in item.proto.body]
    rows = fromstring(body).iterfind(".//tbody/tr")
    return {_cell_text(row[0]): tuple(_cell_text(cell) for cell in row[1:]) for row in rows}


def _cell_text(cell: Element) -> str:
    notes = "".join(f"[{mark.text}]" for mark in cell.iter("sup"))
    text = "".join([cell.text or "", *(part.tail or "" for part in cell)])
    return f"{text}{notes}"


def session(folder: Path, *systems: str) -> Session:
    """The truth of `drive`, and these files of it as systems."""
    return session_of(drive(folder), "truth.csv", *systems)


def unequal_session(folder: Path) -> Session:
    """Two systems without thresholds; X has scores down to 0.01, Y down to 0.5."""
    opened_session = session(folder, "fir.csv", "nir.csv")
    for name, floor, n_boxes in (("fir", 0.01, 6), ("nir", 0.5, 3)):
        lines = [f"urban,{f},{10 * x},0,10,50" for f in range(20) for x in range(n_boxes)]
        lines += [f"urban,{f},{100 + 3 * f},200,40,100" for f in range(20)]  # the pedestrian
        scores = (f"{line},{min(0.99, floor + i / 200):.3f}" for i, line in enumerate(lines))
        write_lines(folder / f"{name}.csv", "recording,frame,x,y,w,h,score", *scores)
    return opened_session


HEAD = "recording,frame,x,y,w,h,track,score\n"


FRAMES = range(30)


def rows(x: int, *, track: int = 1) -> str:
    return "".join(f"night,{frame},{x + frame},200,40,120,{track},0.9\n" for frame in FRAMES)


def write(folder: Path, systems: dict[str, str], *, truth: str) -> Path:
    """A session with one recording without pictures."""
    (folder / "truth.csv").write_text(HEAD.replace(",score", "") + truth.replace(",0.9", ""))
    text = '[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:29"\n'
    text += '[truth]\npath = "truth.csv"\n'
    for name, content in systems.items():
        (folder / f"{name}.csv").write_text(HEAD.replace("track,", "") + content)
        text += f'[[system]]\nname = "{name}"\npath = "{name}.csv"\n'
    session = folder / "session.toml"
    session.write_text(text)
    return session
