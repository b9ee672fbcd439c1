"""The table of small scenes, one for each plugin, default and main parameter of Mitsuba 3: name -> XML.

Most put one object under test on the same stage: a checkered floor, a large lamp, and a sky of one color.
"""

SPHERE = "<transform name='to_world'><translate z='1.1'/></transform>"
TILE = "<string name='filename' value='files/tile.png'/>"
FLOOR = """<shape type='rectangle'>
  <transform name='to_world'><scale value='6'/></transform>
  <bsdf type='diffuse'><texture name='reflectance' type='checkerboard'>
    <transform name='to_uv'><scale value='6'/></transform>
    <rgb name='color0' value='0.7, 0.6, 0.5'/><rgb name='color1' value='0.2, 0.3, 0.4'/>
  </texture></bsdf>
</shape>"""
LAMP = """<shape type='rectangle'>
  <transform name='to_world'><scale value='1.5'/><lookat origin='-3, -2, 5' target='0, 0, 0.5' up='0, 1, 0'/></transform>
  <emitter type='area'><rgb name='radiance' value='5, 4.5, 4'/></emitter>
</shape>"""
SKY = "<emitter type='constant'><rgb name='radiance' value='0.4, 0.5, 0.7'/></emitter>"
PATH = "<integrator type='path'><integer name='max_depth' value='8'/></integrator>"
VOLPATH = "<integrator type='volpath'><integer name='max_depth' value='16'/></integrator>"
PIXELS = "<integer name='width' value='32'/><integer name='height' value='32'/>"
FILM = f"<film type='hdrfilm'>{PIXELS}<rfilter type='box'/></film>"
VIEW = "<transform name='to_world'><lookat origin='0.5, -6, 3' target='0, 0, 0.9' up='0, 0, 1'/></transform>"


def sensor(plugin="perspective", inside="<float name='fov' value='30'/>", film=FILM, view=VIEW):
    return f"<sensor type='{plugin}'>\n  {inside}\n  {view}\n  {film}\n</sensor>"


def scene(*parts, integrator=PATH, camera=None):
    lines = "\n".join([integrator, camera or sensor(), *parts]).splitlines()
    text = "".join(f"  {line}\n" for line in lines if line.strip())
    return f"<scene version='3.0.0'>\n{text}</scene>\n".replace("'", '"')


def subject(bsdf, shape="sphere", place=SPHERE):
    """The stage with one shape of a material."""
    return scene(SKY, LAMP, FLOOR, f"<shape type='{shape}'>\n  {place}\n  {bsdf}\n</shape>")


def bsdf(plugin, inside="", attributes=""):
    return f"<bsdf type='{plugin}'{attributes}>{inside}</bsdf>"


def shape(plugin, inside=""):
    """The stage with one matte, patterned shape."""
    pattern = f"<bsdf type='twosided'><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>{TILE}</texture></bsdf></bsdf>"
    return scene(SKY, LAMP, FLOOR, f"<shape type='{plugin}'>\n  {inside}\n  {pattern}\n</shape>")


def light(*emitters):
    """The stage lit by something else."""
    return scene(*emitters, FLOOR, f"<shape type='sphere'>\n  {SPHERE}\n  {bsdf('diffuse')}\n</shape>")


WALL = "<transform name='to_world'><lookat origin='0, 0, 3' target='0, 0, 0' up='0, 1, 0'/></transform>"
DIRECT = "<integrator type='path'><integer name='max_depth' value='2'/></integrator>"


def texture(inside, film=FILM):
    """A textured square that fills the picture, in an even sky."""
    square = f"<shape type='rectangle'>\n  <bsdf type='diffuse'>{inside}</bsdf>\n</shape>"
    camera = sensor("orthographic", "", film, WALL)
    return scene("<emitter type='constant'/>", square, integrator=DIRECT, camera=camera)


def film(inside, size=(8, 8)):
    """Sharp edges that shine, through one film."""
    width, height = size
    of_size = f"<film type='hdrfilm'><integer name='width' value='{width}'/><integer name='height' value='{height}'/>{inside}</film>"
    board = """<texture name='radiance' type='checkerboard'>
    <transform name='to_uv'><rotate z='1' angle='20'/><scale value='2.2'/></transform>
    <rgb name='color0' value='1, 0.8, 0.1'/><rgb name='color1' value='0.1, 0.3, 0.9'/>
  </texture>"""
    shine = (
        "<shape type='rectangle'>\n  <transform name='to_world'><scale value='0.9'/></transform>\n  <emitter"
        f" type='area'>{board}</emitter>\n</shape>"
    )
    return scene(shine, integrator=DIRECT, camera=sensor("orthographic", "", of_size, WALL))


