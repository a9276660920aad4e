//! Which extensions are known.

use gltf::json::Root;

use super::GltfFault;

/// Extensions that a model may require: they are taken, or told as left out.
const KNOWN: [&str; 4] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions of materials: what they say is told as left out.
const OF_MATERIALS: [&str; 2] = ["KHR_materials_", "EXT_materials_"];

/// Whether all extensions that a model requires are known.
pub(super) fn check_required(required: &[String]) -> Result<(), GltfFault> {
    let unknown = required.iter().find(|name| {
        let is_of_material = OF_MATERIALS.iter().any(|prefix| name.starts_with(prefix));
        !(is_of_material || KNOWN.contains(&&name[..]))
    });
    match unknown {
        Some(extension) => Err(GltfFault::Extension {
            extension: extension.clone(),
            remedy: remedy(extension),
        }),
        None => Ok(()),
    }
}

/// What to do about an extension.
fn remedy(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export the model without compression"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export its textures as PNG or JPEG"
        }
        _ => "export the model without it",
    }
}

/// Extensions that the model uses and that nothing here tells of in detail.
pub(super) fn unknown(root: &Root) -> Vec<&str> {
    let used = root.extensions_used.iter().map(String::as_str);
    used.filter(|name| !KNOWN.contains(name))
        .filter(|name| !OF_MATERIALS.iter().any(|prefix| name.starts_with(prefix)))
        .collect()
}
