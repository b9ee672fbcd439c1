//! Instances: hit by hit the same as the shapes of their group moved where the instance stands, tight, with error bounds
//! that keep rays from meeting the surface that they leave, and small.

use crate::scene_text;
use std::fmt::Write as _;

use crate::shape_text::{read_shapes, shape_nodes};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Vec3, warp};
use photonfarm::scene::fields::Fields;
use photonfarm::scene::geometry::{Geometry, Instance, Interaction, Ray, Shape};

fn uniform(family: u32, index: u32) -> [f32; 4] {
    PathRandom::new(7, Stream::Camera, family, index).block(0)
}

fn direction(family: u32, index: u32) -> Vec3 {
    let u = uniform(family, index);
    warp::sphere([u[0], u[1]])
}

fn in_cube(family: u32, index: u32) -> Vec3 {
    let u = uniform(family, index);
    Vec3::new(u[0], u[1], u[2]) * 2.0 - 1.0
}

const WAVE: &str = "v 0 0 0\nv 1 0 0.2\nv 1 1 -0.1\nv 0 1 0.3\nv -0.5 0.5 0.1\nvt 0.1 0.2\nvt 0.9 0.1\nvt 0.8 0.7\n\
    vt 0.2 0.9\nvt -0.4 0.6\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\nf 1/1 4/4 5/5\n";

/// Shapes, each with `steps` after its own transform.
fn zoo(steps: &str, any_affine: bool) -> String {
    let shape = |kind: &str, own: &str, parameters: &str| {
        format!("<shape type='{kind}'>{parameters}<transform name='to_world'>{own}{steps}</transform></shape>")
    };
    let mut shapes = shape("rectangle", "<rotate x='1' angle='-90'/><translate y='-1'/>", "");
    shapes += &shape("disk", "<scale value='0.6'/><rotate x='1' y='1' angle='50'/><translate x='-0.5' z='0.4'/>", "");
    shapes += &shape(
        "cube",
        "<scale x='0.2' y='0.3' z='0.25'/><rotate y='1' angle='30'/><translate value='0.5, -0.4, 0.4'/>",
        "",
    );
    // Instances keep the outside in a mirror.
    let keep = "<boolean name='keep_outside' value='true'/>";
    // Normals are interpolated before an instance shears them and after a mesh is sheared: flat ones are the same.
    let flat = format!("<boolean name='face_normals' value='{any_affine}'/>");
    shapes += &shape(
        "obj",
        "<translate value='-0.8, 0.3, 0.2'/>",
        &format!("<string name='filename' value='wave.obj'/>{flat}{keep}"),
    );
    if !any_affine {
        let radius = format!("<float name='radius' value='0.3'/>{keep}");
        shapes += &shape("sphere", "<translate value='0.4, 0.5, -0.3'/>", &radius);
        shapes += &shape(
            "cylinder",
            "<rotate x='1' angle='30'/><translate value='-0.4, -0.5, -0.5'/>",
            "<float name='radius' value='0.2'/>",
        );
    }
    shapes
}

fn geometry(body: &str, needs_uv: bool) -> Geometry {
    let shapes = read_shapes(body, &[("wave.obj", WAVE.as_bytes())]).expect("the shapes are good");
    let shapes = (0..).zip(shapes).map(|(material, geometry)| (Shape { needs_uv, ..Shape::new(material) }, geometry));
    Geometry::build(shapes.collect()).0
}

fn instance(steps: &str, group: u32) -> Instance {
    let nodes = shape_nodes(&format!("<shape type='instance'><transform name='to_world'>{steps}</transform></shape>"));
    Instance::read(&mut Fields::new(&nodes[0]), group).expect("the transform is good")
}

/// A scene of nothing but one group at several places.
fn instances(body: &str, needs_uv: bool, places: &[&str]) -> Geometry {
    let instances: Vec<Instance> = places.iter().map(|steps| instance(steps, 0)).collect();
    geometry("", needs_uv).with_instances(vec![geometry(body, needs_uv)], &instances)
}

