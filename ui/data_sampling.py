"""What rates per minute and per hour leave out where not every frame is evaluated."""

from __future__ import annotations

from nvcore.dataset import FrameColumns
from nvcore.frame_lists import nth


def sampling_note(frames: FrameColumns) -> str:
    """A sentence for beside a rate per minute or hour; empty where every frame is evaluated."""
    steps = [round(float(step)) for step in frames.sampling_step]
    sampled = sorted({step for step in steps if step > 1})
    if not sampled:
        return ""
    which = nth(sampled[0])
    if len(sampled) > 1:
        which += f" to {nth(sampled[-1])}"
    n_sampled = sum(step > 1 for step in steps)
    where = "" if n_sampled == len(steps) else f" of {n_sampled:,} of {len(steps):,} recordings"
    return (
        f"Only every {which} frame{where} is evaluated: per minute and per hour count those frames "
        "alone."
    )
