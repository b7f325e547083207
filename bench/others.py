"""Run one other tool on one set, in the tool's own environment.

    python -m bench.others TOOL SET.npz [--repeat 3]

Each tool scores both systems against the truth at one IoU, 0.5. The time is what its user waits for
after the files are parsed and the tool's own objects are made (COCO objects with their index,
per-frame arrays). Making them is timed separately as `prepare_s`. If a tool can be told to do less
(one area range, one limit of detections), it is.
"""

from __future__ import annotations

import argparse
import contextlib
import io
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from bench.measure import measure, report, versions
from bench.sets import HEIGHT, WIDTH, Boxes, BoxSet, load_set

IOU = 0.5
Work = Callable[[], list[dict[str, float]]]


def _coco_truth(boxes: BoxSet) -> dict[str, Any]:
    """Return the truth as COCO's dictionary. Image numbers are the frames' plus 1."""
    g = boxes.truth
    corner = np.column_stack([g.x, g.y, g.w, g.h]).tolist()
    image = (g.frame_index + 1).tolist()
    return {
        "images": [
            {"id": i + 1, "width": WIDTH, "height": HEIGHT, "file_name": f"{i:07d}.jpg"}
            for i in range(boxes.n_frames)
        ],
        "categories": [{"id": 1, "name": "person"}],
        "annotations": [  # numbered from 1, because 0 means "unmatched" to COCO tools
            {"id": i + 1, "image_id": image[i], "category_id": 1, "bbox": box,
             "area": box[2] * box[3], "iscrowd": 0}
            for i, box in enumerate(corner)
        ],
    }  # fmt: skip


def _coco_detections(s: Boxes) -> list[dict[str, Any]]:
    corner = np.column_stack([s.x, s.y, s.w, s.h]).tolist()
    columns = zip((s.frame_index + 1).tolist(), corner, s.score.tolist(), strict=True)
    return [
        {"image_id": image, "category_id": 1, "bbox": box, "score": score}
        for image, box, score in columns
    ]


def _hotcoco(boxes: BoxSet, *, compare: bool) -> Work:
    import hotcoco

    truth = hotcoco.COCO(_coco_truth(boxes))
    results = [truth.load_res(_coco_detections(s)) for s in boxes.systems]

    def work() -> list[dict[str, float]]:
        evaluations = []
        for result in results:
            evaluation = hotcoco.COCOeval(truth, result, "bbox")
            evaluation.params.iou_thrs = [IOU]
            evaluation.params.area_rng = [[0.0, 1e10]]
            evaluation.params.area_rng_lbl = ["all"]
            evaluation.params.max_dets = [100]
            evaluation.evaluate()
            evaluation.accumulate()
            evaluations.append(evaluation)
        if compare:
            hotcoco.compare(*evaluations, n_bootstrap=0)
        return [{"recall": float(np.max(e.eval["recall"]))} for e in evaluations]

    return work


def _ultrafast(boxes: BoxSet) -> Work:
    from ultrafast_pycocotools import COCO, COCOeval

    return _like_pycocotools(boxes, COCO, COCOeval)


def _vernier(boxes: BoxSet) -> Work:
    """Prepare Vernier with COCO's four area ranges, which its `COCOeval` always evaluates."""
    from pycocotools.coco import COCO
    from vernier import COCOeval

    truth = COCO()
    truth.dataset = _coco_truth(boxes)
    truth.createIndex()
    results = [truth.loadRes(_coco_detections(s)) for s in boxes.systems]

    def work() -> list[dict[str, float]]:
        recalls = []
        for result in results:
            evaluation = COCOeval(truth, result, iouType="bbox")
            evaluation.params.iouThrs = np.array([IOU])
            evaluation.params.maxDets = [100]
            evaluation.evaluate()
            evaluation.accumulate()
            recalls.append({"recall": float(np.max(evaluation.eval["recall"][:, :, 0]))})
        return recalls

    return work


def _faster_coco_eval(boxes: BoxSet) -> Work:
    from faster_coco_eval import COCO, COCOeval_faster

    return _like_pycocotools(boxes, COCO, COCOeval_faster)


def _like_pycocotools(boxes: BoxSet, coco: Any, evaluator: Any) -> Work:
    """Prepare a package with classes like those of pycocotools, which can be silenced."""
    truth = coco(_coco_truth(boxes))
    results = [truth.loadRes(_coco_detections(s)) for s in boxes.systems]

    def work() -> list[dict[str, float]]:
        recalls = []
        for result in results:
            evaluation = evaluator(truth, result, "bbox", print_function=lambda *_: None)
            evaluation.params.iouThrs = np.array([IOU])
            evaluation.params.areaRng = [[0.0, 1e10]]
            evaluation.params.areaRngLbl = ["all"]
            evaluation.params.maxDets = [100]
            evaluation.evaluate()
            evaluation.accumulate()
            recalls.append({"recall": float(np.max(evaluation.eval["recall"]))})
        return recalls

    return work


