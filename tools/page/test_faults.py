"""Faults that users found in the page before: each must not come back."""

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

from looks import has_picture, open_job, row, wait_for_picture


def test_a_picture_is_of_the_job_that_is_shown(farm, open_page):
    waiting = farm.submit_paused("waiting")
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    row(page, waiting).click()
    expect(page.locator("#job-name")).to_have_text("waiting")
    expect(page.locator("#picture-note")).to_contain_text("No pass is merged yet")
    assert not has_picture(page)
    row(page, farm.done).click()
    wait_for_picture(page)


def test_b_a_coordinator_that_is_away_is_told_and_one_that_forgot_is_believed(own_farm, open_page):
    job = own_farm.submit("lost")
    page = open_page(own_farm, f"#/jobs/{job}")
    expect(page.locator("#job-name")).to_have_text("lost")
    expect(page.locator("#action-cancel")).to_be_visible()
    expect(page.locator("#action-cancel")).to_be_enabled()
    own_farm.stop_coordinator()
    expect(page.locator("#away")).to_contain_text("does not answer since")
    expect(page.locator("#action-cancel")).to_be_disabled()
    own_farm.start()
    expect(page.locator("#away")).to_be_hidden(timeout=15000)
    expect(row(page, job)).to_have_count(0)
    expect(page.locator("#job")).to_be_hidden()
    expect(page.locator("#no-job-text")).to_contain_text(f"There is no job {job} here")
    again = own_farm.submit("found")
    expect(row(page, again)).to_contain_text("found")


def test_c_many_tabs_share_one_stream(farm, context, open_page):
    pages = [open_page(farm) for _ in range(8)]
    for page in pages:
        expect(row(page, farm.done)).to_be_visible()
    answers = "() => fetch('/v1/limits', { cache: 'no-store', signal: AbortSignal.timeout(4000) }).then(answer => answer.status)"
    assert [page.evaluate(answers) for page in pages] == [200] * 8
    # The tab that came first leads nobody.
    pages[0].close()
    new = farm.submit_paused("seen by all")
    for page in pages[1:]:
        expect(row(page, new)).to_contain_text("paused")


def test_d_a_job_that_stops_by_error_tells_its_error_against_the_goal(farm, open_page):
    job = farm.submit("precise", stop={"error": 0.0001}, size=32)
    page = open_page(farm, f"#/jobs/{job}")
    for text in (row(page, job).locator(".reached"), page.locator("#job-reached")):
        expect(text).to_contain_text("goal 0.0001")
        expect(text).to_contain_text("error below 0.0", timeout=20000)
        assert "∞" not in text.inner_text()
    bound = farm.job(job)["estimated_error"]["bound"]
    assert 0.2 < page.evaluate("document.getElementById('job-bar').value") < 1, bound
    farm.ask(f"/v1/jobs/{job}/cancel", {})
    timed = farm.submit("timed", stop={"seconds": 100000, "error": 1e-7}, size=32)
    open_job(page, farm, timed)
    expect(page.locator("#job-left")).to_contain_text("left")
    farm.ask(f"/v1/jobs/{timed}/cancel", {})


def test_e_no_icon_of_a_broken_picture_is_shown(farm, open_page):
    waiting = farm.submit_paused("still nothing")
    page = open_page(farm, f"#/jobs/{waiting}")
    expect(page.locator("#picture-note")).to_be_visible()
    assert page.evaluate("[...document.images].filter(image => !image.naturalWidth).length") == 0
    assert not has_picture(page)


SIZES = [(360, 740), (768, 1024), (1024, 700), (1600, 900), (1920, 1080), (3840, 2160)]


def test_f_every_window_is_used_and_nothing_is_cut_off(farm, browser, open_page):
    for width, height in SIZES:
        for scheme in ("light", "dark"):
            context = browser.new_context(viewport={"width": width, "height": height}, color_scheme=scheme)
            page = open_page(farm, f"#/jobs/{farm.done}", context.new_page())
            wait_for_picture(page)
            check_layout(page, width, height)
            ground = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/[0-9.]+/g).slice(0, 3).map(Number)")
            assert (sum(ground) > 600) == (scheme == "light"), (scheme, ground)
            context.close()


