//! What media that absorb let pass along the segments of a path.

use super::path::{Path, Terms};
use crate::math::random::{PathRandom, Stream};
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::Ray;
use crate::scene::{MediumIndex, Scene};

/// The share of light that passes a segment of `length`, m, in `medium`, which absorbs evenly.
pub(crate) fn passing(scene: &Scene, medium: MediumIndex, origin: Vec3, direction: Vec3, length: f32) -> Rgb {
    let Some(medium) = scene.medium(medium) else { return Rgb::ONE };
    // Media that need random numbers scatter light, and are not rendered so.
    medium.transmittance(&Ray { origin, direction, length }, || PathRandom::new(0, Stream::Branch, 0, 0))
}

impl Path {
    /// Fills in what passes each segment, from the camera on, since that knows where it stands. Nothing is filled in where there are no media.
    pub(super) fn absorb(&self, scene: &Scene, terms: &mut Terms) {
        terms.passing.clear();
        if scene.media.is_empty() {
            return;
        }
        let mut medium = scene.camera_medium;
        for index in (1..self.segments()).rev() {
            let (vertex, known) = (&self.vertices[index - 1], &terms.vertices[index - 1]);
            let length = match self.vertices.get(index) {
                None => terms.visible_distance,
                Some(next) => next.hit.position.distance(vertex.hit.position),
            };
            terms.passing.push(passing(scene, medium, vertex.hit.position, known.camera_direction, length));
            medium = scene.medium_beyond(&vertex.hit, known.light_direction, medium);
        }
        let (first, position) = (&terms.first, self.vertices[0].hit.position);
        terms.passing.push(passing(scene, medium, position, first.direction, first.distance));
        terms.passing.reverse();
        terms.carried *= terms.passing.iter().product::<Rgb>();
    }
}
