//! What can be wrong with a scene, whatever it was made from.

use crate::MAX_PATCHES;

/// A scene that cannot be. File errors are [`crate::file::FileError`], import errors
/// [`crate::obj::ObjError`]; both can carry one of these.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum SceneError {
    #[error("the scene has no surfaces; give at least one triangle")]
    NoSurfaces,
    #[error("the scene's origin {origin} is not finite")]
    Origin { origin: glam::DVec3 },
    #[error("the unit of the model's coordinates, {value} m, is not a finite number above 0")]
    Unit { value: f64 },
    #[error(
        "material \"{material}\": {channel} reflectance {value} is outside [0, 1); clamp it, for example to 0.99"
    )]
    Reflectance {
        material: String,
        channel: &'static str,
        value: f32,
    },
    #[error(
        "material \"{material}\": {channel} emission {value} W/m^2 is not a finite number >= 0"
    )]
    Emission {
        material: String,
        channel: &'static str,
        value: f32,
    },
    #[error("surface {surface}: coordinate {value} is not finite")]
    Coordinate { surface: u32, value: f32 },
    #[error("surface {surface} is degenerate: its area {area:e} m^2 is zero to rounding; drop it")]
    Degenerate { surface: u32, area: f64 },
    #[error("surface {surface}: material {material} does not exist, the scene has {count}")]
    MaterialIndex {
        surface: u32,
        material: u32,
        count: usize,
    },
    #[error("surface {surface}: object {object} does not exist, the scene has {count}")]
    ObjectIndex {
        surface: u32,
        object: u32,
        count: usize,
    },
    #[error("{depths} depths of bisection trees for {surfaces} surfaces")]
    DepthCount { depths: usize, surfaces: usize },
    #[error("{faces} faces for {surfaces} surfaces")]
    FaceCount { faces: usize, surfaces: usize },
    #[error(
        "surface {surface}: {bisections} bisections, the limit is {}",
        crate::bisection::MAX_BISECTIONS
    )]
    Bisections { surface: u32, bisections: u32 },
    #[error(
        "{patches} patches, the limit is {MAX_PATCHES} (24-bit patch IDs); raise the area threshold"
    )]
    TooManyPatches { patches: u64 },
    #[error(
        "area threshold {value} m^2 must be a number above 0, or inf to keep each triangle as one patch"
    )]
    AreaThreshold { value: f64 },
    #[error("patch {patch} inside of a solid is none of {patches} patches in ascending order")]
    Inside { patch: u32, patches: u32 },
    #[error(
        "opening {opening} has a coordinate that is not finite, or an object that does not exist"
    )]
    Opening { opening: u32 },
    #[error("{what} {index} is wrong in the irradiance function's mesh")]
    VertexMesh { what: &'static str, index: u32 },
    #[error("the irradiance function has {values} values, its mesh has {vertices} vertices")]
    VertexValues { values: usize, vertices: u32 },
    #[error("vertex {vertex}: {value} W/m^2 is no irradiance (finite, >= 0)")]
    VertexValue { vertex: u32, value: f32 },
    #[error(
        "layer \"{layer}\": layers of lamps have what emits in them, and those of bounces do not"
    )]
    LayerLamp { layer: String },
    #[error("layer \"{layer}\" has not one value a patch and one a vertex")]
    LayerLength { layer: String },
    #[error("layer \"{layer}\": {value} W/m^2 is no irradiance (finite, >= 0)")]
    LayerValue { layer: String, value: f32 },
    #[error("each of the {count} layers needs a finite factor of at least 0")]
    LayerFactors { count: usize },
    #[error("patch {patch}: {value} W/m^2 is no error of a radiosity (finite, >= 0)")]
    PatchError { patch: u32, value: f32 },
    #[error("the solution has {errors} estimates of errors, the scene has {patches} patches")]
    ErrorLength { errors: usize, patches: u32 },
    #[error("the solution's sources have {value} m^2 at most; it must be a finite number above 0")]
    SourceArea { value: f64 },
    #[error("the solution has {values} irradiances, the scene has {patches} patches")]
    SolutionLength { values: usize, patches: u32 },
    #[error(
        "patch {patch}: {value} W/m^2 is no irradiance (finite, >= 0) or unshot radiosity (finite)"
    )]
    Irradiance { patch: u32, value: f32 },
}