def check_layout(page, width, height):
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    overflowing = page.evaluate("""() => [...document.querySelectorAll('.job, .job-head, .panel, .jobs, .stage-bar, .top, main')]
        .filter(box => box.scrollWidth > box.clientWidth + 1).map(box => box.className || box.tagName)""")
    assert overflowing == [], (width, overflowing)
    picture = page.locator("#picture").bounding_box()
    assert picture["x"] >= 0 and picture["x"] + picture["width"] <= width + 1
    assert picture["height"] > 0.35 * height, (width, picture)
    # The parts stand beside each other without a gap.
    shown = page.evaluate("""() => ['.jobs', '.stage', '.panel'].map(name => document.querySelector(name).getBoundingClientRect())
        .filter(box => box.width > 0).map(box => [box.left, box.right])""")
    assert min(left for left, _ in shown) <= 1 and max(right for _, right in shown) >= width - 1, shown
    assert picture["width"] > (0.4 if width > 1000 else 0.5) * width, (width, picture)


def test_g_assistive_technology_finds_everything(farm, browser, open_page):
    for scheme in ("dark", "light"):
        context = browser.new_context(viewport={"width": 1600, "height": 900}, color_scheme=scheme)
        page = open_page(farm, f"#/jobs/{farm.done}", context.new_page())
        wait_for_picture(page)
        for tab in ("look", "compare", "paths", "charts", "details", "journal"):
            page.locator(f"#tab-{tab}").click()
            assert_accessible(page, f"{scheme} {tab}")
        for view in ("submit", "workers"):
            page.goto(f"{farm.address}/#/{view}")
            page.locator(f"#{view}-view").wait_for()
            assert_accessible(page, f"{scheme} {view}")
        context.close()


def assert_accessible(page, where):
    found = Axe().run(page).response["violations"]
    told = [(where, fault["id"], [node["html"][:120] for node in fault["nodes"]][:3]) for fault in found]
    assert told == []


def test_g_the_keyboard_reaches_everything_and_shows_where_it_is(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    reached, focus = set(), "document.activeElement.id || document.activeElement.textContent.trim()"
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.add(page.evaluate(focus))
        outline = page.evaluate("""() => {
          const holder = document.activeElement.closest('label') ?? document.activeElement;
          return [document.activeElement, holder].some(element => getComputedStyle(element).outlineStyle !== 'none');
        }""")
        assert outline or page.evaluate("document.activeElement === document.body"), page.evaluate(focus)
    wanted = {"list", "text-filter", "state-filter", "order", "action-clone", "action-delete", "link-exr", "picture", "zoom-fit", "tab-look",
              "exposure", "curve"}
    assert wanted <= reached, wanted - reached
    page.locator("#list").focus()
    page.keyboard.press("Home")
    page.keyboard.press("End")
    last = page.evaluate("location.hash")
    page.keyboard.press("ArrowUp")
    assert page.evaluate("location.hash") != last
    assert page.locator("#list").get_attribute("aria-activedescendant").startswith("job-")


def test_g_a_change_of_state_is_announced(farm, open_page):
    job = farm.submit_paused("told")
    page = open_page(farm, f"#/jobs/{job}")
    expect(page.locator("#announcement")).to_contain_text("told: paused")
    farm.ask(f"/v1/jobs/{job}/cancel", {})
    expect(page.locator("#announcement")).to_contain_text("told: cancelled")


def test_h_cancel_and_delete_ask_first(farm, open_page):
    job = farm.submit_paused("asked")
    page = open_page(farm, f"#/jobs/{job}")
    page.locator("#action-cancel").click()
    expect(page.get_by_role("dialog", name="Cancel asked?")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_have_count(0)
    assert farm.job(job)["state"] == "paused"
    assert page.evaluate("document.activeElement.id") == "action-cancel"
    page.locator("#action-cancel").click()
    page.get_by_role("button", name="Cancel the job").click()
    expect(page.locator("#job-state")).to_have_text("cancelled")
    page.locator("#action-delete").click()
    page.get_by_role("button", name="Back").click()
    assert farm.job(job)["state"] == "cancelled"
    page.locator("#action-delete").click()
    page.get_by_role("button", name="Delete the job").click()
    expect(row(page, job)).to_have_count(0)
