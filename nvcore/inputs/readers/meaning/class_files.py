"""Names of classes by their numbers, from the files that tools put beside their labels."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Final

from nvcore.errors import FormatError
from nvcore.file_kinds import unpacked_name
from nvcore.inputs.readers.base import SourceFile
from nvcore.inputs.readers.meaning.classes import ClassNames
from nvcore.inputs.readers.parse.text import read_text
from nvcore.wording import shortened

MAX_BYTES: Final = 1 << 20
"""Size of a file of names, unpacked; the longest in use (Objects365's) has 20 KiB."""
_MAX_FILES: Final = 50
"""Most files of names that are read: one folder may hold many YAML files."""
_LISTS: Final = re.compile(
    r"_?(?:obj_|predefined_|class_)?(?:classes|labels|names)\.txt|.*\.names|.*\.labels"
)
_YAML: Final = re.compile(r".*\.ya?ml")
_LAYOUT: Final = frozenset(
    {"labels", "label", "train", "val", "valid", "validation", "test", "obj_train_data", "gt"}
    | {"obj_valid_data", "obj_test_data"}
)
"""Folders above which the names of a whole data set lie."""
_KEY: Final = re.compile(r"""(["']?)names\1\s*:(?:\s+(?P<value>.*))?""")
_BLANK: Final = r"(?>(?:\s|#[^\n]*)*)"
_ENTRY: Final = (
    r"""(?>(?:(?P<mark>["']?)(?P<number>\d{1,9})(?P=mark)\s*:\s+)?"""
    r"""(?P<name>'(?:[^'\n]|'')*'|"(?:[^"\\\n]|\\.)*"|[^\s,\[\]{}'"#&*!|>%@`:?-][^,\[\]{}#:\n]*))"""
)
"""A name, plain or quoted, behind its number in a mapping."""
_IN_BRACKETS: Final = re.compile(rf"{_ENTRY}{_BLANK}(?:,{_BLANK}|(?=[\]}}]))")
_ON_A_LINE: Final = re.compile(rf"(?P<dash>- \s*)?{_ENTRY}(?:\s*|(?<=[ '\"])\s*#.*)")


def is_class_file(name: str) -> bool:
    """Whether a file of this name lists classes, and no boxes."""
    return _LISTS.fullmatch(last_part(name)) is not None


def class_names_beside(files: Sequence[SourceFile]) -> ClassNames:
    """Names of classes from a file among those given, else beside the first other file or above.

    A list (``classes.txt``, ``obj.names``, ``labels.txt``) or the ``names`` of a YAML file. Of
    several places the nearest counts.

    Raises
    ------
    FormatError
        If such a file cannot be read, or two in one place differ.
    """
    for place in _places(files):
        first = ClassNames()
        for file in place[:_MAX_FILES]:
            names = names_in(file)
            if not names:
                continue
            source = PurePosixPath(file.name).name
            if first.names and names != first.names:
                raise file.fault(
                    f"the names of classes differ from those in {first.source} beside it; leave "
                    "the right file alone"
                )
            first = first if first.names else ClassNames(names, source)
        if first.names:
            return first
    return ClassNames()


def _places(files: Sequence[SourceFile]) -> Iterator[list[SourceFile]]:
    """Files that may hold names, those of one place together, the nearest place first."""
    yield [file for file in files if _may_name(file.name)]
    labels = [file for file in files if not _may_name(file.name)] or files
    if not labels:
        return
    folder = Path(labels[0].path).absolute().parent
    folders = [folder, folder.parent]
    if {folder.name.lower(), folder.parent.name.lower()} & _LAYOUT:
        folders.append(folder.parent.parent)
    for place in dict.fromkeys(folders):
        try:
            names = sorted(entry.name for entry in place.iterdir() if _may_name(entry.name))
        except OSError:  # a folder above that may not be looked into
            continue
        yield [SourceFile(place / name, name) for name in names if (place / name).is_file()]


def _may_name(name: str) -> bool:
    return is_class_file(name) or _YAML.fullmatch(last_part(name)) is not None


def last_part(name: str) -> str:
    """The last part of a file's name, as its unpacked file would be called, in lower case."""
    return unpacked_name(name.rpartition("/")[2].casefold())


def names_in(file: SourceFile) -> dict[str, str]:
    """The names in a file by their numbers; none where it has none but the numbers themselves."""
    if file.is_larger_than(MAX_BYTES):
        if is_class_file(file.name):
            raise file.fault(f"a list of classes has {MAX_BYTES >> 20} MiB at most")
        return {}
    text = read_text(file)
    if is_class_file(file.name):
        names = {str(i): line.strip() for i, line in enumerate(text.strip().splitlines())}
        names = {number: name for number, name in names.items() if name}
    else:
        names = names_of_yaml(text, file)
    return {} if all(number == name for number, name in names.items()) else names


def names_of_yaml(text: str, file: SourceFile) -> dict[str, str]:
    """The ``names`` of a data set's YAML file, by their numbers; none where it has no such key.

    Only what tools write is understood: a list, or a mapping from numbers, in brackets or with a
    line for each name.

    Raises
    ------
    FormatError
        With the line of anything else.
    """
    lines = text.splitlines()
    keys = [(i, match) for i, line in enumerate(lines) if (match := _KEY.fullmatch(line))]
    if not keys:
        return {}
    at, match = keys[-1]
    value = re.sub(r"^&\S+\s*", "", (match["value"] or "").strip())  # a mark to refer to

    def fault(line: int) -> FormatError:
        return file.fault(
            "expected names: [person, car], or below it a line for each name (- person, or "
            f"0: person); found {shortened(lines[line].strip(), 60)!r}",
            line + 1,
        )

    if len(keys) > 1:
        raise fault(at)
    entries: list[re.Match[str]] = []
    if value.startswith(("[", "{")):
        closing, inside = {"[": "]", "{": "}"}[value[0]], "\n".join([value[1:], *lines[at + 1 :]])
        inside, place = re.sub(_BLANK, "", inside, count=1), 0
        while not inside.startswith(closing, place):
            entry = _IN_BRACKETS.match(inside, place)
            if entry is None or (entry["number"] is None) != (closing == "]"):
                raise fault(at)
            entries.append(entry)
            place = entry.end()
    elif value and not value.startswith("#"):
        raise fault(at)
    else:
        for i, line in enumerate(lines[at + 1 :], at + 1):
            stripped = line.strip()
            if not stripped or stripped[0] == "#":
                continue
            if line[0] not in " -":  # the next key
                break
            entry = _ON_A_LINE.fullmatch(stripped)
            if entry is None or (entry["number"] is None) != (entry["dash"] is not None):
                raise fault(i)
            entries.append(entry)
    numbers = [
        str(i) if entry["number"] is None else str(int(entry["number"]))
        for i, entry in enumerate(entries)
    ]
    try:
        texts = [_unquoted(entry["name"]) for entry in entries]
    except ValueError:  # an escape that JSON does not have
        raise fault(at) from None
    if len({*numbers}) < len(numbers):
        raise fault(at)
    return dict(zip(numbers, texts, strict=True))


def _unquoted(name: str) -> str:
    if name[0] == '"':
        return str(json.loads(name))
    return name[1:-1].replace("''", "'") if name[0] == "'" else name.strip()
