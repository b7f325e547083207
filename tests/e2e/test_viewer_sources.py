"""A recording with two pictures, its own and visible light, in the viewer in a real browser."""

from __future__ import annotations

from playwright import sync_api
from viewer_window import choose, painted, press, viewer_of

# Colour of the picture where nothing is drawn over it, high in it, at this share of its width.
COLOUR = """(viewer, across) => {
  const canvas = viewer.querySelector("canvas.picture");
  const [x, y] = [across * canvas.width, 0.3 * canvas.height];
  const [red, green, blue] = canvas.getContext("2d").getImageData(x, y, 1, 1).data;
  if (red - blue > 150) return "red";
  if (blue - red > 150) return "blue";
  if (red - blue > 40) return "reddish";
  return Math.max(red, green, blue) - Math.min(red, green, blue) < 20 ? "grey" : "other";
}"""
IS_COLOURED = f"([viewer, across, colour]) => ({COLOUR})(viewer, across) === colour"


def colour(page: sync_api.Page, across: float) -> str:
    """Of a place high in the picture, at a share of its width."""
    name: str = viewer_of(page).evaluate(COLOUR, across)
    return name


def becomes(page: sync_api.Page, name: str) -> None:
    """Wait for a picture of this colour, where Python may hear of it before it is loaded."""
    page.wait_for_function(IS_COLOURED, arg=[viewer_of(page).element_handle(), 0.4, name])


def shown(page: sync_api.Page, picture: str) -> None:
    """Wait until this is how the pictures are painted."""
    sync_api.expect(viewer_of(page)).to_have_attribute("data-picture", picture)


def told(page: sync_api.Page, look: str) -> None:
    """Wait until Python has heard of the choice."""
    page.get_by_text(f"look Look({look})", exact=True).wait_for()


def choose_two_pictures(page: sync_api.Page, recording: str = "two pictures") -> None:
    """Choose them, and wait: until then keys go to the recording chosen before, which has one."""
    choose(page, recording)
    sync_api.expect(page.get_by_role("group", name="Pictures")).to_be_visible()
    assert painted(page, 5) == 5


def test_pictures_are_changed_by_key_and_as_the_driver_sees_them_is_said_to_be_a_model(page):
    # a recording with one picture has no choice
    sync_api.expect(page.get_by_role("group", name="Pictures")).to_have_count(0)
    press(page, "v", "d")
    shown(page, "own")

    # a key goes through own, visible, blended and side by side
    choose_two_pictures(page)
    sync_api.expect(page.get_by_role("combobox", name="Picture")).to_have_value("own")
    assert colour(page, 0.4) == "grey"
    press(page, "v")
    shown(page, "visible")
    assert colour(page, 0.4) == "red"
    told(page, "picture='visible', blend=0.5, seen_s=None")
    press(page, "v")
    shown(page, "blended")
    assert colour(page, 0.4) == "reddish"
    press(page, "v")
    shown(page, "both")
    assert (colour(page, 0.3), colour(page, 0.7)) == ("grey", "red")
    told(page, "picture='both', blend=0.5, seen_s=None")
    press(page, "v")
    shown(page, "own")

    # as the driver sees it is visible light from another address, and a model
    said = page.locator(".stage").get_by_text("model, not measured", exact=True)
    sync_api.expect(said).not_to_be_visible()
    press(page, "d")
    shown(page, "visible")
    told(page, "picture='visible', blend=0.5, seen_s='clock'")
    assert colour(page, 0.4) == "blue"
    sync_api.expect(said).to_be_visible()
    page.get_by_role("button", name="As the driver sees it").click()
    told(page, "picture='visible', blend=0.5, seen_s=None")
    becomes(page, "red")
    press(page, "d", "v", "v")
    shown(page, "both")
    middle = viewer_of(page).bounding_box()["width"] / 2
    assert said.bounding_box()["x"] > middle  # over visible light, not over the other picture
    press(page, "d")
    sync_api.expect(said).not_to_be_visible()


def test_after_a_simulated_change_of_light_the_time_runs_with_the_frames(page):
    choose_two_pictures(page)
    press(page, "d")
    told(page, "picture='visible', blend=0.5, seen_s='clock'")
    button = page.get_by_role("button", name="A tunnel ends here")
    button.click()
    page.get_by_text("simulated: 0.05 s after the change", exact=True).wait_for()
    press(page, "Shift+ArrowRight")
    assert painted(page, 25) == 25
    page.get_by_text("simulated: 1.05 s after the change", exact=True).wait_for()
    assert colour(page, 0.4) == "blue"
    press(page, "Home")
    assert painted(page, 0) == 0
    page.get_by_text("before the change", exact=True).wait_for()
    assert colour(page, 0.4) == "red"
    button.click()
    # where the light is not known only a time that is set is kept
    page.get_by_role("slider", name="Seconds since").fill("1.5")
    told(page, "picture='visible', blend=0.5, seen_s=1.5")


def test_the_recordings_own_light_is_followed_unless_a_time_is_set_by_hand(page):
    choose_two_pictures(page, "light known")
    press(page, "d")
    told(page, "picture='visible', blend=0.5, seen_s='clock'")
    page.get_by_text("eyes adapted", exact=True).wait_for()
    shown(page, "visible")
    assert colour(page, 0.4) == "red"
    press(page, "Shift+ArrowRight")
    assert painted(page, 25) == 25
    page.get_by_text("0.80 s after the change", exact=True).wait_for()
    assert colour(page, 0.4) == "blue"
    sync_api.expect(page.get_by_role("slider", name="Seconds since")).not_to_be_visible()
    # a change simulated before the real one ends with it; where nothing is known, that is said
    press(page, "Home")
    page.get_by_text("change of light not known", exact=True).wait_for()
    tunnel = page.get_by_role("button", name="A tunnel ends here")
    tunnel.click()
    page.get_by_text("simulated: 0.05 s after the change", exact=True).wait_for()
    press(page, *["ArrowRight"] * 4)
    page.get_by_text("simulated: 0.25 s after the change", exact=True).wait_for()
    press(page, "ArrowRight")  # it was dark for a moment between this row and the next
    page.get_by_text("eyes adapted", exact=True).wait_for()
    press(page, "Shift+ArrowRight")
    page.get_by_text("0.80 s after the change", exact=True).wait_for()
    press(page, "End")  # the light is back: neither of them is left
    page.get_by_text("eyes adapted", exact=True).wait_for()
    tunnel.click()
    page.get_by_role("button", name="By hand").click()
    sync_api.expect(page.get_by_role("slider", name="Seconds since")).to_be_visible()
    told(page, "picture='visible', blend=0.5, seen_s=0.5")
