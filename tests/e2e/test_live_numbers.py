"""What the browser computes while a slider moves, beside what the library computes."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
from app_server import ROOT
from places import SAMPLE
from playwright.sync_api import BrowserContext, Page
from scenes import draw_scene

import nvcore as nv
from nvcore.common.wording import difference, minus
from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.table import measure_of
from nvcore.evidence.operating_points import at_operating_point
from nvcore.settings.params import Params
from ui.session.packed_comparison import LIVE, pack_comparison
from ui.shell.live import FOLDER
from ui.widgets.script import read_script

EQUAL = {"rel": 1e-12, "abs": 1e-9}
ENGINE = read_script(FOLDER / "comparison.js")
COMPARE = (
    "([packed, rules, settings, window]) => {"
    + ENGINE
    + """
  const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
  const comparison = new Comparison(bytes.buffer, rules);
  const text = (value) => String(value);  // NaN and infinity pass as text
  return settings.map((one) => {
    comparison.update(one);
    const measures = Object.entries(comparison.measures());
    const recordings = [...Array(comparison.columns.first.length - 1).keys()];
    const smooth = (of) => recordings.flatMap((r) => [...comparison.smooth(of, r, window)]);
    return {
      measures: Object.fromEntries(measures.map(([key, { x, y }]) => [key, [text(x), text(y)]])),
      similarity: ["x", "y"].map((of) => [...comparison[of].similarity]),
      means: [comparison.x, comparison.y].map(smooth),
    };
  });
}"""
)


@pytest.fixture(scope="module")
def blank(chromium: BrowserContext) -> Iterator[Page]:
    page = chromium.new_page()
    yield page
    page.close()


def in_browser(page: Page, base: Result, settings: list[Params]) -> list[dict[str, Any]]:
    rules = {name: getattr(base.params, name) for name in ("proximity", "pairing", "coverage")}
    packed = base64.b64encode(pack_comparison(base)).decode()
    live = [{name: getattr(one, name) for name in LIVE} for one in settings]
    rules["point"] = "equal-alarms"
    computed: list[dict[str, Any]] = page.evaluate(
        COMPARE, [packed, rules, live, base.params.window]
    )
    return computed


def check(page: Page, base: Result, settings: list[Params]) -> None:
    """The browser's numbers are the library's, whatever was computed before."""
    for params, computed in zip(settings, in_browser(page, base, settings), strict=True):
        result = at_operating_point(compare(base.dataset, params), "equal-alarms")
        for key, values in computed["measures"].items():
            of = measure_of(key).of
            assert of is not None
            expected = [float(of(result, system)) for _, system in result.sides]
            assert [float(value) for value in values] == pytest.approx(
                expected, nan_ok=True, **EQUAL
            ), (key, asdict(params))
        for i, (_, system) in enumerate(result.sides):
            np.testing.assert_allclose(computed["similarity"][i], system.similarity, atol=1e-9)
            np.testing.assert_allclose(computed["means"][i], system.similarity_window, atol=1e-9)


def settings_from(base: Params, seed: int, n: int) -> list[Params]:
    """Settings in whose sequence now one slider moves, now several."""
    rng = np.random.default_rng(seed)
    drawn = {
        "alpha": lambda: rng.uniform(0, 1),
        "midpoint": lambda: rng.uniform(5, 120),
        "spread": lambda: rng.uniform(1, 30),
        "midpoint_m": lambda: rng.uniform(5, 60),
        "spread_m": lambda: rng.uniform(1, 20),
        "edge_weight": lambda: rng.uniform(0, 1),
        "low": lambda: rng.uniform(0.5, 1),
        "threshold_x": lambda: round(rng.uniform(-0.1, 1.1), 2),
        "threshold_y": lambda: round(rng.uniform(-0.1, 1.1), 2),
    }
    assert set(drawn) == set(LIVE)
    made = [base]
    for _ in range(n):
        names = rng.choice(LIVE, rng.integers(1, 4), replace=False)
        changed: dict[str, Any] = {str(name): float(drawn[str(name)]()) for name in names}
        made.append(replace(made[-1], **changed))
    return made


def test_of_the_sample(blank: Page):
    base = compare(nv.load(SAMPLE))
    check(blank, base, settings_from(base.params, 1, 60))


def test_of_random_scenes(blank: Page):
    kinds: list[dict[str, Any]] = [
        {},
        {"proximity": "distance"},
        {"proximity": "distance", "missing_distance": "borrow"},
        {"proximity": "horizon", "horizon": 30.0},
        {"proximity": "none"},
        {"pairing": "matched"},
        {"distance": "ground"},
        {"distance": "ground", "pairing": "matched", "match": "lateral"},
        {"iou": 0.2, "coverage": 0.3},
    ]
    for kind in kinds:
        for seed in range(6):
            scene = draw_scene(seed, is_grid=seed % 2 == 1, has_tracks=seed != 4)
            scores = np.random.default_rng(seed)
            for boxes in (scene.x, scene.y):  # all have one, so that thresholds can be moved
                boxes[:] = [box._replace(score=round(scores.uniform(), 2)) for box in boxes]
            base = compare(scene.dataset(), Params(**kind))
            check(blank, base, settings_from(base.params, seed, 20))


def test_of_systems_without_scores_and_of_nothing(blank: Page):
    scene = draw_scene(3)
    scene.x = [box._replace(score=math.nan) for box in scene.x]
    scene.y = []
    base = compare(scene.dataset(), Params())
    check(blank, base, settings_from(base.params, 3, 20))


def test_numbers_are_written_as_by_python(blank: Page):
    script = read_script(ROOT / "ui" / "widgets" / "table" / "number_format.js")
    values = [n / 8 for n in range(-40, 4000, 7)] + [0.145, 1.555, 2.675, 1e6 / 3, -0.004, 0.285]
    cases = [
        (value, form) for value in values for form in (".0f", ".1f", ".2f", ".3f", ".0%", ".1%")
    ]
    apart = [(value, value + step, form) for value, form in cases for step in (0.0, 0.002, -0.03)]
    written, differences = blank.evaluate(
        f"([cases, apart]) => {{ {script}\n return [cases.map((one) => formatted(...one)),"
        " apart.map((one) => difference(...one))]; }",
        [cases, apart],
    )
    expected = (minus(format(value, f"z,{form}")) for value, form in cases)
    assert written == [text.replace("%", " %") for text in expected]
    assert differences == [minus(difference(*one)) for one in apart]
