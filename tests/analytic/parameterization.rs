//! Texture coordinates and their partial derivatives: closed forms on every shape in Mitsuba's conventions, derivatives
//! against finite differences, and frames along ∂p/∂u.

use std::f32::consts::{PI, TAU};

use crate::shape_text::read_shapes;
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Vec2, Vec3, warp};
use photonfarm::scene::geometry::{Geometry, Interaction, Ray, Shape, TexturePoint};

fn uniform(family: u32, index: u32) -> [f32; 4] {
    PathRandom::new(5, Stream::Camera, family, index).block(0)
}

/// The geometry of one shape plugin whose material looks at texture coordinates, or does not.
fn geometry(shape: &str, files: &[(&str, &[u8])], needs_uv: bool) -> Geometry {
    let shapes = read_shapes(shape, files).expect("the shape is good").into_iter();
    Geometry::build(shapes.map(|geometry| (Shape { needs_uv, ..Shape::new(0) }, geometry)).collect()).0
}

/// Hits of random rays through the ball of radius 2 round `middle`.
fn hits(geometry: &Geometry, middle: Vec3, family: u32) -> Vec<Interaction> {
    let rays = (0..4000).map(|index| {
        let u = uniform(family, index);
        let from = warp::sphere([u[0], u[1]]) * 4.0;
        let to = warp::sphere([u[2], u[3]]) * 1.2;
        Ray::new(middle + from, (to - from).normalize())
    });
    let hits: Vec<Interaction> = rays.filter_map(|ray| geometry.intersect(&ray)).collect();
    assert!(hits.len() > 200, "only {} hits", hits.len());
    hits
}

fn turns(x: f32, y: f32) -> f32 {
    (y.atan2(x) / TAU).rem_euclid(1.0)
}

/// A shape, and its texture coordinates as a function of the position in its own space.
type ClosedForm = fn(Vec3, Vec3) -> Vec2;

const CLOSED_FORMS: [(&str, ClosedForm); 5] = [
    ("rectangle", |p, _| Vec2::new(p.x + 1.0, p.y + 1.0) / 2.0),
    ("disk", |p, _| Vec2::new(p.x.hypot(p.y), turns(p.x, p.y))),
    ("sphere", |p, _| Vec2::new(turns(p.x, p.y), (p.z / p.length()).acos() / PI)),
    ("cylinder", |p, _| Vec2::new(turns(p.x, p.y), p.z)),
    ("cube", |p, normal| {
        // Mitsuba's table of vertices, one face after the other.
        let uv = match normal.to_array() {
            [_, -1.0, _] => Vec2::new(p.z, p.x),
            [_, 1.0, _] => Vec2::new(-p.x, -p.z),
            [1.0, _, _] => Vec2::new(p.y, -p.z),
            [-1.0, _, _] => Vec2::new(p.y, p.z),
            [_, _, 1.0] => Vec2::new(p.y, p.x),
            _ => Vec2::new(-p.y, p.x),
        };
        (uv + 1.0) / 2.0
    }),
];

#[test]
fn analytic_texture_coordinates_agree_with_their_formulas() {
    for (name, closed_form) in CLOSED_FORMS {
        let geometry = geometry(&format!("<shape type='{name}'/>"), &[], true);
        for hit in hits(&geometry, Vec3::ZERO, 1) {
            let expected = closed_form(hit.position, hit.geometric_normal);
            assert!(hit.uv.distance(expected) < 1e-3, "{name}: uv {} for {expected} at {}", hit.uv, hit.position);
        }
    }
}

/// uv depends on the place in the shape's own space alone.
#[test]
fn analytic_texture_coordinates_follow_the_transform() {
    let place = "<transform name='to_world'><scale value='2, 2, -2'/><rotate x='1' y='2' z='-1' angle='70'/>\
        <translate value='3, 4, -5'/></transform>";
    let middle = Vec3::new(3.0, 4.0, -5.0);
    for (name, closed_form) in CLOSED_FORMS {
        for flip in ["", "<boolean name='flip_normals' value='true'/>"] {
            let geometry = geometry(&format!("<shape type='{name}'>{place}{flip}</shape>"), &[], true);
            let axis = Vec3::new(1.0, 2.0, -1.0).normalize();
            let turn = glam::Quat::from_axis_angle(axis, -70f32.to_radians());
            for hit in hits(&geometry, middle, 2) {
                let to_local = |vector: Vec3| turn * vector / 2.0 * Vec3::new(1.0, 1.0, -1.0);
                let mut normal = to_local(hit.geometric_normal) * 2.0;
                if !flip.is_empty() {
                    normal = -normal;
                }
                let normal = normal.map(|x| if (x.abs() - 1.0).abs() < 1e-3 { x.signum() } else { x });
                let expected = closed_form(to_local(hit.position - middle), normal);
                let off = (hit.uv - expected).map(|x| x.abs().min((x.abs() - 1.0).abs()));
                assert!(off.length() < 1e-3, "{name} {flip}: uv {} for {expected}", hit.uv);
            }
        }
    }
}