def camera(plugin="perspective", inside="", size=(48, 24)):
    """The stage through one camera."""
    pixels = f"<integer name='width' value='{size[0]}'/><integer name='height' value='{size[1]}'/>"
    through = sensor(plugin, inside, f"<film type='hdrfilm'>{pixels}<rfilter type='box'/></film>")
    return scene(SKY, LAMP, FLOOR, f"<shape type='sphere'>\n  {SPHERE}\n  {bsdf('diffuse')}\n</shape>", camera=through)


def integrator(xml):
    """The stage with a mirror and a visible lamp, by one integrator."""
    mirror = f"<shape type='sphere'>\n  {SPHERE}\n  {bsdf('conductor')}\n</shape>"
    bulb = """<shape type='sphere'>
  <transform name='to_world'><scale value='0.4'/><translate x='1.4' y='-0.5' z='0.6'/></transform>
  <emitter type='area'><rgb name='radiance' value='2, 1.5, 1'/></emitter>
</shape>"""
    return scene(SKY, LAMP, FLOOR, mirror, bulb, integrator=xml)


def medium(inside, skin="<bsdf type='null'/>"):
    """A cube of a medium on the stage."""
    cube = f"""<shape type='cube'>
  <transform name='to_world'><rotate z='1' angle='25'/><translate z='1.1'/></transform>
  {skin}
  <medium name='interior' type='homogeneous'>{inside}</medium>
</shape>"""
    return scene(SKY, LAMP, FLOOR, cube, integrator=VOLPATH)


def lit_by(spectrum):
    """A sky of a spectrum over a grey sphere."""
    sphere = f"<shape type='sphere'>\n  {SPHERE}\n  {bsdf('diffuse')}\n</shape>"
    return scene(f"<emitter type='constant'>{spectrum}</emitter>", sphere)


def number(name, value):
    return f"<float name='{name}' value='{value}'/>"


def rgb(name, value):
    return f"<rgb name='{name}' value='{value}'/>"


def text(name, value):
    return f"<string name='{name}' value='{value}'/>"


def flag(name, value):
    return f"<boolean name='{name}' value='{value}'/>"


def bitmap(name, inside="", file="tile.png"):
    return f"<texture name='{name}' type='bitmap'>{text('filename', 'files/' + file)}{inside}</texture>"


TURNED = "<transform name='to_world'><rotate x='1' angle='40'/><rotate y='1' angle='25'/><translate z='1.2'/></transform>"
GGX = text("distribution", "ggx")
GREY = "<texture name='{}' type='bitmap'><string name='filename' value='files/grey.png'/><boolean name='raw' value='true'/></texture>"
COAT = rgb("base_color", "0.7, 0.3, 0.2")
LEAF = bsdf("diffuse", rgb("reflectance", "0.3, 0.6, 0.2"))
AIM = "<transform name='to_world'><lookat origin='-2, -2, 4' target='0, 0, 0.5' up='0, 0, 1'/></transform>"
BULB = (
    "<shape type='sphere'>\n  <transform name='to_world'><scale value='0.7'/><translate x='-1' y='-1.5' z='3.5'/></transform>\n "
    " {}\n</shape>"
)

