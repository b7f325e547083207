from __future__ import annotations

from pathlib import Path

from toy.settings import LONG
from ui.subject import Page, SubjectPages


class ToyPages(SubjectPages):
    pages = (
        Page(
            "toy",
            "Toys",
            "Compare",
            after="encounters",
            own=(LONG,),
            script=str(Path(__file__).with_name("toy_page.py")),
        ),
    )
