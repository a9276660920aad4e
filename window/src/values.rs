//! The numbers that a picture is made of, as the graphics card looks them up.

use display::distinct::distinct_color;
use display::range;
use display::{Mode, Range, SettingsError};
use scene::{PatchId, Rgb};

use crate::loaded::Loaded;
use crate::looks::Looks;

/// What is shown of a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// One per patch: in the unit of what is shown, or display light in [`Mode::Ids`].
    pub of_patches: Vec<Rgb>,
    /// Those between patches, if they are shown.
    pub function: Option<VertexValues>,
    /// The scale's ends that suit them.
    pub range: Range,
}

/// A function of which an affine image is shown, such as E + rho H.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexValues {
    /// What is linear between vertices, one per vertex, W/m^2.
    pub of_vertices: Vec<Rgb>,
    /// What is added to that and what it is multiplied by, one per material.
    pub of_materials: Vec<[Rgb; 2]>,
}

impl Values {
    /// The values that are asked for.
    ///
    /// # Errors
    /// Where the solution does not have them.
    pub fn new(loaded: &Loaded, looks: &Looks) -> Result<Self, SettingsError> {
        let Loaded {
            scene, solution, ..
        } = loaded;
        if looks.mode == Mode::Ids {
            let patches = (0..scene.patch_count()).map(PatchId);
            return Ok(Self {
                of_patches: patches.map(distinct_color).collect(),
                function: None,
                range: Range {
                    low: 0.0,
                    high: 1.0,
                },
            });
        }
        let of_patches = looks.shown.of_patches(scene, solution.as_ref())?;
        let function = if looks.is_flat {
            None
        } else {
            looks
                .shown
                .function(scene, solution.as_ref(), &of_patches)
                .map(|function| VertexValues {
                    of_vertices: function.values,
                    of_materials: function.of_material,
                })
        };
        let range = range::suiting(&range::of_patches(scene, &of_patches), looks.mode);
        Ok(Self {
            of_patches,
            function,
            range,
        })
    }

    /// Whether other looks need other values.
    pub fn differ(a: &Looks, b: &Looks) -> bool {
        a.shown != b.shown || a.is_flat != b.is_flat || a.mode != b.mode
    }
}
