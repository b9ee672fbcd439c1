//! KHR_materials_pbrSpecularGlossiness, the older material model, as metalness and roughness.

use super::entry::Entry;
use super::material::Base;
use super::texture::{Meaning, Slot, Textures};
use crate::scene::description::Value;
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// What a dielectric of index 1.5 reflects head-on.
const DIELECTRIC: f64 = 0.04;

/// The base of a material from its diffuse color, specular color and glossiness.
///
/// # Errors
/// On factors out of range and textures that refer to nothing.
pub(super) fn read<'a>(extension: &Entry<'a>, textures: &mut Textures<'_, 'a>) -> Result<Base, SceneError> {
    let [red, green, blue, alpha] = extension.numbers("diffuseFactor")?.unwrap_or([1.0; 4]);
    let specular = extension.color("specularFactor", [1.0; 3])?;
    let glossiness = extension.number_within("glossinessFactor", 1.0, 0.0, 1.0)?;
    let (color, metallic) = solve([red, green, blue], specular);
    let notices = &mut textures.output.notices;
    let explanation = "the metalness and color that reflect about as much take its place";
    notices.add(Notice::approximated(&extension.location(), "a specular color with glossiness", explanation));
    if extension.has("specularGlossinessTexture") {
        let explanation = "its factors are used alone";
        notices.add(Notice::ignored(&extension.location(), "a texture of specular color and glossiness", explanation));
    }
    Ok(Base {
        color,
        alpha,
        color_texture: textures.read(extension, "diffuseTexture", Meaning::Color)?,
        alpha_texture: textures.read(extension, "diffuseTexture", Meaning::Channel("a"))?,
        metallic: Slot::Value(Value::Float(metallic)),
        roughness: Slot::Value(Value::Float(1.0 - glossiness)),
    })
}

/// Base color b and metalness m with m·b + 0.04·(1 - m) = specular and 0.96·(1 - m)·b = diffuse·(1 - max specular):
/// solved for m on the luminances, then for b on every channel.
fn solve(diffuse: [f64; 3], specular: [f64; 3]) -> ([f64; 3], f64) {
    let luminance = |[r, g, b]: [f64; 3]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let left = 1.0 - specular.into_iter().fold(0.0, f64::max).min(1.0);
    let body = diffuse.map(|channel| channel * left / (1.0 - DIELECTRIC));
    let shine = luminance(specular);
    // 0.04·m² + (body + shine - 0.08)·m + (0.04 - shine) = 0
    let linear = luminance(body) + shine - 2.0 * DIELECTRIC;
    let discriminant = linear * linear - 4.0 * DIELECTRIC * (DIELECTRIC - shine);
    let metallic = if shine <= DIELECTRIC {
        0.0
    } else {
        ((discriminant.max(0.0).sqrt() - linear) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
    };
    let color = std::array::from_fn(|channel| {
        let from_diffuse = body[channel] / (1.0 - metallic).max(1e-6);
        let from_specular = (specular[channel] - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-6);
        let mixed = from_diffuse + (from_specular - from_diffuse) * metallic * metallic;
        mixed.clamp(0.0, 1.0)
    });
    (color, metallic)
}
