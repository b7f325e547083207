"""Keys and layers of the frame viewer in a real browser."""

from __future__ import annotations

import pytest
import viewer_scene as scene
from playwright import sync_api
from viewer_window import painted, press, read, repaint, viewer_of


def test_a_key_switches_a_layer_off_and_on(page):
    for key, name in (("x", "X "), ("y", "Y "), ("g", "Ground truth")):
        button = page.locator(".viewer .legend").get_by_role("button", name=name)
        press(page, key)
        sync_api.expect(button).to_have_attribute("aria-pressed", "false")
        press(page, key)
        sync_api.expect(button).to_have_attribute("aria-pressed", "true")


def test_a_hidden_layer_is_not_drawn(page):
    assert read(page)["box"] is not None
    press(page, "x")
    repaint(page)
    assert read(page)["box"] is None


def test_space_on_a_button_is_the_buttons_own(page):
    page.get_by_role("button", name="Next frame").focus()
    page.keyboard.press(" ")
    assert painted(page, 6) == 6
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")


def test_after_a_click_on_a_button_the_keys_work(page):
    page.get_by_role("button", name="Next frame").click()
    page.keyboard.press("ArrowRight")
    assert painted(page, 7) == 7


def test_keys_work_before_anything_is_clicked(page):
    page.keyboard.press("n")
    assert painted(page, scene.MISSED_BY_X.start) == scene.MISSED_BY_X.start
    page.keyboard.press("ArrowRight")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", str(scene.MISSED_BY_X.start + 1))
    page.keyboard.press(" ")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "true")


def test_a_slider_keeps_its_arrows_and_leaves_letters_to_the_viewer(page):
    slider = page.get_by_role("slider", name="alpha")
    slider.press("ArrowRight")
    sync_api.expect(page.get_by_text("alpha 0.75")).to_be_visible()
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "5")
    slider.press("n")
    assert painted(page, scene.MISSED_BY_X.start) == scene.MISSED_BY_X.start
    sync_api.expect(slider).to_have_value("0.75")


def test_a_button_keeps_its_space(page):
    page.get_by_role("button", name="seek 123").focus()
    page.keyboard.press(" ")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "123")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")


@pytest.mark.parametrize("name", ["hi", "recording"])
def test_keys_that_are_typed_are_not_the_viewer_s(page, name):
    field = page.get_by_role("spinbutton" if name == "hi" else "combobox", name=name)
    field.focus()
    for key in ("n", "x", "f", "ArrowLeft"):
        page.keyboard.press(key)
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "5")
    layer = page.locator(".viewer .layer.x")
    sync_api.expect(layer).to_have_attribute("aria-pressed", "true")


def test_keys_are_left_alone_while_the_picture_is_out_of_sight(page):
    viewer_of(page).evaluate("viewer => { viewer.style.marginTop = '3000px'; }")
    page.keyboard.press("n")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "5")


def test_help_opens_by_key_and_closes_by_escape(page):
    press(page, "?")
    dialog = page.get_by_role("dialog", name="Keys and legend")
    sync_api.expect(dialog).to_contain_text("missed by both")
    page.keyboard.press("Escape")
    sync_api.expect(dialog).to_have_count(0)


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


def test_the_box_of_a_list_is_marked_in_its_frame_alone(page):
    assert not is_marked(page)
    page.get_by_text("list", exact=True).click()
    sync_api.expect(page.get_by_title("Next miss (Shift + n)")).to_be_visible()
    repaint(page)
    assert is_marked(page)
    press(page, "ArrowRight")
    assert painted(page, 6) == 6
    assert not is_marked(page)


def test_while_a_list_is_walked_through_n_and_p_are_the_page_s(page):
    page.get_by_text("list", exact=True).click()
    sync_api.expect(page.get_by_title("Next miss (Shift + n)")).to_be_visible()
    press(page, "n", "p")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "5")
    press(page, "Shift+n")
    assert painted(page, scene.MISSED_BY_X.start) == scene.MISSED_BY_X.start