#[test]
fn analytic_shapes_that_need_no_coordinates_have_none() {
    for (name, _) in CLOSED_FORMS {
        let geometry = geometry(&format!("<shape type='{name}'/>"), &[], false);
        assert!(hits(&geometry, Vec3::ZERO, 3).iter().all(|hit| hit.uv == Vec2::ZERO));
    }
}

// ---- Derivatives. -------------------------------------------------------------------------------------------------

const WAVE: &str = "v 0 0 0\nv 1 0 0.2\nv 1 1 -0.1\nv 0 1 0.3\nv -0.5 0.5 0.1\nvt 0.1 0.2\nvt 0.9 0.1\nvt 0.8 0.7\n\
    vt 0.2 0.9\nvt -0.4 0.6\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 4/4 5/5\n";

fn wave(parameters: &str) -> String {
    format!("<shape type='obj'><string name='filename' value='wave.obj'/>{parameters}</shape>")
}

const FILES: &[(&str, &[u8])] = &[("wave.obj", WAVE.as_bytes())];

/// A step along the surface changes the position by partials · change of uv.
#[test]
fn analytic_partials_agree_with_differences() {
    let place = "<transform name='to_world'><scale value='1.5'/><rotate x='1' y='2' z='-1' angle='70'/>\
        <translate value='0.3, -0.4, 0.5'/></transform>";
    let middle = Vec3::new(0.3, -0.4, 0.5);
    let uneven = place.replace("value='1.5'", "x='1.5' y='0.7' z='1'");
    let shapes = [
        format!("<shape type='rectangle'>{uneven}</shape>"),
        format!("<shape type='disk'>{uneven}</shape>"),
        format!("<shape type='cube'>{uneven}</shape>"),
        format!("<shape type='sphere'>{place}</shape>"),
        format!("<shape type='cylinder'>{place}<point name='p1' value='0.2, 0.5, -1'/></shape>"),
        wave(&uneven),
        wave(&format!("{place}<boolean name='flip_normals' value='true'/>")),
        "<shape type='sphere'><boolean name='flip_normals' value='true'/></shape>".to_owned(),
    ];
    for shape in shapes {
        let geometry = geometry(&shape, FILES, true);
        let mut compared = 0;
        for (index, hit) in (0..).zip(hits(&geometry, middle, 4)) {
            let u = uniform(5, index);
            // A second ray beside the first.
            let step = hit.frame.to_world(Vec3::new(u[0] - 0.5, u[1] - 0.5, 0.0)) * 4e-3;
            let from = hit.position + step + hit.outgoing * 0.5;
            let Some(next) = geometry.intersect(&Ray::new(from, -hit.outgoing)) else { continue };
            let change = next.uv - hit.uv;
            let grazing = hit.outgoing.dot(hit.geometric_normal).abs() < 0.3;
            // Across an edge or a seam the coordinates jump.
            let same_face = next.geometric_normal.dot(hit.geometric_normal) > 0.999;
            let [along_u, along_v] = geometry.partials(&hit);
            let singular = along_u.length().min(along_v.length()) < 0.5;
            if grazing || !same_face || change.abs().max_element() > 0.1 || singular || next.primitive != hit.primitive
            {
                continue;
            }
            let expected = next.position - hit.position;
            let found = along_u * change.x + along_v * change.y;
            assert!(
                found.distance(expected) < 0.03 * expected.length() + 1e-5,
                "{shape}: {found} for {expected} at uv {}",
                hit.uv
            );
            compared += 1;
        }
        assert!(compared > 100, "{shape}: only {compared} compared");
    }
}

#[test]
fn analytic_frames_follow_u() {
    let shapes = ["rectangle", "disk", "sphere", "cylinder", "cube"].map(|name| format!("<shape type='{name}'/>"));
    for shape in shapes.iter().chain([&wave("")]) {
        let geometry = geometry(shape, FILES, true);
        for hit in hits(&geometry, Vec3::ZERO, 6) {
            let frame = hit.frame;
            let [along_u, _] = geometry.partials(&hit);
            let axes = [frame.tangent, frame.bitangent, frame.normal];
            for (i, axis) in axes.iter().enumerate() {
                assert!((axis.length() - 1.0).abs() < 1e-5 && axis.dot(axes[(i + 1) % 3]).abs() < 1e-5, "{shape}");
            }
            let flattened = along_u - frame.normal * along_u.dot(frame.normal);
            assert!(flattened.length() < 1e-3 || flattened.normalize().distance(frame.tangent) < 1e-3, "{shape}");
            // As in Mitsuba, also where u and v turn the other way.
            assert!(frame.tangent.cross(frame.bitangent).distance(frame.normal) < 1e-4, "{shape}: left-handed");
        }
    }
}

