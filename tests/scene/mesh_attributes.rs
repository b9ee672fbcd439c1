//! `mesh_attribute`: what PLY files say of vertices and faces, through `Scene::prepare` and in pictures.

use crate::rendered::rendered;
use std::sync::Arc;

use crate::scene_files::prepare;
use photonfarm::scene::Scene;
use photonfarm::scene::error::Location;
use photonfarm::scene::geometry::ply;

/// The square [-1, 1]² as two triangles below and above its diagonal from (-1, -1) to (1, 1), with extra properties.
fn square(vertex: &str, of_vertices: [&str; 4], face: &str, of_faces: [&str; 2]) -> String {
    let properties =
        |names: &str| names.split_whitespace().map(|name| format!("property float {name}\n")).collect::<String>();
    let [a, b, c, d] = of_vertices;
    let [below, above] = of_faces;
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\n{}{}element face 2\nproperty list uchar int vertex_indices\n{}end_header\n\
        -1 -1 0 {a}\n1 -1 0 {b}\n1 1 0 {c}\n-1 1 0 {d}\n3 0 1 2 {below}\n3 0 2 3 {above}\n",
        properties("x y z"),
        properties(vertex),
        properties(face),
    )
}

/// Red grows along x, green along y; blue is 0.25. Faces are 0.25 and 0.75, or two colors.
fn colored_square() -> String {
    let of_vertices = ["0 0 0.25", "1 0 0.25", "1 1 0.25", "0 1 0.25"];
    square(
        "color_0 color_1 color_2",
        of_vertices,
        "weight_0 hue_r hue_g hue_b",
        ["0.25 0.1 0.2 0.3", "0.75 0.4 0.5 0.6"],
    )
}

fn attribute(slot: &str, name: &str, more: &str) -> String {
    format!("<texture name='{slot}' type='mesh_attribute'><string name='name' value='{name}'/>{more}</texture>")
}

const SENSOR: &str = "<sensor type='orthographic'><transform name='to_world'>\
    <lookat origin='0,0,3' target='0,0,0' up='0,1,0'/></transform><film type='hdrfilm'><integer name='width' value='8'/>\
    <integer name='height' value='8'/><rfilter type='box'/></film></sensor>";

fn ply_shape(inside: &str) -> String {
    format!("<shape type='ply'><string name='filename' value='mesh.ply'/>{inside}</shape>")
}

fn scene(body: &str, file: &str) -> Scene {
    prepare(&format!("{SENSOR}{body}"), &[("mesh.ply", file.as_bytes())])
        .unwrap_or_else(|error| panic!("{body}: {error}"))
}

fn error(body: &str, file: &str) -> String {
    match prepare(&format!("{SENSOR}{body}"), &[("mesh.ply", file.as_bytes())]) {
        Ok(_) => panic!("{body} is no error"),
        Err(error) => error.to_string(),
    }
}

/// The picture; its rows run down along y, its columns along x.
fn render(scene: Scene, name: &str, passes: u32) -> Vec<[f32; 3]> {
    rendered(&Arc::new(scene), name, serde_json::Map::new(), passes, 7).radiance
}

/// The middle of a pixel on the square.
fn place(index: usize) -> [f32; 2] {
    [(index % 8) as f32 / 4.0 - 0.875, 0.875 - (index / 8) as f32 / 4.0]
}

fn emitting(texture: &str) -> String {
    ply_shape(&format!("<emitter type='area'>{texture}</emitter>"))
}

/// A glowing square shows its colors: linear between vertices, so that a pixel has that of its middle.
#[test]
fn analytic_vertex_colors_are_linear() {
    let scale = "<float name='scale' value='2'/>";
    let picture =
        render(scene(&emitting(&attribute("radiance", "vertex_color", scale)), &colored_square()), "path", 256);
    for (index, found) in picture.iter().enumerate() {
        let [x, y] = place(index);
        for (found, expected) in found.iter().zip([x + 1.0, y + 1.0, 0.5]) {
            // A pixel is 0.25 wide, and a sample's standard deviation 0.072 of it.
            assert!((found - expected).abs() < 0.025, "pixel {index}: {found} for {expected}");
        }
    }
}