SHAPES = {
    "sphere": shape("sphere", "<point name='center' x='0.2' y='0' z='1.1'/>" + number("radius", 0.9)),
    "sphere-moved": shape("sphere", TURNED),
    "rectangle": shape(
        "rectangle", "<transform name='to_world'><scale x='1.3' y='0.9'/><rotate x='1' angle='60'/><translate z='1.2'/></transform>"
    ),
    "cube": shape("cube", TURNED.replace("<rotate", "<scale value='0.7'/><rotate")),
    "disk": shape("disk", "<transform name='to_world'><scale x='1.3' y='0.9'/><rotate x='1' angle='60'/><translate z='1.2'/></transform>"),
    "cylinder": shape(
        "cylinder", "<point name='p0' x='-0.8' y='0' z='0.5'/><point name='p1' x='0.8' y='0.4' z='1.6'/>" + number("radius", 0.5)
    ),
    "cylinder-moved": shape(
        "cylinder", "<transform name='to_world'><scale x='0.7' y='0.7' z='1.5'/><rotate y='1' angle='30'/><translate z='0.6'/></transform>"
    ),
    "obj": shape("obj", text("filename", "files/gem.obj") + TURNED),
    "obj-face-normals": shape("obj", text("filename", "files/gem.obj") + flag("face_normals", "true") + TURNED),
    "obj-flip-tex-coords": shape("obj", text("filename", "files/gem.obj") + flag("flip_tex_coords", "false") + TURNED),
    "ply": shape("ply", text("filename", "files/gem.ply") + TURNED),
    "ply-face-normals": shape("ply", text("filename", "files/gem.ply") + flag("face_normals", "true") + TURNED),
    "instance": scene(
        SKY,
        LAMP,
        FLOOR,
        f"""<shape type='shapegroup' id='group'>
  <shape type='sphere'><float name='radius' value='0.5'/>{LEAF}</shape>
  <shape type='cube'>{TURNED.replace('<rotate', "<scale value='0.3'/><rotate")}{bsdf('plastic')}</shape>
</shape>
<shape type='instance'><ref id='group'/><transform name='to_world'><translate x='-1' z='0.6'/></transform></shape>
<shape type='instance'>
  <ref id='group'/>
  <transform name='to_world'><scale x='0.6' y='1.5' z='0.9'/><rotate z='1' angle='50'/><translate x='1' z='0.6'/></transform>
</shape>""",
    ),
    "obj-normals": shape("obj", text("filename", "files/smooth.obj") + TURNED),
    "ply-normals": shape("ply", text("filename", "files/smooth.ply") + TURNED),
    "serialized": shape("serialized", text("filename", "files/two.serialized") + TURNED),
    "serialized-second": shape("serialized", text("filename", "files/two.serialized") + "<integer name='shape_index' value='1'/>" + TURNED),
    "default-bsdf": scene(
        SKY,
        LAMP,
        FLOOR,
        "<shape type='cube'><transform name='to_world'><scale value='0.7'/><rotate z='1' angle='30'/><translate"
        " z='0.8'/></transform></shape>",
    ),
    "flip-normals": scene(LAMP, FLOOR, f"<shape type='sphere'>{SPHERE}{flag('flip_normals', 'true')}{bsdf('diffuse')}</shape>"),
}

