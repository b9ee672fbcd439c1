//! Intersection: closed surfaces are tight, the accelerator agrees with a search through all primitives, scale does not
//! matter, every shape agrees with its formula, and sampled points lie on their shape.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;

use crate::scene_text::prepare;
use glam::DVec3;
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Vec3, warp};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::ray::Shear;
use photonfarm::scene::geometry::{Geometry, Layer, Primitive, Ray};

fn uniform(family: u32, index: u32) -> [f32; 4] {
    PathRandom::new(3, Stream::Camera, family, index).block(0)
}

fn direction(family: u32, index: u32) -> Vec3 {
    let u = uniform(family, index);
    warp::sphere([u[0], u[1]])
}

fn in_cube(family: u32, index: u32) -> Vec3 {
    let u = uniform(family, index);
    Vec3::new(u[0], u[1], u[2]) * 2.0 - 1.0
}

const TWO_SIDED: &str = "<bsdf type='twosided'><bsdf type='diffuse'/></bsdf>";

fn scene(body: &str, files: &[(&str, String)]) -> Scene {
    let around = "<sensor type='perspective'/><emitter type='point'/>";
    prepare(&format!("{around}{body}"), files).expect("the scene is good")
}

// ---- Watertightness. ----------------------------------------------------------------------------------------------

/// An icosahedron whose triangles were split in four `levels` times, on the unit sphere.
fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[usize; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)].map(DVec3::normalize));
    }
    // Faces are the triples at the shortest distance from each other, turned outwards.
    let edge = points.iter().map(|p| p.distance(points[0])).filter(|d| *d > 0.0).fold(f64::MAX, f64::min) * 1.01;
    let near = |a: usize, b: usize| points[a].distance(points[b]) < edge;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outside = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
                    faces.push(if outside { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut middle = |a: usize, b: usize, points: &mut Vec<DVec3>| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a] + points[b]).normalize());
                points.len() - 1
            })
        };
        let split = |[a, b, c]: [usize; 3]| {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| middle(a, b, &mut points));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    (points, faces)
}

/// The icosphere as a scene, and its corners and middles of edges as single precision sees them.
fn icosphere_scene(to_world: &str, place: impl Fn(DVec3) -> DVec3) -> (Scene, Vec<Vec3>, Vec<Vec3>) {
    let (points, faces) = icosphere(3);
    let mut text = String::new();
    for point in &points {
        writeln!(text, "v {} {} {}", point.x, point.y, point.z).unwrap();
    }
    for [a, b, c] in &faces {
        writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    let body = format!(
        "<shape type='obj'><string name='filename' value='ball.obj'/><boolean name='face_normals' value='true'/>\
        <transform name='to_world'>{to_world}</transform>{TWO_SIDED}</shape>"
    );
    let corners: Vec<Vec3> = points.iter().map(|point| place(*point).as_vec3()).collect();
    let edges = faces.iter().flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]);
    let middles = edges.map(|(a, b)| (corners[*a] + corners[*b]) * 0.5).collect();
    (scene(&body, &[("ball.obj", text)]), corners, middles)
}

fn assert_tight(scene: &Scene, origins: impl Fn(u32) -> Vec3, targets: &[Vec3], what: &str) {
    let random = (0..100_000).map(|index| (origins(index), direction(10, index)));
    let aimed =
        (0..20).flat_map(|round| targets.iter().zip(0..).map(move |(target, index)| (round * 7919 + index, target)));
    let aimed = aimed.map(|(index, target)| (origins(index), (*target - origins(index)).normalize()));
    for (origin, direction) in random.chain(aimed) {
        let ray = Ray::new(origin, direction);
        assert!(scene.geometry.intersect(&ray).is_some(), "{what}: a ray from {origin} to {direction} slips out");
        assert!(scene.geometry.is_blocked(&ray), "{what}: a shadow ray from {origin} to {direction} slips out");
    }
}

