"""Measure sliders in a browser: painted frames during a drag, and the time to rest after a key.

    python -m bench.web.sliders [--frames 0 100000] [--repeat 12] [--out FILE]

Measured are the dashboard and an app with nothing but a slider, in one run. 0 frames mean the
sample. One line of JSON is printed. With ``--out`` the section "Sliders" of that page is written.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from statistics import median
from typing import Any

from playwright.sync_api import Browser, Page

from bench.measure import report
from bench.tables import table
from bench.web.__main__ import go_to, open_set, settle
from bench.web.server import folder_of_set, open_chromium, serve
from bench.web.tables import put_section

EMPTY = Path(__file__).with_name("empty_app.py")
SLIDERS = ("alpha", "midpoint", "threshold_x")
DRAG_S, WARM = 3.0, 2
REACH = 0.12
"""Distance of a drag to either side, as a share of the slider's length."""
HEADING = "## Sliders"
METHOD = """\
The sidebar's sliders in headless Chromium {version}, 1280x800, without a GPU, server and browser
on this machine. *Painted*: frames of the browser per second while the handle goes to and fro for
{seconds:g} s; *with new numbers*: those with changed numbers or lines, at most as many as the
slider has steps on its way. *Key*: from a press of an arrow key on alpha to the first frame with a
changed number or line, and until the page is at rest, median of {n}.
Load of the machine when it began: {load:.1f}.
"""

# Visible changes: numbers of the scorecard, lines of the time plot, any text of the rest.
SEEN = """() => [...document.querySelectorAll(".nv-scorecard td, .nv-tiles [data-value]")]
    .map((cell) => cell.textContent).join()
  + [...document.querySelectorAll("[class*=st-key-time_plot_] path.js-line")]
    .map((line) => line.getAttribute("d")).join().slice(0, 20000)
  + [...document.querySelectorAll("[data-testid=stMain] [data-testid=stMarkdown]:has(p)")]
    .slice(0, 3).map((text) => text.textContent).join()"""
COUNT = (
    "() => { const seen = "
    + SEEN
    + """;
  let last = "";
  const own = (window.counted = { painted: 0, changed: 0 });
  (function look() {
    if (window.counted !== own) return; // the next drag is counted
    own.painted += 1;
    const now = seen();
    if (now !== last) own.changed += 1;
    last = now;
    requestAnimationFrame(look);
  })(); }"""
)
# Resolves with the milliseconds to the first change, and until nothing is old or being computed.
PRESS = (
    "(limit_ms) => { const seen = "
    + SEEN
    + """;
  const isAtRest = () => document.querySelector('[data-testid="stApp"]').dataset.testScriptState
      === "notRunning"
    && !document.querySelector('[data-testid="stSkeleton"], [data-stale="true"], [data-nv-late]');
  const before = seen();
  window.pressed = new Promise((done) => addEventListener("keydown", () => {
    const start = performance.now();
    let [first, calm] = [null, null];
    const look = () => {
      const passed = performance.now() - start;
      if (first === null && seen() !== before) first = passed;
      if (!isAtRest()) calm = null;
      else calm ??= passed;
      const isDone = calm !== null && first !== null && passed - calm > 300;
      if (isDone) done([first, Math.max(first, calm)]);
      else if (passed > limit_ms) done(null);
      else requestAnimationFrame(look);
    };
    look();
  }, { capture: true, once: true }));
}"""
)


def drag(page: Page, key: str) -> dict[str, float]:
    """Drag the handle back and forth, and return frames per second, all and with changes."""
    slider = page.locator(f".st-key-{key}")
    slider.scroll_into_view_if_needed()
    handle = slider.locator("[style*='translate']").first.bounding_box()
    track = slider.get_by_role("group").bounding_box()
    assert handle is not None
    assert track is not None
    x, y = handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2
    page.mouse.move(x, y)
    page.wait_for_function("() => !window.nvcoreLive || window.nvcoreLive.compare()")
    page.mouse.down()
    page.evaluate(COUNT)
    start = page.evaluate("performance.now()")
    step, passed = 0, 0.0
    while passed < 1000 * DRAG_S:
        step += 1
        share = abs((step % 80) - 40) / 20 - 1  # back and forth between -1 and 1
        page.mouse.move(x + REACH * share * track["width"], y)
        passed = page.evaluate("performance.now()") - start
    counted = page.evaluate("counted")
    page.mouse.move(x, y)
    page.mouse.up()
    settle(page)
    return {name: 1000 * n / passed for name, n in counted.items()}


def press(page: Page, repeat: int) -> tuple[float, float] | None:
    """Return median seconds from a key on alpha to the first change, and to rest."""
    runs = []
    for number in range(WARM + repeat):
        page.get_by_role("slider", name="alpha").focus()
        page.evaluate(PRESS, 10_000)
        page.keyboard.press("ArrowRight" if number % 2 else "ArrowLeft")
        run = page.evaluate("window.pressed")
        settle(page)
        if run is not None and number >= WARM:
            runs.append(run)
    if not runs:
        return None
    first, rest = (median(run[i] for run in runs) / 1000 for i in (0, 1))
    return first, rest


def measure(
    browser: Browser, url: str, n: int, repeat: int, *, is_empty: bool
) -> dict[str, dict[str, Any]]:
    """Measure each slider and the key, by page."""
    figures: dict[str, dict[str, Any]] = {}
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    if n:
        open_set(page, url)
    else:
        page.goto(url)
    for title in ("Overview",) if is_empty else ("Overview", "Timeline"):
        settle(page)
        if n or title != "Overview":
            go_to(page, title)
        settle(page)
        of = {key: drag(page, key) for key in (("alpha",) if is_empty else SLIDERS)}
        figures[title] = {**of, "key": press(page, repeat)}
    page.close()
    return figures


def section(figures: dict[str, Any]) -> str:
    """Return the section of docs/benchmarks.md."""
    head = ["painted per s, with new numbers", *SLIDERS, "key: first change, at rest"]
    rows = []
    for name, measured in figures["apps"].items():
        cells = []
        for key in SLIDERS:
            of = measured.get(key)
            cells.append(f"{of['painted']:.0f}, {of['changed']:.0f}" if of else "")
        pressed = measured["key"]
        cells.append(", ".join(f"{s:.2f} s" for s in pressed) if pressed else "–")
        rows.append([name, *cells])
    how = METHOD.format(
        version=figures["chromium"], seconds=DRAG_S, n=figures["repeat"], load=figures["load"]
    )
    return f"{HEADING}\n\n{how}\n{table(head, rows)}\n"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, nargs="+", default=[0, 100_000])
    parser.add_argument("--repeat", type=int, default=12)
    parser.add_argument("--port", type=int, default=8660)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    figures: dict[str, Any] = {"load": os.getloadavg()[0], "repeat": options.repeat}
    apps: dict[str, dict[str, Any]] = {}
    with open_chromium() as (browser, parent):
        figures["chromium"] = browser.version
        for n in options.frames:
            folder = folder_of_set(parent, n)
            with serve(folder, options.port) as (url, _):
                for title, of in measure(browser, url, n, options.repeat, is_empty=False).items():
                    apps[f"{n:,} frames, {title}" if n else title] = of
            print(n, apps, file=sys.stderr)
        with serve(parent, options.port, script=EMPTY) as (url, _):
            (apps["empty app"],) = measure(browser, url, 0, options.repeat, is_empty=True).values()
    figures["apps"] = apps
    if options.out:
        put_section(options.out, section(figures))
    report(**figures)


if __name__ == "__main__":
    main()