BSDFS = {
    "diffuse": subject(bsdf("diffuse")),
    "diffuse-color": subject(bsdf("diffuse", rgb("reflectance", "0.8, 0.3, 0.1"))),
    "dielectric": subject(bsdf("dielectric")),
    "dielectric-water-in-glass": subject(bsdf("dielectric", text("int_ior", "water") + number("ext_ior", 1.2))),
    "dielectric-colored": subject(
        bsdf("dielectric", rgb("specular_transmittance", "0.9, 0.6, 0.3") + rgb("specular_reflectance", "0.2, 0.5, 1"))
    ),
    "thindielectric": subject(bsdf("thindielectric")),
    "thindielectric-diamond": subject(bsdf("thindielectric", text("int_ior", "diamond") + rgb("specular_transmittance", "0.9, 0.6, 0.3"))),
    "roughdielectric": subject(bsdf("roughdielectric")),
    "roughdielectric-ggx": subject(bsdf("roughdielectric", GGX + number("alpha", 0.3) + number("int_ior", 1.7))),
    "roughdielectric-anisotropic": subject(bsdf("roughdielectric", number("alpha_u", 0.05) + number("alpha_v", 0.4))),
    "roughdielectric-all-normals": subject(bsdf("roughdielectric", GGX + number("alpha", 0.2) + flag("sample_visible", "false"))),
    "conductor": subject(bsdf("conductor")),
    "conductor-gold": subject(bsdf("conductor", text("material", "Au"))),
    "conductor-eta-k": subject(
        bsdf("conductor", rgb("eta", "0.2, 0.9, 1.5") + rgb("k", "3.9, 2.4, 1.9") + rgb("specular_reflectance", "0.9, 0.8, 0.7"))
    ),
    "roughconductor": subject(bsdf("roughconductor")),
    "roughconductor-copper-ggx": subject(bsdf("roughconductor", text("material", "Cu") + GGX + number("alpha", 0.35))),
    "roughconductor-anisotropic": subject(
        bsdf("roughconductor", text("material", "Al") + number("alpha_u", 0.05) + number("alpha_v", 0.4))
    ),
    "roughconductor-textured": subject(
        bsdf("roughconductor", text("material", "Ag") + GREY.format("alpha") + bitmap("specular_reflectance"))
    ),
    "plastic": subject(bsdf("plastic")),
    "plastic-nonlinear": subject(
        bsdf("plastic", rgb("diffuse_reflectance", "0.1, 0.5, 0.8") + flag("nonlinear", "true") + number("int_ior", 1.9))
    ),
    "plastic-specular": subject(bsdf("plastic", rgb("specular_reflectance", "0.5, 0.7, 0.9") + bitmap("diffuse_reflectance"))),
    "roughplastic": subject(bsdf("roughplastic")),
    "roughplastic-ggx": subject(
        bsdf("roughplastic", GGX + number("alpha", 0.3) + number("int_ior", 1.7) + rgb("diffuse_reflectance", "0.1, 0.5, 0.8"))
    ),
    "roughplastic-nonlinear": subject(
        bsdf(
            "roughplastic",
            flag("nonlinear", "true") + rgb("diffuse_reflectance", "0.1, 0.5, 0.8") + rgb("specular_reflectance", "0.5, 0.7, 0.9"),
        )
    ),
    "principled": subject(bsdf("principled")),
    "principled-metallic": subject(
        bsdf("principled", COAT + number("metallic", 0.9) + number("roughness", 0.3) + number("anisotropic", 0.7))
    ),
    "principled-glass": subject(bsdf("principled", COAT + number("spec_trans", 0.9) + number("roughness", 0.2) + number("eta", 1.4))),
    "principled-coat": subject(
        bsdf("principled", COAT + number("clearcoat", 1) + number("clearcoat_gloss", 0.8) + number("roughness", 0.6))
    ),
    "principled-cloth": subject(
        bsdf("principled", COAT + number("sheen", 0.8) + number("sheen_tint", 0.5) + number("flatness", 0.6) + number("roughness", 0.7))
    ),
    "principled-tint": subject(bsdf("principled", COAT + number("spec_tint", 0.8) + number("specular", 0.9) + GREY.format("roughness"))),
    "blendbsdf": subject(bsdf("blendbsdf", number("weight", 0.3) + LEAF + bsdf("conductor"))),
    "blendbsdf-rough": subject(bsdf("blendbsdf", number("weight", 0.3) + LEAF + bsdf("roughconductor", number("alpha", 0.3)))),
    "blendbsdf-textured": subject(bsdf("blendbsdf", GREY.format("weight") + LEAF + bsdf("roughconductor"))),
    "mask": subject(bsdf("mask", LEAF)),
    "mask-textured": subject(bsdf("mask", GREY.format("opacity") + bsdf("twosided", LEAF))),
    "twosided": subject(
        bsdf("twosided", bsdf("plastic", rgb("diffuse_reflectance", "0.3, 0.6, 0.2"))),
        "rectangle",
        "<transform name='to_world'><rotate x='1' angle='-60'/><translate z='1.2'/></transform>",
    ),
    "twosided-of-two": subject(
        bsdf("twosided", LEAF + bsdf("roughconductor", number("alpha", 0.3))),
        "cylinder",
        "<transform name='to_world'><scale z='1.2'/><translate z='0.2'/></transform>",
    ),
    "one-sided-back": subject(LEAF, "cylinder", "<transform name='to_world'><scale z='1.2'/><translate z='0.2'/></transform>"),
    "bumpmap": subject(bsdf("bumpmap", bitmap("arbitrary", flag("raw", "true"), "bump.png") + bsdf("diffuse"))),
    "bumpmap-scale": subject(
        bsdf("bumpmap", bitmap("arbitrary", flag("raw", "true"), "bump.png") + number("scale", 0.3) + bsdf("roughplastic"))
    ),
    "bumpmap-without-shadowing": subject(
        bsdf(
            "bumpmap",
            bitmap("arbitrary", flag("raw", "true"), "bump.png")
            + flag("use_shadowing_function", "false")
            + flag("flip_invalid_normals", "false")
            + bsdf("diffuse"),
        )
    ),
    "normalmap": subject(bsdf("normalmap", bitmap("normalmap", flag("raw", "true"), "normal.png") + bsdf("diffuse"))),
    "normalmap-rough": subject(
        bsdf("normalmap", bitmap("normalmap", flag("raw", "true"), "normal.png") + bsdf("roughconductor", number("alpha", 0.3)))
    ),
    "normalmap-without-shadowing": subject(
        bsdf(
            "normalmap",
            bitmap("normalmap", flag("raw", "true"), "normal.png")
            + flag("use_shadowing_function", "false")
            + flag("flip_invalid_normals", "false")
            + bsdf("diffuse"),
        )
    ),
    "null": subject(bsdf("null")),
    "roughdielectric-textured": subject(bsdf("roughdielectric", GREY.format("alpha") + bitmap("specular_transmittance"))),
    "roughplastic-textured": subject(bsdf("roughplastic", bitmap("diffuse_reflectance") + GREY.format("specular_reflectance"))),
    "principled-textured": subject(bsdf("principled", bitmap("base_color") + GREY.format("metallic") + GREY.format("roughness"))),
    "mask-of-conductor": subject(bsdf("mask", number("opacity", 0.7) + bsdf("conductor"))),
    "twosided-bumpmap": subject(
        bsdf("twosided", bsdf("bumpmap", bitmap("arbitrary", flag("raw", "true"), "bump.png") + number("scale", 0.3) + LEAF)),
        "cylinder",
        "<transform name='to_world'><scale z='1.2'/><translate z='0.2'/></transform>",
    ),
    "normalmap-plastic": subject(
        bsdf("normalmap", bitmap("normalmap", flag("raw", "true"), "normal.png") + bsdf("roughplastic", number("alpha", 0.2)))
    ),
}

