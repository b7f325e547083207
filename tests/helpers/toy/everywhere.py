"""Print where the toy appears once it has an entry among the subjects, as JSON.

python -m toy.everywhere SESSION FOLDER
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import nvcore.subjects as registry
from toy import Toy

registry.SUBJECTS += (Toy(),)  # the entry; what follows is as ever

from toy.ui import ToyPages  # noqa: E402
from ui.subjects import registry as of_pages  # noqa: E402

of_pages.SUBJECTS += (ToyPages(),)

import pandas as pd  # noqa: E402
from inputs import nvcore  # noqa: E402
from pytest import MonkeyPatch  # noqa: E402, PT013

import nvcore as nv  # noqa: E402
from pages import begin_with, checked, opened  # noqa: E402


def main(session: str, folder: str) -> None:
    compared = nvcore("compare", session, "--toy-frames", "15", "--full", "--out", folder)
    out = Path(folder)
    comparison = nv.compare(session)
    with MonkeyPatch.context() as patch:
        begin_with(Path(session), patch)
        overview = opened()
        page = overview.switch_page(str(Path(__file__).with_name("toy_page.py"))).run()
        checked(page)
        told = [[text.value for text in page.markdown]]
        checked(page.slider(key="toy_frames").set_value(30).run())
        told.append([text.value for text in page.markdown])
    json.dump(
        {
            "terminal": compared.stdout,
            "summary": json.loads((out / "summary.json").read_text()),
            "long": pd.read_csv(out / "encounters.csv")["toy_long"].tolist(),
            "session": (out / "session.toml").read_text(),
            "gate": nvcore("gate", session, "--rule", "toy_detected_x >= 1").exit_code,
            "help": nvcore("compare", "--help").stdout,
            "figure": comparison.figures.toy().layout.title.text,
            "titles": [title.value for title in page.title],
            "pages": told,
        },
        sys.stdout,
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
