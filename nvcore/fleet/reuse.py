"""What a later scan with other settings reuses: of each batch, what matching and distances left.

Kept are the boxes of the truth, what steps made that no sigmoid and no alpha moves, and of each
detection that counts its size and the most that its term can be. The systems' boxes are not needed
again, unless a setting that `stage_key` covers changes.
"""

from __future__ import annotations

import hashlib
import json
import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cached_property
from importlib import import_module
from io import BytesIO
from typing import IO, Any, Final, TypeAlias
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np
import pandas as pd
import pyarrow as pa

from nvcore import __version__
from nvcore.columns import BoxColumns, boxes_of_frame, offsets_of
from nvcore.comparison import TRUTH_STEPS, Result, compare
from nvcore.dataset import Dataset
from nvcore.errors import InputError
from nvcore.fleet.cutting import can_be_cut
from nvcore.fleet.results import ScanParams, each_recording, result_tables, spans_table
from nvcore.measures.table import MEASURES
from nvcore.metrics.encounter_classes import classes_of
from nvcore.metrics.proximity import in_use, weigh_proximity
from nvcore.metrics.similarity import Nearest, SetDistances, border_of, measure_sets
from nvcore.objects import objects_from
from nvcore.params import SETTINGS, params_from, settings_for
from nvcore.schema import DATASET_BOX_DTYPES, RECORDING_DTYPES, conform
from nvcore.scoring import Inputs, Made, Memo, steps_of
from nvcore.scoring.system import STEPS
from nvcore.settings import Settings
from nvcore.stages import LOW, NEAREST, SIMILARITY

_KEPT: Final = (
    *("n_truth", "contact", "urgency", "matches", "n_det", "matched", "false_alarms", "episodes"),
    *("nearest", "distances", "events", "encounters", "failures", "confirmed"),
)
"""Steps whose results are kept, as far as they are of frames, encounters or boxes of the truth."""

_CODEC: Final = "lz4_raw"
_ABOUT: Final = "about.json"
_DAMAGED: Final = (
    *(BadZipFile, EOFError, LookupError, OSError, RuntimeError, ValueError),
    *(struct.error, zlib.error),
)
"""What reading a ZIP file raises of which a byte is another."""
Frozen: TypeAlias = "bytes | IO[bytes]"
"""What is kept of a batch: as `freeze` returns it, or the file that it was written to."""
Arrays: TypeAlias = Callable[[int], Any]
"""The bytes of an array by its number."""


def can_reuse(params: ScanParams) -> bool:
    """Whether no step looks at the systems' boxes once they are matched and measured."""
    return can_be_cut(params.params)


def stage_key(params: ScanParams) -> str:
    """sha256 over the settings that what is kept of a batch depends on.

    Two scans with the same key, of the same recordings in the same versions, can reuse it.
    """
    names = (*settings_for(NEAREST), "threshold_x", "threshold_y")
    names += ("edge_weight", "proximity", "horizon")
    values = [getattr(params.params, name) for name in names]
    text = json.dumps([__version__, *params.sources, *values])
    return hashlib.sha256(text.encode()).hexdigest()


def freeze(
    results: Sequence[Result], tables: Sequence[Mapping[str, pa.Table]], refused: Mapping[str, str]
) -> bytes:
    """What is kept of the comparisons of a batch, as a ZIP file of arrays.

    Parameters
    ----------
    tables
        The result tables of each.
    refused
        Recordings that could not be compared, with the reason.
    """
    arrays: list[np.ndarray] = []
    groups = [_kept(*of, arrays) for of in zip(results, tables, strict=True)]
    about = {"refused": dict(refused), "groups": groups, "sizes": [of.nbytes for of in arrays]}
    content = BytesIO()
    with ZipFile(content, "w") as archive:
        archive.writestr(ZipInfo(_ABOUT), json.dumps(about))
        for place, array in enumerate(arrays):
            archive.writestr(ZipInfo(str(place)), pa.compress(array, _CODEC, asbytes=True))
    return content.getvalue()


