"""The scene of `field_scene`, written as other tools write it, and what has to come of it.

Each case is the files of truth, X and Y as their user has them, the flags that they give, and the
right outcome: the right values, or a refusal or finding that names the cause.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import field_scene
import pandas as pd
from field_scene import RIGHT, SIZE

Files = Mapping[str, str]
"""Content by path within the folder of one source; a single path is a file."""
SIDES: Final = ("truth", "x", "y")
NAMES: Final = ("bicycle", "car", "person")
"""In the order of the alphabet, as exports number them."""
WIDTH, HEIGHT = SIZE
FPS: Final = ("--fps", "10")
SIZED: Final = (*FPS, "--size", "640x480")


@dataclass(frozen=True)
class Case:
    """Files of one kind.

    Attributes
    ----------
    files
        Of ``truth``, ``x`` and ``y``.
    flags
        What the command line is given beside them.
    right
        What `field_scene.found` gives; None: it is refused, or the audit finds an error.
    says
        Words that the refusal or the finding has; all of them.
    exit_code
        Of ``nvcore compare``.
    """

    files: Mapping[str, Files]
    flags: Sequence[str] = SIZED
    right: Mapping[str, tuple[int, int]] | None = field(default_factory=lambda: RIGHT)
    says: tuple[str, ...] = ()
    exit_code: int = 0

    def write(self, folder: Path) -> list[str]:
        """The files below a folder, and the arguments of ``nvcore compare`` for them."""
        arguments: list[str] = []
        for side, files in self.files.items():
            for name, content in files.items():
                path = folder / side / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(content, encoding="utf-8")
            given = folder / side
            arguments += [f"--{side}", str(given / next(iter(files)) if len(files) == 1 else given)]
        return [*arguments, *self.flags]

    def sent(self, side: str) -> tuple[str, bytes]:
        """Name and content of what is sent for a side: the file, or a ZIP archive of the folder."""
        files = self.files[side]
        if len(files) == 1:
            ((name, content),) = files.items()
            return Path(name).name, content.encode()
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            for name, content in files.items():
                archive.writestr(name, content)
        return f"{side}.zip", packed.getvalue()


def tables() -> dict[str, pd.DataFrame]:
    """Rows of truth, X and Y."""
    return {"truth": field_scene.truth(), **{s: field_scene.detections(s) for s in ("x", "y")}}


def each(write: Callable[[str, pd.DataFrame], Files]) -> dict[str, Files]:
    """Files of all three sides, each by the same writer."""
    return {side: write(side, table) for side, table in tables().items()}


def frame_name(frame: int) -> str:
    """As most tools number pictures."""
    return f"drive_{frame:06d}"


def per_picture(
    table: pd.DataFrame,
    row: Callable[[pd.Series], str],
    *,
    name: Callable[[int], str] = frame_name,
    folder: str = "labels",
) -> dict[str, str]:
    """A text file for each picture, also for those without boxes."""
    rows = dict.fromkeys(range(field_scene.N_FRAMES), "")
    for _, box in table.iterrows():  # small, and each tool has a line of its own
        rows[int(box["frame"])] += row(box) + "\n"
    return {f"{folder}/{name(frame)}.txt": text for frame, text in rows.items()}


def yolo_row(box: pd.Series, names: Sequence[str] = NAMES) -> str:
    """Class, middle and size in shares, and the confidence."""
    middle = (box.x + box.w / 2) / WIDTH, (box.y + box.h / 2) / HEIGHT
    shares = " ".join(f"{value:.8f}" for value in (*middle, box.w / WIDTH, box.h / HEIGHT))
    score = f" {box.score:.3f}" if "score" in box else ""
    return f"{names.index(box['name'])} {shares}{score}"


def yolo(_: str, table: pd.DataFrame) -> Files:
    """YOLO text of three classes without their names."""
    return per_picture(table, yolo_row)


def yolo_people(table: pd.DataFrame, name: Callable[[int], str]) -> Files:
    """YOLO text of pedestrians alone."""
    people = table[table["name"] == "person"]
    return per_picture(people, lambda box: yolo_row(box, ["person"]), name=name)


def _sizes(row: pd.Series) -> list[float]:
    return [row.x, row.y, row.w, row.h]


def coco(
    side: str,
    table: pd.DataFrame,
    *,
    ids: Mapping[str, int],
    image_id: Callable[[int], object] = lambda frame: frame + 1,
    result_image: Callable[[int], Mapping[str, object]] | None = None,
    file_name: Callable[[int], str] = lambda frame: f"{frame_name(frame)}.jpg",
    box: Callable[[pd.Series], Sequence[float]] = _sizes,
) -> Files:
    """COCO truth with categories, or results by id."""
    annotations = [
        {
            **(
                {"image_id": image_id(int(row["frame"]))}
                if side == "truth" or result_image is None
                else result_image(int(row["frame"]))
            ),
            "category_id": ids[row["name"]],
            "bbox": [round(float(value), 2) for value in box(row)],
            **({"id": number, "area": 1.0} if side == "truth" else {"score": float(row["score"])}),
        }
        for number, (_, row) in enumerate(table.iterrows(), start=1)
    ]
    if side != "truth":
        return {f"{side}.json": json.dumps(annotations)}
    images = [
        {"id": image_id(frame), "file_name": file_name(frame), "width": WIDTH, "height": HEIGHT}
        for frame in range(field_scene.N_FRAMES)
    ]
    categories = [{"id": number, "name": name} for name, number in ids.items()]
    content = {"images": images, "annotations": annotations, "categories": categories}
    return {"truth.json": json.dumps(content)}


def csv(table: pd.DataFrame, side: str) -> Files:
    """A CSV file with a header line."""
    return {f"{side}.csv": table.to_csv(index=False)}


IDS: Final = {name: number for number, name in enumerate(NAMES, start=1)}


def _data_yaml(text: str) -> dict[str, Files]:
    return {
        side: {"data.yaml": f"train: images/train\nnc: 3\n{text}", **files}
        for side, files in each(yolo).items()
    }


def _visdrone_mot(side: str, table: pd.DataFrame) -> Files:
    classes = {"person": 1, "bicycle": 3, "car": 4}
    end = "0,0" if side == "truth" else "-1,-1"
    lines = [
        f"{row['frame'] + 1},{row.get('track', -1)},{row['x']:g},{row['y']:g},{row['w']:g},"
        f"{row['h']:g},{row.get('score', 1)},{classes[row['name']]},{end}"
        for row in table.to_dict("records")
    ]
    return {f"{side}.txt": "\n".join(lines) + "\n"}


def _visdrone_det(side: str, table: pd.DataFrame) -> Files:
    classes = {"person": 1, "bicycle": 3, "car": 4}

    def row(box: pd.Series) -> str:
        score = 1 if side == "truth" else box.score
        return f"{box.x:g},{box.y:g},{box.w:g},{box.h:g},{score},{classes[box['name']]},0,0"

    return per_picture(table, row, name=lambda frame: f"drive_{frame:07d}", folder="annotations")


def _mot_by_blanks(side: str, table: pd.DataFrame) -> Files:
    people = table[table["name"] == "person"]
    rows = [
        [row.frame + 1, getattr(row, "track", -1), row.x + 1, row.y + 1, row.w, row.h]
        + ([1, 1, 1] if side == "truth" else [row.score, -1, -1, -1])
        for row in people.itertuples(index=False)
    ]
    separator = "," if side == "truth" else " "
    text = "\n".join(separator.join(f"{value:g}" for value in row) for row in rows)
    return {f"{side}.txt": text + "\n"}


def _ultralytics(frame: int) -> dict[str, object]:
    name = frame_name(frame)
    return {"image_id": name, "file_name": f"{name}.jpg"}


def _ultralytics_number(frame: int) -> dict[str, object]:
    """Where the stem is a number, it is the id, whatever ids the truth has."""
    return {"image_id": frame, "file_name": f"{frame:06d}.jpg"}


def _time_ms(frame: int) -> str:
    """Milliseconds at 10 Hz with a few of jitter."""
    return str(1_598_000_000_023 + 100 * frame + (0, 3, -2, 4, 1)[frame % 5])


def _half_rate(side: str, table: pd.DataFrame) -> Files:
    people = table[table["name"] == "person"].drop(columns="name")
    if side == "y":  # ran on every second picture, and counted those
        people = people[people["frame"] % 2 == 0].assign(frame=people["frame"] // 2)
    return csv(people, side)


def _class_and_name(side: str, table: pd.DataFrame) -> Files:
    if side == "truth":
        return csv(table.rename(columns={"name": "class"}), side)
    numbers = table["name"].map({"person": 0, "bicycle": 1, "car": 2})
    return csv(table.assign(**{"class": numbers}), side)


def _with_child(side: str, table: pd.DataFrame) -> Files:
    names = table["name"].replace("person", "pedestrian")
    if side == "truth":
        names = names.where(table["track"] != 3, "child")
    ids = {"pedestrian": 1, "child": 2, "car": 3, "bicycle": 4}
    return coco(side, table.assign(name=names), ids=ids)


def _roboflow(frame: int) -> str:
    return f"drive_mp4-{frame:04d}_jpg.rf.{frame:032x}"


def _sahi(side: str, table: pd.DataFrame) -> Files:
    """Results with numbers of the model's own, and the names that they stand for."""
    if side == "truth":
        return coco(side, table, ids={"bicycle": 0, "person": 1, "car": 2})
    numbers = {"person": 0, "bicycle": 1, "car": 2}
    results = json.loads(coco(side, table, ids=numbers)[f"{side}.json"])
    names = {number: name for name, number in numbers.items()}
    named = [{**result, "category_name": names[result["category_id"]]} for result in results]
    return {f"{side}.json": json.dumps(named)}


