"""Makes the pictures of the documentation.

    PYTHONPATH=tests/e2e/helpers .venv/bin/python tests/e2e/screenshots.py [NAME ...]

Every page of the sample at 1280 x 800, Overview and Timeline in the dark theme as well, into
``docs/images/``, with 256 colours so that the files stay small.
"""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path

from app_server import ROOT, open_chromium, serve
from app_visit import Visit
from PIL import Image
from playwright.sync_api import expect

FOLDER = ROOT / "docs" / "images"
MAX_BYTES = 150_000
# X has found the child again, Y has not
MOMENT = "recording=rural_child&frame=225"
PAGES = {
    "data": "data",
    "overview": "",
    "timeline": f"timeline?{MOMENT}",
    "encounters": "encounters",
    "time-left": "time_left",
    "review": "review",
    "saliency": "saliency?recording=rural_child",
    "detection": "detection",
    "detectors": "detectors?recording=urban_crossing&frame=120",
    "stability": "stability",
    "systems": "systems",
    "driver": "driver",
    "ratings": "ratings",
    "study": "study",
    "export": f"export?{MOMENT}",
    "metrics": "metrics",
}
DARK = ("overview", "timeline")
# below the top of the page: what is then the first to be seen
FIRST_SEEN = {"detectors": "Try it on a frame", "driver": "Pedestrian 3 of urban_sidewalk"}
IS_WHOLE = """() => document.fonts.status === "loaded"
  && [...document.images].every(image => image.complete && image.naturalWidth)"""
TWO_PAINTS = """() => new Promise(
  done => requestAnimationFrame(() => requestAnimationFrame(done)))"""


def main() -> None:
    """Write all pictures, or those that are named."""
    chosen = sys.argv[1:]
    FOLDER.mkdir(parents=True, exist_ok=True)
    with serve(ROOT / "app.py") as address, open_chromium() as chromium:
        for theme, names in (("light", tuple(PAGES)), ("dark", DARK)):
            for name in names if not chosen else [name for name in names if name in chosen]:
                suffix = "" if theme == "light" else f"-{theme}"
                one = Visit(chromium, address, theme=theme)
                one.go(PAGES[name])
                if name in BEFORE:
                    BEFORE[name](one)
                one.page.wait_for_function(IS_WHOLE)
                if one.viewer.count():
                    expect(one.viewer).to_have_attribute("data-shown-row", re.compile("[0-9]"))
                if name in FIRST_SEEN:
                    heading = one.heading(FIRST_SEEN[name])
                    heading.evaluate("element => element.scrollIntoView()")
                one.page.evaluate(TWO_PAINTS)
                save(one.page.screenshot(), FOLDER / f"{name}{suffix}.png")
                one.close()


def estimate(one: Visit) -> None:
    """Let the sample's estimator say whom the driver sees."""
    one.page.get_by_role("button", name="Estimate", exact=True).click()
    expect(one.page.get_by_text(re.compile("^By the estimates"))).to_be_visible()
    one.wait_until_drawn()


# what is done on a page before
BEFORE = {"driver": estimate}


def save(png: bytes, path: Path) -> None:
    """Write a picture with 256 colours, or fewer where that is too large."""
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    for n_colours in (256, 128, 64, 32):
        content = io.BytesIO()
        # this method keeps rare colours: the thin lines of X and Y on a page of greys
        few = picture.quantize(n_colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
        few.save(content, "PNG", optimize=True)
        if content.tell() < MAX_BYTES:
            break
    path.write_bytes(content.getvalue())


if __name__ == "__main__":
    main()
