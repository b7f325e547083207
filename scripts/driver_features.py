"""Compute pedestrians' features in real pictures, for the tables of docs/driver-reference.md.

    python -m scripts.driver_features [--write]

Pictures and boxes are those of `$NVCORE_REALDATA`, all by day: the visible and far-infrared twins
of KAIST, PETS09-S2L1 and two sequences of TUD, and three pictures of KITTI. `--write` puts the
tables between their markers in docs/driver-reference.md. It takes less than a minute on two free
cores.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.wording import number
from nvcore.inputs.load import load
from nvcore.inputs.session import RecordingEntry, Session, Source
from nvcore.pictures.images import decode_image, file_bytes
from nvcore.subjects.driver.features import FEATURE_KEYS, FEATURES, FeatureSettings, features_of
from nvcore.subjects.driver.running.run import run_features
from nvcore.subjects.driver.settings import DriverViewSettings
from scripts.realdata import realdata

ROOT: Final = Path(__file__).resolve().parents[1]
PAGE: Final = ROOT / "docs" / "driver-reference.md"
MARKS: Final = ("<!-- real features: begin -->", "<!-- real features: end -->")
VIDEOS: Final = {"PETS09-S2L1": "vtest.avi", "TUD-Campus": "TUD-Campus.mp4",
                 "TUD-Stadtmitte": "TUD-Stadtmitte.mp4"}  # fmt: skip
TWINS: Final = ("set08_V000_visible_I02159.png", "set08_V000_lwir_I02159.png")
KITTI: Final = (2, 7, 12)
SURROUNDS: Final = (1.5, 2.0, 3.0)
_FORMS: Final = {"colour_emd": ".2f"}


def videos(realdata: Path, surround: float) -> dict[str, pd.DataFrame]:
    """Return the features of every pedestrian in the videos, by recording."""
    tables = {}
    for name, file in VIDEOS.items():
        session = Session(
            folder=realdata,
            truth=Source(f"mot15/{name}/gt/gt.txt"),
            systems=(),
            recordings=(RecordingEntry(name, pictures=f"videos/{file}"),),
        )
        settings = replace(DriverViewSettings(), features=FeatureSettings(surround=surround))
        tables[name] = run_features(load(session), settings).table
    return tables


def of_picture(path: Path, boxes: np.ndarray) -> pd.DataFrame:
    """Return the features of these boxes in a picture, with the fixation in its middle."""
    picture = decode_image(file_bytes(path), path.name)
    height, width = picture.shape[:2]
    values = features_of(picture, boxes, (width / 2, height / 2))
    return pd.DataFrame(values, columns=list(FEATURE_KEYS))


def twins(realdata: Path) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the two pedestrians of KAIST in the visible and in the far-infrared picture."""
    folder = realdata / "thermal" / "kaist"
    truth = pd.read_csv(folder / "gt.csv")
    visible, infrared = (
        of_picture(folder / name, truth.loc[truth["file"] == name, [*"xywh"]].to_numpy(float))
        for name in TWINS
    )
    return visible, infrared


def kitti(realdata: Path) -> pd.DataFrame:
    """Return the pedestrians of three pictures of KITTI."""
    rows = pd.read_csv(realdata / "kitti_tracking" / "label_02" / "0016.txt", sep=" ", header=None)
    tables = []
    for frame in KITTI:
        own = rows[(rows[0] == frame) & (rows[2] == "Pedestrian")]
        left, top, right, bottom = own[[6, 7, 8, 9]].to_numpy(float).T
        boxes = np.stack([left, top, right - left, bottom - top], axis=1)
        path = realdata / "kitti_tracking" / "images" / f"0016_{frame:06}.png"
        tables.append(of_picture(path, boxes))
    return pd.concat(tables, ignore_index=True)


def cell(values: pd.Series, key: str) -> str:
    """Format the median and the range of the middle 80 %."""
    form = _FORMS.get(key, ".1f")
    if values.isna().all():
        return "–"
    low, middle, high = values.quantile([0.1, 0.5, 0.9])
    return f"{number(middle, form)} ({number(low, form)} to {number(high, form)})"


def table_of_sets(sets: dict[str, pd.DataFrame]) -> list[str]:
    """Return rows with one feature per row and one set per column."""
    lines = [
        "| | " + " | ".join(f"{name}, {len(table):,} boxes" for name, table in sets.items()) + " |",
        "|---" * (1 + len(sets)) + "|",
    ]
    for feature in FEATURES:
        cells = [cell(table[feature.key], feature.key) for table in sets.values()]
        lines.append(f"| {feature.label}, {feature.unit} | {' | '.join(cells)} |")
    return lines


def table_of_twins(visible: pd.DataFrame, infrared: pd.DataFrame) -> list[str]:
    """Return rows with one feature per row, for the two pedestrians in both pictures."""
    lines = [
        "| | first, visible | first, far infrared | second, visible | second, far infrared |",
        "|---|--:|--:|--:|--:|",
    ]
    for feature in FEATURES:
        form = _FORMS.get(feature.key, ".1f")
        cells = [
            number(float(table[feature.key][row]), form)
            for row in (0, 1)
            for table in (visible, infrared)
        ]
        lines.append(f"| {feature.label}, {feature.unit} | {' | '.join(cells)} |")
    return lines


def table_of_surrounds(by_surround: dict[float, pd.DataFrame]) -> list[str]:
    """Return rank correlations of each contrast with that of the default surround."""
    usual = by_surround[2.0]
    others = [surround for surround in by_surround if surround != 2.0]
    lines = [
        "| | " + " | ".join(f"{surround:g} beside 2" for surround in others) + " |",
        "|---|" + "--:|" * len(others),
    ]
    for key in ("luminance_contrast", "lab_distance", "edge_contrast", "colour_emd"):
        label = next(feature.label for feature in FEATURES if feature.key == key)
        cells = [
            number(usual[key].corr(by_surround[surround][key], method="spearman"), ".2f")
            for surround in others
        ]
        lines.append(f"| {label} | {' | '.join(cells)} |")
    return lines


def text(realdata: Path) -> str:
    """Return all tables as Markdown."""
    by_surround = {surround: videos(realdata, surround) for surround in SURROUNDS}
    pooled = {
        surround: pd.concat(tables.values(), ignore_index=True)
        for surround, tables in by_surround.items()
    }
    sets = {**by_surround[2.0], "KITTI": kitti(realdata)}
    parts = [
        ["Median, and between which values eight of ten boxes lie:"],
        table_of_sets(sets),
        ["Two pedestrians of KAIST by day, in the visible picture and its far-infrared twin:"],
        table_of_twins(*twins(realdata)),
        ["Rank correlation (Spearman) of contrasts with another `surround`, "
         f"{len(pooled[2.0]):,} boxes of the videos:"],
        table_of_surrounds(pooled),
    ]  # fmt: skip
    return "\n\n".join("\n".join(lines) for lines in parts)


def main() -> None:
    """Print the tables, and write them between their markers."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    folder = realdata()
    body = text(folder)
    print(body)
    if options.write:
        begin, end = MARKS
        before, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
        after = rest.partition(end)[2]
        PAGE.write_text(f"{before}{begin}\n\n{body}\n\n{end}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
