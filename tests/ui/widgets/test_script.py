"""Scripts of components: several modules as one."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest
from places import ROOT

from ui.widgets.script import read_script

OF_COMPONENTS = [
    path
    for path in sorted((ROOT / "ui").rglob("*.js"))
    if "export default" in path.read_text(encoding="utf-8")
]
DECLARED = re.compile(r"^(?:async )?(?:class|const|function|let) (\w+)", re.MULTILINE)


def write(folder: Path, **modules: str) -> Path:
    for name, text in modules.items():
        (folder / f"{name}.js").write_text(text, encoding="utf-8")
    return folder / "show.js"


def test_a_module_follows_those_that_it_imports_and_each_is_there_once(tmp_path):
    show = write(
        tmp_path,
        show='import { twice } from "./twice.js";\nimport {\n  one,\n} from "./one.js";\n\n'
        "export default () => twice(one);\n",
        twice='import { one } from "./one.js";\n\nexport const twice = (n) => 2 * n * one;\n',
        one="export const one = 1;\n",
    )
    assert read_script(show).split("\n") == [
        *("const one = 1;", "", "", "const twice = (n) => 2 * n * one;", "", ""),
        *("export default () => twice(one);", ""),
    ]


@pytest.mark.parametrize("path", OF_COMPONENTS, ids=lambda path: path.stem)
def test_the_modules_of_a_component_can_share_a_scope(path):
    script = read_script(path)
    assert [name for name, n in Counter(DECLARED.findall(script)).items() if n > 1] == []
    assert len(re.findall(r"^export ", script, re.MULTILINE)) == 1
    assert re.findall(r"^import .*", script, re.MULTILINE) == []


@pytest.mark.parametrize("path", sorted((ROOT / "ui").rglob("*.js")), ids=lambda path: path.stem)
def test_an_import_renames_nothing(path):
    text = path.read_text(encoding="utf-8")
    assert re.findall(r"^import \{[^}]*? as [^}]*\}", text, re.MULTILINE) == []
