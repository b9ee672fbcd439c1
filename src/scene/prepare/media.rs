//! Participating media of a description, and the shapes that separate them.

use std::sync::Arc;

use super::Builder;
use crate::scene::description::{Node, PluginClass};
use crate::scene::error::{Location, SceneError};
use crate::scene::fields::Fields;
use crate::scene::geometry::surface::NO_BOUNDARY;
use crate::scene::medium;

impl Builder<'_> {
    /// The index of a medium.
    pub(super) fn medium(&mut self, node: &Arc<Node>) -> Result<u16, SceneError> {
        let address = Arc::as_ptr(node);
        if let Some(known) = self.medium_of_node.get(&address) {
            return Ok(*known);
        }
        let index = u16::try_from(self.media.len()).map_err(|_| {
            SceneError::new(&node.location, "the scene has more than 65536 media", "share some of them")
        })?;
        self.media.push(medium::read(node)?);
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
