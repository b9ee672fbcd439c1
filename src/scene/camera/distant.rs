//! `distant`: one number, the radiance that a scene sends in a direction.
//!
//! | parameter | meaning | default |
//! |---|---|---|
//! | `direction` | against the light: where its parallel rays go | – |
//! | `to_world` | the same: along its +z; one of both | identity |
//! | `target` | a point that all rays go through | the disc of the scene's bounding sphere, evenly |
//!
//! Its film has one pixel, and rays begin outside of the scene. Whatever is beside the scene in the disc counts, too. A shape as `target` is
//! refused. A point is a disc of 10⁻⁵ of the scene's radius, so that methods may look at it from lights.

use glam::{DVec3, Vec2, Vec3};

use super::{Camera, Projection, SeenByCamera};
use crate::math::Frame;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::transform::{ToWorld, to_single};

/// Radius of the disc that stands for a point, as a share of the scene's.
const POINT: f32 = 1e-5;

/// What a distant sensor looks at.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    /// The whole scene.
    Scene,
    /// A point, m.
    Point(Vec3),
}

/// Reads the parameters, for a film of so many pixels. The camera stands nowhere until [`Camera::stand_outside`].
pub(super) fn read(fields: &mut Fields<'_>, [width, height]: [u32; 2]) -> Result<Camera, SceneError> {
    if [width, height] != [1, 1] {
        let problem = format!("the film of a distant sensor has {width} × {height} pixels");
        return Err(SceneError::new(fields.location(), problem, "give it one of width 1 and height 1"));
    }
    let given = fields.has("to_world");
    let to_world = ToWorld::read(fields)?;
    let direction = match fields.vector("direction")? {
        Some(_) if given => {
            return Err(fields.error("direction", "there are \"direction\" and \"to_world\"", "give one of them"));
        }
        Some(direction) => direction,
        None => to_world.vector(DVec3::Z),
    };
    let Some(forward) = direction.try_normalize() else {
        return Err(fields.error("direction", "\"direction\" has no length", "give a vector that is not zero"));
    };
    if let Some(shape) = fields.child(PluginClass::Shape) {
        let problem = "the \"target\" of a distant sensor is a shape";
        return Err(SceneError::new(&shape.location, problem, "give a point, or leave it out for the whole scene"));
    }
    let target = match fields.vector("target")? {
        Some(point) => Target::Point(to_single(point, fields)?),
        None => Target::Scene,
    };
    let forward = forward.as_vec3();
    let frame = Frame::from_normal(forward);
    Ok(Camera {
        position: Vec3::ZERO,
        axes: [frame.tangent, frame.bitangent, forward],
        half_extent: Vec2::ONE,
        projection: Projection::Distant(target),
        principal_point: Vec2::ZERO,
        aperture_radius: 0.0,
        focus_distance: 1.0,
        near: 0.0,
        far: f32::MAX,
    })
}

impl Camera {
    /// Puts a distant sensor outside of the sphere around the scene, m; others stand where they do.
    pub fn stand_outside(&mut self, (center, radius): (Vec3, f32)) {
        let Projection::Distant(target) = self.projection else { return };
        let forward = self.axes[2];
        (self.position, self.aperture_radius) = match target {
            Target::Scene => (center - forward * radius, radius),
            Target::Point(point) => {
                // From wherever the point lies.
                let back = point.distance(center) + radius;
                (point - forward * back, POINT * radius)
            }
        };
    }

    /// [`Camera::look_at`] of a distant sensor. All of its film sees the same, so any place of it does, which `anywhere` in [0, 1)² chooses.
    pub(super) fn look_from_afar(&self, point: Vec3, anywhere: [f32; 2]) -> Option<SeenByCamera> {
        let [left, up, forward] = self.axes;
        let from_disc = point - self.position;
        let (across, depth) = (Vec2::new(from_disc.dot(left), from_disc.dot(up)), from_disc.dot(forward));
        let is_seen = depth > 0.0 && across.length_squared() <= self.aperture_radius * self.aperture_radius;
        is_seen.then(|| SeenByCamera {
            film: Vec2::from_array(anywhere),
            direction: -forward,
            spread: 1.0,
            visible_distance: depth,
            pdf: self.pdf(forward),
        })
    }
}
