"""Files as other tools write them, at the upload field: right values, or what is wrong."""

from __future__ import annotations

import pytest
from data_page import ASKED, opened, press, send, space_of
from field_cases import CASES, Case
from field_scene import found

from nvcore.comparison.compare import compare
from pages import checked, texts


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_files_give_the_right_values_or_say_what_is_wrong(case: Case):
    page = opened()
    for key, side in (("truth", "truth"), ("system_0", "x"), ("system_1", "y")):
        send(page, f"upload_{key}", case.sent(side))
    checked(page.run())
    for field in page.number_input:
        name, *place = (field.key or "").split("_")
        if place[:1] == ["upload"]:
            field.set_value((ASKED | {"fps": 10.0})[name])
    press(page, "open_upload")
    shown = texts(page).replace("\\", "")
    is_open = "Open now: Uploaded files" in shown
    assert is_open == (case.exit_code < 2), shown
    for words in case.says:
        assert words in shown
    if case.right is not None:
        assert found(compare(space_of(page).opened.dataset)) == case.right
