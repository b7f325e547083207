"""What the browser is sent to compute with while a slider moves."""

from __future__ import annotations

from dataclasses import replace

from places import SAMPLE

import nvcore as nv
from nvcore.comparison.compare import compare
from ui.session.packed_comparison import pack_comparison, version_of


def test_it_does_not_depend_on_what_the_browser_changes():
    base = compare(nv.load(SAMPLE))
    moved = replace(base.params, alpha=0.5, midpoint=70.0, threshold_x=0.7, low=0.8)
    other = compare(base.dataset, moved)
    assert version_of(other) == version_of(base)
    assert pack_comparison(other) == pack_comparison(base)
    strict = compare(base.dataset, replace(base.params, match="lateral"))
    assert version_of(strict) != version_of(base)
    assert pack_comparison(strict) != pack_comparison(base)