EMITTERS = {
    "area": light(BULB.format("<emitter type='area'/>")),
    "area-color": light(BULB.format("<emitter type='area'><rgb name='radiance' value='9, 6, 3'/></emitter>")),
    "area-textured": light(LAMP.replace("<rgb name='radiance' value='5, 4.5, 4'/>", bitmap("radiance", flag("raw", "true")))),
    "area-mesh": light(
        f"<shape type='obj'>{text('filename', 'files/gem.obj')}{flag('face_normals', 'true')}<transform name='to_world'><translate x='-1'"
        " y='-1.5' z='3.5'/></transform><emitter type='area'><rgb name='radiance' value='3, 2, 1'/></emitter></shape>"
    ),
    "area-smooth-mesh": light(
        f"<shape type='obj'>{text('filename', 'files/gem.obj')}<transform name='to_world'><translate x='-1' y='-1.5'"
        " z='3.5'/></transform><emitter type='area'><rgb name='radiance' value='3, 2, 1'/></emitter></shape>"
    ),
    "area-opposed-normals": light(
        "<shape type='obj'><string name='filename' value='files/opposed.obj'/>"
        "<emitter type='area'><rgb name='radiance' value='3, 2, 1'/></emitter></shape>"
    ),
    "area-cylinder": light(
        "<shape type='cylinder'><point name='p0' x='-2' y='-1' z='3'/><point name='p1' x='1' y='0' z='4'/><float name='radius'"
        " value='0.4'/><emitter type='area'><rgb name='radiance' value='3, 2, 1'/></emitter></shape>"
    ),
    "point": light(
        "<emitter type='point'><point name='position' x='-1' y='-2' z='4'/><rgb name='intensity' value='20, 15, 10'/></emitter>"
    ),
    "spot": light(f"<emitter type='spot'>{AIM}<rgb name='intensity' value='30, 25, 20'/></emitter>"),
    "spot-wide": light(
        f"<emitter type='spot'>{AIM}<rgb name='intensity' value='30, 25,"
        f" 20'/>{number('cutoff_angle', 35)}{number('beam_width', 10)}</emitter>"
    ),
    "spot-textured": light(
        f"<emitter type='spot'>{AIM}{number('cutoff_angle', 30)}{bitmap('texture')}<rgb name='intensity' value='30'/></emitter>"
    ),
    "point-moved": light(
        "<emitter type='point'><transform name='to_world'><translate x='-1' y='-2' z='4'/></transform>"
        "<rgb name='intensity' value='20, 15, 10'/></emitter>"
    ),
    "several": light(
        SKY, LAMP, "<emitter type='point'><point name='position' x='2' y='-2' z='2'/><rgb name='intensity' value='3, 1, 1'/></emitter>"
    ),
    "area-inside": scene(
        "<shape type='sphere'><float name='radius' value='20'/><boolean name='flip_normals' value='true'/>"
        "<emitter type='area'><rgb name='radiance' value='0.6, 0.5, 0.4'/></emitter></shape>",
        FLOOR,
        f"<shape type='sphere'>{SPHERE}{bsdf('plastic')}</shape>",
    ),
    "directional": light(
        "<emitter type='directional'><vector name='direction' x='1' y='1' z='-2'/><rgb name='irradiance' value='2, 1.5, 1'/></emitter>"
    ),
    "directional-moved": light(f"<emitter type='directional'>{AIM}<rgb name='irradiance' value='2, 1.5, 1'/></emitter>"),
    "constant": light("<emitter type='constant'/>"),
    "constant-color": light(SKY),
    "envmap": light("<emitter type='envmap'><string name='filename' value='files/sky.exr'/></emitter>"),
    "envmap-turned": light(
        "<emitter type='envmap'><string name='filename' value='files/sky.exr'/><float name='scale' value='2'/><transform"
        " name='to_world'><rotate x='1' angle='90'/><rotate z='1' angle='70'/></transform></emitter>"
    ),
    "projector": light(f"<emitter type='projector'>{AIM}{bitmap('irradiance')}{number('scale', 20)}{number('fov', 40)}</emitter>"),
    "projector-even": light(
        f"<emitter type='projector'>{AIM}<rgb name='irradiance' value='20, 15, 10'/><string name='focal_length' value='35mm'/></emitter>"
    ),
}

