"""The viewer: its numbers are those of the EXR, and every control does what it says."""

import math
import urllib.error

import numpy
import OpenEXR
import pytest
from playwright.sync_api import expect

from farm import wait_until
from looks import open_job, point_at, screen_color, screen_place, values, wait_for_picture

SIZE = (64, 64)
PIXELS = [(0, 0), (63, 0), (31, 8), (20, 40), (47, 50), (0, 63), (63, 63)]


def exr_of(farm, job, folder, layers="radius,photons,error,albedo,normal,depth"):
    path = folder / f"{job}.exr"
    path.write_bytes(farm.bytes(f"/v1/jobs/{job}/image.exr?layers={layers}"))
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.copy() for name, channel in file.channels().items()}


@pytest.fixture(scope="session")
def exr(farm, tmp_path_factory):
    return exr_of(farm, farm.done, tmp_path_factory.mktemp("exr"))


LAYERS = {"color": "RGB", "radius": ["radius.Y"], "photons": ["photons.Y"], "error": ["error.Y"], "albedo": ["albedo.R", "albedo.G", "albedo.B"],
          "normal": ["normal.X", "normal.Y", "normal.Z"], "depth": ["depth.Z"]}


def pixels(farm, job, dtype="<f4", **query):
    text = "&".join(f"{name}={value}" for name, value in query.items())
    return numpy.frombuffer(farm.bytes(f"/v1/jobs/{job}/pixels?{text}"), dtype)


@pytest.mark.parametrize("layer", LAYERS)
def test_pixels_are_those_of_the_exr(farm, exr, layer):
    found = pixels(farm, farm.done, layer=layer).reshape(64, 64, -1)
    expected = numpy.stack([exr[name] for name in LAYERS[layer]], axis=-1)
    numpy.testing.assert_array_equal(found, expected)
    half = pixels(farm, farm.done, "<f2", layer=layer, format="half").reshape(64, 64, -1)
    with numpy.errstate(over="ignore"):
        numpy.testing.assert_array_equal(half, expected.astype("<f2"))


def test_levels_are_means_and_parts_are_parts(farm, exr):
    color = numpy.stack([exr[name] for name in "RGB"], axis=-1).astype("f8")
    means = color.reshape(16, 4, 16, 4, 3).mean(axis=(1, 3))
    numpy.testing.assert_allclose(pixels(farm, farm.done, level=2).reshape(16, 16, 3), means, rtol=1e-6)
    part = pixels(farm, farm.done, level=2, x=3, y=5, width=4, height=2).reshape(2, 4, 3)
    numpy.testing.assert_allclose(part, means[5:7, 3:7], rtol=1e-6)


@pytest.mark.parametrize("query", ["level=7", "x=60&width=5", "y=64", "layer=none", "width=0", "format=double", "size=3"])
def test_what_is_not_there_is_refused(farm, query):
    with pytest.raises(urllib.error.HTTPError) as refused:
        farm.bytes(f"/v1/jobs/{farm.done}/pixels?{query}")
    assert refused.value.code in (400, 422)


