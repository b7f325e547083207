"""One list of all that a browser session remembers."""

from __future__ import annotations

import streamlit as st
from places import ROOT

from ui.session import store
from ui.session.store import Entry, Family

APP = [ROOT / "app.py", *(ROOT / "ui").rglob("*.py"), *(ROOT / "pages").rglob("*.py")]
STORE = ROOT / "ui" / "session" / "store.py"


def test_no_other_file_touches_streamlits_state():
    users = {path for path in APP if "session_state" in path.read_text(encoding="utf-8")}
    assert users == {STORE}


def test_no_two_entries_share_a_key():
    entries = [entry for entry in vars(store).values() if isinstance(entry, Entry)]
    keys = [entry.key for entry in entries]
    assert len(keys) == len({*keys}) > 50


def test_an_entry_has_its_default_until_it_is_set_and_after_it_is_taken_out():
    entry = Entry("test_entry", 3)
    assert (entry.get(), entry.is_set) == (3, False)
    assert entry.setdefault(4) == 4
    entry.set(5)
    assert (entry.setdefault(6), entry.is_set) == (5, True)
    assert (entry.pop(), entry.get(), entry.is_set) == (5, 3, False)


def test_a_default_is_no_place_to_keep_anything_for_other_sessions():
    entry = Entry("test_names", {})
    entry.get()["secret"] = 1
    assert entry.get() == entry.pop() == {}


def test_members_of_a_family_are_apart():
    family = Family("test_family", "")
    family.of("x").set("of x")
    assert (family.of("x").get(), family.of("y").get()) == ("of x", "")
    assert family.known() == [family.of("x")]
    family.of("x").pop()
    assert family.known() == []


def test_what_a_component_has_sent_is_read_however_deep_and_none_if_it_is_not_there():
    st.session_state["test_part"] = {"settled": {"n_plays": 2}, "chosen": "no mapping"}
    assert store.sent("test_part", "settled", "n_plays") == 2
    assert store.sent("test_part", "chosen", "encounter") is None
    assert store.sent("test_part", "absent") is store.sent("no_part", "settled") is None
    del st.session_state["test_part"]
