//! One scene in several formats gives one picture. All formats become the same plugins with the same numbers, so the pictures
//! are the same to the last bit, and no tolerance is needed: where they differ, one of the importers means something else.

use std::fmt::Write as _;
use std::sync::Arc;

use crate::gltf_file::{GltfFile, Numbers};
use crate::progressive::Job;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use photonfarm::import::load_bytes;
use photonfarm::scene::Scene;
use photonfarm::scene::bundle::Bundle;
use photonfarm::scene::description::{Parameter, PluginClass, SceneDescription, Value as Plain};
use serde_json::{Value, json};

/// The square [−1, 1]² in the xy plane; v = 0 is its top.
const SQUARE: Mesh = Mesh {
    positions: &[-1., -1., 0., 1., -1., 0., 1., 1., 0., -1., 1., 0.],
    coordinates: &[0., 1., 1., 1., 1., 0., 0., 0.],
    indices: &[0, 1, 2, 0, 2, 3],
};

/// The cube [−1, 1]³.
const CUBE: Mesh = Mesh {
    positions: &[
        -1., -1., -1., 1., -1., -1., 1., 1., -1., -1., 1., -1., -1., -1., 1., 1., -1., 1., 1., 1., 1., -1., 1., 1.,
    ],
    coordinates: &[0., 0., 1., 0., 1., 1., 0., 1., 0., 1., 1., 1., 1., 0., 0., 0.],
    indices: &[
        0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 3, 7, 6, 3, 6, 2, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5,
    ],
};

struct Mesh {
    positions: &'static [f32],
    coordinates: &'static [f32],
    indices: &'static [u16],
}

impl Mesh {
    fn ply(&self) -> String {
        let (vertices, faces) = (self.positions.len() / 3, self.indices.len() / 3);
        let mut text = format!(
            "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\n\
             property float u\nproperty float v\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
        );
        for (position, coordinates) in self.positions.chunks(3).zip(self.coordinates.chunks(2)) {
            position.iter().chain(coordinates).for_each(|number| write!(text, "{number} ").unwrap());
            text.push('\n');
        }
        for corners in self.indices.chunks(3) {
            writeln!(text, "3 {} {} {}", corners[0], corners[1], corners[2]).unwrap();
        }
        text
    }

    fn add_to(&self, file: &mut GltfFile) {
        file.accessor("VEC3", Numbers::F32(self.positions));
        file.accessor("VEC2", Numbers::F32(self.coordinates));
        file.accessor("SCALAR", Numbers::U16(self.indices));
    }
}

/// Two by two tiles, each of its own color.
fn tiles() -> Vec<u8> {
    let pixels = [[200, 30, 30], [30, 180, 60], [40, 60, 210], [230, 220, 90]].concat();
    let image = image::RgbImage::from_raw(2, 2, pixels).expect("four pixels");
    let mut file = std::io::Cursor::new(Vec::new());
    image.write_to(&mut file, image::ImageFormat::Png).expect("images can be written");
    file.into_inner()
}

