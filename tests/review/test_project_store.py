"""Projects stay: through kills, beside other writers, until they are deleted."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from places import ROOT

from nvcore.common.errors import InputError, StoreError
from nvcore.subjects.review import store as store_module
from nvcore.subjects.review.decisions import make_decision
from nvcore.subjects.review.store import ConflictError, ProjectStore, refuse_network


@pytest.fixture
def store(tmp_path: Path) -> ProjectStore:
    return ProjectStore(tmp_path / "data" / "projects.sqlite")


def on(case: str, reviewer: str, decision: str = "real miss") -> pd.DataFrame:
    return make_decision(case, decision, reviewer=reviewer)


def test_a_project_has_members_and_nobody_else(store: ProjectStore) -> None:
    project = store.create("Night drive", "[truth]", owner="ann")
    store.create("Rain", "[truth]", owner="bob")
    assert [of.name for of in store.projects("ann")] == ["Night drive"]
    assert not store.is_member(project.token, "bob")
    store.add_member(project.token, "bob")
    assert {of.name for of in store.projects("bob")} == {"Rain", "Night drive"}
    assert store.project(project.token) == project
    assert store.project("guessed") is None
    with pytest.raises(InputError, match="1 to 200"):
        store.create(" ", "")


def test_decisions_are_kept_in_their_order(store: ProjectStore) -> None:
    token = store.create("a", "").token
    first = store.decide(token, on("c1", "ann"))
    store.decide(token, pd.concat([on("c1", "ann", "ask"), on("c2", "bob")]))
    table = store.decisions(token)
    assert table["decision"].tolist() == ["real miss", "ask", "real miss"]
    assert store.decisions(token, since=first)["case"].tolist() == ["c1", "c2"]


def test_who_decided_meanwhile_is_shown(store: ProjectStore) -> None:
    token = store.create("a", "").token
    seen = store.decide(token, on("c1", "ann"))
    store.decide(token, on("c1", "bob", "wrong truth"), seen=seen)
    with pytest.raises(ConflictError, match="bob") as caught:
        store.decide(token, on("c1", "ann", "ask"), seen=seen)
    assert caught.value.theirs["decision"] == "wrong truth"
    store.decide(token, on("c2", "ann"), seen=seen)
    store.decide(token, on("c1", "ann", "ask"))
    assert len(store.decisions(token)) == 4


def test_copies_stay_as_long_as_a_project_uses_them(store: ProjectStore, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("frame,x,y,w,h\n")
    (tmp_path / "up").mkdir()
    (tmp_path / "x.csv").rename(upload := tmp_path / "up" / "x.csv")
    first, second = (store.create(name, "", copied=[upload], root=tmp_path) for name in "ab")
    size = store.used_bytes()
    assert size == upload.stat().st_size
    upload.unlink()
    assert store.changed_inputs(first.token) == []
    store.delete(first.token)
    assert (store.tree(second.token) / "up" / "x.csv").read_text() == "frame,x,y,w,h\n"
    assert store.used_bytes() == size
    store.delete(second.token)
    assert {path.name for path in store.copies.rglob("*") if path.is_file()} == {".lock"}
    assert store.decisions(first.token).empty


def test_a_changed_input_is_named(store: ProjectStore, tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("same.csv", "touched.csv", "other.csv", "gone.csv")]
    for path in paths:
        path.write_text("1")
    token = store.create("a", "", inputs=paths).token
    os.utime(paths[1], ns=(1, 1))
    paths[2].write_text("2")
    paths[3].unlink()
    assert store.changed_inputs(token) == [str(paths[3]), str(paths[2])]


def test_the_quota_is_held(
    store: ProjectStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(store_module, "QUOTA_BYTES", 5)
    (tmp_path / "x.csv").write_text("123456")
    with pytest.raises(InputError, match="delete one"):
        store.create("a", "", copied=[tmp_path / "x.csv"], root=tmp_path)
    assert store.projects() == []


def test_a_project_travels_as_one_file(store: ProjectStore, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("1")
    token = store.create("Night", "[truth]", copied=[tmp_path / "x.csv"], root=tmp_path).token
    store.decide(token, on("c1", "ann"))
    store.export(token, tmp_path / "night.zip")
    other = ProjectStore(tmp_path / "other" / "projects.sqlite")
    project = other.import_(tmp_path / "night.zip", owner="bob")
    assert (project.name, project.session) == ("Night", "[truth]")
    assert project.token != token
    assert other.decisions(project.token)["case"].tolist() == ["c1"]
    assert (other.tree(project.token) / "x.csv").read_text() == "1"
    assert other.changed_inputs(project.token) == []
    (tmp_path / "no.zip").write_text("no")
    with pytest.raises(InputError, match="no project"):
        other.import_(tmp_path / "no.zip")


@pytest.mark.parametrize(
    ("stated", "forged", "told"),
    [
        (b'"x.csv"', b'"../../../x.csv"', "leaves the project"),
        (b'"sha256": "', b'"sha256": "../', "no hash"),
        (b'"real miss"', b'"perfect"', "no decision"),
    ],
)
def test_a_forged_project_is_refused(
    stated: bytes, forged: bytes, told: str, store: ProjectStore, tmp_path: Path
) -> None:
    (tmp_path / "x.csv").write_text("1")
    token = store.create("a", "", copied=[tmp_path / "x.csv"], root=tmp_path).token
    store.decide(token, on("c1", "ann"))
    store.export(token, tmp_path / "a.zip")
    rewrite(tmp_path / "a.zip", lambda _, content: content.replace(stated, forged))
    with pytest.raises(InputError, match=told):
        store.import_(tmp_path / "a.zip")
    assert len(store.projects()) == 1


def test_a_hash_alone_gives_nobody_a_file(store: ProjectStore, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text("secret")
    token = store.create("a", "", copied=[tmp_path / "x.csv"], root=tmp_path).token
    store.export(token, tmp_path / "a.zip")
    rewrite(
        tmp_path / "a.zip",
        lambda name, content: b"unknown" if name.startswith("files/") else content,
    )
    with pytest.raises(InputError, match="corrupt"):
        store.import_(tmp_path / "a.zip")


def rewrite(path: Path, change: Callable[[str, bytes], bytes]) -> None:
    """Change the files in a ZIP file."""
    with zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, old in content.items():
            archive.writestr(name, change(name, old))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b'"x.csv"', b'""'),
        (b'"size": 1', b'"size": %d' % 2**70),
        (b'"decisions": []', b'"decisions": [5]'),
    ],
)
def test_a_forged_project_leaves_nothing_behind(
    store: ProjectStore, tmp_path: Path, old: bytes, new: bytes
) -> None:
    (tmp_path / "x.csv").write_text("1")
    token = store.create("a", "", copied=[tmp_path / "x.csv"], root=tmp_path).token
    store.export(token, tmp_path / "a.zip")
    store.delete(token)
    with (
        zipfile.ZipFile(tmp_path / "a.zip") as good,
        zipfile.ZipFile(tmp_path / "bad.zip", "w") as bad,
    ):
        for name in good.namelist():
            content = good.read(name)
            bad.writestr(name, content.replace(old, new))
            assert name != "project.json" or old in content
    with pytest.raises(InputError, match="no project that nvcore wrote"):
        store.import_(tmp_path / "bad.zip")
    assert store.projects() == []
    assert {path.name for path in store.copies.rglob("*") if path.is_file()} == {".lock"}


def test_writing_to_a_deleted_project_is_refused(store: ProjectStore) -> None:
    token = store.create("a", "").token
    store.delete(token)
    for write in (
        lambda: store.decide(token, on("c1", "ann")),
        lambda: store.look(token, {"iou": 0.5}),
        lambda: store.add_member(token, "bob"),
    ):
        with pytest.raises(InputError, match="deleted"):
            write()


def test_members_are_known_by_any_case_of_their_address(store: ProjectStore) -> None:
    token = store.create("a", "", owner="Ann@Lab.example").token
    assert store.is_member(token, "ann@lab.example")
    assert [of.token for of in store.projects("ANN@lab.example")] == [token]


def test_different_looks_are_counted_once(store: ProjectStore) -> None:
    token = store.create("a", "").token
    settings = ({"iou": 0.5}, {"iou": 0.3}, {"iou": 0.5})
    assert [store.look(token, of) for of in settings] == [1, 2, 1]


def test_a_backup_is_whole_while_the_file_is_in_use(store: ProjectStore, tmp_path: Path) -> None:
    token = store.create("a", "").token
    with store.connect() as base:
        base.execute("INSERT INTO member VALUES (?, 'ann')", (token,))
        store_of_others = ProjectStore(tmp_path / "data" / "projects.sqlite")
        store_of_others.backup(tmp_path / "backup.sqlite")
    (tmp_path / "again").mkdir()
    copy = ProjectStore(tmp_path / "backup.sqlite")
    assert [of.token for of in copy.projects()] == [token]
    assert not copy.is_member(token, "ann")


KILLER = """
import os, signal, sys
from pathlib import Path
from nvcore.subjects.review.decisions import make_decision
from nvcore.subjects.review.store import ProjectStore
path, token = Path(sys.argv[1]), sys.argv[2]
for round in range(20):
    writers = []
    for name in ("ann", "bob"):
        said, says = os.pipe()
        writer = os.fork()
        if not writer:
            store, number = ProjectStore(path), 0
            while True:
                number += 1
                decision = make_decision(f"{round} {number}", "ask", reviewer=name)
                os.write(says, b"%d\\n" % store.decide(token, decision))
        os.close(says)
        writers.append((writer, os.fdopen(said)))
    first = [said.readline() for _, said in writers]  # both are writing
    for (writer, said), line in zip(writers, first):
        os.kill(writer, signal.SIGKILL)
        os.waitpid(writer, 0)
        print(line + said.read(), end="", flush=True)