WRAPPED = "<transform name='to_uv'><translate x='-0.3' y='-0.2'/><scale value='2.6'/></transform>"
TEXTURES = {
    "bitmap": texture(bitmap("reflectance")),
    "bitmap-raw": texture(bitmap("reflectance", flag("raw", "true"))),
    "bitmap-nearest": texture(bitmap("reflectance", text("filter_type", "nearest"))),
    "bitmap-repeat": texture(bitmap("reflectance", WRAPPED)),
    "bitmap-mirror": texture(bitmap("reflectance", WRAPPED + text("wrap_mode", "mirror"))),
    "bitmap-clamp": texture(bitmap("reflectance", WRAPPED + text("wrap_mode", "clamp"))),
    "bitmap-clamp-nearest": texture(bitmap("reflectance", WRAPPED + text("wrap_mode", "clamp") + text("filter_type", "nearest"))),
    "bitmap-turned": texture(bitmap("reflectance", "<transform name='to_uv'><rotate z='1' angle='30'/><scale x='2' y='0.7'/></transform>")),
    "bitmap-exr": texture(bitmap("reflectance", "", "half.exr")),
    "bitmap-grey": texture(bitmap("reflectance", "", "grey.png")),
    "checkerboard": texture("<texture name='reflectance' type='checkerboard'/>"),
    "checkerboard-turned": texture(
        "<texture name='reflectance' type='checkerboard'><rgb name='color0' value='0.9, 0.1, 0.2'/><rgb name='color1' value='0.1, 0.6,"
        " 0.3'/><transform name='to_uv'><rotate z='1' angle='30'/><scale x='3' y='1.7'/></transform></texture>"
    ),
    "checkerboard-of-bitmap": texture(
        f"<texture name='reflectance' type='checkerboard'>{bitmap('color0')}<rgb name='color1' value='0.1'/></texture>"
    ),
    "rawconstant": texture("<texture name='reflectance' type='rawconstant'><vector name='value' value='0.7, 0.5, 0.1'/></texture>"),
}

CROP = (
    "<integer name='crop_offset_x' value='3'/><integer name='crop_offset_y' value='2'/><integer name='crop_width' value='8'/><integer"
    " name='crop_height' value='6'/>"
)
FILMS = {
    "default": film(""),
    "box": film("<rfilter type='box'/>"),
    "tent": film("<rfilter type='tent'/>"),
    "tent-radius": film("<rfilter type='tent'><float name='radius' value='1.7'/></rfilter>"),
    "gaussian": film("<rfilter type='gaussian'/>"),
    "gaussian-stddev": film("<rfilter type='gaussian'><float name='stddev' value='0.9'/></rfilter>"),
    "mitchell": film("<rfilter type='mitchell'/>"),
    "mitchell-b-c": film("<rfilter type='mitchell'><float name='B' value='0.1'/><float name='C' value='0.6'/></rfilter>"),
    "catmullrom": film("<rfilter type='catmullrom'/>"),
    "lanczos": film("<rfilter type='lanczos'/>"),
    "lanczos-lobes": film("<rfilter type='lanczos'><integer name='lobes' value='2'/></rfilter>"),
    "sample-border": film(flag("sample_border", "true") + "<rfilter type='gaussian'><float name='stddev' value='0.9'/></rfilter>"),
    "crop": film(CROP + "<rfilter type='box'/>", (16, 12)),
    "crop-gaussian": film(CROP + "<rfilter type='gaussian'/>", (16, 12)),
}

