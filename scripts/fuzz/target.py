"""Fuzzer targets and their shared helpers: files, lines of TOML, changes to text."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Final, TypeVar

from nvcore.common.errors import InputError

Read = TypeVar("Read")
Run = Callable[[bytes, Path], None]
Mutator = Callable[[bytes, Random], bytes]
PARTS: Final = b"\n%%\n"
"""Separator between the files of one input."""
ROOT: Final = Path(__file__).resolve().parents[2]
DATA: Final = ROOT / "tests" / "data"
SAMPLE: Final = ROOT / "sample_data"
_TOKEN: Final = re.compile(rb"\w+(?:\.\w+)?|\s|[^\w\s]+?")
_ODD: Final = (
    *(b"", b"0", b"-1", b"0.5", b"1e308", b"nan", b"inf", b"9" * 400, b"1_0", b"1e5", b"1e-300"),
    *(b'"', b"'", b"''", b"\n", b",", b";", b"\t", b"[", b"[[", b"]", b"=", b".", b"{", b"(" * 300),
    *(b"\0", b"\xff", b"=1+1", b"\xe2\x80\xa8", b"\xd9\xa1", b"\xef\xbb\xbf", b"\xc3\xa4"),
)
"""Replacements and insertions for words."""


@dataclass(frozen=True)
class Target:
    """Entry point for external files: (content, empty folder) -> None, or an error.

    `seeds` are initial inputs, or functions that make some. `share` is the share of a run's time,
    and `mutate` changes inputs in meaningful ways, in addition to libFuzzer's own mutations.
    """

    run: Run
    seeds: tuple[bytes | Callable[[], Iterable[bytes]], ...]
    share: float
    most_bytes: int
    mutate: Mutator | None

    def first_inputs(self) -> list[bytes]:
        """Return all seeds."""
        return [one for of in self.seeds for one in ([of] if isinstance(of, bytes) else of())]


TARGETS: Final[dict[str, Target]] = {}
"""Targets by name, as on the command line."""


def target(
    *seeds: bytes | Callable[[], Iterable[bytes]],
    share: float = 0.5,
    most_bytes: int = 8192,
    mutate: Mutator | None = None,
) -> Callable[[Run], Run]:
    """Register a function as a target under its name."""

    def listed(run: Run) -> Run:
        TARGETS[run.__name__] = Target(run, seeds, share, most_bytes, mutate)
        return run

    return listed


def written(folder: Path, name: str, content: bytes) -> Path:
    """Write a file and return its path."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


def read_toml(read: Callable[[Path], Read], path: Path) -> Read:
    """Read a TOML file, dropping invalid lines, since few inputs are valid."""
    try:
        return read(path)
    except InputError as error:
        if not isinstance(error.__cause__, tomllib.TOMLDecodeError):
            raise
        path.write_bytes(without_bad_lines(path.read_bytes()))
        return read(path)


def without_bad_lines(content: bytes) -> bytes:
    """Drop the lines that are not TOML."""
    lines = content.decode("utf-8", "ignore").splitlines()
    while lines:
        try:
            tomllib.loads("\n".join(lines))
        except tomllib.TOMLDecodeError as error:
            place = re.search(r"at line (\d+)", str(error))
            del lines[min(int(place[1]), len(lines)) - 1 if place else -1]
        except (ValueError, RecursionError):
            lines.pop()
        else:
            break
    return "\n".join(lines).encode()


def mutated_text(content: bytes, rng: Random) -> bytes:
    """Replace, insert, drop or move a few words and signs, or repeat, drop or move a line."""
    tokens = _TOKEN.findall(content) or [b""]
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(tokens))
        new = rng.choice((rng.choice(_ODD), rng.choice(tokens), b"%d" % rng.randrange(200)))
        tokens[at : at + rng.randrange(3)] = [new]
    lines = b"".join(tokens).split(b"\n")
    if rng.random() < 0.3:
        line = lines.pop(rng.randrange(len(lines)))
        for _ in range(rng.randrange(4)):
            lines.insert(rng.randint(0, len(lines)), line)
    return b"\n".join(lines)