#[test]
fn analytic_closed_meshes_are_tight() {
    let (ball, corners, middles) = icosphere_scene("<translate x='0'/>", |point| point);
    let targets = [corners, middles].concat();
    assert_tight(&ball, |index| in_cube(11, index) * 0.5, &targets, "icosphere");
    assert_tight(&ball, |_| Vec3::ZERO, &targets, "icosphere from the middle");
    // Far from the origin, where single precision is coarse.
    let far = DVec3::new(300.0, -200.0, 100.0);
    let (ball, corners, middles) = icosphere_scene("<translate value='300, -200, 100'/>", |point| point + far);
    let targets = [corners, middles].concat();
    assert_tight(&ball, |index| far.as_vec3() + in_cube(12, index) * 0.5, &targets, "icosphere far away");

    let cube = scene(&format!("<shape type='cube'>{TWO_SIDED}</shape>"), &[]);
    let targets: Vec<Vec3> = (0..27)
        .map(|code| Vec3::new((code % 3 - 1) as f32, (code / 3 % 3 - 1) as f32, (code / 9 - 1) as f32))
        .filter(|target| *target != Vec3::ZERO)
        .collect();
    assert_tight(&cube, |index| in_cube(13, index) * 0.99, &targets, "cube");
}

#[test]
fn analytic_walks_stay_inside() {
    let (ball, ..) = icosphere_scene("<translate value='3, -2, 1'/>", |point| point);
    let sphere = "<shape type='sphere'><point name='center' value='3, -2, 1'/>";
    let walls = [
        ("icosphere", ball),
        ("sphere", scene(&format!("{sphere}{TWO_SIDED}</shape>"), &[])),
        (
            "cube",
            scene(
                &format!(
                    "<shape type='cube'><transform name='to_world'><translate value='3, -2, 1'/></transform>{TWO_SIDED}</shape>"
                ),
                &[],
            ),
        ),
    ];
    for (what, scene) in walls {
        let mut ray = Ray::new(Vec3::new(3.1, -2.2, 1.3), direction(14, 0));
        for step in 0..100_000 {
            let hit = scene.geometry.intersect(&ray).unwrap_or_else(|| panic!("{what}: leaked after {step} bounces"));
            let inward = if hit.outgoing.dot(hit.geometric_normal) < 0.0 { -1.0 } else { 1.0 };
            let next = direction(14, step + 1);
            let next = next * next.dot(hit.geometric_normal * inward).signum();
            ray = hit.ray_to(next);
        }
    }
}

// ---- Agreement. ---------------------------------------------------------------------------------------------------

/// One of each kind of shape, all scaled by `scale`: 4 analytic primitives and 12 + 4 triangles.
fn zoo(scale: &str) -> Scene {
    let scaled =
        |steps: &str| format!("<transform name='to_world'>{steps}<scale value='{scale}'/></transform>{TWO_SIDED}");
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let body = [
        format!("<shape type='rectangle'>{}</shape>", scaled("<rotate x='1' angle='-90'/><translate y='-1'/>")),
        format!(
            "<shape type='disk'>{}</shape>",
            scaled("<scale value='0.6'/><rotate x='1' y='1' angle='50'/><translate x='-0.5' z='0.4'/>")
        ),
        format!(
            "<shape type='sphere'><float name='radius' value='0.3'/>{}</shape>",
            scaled("<translate value='0.4, 0.5, -0.3'/>")
        ),
        format!(
            "<shape type='cylinder'><float name='radius' value='0.2'/>{}</shape>",
            scaled("<rotate x='1' angle='30'/><translate value='-0.4, -0.5, -0.5'/>")
        ),
        format!(
            "<shape type='cube'>{}</shape>",
            scaled("<scale x='0.2' y='0.3' z='0.25'/><rotate y='1' angle='30'/><translate value='0.5, -0.4, 0.4'/>")
        ),
        format!(
            "<shape type='obj'><string name='filename' value='t.obj'/><boolean name='face_normals' value='true'/>{}</shape>",
            scaled("<scale value='0.5'/><translate value='-0.8, 0.3, 0.2'/>")
        ),
    ];
    scene(&body.concat(), &[("t.obj", tetrahedron.to_owned())])
}

const PRIMITIVES: u32 = 4 + 12 + 4;

