"""How tests look at the page: rows of the list, the picture's pixels, the values that the viewer tells."""

import re

from playwright.sync_api import expect

from farm import wait_until


def row(page, job):
    return page.locator(f"#job-{job}")


def open_job(page, farm, job):
    page.goto(f"{farm.address}/#/jobs/{job}")
    page.locator("#job").wait_for()


def has_picture(page):
    """Whether anything is drawn."""
    return page.evaluate("""() => {
      const canvas = document.getElementById('picture');
      const bytes = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
      return bytes.some((byte, index) => index % 4 === 3 && byte > 0);
    }""")


def wait_for_picture(page):
    expect(page.locator("#picture-passes")).to_contain_text("as of pass")
    wait_until(lambda: has_picture(page), "nothing is drawn", 5)


def screen_place(page, size, x, y):
    """Where the middle of a pixel is on the screen, while the picture is fitted."""
    box = page.locator("#picture").bounding_box()
    zoom = min(box["width"] / size[0], box["height"] / size[1])
    left = box["x"] + (box["width"] - zoom * size[0]) / 2
    top = box["y"] + (box["height"] - zoom * size[1]) / 2
    return left + (x + 0.5) * zoom, top + (y + 0.5) * zoom


def point_at(page, size, x, y):
    page.mouse.move(*screen_place(page, size, x, y))
    expect(page.locator("#readout")).to_have_text(re.compile(rf"^{x}, {y} "))


def values(page):
    """The numbers that the viewer tells of a pixel, by channel; of two pictures, A first."""
    text = page.locator("#readout").inner_text()
    number = lambda value: float(value.replace("−", "-").replace("∞", "inf"))
    return [(channel, number(value)) for channel, value in re.findall(r"\b([RGBXYZ]) ([−-]?[\d.]\S*|[−]?∞|NaN)", text)]


def screen_color(page, size, x, y):
    """The color of a pixel as it is drawn, while the picture is fitted."""
    box = page.locator("#picture").bounding_box()
    at = screen_place(page, size, x, y)
    place = [at[0] - box["x"], at[1] - box["y"]]
    return page.evaluate("""([x, y]) => {
      const canvas = document.getElementById('picture');
      const scale = canvas.width / canvas.clientWidth;
      return [...canvas.getContext('2d').getImageData(Math.floor(x * scale), Math.floor(y * scale), 1, 1).data].slice(0, 3);
    }""", place)
