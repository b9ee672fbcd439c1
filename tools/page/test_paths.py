"""Paths of light: made by clicks, by the list and by keys, drawn, refused with the segment, rendered, and compared."""

import struct

import pytest
from playwright.sync_api import expect

from farm import ROOT, wait_until
from looks import screen_color, screen_place, wait_for_picture

SIZE = (64, 64)
ROOMS = ROOT / "scenes/rooms"
# Of the path that is chosen, and of a segment that was refused.
CHOSEN, REFUSED = [255, 209, 102], [255, 92, 73]


@pytest.fixture(scope="module")
def lamplit(farm):
    """A job by a method that takes paths, in a box with one lamp."""
    job = farm.submit("lamplit", passes=2, method="mlt", parameters={"mutations": 1})
    farm.wait(job)
    return job


def open_paths(page):
    wait_for_picture(page)
    page.locator("#tab-paths").click()
    expect(page.locator("#path-light")).to_contain_text("area")


def place_at(farm, job, x, y):
    return struct.unpack("<3f", farm.bytes(f"/v1/jobs/{job}/pixels?layer=position&x={x}&y={y}&width=1&height=1"))


def shown_place(page, path, point):
    return [float(number) for number in page.locator(f"#path-{path}-{point}-place").input_value().split(",")]


def is_drawn(page, color, x, y):
    """Whether the disc of a point is at a pixel: beside its middle, where its number stands."""
    drawn = screen_color(page, SIZE, x - 0.45, y)
    return all(abs(one - other) < 3 for one, other in zip(drawn, color))


def test_a_path_is_made_by_the_list_and_by_clicks_and_drawn(farm, lamplit, open_page):
    page = open_page(farm, f"#/jobs/{lamplit}")
    open_paths(page)
    expect(page.locator("#path-light option")).to_have_text("1: lamp (area)")
    page.locator("#path-start").click()
    expect(page.locator("#paths > li")).to_have_count(1)
    expect(page.locator("#paths-render")).to_be_disabled()
    for point, pixel in enumerate([(25, 60), (6, 40)], 1):
        page.mouse.click(*screen_place(page, SIZE, *pixel))
        expect(page.locator(f"#path-0-{point}-place")).to_be_visible()
        assert shown_place(page, 0, point) == pytest.approx(place_at(farm, lamplit, *pixel), rel=1e-3, abs=1e-4)
        wait_until(lambda: is_drawn(page, CHOSEN, *pixel), f"point {point} is not drawn", 5)
    assert page.locator(".panel").evaluate("panel => panel.scrollWidth <= panel.clientWidth")
    # Dragging moves the picture and makes no point.
    at = screen_place(page, SIZE, 30, 30)
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] + 40, at[1])
    page.mouse.up()
    page.wait_for_timeout(500)
    expect(page.locator("#path-0-3-place")).to_have_count(0)
    page.get_by_role("button", name="Remove point 2 of path 1").click()
    expect(page.locator("#path-0-2-place")).to_have_count(0)
    assert shown_place(page, 0, 1) == pytest.approx(place_at(farm, lamplit, 6, 40), rel=1e-3, abs=1e-4)
    page.get_by_role("button", name="Remove path 1").click()
    expect(page.locator("#paths > li")).to_have_count(0)


def test_a_click_on_a_lamps_mark_starts_a_path(farm, lamplit, open_page):
    page = open_page(farm, f"#/jobs/{lamplit}")
    open_paths(page)
    layout = farm.ask(f"/v1/jobs/{lamplit}/layout")
    point, matrix = layout["lights"][0]["points"][0] + [1], layout["world_to_ndc"]
    x, y, _, w = [sum(point[row] * matrix[4 * row + column] for row in range(4)) for column in range(4)]
    page.mouse.click(*screen_place(page, SIZE, 64 * x / w - 0.5, 64 * y / w - 0.5))
    expect(page.locator("#paths .path-point")).to_contain_text("lamp")