/// Floor, wall, a metal and a glass block, a lamp, a point light and a spot light.
const XML: &str = "<scene version='3.0.0'>
  <sensor type='perspective'>
    <float name='fov' value='$angle'/><string name='fov_axis' value='y'/>
    <float name='near_clip' value='0.1'/><float name='far_clip' value='100'/>
    <transform name='to_world'><lookat origin='0, 1, 5' target='0, 1, 0' up='0, 1, 0'/></transform>
  </sensor>
  <shape type='ply'>
    <string name='filename' value='square.ply'/><boolean name='face_normals' value='true'/>
    <transform name='to_world'><matrix value='3 0 0 0  0 0 1 0  0 -3 0 0  0 0 0 1'/></transform>
    <bsdf type='twosided'><bsdf type='principled'>
      <texture type='bitmap' name='base_color'><string name='filename' value='tiles.png'/><string name='filter_type' value='nearest'/></texture>
      <float name='metallic' value='0'/><float name='roughness' value='0.9'/><float name='eta' value='1.5'/>
    </bsdf></bsdf>
  </shape>
  <shape type='ply'>
    <string name='filename' value='square.ply'/><boolean name='face_normals' value='true'/>
    <transform name='to_world'><scale x='3' y='2' z='1'/><translate x='0' y='1' z='-2'/></transform>
    <bsdf type='principled'>
      <rgb name='base_color' value='0.7, 0.6, 0.5'/>
      <float name='metallic' value='0'/><float name='roughness' value='1'/><float name='eta' value='1.5'/>
    </bsdf>
  </shape>
  <shape type='ply'>
    <string name='filename' value='cube.ply'/><boolean name='face_normals' value='true'/>
    <transform name='to_world'><matrix value='0.32 0 0.24 -0.9  0 0.4 0 0.4  -0.24 0 0.32 -0.5  0 0 0 1'/></transform>
    <bsdf type='principled'>
      <rgb name='base_color' value='0.9, 0.7, 0.3'/>
      <float name='metallic' value='1'/><float name='roughness' value='0.3'/><float name='eta' value='1.5'/>
    </bsdf>
  </shape>
  <shape type='ply'>
    <string name='filename' value='cube.ply'/><boolean name='face_normals' value='true'/>
    <transform name='to_world'><scale value='0.4'/><translate x='0.9' y='0.45' z='0.3'/></transform>
    <bsdf type='principled'>
      <rgb name='base_color' value='0.95'/><float name='metallic' value='0'/><float name='roughness' value='0.1'/>
      <float name='spec_trans' value='1'/><float name='eta' value='1.3'/>
    </bsdf>
  </shape>
  <shape type='ply'>
    <string name='filename' value='square.ply'/><boolean name='face_normals' value='true'/>
    <transform name='to_world'><matrix value='0.5 0 0 0  0 0 -1 2.5  0 0.5 0 0  0 0 0 1'/></transform>
    <bsdf type='principled'>
      <rgb name='base_color' value='0'/><float name='metallic' value='0'/><float name='roughness' value='1'/><float name='eta' value='1.5'/>
    </bsdf>
    <emitter type='area'><rgb name='radiance' value='8, 4, 2'/></emitter>
  </shape>
  <emitter type='point'><point name='position' value='-2, 2, 2'/><rgb name='intensity' value='1, 2, 4'/></emitter>
  <emitter type='spot'>
    <transform name='to_world'><lookat origin='1.5, 2.4, 0' target='1.5, 0, 0' up='0, 0, -1'/></transform>
    <rgb name='intensity' value='6, 6, 6'/><float name='cutoff_angle' value='$outer'/><float name='beam_width' value='$inner'/>
  </emitter>
</scene>";

/// Angles of the camera, of the spot light's outer and of its inner cone, radians as in glTF.
const ANGLES: [f64; 3] = [0.7, 0.5, 0.375];

fn xml() -> String {
    let [angle, outer, inner] = ANGLES.map(|angle| angle.to_degrees().to_string());
    XML.replace("$angle", &angle).replace("$outer", &outer).replace("$inner", &inner)
}

