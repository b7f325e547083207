"""Compare time to contact from box heights with that from metres, on KITTI.

    python -m scripts.contact_in_metres [--write]

Prints the section "Time to contact" of docs/validation.md. With `--write`, the section and its
picture are written (which needs Chromium). The recordings are those in `$NVCORE_REALDATA`.
"""

from __future__ import annotations

import argparse
import io
import os
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from bench.tables import table
from bench.web.tables import put_section
from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.figures.style import LOOK, LOSS_COLOURS
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source, SystemSource
from nvcore.metrics.encounters import find_encounters
from nvcore.settings.params import Params
from nvcore.subjects.time_left.judging import KMH, find_urgent, measure_contact
from nvcore.subjects.time_left.kinds import Urgency
from nvcore.subjects.time_left.steps import time_left_in
from scripts.realdata import realdata

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "validation.md"
PICTURE = "images/time-to-contact.png"
SIZES = {"0013": (1242, 375), "0015": (1242, 375), "0016": (1224, 370)}
"""Recordings with their picture sizes."""
NEAR_SIDE_M = 0.4
"""Distance from the middle of a person, as in KITTI, to their near side."""
EDGE_PX = 1.0
"""Maximum distance from the picture's edge for a box to count as cut off."""
HEIGHTS_PX = (0, 50, 75, 100, 150, np.inf)
TIMES_S = (0, 1, 2, 4, 8, 20, np.inf)
NEAR_S = 4.0
HIGH_PX = 50.0
OFF = 0.1
"""Share by which a drawn box is lower or higher than the person."""
SECTION = """\
## Time to contact: box heights and metres

KITTI tracking 0013, 0015 and 0016, whose truth has distances. *Ratio*: [time to
contact](metrics.md#time-to-contact) from box heights over that from distances, where both are known
and finite: median, and range of the middle 80 %. Once from the truth's boxes, once from those that
a detector (RRC, all scores) drew where it matches. *Not closing*: boxes of people who come nearer
by the metres, but not by the heights.

![Ratio over time to contact, from the truth's boxes and from drawn ones]({picture})

{ratios}

**The truth's boxes only check the formula.** They are projections of a box in space, of one height
throughout a track. The ratio is below 1 at short distances because the height is that of the
person's near side, while the distance goes to the middle. The drawn boxes show where it fails:

- *Far from contact*: with 1 to 4 s left the median is right, and most are within a quarter. From
  8 s on the growth of a box over 1 s is lost in how it is drawn: people are called not closing, or
  nearer than they are. Small boxes (below 50 px) are mostly far away.
- *Boxes cut by the picture's edge* do not count; the time left would come out too long, the
  dangerous side. A detector's box that ends a few pixels before the edge does count: hence the
  ratio in the last second.
- *Who bends or is covered* (drawn lower than 0.9 of the person): half are not closing.

The [urgency](metrics.md#the-last-chance) of the encounters, by distances (rows) and heights,
assumes 50 km/h. By the metres the people come nearer at {speeds} (median).

{urgency}

One frame below the time needed is enough, so a drawn box that jitters makes somebody urgent where
nobody is. Truth from a detector's boxes is no truth for time left.

Share of the boxes that count that detectors miss (all scores, IoU 0.5):

{misses}

Height hides what the time left shows: at {high:.0f} px and more both miss the same share, in the
last {near:.0f} s RRC misses less.

To reproduce: `python -m scripts.contact_in_metres --write`.
"""


def load_kitti(realdata: Path) -> Dataset:
    """Load the three recordings with both detectors and with distances in the truth."""
    return load(
        Session(
            realdata / "kitti_tracking",
            Source(("label_02/*.txt",)),
            tuple(
                SystemSource((f"{folder}/*.txt",), name=name)
                for name, folder in (("RRC", "rrc_ped"), ("PointRCNN", "pointrcnn_ped"))
            ),
            tuple(
                RecordingEntry(name, width=width, height=height)
                for name, (width, height) in SIZES.items()
            ),
            fps=10.0,
        )
    )


