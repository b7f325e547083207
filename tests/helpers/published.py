"""Log-average miss rates of systems on KAIST, as published and as measured."""

from __future__ import annotations

PUBLISHED = {
    "MBNet": (8.13, 8.28, 7.86),
    "MLPD": (7.58, 7.95, 6.95),
    "GAFF": (6.48, 8.35, 3.46),
}


MEASURED = {  # not published under this protocol: they hold what we found
    "TCDet-thermal": (21.50, 27.65, 9.34),
    "YOLOv3-visible": (27.46, 20.33, 42.13),
}
