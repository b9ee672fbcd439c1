"""The pictures of docs/PAGE.md, written when they are asked for by --screenshots."""

import json
import re

from playwright.sync_api import expect

from farm import ROOT, Farm
from looks import open_job, point_at, screen_place, wait_for_picture
from test_sequences import LAMP

SCENES = ["cornell-diffuse", "cornell-glass-mirror", "cornell-ward", "mirror-box", "scene5", "door-ajar", "table-and-spheres"]
NAMES = ["box, all matt", "glass and mirror", "brushed metal", "mirrors", "caustics", "door ajar", "two spheres"]


def test_screenshots(program, browser, open_page, picture_folder):
    farm = Farm(program)
    try:
        jobs = fill(farm)
        context = browser.new_context(viewport={"width": 1600, "height": 900}, color_scheme="dark")
        page = open_page(farm, "", context.new_page())

        def save(name):
            page.mouse.move(5, 5) if name in ("list", "sequences", "submit", "workers") else None
            page.wait_for_timeout(900)
            page.screenshot(path=picture_folder / f"{name}.png")

        show_pictures(page, farm, jobs, save)
        farm.ask(f"/v1/sequences/{jobs['flight']}/resume", {})
        page.goto(f"{farm.address}/#/sequences")
        expect(page.locator("#sequences")).to_contain_text(re.compile(r"\b[5-9] of 24 frames"), timeout=90000)
        save("sequences")
        page.goto(f"{farm.address}/#/workers")
        save("workers")
        page.goto(f"{farm.address}/#/submit")
        page.locator("#scene-file").set_input_files(ROOT / "scenes/cornell-diffuse/scene.xml")
        form = page.locator("#submit-form")
        form.get_by_label("Method", exact=True).select_option("sppm")
        form.get_by_label("Error (relMSE)").fill("0.01")
        page.locator("#check").click()
        expect(page.locator(".good")).to_be_visible()
        save("submit")
        phone = browser.new_context(viewport={"width": 390, "height": 844}, device_scale_factor=2, color_scheme="light")
        page = open_page(farm, f"#/jobs/{jobs['glass and mirror']}", phone.new_page())
        wait_for_picture(page)
        save("phone")
    finally:
        farm.stop()
    sizes = {file.name: file.stat().st_size for file in picture_folder.glob("*.png")}
    assert len(sizes) == 11 and max(sizes.values()) < 400_000, sizes


def fill(farm):
    farm.start_worker()
    jobs = {}
    for scene, name in zip(SCENES, NAMES):
        path = ROOT / f"scenes/{scene}/scene.xml"
        jobs[name] = farm.submit(name, passes=24, size=160, scene=path, tags=["dailies"])
    glass = ROOT / "scenes/cornell-glass-mirror/scene.xml"
    jobs["second"] = farm.submit("glass and mirror, vcm", passes=24, size=160, method="vcm", scene=glass, tags=["dailies"])
    paths = json.loads((ROOT / "scenes/rooms/user-paths.json").read_text())[:6]
    rooms = {"scene": ROOT / "scenes/rooms", "parameters": {"user_paths": paths}}
    jobs["rooms"] = farm.submit("rooms, with paths", passes=48, size=104, method="mlt", tags=["dailies"], **rooms)
    jobs["running"] = farm.submit("box to an error", size=176, stop={"error": 0.0002}, tags=["night"])
    farm.wait(jobs["second"])
    for job in jobs.values():
        if job != jobs["running"]:
            farm.wait(job)
    flight = {"scene_inline": LAMP, "name": "flight", "stop": {"passes": 100}, "scene_changes": {"width": 256}}
    jobs["flight"] = farm.ask("/v1/sequences", {"job": flight, "frames": {"first": 1, "last": 24}})["id"]
    farm.ask(f"/v1/sequences/{jobs['flight']}/pause", {})
    return jobs


def show_pictures(page, farm, jobs, save):
    open_job(page, farm, jobs["running"])
    wait_for_picture(page)
    page.locator("#tab-charts").click()
    page.wait_for_timeout(5000)
    save("running")
    page.locator("#tab-look").click()
    page.emulate_media(color_scheme="light")
    page.locator("#state-filter").select_option("ended")
    open_job(page, farm, jobs["two spheres"])
    wait_for_picture(page)
    save("list")
    page.emulate_media(color_scheme="dark")
    page.locator("#state-filter").select_option("all")
    open_job(page, farm, jobs["glass and mirror"])
    wait_for_picture(page)
    page.get_by_text("Error", exact=True).click()
    page.wait_for_timeout(800)
    save("finished")
    page.get_by_text("Denoised", exact=True).click()
    expect(page.locator("#picture")).to_have_attribute("aria-label", re.compile("layer denoised$"))
    wait_for_picture(page)
    page.mouse.move(*screen_place(page, (160, 160), 60, 120))
    save("denoised")
    page.get_by_text("Color", exact=True).click()
    wait_for_picture(page)
    page.mouse.move(*screen_place(page, (160, 160), 73, 112))
    for _ in range(14):
        page.mouse.wheel(0, -170)
    save("pixels")
    page.keyboard.press("f")
    page.locator("#tab-compare").click()
    page.locator("#other").select_option(jobs["second"])
    expect(page.locator("#errors")).to_contain_text("relMSE")
    point_at(page, (160, 160), 60, 120)
    save("comparison")
    show_paths(page, farm, jobs["rooms"])
    save("paths")


def show_paths(page, farm, job):
    open_job(page, farm, job)
    wait_for_picture(page)
    page.locator("#tab-paths").click()
    page.locator("#path-3-2-place").fill("-1.975, 1.2, -0.6")
    page.locator("#path-3-2-place").press("Tab")
    page.locator("#paths-check").click()
    page.get_by_text("Refused:").scroll_into_view_if_needed()
