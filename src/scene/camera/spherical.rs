//! `spherical`: what a film of all around sees.

use glam::Vec3;

use super::{Camera, SeenByCamera};
use crate::math::Vec2;

impl Camera {
    /// [`Camera::look_at`] of a camera that sees all around.
    pub(super) fn look_around(&self, point: Vec3) -> Option<SeenByCamera> {
        let between = point - self.position;
        let distance = between.length();
        if !(distance > self.near && distance < self.far) {
            return None;
        }
        let direction = between / distance;
        let [left, up, forward] = self.axes.map(|axis| direction.dot(axis));
        let angles = Vec2::new(libm::atan2f(left, forward), libm::atan2f(up, libm::hypotf(left, forward)));
        Some(SeenByCamera {
            film: Vec2::splat(0.5) - angles / (2.0 * self.half_extent),
            direction: -direction,
            spread: distance * distance,
            visible_distance: distance - self.near,
            pdf: self.pdf(direction),
        })
    }
}
