"""Projects from Python and from the command line."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from inputs import nvcore
from places import ROOT

import nvcore as nv
from nvcore.common.errors import InputError
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.review.calls import import_shared, keep_session, open_store

SAMPLE = ROOT / "sample_data" / "session.toml"


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "projects.sqlite"
    monkeypatch.setenv("NVCORE_PROJECTS", str(path))
    return path


def test_a_project_stays_with_its_decisions(store: Path) -> None:
    project = nv.open_project("Night", session=SAMPLE)
    case = project.cases.loc[project.cases["systems"] == "y", "case"].iloc[0]
    project.decide(case, "wrong truth", reviewer="Ann", note="a pole")
    again = nv.open_project("Night")
    decided = again.cases.set_index("case").loc[case]
    assert (decided["decision"], decided["note"], decided["is_done"]) == (
        "wrong truth",
        "a pole",
        True,
    )
    measures = again.measures.set_index("measure").loc["severity_s"]
    assert measures["y_reviewed"] == pytest.approx(measures["y"] - decided["severity_s"])
    assert again.robustness is not None
    with pytest.raises(InputError, match="no case"):
        again.decide("0", "ask")
    with pytest.raises(InputError, match="already"):
        nv.open_project("Night", session=SAMPLE)


def test_a_changed_input_is_not_compared(store: Path, tmp_path: Path) -> None:
    assert nvcore("sample", str(tmp_path / "copy")).exit_code == 0
    nv.open_project("Night", session=tmp_path / "copy" / "session.toml")
    (tmp_path / "copy" / "nir.csv").write_text("frame,x,y,w,h\n")
    with pytest.raises(InputError, match=r"changed since it was kept.*nir\.csv"):
        _ = nv.open_project("Night").cases


def test_a_changed_file_of_a_folder_is_not_compared(store: Path, tmp_path: Path) -> None:
    assert nvcore("sample", str(tmp_path / "copy")).exit_code == 0
    path = tmp_path / "copy" / "session.toml"
    (tmp_path / "copy" / "nir").mkdir()
    (tmp_path / "copy" / "nir.csv").rename(tmp_path / "copy" / "nir" / "nir.csv")
    path.write_text(path.read_text().replace('"nir.csv"', '"nir"'))
    nv.open_project("Night", session=path)
    assert nv.open_project("Night").cases.shape[0] > 0
    (tmp_path / "copy" / "nir" / "nir.csv").write_text("frame,x,y,w,h\n")
    with pytest.raises(InputError, match=r"changed since it was kept: nir\.csv"):
        _ = nv.open_project("Night").cases


def test_what_states_sizes_and_rates_is_an_input_too(store: Path, tmp_path: Path) -> None:
    assert nvcore("sample", str(tmp_path / "copy")).exit_code == 0
    (tmp_path / "copy" / "seqinfo.ini").write_text("[Sequence]\nframeRate=20\n")
    nv.open_project("Night", session=tmp_path / "copy" / "session.toml")
    (tmp_path / "copy" / "seqinfo.ini").write_text("[Sequence]\nframeRate=5\n")
    with pytest.raises(InputError, match=r"changed since it was kept: seqinfo\.ini"):
        _ = nv.open_project("Night").cases


def test_a_project_is_imported_under_another_name(store: Path, tmp_path: Path) -> None:
    nv.open_project("Night", session=SAMPLE)
    assert nvcore("review", "export", "Night", str(tmp_path / "night.zip")).exit_code == 0
    taken = nvcore("review", "import", str(tmp_path / "night.zip"))
    assert (taken.exit_code, "give another name" in taken.output) == (2, True)
    assert nvcore("review", "import", str(tmp_path / "night.zip"), "Rain").exit_code == 0
    assert {of.name for of in open_store().projects()} == {"Night", "Rain"}


def test_a_strangers_project_names_no_file_that_it_does_not_bring(
    store: Path, tmp_path: Path
) -> None:
    assert nvcore("sample", str(tmp_path / "copy")).exit_code == 0
    file, session = open_store(), read_session(tmp_path / "copy" / "session.toml")
    named, brought = (
        keep_session(file, name, session, "", roots=roots)
        for name, roots in (("named", ()), ("brought", (tmp_path / "copy",)))
    )
    for project in (named, brought):
        file.export(project.token, tmp_path / f"{project.name}.zip")
    (tmp_path / "copy").rename(tmp_path / "moved")
    made = import_shared(file, tmp_path / "brought.zip", [])
    assert nv.open_project(made.token).cases.shape[0] > 0
    (tmp_path / "moved").rename(tmp_path / "copy")
    with pytest.raises(InputError, match="does not bring"):
        import_shared(file, tmp_path / "named.zip", [tmp_path / "other"])
    assert len(file.projects()) == 3
    assert import_shared(file, tmp_path / "named.zip", [tmp_path / "copy"]).name == "named"


def test_a_strangers_table_of_recordings_names_no_other_file(store: Path, tmp_path: Path) -> None:
    assert nvcore("sample", str(tmp_path / "copy")).exit_code == 0
    path = tmp_path / "copy" / "session.toml"
    table = f"recording,pictures\nodd_pose,{tmp_path / 'secret.mp4'}\n"
    (tmp_path / "copy" / "rec.csv").write_text(table)
    text = path.read_text().replace('pictures = "odd_pose.mp4"\n', "")
    path.write_text(f'[recordings]\npath = "rec.csv"\n{text}')
    file = open_store()
    made = keep_session(file, "brought", read_session(path), "", roots=(tmp_path / "copy",))
    file.export(made.token, tmp_path / "brought.zip")
    with pytest.raises(InputError, match="does not bring"):
        import_shared(file, tmp_path / "brought.zip", [])
    assert len(file.projects()) == 1


def test_the_command_line_lists_decides_and_exports(store: Path, tmp_path: Path) -> None:
    def say(*words: str) -> str:
        done = nvcore("review", *words)
        assert done.exit_code == 0, done.output
        return done.stdout

    assert say("list") == "No projects.\n"
    say("new", "Night", str(SAMPLE))
    assert say("list").startswith("Night  20")
    case = say("list", "Night").splitlines()[1].split()[0]
    say("decide", "Night", case, "wrong-truth", "--reviewer", "Ann", "--note", "a pole")
    assert "wrong truth  a pole" in say("list", "Night").replace("  ", "  ")
    assert case not in say("list", "Night", "--open")
    assert nvcore("review", "check", "Night", "--above", "1.2").exit_code == 1
    for line in say("list", "Night", "--open", "--above", "1.2").splitlines()[1:-2]:
        say("decide", "Night", line.split()[0], "real-miss")
    assert len(say("check", "Night", "--above", "1.2").splitlines()) == 3
    assert "X reviewed" in say("measures", "Night")
    say("export", "Night", str(tmp_path / "night.csv"))
    say("export", "Night", str(tmp_path / "night.zip"))
    say("export", "Night", str(tmp_path / "open.xml"))
    frames = ET.parse(tmp_path / "open.xml").getroot().findall("image")
    assert {box.get("label") for image in frames for box in image} == {"miss", "false alarm"}
    say("backup", str(tmp_path / "backup.sqlite"))
    assert say("list", "--projects", str(tmp_path / "backup.sqlite")).startswith("Night")
    say("delete", "Night")
    assert say("list") == "No projects.\n"
    assert say("import", str(tmp_path / "night.zip")) == "kept: Night\n"
    assert say("import", str(tmp_path / "night.csv"), "Night") == "2 decisions\n"
    assert nvcore("review", "new", "Night").exit_code == 2
    assert "no decision 'maybe'" in nvcore("review", "decide", "Night", case, "maybe").output
