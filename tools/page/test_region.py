"""A region that is rendered first: chosen by the pointer and by keys, laid over the picture, and gone when it is not needed."""

import itertools
import json
import re

import numpy
import pytest
from playwright.sync_api import expect

from farm import wait_until
from looks import point_at, screen_color, screen_place, values, wait_for_picture

SIZE = (64, 64)
ENDLESS = 100_000
NUMBERS = itertools.count(1)


@pytest.fixture
def paused(farm):
    """A job with a picture that pauses, so that its numbers stay."""
    job = farm.submit(f"whole {next(NUMBERS)}", passes=ENDLESS, method="path")
    wait_until(lambda: farm.job(job)["passes_done"] >= 40, "there is no picture", 60)
    farm.ask(f"/v1/jobs/{job}/pause", {})
    yield job
    for left in [*regions_of(farm, job), farm.job(job)]:
        if left["state"] in ("running", "paused", "queued"):
            farm.ask(f"/v1/jobs/{left['id']}/cancel", {})


def drag(page, start, end):
    """From the middle of a pixel to that of another."""
    page.mouse.move(*screen_place(page, SIZE, *start))
    page.mouse.down()
    page.mouse.move(*screen_place(page, SIZE, *end), steps=4)
    page.mouse.up()


def regions_of(farm, job):
    begin = f"{farm.job(job)['name']}, region"
    return [job for job in farm.ask("/v1/jobs")["jobs"] if job.get("name", "").startswith(begin)]


def the_region(farm, job):
    (region,) = wait_until(lambda: regions_of(farm, job), "no region was submitted", 10)
    return region


def pixels(farm, job):
    job = farm.job(job)
    numbers = numpy.frombuffer(farm.bytes(f"/v1/jobs/{job['id']}/pixels"), "<f4")
    return numbers.reshape(job["height"], job["width"], 3)


def test_a_region_lies_over_the_picture_while_it_has_more_passes(farm, paused, open_page):
    page = open_page(farm, f"#/jobs/{paused}")
    wait_for_picture(page)
    page.get_by_role("button", name="Region first").click()
    drag(page, (10, 30), (41, 53))
    region = the_region(farm, paused)
    assert region["priority"] == 1000 and region["name"].endswith("region 10,30 32×24")
    assert (region["width"], region["height"], region["method"]) == (32, 24, "path")
    passes = farm.job(paused)["passes_done"]
    wait_until(lambda: farm.job(region["id"])["passes_done"] > passes, "the region gets no further than the picture", 60)
    farm.ask(f"/v1/jobs/{region['id']}/pause", {})
    page.locator("#picture").hover()
    whole, part = pixels(farm, paused), pixels(farm, region["id"])
    for x, y in [(10, 30), (41, 53), (20, 40)]:
        point_at(page, SIZE, x, y)
        expect(page.locator("#readout")).to_contain_text("of the region")
        wait_until(lambda: numpy.allclose([value for _, value in values(page)], part[y - 30, x - 10], rtol=1e-6), "other values", 10)
    for x, y in [(9, 30), (42, 53), (20, 29)]:
        point_at(page, SIZE, x, y)
        expect(page.locator("#readout")).not_to_contain_text("of the region")
        assert [value for _, value in values(page)] == pytest.approx(whole[y, x].tolist(), rel=1e-6)
    assert numpy.mean(part) == pytest.approx(numpy.mean(whole[30:54, 10:42]), rel=0.1), "the same picture in the mean"
    brightest = numpy.unravel_index(numpy.argmax(whole[30:54, 10:42].mean(axis=2)), (24, 32))
    assert part.mean(axis=2)[brightest] > numpy.median(part), "what is where in the picture"
    take_away(page, farm, region["id"])


def take_away(page, farm, region):
    page.get_by_role("button", name="Take away").click()
    wait_until(lambda: farm.job(region)["state"] == "cancelled", "the region goes on", 10)
    expect(page.locator("#region-leave")).to_be_hidden()
    point_at(page, SIZE, 20, 40)
    expect(page.locator("#readout")).not_to_contain_text("of the region")


