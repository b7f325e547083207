"""The section of the report on detection curves."""

from __future__ import annotations

from builders import Box, make_dataset, result_of

from nvcore.protocols import PROTOCOLS
from nvcore.report.html.blocks import Chart, Section
from nvcore.report.html.evidence_sections import detection_section


def section_of(*, x_score: float = 0.9) -> Section:
    truth = [Box(frame, 10, 10, 20, 50) for frame in range(20)]
    truth.append(Box(0, 60, 10, 20, 50, ignore=True))
    x = [box._replace(score=x_score) for box in truth]
    y = [box._replace(score=0.8) for box in truth[:5]]
    return detection_section(result_of(make_dataset(truth, x, y)), PROTOCOLS["all"])


def test_a_log_average_of_0_and_few_pedestrians_are_explained_and_no_click_is_asked_for():
    section = section_of()
    text = " ".join(section.blocks[0].texts)
    assert "Log-average miss rate of X: nobody is missed at any of the 9 references." in text
    assert "Log-average miss rate of Y: there is no false positive" in text
    assert "Few pedestrians: 20, a single miss changes" in text
    assert "20 pedestrians in 20 images count; 1 ignored: flagged in the ground truth 1." in text
    figure = next(block for block in section.blocks if isinstance(block, Chart)).figure
    assert "thresholds in use; lower is better" in figure.layout.title.text


def test_a_system_without_scores_is_called_a_point():
    section = section_of(x_score=float("nan"))
    figure = next(block for block in section.blocks if isinstance(block, Chart)).figure
    assert figure.data[0].name == "X: x, no scores: a point"
    text = " ".join(section.blocks[0].texts)
    assert "X has no averages and no areas (detections have no score" in text
