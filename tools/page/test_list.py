"""The list of jobs: found, ordered, and quick with ten thousand."""

from playwright.sync_api import expect

from farm import wait_until
from looks import row

# Puts jobs into the page's store as the farm would tell of them.
TELL_OF_MANY = """async count => {
  const { hear } = await import('/page/store.js');
  const job = index => ({
    id: `job${String(index).padStart(6, '0')}`, name: `frame ${index}`, state: index % 3 ? 'done' : 'running', owner: null,
    tags: [`shot${index % 7}`],
    priority: 100, method: 'sppm', parameters: {}, stop: { passes: 8 }, passes_done: 0, passes_total: 8, width: 64, height: 64, seconds: 1,
    photons_emitted: 0, photons_per_second: 0, workers: 0, notices: [], picture_version: 0, submitted: 0, scene: '', links: {},
  });
  hear({ kind: 'jobs', isReset: false, deleted: [], changed: Array.from({ length: count }, (_, index) => job(index)) });
}"""

# Scrolls through the whole list in 60 steps and answers how long the middle one of them took: two frames where nothing holds them up.
SCROLL = """async () => {
  const list = document.getElementById('list');
  const times = [];
  for (let step = 0; step <= 60; step++) {
    const before = performance.now();
    list.scrollTop = (list.scrollHeight - list.clientHeight) * step / 60;
    await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
    times.push(performance.now() - before);
  }
  return times.sort((one, other) => one - other)[30];
}"""


def test_rows_tell_what_a_job_is(farm, open_page):
    page = open_page(farm)
    for text in ("amber", "sppm", "#first", "4 of 4 passes", "done"):
        expect(row(page, farm.done)).to_contain_text(text)
    wait_until(lambda: drawn(page, farm.done), "no thumbnail")


def drawn(page, job):
    """Whether the row's small picture has a color."""
    expect(row(page, job)).to_be_visible()
    return page.evaluate("""id => {
      const canvas = document.querySelector(`#job-${id} canvas`);
      return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some(byte => byte > 0);
    }""", job)


def test_a_filter_and_an_order_are_followed(farm, open_page):
    page = open_page(farm)
    names = page.locator(".row .name")
    page.locator("#text-filter").fill("path bir")
    expect(names).to_have_text(["birch"])
    expect(page.locator("#list-count")).to_contain_text("1 of ")
    page.locator("#text-filter").fill("nothing of this kind")
    expect(page.locator("#list-empty")).to_have_text("No job fits the filter.")
    page.locator("#text-filter").fill("")
    page.locator("#state-filter").select_option("done")
    page.locator("#order").select_option("name")
    wait_until(lambda: page.evaluate("[...document.querySelectorAll('.row .state')].every(state => state.textContent === 'done')"), "other states")
    shown = page.evaluate("""[...document.querySelectorAll('.row')].sort((a, b) => a.ariaPosInSet - b.ariaPosInSet)
        .map(row => row.querySelector('.name').textContent)""")
    assert shown == sorted(shown) and "amber" in shown


def test_ten_thousand_jobs_scroll_smoothly(farm, open_page):
    page = open_page(farm)
    expect(row(page, farm.done)).to_be_visible()
    page.evaluate(TELL_OF_MANY, 10_000)
    expect(page.locator("#list-count")).to_contain_text("10,0")
    assert page.locator(".row").count() < 40
    assert page.evaluate(SCROLL) < 80, "milliseconds"
    assert page.locator(".row").count() < 40
    page.locator("#text-filter").fill("frame 9876")
    expect(page.locator(".row")).to_have_count(1)


def test_thumbnails_are_asked_for_one_at_a_time_and_not_again(farm, context, open_page):
    asked, open_now, most = [], set(), []

    def note(request):
        if "/pixels?level=" in request.url:
            asked.append(request.url)
            open_now.add(request)
            most.append(len(open_now))

    context.on("request", note)
    context.on("requestfinished", lambda request: open_now.discard(request))
    page = open_page(farm, "#/workers")
    assert asked == []
    page.goto(f"{farm.address}/#/jobs")
    wait_until(lambda: drawn(page, farm.done) and drawn(page, farm.other), "no thumbnails")
    page.wait_for_timeout(1500)
    assert len(asked) == len(set(asked)) and max(most) == 1, asked
