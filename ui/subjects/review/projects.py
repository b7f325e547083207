"""Review page: projects, which keep a comparison with its decisions for several people."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.dataset import Dataset
from nvcore.subjects.review.calls import import_shared, keep_session, open_store, session_of
from nvcore.subjects.review.store import MOST_NAME, QUOTA_BYTES, Project, ProjectStore
from ui.access.login import login
from ui.confined.reading import session_confined, with_recordings_confined
from ui.session import state, store
from ui.shell.messages import errors_shown, shown_root
from ui.subjects.review import kept
from ui.widgets.buttons import button, download, submit_button
from ui.widgets.text import plain

PROJECT: Final = "project"
"""Entry of a project's token in the address."""
NO_PROJECT: Final = "There is no such project, or you are not one of its members."
MOST_ZIP_MB: Final = 500
GB: Final = 1024**3


def follow_address() -> None:
    """Open the project in the address, or write the open one into it."""
    token, opened = st.query_params.get(PROJECT), kept.project()
    if opened is not None and token is None:
        st.query_params[PROJECT] = opened[1].token
    elif token is not None and (opened is None or opened[1].token != token):
        open_(token)


def open_(token: str) -> None:
    """Open a project's comparison, and start the page again.

    Raises
    ------
    NvcoreError
        If the person is no member, or an input is not as it was.
    """
    file, space = open_store(), state.workspace()
    project = file.project(token)
    if project is None or not kept.may_open(file, token):
        raise InputError(NO_PROJECT)
    session = session_of(file, project, read=session_confined)
    query = store.FIRST_QUERY.get()

    def use(_: Dataset) -> None:
        kept.use(token, space.n_opened + 1)
        # the rest of the address is about this comparison: the next run follows it again
        st.query_params.from_dict(query if query.get(PROJECT) == token else {PROJECT: token})
        for entry in (store.SEEN_OPENING, store.PLACE, store.BAD_LINK):
            entry.pop()

    state.open_session(session, label=project.name, check=use)


def draw() -> None:
    """Draw the open project, the form that keeps a comparison, and this person's projects."""
    file, opened = open_store(), kept.project()
    if not kept.who():
        name = st.text_input("Your name", kept.reviewer(), max_chars=100).strip()
        if name != kept.reviewer():
            kept.call(name)
            st.rerun()
    if opened is not None:
        _draw_address(*opened)
    with errors_shown(), st.form("review_keep", border=False):
        label = "Keep this comparison" if opened is None else "Keep another copy"
        name = st.text_input(label, placeholder="Name", key="review_project", max_chars=MOST_NAME)
        if submit_button("Keep", key="review_keep_it"):
            with st.spinner("Keeping the files"):
                _keep(file, name)
            st.rerun()
    for project in mine(file):
        _draw_project(file, project, is_open=opened is not None and opened[1] == project)
    with errors_shown():
        _draw_import(file)
    st.caption(f"Copies: {file.used_bytes() / GB:.1f} of {QUOTA_BYTES / GB:.0f} GB")


def _draw_address(file: ProjectStore, project: Project) -> None:
    """Draw the address of the open project, and a field that adds members."""
    address = str(st.context.url or "").partition("?")[0]
    st.caption(
        f"**{plain(project.name)}** opens for its members at:"
        if login()
        else f"**{plain(project.name)}** opens for everybody who has this address:"
    )
    st.code(f"{address}?{PROJECT}={project.token}", language=None, wrap_lines=True)
    if login() is not None:
        with st.form("review_member", border=False, clear_on_submit=True):
            email = st.text_input("Add a member", placeholder="E-mail", key="review_email")
            if submit_button("Add", key="review_add_member") and email.strip():
                file.add_member(project.token, email.strip())
                st.toast(f"{plain(email.strip())} may open it")


def mine(file: ProjectStore) -> list[Project]:
    """Return the projects of the person who logged in. Without log-in, those of this tab."""
    if login() is not None:
        return file.projects(kept.who())
    found = (file.project(token) for token in kept.notes().get(kept.TOKENS, []))
    return [project for project in found if project is not None]


def _draw_project(file: ProjectStore, project: Project, *, is_open: bool) -> None:
    """Draw a project's name, and buttons to open, export and delete it."""
    token = project.token
    with st.container(horizontal=True, vertical_alignment="center"):
        st.markdown(f"{plain(project.name)}  \n:gray[:small[{project.created_at:%Y-%m-%d}]]")
        if store.REVIEW_DELETES.get() == token:
            st.markdown("Delete it, its decisions and copies?", width="content")
            if button("Delete", key=f"review_delete_{token}", type="primary"):
                store.REVIEW_DELETES.pop()
                if kept.may_open(file, token):
                    file.delete(token)
                if is_open:
                    kept.leave()
                    st.query_params.pop(PROJECT, None)
                st.rerun()
            if button("Cancel", key=f"review_cancel_{token}"):
                store.REVIEW_DELETES.pop()
                st.rerun()
            return
        if button("Open", key=f"review_open_{token}", disabled=is_open):
            with errors_shown():
                open_(token)
        download("Export", lambda: _exported(file, token), "project.zip", key=f"review_zip_{token}")
        if button("Delete …", key=f"review_ask_{token}"):
            store.REVIEW_DELETES.set(token)
            st.rerun()


def _exported(file: ProjectStore, token: str) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "project.zip"
        file.export(token, path)
        return path.read_bytes()


def _keep(file: ProjectStore, name: str) -> None:
    """Keep the open comparison with its decisions. Uploads are copied, other files stay."""
    kept.call_guest()
    space, before = state.workspace(), kept.decisions()
    fingerprint = state.opened().dataset.fingerprint
    session = state.live_session()
    project = keep_session(
        file, name, session, fingerprint, roots=(space.folder, file.copies), owner=kept.who()
    )
    if len(before):
        file.decide(project.token, before)
    kept.use(project.token, space.n_opened)
    st.query_params[PROJECT] = project.token


def _draw_import(file: ProjectStore) -> None:
    sent = st.file_uploader(
        "Import a project", ["zip"], key="review_import", max_upload_size=MOST_ZIP_MB
    )
    if sent is None or not button("Import", key="review_import_it"):
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "project.zip"
        path.write_bytes(sent.getbuffer())
        roots = [state.SAMPLE.parent, *filter(None, [shown_root()])]
        project = import_shared(
            *(file, path, roots),
            owner=kept.who(),
            read=session_confined,
            read_table=with_recordings_confined,
        )
    open_(project.token)
