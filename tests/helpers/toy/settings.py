from __future__ import annotations

from dataclasses import dataclass

from nvcore.settings.stages import Stage, SubjectSettings, setting

LONG = Stage("long encounters", "Toy", result="toy results")


@dataclass(frozen=True)
class ToySettings(SubjectSettings):
    toy_frames: int = setting(
        LONG, 5, low=1, high=100, is_whole=True, label="Toy frames", meaning="Long from so many on."
    )
