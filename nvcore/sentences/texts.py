"""Templates of facts, by type and kind."""

from __future__ import annotations

from collections.abc import Mapping

from nvcore.notes import Fact

Texts = Mapping[type[Fact], str | Mapping[str, str]]
