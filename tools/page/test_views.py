"""Workers, charts, details and history; what the page loads, and whether its files are all served."""

import json
import re
import urllib.request

import pytest
from playwright.sync_api import expect

from farm import ROOT, Hand, wait_until
from looks import open_job, wait_for_picture

FOLDER = ROOT / "src/api/dashboard"
# A path of SVG that goes somewhere.
LINE = re.compile("M.*L")
FILES = sorted(path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*") if path.is_file() and path.name != "page.html")


@pytest.mark.parametrize("path", FILES)
def test_every_file_is_served_as_what_it_is(farm, path):
    with urllib.request.urlopen(f"{farm.address}/{path}") as answer:
        assert answer.read() == (FOLDER / path).read_bytes()
        kind = {"js": "text/javascript", "css": "text/css", "svg": "image/svg+xml"}[path.rsplit(".", 1)[1]]
        assert answer.headers["Content-Type"].startswith(kind)


def test_workers_are_told_as_they_come_and_go(own_farm, open_page):
    page = open_page(own_farm, "#/workers")
    expect(page.locator("#workers-summary")).to_contain_text("No worker is connected")
    own_farm.start_worker()
    rows = page.locator("#workers-rows tr")
    expect(rows).to_have_count(1)
    expect(rows).to_contain_text("idle")
    own_farm.submit("work", passes=100_000, size=32)
    expect(rows).to_contain_text("working")
    expect(rows.locator("td").nth(3)).not_to_have_text("0")
    expect(page.locator("#workers-summary")).to_contain_text("1 worker, 1 thread: 1 working")
    rate = rows.locator("td").nth(4)
    wait_until(lambda: rate.inner_text() not in ("–", "0"), "no speed")
    page.reload()
    expect(page.locator("#farm-journal")).to_contain_text("joined")


def test_what_went_wrong_is_told_and_a_worker_is_sent_away(own_farm, open_page):
    hand = Hand(own_farm, "clumsy")
    job = own_farm.submit("work", passes=100_000, size=32)
    hand.fail("out of photons")
    own_farm.start_worker()
    page = open_page(own_farm, "#/workers")
    rows = page.locator("#workers-rows tr")
    expect(rows).to_have_count(2)
    clumsy, other = (page.locator("#workers-rows tr", has=page.get_by_role("rowheader", name=name)) for name in ("clumsy", "worker"))
    expect(clumsy).to_contain_text(f"pilot of job {job}: out of photons")
    expect(other).to_contain_text("working")
    other.get_by_role("button", name="Send away").click()
    page.get_by_role("dialog").get_by_role("button", name="Send away").click()
    expect(rows).to_have_count(1, timeout=20000)
    assert own_farm.workers[0].wait(10) == 0
    expect(page.locator("#workers-summary")).to_contain_text("1 worker")


def test_charts_draw_the_history(farm, open_page):
    job = farm.submit("charted", passes=100_000, size=32, stop={"passes": 100_000, "error": 1e-7})
    page = open_page(farm, f"#/jobs/{job}")
    page.locator("#tab-charts").click()
    error = page.get_by_role("img", name="Error over time")
    expect(error.locator("path.bound")).to_have_attribute("d", LINE, timeout=20000)
    expect(error.locator("line.goal")).to_have_count(1)
    for name in ("Speed over time", "Workers over time"):
        expect(page.get_by_role("img", name=name).locator("path")).to_have_attribute("d", LINE, timeout=20000)
    farm.ask(f"/v1/jobs/{job}/cancel", {})
    points = farm.ask(f"/v1/jobs/{job}/history")["points"]
    last = farm.wait(job, "cancelled")["estimated_error"]
    assert all(before["seconds"] < after["seconds"] for before, after in zip(points, points[1:]))
    assert [points[-1][name] for name in ("passes", "relmse", "bound")] == [last[name] for name in ("passes", "relmse", "bound")]


def test_details_and_history_are_of_the_job(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    page.locator("#tab-details").click()
    for text in (farm.done, "64 × 64", "4 passes", "photons_per_pass"):
        expect(page.locator("#panel-details")).to_contain_text(text)
    page.locator("#tab-journal").click()
    lines = farm.ask(f"/v1/journal?job={farm.done}")["lines"]
    expect(page.locator("#panel-journal tr")).to_have_count(len(lines))
    if lines:
        expect(page.locator("#panel-journal")).to_contain_text(lines[-1]["text"])
    # The arrow keys go from tab to tab.
    page.locator("#tab-journal").press("ArrowRight")
    expect(page.locator("#panel-look")).to_be_visible()


def test_notices_stand_in_plain_sight(own_farm, open_page):
    job = own_farm.submit("nobody works")
    wait_until(lambda: own_farm.job(job)["notices"], "the job has no notice")
    page = open_page(own_farm, f"#/jobs/{job}")
    expect(page.locator("#job-notices")).to_contain_text("No worker is connected")
    expect(page.locator("#job-reason")).to_contain_text("It waits for workers since")


def test_a_shared_address_opens_the_job_and_back_goes_back(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    expect(page.locator("#job-name")).to_have_text("amber")
    open_job(page, farm, farm.other)
    expect(page.locator("#job-name")).to_have_text("birch")
    page.go_back()
    expect(page.locator("#job-name")).to_have_text("amber")


def test_a_watched_picture_costs_little(farm, context, open_page):
    """What a page takes while a job runs stays within its budget, and an ended job's picture is not asked for again."""
    taken = []
    context.on("response", lambda answer: taken.append(int(answer.headers.get("content-length", 0))) if "/pixels?layer" in answer.url else None)
    job = farm.submit("watched", passes=100_000, size=512)
    page = open_page(farm, f"#/jobs/{job}")
    expect(page.locator("#picture-passes")).to_contain_text("as of pass", timeout=30000)
    page.wait_for_timeout(2000)
    taken.clear()
    page.wait_for_timeout(6000)
    assert sum(taken) < 2e6 * 6, json.dumps(taken)
    open_job(page, farm, farm.done)
    wait_for_picture(page)
    farm.ask(f"/v1/jobs/{job}/cancel", {})
    page.wait_for_timeout(500)
    taken.clear()
    page.wait_for_timeout(2000)
    assert taken == []