class Kept:
    """What is kept of a comparison; each value is read when it is asked for."""

    def __init__(self, spec: Mapping[str, Any], arrays: Arrays):
        self._spec, self._arrays = spec, arrays
        self.names: list[str] = spec["names"]
        self.params = params_from(spec["params"])

    def __getitem__(self, name: str) -> Any:
        return _thawed(self._spec["values"][name], self._arrays)

    @cached_property
    def tables(self) -> dict[str, pa.Table]:
        """The result tables, without frames."""
        tables: dict[str, pa.Table] = self["tables"]
        return tables

    def dataset(self, params: ScanParams) -> Dataset:
        """The recordings and frames, without boxes, to be compared as asked."""
        own, tags = self["recordings"], self.tables["recordings"]["tags"].to_pylist()
        columns = {**own, "tags": pd.Series([*map(tuple, tags)], dtype=object).array}
        given, here = params.params, self.params
        return Dataset(
            recordings=conform(columns, RECORDING_DTYPES, n_rows=len(tags)),
            frames=self["frames"],
            boxes=conform({}, DATASET_BOX_DTYPES, n_rows=0),
            systems=(params.x, params.y),
            fingerprint=self["fingerprint"],
            settings=Settings(
                x=params.x,
                y=params.y,
                params=replace(given, threshold_x=here.threshold_x, threshold_y=here.threshold_y),
                objects=objects_from(self["objects"]),
            ),
            each_alone=True,
        )

    def stages(self, *names: str) -> dict[tuple[Any, ...], Any]:
        """Results of steps of these names, all without a name, as `compare` takes them."""
        steps = [(key, of) for key, of in self._spec["steps"] if not names or key[0] in names]
        return {tuple(key): _thawed(of, self._arrays) for key, of in steps}


def thaw(kept: Frozen) -> tuple[list[Kept], dict[str, str]]:
    """What was kept of each comparison, and who was refused.

    Raises
    ------
    InputError
        If nothing was kept there.
    """
    try:
        archive = ZipFile(BytesIO(kept) if isinstance(kept, bytes) else kept)
        about = json.loads(archive.read(_ABOUT))
    except _DAMAGED as error:
        raise InputError(f"what is kept of a batch cannot be read ({error})") from error

    def read(place: int) -> Any:
        try:  # its checksum is looked at, too
            return pa.decompress(archive.read(str(place)), about["sizes"][place], _CODEC)
        except _DAMAGED as error:
            raise InputError(f"what is kept of a batch cannot be read ({error})") from error

    return [Kept(group, read) for group in about["groups"]], about["refused"]


def tables_again(kept: Kept, params: ScanParams) -> dict[str, pa.Table]:
    """The result tables of recordings of which this was kept, by other settings."""
    dataset = kept.dataset(params)
    own = dataset.params_of()
    changed = [name for name in SETTINGS if getattr(own, name) != getattr(kept.params, name)]
    if params.frames or not {SETTINGS[name].stage for name in changed} <= {SIMILARITY, LOW}:
        result = _compare_again(dataset, kept)
        truth = kept.tables["recordings"]["truth"].to_pylist()
        tables = result_tables(result, truth, params.frames)
        result.forget()
        return tables
    # nothing but similarity is another: as of recordings without boxes, whose distances are known
    nobody = np.full(len(dataset.frames), -1)
    known = kept.stages("distances").items()
    stages = {key: replace(distances, salient_row=nobody) for key, distances in known}
    result = compare(dataset, stages=stages)
    tables = {**kept.tables, "intervals": spans_table(result, "intervals")}
    units = each_recording(result)
    for measure in MEASURES:
        if not any(SETTINGS[name].moves(measure.stages) for name in changed):
            continue
        for letter, system in result.sides:
            if measure.by_recording is not None:
                values = measure.by_recording(result, system)
                _replace(tables, f"{measure.key}_{letter}", values)
            if measure.inference is not None and measure.inference.parts is not None:
                parts = measure.inference.parts(result, system)
                assert parts is not None, measure.key
                total = units.total(units.unit_of_frame[parts.frame], parts.value)
                _replace(tables, f"sum_{measure.key}_{letter}", total)
    return tables


