//! What is refused of a scene whose parts are good.

use crate::math::{Vec2, Vec3};
use crate::scene::camera::Camera;
use crate::scene::description::Node;
use crate::scene::error::SceneError;
use crate::scene::geometry::Geometry;
use crate::scene::material::{Material, TransportMode, View};

/// The farthest that surfaces may reach from the origin, m: squares of distances must fit into single precision.
const FARTHEST: f32 = 1e18;

/// Refuses boxes that single precision cannot reckon with.
pub(super) fn check_reach(node: &Node, mut boxes: impl Iterator<Item = (Vec3, Vec3)>) -> Result<(), SceneError> {
    let near = |corner: Vec3| corner.abs().cmplt(Vec3::splat(FARTHEST)).all();
    if boxes.all(|(low, high)| near(low) && near(high)) {
        return Ok(());
    }
    let problem = format!("shape \"{}\" reaches farther than {FARTHEST:e} m from the origin", node.plugin);
    Err(SceneError::new(&node.location, problem, "check its size and its to_world"))
}

/// A camera that sees nothing but the black backs of one-sided surfaces stands inside a solid.
pub(super) fn check_view(
    camera: &Camera,
    geometry: &Geometry,
    materials: &[Material],
    sensor: &Node,
) -> Result<(), SceneError> {
    const SIDE: usize = 16;
    if camera.is_distant() {
        return Ok(());
    }
    let sees_black_back = |index: usize| {
        let place = Vec2::new((index % SIDE) as f32 + 0.5, (index / SIDE) as f32 + 0.5) / SIDE as f32;
        let hit = geometry.intersect(&camera.ray(place, [0.5; 2]));
        hit.is_some_and(|hit| {
            let outgoing = hit.frame.to_local(hit.outgoing);
            let material = &materials[hit.shape.material as usize];
            outgoing.z < 0.0 && material.sample(&View::at(&hit, TransportMode::Radiance), [0.5; 3]).is_none()
        })
    };
    if !(0..SIDE * SIDE).all(sees_black_back) {
        return Ok(());
    }
    let problem = "the camera sees only the black backs of one-sided surfaces: it seems to stand inside a solid";
    Err(SceneError::new(&sensor.location, problem, "move it out, or make those surfaces \"twosided\""))
}
