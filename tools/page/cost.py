"""What an open page takes from a coordinator while it shows a job of 1920 × 1080 that runs: share of a processor, bytes, and time to the first paint.

usage: cost.py PROGRAM
"""

import os
import re
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

from farm import Farm, launch_browser

SECONDS = 40
# The browser calls the coordinator by an address of its own, so that its connections are told from the worker's.
BROWSERS_ADDRESS = "127.0.0.2"


class WatchedFarm(Farm):
    """A farm that also listens where the browser calls."""

    listen = "0.0.0.0"


def processor_seconds(process):
    """What a process used so far."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def bytes_sent():
    """What went to the browser over the connections that it has."""
    told = subprocess.run(["ss", "-tinH", "src", BROWSERS_ADDRESS], capture_output=True, text=True, check=True).stdout
    return sum(int(number) for number in re.findall(r"bytes_sent:(\d+)", told))


def measure(farm):
    """Shares of a processor and bytes a second, over some time."""
    used, sent, began = processor_seconds(farm.coordinator), bytes_sent(), time.monotonic()
    time.sleep(SECONDS)
    seconds = time.monotonic() - began
    return (processor_seconds(farm.coordinator) - used) / seconds, (bytes_sent() - sent) / seconds


def main():
    farm = WatchedFarm(sys.argv[1], "--insecure")
    try:
        farm.start_worker()
        changes = {"width": 1920, "height": 1080}
        job = farm.submit("watched", passes=1_000_000, method="path", scene_changes=changes)
        farm.wait(job, "running")
        while not farm.job(job)["passes_done"]:
            time.sleep(1)
        alone, _ = measure(farm)
        with sync_playwright() as playwright:
            browser = launch_browser(playwright)
            page = browser.new_context(viewport={"width": 1600, "height": 900}).new_page()
            page.goto(f"http://{BROWSERS_ADDRESS}:{farm.port}/#/jobs/{job}")
            page.get_by_text("as of pass").wait_for(timeout=60_000)
            paint = page.evaluate("performance.getEntriesByName('first-contentful-paint')[0].startTime")
            watched, rate = measure(farm)
            browser.close()
        passes = farm.job(job)["passes_done"]
        print(f"without the page {100 * alone:.1f} % of a processor, with it {100 * watched:.1f} %, {rate / 1e6:.2f} MB/s to the browser,")
        print(f"first paint after {paint:.0f} ms; {passes} passes, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}")
    finally:
        farm.stop()


if __name__ == "__main__":
    main()
