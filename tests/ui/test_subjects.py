"""What a subject adds to the dashboard, in a room of its own."""

from __future__ import annotations

import runpy
from collections.abc import Iterator
from pathlib import Path

import pytest
from asgi import ask
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from nvcore.settings.stages import SALIENCY
from nvcore.subjects.ratings.clip_task import RatingStore
from ui.serving.life import check_start
from ui.session.routes import Place
from ui.shell import pages
from ui.subject import Document, Page, SubjectPages, subject_pages
from ui.subjects.people.studies import Studies
from ui.views.documentation import page as documentation


async def answer(request: Request) -> Response:
    return PlainTextResponse(f"toy {request.path_params['row']}")


class ToyStudies(Studies):
    variable = "NVCORE_TOYS"
    file_name = "toys.sqlite"

    def store(self):
        return RatingStore(self.file())


class ToyPages(SubjectPages):
    pages = (Page("toy", "Toy", "Compare", after="overview", shown=(), own=(SALIENCY,)),)
    documents = (Document("toy", "The toy", after="metrics"),)

    def routes(self) -> tuple[Place]:
        return (Place("toy/{row}", answer),)

    def studies(self) -> tuple[ToyStudies]:
        return (ToyStudies(),)


@pytest.fixture
def toy(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """One more subject, with pages, a route and studies."""
    monkeypatch.setattr("ui.subjects.registry.SUBJECTS", (*subject_pages(), ToyPages()))
    subject_pages.cache_clear()
    yield
    monkeypatch.undo()
    subject_pages.cache_clear()


def test_its_page_stands_where_it_says(toy: None):
    page = runpy.run_path(pages.__file__)
    compared = [(of.key, of.title) for of in page["PAGE_OF"].values() if of.section == "Compare"]
    assert compared[1:3] == [("overview", "Overview"), ("toy", "Toy")]
    assert page["PAGE_OF"]["toy"].own == (SALIENCY,)


def test_its_document_is_one_of_the_documentation(toy: None):
    names = [*runpy.run_path(documentation.__file__)["PAGES"]]
    assert names.index("toy") == names.index("metrics") + 1


def test_its_routes_are_those_of_a_session(toy: None):
    assert ask("/nv/token/toy/3").text == "toy 3"


def test_its_file_of_answers_is_looked_at_before_anybody_comes(
    toy: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, surroundings: None
):
    monkeypatch.setenv("NVCORE_TOYS", str(tmp_path / "toys.sqlite"))
    check_start()
    assert (tmp_path / "toys.sqlite").is_file()
