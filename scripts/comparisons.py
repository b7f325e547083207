"""The comparisons that `scripts/same_results.py` runs: their session files and systems."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

Range = tuple[float, float]


@dataclass(frozen=True)
class System:
    """A system of a comparison: the path of its session file, and the range of its scores."""

    path: str
    scores: Range = (0.0, 1.0)


@dataclass(frozen=True)
class Comparison:
    """Inputs that are compared.

    Attributes
    ----------
    name
        For the table and `--only`.
    systems
        Systems by name; the first two are compared, under random settings any two.
    head
        The session file without its systems; None: the sample's own session.
    """

    name: str
    systems: dict[str, System]
    head: str | None

    def session(self, realdata: Path) -> str | None:
        """Text of the session file; None: the sample's own is used."""
        if self.head is None:
            return None
        tables = [
            f'[[system]]\nname = "{name}"\npath = "{system.path}"'
            for name, system in self.systems.items()
        ]
        return "\n".join([self.head.strip(), *tables, ""]).replace("{realdata}", str(realdata))


MOT15 = """
[[recording]]
name = "TUD-Campus"
pictures = "{realdata}/videos/TUD-Campus.mp4"
[[recording]]
name = "TUD-Stadtmitte"
pictures = "{realdata}/videos/TUD-Stadtmitte.mp4"
[[recording]]
name = "PETS09-S2L1"
pictures = "{realdata}/videos/vtest.avi"
[[recording]]
name = "ETH-Sunnyday"
[truth]
path = "{realdata}/mot15"
"""

# 16 recordings, the sets from set09 by night
KAIST_SETS = {"set06": 5, "set07": 3, "set08": 3, "set09": 1, "set10": 2, "set11": 2}
KAIST = "\n".join(
    [
        *(
            f'[[recording]]\nname = "{name}/V{index:03}"\n'
            f'tags = ["{"day" if name < "set09" else "night"}"]'
            for name, count in KAIST_SETS.items()
            for index in range(count)
        ),
        '[defaults]\nfps = 20\n[protocol]\nname = "kaist-reasonable"',
        '[truth]\npath = "{realdata}/kaist/KAIST_annotation.json"',
    ]
)

KITTI = """
[[recording]]
name = "0016"
width = 1224
height = 370
fps = 10
pictures = "{realdata}/kitti_tracking/images"
[parameters]
proximity = "distance"
[truth]
path = "{realdata}/kitti_tracking/label_02/0016.txt"
"""

NIGHT = """
[[recording]]
name = "night"
width = 640
height = 512
fps = 20
pictures = "{realdata}/kaist_night_video/set09_V000_I02330-I03499_lwir.mp4"
[truth]
path = "{realdata}/kaist_night_video/gt.csv"
"""

COMPARISONS = (
    Comparison("sample", {"FIR": System("fir.csv"), "NIR": System("nir.csv")}, None),
    Comparison(
        "mot15",
        {
            "Faster R-CNN": System("{realdata}/mot15/*/det_frcnn/det.txt", (0.5, 1.0)),
            "tracker": System("{realdata}/mot15/*/res_devkit/*.txt"),
        },
        MOT15,
    ),
    Comparison(
        "kaist",
        {
            name: System(f"{{realdata}}/kaist/results/{name}_result.txt")
            for name in ("MLPD", "MBNet", "GAFF", "TCDet-thermal", "YOLOv3-visible")
        },
        KAIST,
    ),
    Comparison(
        "kitti-0016",
        {
            "RRC": System("{realdata}/kitti_tracking/rrc_ped/0016.txt"),
            "PointRCNN": System("{realdata}/kitti_tracking/pointrcnn_ped/0016.txt", (-0.9, 8.6)),
        },
        KITTI,
    ),
    Comparison(
        "night-video",
        {
            name: System(f"{{realdata}}/kaist_night_video/detections/{name}.csv")
            for name in ("TCDet-thermal", "YOLOv3-visible", "MLPD", "MBNet")
        },
        NIGHT,
    ),
)
