"""Where the code leads to another page."""

from __future__ import annotations

import ast
from collections import Counter

from app_server import ROOT

OURS = {*("open_page", "open_frame", "open_row", "open_encounter", "ask_for_page")}
STREAMLITS = {"switch_page", "page_link"}
WAYS = ("ui/shell/navigate.py", "ui/subjects/time_left/listed.py")
"""They are made of one another here."""


def jump_sites() -> Counter[str]:
    """How often a function of the dashboard leads to another page, by "file:function"."""
    counts: Counter[str] = Counter()
    for path in sorted([*ROOT.glob("ui/**/*.py"), *ROOT.glob("pages/*.py")]):
        name = path.relative_to(ROOT).as_posix()
        for part in ast.parse(path.read_text(encoding="utf-8")).body:
            where = part.name if isinstance(part, ast.FunctionDef | ast.ClassDef) else ""
            counts[f"{name}:{where}"] += sum(map(leads, ast.walk(part)))
    return +counts


def leads(node: ast.AST) -> bool:
    if isinstance(node, ast.Name):
        return node.id in OURS
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return node.attr in OURS or (node.value.id == "st" and node.attr in STREAMLITS)
    return False
