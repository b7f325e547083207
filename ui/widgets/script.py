"""The scripts of the dashboard's components, which are modules in files of their own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

_IMPORT: Final = re.compile(r'^import \{[^}]*\} from "([^"]+)";\n', re.MULTILINE)
_EXPORT: Final = re.compile(r"^export (?!default )", re.MULTILINE)


def read_script(path: Path) -> str:
    """A module and those that it imports as one module, each after those that it needs.

    Streamlit loads a component's script as a blob, to which no address of another file is relative.
    The modules come to share one scope: imports rename nothing, do not go in circles, and no two
    modules declare the same name.
    """
    texts: dict[Path, str] = {}

    def add(path: Path) -> None:
        if path in texts:
            return
        text = path.read_text(encoding="utf-8")
        for address in _IMPORT.findall(text):
            add((path.parent / address).resolve())
        texts[path] = _EXPORT.sub("", _IMPORT.sub("", text))

    add(path.resolve())
    return "\n".join(texts.values())
