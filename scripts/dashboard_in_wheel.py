"""Puts the dashboard into the wheel, as data of the package: what `nvcore app` starts.

Not as packages of their own: at the top of site-packages `ui`, `pages` and `app` would be in
everybody's way. ``streamlit run`` puts the folder of its script on the path, so that they import
each other as they do here. An editable installation takes them from the checkout.
"""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PARTS = (
    *("app.py", "pages", "ui", "sample_data", ".streamlit/config.toml", "docs/*.md"),
    "docs/images/time-to-contact.png",  # the others are of the README
)
TARGET = Path("nvcore", "dashboard")


class DashboardInWheel(BuildHookInterface):  # type: ignore[type-arg]
    """Adds the files of the dashboard; hatchling leaves compiled modules out."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the files, unless the installation is editable."""
        if version == "editable":
            return
        root = Path(self.root)
        for path in (path for part in PARTS for path in root.glob(part)):
            build_data["force_include"][str(path)] = str(TARGET / path.relative_to(root))
