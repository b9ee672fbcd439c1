"""Light groups in the viewer: the picture of a job whose lights are kept apart is mixed anew without rendering."""

import re

import numpy
import pytest
from playwright.sync_api import expect

from farm import wait_until
from looks import point_at, values, wait_for_picture

SIZE = (64, 48)
PIXELS = [(10, 40), (32, 24), (50, 30), (40, 8)]
LAYER = "#layers [value=light_groups]"
GROUPS = ["lamp", "bulb", "others"]
SCENE = """<scene version="3.0.0"><default name="width" value="64"/>
<sensor type="perspective"><float name="fov" value="50"/><transform name="to_world">
<lookat origin="0, -2.5, 1.5" target="0, 0, 0.4" up="0, 0, 1"/></transform><film type="hdrfilm">
<integer name="width" value="64"/><integer name="height" value="48"/><rfilter type="box"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="4"/></transform><bsdf type="diffuse"/></shape>
<shape type="sphere"><point name="center" x="-0.4" y="0.5" z="1"/><float name="radius" value="0.15"/>
<emitter type="area"><rgb name="radiance" value="8, 4, 2"/><string name="light_group" value="lamp"/></emitter></shape>
<emitter type="point"><point name="position" x="0.7" y="0.3" z="0.8"/><rgb name="intensity" value="0.2, 0.5, 0.2"/>
<string name="light_group" value="bulb"/></emitter>
<emitter type="constant"><rgb name="radiance" value="0.1, 0.2, 0.5"/></emitter></scene>"""


@pytest.fixture(scope="module")
def grouped(farm, tmp_path_factory):
    scene = tmp_path_factory.mktemp("scene") / "scene.xml"
    scene.write_text(SCENE)
    job = farm.submit("grouped", method="path", scene=scene, light_groups=True)
    farm.wait(job)
    return job


def pixels(farm, job, layer):
    answer = farm.bytes(f"/v1/jobs/{job}/pixels?layer={layer}")
    return numpy.frombuffer(answer, "<f4").reshape(SIZE[1], SIZE[0], -1)


@pytest.fixture(scope="module")
def light(farm, grouped):
    return {group: pixels(farm, grouped, f"light_group.{group}").astype("f8") for group in GROUPS}


def open_groups(farm, job, open_page):
    page = open_page(farm, f"#/jobs/{job}")
    wait_for_picture(page)
    page.locator(LAYER).evaluate("radio => radio.click()")
    expect(page.locator("#picture")).to_have_attribute("aria-label", re.compile("layer light_groups"))
    wait_for_picture(page)
    return page


def set_range(page, group, value):
    page.get_by_label(group, exact=True).evaluate("(range, value) => { range.value = value; range.dispatchEvent(new Event('input')); }", value)


def assert_told(page, expected):
    for x, y in PIXELS:
        point_at(page, SIZE, x, y)
        is_near = lambda: numpy.allclose([value for _, value in values(page)], expected[y, x], rtol=2e-5, atol=1e-6)
        wait_until(is_near, f"{values(page)} at {x}, {y} is not {expected[y, x]}", 5)


def test_groups_are_told_and_add_up(farm, grouped, light):
    assert farm.job(grouped)["light_groups"] == GROUPS
    together = pixels(farm, grouped, "light_groups")
    assert together.shape == (48, 64, 9)
    numpy.testing.assert_array_equal(together, numpy.concatenate([light[group] for group in GROUPS], axis=-1).astype("f4"))
    numpy.testing.assert_allclose(sum(light.values()), pixels(farm, grouped, "color"), rtol=1e-6, atol=1e-7)
    assert all(light[group].mean() > 0.01 for group in GROUPS)


def test_the_viewer_mixes_groups(farm, grouped, light, open_page):
    page = open_groups(farm, grouped, open_page)
    picture = pixels(farm, grouped, "color")
    assert_told(page, picture)
    set_range(page, "lamp", 0)
    expect(page.locator("#light-group-0-value")).to_have_text("0")
    assert_told(page, picture - light["lamp"])
    set_range(page, "bulb", 2.5)
    assert_told(page, 2.5 * light["bulb"] + light["others"])
    color = page.get_by_label("Color of bulb")
    color.evaluate("input => { input.value = '#ff8000'; input.dispatchEvent(new Event('input')); }")
    green = ((0x80 / 255 + 0.055) / 1.055) ** 2.4
    assert_told(page, 2.5 * light["bulb"] * numpy.array([1, green, 0]) + light["others"])
    page.get_by_role("button", name="As rendered").click()
    expect(page.locator("#light-group-0-value")).to_have_text("1")
    assert_told(page, picture)


def test_other_jobs_have_no_groups(farm, grouped, open_page):
    page = open_groups(farm, grouped, open_page)
    page.goto(f"{farm.address}/#/jobs/{farm.done}")
    expect(page.locator("#job-name")).to_have_text("amber")
    wait_for_picture(page)
    expect(page.locator("#layers label", has_text="Light groups")).to_be_hidden()
    expect(page.locator("#light-groups")).to_be_hidden()
    expect(page.locator("#picture")).to_have_attribute("aria-label", "The picture of job amber so far, layer color")
