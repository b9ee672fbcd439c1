"""Sequences: submitted with the form, shown frame by frame, paused, resumed, cancelled and deleted as one."""

import re

from playwright.sync_api import expect

from farm import wait_until

# A lamp on its way.
LAMP = """<scene version="3.0.0"><integrator type="path"/>
  <sensor type="perspective"><float name="fov" value="60"/>
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="18"/></film></sensor>
  <shape type="sphere"><emitter type="area"/><animation name="to_world">
    <transform time="0"><translate x="-2" z="5"/></transform><transform time="1"><translate x="2" z="5"/></transform>
  </animation></shape>
</scene>"""


def lamp(farm, name, last, passes, **further):
    job = {"scene_inline": LAMP, "name": name, "stop": {"passes": passes}}
    return farm.ask("/v1/sequences", {"job": job, "frames": {"first": 1, "last": last}, **further})["id"]


def card(page, name):
    return page.get_by_role("article", name=name)


def test_a_sequence_is_submitted_and_shown_frame_by_frame(own_farm, open_page, tmp_path):
    own_farm.start_worker()
    page = open_page(own_farm, "#/submit")
    expect(page.locator("#farm")).to_contain_text("1 worker")
    scene = tmp_path / "lamp.xml"
    scene.write_text(LAMP)
    page.locator("#scene-file").set_input_files(scene)
    page.get_by_label("Frames", exact=True).fill("1-5")
    page.get_by_label("Passes").fill("3")
    page.locator("#submit").click()
    shown = card(page, "lamp")
    expect(shown).to_contain_text("5 of 5 frames, 100 %", timeout=30000)
    expect(shown.locator(".state")).to_have_text("done")
    frames = shown.get_by_role("list", name="Frames").get_by_role("link")
    expect(frames).to_have_text(["1", "2", "3", "4", "5"])
    expect(frames.nth(2)).to_have_accessible_name("Frame 3: done")
    expect(page.get_by_role("link", name="Sequences")).to_have_attribute("aria-current", "page")
    frames.nth(2).click()
    expect(page.locator("#job-name")).to_have_text("lamp.0003")
    page.locator("#tab-details").click()
    sequence = own_farm.ask("/v1/sequences")["sequences"][0]
    expect(page.locator("#panel-details")).to_contain_text(f"3 of {sequence['id']}")
    # All of its frames are found by its id.
    own_farm.submit("a still")
    page.locator("#text-filter").fill(sequence["id"])
    expect(page.locator("#list-count")).to_contain_text("5 of 6")


def test_all_frames_are_paused_resumed_cancelled_and_deleted_at_once(own_farm, open_page):
    sequence = lamp(own_farm, "film", 40, 1000000)
    wait_until(lambda: len(own_farm.ask("/v1/jobs")["jobs"]) == 2, "the second frame is not made")
    page = open_page(own_farm, "#/sequences")
    shown = card(page, "film")
    expect(shown).to_contain_text("0 of 40 frames")
    expect(shown.get_by_role("link")).to_have_count(2)
    frames = shown.get_by_role("list", name="Frames")
    expect(frames.get_by_role("listitem")).to_have_count(40)
    shown.get_by_role("button", name="Pause").focus()
    page.keyboard.press("Enter")
    expect(shown.locator(".state")).to_have_text("paused")
    # Who works by keys stays where they are.
    expect(shown.get_by_role("button", name="Resume")).to_be_focused()
    assert [job["state"] for job in own_farm.ask("/v1/jobs")["jobs"]] == ["paused"] * 2
    page.keyboard.press("Enter")
    expect(shown.locator(".state")).to_have_text("running")
    shown.get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Cancel the sequence").click()
    expect(shown.locator(".state")).to_have_text("cancelled")
    expect(shown.get_by_role("link").first).to_have_attribute("title", re.compile("cancelled$"))
    expect(shown.get_by_role("button", name="Cancel")).to_have_count(0)
    shown.get_by_role("button", name="Delete").click()
    page.get_by_role("button", name="Delete the sequence").click()
    expect(shown).to_have_count(0)
    expect(page.locator("#sequences-title")).to_be_focused()
    expect(page.locator("#no-sequences")).to_be_visible()
    assert own_farm.ask("/v1/jobs")["jobs"] == []
    assert own_farm.ask("/v1/sequences")["sequences"] == []
    assert sequence.startswith("seq-")


def test_what_the_coordinator_refuses_is_told(own_farm, open_page, tmp_path):
    page = open_page(own_farm, "#/submit")
    expect(page.locator("#farm")).to_contain_text("0 workers")
    scene = tmp_path / "still.xml"
    scene.write_text(re.sub("<animation.*</animation>", "", LAMP, flags=re.DOTALL))
    page.locator("#scene-file").set_input_files(scene)
    page.get_by_label("Frames", exact=True).fill("1-5")
    page.locator("#submit").click()
    expect(page.locator("#check-answer")).to_contain_text("Nothing in the scene moves")
    expect(page.locator("#check-answer")).to_contain_text("Remedy: give key frames")


def test_what_fits_no_sequence_is_told_before_anything_is_sent(own_farm, open_page, tmp_path):
    page = open_page(own_farm, "#/submit")
    expect(page.locator("#farm")).to_contain_text("0 workers")
    scene = tmp_path / "lamp.xml"
    scene.write_text(LAMP)
    page.locator("#scene-file").set_input_files(scene)
    page.get_by_label("Camera path").fill("0, 0")
    for button in ("#check", "#submit"):
        page.locator(button).click()
        expect(page.locator("#check-answer")).to_contain_text("no frames are given")
    page.get_by_label("Frames", exact=True).fill("5-1")
    page.locator("#check").click()
    expect(page.locator("#check-answer")).to_contain_text("1, is before the first one, 5")
    page.get_by_label("Frames", exact=True).fill("1-5")
    page.locator("#check").click()
    expect(page.locator("#check-answer")).to_contain_text("1 to 5")
    assert own_farm.ask("/v1/jobs")["jobs"] == []
