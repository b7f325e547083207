"""The viewer's labels on crowded frames, drawn by its own script in a real browser."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page

from ui.widgets.script import read_script
from ui.widgets.viewer import FOLDER

TRUTH, X, Y = 0, 1, 2
RELEVANT, MATCHED_X, MATCHED_Y = 8, 2, 4
MATCHED, FALSE_ALARM = 1, 2
# The picture stands in the middle of a wider canvas.
AREA = {"x": 40.0, "y": 0.0, "w": 600.0, "h": 400.0}

# Draws boxes [x, y, w, h, score, track, source, state] and returns the labels with their places.
DRAW = """([rows, area]) => {
  const placed = [];
  const draw = Labels.prototype.draw;
  Labels.prototype.draw = function (parts, rect) {
    placed.push({ text: parts.map((part) => part.text).join(" "), ...rect });
    draw.call(this, parts, rect);
  };
  const column = (i) => rows.map((row) => row[i]);
  const boxes = { x: column(0), y: column(1), w: column(2), h: column(3), score: column(4),
                  track: column(5), source: column(6), state: column(7) };
  const canvas = document.createElement("canvas");
  const layers = { truth: true, x: true, y: true, labels: true };
  const found = { boxes, start: 0, stop: rows.length };
  drawBoxes(canvas.getContext("2d"), found, { scale: 1, x: 0, y: 0 }, layers,
            { x: "#00F", y: "#F80", truth: "#FFF", dash: { x: [], y: [6, 4] } }, area);
  Labels.prototype.draw = draw;
  return placed;
}"""


@pytest.fixture(scope="module")
def page(chromium: BrowserContext) -> Iterator[Page]:
    opened = chromium.new_page()
    opened.add_script_tag(content=read_script(FOLDER / "drawing" / "drawing.js"))
    yield opened
    opened.close()


def labels_of(page: Page, rows: Sequence[Sequence[float]]) -> list[dict[str, Any]]:
    placed: list[dict[str, Any]] = page.evaluate(DRAW, [rows, AREA])
    return placed


def overlap(one: dict[str, float], other: dict[str, float]) -> bool:
    return (
        one["x"] < other["x"] + other["w"]
        and other["x"] < one["x"] + one["w"]
        and one["y"] < other["y"] + other["h"]
        and other["y"] < one["y"] + one["h"]
    )


def missed(x: float, y: float, track: int, state: int = RELEVANT) -> list[float]:
    return [x, y, 24, 60, 0, track, TRUTH, state]


def test_in_a_crowd_labels_cover_neither_each_other_nor_the_missed(page):
    crowd = [missed(150 + 26 * i, 150 + 9 * (i % 3), i) for i in range(12)]
    found = [[x + 2, y + 3, 24, 58, 0.5, -1, Y, MATCHED] for x, y, *_ in crowd]
    labels = labels_of(page, [*crowd, *found])
    tracks = sorted(int(label["text"].split("#")[1]) for label in labels if "#" in label["text"])
    assert tracks == list(range(12))
    people = [dict(zip("xywh", row, strict=False)) for row in crowd]
    crossing = [
        (label["text"], other)
        for i, label in enumerate(labels)
        for other in [*people, *labels[:i]]
        if overlap(label, other)
    ]
    assert crossing == []


def test_a_missed_pedestrian_keeps_its_label_where_there_is_no_room(page):
    matched = [[300, 100, 20, 40, 0.9, -1, X, MATCHED] for _ in range(40)]
    texts = [label["text"] for label in labels_of(page, [*matched, missed(300, 100, 7, RELEVANT)])]
    assert "X Y missed #7" in texts
    assert texts.count("X 0.90") < 5  # matched ones lose theirs

    everywhere = [[0, 0, 700, 400, 0, 100 + i, TRUTH, RELEVANT | MATCHED_X] for i in range(3)]
    texts = [label["text"] for label in labels_of(page, everywhere)]
    assert texts == ["Y #100", "Y #101", "Y #102"]


def test_labels_lie_inside_the_picture(page):
    at_edges = {
        "left": [38, 200, 9, 20],
        "right": [632, 200, 30, 20],
        "top": [300, -9, 20, 30],
        "bottom": [300, 385, 20, 30],
        "corner": [30, 390, 20, 30],
    }
    outside = []
    for source, state in ((X, FALSE_ALARM), (Y, FALSE_ALARM), (TRUTH, RELEVANT)):
        for edge, box in at_edges.items():
            (label,) = labels_of(page, [[*box, 0.01, 4, source, state]])
            is_across = AREA["x"] <= label["x"] <= AREA["x"] + AREA["w"] - label["w"]
            is_down = AREA["y"] <= label["y"] <= AREA["y"] + AREA["h"] - label["h"]
            if not (is_across and is_down):
                outside.append((edge, source, label))
    assert outside == []
