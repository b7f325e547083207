"""Projects: comparisons that stay, with their inputs, decisions and looks, in one SQLite file.

Inputs that were uploaded are copied into the folder beside the file: their content by hash, and for
each project a tree of hard links with their names. Inputs opened by path stay where they are, and
the project knows their size, time and hash. Decisions are only appended.
"""

from __future__ import annotations

import hashlib
import json
import re
import secrets
import shutil
import sqlite3
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, ClassVar, Final, NamedTuple

import pandas as pd
from filelock import FileLock

from nvcore.common.errors import InputError, NvcoreError
from nvcore.common.output.sqlite_file import SqliteFile
from nvcore.evidence.looks import look_key
from nvcore.subjects.review.decisions import COLUMNS, check_decisions

MIGRATIONS: Final = (
    """CREATE TABLE project (token TEXT PRIMARY KEY, name TEXT NOT NULL, session TEXT NOT NULL,
        root TEXT NOT NULL, created_at TEXT NOT NULL);
    CREATE TABLE member (project TEXT NOT NULL REFERENCES project ON DELETE CASCADE,
        who TEXT NOT NULL, PRIMARY KEY (project, who));
    CREATE TABLE input (project TEXT NOT NULL REFERENCES project ON DELETE CASCADE,
        path TEXT NOT NULL, sha256 TEXT NOT NULL, size INTEGER NOT NULL, time_ns INTEGER NOT NULL,
        is_copy INTEGER NOT NULL, PRIMARY KEY (project, path));
    CREATE TABLE decision (n INTEGER PRIMARY KEY AUTOINCREMENT,
        project TEXT NOT NULL REFERENCES project ON DELETE CASCADE, "case" TEXT NOT NULL,
        reviewer TEXT NOT NULL, decision TEXT NOT NULL, note TEXT NOT NULL,
        is_done INTEGER NOT NULL, at TEXT NOT NULL);
    CREATE INDEX decision_of_project ON decision (project, n);
    CREATE TABLE look (n INTEGER PRIMARY KEY AUTOINCREMENT,
        project TEXT NOT NULL REFERENCES project ON DELETE CASCADE, key TEXT NOT NULL,
        setting TEXT NOT NULL, at TEXT NOT NULL, UNIQUE (project, key));""",
)
"""SQL that takes the file from one version of its schema to the next one."""

NETWORK: Final = ("nfs", "nfs4", "cifs", "smb3", "smbfs", "fuse.sshfs", "9p", "afs")
"""File systems on which SQLite's locks cannot be relied on."""
QUOTA_BYTES: Final = 20 * 1024**3
"""Largest total size of all copies."""
MOST_NAME: Final = 200
MOST_ABOUT_BYTES: Final = 64 * 1024**2
"""Largest size of a project's description in its file, which is read into memory."""
BLOBS: Final = "content"
TREES: Final = "projects"
PARTIAL: Final = "partial"
LOCK: Final = ".lock"


_NO_PROJECT: Final = (
    *(OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError, InputError),
    *(NotImplementedError, RuntimeError, OverflowError, zipfile.BadZipFile, zlib.error),
)
"""Exceptions that a file which is no project can raise."""


class Project(NamedTuple):
    """A comparison that stays.

    Attributes
    ----------
    token
        Its name in addresses, which cannot be guessed.
    session
        Text of its session file, with absolute paths.
    root
        Folder in which copied inputs were. Empty: none were copied.
    created_at
        Time, UTC.
    """

    token: str
    name: str
    session: str
    root: str
    created_at: datetime


class KeptInput(NamedTuple):
    """An input of a project.

    Attributes
    ----------
    path
        Path of the original; of a copied one below the project's `root`.
    is_copy
        True if the file is in `ProjectStore.tree`.
    """

    path: str
    sha256: str
    size: int
    time_ns: int
    is_copy: bool


class ConflictError(NvcoreError):
    """Somebody else decided on a case after the reviewer saw it: `theirs` is their decision."""

    def __init__(self, theirs: Mapping[str, Any]):
        super().__init__(f"{theirs['reviewer'] or 'somebody'} decided on this case meanwhile")
        self.theirs = theirs