/// Rays within a layer are blocked by its obstacles exactly where anything blocks them, also where there are more obstacles than are
/// kept, and instances; and most layers have none.
#[test]
fn analytic_obstacles_of_a_layer_block_what_all_primitives_block() {
    let (ball, ..) = icosphere_scene("<scale value='0.7'/>", |point| point);
    let group = format!("<shape type='shapegroup' id='group'><shape type='disk'>{TWO_SIDED}</shape></shape>");
    let instance =
        "<shape type='instance'><ref id='group'/><transform name='to_world'><scale value='0.5'/></transform></shape>";
    let floor = format!("<shape type='rectangle'>{TWO_SIDED}</shape>");
    let scenes = [("zoo", zoo("1")), ("ball", ball), ("instance", scene(&format!("{floor}{group}{instance}"), &[]))];
    for (what, scene) in &scenes {
        let geometry = &scene.geometry;
        let (mut blocked, mut clear, mut told) = (0, 0, 0);
        for index in 0..20_000 {
            let (place, normal) = (in_cube(20, index), direction(21, index));
            let [wide, low, thick, _] = uniform(22, index);
            let radius = 0.3 * wide;
            let heights = [low * radius, (low + thick) * radius];
            let obstacles = geometry.obstacles(&Layer::new(place, normal, radius, heights));
            clear += u32::from(obstacles.is_empty());
            // Two points in the layer.
            let across = normal.any_orthonormal_vector();
            let ends = [0, 1].map(|end| {
                let [turn, out, up, _] = uniform(23 + end, index);
                let (sin, cos) = (std::f32::consts::TAU * turn).sin_cos();
                let out = radius * out.sqrt();
                place
                    + (across * cos + normal.cross(across) * sin) * out
                    + normal * (heights[0] + (heights[1] - heights[0]) * up)
            });
            let between = ends[1] - ends[0];
            let length = between.length();
            let ray = Ray { origin: ends[0], direction: between / length, length };
            let expected = geometry.is_blocked(&ray);
            assert_eq!(geometry.is_blocked_within(&ray, &obstacles), expected, "{what}: {ray:?}");
            blocked += u32::from(expected);
            told += u32::from(expected && !obstacles.needs_tree());
        }
        println!("{what}: {blocked} rays blocked, {told} by obstacles that were kept; {clear} layers clear");
        assert!(blocked > 300 && clear > 5000, "{what}: {blocked} rays blocked, {clear} layers clear");
        assert!(told > 0 && told < blocked, "{what}: {told} of {blocked} by obstacles that were kept");
    }
}

fn search(geometry: &Geometry, ray: &Ray) -> Option<f32> {
    let shear = Shear::new(ray.direction);
    let hits = (0..PRIMITIVES).filter_map(|index| geometry.primitive(index).intersect(ray, &shear, ray.length));
    hits.map(|hit| hit.distance).reduce(f32::min)
}

/// Rays through the unit cube.
fn rays(family: u32, count: u32) -> impl Iterator<Item = Ray> {
    (0..count).map(move |index| Ray::new(in_cube(family, index) * 1.5, direction(family + 1, index)))
}

#[test]
fn agreement_of_the_accelerator_with_a_full_search() {
    let zoo = zoo("1");
    let mut hits = 0;
    for (ray, index) in rays(20, 100_000).zip(0..) {
        let length = if index % 2 == 0 { f32::INFINITY } else { uniform(22, index)[0] * 2.0 };
        let ray = Ray { length, ..ray };
        let expected = search(&zoo.geometry, &ray);
        let found = zoo.geometry.intersect(&ray);
        assert_eq!(found.map(|hit| hit.distance), expected, "{ray:?}");
        assert_eq!(zoo.geometry.is_blocked(&ray), expected.is_some(), "{ray:?}");
        hits += usize::from(expected.is_some());
        let Some(hit) = found else { continue };
        assert!(hit.position.distance(ray.at(hit.distance)) < 1e-5, "{ray:?} meets {}", hit.position);
        assert!((hit.geometric_normal.length() - 1.0).abs() < 1e-5);
        assert_eq!(hit.outgoing, -ray.direction);
    }
    assert!((10_000..90_000).contains(&hits), "{hits} rays hit: the test is one-sided");
}

#[test]
fn agreement_of_tiny_and_huge_scenes() {
    let normal = zoo("1");
    for (text, scale) in [("1e-6", 1e-6f32), ("1e6", 1e6), ("1024", 1024.0)] {
        let scaled = zoo(text);
        let mut differing = 0;
        for ray in rays(30, 100_000) {
            let expected = normal.geometry.intersect(&ray);
            let found = scaled.geometry.intersect(&Ray::new(ray.origin * scale, ray.direction));
            let same = match (expected, found) {
                (None, None) => true,
                (Some(a), Some(b)) => {
                    let near = (b.distance / scale - a.distance).abs() < 1e-4 * (1.0 + a.distance);
                    near && a.geometric_normal.distance(b.geometric_normal) < 1e-2
                }
                _ => false,
            };
            differing += u32::from(!same);
        }
        // Rays that graze an outline may be rounded to either side of it.
        assert!(differing <= 5, "at {text} units {differing} of 100000 rays differ");
    }
}

