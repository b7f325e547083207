"""Introductions to the sections on the inputs and the settings."""

from __future__ import annotations

from nvcore.report.html.blocks import Intro

AUDIT = Intro(
    what="What is wrong or suspicious in the input files. An error makes measures wrong until it "
    "is mended, a warning may, a note is good to know.",
    limits="Mistakes of the people who annotated are not found by it.",
)

INPUTS = Intro(
    what="What was read, and how it was converted, so that the comparison can be repeated and "
    "files can be told apart.",
    how="The SHA-256 of a file changes with every change of its content. The fingerprint stands "
    "for all files, how they were read, and the evaluated frames.",
)

PARAMETERS = Intro(
    what="Every setting of the analysis, with its value here. Whoever sets the same values and "
    "has the same files gets the same numbers.",
)