class ProjectStore(SqliteFile):
    """Projects in one SQLite file in WAL mode, and the copies of their inputs beside it.

    Raises
    ------
    InputError
        If the folder is on a network drive, or the file is of a later version.
    """

    content: ClassVar[str] = "projects"

    def __init__(self, path: Path):
        refuse_network(path)
        super().__init__(path)
        self.copies = path.with_suffix(".files")
        for folder in (self.copies, *(self.copies / name for name in (BLOBS, TREES, PARTIAL))):
            folder.mkdir(mode=0o700, exist_ok=True)
        with self.connect() as base:
            base.execute("PRAGMA journal_mode = WAL")
            (version,) = base.execute("PRAGMA user_version").fetchone()
        if version > len(MIGRATIONS):
            raise InputError("the file of the projects was written by a later version of nvcore")
        for number in range(version, len(MIGRATIONS)):
            with self.connect() as base:
                base.execute("BEGIN IMMEDIATE")
                (done,) = base.execute("PRAGMA user_version").fetchone()
                if done > number:  # by another process meanwhile
                    continue
                for statement in MIGRATIONS[number].split(";"):
                    base.execute(statement)
                base.execute(f"PRAGMA user_version = {number + 1}")

    def create(
        self,
        name: str,
        session: str,
        *,
        owner: str = "",
        inputs: Iterable[Path] = (),
        copied: Iterable[Path] = (),
        root: Path | None = None,
    ) -> Project:
        """Keep a comparison.

        Parameters
        ----------
        session
            Text of the session file.
        owner
            First member: a log-in, or a name.
        inputs
            Files that stay where they are.
        copied, root
            Files that are copied, such as uploads, and the folder in which they are.

        Raises
        ------
        InputError
            If the name is empty or too long, or the copies exceed the quota.
        """
        if not 0 < len(name.strip()) <= MOST_NAME:
            raise InputError(f"a project's name has 1 to {MOST_NAME} characters")
        copied, token = list(copied), secrets.token_urlsafe(16)
        self._check_quota(sum(path.stat().st_size for path in copied))
        kept = [_known(path) for path in inputs]
        try:
            for path in copied:
                assert root is not None
                known = _known(path)
                inside = path.relative_to(root).as_posix()
                self._link(known.sha256, path, self.tree(token) / inside)
                kept.append(known._replace(path=inside, is_copy=True))
            return self._add(token, name.strip(), session, str(root or ""), owner, kept)
        except BaseException as error:
            self.delete(token)
            if isinstance(error, OSError | ValueError):
                raise InputError(f"the inputs cannot be copied ({error})") from error
            raise

    def _add(
        self,
        token: str,
        name: str,
        session: str,
        root: str,
        owner: str,
        inputs: Iterable[KeptInput],
    ) -> Project:
        project = Project(token, name, session, root, datetime.now(UTC))
        with self.connect() as base:
            values = (*project[:4], project.created_at.isoformat())
            base.execute("INSERT INTO project VALUES (?, ?, ?, ?, ?)", values)
            base.execute("INSERT INTO member VALUES (?, ?)", (token, owner.lower()))
            base.executemany(
                "INSERT OR IGNORE INTO input VALUES (?, ?, ?, ?, ?, ?)",
                [(token, *one) for one in inputs],
            )
        return project

    def tree(self, token: str) -> Path:
        """Return the folder with the copied inputs of a project."""
        return self.copies / TREES / token

    def project(self, token: str) -> Project | None:
        """Return the project of a token, if there is one."""
        rows = self.execute("SELECT * FROM project WHERE token = ?", token)
        return _project(rows[0]) if rows else None

    def projects(self, who: str | None = None) -> list[Project]:
        """Return the projects of a member, or all of them, the newest first."""
        rows = self.execute(
            "SELECT * FROM project WHERE ?1 IS NULL OR token IN "
            "(SELECT project FROM member WHERE who = ?1) ORDER BY created_at DESC",
            who and who.lower(),
        )
        return list(map(_project, rows))

    def is_member(self, token: str, who: str) -> bool:
        """Return whether somebody may open a project."""
        query = "SELECT 1 FROM member WHERE project = ? AND who = ?"
        return bool(self.execute(query, token, who.lower()))

    def add_member(self, token: str, who: str) -> None:
        """Let somebody open a project."""
        with self._of_project() as base:
            base.execute("INSERT OR IGNORE INTO member VALUES (?, ?)", (token, who.lower()))

    @contextmanager
    def _of_project(self) -> Iterator[sqlite3.Connection]:
        """Open the file to write about a project, which somebody may have deleted meanwhile."""
        try:
            with self.connect() as base:
                yield base
        except sqlite3.IntegrityError as error:
            raise InputError("the project was deleted") from error

    def delete(self, token: str) -> None:
        """Delete a project, and all copies that no other project uses."""
        self.execute("DELETE FROM project WHERE token = ?", token)
        with FileLock(self.copies / LOCK):  # nobody links a copy in between
            shutil.rmtree(self.tree(token), ignore_errors=True)
            for path in (self.copies / BLOBS).iterdir():
                if path.stat().st_nlink == 1:
                    path.unlink()

    def inputs(self, token: str) -> list[KeptInput]:
        """Return the inputs of a project."""
        rows = self.execute("SELECT * FROM input WHERE project = ? ORDER BY path", token)
        return [
            KeptInput(row["path"], row["sha256"], row["size"], row["time_ns"], bool(row["is_copy"]))
            for row in rows
        ]

    def changed_inputs(self, token: str) -> list[str]:
        """Return the paths of inputs that are gone, or whose content is another one now."""
        changed = []
        for kept in self.inputs(token):
            path = self.tree(token) / kept.path if kept.is_copy else Path(kept.path)
            try:
                status = path.stat()
            except OSError:
                changed.append(kept.path)
                continue
            is_same = (status.st_size, status.st_mtime_ns) == (kept.size, kept.time_ns)
            if not kept.is_copy and not is_same and _hash(path) != kept.sha256:
                changed.append(kept.path)
        return changed

    def decide(self, token: str, decisions: pd.DataFrame, *, seen: int | None = None) -> int:
        """Append decisions, and return the number of the last one.

        Parameters
        ----------
        decisions
            Rows of `nvcore.subjects.review.decisions.make_decision`.
        seen
            Number of the last decision that the reviewer has seen; None: all.

        Raises
        ------
        ConflictError
            If somebody else decided on one of the cases after `seen`.
        """
        rows = list(decisions[list(COLUMNS)].itertuples(index=False, name=None))
        with self._of_project() as base:
            base.execute("BEGIN IMMEDIATE")  # nobody decides in between
            for case, reviewer, *_ in rows if seen is not None else ():
                theirs = base.execute(
                    'SELECT * FROM decision WHERE project = ? AND "case" = ? AND n > ? '
                    "AND reviewer != ? ORDER BY n DESC LIMIT 1",
                    (token, case, seen, reviewer),
                ).fetchone()
                if theirs is not None:
                    raise ConflictError(dict(theirs))
            last = 0
            for row in rows:
                made = base.execute(
                    "INSERT INTO decision VALUES (NULL, ?, ?, ?, ?, ?, ?, ?)", (token, *row)
                )
                last = int(made.lastrowid or 0)
        return last

    def decisions(self, token: str, *, since: int = 0) -> pd.DataFrame:
        """Return all decisions on a project after number `since`, in their order.

        Returns
        -------
        n, and `nvcore.subjects.review.decisions.COLUMNS`.
        """
        columns = ", ".join(f'"{name}"' for name in ("n", *COLUMNS))
        rows = self.execute(
            f"SELECT {columns} FROM decision WHERE project = ? AND n > ? ORDER BY n",  # noqa: S608  # our own names
            token,
            since,
        )
        table = pd.DataFrame([tuple(row) for row in rows], columns=["n", *COLUMNS])
        return table.assign(is_done=table["is_done"].astype(bool))

    def look(self, token: str, setting: Mapping[str, Any]) -> int:
        """Record that a verdict was shown, and return the number of this look.

        Parameters
        ----------
        setting
            What the verdict rests on (`nvcore.evidence.looks.setting_of`).
        """
        text, key = json.dumps(setting, sort_keys=True, default=str), look_key(setting)
        with self._of_project() as base:
            base.execute(
                "INSERT OR IGNORE INTO look VALUES (NULL, ?, ?, ?, ?)",
                (token, key, text, datetime.now(UTC).isoformat()),
            )
            query = (
                "SELECT COUNT(*) FROM look WHERE project = ?1 AND n <= "
                "(SELECT n FROM look WHERE project = ?1 AND key = ?2)"
            )
            (number,) = base.execute(query, (token, key)).fetchone()
        return int(number)

    def used_bytes(self) -> int:
        """Return the total size of all copies."""
        query = "SELECT sha256, MAX(size) FROM input WHERE is_copy GROUP BY sha256"
        return sum(size for _, size in self.execute(query))

    def backup(self, path: Path) -> None:
        """Write a copy of the file while it is in use. The copies of inputs are not in it."""
        self.execute("VACUUM INTO ?", str(path))

    def export(self, token: str, path: Path) -> None:
        """Write a project with its decisions and copied inputs as one ZIP file.

        Raises
        ------
        InputError
            If there is no such project, or the file cannot be written. An older file then stays.
        """
        project = self.project(token)
        if project is None:
            raise InputError("there is no such project")
        inputs = self.inputs(token)
        about = {
            "name": project.name,
            "session": project.session,
            "root": project.root,
            "inputs": [one._asdict() for one in inputs],
            "decisions": self.decisions(token)[list(COLUMNS)].to_dict("records"),
        }
        partial = self.copies / PARTIAL / secrets.token_hex(16)
        try:
            with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
                archive.writestr("project.json", json.dumps(about, indent=1, ensure_ascii=False))
                for sha256 in sorted({one.sha256 for one in inputs if one.is_copy}):
                    archive.write(self.copies / BLOBS / sha256, f"files/{sha256}")
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(partial, path)
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror})") from error
        finally:
            partial.unlink(missing_ok=True)

    def import_(self, path: Path, *, owner: str = "", name: str | None = None) -> Project:
        """Add the project of a file that `export` wrote, under a new token.

        Parameters
        ----------
        name
            Another name for it. None: that in the file.

        Raises
        ------
        InputError
            If the file is something else, or a copied input is corrupt.
        """
        token = secrets.token_urlsafe(16)
        try:
            with zipfile.ZipFile(path) as archive:
                if archive.getinfo("project.json").file_size > MOST_ABOUT_BYTES:
                    raise ValueError("its description is too large")
                about = json.loads(archive.read("project.json"))
                inputs = [_stated(**one) for one in about["inputs"]]
                table = pd.DataFrame(about["decisions"], columns=list(COLUMNS))
                decisions = check_decisions(table, "project.json")
                copied = [one for one in inputs if one.is_copy]
                self._check_quota(
                    sum(archive.getinfo(f"files/{one.sha256}").file_size for one in copied)
                )
                for one in copied:
                    target = (self.tree(token) / one.path).resolve()
                    if self.tree(token).resolve() not in target.parents:
                        raise ValueError(f"{one.path} leaves the project")
                    self._link(one.sha256, archive, target)
            own_name, session, root = (str(about[key]) for key in ("name", "session", "root"))
            project = self._add(token, name or own_name, session, root, owner, inputs)
            self.decide(token, decisions)
            return project
        except BaseException as error:
            self.delete(token)
            if isinstance(error, _NO_PROJECT):
                told = f"{path.name} is no project that nvcore wrote ({error})"
                raise InputError(told) from error
            raise

    def _link(self, sha256: str, source: Path | zipfile.ZipFile, target: Path) -> None:
        """Put a file into the tree of a project, and its content beside the others if it is new.

        The content is hashed even if it is there, so that a known hash gives no access to it.
        """
        blob = self.copies / BLOBS / sha256
        partial = self.copies / PARTIAL / secrets.token_hex(16)
        if isinstance(source, Path):
            shutil.copyfile(source, partial)
        else:
            with source.open(f"files/{sha256}") as packed, partial.open("wb") as copy:
                shutil.copyfileobj(packed, copy)
        if _hash(partial) != sha256:
            partial.unlink()
            raise ValueError("an input is corrupt")
        with FileLock(self.copies / LOCK):
            if blob.exists():
                partial.unlink()
            else:
                partial.replace(blob)
            target.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            target.hardlink_to(blob)

    def _check_quota(self, size: int) -> None:
        used = self.used_bytes()
        if used + size > QUOTA_BYTES:
            raise InputError(
                f"projects hold {used / 1024**3:.1f} of {QUOTA_BYTES / 1024**3:.0f} GB: delete one"
            )