// ---- Meshes. ------------------------------------------------------------------------------------------------------

fn down(x: f32, y: f32) -> Ray {
    Ray::new(Vec3::new(x, y, 5.0), -Vec3::Z)
}

#[test]
fn analytic_mesh_coordinates_are_interpolated() {
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nvt 1.5 0.25\nvt 0.5 1.25\nf 1/1 2/2 3/3\n";
    let ply = |names: [&str; 2], rows: &str| {
        let [u, v] = names;
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float {u}\n\
            property float {v}\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{rows}3 0 1 2\n"
        )
    };
    let rows = "0 0 0 0.5 0.25\n1 0 0 1.5 0.25\n0 1 0 0.5 1.25\n";
    let (uv, st) = (ply(["u", "v"], rows), ply(["s", "t"], rows));
    let named = ply(["texture_u", "texture_v"], rows);
    let files: &[(&str, &[u8])] = &[
        ("a.obj", obj.as_bytes()),
        ("uv.ply", uv.as_bytes()),
        ("st.ply", st.as_bytes()),
        ("named.ply", named.as_bytes()),
    ];
    let flag = |value: &str| format!("<boolean name='flip_tex_coords' value='{value}'/>");
    let plain = Vec2::new(0.5 + 0.25, 0.25 + 0.5);
    let flipped = Vec2::new(plain.x, 1.0 - plain.y);
    // OBJ files of Mitsuba count v downwards unless told otherwise.
    let cases = [
        ("a.obj", String::new(), flipped),
        ("a.obj", flag("false"), plain),
        ("uv.ply", String::new(), plain),
        ("uv.ply", flag("true"), flipped),
        ("st.ply", String::new(), plain),
        ("named.ply", String::new(), plain),
    ];
    for (file, parameters, expected) in cases {
        let kind = &file[file.len() - 3..];
        let shape = format!("<shape type='{kind}'><string name='filename' value='{file}'/>{parameters}</shape>");
        let hit = geometry(&shape, files, true).intersect(&down(0.25, 0.5)).expect("the ray hits");
        assert!(hit.uv.distance(expected) < 1e-5, "{file} {parameters}: {}", hit.uv);
    }
}

#[test]
fn analytic_meshes_without_coordinates_have_barycentric_ones() {
    let obj = "v 0 0 0\nv 2 0 0\nv 0 4 0\nf 1 2 3\n";
    let shape = "<shape type='obj'><string name='filename' value='a.obj'/></shape>";
    let geometry = geometry(shape, &[("a.obj", obj.as_bytes())], true);
    let hit = geometry.intersect(&down(0.5, 2.0)).expect("the ray hits");
    assert!(hit.uv.distance(Vec2::new(0.25, 0.5)) < 1e-5);
    assert_eq!(geometry.partials(&hit), [Vec3::X * 2.0, Vec3::Y * 4.0]);
}

/// Coordinates that do not tell points apart give no direction, and nothing that is not finite.
#[test]
fn analytic_degenerate_coordinates_give_no_tangent() {
    let obj = "v 0 0 0\nv 2 0 0\nv 0 4 0\nvt 0.5 0.5\nf 1/1 2/1 3/1\n";
    let shape = "<shape type='obj'><string name='filename' value='a.obj'/></shape>";
    let geometry = geometry(shape, &[("a.obj", obj.as_bytes())], true);
    let hit = geometry.intersect(&down(0.5, 2.0)).expect("the ray hits");
    assert_eq!(geometry.partials(&hit), [Vec3::ZERO; 2]);
    assert!(hit.frame.tangent.is_finite() && hit.frame.tangent.is_normalized());
}

#[test]
fn analytic_sampled_points_have_the_coordinates_of_their_hits() {
    for (name, _) in CLOSED_FORMS {
        let geometry = geometry(&format!("<shape type='{name}'/>"), &[], true);
        for index in 0..500 {
            let u = uniform(7, index);
            let primitive = if name == "cube" { index % 12 } else { 0 };
            let (point, TexturePoint { uv, .. }) = geometry.sample_for_texture(primitive, [u[0], u[1]]);
            let hit = geometry.intersect(&Ray::new(point.position + point.normal, -point.normal));
            let hit = hit.expect("the point is found again");
            let seam = (hit.uv - uv).abs().max_element() > 0.9;
            // Near the middle of a disk and the poles of a sphere a small step is a large turn.
            let tolerance = 1e-3 / geometry.partials(&hit)[1].length().min(1.0);
            assert!(seam || hit.uv.distance(uv) < tolerance, "{name}: {uv} and {}", hit.uv);
        }
    }
}
