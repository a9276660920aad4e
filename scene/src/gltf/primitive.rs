//! Primitives: lists, strips and fans of triangles.

use glam::{DVec2, DVec3};
use gltf::json::mesh::{self, Mode, Semantic};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::document::Document;
use super::elements::Elements;
use super::error::wrong;
use super::layouts::{COLOURS, INDICES, Layout, NORMALS, POSITIONS, TEXTURE_COORDINATES};
use super::materials::Used;
use super::morphs::{Morphs, displacement};
use super::pictures::Mapping;
use super::skins::Influences;
use crate::import::Coordinates;
use crate::{Rgb, import};

/// The triangles of a primitive, in the coordinates of its node.
pub(super) struct Primitive<'a> {
    mode: Mode,
    positions: Elements<'a>,
    /// `None` where nothing asks for them.
    normals: Option<Elements<'a>>,
    /// For the textures of reflectance and emission.
    coordinates: [Option<(Mapping, Elements<'a>)>; 2],
    colours: Option<Elements<'a>>,
    morphs: Morphs<'a>,
    /// `None` where the file has no skins.
    pub influences: Option<Influences<'a>>,
    indices: Option<Elements<'a>>,
    /// How many.
    pub triangles: usize,
}

/// What is not a triangle.
pub(super) fn draws_points_or_lines(primitive: &mesh::Primitive) -> bool {
    !matches!(
        primitive.mode,
        Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
    )
}

/// What does not say where it is.
pub(super) fn has_no_positions(primitive: &mesh::Primitive) -> bool {
    let positions = Checked::Valid(Semantic::Positions);
    !primitive.attributes.contains_key(&positions)
}

impl<'a> Primitive<'a> {
    /// Opens what is needed of a primitive that draws triangles.
    pub(super) fn open(
        document: &'a Document,
        primitive: &mesh::Primitive,
        thing: &str,
        used: Used,
    ) -> Result<Self, GltfFault> {
        let attribute = |semantic, layout: &Layout| {
            let index = primitive.attributes.get(&Checked::Valid(semantic));
            index
                .map(|&index| Elements::open(document, index, layout))
                .transpose()
        };
        let positions = attribute(Semantic::Positions, &POSITIONS)?
            .ok_or_else(|| wrong(thing, "it has no POSITION"))?;
        let vertices = positions.count;
        let of_vertices = |semantic, layout: &Layout| {
            let elements = attribute(semantic, layout)?;
            elements.iter().try_for_each(|e| e.check_count(vertices))?;
            Ok::<_, GltfFault>(elements)
        };
        // What is double-sided has fronts on both sides, whatever normals say.
        let normals = if used.is_double_sided {
            None
        } else {
            of_vertices(Semantic::Normals, &NORMALS)?
        };
        let [of_reflectance, of_emission] = used.mappings.map(|mapping| {
            let Some(mapping) = mapping else {
                return Ok(None);
            };
            let found = of_vertices(Semantic::TexCoords(mapping.set), &TEXTURE_COORDINATES)?;
            Ok::<_, GltfFault>(found.map(|elements| (mapping, elements)))
        });
        let colours = if used.is_tinted {
            of_vertices(Semantic::Colors(0), &COLOURS)?
        } else {
            None
        };
        let influences = match document.root.skins[..] {
            [] => None,
            _ => Influences::open(document, primitive, thing, vertices)?,
        };
        let indices = primitive.indices;
        let indices = indices
            .map(|index| Elements::open(document, index, &INDICES))
            .transpose()?;
        let corners = indices.as_ref().map_or(vertices, |indices| indices.count);
        let Checked::Valid(mode) = primitive.mode else {
            return Err(wrong(thing, "its mode is none of glTF 2.0"));
        };
        let triangles = match mode {
            Mode::TriangleStrip | Mode::TriangleFan => corners.saturating_sub(2),
            _ if corners % 3 != 0 => {
                return Err(wrong(
                    thing,
                    format!("{corners} corners make no whole number of triangles"),
                ));
            }
            _ => corners / 3,
        };
        Ok(Self {
            mode,
            morphs: Morphs::open(document, primitive, vertices)?,
            positions,
            normals,
            coordinates: [of_reflectance?, of_emission?],
            colours,
            influences,
            indices,
            triangles,
        })
    }

    /// The vertices of a triangle, counter-clockwise from its front.
    pub(super) fn vertices(&self, triangle: usize) -> Result<[usize; 3], GltfFault> {
        let k = triangle;
        let corners = match self.mode {
            // Every other triangle of a strip is wound the other way.
            Mode::TriangleStrip if k % 2 == 1 => [k, k + 2, k + 1],
            Mode::TriangleStrip => [k, k + 1, k + 2],
            Mode::TriangleFan => [k + 1, k + 2, 0],
            _ => [3 * k, 3 * k + 1, 3 * k + 2],
        };
        let Some(indices) = &self.indices else {
            return Ok(corners);
        };
        let vertex = |k: usize| indices.index(corners[k], self.positions.count);
        Ok([vertex(0)?, vertex(1)?, vertex(2)?])
    }

    /// Where the corners of a triangle are, moved by morph targets of these weights.
    pub(super) fn positions(
        &self,
        vertices: [usize; 3],
        weights: &[f64],
    ) -> Result<[DVec3; 3], GltfFault> {
        let position = |k: usize| {
            let position = DVec3::from_array(self.positions.get(vertices[k])?);
            Ok(position + displacement(&self.morphs.positions, weights, vertices[k])?)
        };
        Ok([position(0)?, position(1)?, position(2)?])
    }

    /// Whether the normals of a triangle's corners are on its back; `None` where they do not say.
    pub(super) fn is_against(
        &self,
        vertices: [usize; 3],
        [a, b, c]: [DVec3; 3],
        weights: &[f64],
    ) -> Result<Option<bool>, GltfFault> {
        let Some(normals) = &self.normals else {
            return Ok(None);
        };
        let mut sum = DVec3::ZERO;
        for vertex in vertices {
            sum += DVec3::from_array(normals.get(vertex)?);
            sum += displacement(&self.morphs.normals, weights, vertex)?;
        }
        let agreement = (b - a).cross(c - a).dot(sum);
        Ok((agreement != 0.0).then_some(agreement < 0.0))
    }

    /// What a triangle says of its look.
    pub(super) fn place_of_look(&self, vertices: [usize; 3]) -> Result<import::Place, GltfFault> {
        let [of_reflectance, of_emission] = &self.coordinates;
        Ok(import::Place {
            of_reflectance: coordinates(of_reflectance.as_ref(), vertices)?,
            of_emission: coordinates(of_emission.as_ref(), vertices)?,
            tint: self.tint(vertices)?,
        })
    }

    /// The mean of the vertex colours of a triangle's corners, which are linear, clamped to [0, 1] (section 3.7.2.1).
    fn tint(&self, vertices: [usize; 3]) -> Result<Rgb, GltfFault> {
        let Some(colours) = &self.colours else {
            return Ok(Rgb::ONE);
        };
        let mut sum = DVec3::ZERO;
        for vertex in vertices {
            sum += DVec3::from_array(colours.get(vertex)?).clamp(DVec3::ZERO, DVec3::ONE);
        }
        Ok((sum / 3.0).as_vec3())
    }
}

/// Where the corners of a triangle are in a texture, (0, 0) at the lower left.
fn coordinates(
    found: Option<&(Mapping, Elements)>,
    vertices: [usize; 3],
) -> Result<Coordinates, GltfFault> {
    let Some((mapping, elements)) = found else {
        return Ok([None; 3]);
    };
    let mut corners = [None; 3];
    for (corner, vertex) in corners.iter_mut().zip(vertices) {
        let DVec2 { x, y } = mapping.apply(elements.get(vertex)?.into());
        *corner = Some(DVec2::new(x, 1.0 - y));
    }
    Ok(corners)
}
