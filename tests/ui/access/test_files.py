"""Local browsing: off unless asked for, and never outside its root."""

from __future__ import annotations

from pathlib import Path

import pytest
from inputs import write

from nvcore.common.errors import InputError
from ui.access.files import MAX_NAME_BYTES, Entry, LocalRoot, free_name, local_root, safe_name


@pytest.fixture
def root(tmp_path: Path) -> LocalRoot:
    for name in ("root/b.csv", "root/.secret", "root/night/a.csv", "private/p.csv"):
        write(tmp_path / name, "1")
    return LocalRoot(tmp_path / "root")


def test_it_is_off_unless_asked_for(monkeypatch: pytest.MonkeyPatch):
    for arguments in ([], ["--local-root"]):
        monkeypatch.setattr("sys.argv", ["app.py", *arguments])
        assert local_root() is None


@pytest.mark.parametrize(
    "flag", [["--local-root", "{}"], ["--local-root={}"], ["-x", "--local-root", "{}"]]
)
def test_a_flag_names_the_root(tmp_path: Path, flag: list[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.argv", ["app.py", *(part.format(tmp_path) for part in flag)])
    root = local_root()
    assert root is not None
    assert root.folder == tmp_path.resolve()


def test_a_root_that_is_no_folder_is_told(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", "/nowhere/night")
    with pytest.raises(InputError, match="--local-root: there is no such folder"):
        local_root()


def test_entries_are_named_relative_to_the_root_folders_first(root: LocalRoot):
    assert root.entries() == [Entry("night", True), Entry("b.csv", False)]
    assert root.entries("night") == [Entry("night/a.csv", False)]


@pytest.mark.parametrize(
    "path", ["..", "../private", "night/../../private", "/etc", "../private/p.csv", "nothing"]
)
def test_what_is_outside_is_as_if_it_were_not_there(root: LocalRoot, path: str):
    with pytest.raises(InputError, match="there is no such file or folder"):
        root.find(path)


def test_files_that_folders_of_recordings_share_are_proposed_as_patterns(root: LocalRoot):
    for name in ("A", "B"):
        for file in ("gt/gt.txt", f"res/{name}.txt.gz", "img1/1.jpg", "seqinfo.ini"):
            write(root.folder / "mot" / name / file, "1")
    write(root.folder / "mot" / "A" / "det" / "det.txt", "1")  # of one recording alone
    files, folders = root.patterns("mot")
    assert files == ["mot/*/gt/gt.txt", "mot/*/res/*.txt.gz"]
    assert folders == ["mot/*/img1"]
    assert root.matches(files[0]) == ["mot/A/gt/gt.txt", "mot/B/gt/gt.txt"]
    write(root.folder / "a[1].csv", "1")
    write(root.folder / "a1.csv", "1")
    assert root.matches("a[1].csv") == ["a[1].csv"]  # a file before a pattern


@pytest.mark.parametrize(
    "pattern", ["../*/p.csv", "*/../../private/*", "{}/*", "**/p.csv", "out/*", "o*/p.csv", "*.txt"]
)
def test_no_pattern_tells_what_is_outside(root: LocalRoot, pattern: str):
    (root.folder / "out").symlink_to(root.folder.parent / "private")
    with pytest.raises(InputError, match="there is no such file or folder"):
        root.matches(pattern.format(root.folder.parent / "private"))


def test_links_that_lead_out_are_not_listed(root: LocalRoot):
    (root.folder / "out").symlink_to(root.folder.parent / "private")
    assert "out" not in [entry.path for entry in root.entries()]
    with pytest.raises(InputError, match="there is no such"):
        root.find("out/p.csv")


def test_a_link_that_stays_inside_is_listed(root: LocalRoot):
    (root.folder / "again").symlink_to(root.folder / "night")
    assert Entry("again", True) in root.entries()


def test_a_file_is_no_folder_to_look_into(root: LocalRoot):
    with pytest.raises(InputError, match="cannot be opened"):
        root.entries("b.csv")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("truth.csv", "truth.csv"),
        ("../../etc/passwd", "passwd"),
        ("C:\\Users\\me\\gt.txt", "gt.txt"),
        ("/etc/shadow", "shadow"),
        ("..", "file"),
        (".", "file"),
        ("", "file"),
        (".hidden.csv", "hidden.csv"),
        ("a\x00b\nc.csv", "a_b_c.csv"),
        ("night\u202edrive.csv", "night_drive.csv"),
        ("lone \udc80.csv", "lone _.csv"),
        ("Straße 07.csv", "Straße 07.csv"),
        ("<script>.csv", "_script_.csv"),
    ],
)
def test_a_name_becomes_a_harmless_base_name(name: str, expected: str):
    assert safe_name(name) == expected


def test_a_long_name_is_cut_and_keeps_its_ending():
    name = safe_name("ä" * 500 + ".csv")
    assert len(name.encode()) <= MAX_NAME_BYTES
    assert name.endswith("ä.csv")
    cut_at_a_dot = safe_name("a" * (MAX_NAME_BYTES - 1) + "." + "b" * 20)
    assert safe_name(cut_at_a_dot) == cut_at_a_dot == "a" * (MAX_NAME_BYTES - 1)


def test_a_name_that_is_taken_gets_a_number():
    assert free_name("gt.txt", ["gt.txt", "GT-2.txt"]) == "gt-3.txt"
    assert free_name("gt.txt.gz", ["gt.txt.gz"]) == "gt-2.txt.gz"