def refuse_network(path: Path) -> None:
    """Raise InputError if a path is on a network drive, where SQLite's locks may fail."""
    try:
        mounts = Path("/proc/mounts").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return
    resolved = path.parent.resolve()
    kinds = {Path(parts[1]): parts[2] for line in mounts if len(parts := line.split()) > 2}
    within = [mount for mount in kinds if resolved.is_relative_to(mount)]
    kind = kinds[max(within, key=lambda mount: len(mount.parts))] if within else ""
    if kind in NETWORK:
        raise InputError(
            f"projects cannot be kept on a network drive ({kind}), where two writers may destroy "
            "the file: choose a local folder"
        )


def _project(row: sqlite3.Row | Sequence[Any]) -> Project:
    token, name, session, root, created_at = row
    return Project(token, name, session, root, datetime.fromisoformat(created_at))


def _known(path: Path) -> KeptInput:
    status = path.stat()
    return KeptInput(str(path), _hash(path), status.st_size, status.st_mtime_ns, is_copy=False)


def _stated(path: str, sha256: str, size: int, time_ns: int, *, is_copy: bool) -> KeptInput:
    """Return an input as a file states it."""
    if not re.fullmatch(r"[0-9a-f]{64}", sha256):
        raise ValueError(f"{sha256!r} is no hash")
    return KeptInput(str(path), sha256, int(size), int(time_ns), bool(is_copy))


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
