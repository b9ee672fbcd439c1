//! KHR_materials_unlit: a surface that shows its base color whatever the light, and lights nothing.

use super::super::draft::Draft;
use super::entry::Entry;
use super::lights::light_group;
use super::material::Base;
use super::texture::{Slot, Textures};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// Whether a material is unlit.
///
/// # Errors
/// When the extension is no object.
pub(super) fn is_unlit(material: &Entry<'_>) -> Result<bool, SceneError> {
    Ok(material.extension("KHR_materials_unlit")?.is_some())
}

/// The emitter that shows the base color, and the black surface below it.
///
/// # Errors
/// On factors out of range and textures that refer to nothing.
pub(super) fn read<'a>(material: &Entry<'a>, textures: &mut Textures<'_, 'a>) -> Result<(Draft, Draft), SceneError> {
    let Base { color, color_texture, alpha, .. } = Base::read(material, textures)?;
    let blends = material.text("alphaMode")?.is_some_and(|mode| mode != "OPAQUE");
    if blends && (alpha != 1.0 || color_texture.is_some()) {
        let explanation = "it is opaque";
        let notice = Notice::approximated(&material.location(), "the alpha of an unlit material", explanation);
        textures.output.notices.add(notice);
    }
    let emitter = Draft::new(PluginClass::Emitter, "area", &material.location()).with_flag("seen_only", true);
    let emitter = if material.flag("doubleSided")? { emitter.with_flag("two_sided", true) } else { emitter };
    let emitter = emitter.in_light_group(light_group(material)?);
    let emitter = Slot::product(color_texture, Value::Rgb(color)).put(emitter, "radiance");
    let black = Draft::new(PluginClass::Bsdf, "diffuse", &material.location()).with_rgb("reflectance", [0.0; 3]);
    Ok((black, emitter))
}
