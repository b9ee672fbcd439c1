"""What can be done with a job, and who may."""

from playwright.sync_api import expect

from farm import Farm, wait_until
from looks import open_job, row, wait_for_picture


def test_a_job_is_paused_and_goes_on(farm, open_page):
    job = farm.submit("long", passes=100_000, size=32)
    page = open_page(farm, f"#/jobs/{job}")
    page.locator("#action-pause").click()
    expect(page.locator("#job-state")).to_have_text("paused")
    expect(page.locator("#action-pause")).to_be_hidden()
    page.locator("#action-resume").click()
    expect(page.locator("#action-resume")).to_be_hidden()
    assert farm.job(job)["state"] in ("queued", "running")
    farm.ask(f"/v1/jobs/{job}/cancel", {})


def test_an_ended_job_is_extended(farm, open_page):
    job = farm.submit("short", passes=2, size=32)
    farm.wait(job)
    page = open_page(farm, f"#/jobs/{job}")
    page.locator("#action-extend").click()
    dialog = page.get_by_role("dialog", name="Extend short")
    expect(dialog.get_by_label("Passes")).to_have_value("4")
    dialog.get_by_label("Passes").fill("1")
    dialog.get_by_role("button", name="Extend").click()
    expect(dialog.get_by_role("alert")).to_contain_text("Remedy")
    dialog.get_by_label("Passes").fill("6")
    dialog.get_by_role("button", name="Extend").click()
    expect(dialog).to_have_count(0)
    expect(page.locator("#job-reached")).to_contain_text("6 of 6 passes")


def test_a_job_is_cloned_with_another_method_and_end(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    page.locator("#action-clone").click()
    dialog = page.get_by_role("dialog", name="Clone amber")
    dialog.get_by_label("Name").fill("amber again")
    dialog.get_by_label("Method", exact=True).select_option("path")
    dialog.get_by_role("button", name="Set a parameter").click()
    dialog.get_by_role("combobox", name="Parameter").select_option("max_depth")
    dialog.get_by_label("Value").fill("3")
    dialog.get_by_label("Passes").fill("2")
    dialog.get_by_role("button", name="Submit").click()
    expect(page.locator("#job-name")).to_have_text("amber again")
    job = farm.job(page.evaluate("location.hash").split("/")[-1])
    assert (job["method"], job["parameters"]["max_depth"], job["stop"]) == ("path", 3, {"passes": 2})
    farm.wait(job["id"])


def test_name_tags_and_priority_are_changed_unless_somebody_else_did(farm, open_page):
    job = farm.submit_paused("old name", tags=["one"])
    page = open_page(farm, f"#/jobs/{job}")
    page.locator("#action-edit").click()
    dialog = page.get_by_role("dialog", name="Edit old name")
    dialog.get_by_label("Name").fill("new name")
    dialog.get_by_label("Tags").fill("two, three")
    dialog.get_by_label("Priority").fill("250")
    dialog.get_by_role("button", name="Save").click()
    expect(page.locator("#job-name")).to_have_text("new name")
    expect(row(page, job)).to_contain_text("#two · #three")
    assert farm.job(job)["priority"] == 250
    page.locator("#action-edit").click()
    dialog = page.get_by_role("dialog", name="Edit new name")
    expect(dialog).to_be_visible()
    farm.ask(f"/v1/jobs/{job}", {"priority": 10}, "PATCH")
    dialog.get_by_label("Name").fill("lost update")
    dialog.get_by_role("button", name="Save").click()
    expect(dialog.get_by_role("alert")).to_contain_text("changed")
    assert farm.job(job)["name"] == "new name" and farm.job(job)["priority"] == 10


def test_what_fails_is_told(farm, open_page):
    job = farm.submit_paused("gone soon")
    page = open_page(farm, f"#/jobs/{job}")
    expect(page.locator("#job-state")).to_have_text("paused")
    page.evaluate("""() => { const { fetch } = globalThis;
      globalThis.fetch = (address, options) => fetch(String(address).replace('/resume', '/pause'), options); }""")
    page.locator("#action-resume").click()
    expect(page.locator("#action-problem")).not_to_have_text("")


def test_pictures_are_saved(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    with page.expect_download() as download:
        page.locator("#link-exr").click()
    assert download.value.suggested_filename == "amber.exr"
    assert download.value.path().read_bytes() == farm.bytes(f"/v1/jobs/{farm.done}/image.exr")
    page.keyboard.press("e")
    expect(page.locator("#link-png")).to_have_attribute("href", f"/v1/jobs/{farm.done}/image.png?exposure=0.5")


def test_roles_and_logins(program, open_page, tmp_path):
    secret = tmp_path / "admin"
    secret.write_text("an-admin-token-of-these-tests-0123456789")
    farm = Farm(program, "--admin-token-file", str(secret))
    try:
        check_roles(farm, open_page, secret.read_text())
    finally:
        farm.stop()


def check_roles(farm, open_page, admin):
    farm.token = admin
    tokens = {name: farm.ask("/v1/users", {"name": name, "role": role})["token"]["secret"] for name, role in (("vera", "viewer"), ("art", "artist"))}
    job = farm.submit_paused("of the operator")
    page = open_page(farm, f"#/jobs/{job}")
    log_in(page, "wrong-token")
    expect(page.locator("#login-problem")).to_contain_text("token")
    log_in(page, tokens["vera"])
    expect(page.locator("#user-name")).to_have_text("vera (read)")
    expect(page.locator("#job-name")).to_have_text("of the operator")
    for name in ("cancel", "delete", "edit", "resume", "clone"):
        expect(page.locator(f"#action-{name}")).to_be_disabled()
    other_tab = page.context.new_page()
    other_tab.goto(f"{farm.address}/#/jobs/{job}")
    expect(other_tab.locator("#job-name")).to_have_text("of the operator")
    page.locator("#log-out").click()
    for tab in (page, other_tab):
        expect(tab.locator("#login-view")).to_be_visible()
        expect(tab.locator("#job")).to_be_hidden()
    log_in(page, tokens["art"])
    expect(page.locator("#action-clone")).to_be_enabled()
    expect(page.locator("#action-cancel")).to_be_disabled()
    farm.token = tokens["art"]
    own = farm.submit_paused("of art")
    open_job(page, farm, own)
    expect(page.locator("#action-cancel")).to_be_enabled()
    farm.token = admin
    page.locator("#log-out").click()
    log_in(page, admin)
    open_job(page, farm, own)
    expect(page.locator("#action-delete")).to_be_enabled()


def log_in(page, token):
    page.get_by_label("Your token").fill(token)
    page.get_by_role("button", name="Log in").click()