fn assert_same(found: &Interaction, expected: &Interaction, geometries: [&Geometry; 2], what: &str) {
    let near = |a: Vec3, b: Vec3, tolerance: f32, of: &str| {
        assert!(a.distance(b) <= tolerance * (1.0 + b.length()), "{what}: {of} {a} for {b}");
    };
    assert!((found.distance - expected.distance).abs() < 1e-3 * (1.0 + expected.distance), "{what}: distance");
    assert!(found.position.distance(expected.position) < 1e-3 * (1.0 + expected.position.length()), "{what}: position");
    near(found.geometric_normal, expected.geometric_normal, 1e-3, "normal");
    near(found.frame.normal, expected.frame.normal, 1e-3, "shading normal");
    near(found.frame.tangent, expected.frame.tangent, 1e-2, "tangent");
    near(found.frame.bitangent, expected.frame.bitangent, 1e-2, "bitangent");
    assert_eq!(found.outgoing, expected.outgoing);
    assert_eq!(found.shape.material, expected.shape.material);
    assert!(found.uv.distance(expected.uv) < 2e-3, "{what}: uv {} for {}", found.uv, expected.uv);
    let [a, b] = [geometries[0].partials(found), geometries[1].partials(expected)];
    near(a[0], b[0], 1e-2, "∂p/∂u");
    near(a[1], b[1], 1e-2, "∂p/∂v");
}

#[test]
fn agreement_of_instances_with_moved_shapes() {
    let places = [
        ("<translate x='0'/>", false),
        ("<rotate x='1' y='2' z='-1' angle='70'/><translate value='3, 4, -5'/>", false),
        ("<scale value='0.01'/><translate value='0, 1, 0'/>", false),
        ("<scale value='100'/>", false),
        ("<scale x='-1'/><translate value='1, 0, 0'/>", false),
        ("<scale x='2' y='0.5' z='1'/><rotate z='1' angle='20'/><scale x='1' y='3' z='1'/><translate y='-2'/>", true),
    ];
    for (place, any_affine) in places {
        let direct = geometry(&zoo(place, any_affine), true);
        let placed = instances(&zoo("", any_affine), true, &[place]);
        let (low, high) = direct.bounds();
        let (placed_low, placed_high) = placed.bounds();
        assert!(placed_low.cmple(low + 1e-3).all() && placed_high.cmpge(high - 1e-3).all(), "{place}: bounds");
        let (center, size) = ((low + high) * 0.5, high - low);
        let (mut differing, mut hits) = (0, 0);
        for index in 0..20_000 {
            let from = center + in_cube(1, index) * size;
            let ray = Ray::new(from, (center + in_cube(2, index) * size * 0.4 - from).normalize());
            let (found, expected) = (placed.intersect(&ray), direct.intersect(&ray));
            assert_eq!(placed.is_blocked(&ray), found.is_some());
            match (found, expected) {
                (None, None) => {}
                // Near an edge one may hit what the other misses; near a seam uv jumps; near a pole it turns.
                (Some(found), Some(expected)) if found.shape.material == expected.shape.material => {
                    hits += 1;
                    let near_seam = found.uv.distance(expected.uv) > 0.9;
                    let singular = direct.partials(&expected)[1].length() < 0.1 * size.length() / 3.0;
                    let apart = (found.distance - expected.distance).abs() > 1e-3 * (1.0 + expected.distance);
                    let edge = apart || found.geometric_normal.distance(expected.geometric_normal) > 0.1;
                    if near_seam || singular || edge {
                        differing += u32::from(edge);
                    } else {
                        assert_same(&found, &expected, [&placed, &direct], place);
                    }
                }
                _ => differing += 1,
            }
        }
        assert!(hits > 5000, "{place}: only {hits} hits");
        assert!(differing <= 10, "{place}: {differing} of 20000 rays differ");
    }
}

