//! The entity `ies`.

use glam::{DMat4, DVec3};

use super::super::draft::Draft;
use super::Reader;
use super::text::Entity;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;

impl Reader<'_> {
    /// A luminaire: a point light with the intensities of an IES file. There a profile's downward direction is -z; here
    /// an `ies` emitter sends it along its +z.
    pub(super) fn luminaire(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        entity.check_count(1, usize::MAX, "ies file [-m factor] [transform]")?;
        let name = self.resolved(entity.word(0));
        let scaled = entity.word(1) == "-m";
        let factor = if scaled { entity.amount(2)? } else { 1.0 };
        self.push_transform(entity, if scaled { 3 } else { 1 }, 0)?;
        loop {
            self.count(entity)?;
            let upright = DMat4::from_scale(DVec3::new(1.0, -1.0, -1.0));
            let to_world = self.placed(entity)?.matrix() * upright;
            let light = Draft::new(PluginClass::Emitter, "ies", &entity.location());
            let light = light.with_text("filename", &name).with_transform("to_world", to_world);
            let light = if scaled { light.with_rgb("intensity", [factor; 3]) } else { light };
            self.stage.add(light, entity)?;
            if self.next_copy(entity)?.is_none() {
                return Ok(());
            }
        }
    }
}
