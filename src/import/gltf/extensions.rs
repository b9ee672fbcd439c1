//! The extensions of glTF: which are read, and what happens with the others.

use super::Output;
use super::entry::Entry;
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// Extensions that are read, wholly or in part; what is left out of them gets its own notice.
const READ: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "NV_materials_mdl",
];

/// Extensions without which the scene is still itself, even if the file says that it requires them.
const DISPENSABLE: &[&str] = &[
    "KHR_animation_pointer",
    "KHR_materials_anisotropy",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_variants",
    "KHR_xmp_json_ld",
];

/// Refuses a file that requires an extension without which it would be another scene.
///
/// # Errors
/// At the entry of `extensionsRequired`.
pub(super) fn check_required(root: &Entry<'_>) -> Result<(), SceneError> {
    for (name, entry) in root.texts("extensionsRequired")? {
        if !READ.contains(&name) && !DISPENSABLE.contains(&name) {
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
    for name in extensions.keys().filter(|name| !READ.contains(name)) {
        let name: String = name.chars().take(80).collect();
        output.notices.add(Notice::ignored(&owner.location(), format!("extension \"{name}\""), ""));
    }
    Ok(())
}