#[test]
fn agreement_of_many_instances_among_other_shapes() {
    let places: Vec<String> = (0..40)
        .map(|index| {
            let [p, d] = [in_cube(3, index) * 6.0, in_cube(4, index)];
            format!(
                "<scale value='0.5'/><rotate x='{}' y='{}' z='{}' angle='77'/><translate value='{}, {}, {}'/>",
                d.x, d.y, d.z, p.x, p.y, p.z
            )
        })
        .collect();
    let beside = "<shape type='rectangle'><transform name='to_world'><scale value='8'/></transform></shape>";
    let all: String = places.iter().map(|place| zoo(place, false)).collect();
    let direct = geometry(&(all + beside), false);
    let instances: Vec<Instance> = places.iter().map(|place| instance(place, 0)).collect();
    let placed = geometry(beside, false).with_instances(vec![geometry(&zoo("", false), false)], &instances);
    let mut differing = 0;
    for index in 0..50_000 {
        let from = in_cube(5, index) * 9.0;
        let length = if index % 2 == 0 { f32::INFINITY } else { uniform(6, index)[0] * 6.0 };
        let ray = Ray { length, ..Ray::new(from, direction(7, index)) };
        let (found, expected) = (placed.intersect(&ray), direct.intersect(&ray));
        let same = match (found, expected) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                (a.distance - b.distance).abs() < 1e-3 && a.geometric_normal.distance(b.geometric_normal) < 1e-2
            }
            _ => false,
        };
        differing += u32::from(!same);
        assert_eq!(placed.is_blocked(&ray), found.is_some(), "{ray:?}");
    }
    assert!(differing <= 10, "{differing} of 50000 rays differ");
}

// ---- Rounding. ----------------------------------------------------------------------------------------------------

/// Where single precision is put to the test: far away, tiny, huge, flattened, and seen from far away.
const PLACES: [&str; 6] = [
    "<translate value='300, -200, 100'/>",
    "<scale value='0.001'/><rotate x='1' y='1' angle='40'/><translate value='5, 6, 7'/>",
    "<scale value='3000'/><rotate x='1' y='1' angle='40'/><translate value='5, 6, 7'/>",
    "<scale x='100' y='1' z='0.01'/><rotate x='1' y='1' z='3' angle='40'/><translate value='-7, 20, 3'/>",
    "<rotate x='1' y='1' z='3' angle='40'/><scale x='1' y='0.02' z='1'/><rotate z='1' angle='50'/><translate x='40'/>",
    "<scale x='-1' y='2' z='1'/><translate value='-4, 0, 1'/>",
];

/// The middle of what stands at a place, and a point inside of the unit ball carried there.
fn inside(geometry: &Geometry) -> Vec3 {
    let (low, high) = geometry.bounds();
    (low + high) * 0.5
}

#[test]
fn analytic_walks_inside_instances_stay_inside() {
    for (place, kind) in PLACES.iter().flat_map(|place| [(place, "sphere"), (place, "cube")]) {
        // What is but some thousand roundings wide leaks near its edges, wherever its corners come from.
        let rounds = place.contains("0.01") || kind == "cube" && place.contains("0.0");
        if !rounds {
            let geometry = instances(&format!("<shape type='{kind}'/>"), false, &[place]);
            let mut ray = Ray::new(inside(&geometry), direction(14, 0));
            for step in 0..30_000 {
                let hit = geometry.intersect(&ray);
                let hit = hit.unwrap_or_else(|| panic!("{kind} at {place}: leaked after {step} bounces"));
                let inward = if hit.outgoing.dot(hit.geometric_normal) < 0.0 { -1.0 } else { 1.0 };
                let next = direction(14, step + 1);
                ray = hit.ray_to(next * next.dot(hit.geometric_normal * inward).signum());
            }
        }
    }
}