FOV = number("fov", 40)
SENSORS = {
    "perspective": camera(),
    "fov-axis-x": camera(inside=FOV + text("fov_axis", "x")),
    "fov-axis-y": camera(inside=FOV + text("fov_axis", "y")),
    "fov-axis-diagonal": camera(inside=FOV + text("fov_axis", "diagonal")),
    "fov-axis-smaller": camera(inside=FOV + text("fov_axis", "smaller")),
    "fov-axis-larger": camera(inside=FOV + text("fov_axis", "larger"), size=(24, 48)),
    "focal-length": camera(inside=text("focal_length", "80mm")),
    "principal-point": camera(inside=FOV + number("principal_point_offset_x", 0.2) + number("principal_point_offset_y", -0.1)),
    "clip": camera(inside=FOV + number("near_clip", 5.2) + number("far_clip", 6.6)),
    "thinlens": camera("thinlens", FOV + number("aperture_radius", 0.4) + number("focus_distance", 5.2)),
    "thinlens-far": camera("thinlens", FOV + number("aperture_radius", 0.2)),
    "orthographic": scene(
        SKY,
        LAMP,
        FLOOR,
        f"<shape type='sphere'>\n  {SPHERE}\n  {bsdf('diffuse')}\n</shape>",
        camera=sensor("orthographic", "", FILM, VIEW.replace("<lookat", "<scale x='2.5' y='2'/><lookat")),
    ),
}

INTEGRATORS = {
    "path": integrator("<integrator type='path'/>"),
    "path-depth-1": integrator("<integrator type='path'><integer name='max_depth' value='1'/></integrator>"),
    "path-depth-2": integrator("<integrator type='path'><integer name='max_depth' value='2'/></integrator>"),
    "path-depth-3": integrator("<integrator type='path'><integer name='max_depth' value='3'/></integrator>"),
    "path-rr-depth": integrator("<integrator type='path'><integer name='rr_depth' value='2'/></integrator>"),
    "path-hide-emitters": integrator("<integrator type='path'><boolean name='hide_emitters' value='true'/></integrator>"),
    "direct": integrator("<integrator type='direct'/>"),
    "direct-emitters-only": integrator("<integrator type='direct'><integer name='bsdf_samples' value='0'/></integrator>"),
    "direct-bsdf-only": integrator("<integrator type='direct'><integer name='emitter_samples' value='0'/></integrator>"),
    "direct-hide-emitters": integrator("<integrator type='direct'><boolean name='hide_emitters' value='true'/></integrator>"),
    "aov": integrator("<integrator type='aov'><string name='aovs' value='dd.y:depth,nn:sh_normal'/><integrator type='path'/></integrator>"),
    "moment": integrator("<integrator type='moment'><integrator type='direct'/></integrator>"),
    "volpath": integrator("<integrator type='volpath'/>"),
    "volpathmis": integrator("<integrator type='volpathmis'/>"),
    "ptracer": integrator("<integrator type='ptracer'/>").replace('"conductor"', '"diffuse"'),
}


def spectrum(inside, kind="d65"):
    return f"<spectrum name='radiance' type='{kind}'>{inside}</spectrum>"