def test_paths_are_rendered_and_the_noise_is_compared(farm, lamplit, open_page):
    page = open_page(farm, f"#/jobs/{lamplit}")
    open_paths(page)
    page.locator("#path-start").click()
    page.mouse.click(*screen_place(page, SIZE, 25, 60))
    page.locator("#path-0-1-cone").fill("12")
    page.locator("#path-0-1-cone").press("Tab")
    page.locator("#paths-check").click()
    expect(page.locator("#paths-note")).to_have_text("All paths can be taken.")
    page.locator("#paths-render").click()
    expect(page.locator("#paths-made-text")).to_contain_text("lamplit, mlt with 1 path")
    (made,) = [job for job in farm.ask("/v1/jobs?name=lamplit%2C%20mlt%20with%201%20path")["jobs"]]
    (path,) = made["parameters"]["user_paths"]
    assert made["method"] == "mlt" and path["cones"] == [12]
    assert path["points"][1] == pytest.approx(place_at(farm, lamplit, 25, 60), rel=1e-5)
    farm.wait(made["id"])
    page.locator("#paths-compare").click()
    expect(page.locator("#job-name")).to_have_text("lamplit, mlt with 1 path")
    expect(page.locator("#other")).to_have_value(lamplit)
    expect(page.get_by_role("radio", name="Difference")).to_be_checked()
    expect(page.locator("#errors")).to_contain_text("RMSE")
    for name in ("lamplit", "lamplit, mlt with 1 path"):
        expect(page.get_by_role("rowheader", name=f"Noise of {name}", exact=True)).to_be_visible()
    # The paths of a job that has some are there again.
    page.reload()
    open_paths(page)
    assert shown_place(page, 0, 1) == pytest.approx(path["points"][1], rel=1e-3)
    expect(page.locator("#path-0-1-cone")).to_have_value("12")


def test_a_job_by_another_method_is_rendered_with_and_without(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.other}")
    open_paths(page)
    page.locator("#path-start").click()
    page.mouse.click(*screen_place(page, SIZE, 25, 60))
    page.locator("#paths-method").select_option("mps")
    expect(page.locator("#paths-twin")).to_contain_text("without paths is rendered, too")
    page.locator("#paths-render").click()
    expect(page.locator("#paths-made-text")).to_contain_text("Without: birch, mps without paths")
    jobs = {job["name"]: job for job in farm.ask("/v1/jobs")["jobs"]}
    with_paths, without = jobs["birch, mps with 1 path"], jobs["birch, mps without paths"]
    assert (with_paths["method"], without["method"]) == ("mps", "mps")
    assert len(with_paths["parameters"]["user_paths"]) == 1 and not without["parameters"]["user_paths"]
    for job in (with_paths, without):
        farm.ask(f"/v1/jobs/{job['id']}/cancel", {})


def test_a_refusal_stands_beside_its_segment(farm, lamplit, open_page):
    page = open_page(farm, f"#/jobs/{lamplit}")
    open_paths(page)
    page.locator("#path-start").click()
    page.mouse.click(*screen_place(page, SIZE, 25, 60))
    expect(page.locator("#path-0-1-place")).to_be_visible()
    page.locator("#path-start").click()
    page.mouse.click(*screen_place(page, SIZE, 6, 40))
    expect(page.locator("#path-1-1-place")).to_be_visible()
    # Under the tall block.
    page.locator("#path-1-1-place").fill("-0.42, -1, -0.38")
    page.locator("#path-1-1-place").press("Tab")
    page.locator("#paths-render").click()
    point = page.locator("#paths > li").nth(1).locator("ol > li").nth(1)
    expect(point.get_by_role("alert")).to_contain_text("segment 1 passes a surface")
    page.locator("#path-1-1-place").fill("nowhere")
    page.locator("#path-1-1-place").press("Tab")
    assert page.locator("#path-1-1-place").evaluate("field => field.validity.customError")
    page.locator("#path-1-0-place").fill("0 0 0")
    page.locator("#path-1-0-place").press("Tab")
    expect(point.get_by_role("alert")).to_have_count(0)
    page.locator("#paths-check").click()
    first = page.locator("#paths > li").nth(1).locator("ol > li").nth(0)
    expect(first.get_by_role("alert")).to_contain_text("it starts at no lamp; the nearest is at")


def test_a_path_is_made_by_keys_alone(farm, lamplit, open_page):
    page = open_page(farm, f"#/jobs/{lamplit}")
    wait_for_picture(page)
    page.locator("#tab-look").focus()
    for panel in ("#panel-compare", "#panel-paths"):
        page.keyboard.press("ArrowRight")
        expect(page.locator(panel)).to_be_visible()
    expect(page.locator("#path-light option")).to_have_text("1: lamp (area)")
    page.keyboard.press("Tab")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator("#paths > li")).to_have_count(1)
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(page.locator("#paths-note")).to_contain_text("Point 2 of path 1 is at")
    assert shown_place(page, 0, 1) == pytest.approx(place_at(farm, lamplit, 32, 32), rel=1e-3, abs=1e-4)


def test_lamps_out_of_view_are_in_the_list(farm, open_page):
    job = farm.submit("rooms", passes=1, method="path", scene=ROOMS)
    farm.wait(job)
    page = open_page(farm, f"#/jobs/{job}")
    open_paths(page)
    expect(page.locator("#path-light option")).to_have_count(6)
    page.locator("#path-light").select_option(label="4: lamp-3 (area)")
    page.locator("#path-start").click()
    x, y, z = shown_place(page, 0, 0)
    assert abs(x) <= 0.31 and y == pytest.approx(2.49, abs=1e-3) and abs(z + 4) <= 0.31
