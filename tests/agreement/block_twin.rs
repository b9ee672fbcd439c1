//! Blocks of eight primitives find what their primitives find one by one, to the bit.

use crate::chi_square::numbers;
use crate::scene_text::prepare;
use photonfarm::math::{Vec3, warp};
use photonfarm::scene::geometry::block::{Block, LANES};
use photonfarm::scene::geometry::one_sided_triangle::OneSidedTriangle;
use photonfarm::scene::geometry::ray::{PrimitiveHit, Shear};
use photonfarm::scene::geometry::triangle::Triangle;
use photonfarm::scene::geometry::{Primitive, Ray};

fn one_by_one(primitives: &[Primitive], ray: &Ray) -> Option<(usize, PrimitiveHit)> {
    let shear = Shear::new(ray.direction);
    let mut nearest: Option<(usize, PrimitiveHit)> = None;
    for (lane, primitive) in primitives.iter().enumerate() {
        let length = nearest.map_or(ray.length, |(_, hit)| hit.distance);
        if let Some(hit) = primitive.intersect(ray, &shear, length) {
            nearest = Some((lane, hit));
        }
    }
    nearest
}

/// Tests `count` rays from all around; how many hit something.
fn assert_same(primitives: &[Primitive], family: u32, count: u32) -> u32 {
    let block = Block::new(primitives);
    let mut hits = 0;
    for index in 0..count {
        let (u, v) = (numbers(family, index), numbers(family + 1, index));
        let origin = warp::sphere([u[0], u[1]]) * 3.0;
        // Every third ray goes along whole numbers, through vertices and edges.
        let target = Vec3::new(v[0], v[1], v[2]) * 2.0 - 1.0;
        let (origin, target) = if index % 3 == 0 { (origin.round(), target.round()) } else { (origin, target) };
        let Some(direction) = (target - origin).try_normalize() else { continue };
        let mut ray = Ray::new(origin, direction);
        if index % 5 == 0 {
            ray.length = 3.0 * u[2];
        }
        let found = block.intersect(primitives, &ray, &Shear::new(direction), ray.length);
        let expected = one_by_one(primitives, &ray);
        assert_eq!(found.map(|found| found.lane), expected.map(|(lane, _)| lane), "{ray:?}");
        if let (Some(found), Some((_, hit))) = (found, expected) {
            hits += 1;
            assert_eq!(found.hit.distance.to_bits(), hit.distance.to_bits(), "{ray:?}");
            assert_eq!(found.hit.barycentric, hit.barycentric, "{ray:?}");
        }
    }
    hits
}

#[test]
fn agreement_blocks_of_triangles_equal_their_plain_twin() {
    for count in 1..=LANES {
        let corner = |triangle: usize, corner: u32| {
            let u = numbers(900 + corner, triangle as u32);
            let point = Vec3::new(u[0], u[1], u[2]) * 2.0 - 1.0;
            // Half of them share corners on whole numbers, so that edges meet.
            if triangle.is_multiple_of(2) { point.round() } else { point }
        };
        let triangle = |index| Triangle { vertices: [0, 1, 2].map(|vertex| corner(index, vertex)) };
        let triangles: Vec<Primitive> = (0..count).map(|index| Primitive::Triangle(triangle(index))).collect();
        let all = assert_same(&triangles, 910 + 2 * count as u32, 20_000);
        let one_sided = |index| Primitive::OneSidedTriangle(OneSidedTriangle(triangle(index)));
        let one_sided: Vec<Primitive> = (0..count).map(one_sided).collect();
        let from_outside = assert_same(&one_sided, 910 + 2 * count as u32, 20_000);
        assert!(from_outside > 200 && all > 500, "{count} triangles");
        assert!(from_outside < all, "{count} triangles: {from_outside} of {all} hits");
    }
}

#[test]
fn agreement_blocks_of_rectangles_and_disks_equal_their_plain_twin() {
    let shapes: String = (0..LANES as u32)
        .map(|index| {
            let (u, v) = (numbers(930, index), numbers(931, index));
            let kind = if index % 2 == 0 { "rectangle" } else { "disk" };
            format!(
                "<shape type='{kind}'><transform name='to_world'><scale x='{}' y='{}'/><rotate x='1' y='{}' angle='{}'/>\
                 <translate x='{}' y='{}' z='{}'/></transform></shape>",
                0.2 + u[0],
                0.2 + u[1],
                u[2],
                360.0 * u[3],
                v[0] - 0.5,
                v[1] - 0.5,
                v[2] - 0.5
            )
        })
        .collect();
    let scene = prepare(&format!("<sensor type='perspective'/><emitter type='constant'/>{shapes}"), &[]);
    let geometry = scene.expect("the scene is good").geometry;
    let all: Vec<Primitive> = (0..LANES as u32).map(|index| *geometry.primitive(index)).collect();
    for count in 1..=LANES {
        assert!(assert_same(&all[..count], 940 + 2 * count as u32, 20_000) > 500, "{count} flat primitives");
    }
}
