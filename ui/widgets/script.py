"""Scripts of the dashboard's components, which are modules in separate files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

_IMPORT: Final = re.compile(r'^import \{[^}]*\} from "([^"]+)";\n', re.MULTILINE)
_EXPORT: Final = re.compile(r"^export (?!default )", re.MULTILINE)


def read_script(path: Path) -> str:
    """Bundle a module and its imports into one module, each after its dependencies.

    Streamlit loads a component's script as a blob, which cannot import other files by relative
    address. All modules share one scope: imports must not rename anything or be circular, and no
    two modules may declare the same name.
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
