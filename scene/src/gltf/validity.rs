//! Whether a document is valid, by the crate's own checks, but for what is not used here.

use gltf::json::validation::{Error as Invalid, Validate};
use gltf::json::{Index, Path, Root};

use super::GltfFault;
use super::error::wrong;

/// Checks the whole document.
pub(super) fn check(root: &Root) -> Result<(), GltfFault> {
    // The crate looks up accessors before it checks their indices.
    let accessors = root.accessors.len();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let beyond = |index: &&_| Index::value(*index) >= accessors;
            if let Some(index) = primitive.attributes.values().find(beyond) {
                return Err(wrong(
                    format!("meshes[{m}].primitives[{p}]"),
                    format!("an attribute has accessor {index}, the file has {accessors}"),
                ));
            }
        }
    }
    let mut first = None;
    let mut report = |path: &dyn Fn() -> Path, error: Invalid| {
        if first.is_none() {
            let path = path().to_string();
            first = (!may_be(&path, error)).then_some((path, error));
        }
    };
    root.validate(root, Path::new, &mut report);
    match first {
        None => Ok(()),
        Some((thing, error)) => Err(wrong(
            thing,
            match error {
                Invalid::IndexOutOfBounds => "there is nothing of this index",
                Invalid::Missing => "it is missing",
                Invalid::Oversize => "it is larger than memory can be",
                Invalid::Invalid => "its value is none of those that glTF 2.0 has",
                Invalid::Unsupported => "it is not known",
            },
        )),
    }
}

/// Whether what the crate reports may be: it is allowed, or nothing here asks for it.
fn may_be(path: &str, error: Invalid) -> bool {
    let is_missing = matches!(error, Invalid::Missing);
    // Without a view and without replacements all elements are 0 (section 3.6.2.3).
    let is_zero = is_missing && path.starts_with("accessors[") && path.ends_with("].bufferView");
    // Such primitives are left out (section 3.7.2.1).
    let is_without_positions = is_missing && path.ends_with("[\"POSITION\"]");
    // Bounds are those of the positions themselves.
    let is_bound = matches!(path.rsplit('.').next(), Some("min" | "max"));
    // Attributes of names that the format does not have.
    let is_other = path.contains("<invalid semantic name>");
    is_zero || is_without_positions || is_bound || is_other
}