def _people(table: pd.DataFrame) -> pd.DataFrame:
    return table[table["name"] == "person"].drop(columns="name")


def _cvat_mot(side: str, table: pd.DataFrame) -> Files:
    """CVAT's MOT export: the names of its classes in the folder ``gt``, or above it."""
    lines = [
        f"{row['frame'] + 1},{row.get('track', -1)},{row['x'] + 1:g},{row['y'] + 1:g},{row['w']:g},"
        f"{row['h']:g},{row.get('score', 1)},{IDS[row['name']]},1.0"
        for row in table.to_dict("records")
    ]
    return {"gt/gt.txt": "\n".join(lines) + "\n", "labels.txt": "\n".join(NAMES) + "\n"}


def _with_empty_row(side: str, table: pd.DataFrame) -> Files:
    """A row with a frame and no box, as some write that nothing was detected."""
    empty = pd.DataFrame({"frame": [39]})
    return csv(_people(table) if side == "truth" else pd.concat([_people(table), empty]), side)


def _flipped(side: str, table: pd.DataFrame) -> Files:
    """Both systems ran on pictures that were turned left to right."""
    people = _people(table)
    if side != "truth":
        people = people.assign(x=WIDTH - people["x"] - people["w"])
    return csv(people, side)


def _camel_centres(side: str, table: pd.DataFrame) -> Files:
    people = _people(table)
    middle = {"CenterX": people["x"] + people["w"] / 2, "CenterY": people["y"] + people["h"] / 2}
    people = people.assign(**middle).drop(columns=["x", "y"])
    return csv(people.rename(columns={"w": "Width", "h": "Height"}), side)