// ---- Closed forms. ------------------------------------------------------------------------------------------------

/// The first hit of the ray `o + t·d`, and how near the ray comes to the shape's outline.
type ClosedForm = fn(DVec3, DVec3) -> Option<f64>;

fn plane_z(o: DVec3, d: DVec3, inside: impl Fn(DVec3) -> bool) -> Option<f64> {
    let distance = -o.z / d.z;
    (distance > 0.0 && inside(o + d * distance)).then_some(distance)
}

fn quadratic(a: f64, half_b: f64, c: f64, accept: impl Fn(f64) -> bool) -> Option<f64> {
    let discriminant = half_b * half_b - a * c;
    let root = (discriminant >= 0.0).then(|| discriminant.sqrt())?;
    [(-half_b - root) / a, (-half_b + root) / a].into_iter().find(|distance| *distance > 0.0 && accept(*distance))
}

const CLOSED_FORMS: [(&str, f64, ClosedForm); 5] = [
    ("rectangle", 4.0, |o, d| plane_z(o, d, |p| p.x.abs() <= 1.0 && p.y.abs() <= 1.0)),
    ("disk", PI, |o, d| plane_z(o, d, |p| p.length_squared() <= 1.0)),
    ("sphere", 4.0 * PI, |o, d| quadratic(1.0, o.dot(d), o.length_squared() - 1.0, |_| true)),
    ("cylinder", 2.0 * PI, |o, d| {
        let (flat_o, flat_d) = (o.truncate(), d.truncate());
        let (a, half_b, c) = (flat_d.length_squared(), flat_o.dot(flat_d), flat_o.length_squared() - 1.0);
        quadratic(a, half_b, c, |distance| (0.0..=1.0).contains(&(o.z + d.z * distance)))
    }),
    ("cube", 24.0, |o, d| {
        let (one, other) = ((-1.0 - o) / d, (1.0 - o) / d);
        let (enter, leave) = (one.min(other).max_element(), one.max(other).min_element());
        (enter <= leave && leave > 0.0).then_some(if enter > 0.0 { enter } else { leave })
    }),
];

