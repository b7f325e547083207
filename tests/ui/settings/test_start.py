"""What the app was started with is what every visitor starts with."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import drive, write
from places import SAMPLE

from nvcore.inputs.session import Session, Source, SystemSource
from nvcore.inputs.session.toml import read_session
from pages import checked, opened, press, texts, to_page
from ui.settings.start import start_file
from ui.views.export.session import inputs_beside, portable_session


@pytest.fixture
def night(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A session file, and the truth elsewhere; the app is started with it."""
    truth = drive(tmp_path / "drive") / "truth.csv"
    (tmp_path / "own").mkdir()
    elsewhere = truth.rename(tmp_path / "own" / "night_truth.csv")
    path = write(
        tmp_path / "drive" / "night.toml",
        '[defaults]\nsize = "640x480"\nfps = 20',
        f'[truth]\npath = "{elsewhere}"',
        '[[system]]\nname = "FIR"\npath = "fir.csv"',
        '[[system]]\nname = "NIR"\npath = "nir.csv"',
    )
    monkeypatch.setenv("NVCORE_SESSION", str(path))
    return path


@pytest.mark.parametrize("flag", [["--session", "{}"], ["--session={}"]])
def test_a_flag_goes_before_the_environment(
    flag: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("sys.argv", ["app.py", "--local-root", "x"])
    assert start_file() is None
    monkeypatch.setenv("NVCORE_SESSION", str(tmp_path / "b.toml"))
    assert start_file() == tmp_path / "b.toml"
    monkeypatch.setattr(
        "sys.argv", ["app.py", *(part.format(tmp_path / "a.toml") for part in flag)]
    )
    assert start_file() == tmp_path / "a.toml"


def test_every_visitor_starts_with_it_and_shares_what_is_read(night: Path):
    pages = [opened(), opened()]
    first, second = (page.session_state["workspace"].opened for page in pages)
    assert first.label == "night.toml"
    assert first is second


def test_the_data_page_opens_the_sample_and_then_it_again(night: Path):
    page = checked(opened("data"))
    assert "Open now: night.toml (" in texts(page)
    assert [tab.label for tab in page.tabs] == ["Upload", "Session file", "Sample", "Start"]
    press(page, "open_sample")
    assert "Open now: Sample recordings (" in texts(page)
    press(page, "open_start")
    assert "Open now: night.toml (" in texts(page)
    assert page.session_state["workspace"].opened is opened().session_state["workspace"].opened


def test_its_link_is_for_everybody_and_names_no_folder(night: Path):
    page = checked(opened("export"))
    assert "It opens night.toml with these parameters, for everybody" in texts(page)
    assert "put session.toml beside its inputs: night_truth.csv, fir.csv, nir.csv" in texts(
        page
    ).replace("`", "")
    assert "own/night_truth.csv" not in texts(page)
    press(to_page(page, "data"), "open_sample")
    (only_here,) = checked(to_page(page, "export")).warning
    words = only_here.value.replace("\\", "")
    assert "elsewhere the link opens night.toml with these parameters" in words


def test_what_cannot_be_read_is_told_without_folders(night: Path, tmp_path: Path):
    (tmp_path / "drive" / "fir.csv").write_text("nothing\n")
    page = opened("data")
    (error,) = page.error
    assert "fir.csv" in error.value.replace("\\", "")
    assert str(tmp_path) not in error.value.replace("\\", "")
    assert "drive/" not in error.value.replace("\\", "")


def test_absolute_paths_outside_are_written_by_as_many_parts_as_tell_them_apart():
    session = Session(
        Path("/srv/night"),
        Source(("/data/truth/a.csv",)),
        (
            SystemSource(("/data/x/a.csv",)),
            SystemSource(("/srv/night/nir.csv",)),
            SystemSource(("../runs/b.csv",)),
        ),
    )
    assert inputs_beside(portable_session(session, is_upload=False)) == [
        "truth/a.csv", "x/a.csv", "nir.csv", "../runs/b.csv",
    ]  # fmt: skip
    assert inputs_beside(portable_session(session, is_upload=False, root=Path("/data"))) == [
        "../../data/truth/a.csv", "../../data/x/a.csv", "nir.csv", "../runs/b.csv",
    ]  # fmt: skip


def test_the_sample_is_the_start_where_nothing_is_named():
    page = opened()
    assert page.session_state["workspace"].opened.session == read_session(SAMPLE)
