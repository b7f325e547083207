"""Patterns name what glob finds, and end where folders have links to themselves."""

from __future__ import annotations

import glob
import os
from pathlib import Path

import pytest

from nvcore.common.errors import InputError
from nvcore.inputs.files import patterns
from nvcore.inputs.files.find import find_files
from nvcore.inputs.files.patterns import matching
from nvcore.inputs.session import Source


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("a/b/c/x.csv", "a/x.csv", "x.csv", "a/.hidden/x.csv", "d/y.txt", "[1]/x.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("frame,x,y,w,h\n1,1,1,9,9\n")
    return tmp_path


@pytest.mark.parametrize(
    "pattern",
    [
        *("**/x.csv", "**/*", "**", "a/**", "**/b/**/x.csv", "**/**/x.csv", "*/x.csv", "[[]1]/*"),
        *("a/**/../*", "none/**/x.csv", "./**/x.csv", "**/.hidden/x.csv", "a/**b/x.csv"),
    ],
)
@pytest.mark.parametrize("is_absolute", [False, True])
def test_without_links_it_is_what_glob_finds(folder: Path, pattern: str, is_absolute: bool):
    pattern = str(folder / pattern) if is_absolute else pattern
    names = glob.glob(pattern, root_dir=folder, recursive=True)  # noqa: PTH207  # as it was
    theirs = {os.path.normpath(folder / name) for name in names}
    ours = [os.path.normpath(folder / name) for name in matching(pattern, folder)]
    assert {name for name in ours if Path(name).is_file()} == {
        name for name in theirs if Path(name).is_file()
    }


def test_links_are_followed_and_those_back_end_the_way(folder: Path):
    (folder / "other").symlink_to(folder / "a", target_is_directory=True)
    for name in ("one", "two", "three"):
        (folder / "a" / "b" / name).symlink_to(folder, target_is_directory=True)
    names = matching("**/**/x.csv", folder)
    assert {"x.csv", "a/x.csv", "other/x.csv", "a/b/c/x.csv", "other/b/c/x.csv"} <= {*names}
    assert all(name.count("/one/") + name.count("/two/") < 2 for name in names)
    assert len(names) < 100
    files, _ = find_files(Source(("**/**/y.txt",), format="csv"), folder, "truth")
    assert [file.path.name for file in files] == ["y.txt"] * len(files)


def test_too_many_folders_are_refused(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(patterns, "MOST_FOLDERS", 3)
    with pytest.raises(InputError, match=r"stands for more than 3 folders here"):
        matching("**/x.csv", folder)
