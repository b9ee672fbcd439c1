"""Submitting: files, archives and folders are uploaded, and the form says how they are rendered."""

import io
import zipfile

from playwright.sync_api import expect

from farm import ROOT, SCENE

# A scene of a mesh in a file beside it.
MESH = """<scene version="3.0.0">
  <sensor type="perspective"><float name="fov" value="40"/>
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="24"/></film></sensor>
  <shape type="obj"><string name="filename" value="meshes/triangle.obj"/></shape>
  <emitter type="constant"/>
</scene>"""
TRIANGLE = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n"

# Drops files on the field, as a file manager does.
DROP = """async files => {
  const transfer = new DataTransfer();
  for (const [name, text] of files) transfer.items.add(new File([text], name));
  document.getElementById('drop').dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true }));
}"""


def make_folder(folder):
    (folder / "meshes").mkdir(parents=True)
    (folder / "set.xml").write_text(MESH)
    (folder / "meshes/triangle.obj").write_text(TRIANGLE)
    (folder / ".hidden").write_text("no part of it")
    return folder


def open_submit(farm, open_page):
    page = open_page(farm, "#/submit")
    page.locator("#submit-view").wait_for()
    expect(page.locator("#farm")).to_contain_text("worker")
    return page


def submitted(page, farm):
    page.locator("#submit").click()
    expect(page.locator("#job")).to_be_visible()
    return farm.job(page.evaluate("location.hash").split("/")[-1])


def test_a_file_is_submitted_as_the_form_says(farm, open_page):
    page = open_submit(farm, open_page)
    page.locator("#scene-file").set_input_files(SCENE)
    form = page.locator("#submit-form")
    form.get_by_label("Name", exact=True).fill("from the page")
    form.get_by_label("Tags").fill("a, b")
    form.get_by_label("Priority").fill("40")
    form.get_by_label("Method", exact=True).select_option("path")
    expect(form.get_by_text("Cannot sample")).to_be_visible()
    form.get_by_role("button", name="Set a parameter").click()
    form.get_by_role("combobox", name="Parameter").select_option("max_depth")
    expect(form.locator(".parameter small")).to_contain_text("longest path")
    form.get_by_label("Value").fill("4")
    form.get_by_label("Passes").fill("2")
    form.get_by_label("Seconds").fill("500")
    form.get_by_label("Width").fill("48")
    form.get_by_label("Seed").fill("7")
    page.locator("#check").click()
    expect(page.locator("#check-answer")).to_contain_text("The job can be rendered.")
    expect(page.locator("#check-answer")).to_contain_text("48 × 48")
    job = submitted(page, farm)
    told = [job[name] for name in ("name", "tags", "priority", "method", "stop", "width", "height", "seed")]
    assert told == ["from the page", ["a", "b"], 40, "path", {"passes": 2, "seconds": 500.0}, 48, 48, 7]
    assert job["parameters"]["max_depth"] == 4
    farm.wait(job["id"])


def test_what_is_wrong_is_told_with_place_and_remedy(farm, open_page):
    page = open_submit(farm, open_page)
    page.evaluate(DROP, [["broken.xml", SCENE.read_text().replace("perspective", "perspectiv")]])
    problem = page.locator("#upload .problem")
    expect(problem).to_contain_text("perspectiv")
    expect(problem).to_contain_text("Place:")
    expect(problem).to_contain_text("Remedy:")
    page.evaluate(DROP, [["alone.xml", MESH]])
    expect(problem).to_contain_text("triangle.obj")
    expect(page.locator("#upload")).to_contain_text("choose its folder")
    page.locator("#scene-file").set_input_files(SCENE)
    page.locator("#submit-form").get_by_label("Camera", exact=True).fill("none of this name")
    page.locator("#check").click()
    expect(page.locator("#check-answer .problem")).to_contain_text("none of this name")


def test_a_folder_goes_as_an_archive(farm, open_page, tmp_path):
    page = open_submit(farm, open_page)
    page.locator("#scene-folder").set_input_files(make_folder(tmp_path / "shot"))
    expect(page.locator("#upload")).to_contain_text("set.xml: 32 × 24 pixels, 2 files")
    page.locator("#submit-form").get_by_label("Passes").fill("1")
    job = submitted(page, farm)
    assert (job["name"], job["width"], job["height"]) == ("set", 32, 24)
    farm.wait(job["id"])


def test_dropped_files_are_packed_and_the_scene_among_them_is_asked_for(farm, open_page):
    page = open_submit(farm, open_page)
    scene = MESH.replace("meshes/", "")
    page.evaluate(DROP, [["one.xml", scene], ["other.xml", scene.replace('value="24"', 'value="16"')], ["triangle.obj", TRIANGLE]])
    page.get_by_label("Which file is the scene?").select_option("other.xml")
    page.get_by_role("button", name="Upload").click()
    expect(page.locator("#upload")).to_contain_text("other.xml: 32 × 16 pixels, 3 files")
    page.evaluate(DROP, [["a.obj", TRIANGLE], ["b.obj", TRIANGLE]])
    expect(page.locator("#upload .problem")).to_contain_text("There is no scene file among the 2 files")
    page.evaluate(DROP, [["scene.xml", SCENE.read_text()]])
    expect(page.locator("#upload")).to_contain_text("scene.xml: 512 × 512 pixels, 1 file.")


def test_archives_of_the_page_are_zip_files(farm, open_page):
    page = open_submit(farm, open_page)
    made = page.evaluate("""async () => {
      const { zip } = await import('/page/submit/zip.js');
      const blob = await zip([{ name: 'ä/one.txt', file: new Blob(['one']) }, { name: 'empty', file: new Blob([]) }], 'a comment');
      return [...new Uint8Array(await blob.arrayBuffer())];
    }""")
    with zipfile.ZipFile(io.BytesIO(bytes(made))) as archive:
        assert archive.testzip() is None and archive.comment == b"a comment"
        assert {name: archive.read(name) for name in archive.namelist()} == {"ä/one.txt": b"one", "empty": b""}


def test_an_archive_is_taken_as_it_is(farm, open_page, tmp_path):
    page = open_submit(farm, open_page)
    archive = tmp_path / "set.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("scene.xml", MESH)
        file.writestr("meshes/triangle.obj", TRIANGLE)
    page.locator("#scene-file").set_input_files(archive)
    expect(page.locator("#upload")).to_contain_text("32 × 24 pixels")


def test_every_format_that_is_read_may_be_chosen():
    """The page's list is that of the coordinator."""
    source = (ROOT / "src/import/formats.rs").read_text()
    table = source.split("pub const FORMATS", 1)[1].split("];", 1)[0]
    extensions = {line.split('"')[3] for line in table.splitlines() if "row(" in line}
    page = (ROOT / "src/api/dashboard/page/submit/scene_files.js").read_text()
    listed = page.split("FORMATS = [", 1)[1].split("]", 1)[0].replace("'", "").split(", ")
    assert set(listed) - {"zip"} == extensions