def _replace(tables: dict[str, pa.Table], column: str, values: Any) -> None:
    """Other numbers in a column of the recordings."""
    table = tables["recordings"]
    place = table.schema.get_field_index(column)
    cells = pa.array(values, table.schema.field(place).type, from_pandas=True)
    tables["recordings"] = table.set_column(place, table.schema.field(place), cells)


def _compare_again(dataset: Dataset, kept: Kept) -> Result:
    dataset = replace(dataset, boxes=kept["boxes"])
    tracks, encounters = dataset.derived["encounters"] = kept["tracks"], kept["encounters"]
    key = "encounter_classes", dataset.objects, dataset.settings.codes
    dataset.derived[key] = kept["classes"]
    params, frames, stages = dataset.params_of(), dataset.frame_columns, kept.stages()
    memo, at = Memo(params, stages), Inputs(dataset, params, tracks, encounters)
    truth = Made(steps_of("truth", TRUTH_STEPS), at, memo)
    settings = {step.name: step.settings for step in STEPS}
    for number, threshold in enumerate((params.threshold_x, params.threshold_y)):
        owner = number, threshold
        nearest = stages["nearest", *owner, *params.values_for(NEAREST)]

        def measure(number: int = number, nearest: Nearest = nearest) -> SetDistances:
            sizes = kept[f"sizes_{number}"]
            counted, every = _as_boxes(sizes, dataset), np.ones(len(sizes["h"]), bool)
            return measure_sets(
                dataset.truth,
                truth["k_miss"],
                counted,
                weigh_proximity(counted, every, frames, params).k,
                every,
                Nearest(nearest.truth, sizes["most_px"]),
                frames,
                edge_weight=in_use(params, "edge_weight", frames),
                track=tracks.track,
            )

        memo.get(("distances", *owner), measure, settings["distances"])
    return compare(dataset, stages={**stages, **memo.used})


def _kept(
    result: Result, tables: Mapping[str, pa.Table], arrays: list[np.ndarray]
) -> dict[str, Any]:
    dataset, frames = result.dataset, result.dataset.frame_columns
    edge_weight = in_use(result.params, "edge_weight", frames)
    recordings = dataset.recordings
    values: dict[str, Any] = {
        "recordings": {name: recordings[name].to_numpy() for name in recordings if name != "tags"},
        "frames": dataset.frames,
        "fingerprint": dataset.fingerprint,
        "objects": (dataset.objects.singular, dataset.objects.plural),
        "boxes": dataset.boxes.iloc[: len(dataset.truth)].assign(file=0, line=0),
        "tracks": result.tracks,
        "encounters": result.encounters,
        "classes": classes_of(dataset),
        "tables": {name: table for name, table in tables.items() if name != "frames"},
    }
    for number, (_, system) in enumerate(result.sides):
        boxes, is_counted = dataset.system(system.name), system.matches.is_counted
        border_px = border_of(boxes, frames, edge_weight)
        sizes = {
            "h": boxes.y + boxes.h if result.params.proximity == "horizon" else boxes.h,
            "distance_m": boxes.distance_m,
            "frame_index": boxes.frame_index,
            "most_px": np.minimum(border_px, system.nearest.detections),
        }
        values[f"sizes_{number}"] = {name: of[is_counted] for name, of in sizes.items()}
    steps = []
    for key, value in result.stages.items():
        if key[0] in _KEPT:
            if key[0] == "matches":
                value = replace(value, state=np.empty(0, np.int8), det_truth=np.empty(0, np.int64))
            elif key[0] == "nearest":
                value = replace(value, detections=np.empty(0))
            steps.append((key, _frozen(value, arrays)))
    return {
        "names": dataset.recordings["name"].tolist(),
        "params": result.params.given(),
        "values": {name: _frozen(value, arrays) for name, value in values.items()},
        "steps": steps,
    }


