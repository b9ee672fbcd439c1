//! Participating media of a description, and the shapes that separate them.

use std::sync::Arc;

use super::{Builder, Scene};
use crate::math::{Vec2, Vec3};
use crate::scene::description::{Node, PluginClass};
use crate::scene::error::{Location, SceneError};
use crate::scene::fields::Fields;
use crate::scene::geometry::surface::NO_BOUNDARY;
use crate::scene::geometry::{Interaction, Ray};
use crate::scene::light::Light;
use crate::scene::medium::{self, Medium, MediumIndex};
use crate::scene::notice::Notice;

/// The most surfaces behind which a medium is looked for.
const MOST_PASSED: usize = 1024;

impl Scene {
    /// A medium by its index.
    #[inline]
    pub fn medium(&self, index: MediumIndex) -> Option<&Medium> {
        index.map(|index| &self.media[usize::from(index)])
    }

    /// The media inside and outside of the shape at `hit`, where it separates two.
    #[inline]
    fn media_at(&self, hit: &Interaction) -> Option<[MediumIndex; 2]> {
        self.boundaries.get(usize::from(hit.shape.boundary)).copied()
    }

    /// The medium on the side of `direction` of a surface that was met in `medium`.
    #[inline]
    pub fn medium_beyond(&self, hit: &Interaction, direction: Vec3, medium: MediumIndex) -> MediumIndex {
        let Some([inside, outside]) = self.media_at(hit) else { return medium };
        if direction.dot(hit.geometric_normal) > 0.0 { outside } else { inside }
    }

    /// The medium in which a ray begins, by the first surface along it that separates two.
    pub fn medium_along(&self, ray: &Ray) -> MediumIndex {
        let before = |hit: &Interaction| self.media_at(hit).map(|_| self.medium_beyond(hit, hit.outgoing, None));
        self.surfaces_along(*ray).find_map(|hit| before(&hit)).unwrap_or(self.outermost_medium)
    }

    /// What of the media is likely to be a mistake.
    pub(super) fn notices_of_media(&self, sensor: &Location) -> Option<String> {
        if self.media.is_empty() {
            return None;
        }
        let around = self.medium_along(&self.camera.ray(Vec2::splat(0.5), [0.5; 2]));
        let (subject, explanation) = if around.is_some() && self.camera_medium.is_none() {
            let explanation =
                "the camera sees as if it stood outside, and methods differ: name the medium in the sensor, too";
            ("the medium around the camera", explanation)
        } else if self.outermost_medium.is_some() && self.lights.lights().iter().any(Light::is_distant) {
            ("light from outside", "it does not get through the medium, which has no end: enclose it in a shape")
        } else {
            return None;
        };
        Some(Notice::ignored(sensor, subject, explanation).to_string())
    }

    /// The medium beyond all surfaces, which the one that the camera stands in tells.
    pub(super) fn medium_outside(&self) -> MediumIndex {
        if self.media.is_empty() {
            return None;
        }
        let ray = self.camera.ray(Vec2::splat(0.5), [0.5; 2]);
        let beyond = |medium, hit: Interaction| self.medium_beyond(&hit, ray.direction, medium);
        self.surfaces_along(ray).fold(self.camera_medium, beyond)
    }

    fn surfaces_along(&self, ray: Ray) -> impl Iterator<Item = Interaction> {
        let next = move |hit: &Interaction| self.intersect(&hit.ray_to(ray.direction));
        std::iter::successors(self.intersect(&ray), next).take(MOST_PASSED)
    }

    /// Whether some media do more than absorb by distance alone, which few methods render.
    pub fn has_scattering_media(&self) -> bool {
        self.media.iter().any(|medium| !medium.only_absorbs())
    }
}

impl Builder<'_> {
    /// Renders a scene with media as if there were none.
    pub(super) fn leave_out_media(&mut self, place: &Location) {
        if self.media.is_empty() {
            return;
        }
        (self.media, self.boundaries) = (Vec::new(), Vec::new());
        let explanation = "the scene's integrator passes through them as if there were none; \"volpath\" renders them";
        self.notices.push(Notice::ignored(place, "the scene's participating media", explanation).to_string());
    }

    /// The index of a medium.
    pub(super) fn medium(&mut self, node: &Arc<Node>) -> Result<u16, SceneError> {
        let address = Arc::as_ptr(node);
        if let Some(known) = self.medium_of_node.get(&address) {
            return Ok(*known);
        }
        let index = u16::try_from(self.media.len()).map_err(|_| {
            SceneError::new(&node.location, "the scene has more than 65536 media", "share some of them")
        })?;
        self.media.push(medium::read(node, self.bundle)?);
        self.medium_of_node.insert(address, index);
        Ok(index)
    }

    /// The index of the media inside and outside of a shape, where it separates two.
    pub(super) fn boundary_of(&mut self, fields: &mut Fields<'_>, place: &Location) -> Result<u16, SceneError> {
        let nodes = ["interior", "exterior"].map(|name| fields.named_child(PluginClass::Medium, name));
        if nodes.iter().all(Option::is_none) {
            return Ok(NO_BOUNDARY);
        }
        let mut read = |node: Option<&Arc<Node>>| node.map(|node| self.medium(node)).transpose();
        let boundary = [read(nodes[0])?, read(nodes[1])?];
        let known = self.boundaries.iter().position(|other| *other == boundary);
        let index = known.unwrap_or(self.boundaries.len());
        if known.is_none() {
            self.boundaries.push(boundary);
        }
        u16::try_from(index)
            .ok()
            .filter(|index| *index != NO_BOUNDARY)
            .ok_or_else(|| SceneError::new(place, "the scene has more than 65535 pairs of media", "share some of them"))
    }
}