def test_a_region_is_drawn_with_its_own_pixels_and_a_border(farm, paused, open_page):
    page = open_page(farm, f"#/jobs/{paused}")
    wait_for_picture(page)
    # As if the region were red: what is drawn can then be told from the picture.
    red = numpy.tile(numpy.float32([1, 0, 0]), 16 * 16).tobytes()
    page.route(re.compile("/pixels.*width=16&"), lambda route: route.fulfill(
        body=red, content_type="application/octet-stream", headers={"Photonfarm-Channels": "R,G,B", "Photonfarm-Passes": "1", "ETag": '"red"'}))
    page.keyboard.press("b")
    drag(page, (20, 24), (35, 39))
    region = the_region(farm, paused)
    page.mouse.move(5, 5)
    for x, y in [(20, 24), (35, 24), (20, 39), (35, 39), (28, 30)]:
        wait_until(lambda: screen_color(page, SIZE, x, y) == [255, 0, 0], f"pixel {x}, {y} is not of the region", 60)
    for x, y in [(19, 24), (36, 39), (28, 23), (28, 40)]:
        assert screen_color(page, SIZE, x, y) != [255, 0, 0]
    box, (left, top) = page.locator("#picture").bounding_box(), screen_place(page, SIZE, 19.5, 30)
    border = page.evaluate("""([x, y]) => {
      const canvas = document.getElementById('picture');
      return [...canvas.getContext('2d').getImageData(Math.round(x) - 2, Math.round(y), 4, 1).data];
    }""", [left - box["x"], top - box["y"]])
    assert [255, 255, 255] in [border[at:at + 3] for at in range(0, 16, 4)], border
    take_away(page, farm, region["id"])


def test_a_region_is_made_and_taken_away_by_keys(farm, paused, open_page):
    page = open_page(farm, f"#/jobs/{paused}")
    wait_for_picture(page)
    page.keyboard.press("b")
    expect(page.locator("#region")).to_have_text("Render this region")
    page.keyboard.press("Escape")
    expect(page.locator("#region")).to_have_text("Region first")
    assert not regions_of(farm, paused)
    page.keyboard.press("b")
    page.keyboard.press("Enter")
    region = the_region(farm, paused)
    assert region["height"] == 32, "half of the view"
    expect(page.locator("#region-note")).to_contain_text("Region: pass")
    page.keyboard.press("Escape")
    wait_until(lambda: farm.job(region["id"])["state"] == "cancelled", "the region goes on", 10)
    # A drag moves the picture again.
    drag(page, (20, 20), (40, 40))
    page.wait_for_timeout(300)
    assert len(regions_of(farm, paused)) == 1


def test_regions_of_crop_windows_are_where_they_are_seen(farm, open_page):
    job = farm.submit("window", passes=ENDLESS, method="path", scene_changes={"width": 128, "crop": {"x": 40, "y": 50, "width": 64, "height": 64}})
    page = open_page(farm, f"#/jobs/{job}")
    wait_for_picture(page)
    page.get_by_role("button", name="Region first").click()
    drag(page, (30, 20), (11, 9))
    region = the_region(farm, job)
    assert (region["width"], region["height"]) == (20, 12)
    assert farm.ask(f"/v1/jobs/{region['id']}/layout")["first_pixel"] == [40 + 11, 50 + 9]
    # The whole picture ends, and with it what was to be early.
    farm.ask(f"/v1/jobs/{job}/cancel", {})
    wait_until(lambda: farm.job(region["id"])["state"] == "cancelled", "the region goes on", 10)
    expect(page.locator("#region")).to_be_disabled()


def test_a_region_that_is_done_goes_when_the_whole_picture_is_as_far(farm, open_page):
    job = farm.submit("caught up", passes=1000, method="path")
    wait_until(lambda: farm.job(job)["passes_done"], "there is no picture", 60)
    farm.ask(f"/v1/jobs/{job}/pause", {})
    page = open_page(farm, f"#/jobs/{job}")
    wait_for_picture(page)
    page.get_by_role("button", name="Region first").click()
    drag(page, (30, 30), (37, 37))
    region = the_region(farm, job)
    wait_until(lambda: farm.job(region["id"])["state"] == "done", "the region is not done", 240)
    farm.ask(f"/v1/jobs/{job}/resume", {})
    wait_until(lambda: farm.job(job)["state"] == "done", "the whole picture is not done", 240)
    expect(page.locator("#region-leave")).to_be_hidden()
    assert farm.job(region["id"])["state"] == "done"


def test_a_refusal_is_told(farm, paused, open_page):
    page = open_page(farm, f"#/jobs/{paused}")
    wait_for_picture(page)
    problem = json.dumps({"title": "no", "detail": "There are too many jobs.", "remedy": "Delete some", "status": 429})
    page.route(re.compile("/v1/jobs$"), lambda route: route.fulfill(status=429, body=problem, content_type="application/problem+json"))
    page.keyboard.press("b")
    drag(page, (5, 5), (9, 9))
    expect(page.locator("#region-problem")).to_have_text("There are too many jobs.; Delete some")
    expect(page.locator("#region-leave")).to_be_hidden()