def _as_boxes(sizes: Mapping[str, np.ndarray], dataset: Dataset) -> BoxColumns:
    """Boxes of these sizes in the middle of the picture, where the border limits nothing."""
    frames, n = dataset.frame_columns, len(sizes["h"])
    nothing = boxes_of_frame(np.empty((0, 4)), np.empty(0), np.empty(0, np.int32))
    columns = {
        "x": frames.half_width[sizes["frame_index"]],
        "y": np.zeros(n),
        "w": np.zeros(n),
        **{name: sizes[name] for name in ("h", "distance_m", "frame_index")},
    }
    for column in columns.values():  # as a dataset's own: kernels are compiled for one kind
        column.flags.writeable = False
    offsets = offsets_of(sizes["frame_index"], len(frames))
    return replace(nothing, **columns, offsets=offsets)


def _frozen(value: Any, arrays: list[np.ndarray]) -> Any:
    """A value as JSON; arrays are put into the list, and JSON has their places."""
    if isinstance(value, pd.DataFrame):
        return {"table": {name: _frozen(value[name].to_numpy(), arrays) for name in value}}
    if isinstance(value, pa.Table):
        content = pa.BufferOutputStream()
        with pa.ipc.new_stream(content, value.schema) as writer:
            writer.write_table(value)
        arrays.append(np.frombuffer(content.getvalue(), np.uint8))
        return {"arrow": len(arrays) - 1}
    if isinstance(value, dict):
        return {"dict": {name: _frozen(of, arrays) for name, of in value.items()}}
    if isinstance(value, tuple):
        return {"tuple": [_frozen(of, arrays) for of in value]}
    if is_dataclass(value):
        own = {of.name: _frozen(getattr(value, of.name), arrays) for of in fields(value)}
        return {"class": f"{type(value).__module__}:{type(value).__name__}", "fields": own}
    if not isinstance(value, np.ndarray):
        return {"is": value.item() if isinstance(value, np.generic) else value}
    if value.dtype == object:
        codes, texts = pd.factorize(value)
        return {"texts": [*texts], "codes": _frozen(codes, arrays)}
    spec: dict[str, Any] = {"dtype": value.dtype.str, "n": len(value)}
    plain = np.ascontiguousarray(value)
    bits = plain.view(f"u{value.dtype.itemsize}")
    if len(bits) and bits[0] == bits[-1] and (bits == bits[0]).all():
        plain = plain[:1]
    elif value.dtype == np.int64 and np.abs(value).max(initial=0) < 2**31:
        plain = plain.astype(np.int32)
    arrays.append(plain)
    return spec | {
        "stored": plain.dtype.str,
        "stored_n": len(plain),
        "place": len(arrays) - 1,
    }


def _thawed(spec: Mapping[str, Any], arrays: Arrays, *, is_column: bool = False) -> Any:
    """The value of `_frozen`.

    Parameters
    ----------
    is_column
        Whether it becomes a column of a table, which nobody writes to: as it lies then, not copied.
    """
    if "table" in spec:
        items = spec["table"].items()
        columns = {name: _thawed(of, arrays, is_column=True) for name, of in items}
        return pd.DataFrame(columns, copy=False)
    if "arrow" in spec:
        return pa.ipc.open_stream(arrays(spec["arrow"])).read_all()
    if "dict" in spec:
        return {name: _thawed(of, arrays) for name, of in spec["dict"].items()}
    if "tuple" in spec:
        return tuple(_thawed(of, arrays) for of in spec["tuple"])
    if "class" in spec:
        module, _, name = spec["class"].partition(":")
        kind = getattr(import_module(module), name) if module.startswith("nvcore.") else None
        if not is_dataclass(kind) or not isinstance(kind, type):
            raise ValueError(f"{spec['class']} is no result of a step")
        return kind(**{name: _thawed(of, arrays) for name, of in spec["fields"].items()})
    if "is" in spec:
        return spec["is"]
    if "texts" in spec:
        return np.array([*spec["texts"], None], dtype=object)[_thawed(spec["codes"], arrays)]
    stored = np.frombuffer(arrays(spec["place"]), spec["stored"], spec["stored_n"])
    if len(stored) != spec["n"]:
        return np.repeat(stored, spec["n"])
    return stored.astype(spec["dtype"], copy=not is_column)