def _corners(row: pd.Series) -> list[float]:
    return [row.x, row.y, row.x + row.w, row.y + row.h]


CASES: Final[Mapping[str, Case]] = {
    "coco-person-is-3": Case(each(lambda s, t: coco(s, t, ids=IDS)), FPS),
    "coco-ids-from-0": Case(
        each(lambda s, t: coco(s, t, ids={"person": 0, "bicycle": 1, "car": 2})), FPS
    ),
    "yolo-names-in-a-list": Case(_data_yaml("names: ['bicycle', 'car', 'person']\n")),
    "yolo-names-in-lines": Case(_data_yaml("names:\n- bicycle\n- car\n- person\n")),
    "yolo-names-in-a-mapping": Case(_data_yaml("names:\n  0: bicycle\n  1: car\n  2: person\n")),
    "yolo-classes-without-names": Case(
        each(yolo), right=None, says=("several classes", "2 (110 boxes)"), exit_code=2
    ),
    "coco-truth-yolo-numbers": Case(
        {
            "truth": coco("truth", tables()["truth"], ids=IDS),
            **{side: yolo(side, tables()[side]) for side in ("x", "y")},
        },
        FPS,
        right=None,
        says=("several classes",),
        exit_code=2,
    ),
    "visdrone-mot": Case(each(_visdrone_mot)),
    "visdrone-det": Case(each(_visdrone_det)),
    "times-in-names": Case(each(lambda _, t: yolo_people(t, _time_ms))),
    "ultralytics-text-ids": Case(
        each(lambda s, t: coco(s, t, ids=IDS, result_image=_ultralytics)), FPS
    ),
    "ultralytics-numbers-as-ids": Case(
        each(
            lambda s, t: coco(
                s,
                t,
                ids=IDS,
                file_name=lambda frame: f"{frame:06d}.jpg",
                result_image=_ultralytics_number,
            )
        ),
        FPS,
    ),
    "coco-results-as-corners": Case(
        each(lambda s, t: coco(s, t, ids=IDS, box=_sizes if s == "truth" else _corners)),
        FPS,
        right=None,
        says=("left, top, right, bottom",),
        exit_code=1,
    ),
    "roboflow-names": Case(each(lambda _, t: yolo_people(t, _roboflow))),
    "mot-by-blanks": Case(each(_mot_by_blanks)),
    "class-number-and-name": Case(each(_class_and_name)),
    "ending-of-the-camera": Case(
        each(lambda _, t: yolo_people(t, lambda frame: f"set09_V000_I{frame:05d}_lwir"))
    ),
    "half-the-rate": Case(each(_half_rate), right=None, says=("rate",), exit_code=1),
    "child-beside-pedestrian": Case(
        each(_with_child), FPS, right=None, says=("child",), exit_code=0
    ),
    "coco-results-with-names": Case(each(_sahi), FPS),
    "coco-ids-less-by-one": Case(
        each(
            lambda s, t: coco(s, t, ids=IDS if s == "truth" else {n: k - 1 for n, k in IDS.items()})
        ),
        FPS,
        right=None,
        says=("only you know which numbers of the results are pedestrians",),
        exit_code=2,
    ),
    "yolo-names-with-a-mark": Case(
        _data_yaml("names: &names  # all\n  0: bicycle\n  1: car\n  2: person # us\n")
    ),
    "pictures-flipped": Case(
        each(_flipped),
        right=None,
        says=("agree with one another", "the same way round"),
        exit_code=1,
    ),
    "centres-in-capitals": Case(each(_camel_centres)),
    "cvat-mot-names-above": Case(each(_cvat_mot)),
    "rows-without-a-box": Case(each(_with_empty_row)),
    "milliseconds-as-frames": Case(
        each(lambda s, t: csv(_people(t).assign(frame=t["frame"] * 100), s)),
        right=None,
        says=("milliseconds at this frame rate",),
        exit_code=1,
    ),
    "results-by-milliseconds": Case(
        each(
            lambda s, t: csv(_people(t).assign(frame=t["frame"] * (1 if s == "truth" else 100)), s)
        ),
        right=None,
        says=("Hardly anything is left to compare",),
        exit_code=1,
    ),
    "size-behind-the-number": Case(
        each(lambda _, t: yolo_people(t, lambda frame: f"frame_{frame:04d}_640x480"))
    ),
    "checksums-as-names": Case(
        each(lambda _, t: yolo_people(t, lambda frame: f"{frame * 7919 + 10:016x}"[::-1] + "a")),
        right=None,
        says=("checksums",),
        exit_code=2,
    ),
    "times-without-a-frame": Case(
        each(lambda s, t: csv(_people(t).rename(columns={"frame": "timestamp"}), s)),
        right=None,
        says=("none is the frame's number", "timestamp"),
        exit_code=2,
    ),
}
