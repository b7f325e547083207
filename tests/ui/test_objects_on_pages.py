"""Every page of a comparison of speed signs speaks of speed signs."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from signs import write_signs
from streamlit.testing.v1 import AppTest
from streamlit.testing.v1.element_tree import Block

from pages import begin_with, checked, opened, texts, to_page
from ui.shell.pages import SECTIONS

OF_ITSELF = ("metrics", "study")
"""Pages that are not about what is compared."""
PAGES = [name for section in SECTIONS.values() for name in section if name not in OF_ITSELF]
OF_PEDESTRIANS = re.compile(
    r"\b(pedestrians?|persons?|nobody(?! else)|him|his|whom|feet|ped)\b", re.IGNORECASE
)


@pytest.fixture(scope="module")
def visit(tmp_path_factory: pytest.TempPathFactory) -> Iterator[AppTest]:
    """One visit, which goes from page to page."""
    with pytest.MonkeyPatch.context() as patch:
        folder = tmp_path_factory.mktemp("signs")
        patch.setenv("NVCORE_UPLOAD_DIR", str(folder / "uploads"))
        begin_with(write_signs(folder), patch)
        yield opened()


def everything(block: Block) -> str:
    """What the elements of a page were sent, with headings, help and figures."""
    parts = []
    for child in block.children.values():
        parts.append(everything(child) if isinstance(child, Block) else str(child.proto))
        proto = getattr(child, "proto", None)
        parts.append(str(proto) if isinstance(child, Block) and proto is not None else "")
    return "\n".join(parts)


@pytest.mark.parametrize("page", PAGES)
def test_a_page_says_nothing_of_pedestrians(page: str, visit: AppTest):
    checked(to_page(visit, page))
    sent = everything(visit.main) + everything(visit.sidebar)
    # keys, the viewer's comments, and what it is to say in place of which words
    sent = re.sub(r'(js|css)_content: .*|\bid: .*|\\"phrases\\": {[^}]*}', "", sent)
    if page == "data":  # of the sample, and of what else could be opened
        sent = re.sub(
            r"Ten short night drives[^\n]*|Pedestrians?\"|pedestrians? at the kerb", "", sent
        )
    if page == "detectors":  # of those that are built in
        sent = re.sub(
            r"trained on (INRIA|Daimler)[^\n]*|Detects pedestrian\.|3/4 of[^\n]*", "", sent
        )
        sent = re.sub(r"of the person|Person box", "", sent)
    if page == "driver":  # of the trials that the estimator was trained on
        sent = re.sub(r"Trained on [^\n]*", "", sent)
    said = [sent[max(0, m.start() - 80) : m.end() + 40] for m in OF_PEDESTRIANS.finditer(sent)]
    assert said == []


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ("overview", "a speed sign straight ahead and near"),
        ("encounters", "one speed sign of one recording"),
        ("saliency", "speed signs are missed"),
        ("time_left", "A car passes speed signs and does not brake for them"),
        ("ratings", "not asked of speed signs"),
    ],
)
def test_a_page_says_it_of_speed_signs(page: str, words: str, visit: AppTest):
    assert words in texts(checked(to_page(visit, page)))


def test_the_preset_of_speed_signs_is_offered(visit: AppTest):
    checked(to_page(visit, "overview"))
    (presets,) = [group for group in visit.get("button_group") if "Preset" in group.label]
    assert "Speed signs" in presets.options
