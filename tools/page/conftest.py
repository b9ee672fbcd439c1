"""What the tests share: one farm with some jobs, a browser, and pages of it that fail on every error of their scripts."""

from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

from farm import Farm, launch_browser

WIDE = {"width": 1600, "height": 900}


def pytest_addoption(parser):
    parser.addoption("--program", required=True, help="the program photonfarm")
    parser.addoption("--screenshots", action="store_true", help="also write docs/page/*.png")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--screenshots"):
        items[:] = [item for item in items if "screenshots" not in item.nodeid]


def pytest_unconfigure(config):
    """The last line says how it went."""
    stats = config.pluginmanager.getplugin("terminalreporter").stats
    count = {kind: len(stats.get(kind, [])) for kind in ("passed", "failed", "error")}
    print(f"{count['passed']} passed, {count['failed'] + count['error']} failed")


@pytest.fixture(scope="session")
def program(request):
    return request.config.getoption("--program")


@pytest.fixture(scope="session")
def farm(program):
    """A farm with a worker, and jobs of one scene that are done."""
    farm = Farm(program)
    farm.start_worker()
    farm.done = farm.submit("amber", tags=["first"])
    farm.other = farm.submit("birch", method="path", seed=2)
    farm.wait(farm.other)
    farm.wait(farm.done)
    yield farm
    farm.stop()


@pytest.fixture
def own_farm(program):
    """A farm of the test's own, without workers, that may be stopped and started."""
    farm = Farm(program)
    yield farm
    farm.stop()


@pytest.fixture(scope="session")
def browser():
    expect.set_options(timeout=8000)
    with sync_playwright() as playwright:
        browser = launch_browser(playwright)
        yield browser
        browser.close()


@pytest.fixture
def context(browser):
    context = browser.new_context(viewport=WIDE, color_scheme="dark", reduced_motion="reduce")
    yield context
    context.close()


@pytest.fixture
def open_page(context):
    """Opens a page of a farm; errors of its scripts and requests to elsewhere fail the test."""
    faults = []

    def open_page(farm, address="", page=None):
        page = page or context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda line: faults.append(line.text) if "Content Security Policy" in line.text else None)
        page.on("request", lambda asked: None if asked.url.startswith((farm.address, "data:", "blob:")) else faults.append(asked.url))
        page.goto(f"{farm.address}/{address}")
        return page

    yield open_page
    assert faults == []


@pytest.fixture
def picture_folder():
    folder = Path(__file__).resolve().parents[2] / "docs/page"
    folder.mkdir(exist_ok=True)
    return folder
