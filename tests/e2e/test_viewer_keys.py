"""Keys and layers of the frame viewer in a real browser."""

from __future__ import annotations

import viewer_scene as scene
from playwright import sync_api
from viewer_window import painted, press, read, repaint, viewer_of

FIRST_MISS = scene.MISSED_BY_X.start


def test_a_key_switches_a_layer_off_and_on_and_another_opens_the_legend(page):
    assert read(page)["box"] is not None
    for key, name in (("y", "Y "), ("g", "Ground truth"), ("x", "X ")):
        button = page.locator(".viewer .legend").get_by_role("button", name=name)
        press(page, key)
        sync_api.expect(button).to_have_attribute("aria-pressed", "false")
        repaint(page)
        assert (read(page)["box"] is None) == (key == "x")
        press(page, key)
        sync_api.expect(button).to_have_attribute("aria-pressed", "true")

    press(page, "?")
    dialog = page.get_by_role("dialog", name="Keys and legend")
    sync_api.expect(dialog).to_contain_text("missed by both")
    page.keyboard.press("Escape")
    sync_api.expect(dialog).to_have_count(0)


def test_keys_are_the_viewer_s_unless_what_is_focused_needs_them(page):
    keys = page.keyboard
    is_playing = "data-playing"

    # before anything is clicked
    keys.press("n")
    assert painted(page, FIRST_MISS) == FIRST_MISS
    keys.press("ArrowRight")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", str(FIRST_MISS + 1))
    for state in ("true", "false"):
        keys.press(" ")
        sync_api.expect(viewer_of(page)).to_have_attribute(is_playing, state)
    press(page, "Home")
    assert painted(page, 0) == 0

    # after a click on a button, too; its space is its own
    page.get_by_role("button", name="Next frame").click()
    keys.press("ArrowRight")
    assert painted(page, 2) == 2
    page.get_by_role("button", name="Next frame").focus()
    keys.press(" ")
    assert painted(page, 3) == 3
    sync_api.expect(viewer_of(page)).to_have_attribute(is_playing, "false")

    # a slider keeps its arrows and leaves letters to the viewer
    slider = page.get_by_role("slider", name="alpha")
    slider.press("ArrowRight")
    sync_api.expect(page.get_by_text("alpha 0.75")).to_be_visible()
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "3")
    slider.press("n")
    assert painted(page, FIRST_MISS) == FIRST_MISS
    sync_api.expect(slider).to_have_value("0.75")

    # what is typed into a field is the field's
    for field in (
        page.get_by_role("spinbutton", name="hi"),
        page.get_by_role("combobox", name="recording"),
    ):
        field.focus()
        for key in ("n", "x", "f", "ArrowLeft"):
            keys.press(key)
        sync_api.expect(viewer_of(page)).to_have_attribute("data-row", str(FIRST_MISS))
        layer = page.locator(".viewer .layer.x")
        sync_api.expect(layer).to_have_attribute("aria-pressed", "true")
    keys.press("Escape")

    # a button of the page keeps its space
    page.get_by_role("button", name="seek 123").focus()
    keys.press(" ")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "123")
    sync_api.expect(viewer_of(page)).to_have_attribute(is_playing, "false")

    # while the picture is out of sight keys are left alone
    viewer_of(page).evaluate("viewer => { viewer.style.marginTop = '3000px'; }")
    keys.press("n")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "123")


YELLOW = """(viewer, [left, y, right]) => {
  const canvas = viewer.querySelector("canvas.picture");
  const scale = Math.min(canvas.width / 640, canvas.height / 480);
  const x0 = (canvas.width - 640 * scale) / 2, y0 = (canvas.height - 480 * scale) / 2;
  const { data } = canvas.getContext("2d")
    .getImageData(x0 + left * scale, y0 + y * scale, (right - left) * scale, 1);
  for (let i = 0; i < data.length; i += 4) {
    if (data[i] > 230 && data[i + 1] > 190 && data[i + 2] < 110) return true;
  }
  return false;
}"""


def is_marked(page) -> bool:
    """Whether there is a yellow line left of the listed box, half way down."""
    x, y, _, h = scene.LISTED
    return viewer_of(page).evaluate(YELLOW, [x - 30, y + h / 2, x])


def test_the_box_of_a_list_is_marked_in_its_frame_alone_and_n_and_p_are_the_page_s(page):
    assert not is_marked(page)
    page.get_by_text("list", exact=True).click()
    sync_api.expect(page.get_by_title("Next miss (Shift + n)")).to_be_visible()
    repaint(page)
    assert is_marked(page)
    press(page, "n", "p")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "5")
    press(page, "ArrowRight")
    assert painted(page, 6) == 6
    assert not is_marked(page)
    press(page, "Shift+n")
    assert painted(page, FIRST_MISS) == FIRST_MISS
