//! `radiancemeter`: one number, the radiance that comes along a ray.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `origin`, `direction` | the ray against the light, both or none | – |
//! | `to_world` | the same: from its origin along its +z; it counts before `origin` and `direction` | identity |
//!
//! Its film has one pixel. A perspective camera whose pixel is 0.01° wide takes its place, so that methods may look at it from lights.

use glam::{DVec3, Vec2};

use super::{Camera, Projection};
use crate::math::Frame;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::transform::{ToWorld, to_single};

/// Tangent of half the angle across the pixel.
const HALF_EXTENT: f32 = 8.726_646e-5;

/// Reads the parameters, for a film of so many pixels.
pub(super) fn read(fields: &mut Fields<'_>, [width, height]: [u32; 2]) -> Result<Camera, SceneError> {
    if [width, height] != [1, 1] {
        let problem = format!("the film of a radiancemeter has {width} × {height} pixels");
        return Err(SceneError::new(fields.location(), problem, "give it one of width 1 and height 1"));
    }
    let given = fields.has("to_world");
    let to_world = ToWorld::read(fields)?;
    let (origin, direction) = match (fields.vector("origin")?, fields.vector("direction")?) {
        (Some(origin), Some(direction)) if !given => (origin, direction),
        (origin, direction) if given || origin.is_some() == direction.is_some() => {
            (to_world.point(DVec3::ZERO), to_world.vector(DVec3::Z))
        }
        (origin, _) => {
            let name = if origin.is_some() { "origin" } else { "direction" };
            return Err(fields.error(name, "\"origin\" and \"direction\" belong together", "give both"));
        }
    };
    let Some(forward) = direction.try_normalize() else {
        return Err(fields.error("direction", "\"direction\" has no length", "give a vector that is not zero"));
    };
    let forward = forward.as_vec3();
    let frame = Frame::from_normal(forward);
    Ok(Camera {
        position: to_single(origin, fields)?,
        axes: [frame.tangent, frame.bitangent, forward],
        half_extent: Vec2::splat(HALF_EXTENT),
        projection: Projection::Perspective,
        principal_point: Vec2::ZERO,
        aperture_radius: 0.0,
        focus_distance: 1.0,
        near: 0.0,
        far: f32::MAX,
    })
}
