//! KHR_materials_transmission: through a solid with KHR_materials_volume, else through a thin wall, which light passes
//! straight on.

use super::super::draft::Draft;
use super::entry::Entry;
use super::material::{Base, Sided, index_of_refraction};
use super::texture::{Meaning, Slot, Textures};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// How much light a surface lets through, and into what.
pub(super) enum Transmission {
    None,
    /// Into a solid, in which it is refracted.
    Solid(Slot),
    /// Through a thin wall.
    Thin(Slot),
}

/// The least share of light that is left after the attenuation distance: the format allows none, which no number of absorption gives.
const LEAST_SHARE: f64 = 1e-6;

/// The volume of a material that is one: without thickness it is a thin wall.
fn volume<'a>(material: &Entry<'a>) -> Result<Option<Entry<'a>>, SceneError> {
    let Some(volume) = material.extension("KHR_materials_volume")? else { return Ok(None) };
    let thickness = volume.number_within("thicknessFactor", 0.0, 0.0, f64::INFINITY)?;
    Ok((thickness > 0.0).then_some(volume))
}

/// The medium inside of a solid that light gets into: after the attenuation distance d, m, the attenuation color c is left, so that
/// it absorbs -ln c / d.
///
/// # Errors
/// On numbers that no volume can have.
pub(super) fn interior(material: &Entry<'_>) -> Result<Option<Draft>, SceneError> {
    let Some(transmission) = material.extension("KHR_materials_transmission")? else { return Ok(None) };
    let lets_through = transmission.number_within("transmissionFactor", 0.0, 0.0, 1.0)? > 0.0;
    let Some(volume) = volume(material)?.filter(|volume| lets_through && volume.has("attenuationDistance")) else {
        return Ok(None);
    };
    let distance = volume.number_within("attenuationDistance", f64::INFINITY, 0.0, f64::INFINITY)?;
    if distance == 0.0 {
        let place = volume.get("attenuationDistance").unwrap_or_else(|| volume.clone());
        return Err(place.error("\"attenuationDistance\" is 0", "give a length above 0, or leave it out"));
    }
    let color = volume.color("attenuationColor", [1.0; 3])?;
    if color == [1.0; 3] {
        return Ok(None);
    }
    if color.iter().any(|share| *share > 1.0) {
        return Err(volume.error("a channel of \"attenuationColor\" is above 1", "give numbers from 0 to 1"));
    }
    let absorption = color.map(|share| libm::log(share.max(LEAST_SHARE).recip()) / distance);
    let medium = Draft::new(PluginClass::Medium, "homogeneous", &volume.location());
    Ok(Some(medium.with_rgb("sigma_t", absorption).with_rgb("albedo", [0.0; 3])))
}

impl Transmission {
    /// Reads both extensions of a material.
    ///
    /// # Errors
    /// On factors out of range and textures that refer to nothing.
    pub(super) fn read<'a>(
        material: &Entry<'a>,
        base: &Base,
        textures: &mut Textures<'_, 'a>,
    ) -> Result<Self, SceneError> {
        let Some(extension) = material.extension("KHR_materials_transmission")? else { return Ok(Self::None) };
        let factor = extension.number_within("transmissionFactor", 0.0, 0.0, 1.0)?;
        if factor == 0.0 {
            return Ok(Self::None);
        }
        let texture = textures.read(&extension, "transmissionTexture", Meaning::Channel("r"))?;
        if volume(material)?.is_none() {
            return Ok(Self::thin(material, factor, texture, base, textures));
        }
        Ok(Self::Solid(Slot::product(texture, Value::Float(factor))))
    }

    /// Through a thin wall; what is metal lets nothing through.
    fn thin(
        material: &Entry<'_>,
        factor: f64,
        texture: Option<Draft>,
        base: &Base,
        textures: &mut Textures<'_, '_>,
    ) -> Self {
        let clear = match &base.metallic {
            Slot::Value(Value::Float(metallic)) => 1.0 - metallic,
            _ => {
                let explanation = "it lets light through where it is metal, too";
                let subject = "a thin wall that is metal in parts";
                textures.output.notices.add(Notice::approximated(&material.location(), subject, explanation));
                1.0
            }
        };
        if clear == 0.0 { Self::None } else { Self::Thin(Slot::product(texture, Value::Float(factor * clear))) }
    }
}

/// A thin wall that lets `share` of the light through, in the base color, and scatters the rest as `opaque` does.
///
/// # Errors
/// On an index of refraction that is no number.
pub(super) fn thin_wall<'a>(
    material: &Entry<'a>,
    share: Slot,
    base: &Base,
    opaque: Sided,
    textures: &mut Textures<'_, 'a>,
) -> Result<Draft, SceneError> {
    let index = index_of_refraction(material, textures)?;
    if !matches!(base.roughness, Slot::Value(Value::Float(0.0))) {
        let explanation = "light passes it, and is reflected by it, as if it were smooth";
        let notice = Notice::approximated(&material.location(), "a rough thin wall", explanation);
        textures.output.notices.add(notice);
    }
    let pane = Draft::new(PluginClass::Bsdf, "thindielectric", &material.location());
    let pane = pane.with_float("int_ior", index).with_float("ext_ior", 1.0);
    let color = Slot::product(base.color_texture.clone(), Value::Rgb(base.color));
    let pane = color.put(pane, "specular_transmittance");
    if matches!(share, Slot::Value(Value::Float(1.0))) {
        return Ok(pane);
    }
    let blend = Draft::new(PluginClass::Bsdf, "blendbsdf", &material.location());
    let opaque = opaque.told(material, textures);
    Ok(share.put(blend, "weight").with_child("", opaque).with_child("", pane))
}
