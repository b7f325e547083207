"""Hooks of MkDocs: pages from outside docs/, links between them, anchors as on GitHub."""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

PAGES = {
    "README.md": "index.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "THIRD_PARTY.md": "third-party.md",
    "sample_data/README.md": "sample-data.md",
}
"""Pages of the site by their file outside docs/."""

LINK = re.compile(r"\[((?:[^\[\]]|\[[^\]]*\])*)\]\((?![a-z][a-z0-9+.-]*:|#)([^)\s]+)\)")
FENCE = re.compile(r"(^```.*?^```$)", re.DOTALL | re.MULTILINE)


def anchor_of(title: str, _separator: str) -> str:
    """Return the anchor of a heading as GitHub makes it, which the links use."""
    return re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-")


def on_config(config: MkDocsConfig) -> None:
    """Set how anchors are made."""
    config.mdx_configs["toc"]["slugify"] = anchor_of


def on_files(files: Files, config: MkDocsConfig) -> None:
    """Add the pages from outside docs/."""
    root = Path(config.config_file_path).parent
    for source, page in PAGES.items():
        files.append(File.generated(config, page, abs_src_path=str(root / source)))


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Point links to pages of the site; links to other files of the source become plain text."""
    root = Path(config.config_file_path).parent
    here = page.file.src_uri
    sources = {site: source for source, site in PAGES.items()}
    folder = posixpath.dirname(sources.get(here, f"docs/{here}"))

    def point(link: re.Match[str]) -> str:
        path, _, anchor = link[2].partition("#")
        target = posixpath.normpath(posixpath.join(folder, path))
        if target == "docs/decisions":
            target += "/README.md"
        target = PAGES.get(target, target.removeprefix("docs/"))
        if files.get_file_from_path(target) is None:
            return link[1] if (root / folder / path).exists() else link[0]
        target = posixpath.relpath(target, posixpath.dirname(here) or ".")
        return f"[{link[1]}]({target}{'#' * bool(anchor)}{anchor})"

    parts = FENCE.split(markdown)
    parts[::2] = [LINK.sub(point, part) for part in parts[::2]]
    return "".join(parts)
