"""From a dropped scene file to its picture on the page: prints the seconds until the first pass is seen.

usage: first_picture.py PROGRAM
"""

import sys
import time

from playwright.sync_api import expect, sync_playwright

from farm import SCENE, Farm, launch_browser
from test_submit import DROP


def main():
    farm = Farm(sys.argv[1])
    try:
        farm.start_worker()
        with sync_playwright() as playwright:
            browser = launch_browser(playwright)
            page = browser.new_context(viewport={"width": 1600, "height": 900}).new_page()
            page.goto(f"{farm.address}/#/submit")
            page.locator("#submit-view").wait_for()
            expect(page.locator("#farm")).to_contain_text("worker")
            began = time.monotonic()
            page.evaluate(DROP, [[SCENE.name, SCENE.read_text()]])
            page.locator("#submit:enabled").click()
            page.get_by_text("as of pass").wait_for(timeout=60_000)
            print(f"{time.monotonic() - began:.1f}")
            browser.close()
    finally:
        farm.stop()


if __name__ == "__main__":
    main()