def measure_boxes(result: Result) -> pd.DataFrame:
    """Return each truth box that is not ignored with its time to contact by each method.

    Returns
    -------
    Columns recording, height_px, distance_m, occlusion, is_cut, relative_height (of X's box, NaN
    for none), is_missed_x, is_missed_y, and in seconds metres, near_side (distances to the near
    side), heights, with_cut (heights including cut boxes) and drawn (heights of X's boxes).
    """
    truth, frames = result.dataset.truth, result.dataset.frame_columns
    recording = frames.recording[truth.frame_index]
    width, height = frames.width[recording], frames.height[recording]
    flat = replace(truth, distance_m=np.full(len(truth), np.nan))
    middle = replace(flat, x=width / 2, y=np.ones_like(height) + 1, w=np.ones_like(width))
    middle = replace(middle, h=np.minimum(truth.h, height - 4))
    near_side = replace(truth, distance_m=truth.distance_m - NEAR_SIDE_M)
    ways = {"near_side": near_side, "heights": flat, "with_cut": middle}
    contacts = {
        name: measure_contact(
            boxes, result.encounters, frames, ttc_window=result.params.ttc_window
        ).ttc_s
        for name, boxes in ways.items()
    }
    drawn, drawn_px = drawn_contact(result)
    boxes = pd.DataFrame(
        {
            "recording": result.dataset.recordings["name"].to_numpy()[recording],
            "height_px": truth.h,
            "distance_m": truth.distance_m,
            "occlusion": result.dataset.boxes["occlusion"].to_numpy()[: len(truth)],
            "is_cut": (truth.x <= EDGE_PX)
            | (truth.y <= EDGE_PX)
            | (truth.x + truth.w >= width - EDGE_PX)
            | (truth.y + truth.h >= height - EDGE_PX),
            "relative_height": drawn_px / truth.h,
            "is_missed_x": ~result.x.matches.is_matched,
            "is_missed_y": ~result.y.matches.is_matched,
            "metres": time_left_in(result).contact.ttc_s,
            **contacts,
            "drawn": drawn,
        }
    )
    return boxes[~truth.ignore]


