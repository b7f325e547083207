"""Every page of a comparison of speed signs speaks of speed signs."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from signs import write_signs
from streamlit.testing.v1 import AppTest
from streamlit.testing.v1.element_tree import Block

from nvcore.common.wording.objects import words_for
from pages import begin_with, checked, opened, part, space_of, texts, to_page
from ui.shell.pages import PAGE_OF

OF_ITSELF = ("metrics", "study")
"""Pages that are not about what is compared."""
OF_PEDESTRIANS = ("data", "detectors", "driver")
"""Pages that tell of the sample, of detectors and of estimators, which know pedestrians."""
PAGES = [name for name in PAGE_OF if name not in OF_ITSELF]
UNFILLED = re.compile(
    rf"{{({'|'.join(words_for('sign', 'signs', are_people=False))})}}|\bpedestrians?\b",
    re.IGNORECASE,
)
UNSHOWN = re.compile(r"\b(js|css)_content: .*|\bid: .*")
"""Scripts and styles, and keys of widgets."""


@pytest.fixture(scope="module")
def visit(tmp_path_factory: pytest.TempPathFactory) -> Iterator[AppTest]:
    """One visit, which goes from page to page."""
    with pytest.MonkeyPatch.context() as patch:
        begin_with(write_signs(tmp_path_factory.mktemp("signs")), patch)
        yield opened()


def everything(block: Block) -> str:
    """What the elements of a page were sent, with headings, help and figures."""
    parts = []
    for child in block.children.values():
        parts.append(everything(child) if isinstance(child, Block) else str(child.proto))
        proto = getattr(child, "proto", None)
        parts.append(str(proto) if isinstance(child, Block) and proto is not None else "")
    return "\n".join(parts)


WORDS = {
    "overview": "a speed sign straight ahead and near",
    "encounters": "one speed sign of one recording",
    "saliency": "speed signs are missed",
    "time_left": "A car passes speed signs and does not brake for them",
    "ratings": "not asked of speed signs",
}


@pytest.mark.parametrize("page", [name for name in PAGES if name not in OF_PEDESTRIANS])
def test_a_page_speaks_of_speed_signs_alone_and_leaves_no_word_open(page: str, visit: AppTest):
    assert WORDS.get(page, "") in texts(checked(to_page(visit, page)))
    sent = UNSHOWN.sub("", everything(visit.main) + everything(visit.sidebar))
    unfilled = [sent[max(0, m.start() - 80) : m.end() + 40] for m in UNFILLED.finditer(sent)]
    assert unfilled == []


def test_the_driver_is_asked_about_speed_signs(visit: AppTest):
    page = checked(part("ui.subjects.driver.run.draw_missing()", space=space_of(visit)).run())
    assert "Whether the driver sees the speed signs is not known yet" in texts(page)


def test_the_preset_of_speed_signs_is_offered(visit: AppTest):
    page = checked(
        part("ui.shell.sidebar.draw(wrong, pages.PAGE_OF['data'])", space=space_of(visit)).run()
    )
    (presets,) = [group for group in page.get("button_group") if "Preset" in group.label]
    assert "Speed signs" in presets.options