def test_the_readout_tells_the_values_of_the_exr(farm, exr, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    for number, (layer, channels) in enumerate(LAYERS.items(), 1):
        page.keyboard.press(str(number))
        expect(page.locator("#picture")).to_have_attribute("aria-label", f"The picture of job amber so far, layer {layer}")
        wait_for_picture(page)
        for x, y in PIXELS:
            point_at(page, SIZE, x, y)
            expected = [float(exr[name][y, x]) for name in channels]
            numpy.testing.assert_allclose([value for _, value in values(page)], expected, rtol=1e-6)


def srgb(value):
    value = min(max(value, 0), 1)
    return 255 * (12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055)


def assert_shown(page, exr, place, curve):
    x, y = place
    expected = [curve(float(exr[name][y, x])) for name in "RGB"]
    is_near = lambda: numpy.allclose(screen_color(page, SIZE, x, y), expected, rtol=0, atol=1.01)
    wait_until(is_near, f"the color at {place} is not {expected}", 3)


def test_exposure_curve_and_gamma_are_those_that_are_told(farm, exr, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    for place in PIXELS:
        assert_shown(page, exr, place, srgb)
    page.keyboard.press("e")
    page.keyboard.press("e")
    page.keyboard.press("Shift+E")
    expect(page.locator("#exposure-value")).to_have_text("+0.5")
    assert_shown(page, exr, (20, 40), lambda value: srgb(value * 2 ** 0.5))
    page.keyboard.press("r")
    page.keyboard.press("g")
    expect(page.locator("#gamma-value")).to_have_text("2.3")
    assert_shown(page, exr, (20, 40), lambda value: 255 * min(value, 1) ** (1 / 2.3))
    page.locator("#curve").select_option("linear")
    assert_shown(page, exr, (20, 40), lambda value: 255 * min(value, 1))
    page.locator("#curve").select_option("filmic")
    assert_shown(page, exr, (20, 40), lambda value: srgb(value * (2.51 * value + 0.03) / (value * (2.43 * value + 0.59) + 0.14)))


def test_false_colors_follow_the_scale(farm, exr, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    page.keyboard.press("c")
    expect(page.locator("#exposure")).to_be_hidden()
    page.get_by_label("from").fill("0")
    page.get_by_label("to", exact=True).fill("1")
    page.get_by_label("to", exact=True).press("Tab")
    page.get_by_label("logarithmic").set_checked(False)
    luminance = sum(weight * exr[name] for weight, name in zip((0.2126, 0.7152, 0.0722), "RGB"))
    colors = [screen_color(page, SIZE, x, y) for x, y in PIXELS]
    lightness = [sum(weight * byte for weight, byte in zip((0.2126, 0.7152, 0.0722), color)) for color in colors]
    order = [float(min(luminance[y, x], 1)) for x, y in PIXELS]
    assert numpy.argsort(lightness).tolist() == numpy.argsort(order).tolist()
    page.get_by_label("to", exact=True).fill("-1")
    page.get_by_label("to", exact=True).press("Tab")
    expect(page.locator("#scale-problem")).to_be_visible()


def zoom(page):
    return float(page.locator("#zoom").inner_text().split()[0])


def test_the_view_is_moved_and_zoomed(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    fitted = zoom(page)
    box = page.locator("#picture").bounding_box()
    assert math.isclose(fitted, 100 * min(box["width"], box["height"]) / 64, rel_tol=0.02)
    page.keyboard.press("a")
    expect(page.locator("#zoom")).to_have_text("100 %")
    page.keyboard.press("f")
    wait_until(lambda: zoom(page) == fitted, "not fitted")
    # The pixel under the pointer stays there.
    point_at(page, SIZE, 40, 20)
    page.mouse.wheel(0, -600)
    wait_until(lambda: zoom(page) > 2 * fitted, "not zoomed")
    expect(page.locator("#readout")).to_contain_text("40, 20 ")
    at = screen_place(page, SIZE, 40, 20)
    page.mouse.down()
    page.mouse.move(at[0] + 200, at[1])
    page.mouse.up()
    expect(page.locator("#readout")).to_contain_text("40, 20 ")
    page.mouse.move(*at)
    wait_until(lambda: "40, 20 " not in page.locator("#readout").inner_text(), "not moved")
    page.locator("#zoom-fit").click()
    page.locator("#zoom-in").click()
    wait_until(lambda: math.isclose(zoom(page), fitted * 2 ** 0.5, rel_tol=0.01), "not closer")


def test_two_fingers_zoom(farm, browser, open_page):
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page = open_page(farm, f"#/jobs/{farm.done}", context.new_page())
    wait_for_picture(page)
    before = zoom(page)
    box = page.locator("#picture").bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    touch = context.new_cdp_session(page)
    points = lambda reach: [{"x": middle[0] - reach, "y": middle[1], "id": 0}, {"x": middle[0] + reach, "y": middle[1], "id": 1}]
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": points(30)})
    for reach in (45, 60, 75, 90):
        touch.send("Input.dispatchTouchEvent", {"type": "touchMove", "touchPoints": points(reach)})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    wait_until(lambda: math.isclose(zoom(page), 3 * before, rel_tol=0.15), f"zoom {zoom(page)} from {before}")
    context.close()


# Lets the canvas note which texts it draws.
NOTE_TEXTS = """() => {
  globalThis.drawnTexts = [];
  const { fillText } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) { drawnTexts.push(text); fillText.call(this, text, ...rest); };
}"""


def test_large_pixels_show_their_values(farm, exr, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    page.evaluate(NOTE_TEXTS)
    point_at(page, SIZE, 20, 40)
    for _ in range(10):
        page.mouse.wheel(0, -170)
    wait_until(lambda: zoom(page) > 10_000, "not close")
    page.evaluate("drawnTexts.length = 0")
    page.keyboard.press("+")
    wait_until(lambda: page.evaluate("drawnTexts.length"), "no numbers")
    drawn = page.evaluate("drawnTexts.map(Number)")
    for name in "RGB":
        expected = float(exr[name][40, 20])
        assert any(math.isclose(value, expected, rel_tol=1e-3) for value in drawn), (name, expected)


def test_keys_go_from_job_to_job_and_tell_themselves(farm, open_page):
    page = open_page(farm, f"#/jobs/{farm.other}")
    wait_for_picture(page)
    page.locator("#text-filter").fill("path")
    page.locator("#text-filter").fill("")
    page.locator("#order").select_option("oldest")
    page.locator("#picture").focus()
    page.keyboard.press("p")
    expect(page.locator("#job-name")).to_have_text("amber")
    page.keyboard.press("ArrowRight")
    expect(page.locator("#job-name")).to_have_text("birch")
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keys")).to_contain_text("false colors")
    page.keyboard.press("Escape")
    page.keyboard.press("/")
    page.keyboard.type("e")
    expect(page.locator("#text-filter")).to_have_value("e")
    expect(page.locator("#exposure-value")).to_have_text("0")


def test_the_histogram_tells_the_whole_picture(farm, exr, open_page):
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    summary = page.locator("#histogram-summary").inner_text()
    mean = numpy.mean([exr[name].astype("f8").mean() for name in "RGB"])
    assert f"mean {mean:.3g}" in summary, (summary, mean)
    assert page.evaluate("""() => { const canvas = document.getElementById('histogram');
      return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some(byte => byte > 0); }""")


def errors(farm, folder, job, reference):
    one, other = [numpy.stack([exr_of(farm, each, folder, "")[name] for name in "RGB"], -1).astype("f8") for each in (job, reference)]
    squares = ((one - other) ** 2).mean(axis=-1)
    return math.sqrt(squares.mean()), (squares / (other.mean(axis=-1) ** 2 + 1e-3 * other.mean() ** 2)).mean()


def told_errors(page):
    """RMSE and relMSE; what the jobs themselves tell of their noise follows."""
    rows = [row for row in page.locator("#errors").inner_text().splitlines() if "\t" in row]
    return [float(row.split("\t")[1].split()[0]) for row in rows[:2]]


def test_two_jobs_are_compared(farm, exr, open_page, tmp_path):
    other = exr_of(farm, farm.other, tmp_path, "")
    page = open_page(farm, f"#/jobs/{farm.done}")
    wait_for_picture(page)
    page.locator("#tab-compare").click()
    page.locator("#other").select_option(farm.other)
    expect(page.locator("#errors")).to_contain_text("relMSE")
    numpy.testing.assert_allclose(told_errors(page), errors(farm, tmp_path, farm.done, farm.other), rtol=6e-3)
    # The line stands in the middle: A is left of it, B right of it.
    page.locator("#split").focus()
    point_at(page, SIZE, 10, 30)
    assert_shown(page, exr, (10, 30), srgb)
    assert_shown(page, other, (50, 30), srgb)
    assert [value for _, value in values(page)] == pytest.approx([float(of[name][30, 10]) for of in (exr, other) for name in "RGB"], rel=1e-4)
    page.keyboard.press("x")
    page.keyboard.press("x")
    expect(page.locator("#flip")).to_contain_text("birch")
    assert_shown(page, other, (10, 30), srgb)
    page.keyboard.press("d")
    apart = {name: abs(exr[name] - other[name]) for name in "RGB"}
    assert_shown(page, apart, (10, 30), srgb)
    page.locator("#other").select_option("")
    expect(page.locator("#comparison")).to_be_hidden()
    open_job(page, farm, farm.other)
    expect(page.locator("#job-name")).to_have_text("birch")


def test_a_large_picture_comes_coarse_first_and_only_as_far_as_it_is_seen(farm, context, open_page):
    job = farm.submit("large", passes=2, size=520, method="path")
    farm.wait(job)
    asked = []
    context.on("request", lambda request: asked.append(request.url) if f"{job}/pixels?layer" in request.url else None)
    page = open_page(farm, f"#/jobs/{job}")
    wait_for_picture(page)
    page.wait_for_timeout(1500)
    assert "level=2&x=0&y=0" in asked[0] and len(asked) == len(set(asked))
    asked.clear()
    point_at(page, (520, 520), 100, 100)
    for _ in range(12):
        page.mouse.wheel(0, -170)
    wait_until(lambda: any("format=float" in url for url in asked), "no exact values")
    page.wait_for_timeout(500)
    assert all("level=0" in url for url in asked if "format=float" in url) and len(asked) < 20, asked


def test_errors_of_large_pictures_are_those_of_means_until_every_pixel_is_measured(farm, open_page, tmp_path):
    job, other = [farm.submit(f"large {seed}", passes=2, size=300, method="path", seed=seed) for seed in (1, 2)]
    farm.wait(other)
    farm.wait(job)
    page = open_page(farm, f"#/jobs/{job}")
    wait_for_picture(page)
    page.locator("#tab-compare").click()
    page.locator("#other").select_option(other)
    expect(page.locator("#errors-note")).to_contain_text("means over 2 × 2 pixels")
    expected = errors(farm, tmp_path, job, other)
    assert told_errors(page)[1] < 0.7 * expected[1]
    page.locator("#measure").click()
    expect(page.locator("#errors-note")).to_contain_text("Of every pixel, at passes 2 and 2")
    numpy.testing.assert_allclose(told_errors(page), expected, rtol=6e-3)