#[test]
fn analytic_face_values_are_the_same_all_over() {
    for (name, values) in
        [("face_weight", [[0.25; 3], [0.75; 3]]), ("face_hue_color", [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])]
    {
        let picture = render(scene(&emitting(&attribute("radiance", name, "")), &colored_square()), "path", 2);
        for (index, found) in picture.iter().enumerate() {
            let [x, y] = place(index);
            // Pixels on the diagonal see both.
            if x != y {
                assert_eq!(*found, values[usize::from(y > x)], "{name}, pixel {index}");
            }
        }
    }
}

/// Under a white sky a matte square shows its reflectance, by every way in which methods keep what they hit.
#[test]
fn analytic_reflectances_by_all_methods() {
    let bsdf = format!("<bsdf type='diffuse'>{}</bsdf>", attribute("reflectance", "face_hue_color", ""));
    let shape = ply_shape(&bsdf);
    let instance =
        format!("<shape type='shapegroup' id='group'>{shape}</shape><shape type='instance'><ref id='group'/></shape>");
    for body in [shape, instance] {
        let body = format!("{body}<emitter type='constant'/>");
        for (method, passes, bound) in
            [("path", 64, 0.02), ("sppm", 8, 0.03), ("ppm", 8, 0.03), ("bdpt", 64, 0.04), ("vcm", 8, 0.05)]
        {
            let picture = render(scene(&body, &colored_square()), method, passes);
            for (above, expected) in [(false, [0.1, 0.2, 0.3]), (true, [0.4, 0.5, 0.6])] {
                let side = |index: usize| {
                    let [x, y] = place(index);
                    x != y && (y > x) == above
                };
                let pixels: Vec<_> = (0..64).filter(|index| side(*index)).map(|index| picture[index]).collect();
                for channel in 0..3 {
                    let mean = pixels.iter().map(|pixel| pixel[channel]).sum::<f32>() / pixels.len() as f32;
                    let off = mean / expected[channel] - 1.0;
                    assert!(
                        off.abs() < bound,
                        "{method}, {above}, channel {channel}: {mean} for {}",
                        expected[channel]
                    );
                }
            }
        }
    }
}

/// Two shapes with one bsdf each have their own values.
#[test]
fn a_shared_material_has_the_values_of_each_shape() {
    let bsdf = format!("<bsdf type='diffuse' id='paint'>{}</bsdf>", attribute("reflectance", "face_weight", ""));
    let half = |file: &str, x: f32| {
        format!(
            "<shape type='ply'><string name='filename' value='{file}'/><transform name='to_world'><scale x='0.5'/>\
            <translate x='{x}'/></transform><ref id='paint'/></shape>"
        )
    };
    let dark = square("", [""; 4], "weight_0", ["0.2", "0.2"]);
    let bright = square("", [""; 4], "weight_0", ["0.8", "0.8"]);
    let body = format!("{SENSOR}{bsdf}{}{}<emitter type='constant'/>", half("dark.ply", -0.5), half("bright.ply", 0.5));
    let scene =
        prepare(&body, &[("dark.ply", dark.as_bytes()), ("bright.ply", bright.as_bytes())]).expect("a good scene");
    let picture = render(scene, "path", 64);
    for (index, found) in picture.iter().enumerate() {
        let expected = if place(index)[0] > 0.0 { 0.8 } else { 0.2 };
        assert!((found[0] / expected - 1.0).abs() < 2e-2, "pixel {index}: {} for {expected}", found[0]);
    }
}