fn json() -> String {
    let [angle, outer, inner] = ANGLES.map(f64::to_degrees);
    let rgb = |value: Value| json!({"type": "rgb", "value": value});
    let mesh = |name: &str, to_world: Value, bsdf: Value| json!({"type": "ply", "filename": name, "face_normals": true, "to_world": to_world, "bsdf": bsdf});
    let surface = |color: Value, metallic: f64, roughness: f64| json!({"type": "principled", "base_color": color, "metallic": metallic, "roughness": roughness, "eta": 1.5});
    let image = json!({"type": "bitmap", "filename": "tiles.png", "filter_type": "nearest"});
    let mut glass = surface(rgb(json!([0.95, 0.95, 0.95])), 0.0, 0.1);
    (glass["spec_trans"], glass["eta"]) = (json!(1.0), json!(1.3));
    let mut lamp = mesh(
        "square.ply",
        json!([{"matrix": [[0.5, 0, 0, 0], [0, 0, -1, 2.5], [0, 0.5, 0, 0], [0, 0, 0, 1]]}]),
        surface(rgb(json!([0, 0, 0])), 0.0, 1.0),
    );
    lamp["emitter"] = json!({"type": "area", "radiance": rgb(json!([8, 4, 2]))});
    let scene = json!({
        "type": "scene",
        "camera": {
            "type": "perspective", "fov": angle, "fov_axis": "y", "near_clip": 0.1, "far_clip": 100.0,
            "to_world": [{"look_at": {"origin": [0, 1, 5], "target": [0, 1, 0], "up": [0, 1, 0]}}],
        },
        "floor": mesh(
            "square.ply",
            json!([{"matrix": [[3, 0, 0, 0], [0, 0, 1, 0], [0, -3, 0, 0], [0, 0, 0, 1]]}]),
            json!({"type": "twosided", "bsdf": surface(image, 0.0, 0.9)}),
        ),
        "wall": mesh(
            "square.ply",
            json!([{"scale": [3, 2, 1]}, {"translate": [0, 1, -2]}]),
            surface(rgb(json!([0.7, 0.6, 0.5])), 0.0, 1.0),
        ),
        "metal": mesh(
            "cube.ply",
            json!([{"matrix": [[0.32, 0, 0.24, -0.9], [0, 0.4, 0, 0.4], [-0.24, 0, 0.32, -0.5], [0, 0, 0, 1]]}]),
            surface(rgb(json!([0.9, 0.7, 0.3])), 1.0, 0.3),
        ),
        "glass": mesh("cube.ply", json!([{"scale": 0.4}, {"translate": [0.9, 0.45, 0.3]}]), glass),
        "lamp": lamp,
        "bulb": {"type": "point", "position": [-2, 2, 2], "intensity": rgb(json!([1, 2, 4]))},
        "spot": {
            "type": "spot", "intensity": rgb(json!([6, 6, 6])), "cutoff_angle": outer, "beam_width": inner,
            "to_world": [{"look_at": {"origin": [1.5, 2.4, 0], "target": [1.5, 0, 0], "up": [0, 0, -1]}}],
        },
    });
    scene.to_string()
}

fn gltf() -> GltfFile {
    let [angle, outer, inner] = ANGLES;
    let mesh = |first: usize, material: usize| {
        let attributes = json!({"POSITION": first, "TEXCOORD_0": first + 1});
        json!({"primitives": [{"attributes": attributes, "indices": first + 2, "material": material}]})
    };
    let surface = |color: [f64; 3], metallic: f64, roughness: f64| {
        let [red, green, blue] = color;
        json!({"baseColorFactor": [red, green, blue, 1], "metallicFactor": metallic, "roughnessFactor": roughness})
    };
    let image = format!("data:image/png;base64,{}", STANDARD.encode(tiles()));
    let mut file = GltfFile::new(json!({
        "scene": 0, "scenes": [{"nodes": [0, 1, 2, 3, 4, 5, 6, 7]}],
        "nodes": [
            {"mesh": 0, "matrix": [3, 0, 0, 0, 0, 0, -3, 0, 0, 1, 0, 0, 0, 0, 0, 1]},
            {"mesh": 1, "scale": [3, 2, 1], "translation": [0, 1, -2]},
            {"mesh": 2, "matrix": [0.32, 0, -0.24, 0, 0, 0.4, 0, 0, 0.24, 0, 0.32, 0, -0.9, 0.4, -0.5, 1]},
            {"mesh": 3, "scale": [0.4, 0.4, 0.4], "translation": [0.9, 0.45, 0.3]},
            {"mesh": 4, "matrix": [0.5, 0, 0, 0, 0, 0, 0.5, 0, 0, -1, 0, 0, 0, 2.5, 0, 1]},
            {"camera": 0, "translation": [0, 1, 5]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [-2, 2, 2]},
            {"extensions": {"KHR_lights_punctual": {"light": 1}}, "matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 1.5, 2.4, 0, 1]},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": angle, "znear": 0.1, "zfar": 100}}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "point", "color": [0.25, 0.5, 1], "intensity": 4},
            {"type": "spot", "intensity": 6, "spot": {"innerConeAngle": inner, "outerConeAngle": outer}},
        ]}},
        "meshes": [mesh(0, 0), mesh(0, 1), mesh(3, 2), mesh(3, 3), mesh(0, 4)],
        "materials": [
            {"doubleSided": true,
             "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0, "roughnessFactor": 0.9}},
            {"pbrMetallicRoughness": surface([0.7, 0.6, 0.5], 0.0, 1.0)},
            {"pbrMetallicRoughness": surface([0.9, 0.7, 0.3], 1.0, 0.3)},
            {"pbrMetallicRoughness": surface([0.95; 3], 0.0, 0.1), "extensions": {
                "KHR_materials_transmission": {"transmissionFactor": 1},
                "KHR_materials_ior": {"ior": 1.3},
                "KHR_materials_volume": {"thicknessFactor": 0.8},
            }},
            {"pbrMetallicRoughness": surface([0.0; 3], 0.0, 1.0), "emissiveFactor": [1, 0.5, 0.25],
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 8}}},
        ],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": 9728}],
        "images": [{"uri": image}],
    }));
    SQUARE.add_to(&mut file);
    CUBE.add_to(&mut file);
    file
}

