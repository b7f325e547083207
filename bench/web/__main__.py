"""Measure the dashboard in a browser: slider key press to changed plot, and playback.

    python -m bench.web [--frames 0 100000 1000000] [--repeat 10] [--port 8650] [--out FILE]

The module starts the app on a folder of sets, opens each in Chromium (``$NVCORE_CHROMIUM``, else
/usr/bin/chromium-headless-shell), goes to the Timeline page and presses an arrow key on one slider
after the other. 0 frames mean the sample recordings. Each set has its own server. One line of JSON
is printed. With ``--out`` the section "In the browser" of that page is written.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

from playwright.sync_api import Browser, Locator, Page, expect

from bench.measure import report
from bench.web.scene import FPS, READER, is_whole, write_scene
from bench.web.server import CHROMIUM, folder_of_set, open_chromium, serve
from bench.web.tables import put_section, web_section

SLIDERS = {
    "alpha": ("Misses against false alarms (alpha)", "ArrowLeft"),
    "sigmoid midpoint": ("Counts half at (px)", "ArrowRight"),
    "threshold": ("Score threshold of X", "ArrowRight"),
}
"""Slider to move, with its label and key."""
OPEN_S, WARM = 600, 2
PLAY_S = 5.0
NO_CHANGE_MS = 2_500
"""Time after which a key press counts as having no effect and is ignored, for example because no
detection lies between the two thresholds.
"""

# Resolves with the milliseconds from the next key press until the lines of the time plot have
# changed and the frame with them was painted; -1 if they do not change.
WATCH = """([plot, limit_ms]) => {
  const lines = () => [...document.querySelectorAll(`${plot} .scatterlayer path.js-line`)]
    .map(line => line.getAttribute("d")).join();
  const before = lines();
  window.painted = new Promise(done => addEventListener("keydown", () => {
    const start = performance.now();
    const look = () => {
      const now = lines(), passed = performance.now() - start;
      if (now && now !== before)
        requestAnimationFrame(() => setTimeout(() => done(performance.now() - start)));
      else if (passed > limit_ms) done(-1);
      else requestAnimationFrame(look);
    };
    look();
  }, { capture: true, once: true }));
}"""

# Collects one reading for each row that the viewer paints while it plays.
PLAYED = (
    "async (viewer, ms) => { const read = "
    + READER
    + """; const seen = []; const start = performance.now();
  while (performance.now() - start < ms) {
    await new Promise(requestAnimationFrame);
    if (!seen.length || seen.at(-1).shown !== Number(viewer.dataset.shownRow)) {
      seen.push(read(viewer));
      seen.at(-1).ms = performance.now() - start;
    }
  }
  return seen; }"""
)


def measure_set(browser: Browser, url: str, repeat: int, *, is_sample: bool) -> dict[str, Any]:
    """Return the seconds to open the set, and those of each key press by slider."""
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    opened_s = None if is_sample else open_set(page, url)
    if is_sample:
        page.goto(url)
    go_to(page, "Timeline")
    page.locator(".st-key-time_plot_0 .scatterlayer path.js-line").first.wait_for(timeout=60_000)
    settle(page)
    seconds = {name: move(page, *slider, repeat) for name, slider in SLIDERS.items()}
    page.close()
    return {"opened_s": opened_s, "seconds": seconds}


def open_set(page: Page, url: str) -> float:
    """Open the folder's session on the Data page, and return the seconds until all is shown."""
    page.goto(f"{url}/data")
    settle(page)
    box = page.get_by_text("Open your own files or another comparison")
    if box.count():  # in older versions it is already open
        box.click()
    page.get_by_role("tab", name="Local folder").click(timeout=60_000)
    button = page.get_by_role("button", name="Open session")
    button.wait_for(timeout=60_000)
    start = perf_counter()
    button.click()
    # the sidebar shows the name before the page is complete
    page.get_by_text("X: first").first.wait_for(state="attached", timeout=1000 * OPEN_S)
    settle(page)
    return perf_counter() - start


def go_to(page: Page, name: str) -> None:
    settle(page)
    page.get_by_role("link", name=name, exact=True).first.click()
    page.get_by_role("heading", name=name, level=1).wait_for(timeout=1000 * OPEN_S)
    settle(page)


def settle(page: Page) -> None:
    """Wait until the script has ended and nothing old is shown."""
    page.locator('[data-testid="stApp"][data-test-script-state="notRunning"]').wait_for(
        timeout=1000 * OPEN_S
    )
    page.wait_for_function(
        "() => !document.querySelector('[data-testid=stSkeleton], [data-stale=true]')",
        timeout=1000 * OPEN_S,
    )


def move(page: Page, label: str, key: str, repeat: int) -> list[float]:
    """Return the seconds from key press to painted plot, without the first `WARM` presses."""
    slider = page.get_by_role("slider", name=label)
    seconds: list[float] = []
    for _ in range(3 * (WARM + repeat)):
        slider.focus()
        page.evaluate(WATCH, [".st-key-time_plot_0", NO_CHANGE_MS])
        page.keyboard.press(key)
        took_ms = float(page.evaluate("() => window.painted"))
        settle(page)
        if took_ms > 0:
            seconds.append(took_ms / 1000)
        if len(seconds) == WARM + repeat:
            break
    return seconds[WARM:]


def measure_playing(browser: Browser, url: str) -> dict[str, float]:
    """Count the frames due, those painted, and those with the boxes of another frame."""
    page = browser.new_page(viewport={"width": 1280, "height": 1000})
    open_set(page, url)
    go_to(page, "Timeline")
    viewer = page.locator(".viewer")
    expect(viewer).to_have_attribute("data-shown-row", "0", timeout=60_000)
    painted = _play(page, viewer, 1000 * PLAY_S)
    painted = [frame for frame in painted if frame["ms"] > 300]  # it has started by then
    due = (painted[-1]["ms"] - painted[0]["ms"]) / 1000 * FPS + 1
    page.close()
    return {
        "due": round(due),
        "painted": len(painted),
        "mixed": sum(not is_whole(frame) for frame in painted),
    }


def _play(page: Page, viewer: Locator, ms: float) -> list[dict[str, float]]:
    viewer.focus()
    page.keyboard.press("Space")
    played: list[dict[str, float]] = viewer.evaluate(PLAYED, ms)
    page.keyboard.press("Space")
    return played


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, nargs="+", default=[0, 100_000, 1_000_000])
    parser.add_argument("--one-recording", action="store_true", help="one long recording")
    parser.add_argument("--repeat", type=int, default=10)
    parser.add_argument("--port", type=int, default=8650)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    if not Path(CHROMIUM).exists():
        report(failed=f"{CHROMIUM} is missing: apt-get install chromium-headless-shell")
        return
    figures: dict[str, Any] = {"load": os.getloadavg()[0], "sets": {}}
    with open_chromium() as (browser, parent):
        figures["chromium"] = browser.version
        for n in options.frames:
            folder = folder_of_set(parent, n, one_recording=options.one_recording)
            print(f"in the browser, {n:,} frames ..." if n else "sample ...", file=sys.stderr)
            with serve(folder, options.port) as (url, _):
                figures["sets"][n] = measure_set(browser, url, options.repeat, is_sample=not n)
            print(figures["sets"][n], file=sys.stderr)
        folder = parent / "scene"
        write_scene(folder)
        with serve(folder, options.port) as (url, _):
            figures["playing"] = measure_playing(browser, url)
    if options.out:
        put_section(options.out, web_section(figures))
    report(**figures)


if __name__ == "__main__":
    main()