PAIRS = "400:0.1, 480:0.3, 550:0.9, 620:0.4, 700:0.2"
SPECTRA = {
    "d65": lit_by(spectrum("")),
    "d65-scale": lit_by(spectrum(number("scale", 0.5))),
    "d65-color": lit_by(spectrum(rgb("color", "0.8, 0.5, 0.2"))),
    "blackbody": lit_by(spectrum(number("temperature", 2000), "blackbody")),
    "blackbody-part": lit_by(
        spectrum(number("temperature", 5000) + number("wavelength_min", 430) + number("wavelength_max", 650), "blackbody")
    ),
    "regular": lit_by(
        spectrum(number("wavelength_min", 400) + number("wavelength_max", 700) + text("values", "0.1, 0.5, 0.9, 0.3"), "regular")
    ),
    "irregular": lit_by(spectrum(text("wavelengths", "400, 480, 550, 620, 700") + text("values", "0.1, 0.3, 0.9, 0.4, 0.2"), "irregular")),
    "uniform": lit_by(spectrum(number("value", 0.7), "uniform")),
    "emitted-number": lit_by("<spectrum name='radiance' value='0.7'/>"),
    "emitted-float": lit_by("<float name='radiance' value='0.7'/>"),
    "emitted-pairs": lit_by(f"<spectrum name='radiance' value='{PAIRS}'/>"),
    "emitted-rgb": lit_by(rgb("radiance", "0.7, 0.2, 0.9")),
    "emitted-srgb": lit_by(spectrum(rgb("color", "0.7, 0.2, 0.9"), "srgb")),
    "reflected-file": subject(bsdf("diffuse", "<spectrum name='reflectance' filename='files/green.spd'/>")),
    "reflected-number": subject(bsdf("diffuse", "<spectrum name='reflectance' value='0.3'/>")),
    "reflected-pairs": subject(bsdf("diffuse", f"<spectrum name='reflectance' value='{PAIRS}'/>")),
    "reflected-regular": subject(
        bsdf(
            "diffuse",
            spectrum(
                number("wavelength_min", 400) + number("wavelength_max", 700) + text("values", "0.1, 0.5, 0.9, 0.3"), "regular"
            ).replace("radiance", "reflectance"),
        )
    ),
    "reflected-uniform": subject(bsdf("diffuse", spectrum(number("value", 0.3), "uniform").replace("radiance", "reflectance"))),
    "index-pairs": subject(
        bsdf(
            "conductor",
            "<spectrum name='eta' value='400:1.6, 500:1.1, 600:0.3, 700:0.2'/><spectrum name='k' value='400:2, 500:2.5, 600:3.3, 700:4'/>",
        )
    ),
}

WHITE = number("albedo", 0.9)
MEDIA = {
    "homogeneous": medium(""),
    "homogeneous-color": medium(rgb("sigma_t", "0.25, 0.5, 1") + number("scale", 2) + rgb("albedo", "0.9, 0.6, 0.3")),
    "homogeneous-scale": medium(number("scale", 0.3) + WHITE),
    "isotropic": medium(WHITE + "<phase type='isotropic'/>"),
    "hg": medium(WHITE + "<phase type='hg'/>"),
    "hg-backward": medium(WHITE + "<phase type='hg'><float name='g' value='-0.5'/></phase>"),
    "rayleigh": medium(WHITE + "<phase type='rayleigh'/>"),
    "colored-albedo": medium(
        number("sigma_t", 2) + rgb("albedo", "0.95, 0.7, 0.4") + "<phase type='hg'><float name='g' value='0.6'/></phase>"
    ),
    "round-camera": scene(
        LAMP,
        FLOOR,
        f"<shape type='sphere'>{SPHERE}{LEAF}</shape>",
        integrator=VOLPATH,
        camera=sensor(
            inside="<float name='fov' value='30'/><medium type='homogeneous' id='fog'><float name='sigma_t' value='0.1'/></medium>"
        ),
    ),
    "in-glass": medium(number("sigma_t", 0.7) + WHITE, bsdf("dielectric", number("int_ior", 1.3))),
    "in-rough-glass": medium(number("sigma_t", 0.7) + WHITE, bsdf("roughdielectric", number("alpha", 0.3))),
}

GROUPS = {
    "shape": SHAPES,
    "bsdf": BSDFS,
    "emitter": EMITTERS,
    "texture": TEXTURES,
    "film": FILMS,
    "sensor": SENSORS,
    "integrator": INTEGRATORS,
    "spectrum": SPECTRA,
    "medium": MEDIA,
}
SCENES = {f"{group}-{name}": xml for group, scenes in GROUPS.items() for name, xml in scenes.items()}
# These have no color in Mitsuba's RGB mode, which refuses them: they are compared with its spectral mode.
SPECTRAL = ["spectrum-blackbody", "spectrum-blackbody-part", "spectrum-regular", "spectrum-irregular", "spectrum-reflected-regular"]