def drawn_contact(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Return time to contact (s) and height (px) of each truth box by X's matching box, or NaN."""
    truth, frames = result.dataset.truth, result.dataset.frame_columns
    matches = result.x.matches
    is_drawn = matches.is_matched & ~truth.ignore
    rows = matches.truth_det[is_drawn]
    columns = {name: getattr(result.dataset.system(result.x.name), name)[rows] for name in "xywh"}
    boxes = replace(
        truth.only(is_drawn), **columns, distance_m=np.full(int(is_drawn.sum()), np.nan)
    )
    unknown = np.full(len(boxes), -1, np.int8)
    encounters = find_encounters(boxes, result.tracks.track[is_drawn], unknown, frames)
    contact = measure_contact(boxes, encounters, frames, ttc_window=result.params.ttc_window)
    ttc_s, height_px = np.full(len(truth), np.nan), np.full(len(truth), np.nan)
    ttc_s[is_drawn], height_px[is_drawn] = contact.ttc_s, boxes.h
    return ttc_s, height_px


def ratio_cells(boxes: pd.DataFrame, way: str, base: str = "metres") -> tuple[str, str, str]:
    """Return number of boxes, median ratio with range, and share called not closing, as text."""
    metres, other = boxes[base].to_numpy(), boxes[way].to_numpy()
    is_known = np.isfinite(metres) & (metres > 0) & ~np.isnan(other)
    ratio = other[is_known] / metres[is_known]
    if not len(ratio):
        return "0", "–", "–"
    finite = ratio[np.isfinite(ratio)]
    low, median, high = np.percentile(finite, [10, 50, 90])
    text = f"{median:.2f} ({low:.2f} to {high:.2f})"
    return f"{len(ratio):,}", text, f"{100 * np.isinf(ratio).mean():.1f} %"


def groups_of(boxes: pd.DataFrame) -> Iterator[tuple[str, pd.Series]]:
    """Yield the name and the mask of boxes of each row of the table."""
    yield "all", pd.Series(True, boxes.index)
    for name in SIZES:
        yield name, boxes["recording"] == name
    for column, unit, bounds in (("height_px", "px", HEIGHTS_PX), ("metres", "s left", TIMES_S)):
        for low, high in pairwise(bounds):
            text = f"{low:g} to {high:g} {unit}" if low else f"below {high:g} {unit}"
            text = f"{low:g} {unit} and more" if np.isinf(high) else text
            yield text, (boxes[column] >= low) & (boxes[column] < high)
    for level, text in enumerate(("not occluded", "partly occluded", "heavily occluded")):
        yield text, boxes["occlusion"] == level
    yield "cut by the edge", boxes["is_cut"]
    yield f"drawn lower than {1 - OFF:g} of the person", boxes["relative_height"] < 1 - OFF
    yield f"drawn higher than {1 + OFF:g} of the person", boxes["relative_height"] > 1 + OFF


def ratio_table(boxes: pd.DataFrame) -> str:
    """Return ratios by recording, height, time left, occlusion and edge."""
    rows = []
    for text, is_in in groups_of(boxes):
        part = boxes[is_in]
        rows.append((text, *ratio_cells(part, "heights"), *ratio_cells(part, "drawn")))
    cut = ratio_cells(boxes[boxes["is_cut"]], "with_cut")
    rows.append(("cut by the edge, if they counted", *cut, "", "", ""))
    near = ratio_cells(boxes, "heights", "near_side")
    rows.append((f"all, metres to the near side ({NEAR_SIDE_M:g} m less)", *near, "", "", ""))
    head = ("Boxes", "Truth's", "Ratio", "Not closing", "Drawn", "Ratio", "Not closing")
    return table(list(head), [list(row) for row in rows])


def urgency_table(result: Result, boxes: pd.DataFrame) -> str:
    """Tabulate encounters by urgency from metres, with the number of equal results from heights."""
    truth, frames = result.dataset.truth, result.dataset.frame_columns
    by_metres = time_left_in(result).urgency["urgency"]
    classes = {}
    for way in ("heights", "drawn"):
        ttc_s = np.full(len(truth), np.nan)
        ttc_s[boxes.index] = boxes[way]
        contact = replace(time_left_in(result).contact, ttc_s=ttc_s)
        urgency = find_urgent(contact, truth, result.encounters, frames, result.params)
        classes[way] = urgency["urgency"]
    kinds = [kind.value for kind in Urgency if (by_metres == kind.value).any()]
    rows = []
    for kind in kinds:
        is_in = by_metres == kind
        cells = [kind.replace("_", " "), f"{int(is_in.sum())}"]
        for of_way in classes.values():
            counts = of_way[is_in].value_counts()
            cells.append(
                ", ".join(
                    f"{n} {name.replace('_', ' ')}" for name, n in counts.sort_index().items()
                )
            )
        rows.append(cells)
    return table(["By metres", "Encounters", "By the truth's heights", "By drawn heights"], rows)


def closing_speeds(boxes: pd.DataFrame) -> str:
    """Return the median closing speed of people in each recording, from metres."""
    is_closing = np.isfinite(boxes["metres"]) & (boxes["metres"] > 0)
    near = boxes[is_closing]
    speed_kmh = KMH * near["distance_m"] / near["metres"]
    medians = speed_kmh.groupby(near["recording"]).median()
    return ", ".join(f"{medians[name]:.0f} km/h in {name}" for name in SIZES)


def miss_table(result: Result, boxes: pd.DataFrame) -> str:
    """Tabulate each detector's miss rate for all high boxes and for those with little time left."""
    groups = (
        ("all", boxes["height_px"] > 0),
        (f"{HIGH_PX:g} px and more", boxes["height_px"] >= HIGH_PX),
        (f"less than {NEAR_S:g} s left, by metres", boxes["metres"] < NEAR_S),
        (f"less than {NEAR_S:g} s left, by heights", boxes["heights"] < NEAR_S),
    )
    rows = []
    for text, is_in in groups:
        missed = (
            f"{100 * boxes.loc[is_in, f'is_missed_{letter}'].mean():.1f} %" for letter in "xy"
        )
        rows.append([text, f"{int(is_in.sum()):,}", *missed])
    names = [f"missed by {system.name}" for _, system in result.sides]
    return table(["Boxes", "Number", *names], rows)


def section_of(result: Result, boxes: pd.DataFrame) -> str:
    """Return the section of the page."""
    return SECTION.format(
        picture=PICTURE,
        ratios=ratio_table(boxes),
        speeds=closing_speeds(boxes),
        urgency=urgency_table(result, boxes),
        misses=miss_table(result, boxes),
        high=HIGH_PX,
        near=NEAR_S,
    )


def ratio_figure(boxes: pd.DataFrame) -> go.Figure:
    """Plot the ratio of each box over its time to contact in metres, for truth and drawn boxes."""
    look = LOOK["light"]
    ways = {"heights": "the truth's boxes", "drawn": "boxes drawn by RRC"}
    figure = make_subplots(1, 2, shared_yaxes=True, horizontal_spacing=0.03)
    sizes = ((0, 50, "below 50 px"), (50, 100, "50 to 100 px"), (100, np.inf, "100 px and more"))
    colours = LOSS_COLOURS["light"][1:]  # colours that no system has
    for column, way in enumerate(ways, start=1):
        ratio = (boxes[way] / boxes["metres"]).replace([np.inf, -np.inf], np.nan)
        for (low, high, text), colour in zip(sizes, colours, strict=True):
            is_in = (boxes["height_px"] >= low) & (boxes["height_px"] < high) & ratio.notna()
            figure.add_scatter(
                x=boxes.loc[is_in, "metres"],
                y=ratio[is_in],
                mode="markers",
                marker={"size": 4, "color": colour, "opacity": 0.9},
                name=text,
                legendgroup=text,
                showlegend=column == 1,
                row=1,
                col=column,
            )
    title = "Time to contact by box heights over that by metres"
    subtitle = f"KITTI {', '.join(SIZES)}: a mark for each box that is closing by both"
    style = look.layout(title=title, subtitle=subtitle, height=420)
    ground = {"paper_bgcolor": look.surface, "plot_bgcolor": look.surface}
    figure.update_layout(**(style | ground))
    ticks = {"type": "log", "tickvals": [0.5, 1, 2, 4, 8, 20, 60], "range": np.log10([0.6, 100])}
    for column, text in enumerate(ways.values(), start=1):
        across = look.axis(f"time to contact by metres (s), {text}", can_zoom=True, **ticks)
        figure.update_xaxes(**across, row=1, col=column)
        up = {"type": "log", "range": np.log10([0.2, 5]), "tickvals": [0.25, 0.5, 1, 2, 4]}
        title = "ratio (1 = the same)" if column == 1 else ""
        figure.update_yaxes(**look.axis(title, can_zoom=True, **up), row=1, col=column)
        figure.add_hline(y=1, line={"color": look.ink, "width": 1}, row=1, col=column)
    return figure


def write_picture(figure: go.Figure, path: Path) -> None:
    """Write a figure as PNG with few colours, using Chromium."""
    from PIL import Image
    from playwright.sync_api import sync_playwright

    program = os.environ.get("NVCORE_CHROMIUM", "/usr/bin/chromium-headless-shell")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=program)
        page = chromium.new_page(viewport={"width": 1000, "height": 440}, device_scale_factor=1.5)
        page.set_content(figure.to_html(config={"staticPlot": True}))
        page.wait_for_selector(".main-svg")
        picture = page.locator(".js-plotly-plot").screenshot()
        chromium.close()
    with Image.open(io.BytesIO(picture)) as image:
        image.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> None:
    """Print the section, and write it and the picture."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    folder = realdata()
    result = compare(load_kitti(folder), Params())
    boxes = measure_boxes(result)
    text = section_of(result, boxes)
    print(text)
    if options.write:
        put_section(PAGE, text)
        write_picture(ratio_figure(boxes), PAGE.parent / PICTURE)


if __name__ == "__main__":
    main()