/// Names as Mitsuba 3.9.1 makes them of the same properties.
#[test]
fn mitsuba_names_of_attributes() {
    let names = |properties: &str| {
        let zeros = vec!["0"; properties.split_whitespace().count()].join(" ");
        let file = square(properties, [&zeros; 4], properties, [&zeros; 2]);
        let location = Location::default();
        let mesh = ply::read(file.as_bytes(), &location).expect("the file is good");
        let names: Vec<(String, usize)> =
            mesh.attributes.iter().map(|values| (values.name.clone(), values.channels)).collect();
        let (vertices, faces) = names.split_at(names.len() / 2);
        let bare = |names: &[(String, usize)], kind: &str| -> Vec<(String, usize)> {
            names
                .iter()
                .map(|(name, channels)| (name.strip_prefix(kind).expect("its kind").to_owned(), *channels))
                .collect()
        };
        assert_eq!(bare(vertices, "vertex_"), bare(faces, "face_"), "{properties}");
        bare(vertices, "vertex_")
            .iter()
            .map(|(name, channels)| format!("{name}:{channels}"))
            .collect::<Vec<_>>()
            .join(" ")
    };
    for (properties, expected) in [
        ("r g b", "color:3"),
        ("g r b", "color:3"),
        ("red green blue", "color:3"),
        ("r g", ""),
        ("quality", ""),
        ("confidence r g b k_1", "color:3 k:1"),
        ("foo_0", "foo:1"),
        ("foo_1", "foo:1"),
        ("foo_x", "foo:1"),
        ("foo_r", "foo_color:1"),
        ("foo_9", ""),
        ("foo_q", ""),
        ("foo_", ""),
        ("_0", ""),
        ("color_r color_g color_b", "color_color:3"),
        ("vertex_color_0 vertex_color_1 vertex_color_2", "vertex_color:3"),
        ("a_1 a_2 b_1", "b:1"),
        ("a_1 b_1 a_2", "a:1 b:1"),
        ("n_w n_x n_y n_z", ""),
        ("n_x n_y n_z k_0 k_1 k_2", "n:3 k:3"),
        ("c_g c_r c_b", ""),
        ("c_r d_g e_b", "c_color:1"),
        ("a_b_c_0", "a_b_c:1"),
    ] {
        assert_eq!(names(properties), expected, "{properties}");
    }
}

#[test]
fn attributes_are_written_as_they_are_read() {
    let location = Location::default();
    let mesh = ply::read(colored_square().as_bytes(), &location).expect("the file is good");
    assert_eq!(mesh.attributes.len(), 3);
    let again = ply::read(&ply::write(&mesh), &location).expect("what is written can be read");
    assert_eq!(again.attributes, mesh.attributes);
}

#[test]
fn errors_of_attributes() {
    let file = colored_square();
    let matte =
        |texture: &str| ply_shape(&format!("<bsdf type='diffuse'>{texture}</bsdf>")) + "<emitter type='point'/>";
    let cases = [
        (
            matte(&attribute("reflectance", "vertex_colour", "")),
            "the shape has no attribute \"vertex_colour\"; did you mean \"vertex_color\"?",
        ),
        (matte(&attribute("reflectance", "color", "")), "names start with \"vertex_\" or \"face_\""),
        (matte("<texture name='reflectance' type='mesh_attribute'/>"), "\"mesh_attribute\" has no \"name\""),
        (
            matte(&attribute("reflectance", "vertex_color", "<float name='scale' value='2'/>")),
            "it would reflect more than arrives",
        ),
        (
            format!(
                "<shape type='sphere'><bsdf type='diffuse'>{}</bsdf></shape>",
                attribute("reflectance", "vertex_color", "")
            ),
            "its file names no attributes",
        ),
        (
            ply_shape(&format!(
                "<bsdf type='bumpmap'><texture type='checkerboard'/><bsdf type='diffuse'>{}</bsdf></bsdf>",
                attribute("reflectance", "vertex_color", "")
            )),
            "a shape with a bumpmap reads a mesh_attribute",
        ),
    ];
    for (body, expected) in cases {
        let found = error(&body, &file);
        assert!(found.contains(expected), "{found}");
    }
    // A bsdf that no shape has is checked without a mesh.
    let unused = format!("<bsdf type='diffuse'>{}</bsdf>", attribute("reflectance", "vertex_none", ""));
    scene(&format!("{unused}<shape type='sphere'/><emitter type='point'/>"), &file);
}
