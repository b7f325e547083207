"""The Driver page in a real browser: a region of the diagram lists its encounters."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from app_server import ROOT, serve
from app_visit import Visit
from playwright.sync_api import BrowserContext, expect

N_FRAMES = 30
# Place in the plot's area of the region of that name.
REGION = """(plot, name) => {
  const { _fullData: [regions], _fullLayout: { xaxis, yaxis } } = plot;
  const at = regions.customdata.indexOf(name);
  return [xaxis.d2p(regions.x[at]), yaxis.d2p(regions.y[at])];
}"""


def boxes(x: int, last: str) -> str:
    lines = (f"night,{frame},{x + frame},200,40,120,{last}\n" for frame in range(N_FRAMES))
    return "".join(lines)


@pytest.fixture
def address(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The app with two pedestrians: the driver sees the first, X detects both, Y the first."""
    head = "recording,frame,x,y,w,h,"
    truth = boxes(100, "1,0.8") + boxes(300, "2,0.2")
    (tmp_path / "truth.csv").write_text(f"{head}track,detectability\n{truth}")
    (tmp_path / "x.csv").write_text(f"{head}score\n{boxes(100, '0.9')}{boxes(300, '0.9')}")
    (tmp_path / "y.csv").write_text(f"{head}score\n{boxes(100, '0.9')}")
    (tmp_path / "session.toml").write_text(
        f'[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:{N_FRAMES - 1}"\n'
        '[truth]\npath = "truth.csv"\n'
        '[[system]]\nname = "one"\npath = "x.csv"\n[[system]]\nname = "two"\npath = "y.csv"\n'
    )
    monkeypatch.setenv("NVCORE_SESSION", str(tmp_path / "session.toml"))
    with serve(ROOT / "app.py") as url:
        yield url


def test_a_region_of_the_diagram_lists_its_encounters(address: str, person: BrowserContext):
    one = Visit(person, address)
    one.go("driver")
    expect(one.heading("Driver", level=1)).to_be_visible()
    expect(one.heading("Pedestrian 2 of night")).to_be_visible()  # the least detectable
    one.click_plot("driver_venn", REGION, "driver_x_y")
    expect(one.heading("Pedestrian 1 of night")).to_be_visible()
    assert one.accessibility_faults() == []
    assert one.complaints == []
    one.close()
