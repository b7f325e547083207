"""What is said of files that no reader takes."""

from __future__ import annotations

import json
from pathlib import Path
from time import process_time

import pytest
from reader_files import source

from nvcore.common.errors import FormatError, UnknownFormatError
from nvcore.inputs.readers import detect_format
from nvcore.inputs.readers.base import Role
from nvcore.inputs.readers.parse import unknown

COCO_RESULTS = '[{"image_id": 1, "category_id": 1, "bbox": [1, 2, 3, 4], "score": 0.5}]'


def refusal(folder: Path, content: bytes | str, role: Role = "truth") -> str:
    """What is said of a file of this content."""
    with pytest.raises(UnknownFormatError) as refused:
        detect_format([source(folder, content, "a.file")], role)
    return str(refused.value)


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"\x89PNG\r\n\x1a\n\x00", "a PNG picture"),
        (b"\xff\xd8\xff\xe0\x00", "a JPEG picture"),
        (b"\x00\x00\x00\x20ftypisom", "an MP4 video"),
        (b"RIFF\x10\x00\x00\x00AVI LIST", "an AVI video"),
        (b"PK\x03\x04\x14\x00", "a ZIP archive (or a spreadsheet): unpack it, or save it as CSV"),
        ("frame,x,y,w,h\n".encode("utf-16"), "UTF-16 text: save it as UTF-8"),
        (b"\x89MCAP0\r\n\x01\x00", "an MCAP recording: export its boxes as CSV"),
        (b"\x01\x02\x00\x03", "a binary file"),
    ],
)
def test_a_binary_file_is_named_and_its_bytes_are_not_printed(tmp_path, content, kind):
    assert refusal(tmp_path, content) == f"a.file: expected ground truth, found {kind}"


@pytest.mark.parametrize(
    ("content", "role", "kind"),
    [
        (
            '{"version": "5.0", "shapes": []}',
            "truth",
            'a JSON object with the keys "version", "shapes"; expected a COCO object with '
            "the lists 'images', 'annotations' and 'categories'",
        ),
        (
            '[{"label": "person", "box": [1, 2]}]',
            "detections",
            'a JSON list of objects with the keys "label", "box"; expected a list of COCO',
        ),
        ("{}", "truth", "a JSON object without keys"),
        ("[1]", "truth", "without objects"),
        (json.dumps({f"k{number}": 0 for number in range(11)}), "truth", '"k7" and 3 more; exp'),
    ],
)
def test_json_of_another_kind_is_told_by_its_keys(tmp_path, content, role, kind):
    assert kind in refusal(tmp_path, content, role)


def test_a_large_json_file_is_not_parsed_for_its_keys(tmp_path, monkeypatch):
    monkeypatch.setattr(unknown, "_MAX_JSON_BYTES", 5)
    assert "JSON of another kind; expected" in refusal(tmp_path, '{"version": "5.0"}')


def test_text_that_begins_as_json_and_is_none_is_an_error_with_its_line(tmp_path):
    file = source(tmp_path, '{"version": 1,\n "shapes": [}', "a.json")
    with pytest.raises(FormatError, match=r"a\.json, line 2: expected JSON"):
        detect_format([file], "truth")


def test_xml_of_another_kind_is_told_by_its_root(tmp_path):
    message = refusal(tmp_path, '<?xml version="1.0"?>\n<!-- <a> -->\n<svg width="1"/>')
    assert "it is XML with the root <svg>; expected <annotations> (CVAT)" in message


ENTITIES = '<!DOCTYPE lolz [<!ENTITY lol "lol"><!ENTITY lol1 "&lol;&lol;">]>'


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (f'<?xml version="1.0"?>\n{ENTITIES}<annotations>&lol1;</annotations>', "DTD or entities"),
        ("<annotations>" + "<a>" * 9000, "root <annotations>, without the <track> or <image> of"),
    ],
    ids=["billion laughs", "deep"],
)
def test_an_xml_bomb_is_not_told_that_it_should_be_what_it_is(tmp_path, content, words):
    message = refusal(tmp_path, content)
    assert words in message
    assert "expected <annotations>" not in message


def test_results_given_as_ground_truth_are_called_so(tmp_path):
    message = refusal(tmp_path, COCO_RESULTS)
    assert "expected ground truth, found COCO results, which holds the detections of" in message


def test_ground_truth_given_as_results_is_called_so(tmp_path):
    message = refusal(tmp_path, "% bbGt version=3\nperson 1 2 20 50 0 0 0 0 0 0 0\n", "detections")
    assert "expected the detections of a system, found " in message
    assert message.endswith("which holds ground truth")


@pytest.mark.parametrize("key", ["samples", "shapes", "detections", "imgHeight", "imagename"])
def test_a_key_that_stands_there_thousands_of_times_takes_no_time(key):
    start = process_time()
    assert unknown.foreign_format("{" + f'"{key}": [' * 5000) is None
    assert process_time() - start < 1
