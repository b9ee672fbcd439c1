//! How long big scenes take to load and to build, on one thread. Run with `cargo test --test scene big_meshes -- --ignored
//! --nocapture`.

use std::fmt::Write as _;
use std::time::Instant;

use crate::shape_text::{read_shapes, shape_nodes};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Vec3, warp};
use photonfarm::scene::fields::Fields;
use photonfarm::scene::geometry::mesh::ShapeGeometry;
use photonfarm::scene::geometry::{Geometry, Instance, Ray, Shape};

/// Measures the time that this thread has worked, so that other programs do not count; where the system does not tell, the
/// time that has passed.
struct Stopwatch {
    passed: Instant,
    worked: Option<f64>,
}

impl Stopwatch {
    fn start() -> Self {
        Self { passed: Instant::now(), worked: Self::worked() }
    }

    fn worked() -> Option<f64> {
        let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
        Some(text.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
    }

    fn seconds(&self) -> f64 {
        let worked = self.worked.zip(Self::worked()).map(|(start, end)| end - start);
        worked.unwrap_or_else(|| self.passed.elapsed().as_secs_f64())
    }
}

/// A bumpy ball of `2·rings·sectors` triangles: its vertices and triangles.
fn bumpy_ball(rings: u32, sectors: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for ring in 0..=rings {
        for sector in 0..sectors {
            let (theta, phi) = (
                std::f32::consts::PI * (ring as f32 + 0.5) / (rings as f32 + 1.0),
                std::f32::consts::TAU * sector as f32 / sectors as f32,
            );
            let radius = 1.0 + 0.05 * (20.0 * theta).sin() * (17.0 * phi).cos();
            vertices.push(Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()) * radius);
        }
    }
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for sector in 0..sectors {
            let next = (sector + 1) % sectors;
            let [a, b] = [ring * sectors + sector, ring * sectors + next];
            triangles.extend([[a, a + sectors, b], [b, a + sectors, b + sectors]]);
        }
    }
    (vertices, triangles)
}

fn ply_file(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
        element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    )
    .into_bytes();
    vertices.iter().for_each(|vertex| bytes.extend(vertex.to_array().iter().flat_map(|x| x.to_le_bytes())));
    for triangle in triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

fn obj_file(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut text = String::new();
    vertices.iter().for_each(|v| writeln!(text, "v {} {} {}", v.x, v.y, v.z).unwrap());
    vertices.iter().for_each(|v| writeln!(text, "vt {} {}", v.x, v.y).unwrap());
    vertices.iter().for_each(|v| writeln!(text, "vn {} {} {}", v.x, v.y, v.z).unwrap());
    for [a, b, c] in triangles.iter().map(|triangle| triangle.map(|index| index + 1)) {
        writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}").unwrap();
    }
    text.into_bytes()
}

fn trace(geometry: &Geometry) -> (f64, u32) {
    let start = Stopwatch::start();
    let mut hits = 0;
    for index in 0..300_000 {
        let u = PathRandom::new(1, Stream::Camera, 1, index).block(0);
        let from = warp::sphere([u[0], u[1]]) * 1.5;
        let to = warp::sphere([u[2], u[3]]);
        hits += u32::from(geometry.intersect(&Ray::new(from, (to - from).normalize())).is_some());
    }
    (start.seconds(), hits)
}

fn load(kind: &str, bytes: &[u8], limit: f64) -> ShapeGeometry {
    let shape = format!("<shape type='{kind}'><string name='filename' value='a'/></shape>");
    let start = Stopwatch::start();
    let shapes = read_shapes(&shape, &[("a", bytes)]).expect("the mesh is good");
    let seconds = start.seconds();
    println!("{kind} of {} MB: loaded in {seconds:.2} s", bytes.len() >> 20);
    assert!(seconds < limit, "{kind} takes {seconds} s");
    shapes.into_iter().next().expect("there is one shape")
}

#[test]
#[ignore = "takes half a minute, and measures time"]
fn a_million_triangles_load_and_build() {
    let (vertices, triangles) = bumpy_ball(500, 1000);
    load("obj", &obj_file(&vertices, &triangles), 10.0);
    let geometry = load("ply", &ply_file(&vertices, &triangles), 10.0);
    assert_eq!(geometry.primitives.len(), 1_000_000);
    let start = Stopwatch::start();
    let geometry = Geometry::build(vec![(Shape::new(0), geometry)]).0;
    let seconds = start.seconds();
    println!("built in {seconds:.2} s");
    println!("300000 rays in {:.3} s, {} hits", trace(&geometry).0, trace(&geometry).1);
    assert!(seconds < 5.0, "building takes {seconds} s");
}

#[test]
#[ignore = "measures time"]
fn trees_by_size() {
    for (rings, sectors) in [(50, 100), (100, 250), (200, 500), (300, 1000)] {
        let (vertices, triangles) = bumpy_ball(rings, sectors);
        let geometry = load("ply", &ply_file(&vertices, &triangles), 10.0);
        let start = Stopwatch::start();
        let geometry = Geometry::build(vec![(Shape::new(0), geometry)]).0;
        let seconds = start.seconds();
        println!("{} triangles built in {seconds:.3} s; rays in {:.3} s", triangles.len(), trace(&geometry).0);
    }
}

#[test]
#[ignore = "measures time"]
fn a_hundred_thousand_instances_build() {
    let node = &shape_nodes("<shape type='instance'/>")[0];
    let instances: Vec<Instance> = (0..100_000)
        .map(|index| {
            let u = PathRandom::new(2, Stream::Camera, 1, index).block(0);
            let place = glam::DVec3::new(f64::from(u[0]), f64::from(u[1]), f64::from(u[2])) * 100.0;
            let turn = glam::DQuat::from_rotation_z(f64::from(u[3]) * 6.0);
            let mut node = (**node).clone();
            node.parameters.push(photonfarm::scene::description::Parameter {
                name: "to_world".to_owned(),
                value: photonfarm::scene::description::Value::Transform(glam::DMat4::from_rotation_translation(
                    turn, place,
                )),
                location: node.location.clone(),
            });
            Instance::read(&mut Fields::new(&node), 0).expect("the transform is good")
        })
        .collect();
    let (vertices, triangles) = bumpy_ball(50, 100);
    let ball = load("ply", &ply_file(&vertices, &triangles), 10.0);
    let group = Geometry::build(vec![(Shape::new(0), ball)]).0;
    let start = Stopwatch::start();
    let forest = Geometry::build(Vec::new()).0.with_instances(vec![group], &instances);
    let seconds = start.seconds();
    println!("{} instances built in {seconds:.2} s", instances.len());
    assert!(seconds < 5.0, "building takes {seconds} s");
    let middle = Vec3::splat(50.0);
    assert!(forest.intersect(&Ray::new(middle * 3.0, -Vec3::ONE.normalize())).is_some());
}
