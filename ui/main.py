"""Entry script of the app: navigation, sidebar and error messages shared by all pages."""

from __future__ import annotations

import streamlit as st

from nvcore.common.errors import NvcoreError
from ui.serving.life import settle_memory
from ui.session import settings, state, store
from ui.shell import account, live, live_params, sidebar, systems, tab, title, way_out
from ui.shell.messages import error_banner
from ui.shell.navigate import follow_wish
from ui.shell.pages import all_pages, draw_bar, draw_questions, draw_tabs, page_of
from ui.subject import subject_pages
from ui.subjects.people.studies import is_participant, leave_screen
from ui.widgets.text import plain

# pages with more entries in their address, which they write themselves or leave as they are
# (a comment, because Streamlit would print a docstring here on every page)
WRITE_ADDRESS = ("encounters", "metrics")

st.set_page_config(
    page_title=title.last(),
    page_icon=str(state.ROOT / "ui" / "assets" / "icon.svg"),
    layout="wide",
    initial_sidebar_state="auto",
)
st.logo(str(state.ROOT / "ui" / "assets" / "logo.svg"), size="large")

if not account.is_welcome():
    account.draw_farewell()
    st.stop()

pages = all_pages()
page = st.navigation(list(pages.values()), position="hidden")
here = page_of(page)
bar = st.container(key="navigation_place")
asides = [aside for subject in subject_pages() for aside in subject.asides()]

wrong_params = failure = None
try:
    follow_wish()
    settings.begin_run()
    if not is_participant():
        with bar:
            draw_bar(pages, here)
    tab.follow_history()
    leave_screen(state.workspace(), page.url_path if is_participant() else "")
    if not is_participant():
        with st.sidebar:  # before the page, to reserve the space
            systems.draw()
            for aside in asides:
                aside.draw(page.url_path)
    wrong_params = live_params.read()
    if not is_participant() and here.key not in WRITE_ADDRESS:
        state.write_address()
    if not is_participant():
        title.draw(page.title, page.url_path)
    if wrong := store.BAD_LINK.pop():
        st.warning(f"The link could not be followed in all: {wrong}.", icon=":material/link_off:")
    if refusal := state.workspace().refusal:
        state.workspace().refusal = ""
        st.toast(plain(refusal), icon=":material/error:", duration="infinite")  # outlasts the run
    if not is_participant():
        draw_tabs(pages, here)
    page.run()
    if not is_participant():
        draw_questions(pages, here)
    store.PAGE_LINK.pop()  # it was only for this page
except Exception as error:  # noqa: BLE001  # draw the sidebar, or its widgets lose their values
    error_banner(error)
    failure = error
store.CLICKED.pop()  # the widget is gone
if wrong_params is not None and not is_participant():  # a comparison is open
    try:
        sidebar.draw(wrong_params, here)
    except Exception as error:  # noqa: BLE001  # draw what follows
        if failure is None:
            error_banner(error)
            failure = error
    with st.sidebar:
        tab.draw_memory()
        account.draw()
        live.draw(can_compare=failure is None)
        tab.draw_window()
if failure is None and not is_participant():
    try:
        for aside in asides:
            aside.take_over()  # all is drawn: no click gets lost
    except Exception as error:  # noqa: BLE001  # our bug: do not retry
        for aside in asides:
            aside.give_up()
        error_banner(error)
        failure = error
if failure is not None and not is_participant():
    way_out.draw(is_fault=not isinstance(failure, NvcoreError))
settle_memory()