def _per_frame(boxes: BoxSet) -> list[list[tuple[np.ndarray, np.ndarray]]]:
    """Return per-frame corners (n, 4) and per-recording track ids of truth and systems."""
    ends = np.cumsum(boxes.lengths)
    sources = []
    for source in (boxes.truth, *boxes.systems):
        offsets = source.offsets(boxes.n_frames)
        corner = np.column_stack([source.x, source.y, source.w, source.h])
        track = np.empty(len(source), np.int64)
        for first, last in zip(ends - boxes.lengths, ends, strict=True):
            rows = slice(offsets[first], offsets[last])
            track[rows] = np.unique(source.track[rows], return_inverse=True)[1]
        sources.append(
            list(zip(np.split(corner, offsets[1:-1]), np.split(track, offsets[1:-1]), strict=True))
        )
    return sources


def _trackeval(boxes: BoxSet) -> Work:
    from trackeval.datasets._base_dataset import _BaseDataset
    from trackeval.metrics import CLEAR

    ends = np.cumsum(boxes.lengths)
    truth, *systems = _per_frame(boxes)
    metric = CLEAR({"THRESHOLD": IOU, "PRINT_CONFIG": False})

    def work() -> list[dict[str, float]]:
        figures = []
        for system in systems:
            recordings = {}
            for first, last in zip(ends - boxes.lengths, ends, strict=True):
                gt, dets = truth[first:last], system[first:last]
                similarity = [
                    _BaseDataset._calculate_box_ious(g, d)  # called by TrackEval's readers
                    for (g, _), (d, _) in zip(gt, dets, strict=True)
                ]
                recordings[str(first)] = metric.eval_sequence(
                    {
                        "num_timesteps": last - first,
                        "num_gt_dets": sum(len(ids) for _, ids in gt),
                        "num_tracker_dets": sum(len(ids) for _, ids in dets),
                        "num_gt_ids": 1 + max(ids.max() for _, ids in gt if len(ids)),
                        "num_tracker_ids": 1 + max(ids.max() for _, ids in dets if len(ids)),
                        "gt_ids": [ids for _, ids in gt],
                        "tracker_ids": [ids for _, ids in dets],
                        "similarity_scores": similarity,
                    }
                )
            combined = metric.combine_sequences(recordings)
            figures.append({"matched": int(combined["CLR_TP"])})
        return figures

    return work


def _motmetrics(boxes: BoxSet) -> Work:
    import motmetrics

    ends = np.cumsum(boxes.lengths)
    truth, *systems = _per_frame(boxes)
    measures = ["num_frames", "mota", "motp", "num_matches", "num_switches", "num_objects"]

    def work() -> list[dict[str, float]]:
        figures = []
        for system in systems:
            accumulators = []  # one per recording, because a long one grows quadratically
            for first, last in zip(ends - boxes.lengths, ends, strict=True):
                accumulator = motmetrics.MOTAccumulator(auto_id=True)
                for (g, g_ids), (d, d_ids) in zip(
                    truth[first:last], system[first:last], strict=True
                ):
                    apart = motmetrics.distances.iou_matrix(g, d, max_iou=1 - IOU)
                    accumulator.update(g_ids, d_ids, apart)
                accumulators.append(accumulator)
            summary = motmetrics.metrics.create().compute_many(
                accumulators, metrics=measures, generate_overall=True
            )
            overall = summary.loc["OVERALL"]
            figures.append({"matched": int(overall["num_matches"] + overall["num_switches"])})
        return figures

    return work


TOOLS: dict[str, tuple[Callable[[BoxSet], Work], tuple[str, ...]]] = {
    "hotcoco": (lambda boxes: _hotcoco(boxes, compare=False), ("hotcoco", "numpy")),
    "hotcoco compare": (lambda boxes: _hotcoco(boxes, compare=True), ("hotcoco", "numpy")),
    "faster-coco-eval": (_faster_coco_eval, ("faster-coco-eval", "numpy")),
    "ultrafast-pycocotools": (_ultrafast, ("ultrafast-pycocotools", "numpy")),
    "vernier": (_vernier, ("vernier", "pycocotools", "numpy")),
    "TrackEval CLEAR": (_trackeval, ("trackeval", "numpy", "scipy")),
    "motmetrics": (_motmetrics, ("motmetrics", "numpy", "pandas")),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tool", choices=sorted(TOOLS))
    parser.add_argument("set", type=Path)
    parser.add_argument("--repeat", type=int, default=3)
    options = parser.parse_args()
    prepare, packages = TOOLS[options.tool]
    boxes = load_set(options.set)
    start = perf_counter()
    with contextlib.redirect_stdout(io.StringIO()):
        work = prepare(boxes)
        prepare_s = perf_counter() - start
        figures, seconds, peak_mb = measure(work, options.repeat)
    report(
        seconds=seconds,
        peak_mb=peak_mb,
        prepare_s=prepare_s,
        check=figures,
        versions=versions(*packages),
    )


if __name__ == "__main__":
    main()