fn load(name: &str, bytes: &[u8]) -> SceneDescription {
    load_bytes(name, bytes, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The scene with its files beside it, as in a folder.
fn with_files(mut description: SceneDescription) -> SceneDescription {
    let files = [("square.ply", SQUARE.ply().into()), ("cube.ply", CUBE.ply().into()), ("tiles.png", tiles())];
    let files = files.map(|(name, content): (&str, Vec<u8>)| (name.to_owned(), Arc::from(content)));
    description.bundle = Bundle::Archive(Arc::new(files.into()));
    description
}

/// Takes the place of the sensor's film: glTF has no size of pictures, and 768 × 576 pixels are more than it takes here.
fn with_small_film(mut description: SceneDescription) -> SceneDescription {
    let film =
        load("film.xml", b"<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'/></sensor></scene>");
    let mut film = film.root.children[0].node.children[0].clone();
    for (name, side) in [("width", 48), ("height", 36)] {
        let node = Arc::make_mut(&mut film.node);
        node.parameters.push(Parameter {
            name: name.to_owned(),
            value: Plain::Integer(side),
            location: node.location.clone(),
        });
    }
    let sensor = description.root.children.iter_mut().find(|child| child.node.class == PluginClass::Sensor);
    let sensor = Arc::make_mut(&mut sensor.expect("the scene has a sensor").node);
    sensor.children.retain(|child| child.node.class != PluginClass::Film);
    sensor.children.push(film);
    description
}

/// The bits of a picture of two passes.
fn picture(description: &SceneDescription) -> Vec<u32> {
    let scene = Arc::new(Scene::prepare(description).unwrap_or_else(|error| panic!("{error}")));
    let estimate = Job::new(&scene, "sppm", r#"{"photons_per_pass": 8192}"#).run(2, 1);
    assert_eq!(estimate.non_finite(), 0);
    let picture = estimate.picture();
    let lit = picture.radiance.iter().filter(|radiance| **radiance != [0.0; 3]).count();
    assert!(2 * lit > picture.radiance.len(), "most of the picture is black");
    picture.radiance.iter().flatten().map(|channel| channel.to_bits()).collect()
}

#[test]
fn agreement_of_xml_json_and_gltf() {
    let scenes = [
        ("XML", with_files(load("room.xml", xml().as_bytes()))),
        ("JSON", with_files(load("room.json", json().as_bytes()))),
        ("glTF", load("room.gltf", gltf().text().as_bytes())),
        ("GLB", load("room.glb", &gltf().glb())),
    ];
    let scenes = scenes.map(|(format, scene)| (format, with_small_film(scene)));
    let expected = picture(&scenes[0].1);
    for (format, scene) in &scenes[1..] {
        assert!(picture(scene) == expected, "{format} and XML differ");
    }
}

/// The Cornell box in the names of Mitsuba 0.6.
const OLD_BOX: &str = "<scene version='0.5.0'>
  <integrator type='path'><integer name='maxDepth' value='9'/><boolean name='strictNormals' value='true'/></integrator>
  <sensor type='perspective'>
    <float name='fov' value='39'/><string name='fovAxis' value='smaller'/><float name='nearClip' value='0.1'/>
    <transform name='toWorld'><lookAt origin='0, 1, 4' target='0, 1, 0' up='0, 1, 0'/></transform>
    <sampler type='independent'><integer name='sampleCount' value='64'/></sampler>
    <film type='ldrfilm'>
      <integer name='width' value='32'/><integer name='height' value='32'/><string name='fileFormat' value='png'/>
      <string name='pixelFormat' value='rgb'/><float name='gamma' value='2.2'/><boolean name='banner' value='false'/><rfilter type='tent'/>
    </film>
  </sensor>
  <bsdf type='twosided' id='white'><bsdf type='diffuse'><rgb name='reflectance' value='0.725, 0.71, 0.68'/></bsdf></bsdf>
  <bsdf type='twosided' id='red'><bsdf type='diffuse'><rgb name='reflectance' value='0.63, 0.065, 0.05'/></bsdf></bsdf>
  <bsdf type='twosided' id='green'><bsdf type='diffuse'><rgb name='reflectance' value='0.14, 0.45, 0.091'/></bsdf></bsdf>
  <shape type='rectangle'><transform name='toWorld'><rotate x='1' angle='-90'/></transform><ref id='white'/></shape>
  <shape type='rectangle'>
    <transform name='toWorld'><rotate x='1' angle='90'/><translate x='0' y='2' z='0'/></transform><ref id='white'/>
  </shape>
  <shape type='rectangle'><transform name='toWorld'><translate x='0' y='1' z='-1'/></transform><ref id='white'/></shape>
  <shape type='rectangle'>
    <transform name='toWorld'><rotate y='1' angle='90'/><translate x='-1' y='1' z='0'/></transform><ref id='red'/>
  </shape>
  <shape type='rectangle'>
    <transform name='toWorld'><matrix value='0 0 -1 1 0 1 0 1 1 0 0 0 0 0 0 1'/></transform><ref id='green'/>
  </shape>
  <shape type='cube'>
    <transform name='toWorld'><scale value='0.3'/><rotate y='1' angle='-17'/><translate x='0.33' y='0.3' z='0.35'/></transform><ref id='white'/>
  </shape>
  <shape type='sphere'>
    <point name='center' x='-0.4' y='0.4' z='-0.2'/><float name='radius' value='0.4'/>
    <bsdf type='dielectric'><float name='intIOR' value='1.5'/><float name='extIOR' value='1'/></bsdf>
  </shape>
  <shape type='rectangle'>
    <transform name='toWorld'><scale x='0.25' y='0.2'/><rotate x='1' angle='90'/><translate x='0' y='1.98' z='0'/></transform>
    <bsdf type='diffuse'><rgb name='reflectance' value='0, 0, 0'/></bsdf>
    <emitter type='area'><rgb name='radiance' value='17, 12, 4'/></emitter>
  </shape>
</scene>";

/// Names of Mitsuba 0.6 and of Mitsuba 3.
const NAMES: [(&str, &str); 13] = [
    ("'0.5.0'", "'3.0.0'"),
    ("maxDepth", "max_depth"),
    ("<boolean name='strictNormals' value='true'/>", ""),
    ("fovAxis", "fov_axis"),
    ("nearClip", "near_clip"),
    ("toWorld", "to_world"),
    ("lookAt", "lookat"),
    ("sampleCount", "sample_count"),
    ("ldrfilm", "hdrfilm"),
    ("<string name='fileFormat' value='png'/>", ""),
    ("<float name='gamma' value='2.2'/><boolean name='banner' value='false'/>", ""),
    ("pixelFormat", "pixel_format"),
    ("IOR", "_ior"),
];

#[test]
fn agreement_of_old_and_new_xml() {
    let new_box = NAMES.iter().fold(OLD_BOX.to_owned(), |text, (old, new)| {
        assert!(text.contains(old), "{old}");
        text.replace(old, new)
    });
    let [old, new] = [OLD_BOX, &new_box].map(|text| load("box.xml", text.as_bytes()));
    // Those of `strictNormals` and of the film that writes PNG.
    assert_eq!((old.notices.len(), new.notices.len()), (2, 0), "{:?}", old.notices);
    assert!(picture(&old) == picture(&new), "the pictures differ");
}