#[test]
fn analytic_rays_that_leave_a_convex_instance_never_meet_it_again() {
    for place in PLACES {
        for kind in ["sphere", "cube"] {
            let geometry = instances(&format!("<shape type='{kind}'/>"), false, &[place]);
            let middle = inside(&geometry);
            let radius = geometry.bounding_sphere().1;
            let (mut again, mut hits) = (0, 0);
            for index in 0..20_000 {
                // From up to a thousand radii away.
                let from = middle + direction(15, index) * radius * 10f32.powf(uniform(16, index)[0] * 3.0 + 0.1);
                let towards = middle + in_cube(17, index) * radius * 0.1;
                let Some(hit) = geometry.intersect(&Ray::new(from, (towards - from).normalize())) else { continue };
                hits += 1;
                let out = direction(18, index);
                let out = out * out.dot(hit.geometric_normal).signum();
                let outwards = hit.outgoing.dot(hit.geometric_normal) > 0.0;
                again += u32::from(outwards && geometry.is_blocked(&hit.ray_to(out)));
            }
            assert!(hits > 500, "{kind} at {place}: only {hits} hits");
            assert_eq!(again, 0, "{kind} at {place}: of {hits}");
        }
    }
}

#[test]
fn analytic_error_bounds_stay_small() {
    for place in PLACES {
        let geometry = instances("<shape type='sphere'/>", false, &[place]);
        let (middle, radius) = geometry.bounding_sphere();
        let reach = middle.length() + radius;
        for index in 0..2000 {
            let from = middle + direction(19, index) * radius * 2.0;
            let Some(hit) = geometry.intersect(&Ray::new(from, (middle - from).normalize())) else { continue };
            assert!(hit.error > 0.0 && hit.error < 1e-4 * reach, "{place}: {} where numbers reach {reach}", hit.error);
        }
    }
}

// ---- Size. --------------------------------------------------------------------------------------------------------

/// A forest: as many instances as there may be trees are built, and each is found where it stands.
#[test]
fn instances_are_small_and_many() {
    assert!(size_of::<Instance>() <= 128, "an instance takes {} bytes", size_of::<Instance>());
    const SIDE: u32 = 317;
    let place = |index: u32| [(index % SIDE) as f32, (index / SIDE) as f32];
    let instances: Vec<Instance> = (0..SIDE * SIDE)
        .step_by(331)
        .map(|index| {
            let [x, y] = place(index);
            instance(&format!("<scale value='0.3'/><translate x='{x}' y='{y}'/>"), 0)
        })
        .collect();
    let count = instances.len();
    let forest = geometry("", false).with_instances(vec![geometry("<shape type='sphere'/>", false)], &instances);
    for index in (0..SIDE * SIDE).step_by(331) {
        let [x, y] = place(index);
        let hit = forest.intersect(&Ray::new(Vec3::new(x, y, 2.0), -Vec3::Z)).expect("a tree stands there");
        assert!(hit.position.distance(Vec3::new(x, y, 0.3)) < 1e-4, "{count} instances");
    }
}

// ---- Scenes. ------------------------------------------------------------------------------------------------------

#[test]
fn a_group_is_seen_only_where_it_is_placed() {
    let mut body = "<sensor type='perspective'/><emitter type='point'/><shape type='shapegroup' id='pair'>\
        <shape type='sphere'><bsdf type='diffuse'><rgb name='reflectance' value='0.1, 0.2, 0.3'/></bsdf></shape>\
        <shape type='cube'><transform name='to_world'><translate z='3'/></transform></shape></shape>"
        .to_owned();
    for x in [10, 20] {
        write!(
            body,
            "<shape type='instance'><ref id='pair'/><transform name='to_world'><translate x='{x}'/></transform></shape>"
        )
        .unwrap();
    }
    let scene = scene_text::prepare(&body, &[]).expect("the scene is good");
    let down = |x: f32| scene.geometry.intersect(&Ray::new(Vec3::new(x, 0.0, 10.0), -Vec3::Z));
    let up = |x: f32| scene.geometry.intersect(&Ray::new(Vec3::new(x, 0.0, -10.0), Vec3::Z));
    assert!(down(0.0).is_none());
    for x in [10.0, 20.0] {
        let (top, bottom) = (down(x).expect("the cube"), up(x).expect("the sphere"));
        assert!(top.position.distance(Vec3::new(x, 0.0, 4.0)) < 1e-4);
        assert!(bottom.position.distance(Vec3::new(x, 0.0, -1.0)) < 1e-4);
        assert_ne!(top.shape.material, bottom.shape.material);
    }
    assert_eq!(scene.materials.len(), 2, "instances share the materials of their group");
}