"""


def test_a_kill_loses_nothing_that_was_acknowledged(store: ProjectStore) -> None:
    """Two writers at a time are killed at any moment, 40 in all."""
    token = store.create("a", "").token
    done = subprocess.run(
        [sys.executable, "-c", KILLER, str(store._path), token],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stderr
    acknowledged = set(map(int, done.stdout.split()))
    assert len(acknowledged) >= 40
    assert acknowledged <= set(store.decisions(token)["n"])


def test_a_later_or_foreign_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "projects.sqlite"
    ProjectStore(path).execute("PRAGMA user_version = 99")
    with pytest.raises(InputError, match="later version"):
        ProjectStore(path)
    (tmp_path / "other.sqlite").write_text("not a database, by any means" * 100)
    with pytest.raises(StoreError, match="cannot be used"):
        ProjectStore(tmp_path / "other.sqlite")


def test_a_locked_file_is_reported(store: ProjectStore, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nvcore.common.output.sqlite_file.WAIT_S", 0.01)
    token = store.create("a", "").token
    with sqlite3.connect(store._path) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(StoreError, match="locked"):
            store.decide(token, on("c1", "ann"))
    store.decide(token, on("c1", "ann"))


def test_network_drives_are_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    mounts = f"/dev/sda / ext4 rw 0 0\nhost:/x {tmp_path} nfs4 rw 0 0\n"
    monkeypatch.setattr(Path, "read_text", lambda *_args, **_options: mounts)
    with pytest.raises(InputError, match="network drive"):
        refuse_network(tmp_path / "projects.sqlite")
    refuse_network(Path("/elsewhere/projects.sqlite"))
