"""Build hook that puts the dashboard, as started by `nvcore app`, into the wheel as package data.

The folders are no packages of their own: at the top of site-packages, `ui`, `pages` and `app` would
collide with other packages. ``streamlit run`` puts the script's folder on the path, so that imports
work as in the checkout. An editable installation uses the checkout. The folder in
``$NVCORE_MACHINE_CODE``, filled by `machine_code.py`, is added too.
"""

import os
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PARTS = (
    *("app.py", "pages", "ui", "sample_data", ".streamlit/config.toml", "docs/*.md"),
    "docs/images/time-to-contact.png",  # the other images belong to the README
)
TARGET = Path("nvcore", "dashboard")
MACHINE_CODE = Path("nvcore", "metrics", "kernels", "machine_code")


class DashboardInWheel(BuildHookInterface):  # type: ignore[type-arg]
    """Add the files of the dashboard, since hatchling omits compiled modules."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """List the files unless the installation is editable."""
        if version == "editable":
            return
        root = Path(self.root)
        for path in (path for part in PARTS for path in root.glob(part)):
            build_data["force_include"][str(path)] = str(TARGET / path.relative_to(root))
        if folder := os.environ.get("NVCORE_MACHINE_CODE"):
            build_data["force_include"][str(Path(folder).resolve(strict=True))] = str(MACHINE_CODE)
