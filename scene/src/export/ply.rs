//! A coloured triangle mesh in the Stanford PLY format, binary, little-endian.

use std::path::Path;

use super::{check_colors, original, patches};
use crate::Scene;
use crate::file::{FileError, write_atomically};

/// Writes one triangle a patch, in patch order, flat coloured.
///
/// `patch_colors` are display colours (sRGB), one per patch. Each patch has three vertices of its
/// own, since a PLY vertex has one colour. Positions are the model's own coordinates, metres, f64.
pub fn save(path: &Path, scene: &Scene, patch_colors: &[[u8; 3]]) -> Result<(), FileError> {
    check_colors(path, scene, patch_colors)?;
    let patch_count = scene.patch_count();
    write_atomically(path, |out| {
        write!(
            out,
            "ply\n\
             format binary_little_endian 1.0\n\
             element vertex {}\n\
             property double x\n\
             property double y\n\
             property double z\n\
             property uchar red\n\
             property uchar green\n\
             property uchar blue\n\
             element face {patch_count}\n\
             property list uchar int vertex_indices\n\
             end_header\n",
            3 * patch_count
        )?;
        for (patch, color) in patches(scene).zip(patch_colors) {
            for corner in patch.corners {
                for coordinate in original(scene, corner).to_array() {
                    out.write_all(&coordinate.to_le_bytes())?;
                }
                out.write_all(color)?;
            }
        }
        for patch in 0..patch_count {
            out.write_all(&[3])?;
            for corner in 0..3 {
                out.write_all(&(3 * patch + corner).to_le_bytes())?;
            }
        }
        Ok(())
    })
}