#[test]
fn analytic_shapes_agree_with_their_formulas() {
    for (name, _, closed_form) in CLOSED_FORMS {
        let scene = scene(&format!("<shape type='{name}'>{TWO_SIDED}</shape>"), &[]);
        let (mut differing, mut hits) = (0, 0);
        for (index, ray) in (0..).zip(rays(40, 50_000)) {
            // Every other ray starts far away and is aimed at the middle.
            let aimed = ray.origin * 20.0;
            let ray = if index % 2 == 0 { ray } else { Ray::new(aimed, (ray.origin * 0.5 - aimed).normalize()) };
            let expected = closed_form(ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let found = scene.geometry.intersect(&ray).map(|hit| f64::from(hit.distance));
            let close = |a: f64, b: f64| (a - b).abs() < 1e-4 * (1.0 + a);
            let same = match (expected, found) {
                (Some(expected), Some(found)) => close(expected, found),
                (None, None) => true,
                _ => false,
            };
            differing += u32::from(!same);
            hits += u32::from(expected.is_some());
        }
        assert!(hits > 10_000, "{name}: only {hits} hits");
        // Rays that graze the outline.
        assert!(differing <= 5, "{name}: {differing} of 50000 rays differ from the formula");
    }
}

#[test]
fn analytic_sampled_points_lie_on_their_shape() {
    for (name, area, _) in CLOSED_FORMS {
        let scene = scene(&format!("<shape type='{name}'>{TWO_SIDED}</shape>"), &[]);
        let count = if name == "cube" { 12 } else { 1 };
        let primitives: Vec<&Primitive> = (0..count).map(|index| scene.geometry.primitive(index)).collect();
        let total: f64 = primitives.iter().map(|primitive| f64::from(primitive.area())).sum();
        assert!((total / area - 1.0).abs() < 1e-6, "{name} has an area of {total}");
        for (index, primitive) in (0..20_000).zip(primitives.iter().cycle()) {
            let u = uniform(50, index);
            let point = primitive.sample([u[0], u[1]]);
            let p = point.position.as_dvec3();
            let off = match name {
                "rectangle" => p.z.abs().max(p.x.abs() - 1.0).max(p.y.abs() - 1.0),
                "disk" => p.z.abs().max(p.length() - 1.0),
                "sphere" => (p.length() - 1.0).abs(),
                "cylinder" => (p.truncate().length() - 1.0).abs().max(-p.z).max(p.z - 1.0),
                _ => (p.abs().max_element() - 1.0).abs(),
            };
            assert!(off <= f64::from(point.error), "{name}: {p} is off the shape by {off}");
            let expected = match name {
                "rectangle" | "disk" => DVec3::Z,
                "sphere" => p.normalize(),
                "cylinder" => DVec3::new(p.x, p.y, 0.0).normalize(),
                _ => {
                    let axis = (0..3).max_by(|a, b| p[*a].abs().total_cmp(&p[*b].abs())).expect("three axes");
                    DVec3::AXES[axis] * p[axis].signum()
                }
            };
            // On a cube's edge two faces are equally near.
            let on_edge = name == "cube" && p.abs().to_array().iter().filter(|x| **x > 0.9999).count() > 1;
            assert!(
                on_edge || point.normal.as_dvec3().distance(expected) < 1e-5,
                "{name}: normal {} at {p}",
                point.normal
            );
            // The point is found again from outside.
            let ray = Ray::new(point.position + point.normal, -point.normal);
            let hit = scene.geometry.intersect(&ray);
            let inner = name == "cylinder" || name == "rectangle" || name == "disk" || hit.is_some();
            assert!(inner, "{name}: {p} is not found again");
        }
    }
}

/// Axis-aligned rays have components that are zero, of either sign.
#[test]
fn analytic_rays_along_the_axes_hit() {
    let cube = scene(&format!("<shape type='cube'>{TWO_SIDED}</shape>"), &[]);
    for axis in 0..3 {
        for signs in 0..8 {
            let sign = |bit: usize| if signs >> bit & 1 == 1 { -1.0f32 } else { 1.0 };
            let mut direction = Vec3::new(0.0f32.copysign(sign(0)), 0.0f32.copysign(sign(1)), 0.0f32.copysign(sign(2)));
            direction[axis] = sign(axis);
            for index in 0..100 {
                let ray = Ray::new(in_cube(60, index) * 0.99 - direction * 3.0, direction);
                assert!(cube.geometry.intersect(&ray).is_some(), "a ray along {direction:?} misses");
                assert!(cube.geometry.is_blocked(&ray), "a shadow ray along {direction:?} misses");
            }
        }
    }
}

/// In a mirror the order of a mesh's corners says that the inside is outside, as in Mitsuba, but with `keep_outside`; so it is with spheres.
#[test]
fn analytic_mirrored_shapes_turn_over_unless_they_keep_their_outside() {
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let mesh = |face_normals: bool| {
        format!(
            "<shape type='obj'><string name='filename' value='t.obj'/><boolean name='face_normals' value='{face_normals}'/>"
        )
    };
    let sphere = "<shape type='sphere'><point name='center' x='0.25' y='0.25' z='0.25'/>".to_owned();
    for shape in [mesh(true), mesh(false), sphere] {
        for (scale, flip, keep) in [(1.0, false, false), (1.0, true, true), (-1.0, false, false), (-1.0, true, false)]
            .into_iter()
            .chain([(-1.0, false, true), (-1.0, true, true)])
        {
            let body = format!(
                "{shape}<boolean name='flip_normals' value='{flip}'/><boolean name='keep_outside' value='{keep}'/>\
                <transform name='to_world'><scale x='{scale}' y='1' z='1'/></transform>{TWO_SIDED}</shape>"
            );
            let scene = scene(&body, &[("t.obj", tetrahedron.to_owned())]);
            let middle = Vec3::new(0.25 * scale, 0.25, 0.25);
            let turns = scale < 0.0 && !keep;
            for index in 0..1000 {
                let out = direction(70, index);
                let hit = scene.geometry.intersect(&Ray::new(middle + out * 5.0, -out)).expect("the middle is inside");
                let outside = hit.geometric_normal.dot(out) > 0.0;
                assert_eq!(outside, flip == turns, "{shape}: scale {scale}, flip {flip}, keep {keep}");
            }
        }
    }
}
