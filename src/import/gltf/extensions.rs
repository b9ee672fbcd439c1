//! The extensions of glTF: which are read, and what happens with the others.

use super::super::compatibility::Row;
use super::super::compatibility::Support::{self, Approximated, PassedOver, Refused, Same};
use super::Output;
use super::entry::Entry;
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// The extensions that are known, by name; any other is passed over when a file uses it, and refused when it requires it.
pub(in super::super) const EXTENSIONS: &[Row] = &[
    Row::new(
        "EXT_mesh_gpu_instancing",
        Same,
        "instances of a shapegroup where copies would be more than 20 000 triangles",
    ),
    Row::new("EXT_meshopt_compression", Refused, "export without mesh compression"),
    Row::new("EXT_texture_avif", Refused, "export PNG or JPEG; beside an image of these it is passed over"),
    Row::new("EXT_texture_webp", Refused, "export PNG or JPEG; beside an image of these it is passed over"),
    Row::new("KHR_animation_pointer", PassedOver, "nodes stand where they rest"),
    Row::new(
        "KHR_draco_mesh_compression",
        Refused,
        "export without mesh compression; beside plain numbers it is passed over",
    ),
    Row::new(
        "KHR_lights_punctual",
        Approximated,
        "the edge of a spot falls linearly with the angle; `range` is ignored",
    ),
    Row::new("KHR_materials_anisotropy", PassedOver, ""),
    Row::new("KHR_materials_clearcoat", Approximated, "Mitsuba's coat, which reflects a quarter as much"),
    Row::new("KHR_materials_diffuse_transmission", PassedOver, ""),
    Row::new("KHR_materials_dispersion", PassedOver, ""),
    Row::new("KHR_materials_emissive_strength", Same, ""),
    Row::new("KHR_materials_ior", Same, "from 1 on"),
    Row::new("KHR_materials_iridescence", PassedOver, ""),
    Row::new("KHR_materials_pbrSpecularGlossiness", Approximated, "the metalness and color that reflect about as much"),
    Row::new("KHR_materials_sheen", PassedOver, ""),
    Row::new("KHR_materials_specular", Approximated, "an index of refraction that reflects as much head-on"),
    Row::new("KHR_materials_transmission", Approximated, "thin walls have no roughness; solids refract"),
    Row::new("KHR_materials_unlit", Same, "seen, and lights nothing; opaque"),
    Row::new("KHR_materials_variants", PassedOver, "the materials of the primitives themselves"),
    Row::new(
        "KHR_materials_volume",
        Same,
        "a share of 0 after the attenuation distance counts as 10⁻⁶; `thicknessTexture` is not needed",
    ),
    Row::new("KHR_mesh_quantization", Same, ""),
    Row::new("KHR_meshopt_compression", Refused, "export without mesh compression"),
    Row::new(
        "KHR_texture_basisu",
        Refused,
        "export PNG or JPEG; beside an image of these it is passed over; the one decoder that is Rust alone is at its first release",
    ),
    Row::new("KHR_texture_transform", Same, ""),
    Row::new("KHR_xmp_json_ld", PassedOver, ""),
    Row::new("MSFT_texture_dds", Refused, "export PNG or JPEG; beside an image of these it is passed over"),
    Row::new("NV_materials_mdl", Approximated, "`thick_glass` is a smooth dielectric; other shaders are ignored"),
];

fn support(name: &str) -> Option<Support> {
    EXTENSIONS.iter().find(|row| row.name == name).map(|row| row.support)
}

/// Refuses a file that requires an extension without which it would be another scene.
///
/// # Errors
/// At the entry of `extensionsRequired`.
pub(super) fn check_required(root: &Entry<'_>) -> Result<(), SceneError> {
    for (name, entry) in root.texts("extensionsRequired")? {
        if support(name).is_none_or(|support| support == Refused) {
            let remedy = match name {
                "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
                    "export the scene without mesh compression"
                }
                "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
                    "export the textures as PNG or JPEG"
                }
                _ => "export the scene without it",
            };
            let name: String = name.chars().take(80).collect();
            return Err(
                entry.error(format!("the scene requires the extension \"{name}\", which is not supported"), remedy)
            );
        }
    }
    Ok(())
}

/// Reports the extensions of an object that nothing reads.
pub(super) fn report_unread(owner: &Entry<'_>, output: &mut Output) -> Result<(), SceneError> {
    let Some(extensions) = owner.child("extensions")? else { return Ok(()) };
    // Whoever reads the others tells what is lost.
    let is_unread = |name: &str| match support(name) {
        Some(Same | Approximated) => false,
        Some(Refused) => name != "KHR_draco_mesh_compression",
        Some(PassedOver) | None => true,
    };
    for name in extensions.keys().filter(|name| is_unread(name)) {
        let name: String = name.chars().take(80).collect();
        output.notices.add(Notice::ignored(&owner.location(), format!("extension \"{name}\""), ""));
    }
    Ok(())
}
