//! Primitives: lists, strips and fans of triangles.

use glam::{DVec2, DVec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{self, Mode, Semantic};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::document::Document;
use super::elements::Elements;
use super::error::wrong;
use super::materials::Mapping;

/// The triangles of a primitive, in the coordinates of its node.
pub(super) struct Primitive<'a> {
    mode: Mode,
    positions: Elements<'a>,
    normals: Option<Elements<'a>>,
    /// For the textures of reflectance and emission.
    coordinates: [Option<(Mapping, Elements<'a>)>; 2],
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

impl<'a> Primitive<'a> {
    /// Opens what is needed of a primitive that draws triangles.
    pub(super) fn open(
        document: &'a Document,
        primitive: &mesh::Primitive,
        thing: &str,
        mappings: [Option<Mapping>; 2],
    ) -> Result<Self, GltfFault> {
        let attribute = |semantic, kind| {
            let index = primitive.attributes.get(&Checked::Valid(semantic));
            index
                .map(|&index| Elements::open(document, index, kind))
                .transpose()
        };
        let positions = attribute(Semantic::Positions, Type::Vec3)?
            .ok_or_else(|| wrong(thing, "it has no POSITION"))?;
        let normals = attribute(Semantic::Normals, Type::Vec3)?;
        let [of_reflectance, of_emission] = mappings.map(|mapping| {
            let Some(mapping) = mapping else {
                return Ok(None);
            };
            let found = attribute(Semantic::TexCoords(mapping.set), Type::Vec2)?;
            Ok(found.map(|elements| (mapping, elements)))
        });
        let coordinates = [of_reflectance?, of_emission?];
        let of_vertices = coordinates.iter().flatten().map(|(_, elements)| elements);
        for elements in of_vertices.chain(&normals) {
            elements.check_count(positions.count)?;
        }
        let indices = primitive.indices;
        let indices = indices
            .map(|index| Elements::open(document, index, Type::Scalar))
            .transpose()?;
        let mut corners = positions.count;
        if let Some(indices) = &indices {
            indices.check_indices()?;
            corners = indices.count;
        }
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
            positions,
            normals,
            coordinates,
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

    pub(super) fn positions(&self, vertices: [usize; 3]) -> Result<[DVec3; 3], GltfFault> {
        let position = |k: usize| self.positions.get(vertices[k]).map(DVec3::from_array);
        Ok([position(0)?, position(1)?, position(2)?])
    }

    /// Whether the normals of a triangle's corners are on its back; `None` where they do not say.
    pub(super) fn is_against(
        &self,
        vertices: [usize; 3],
        [a, b, c]: [DVec3; 3],
    ) -> Result<Option<bool>, GltfFault> {
        let Some(normals) = &self.normals else {
            return Ok(None);
        };
        let mut sum = DVec3::ZERO;
        for vertex in vertices {
            sum += DVec3::from_array(normals.get(vertex)?);
        }
        let agreement = (b - a).cross(c - a).dot(sum);
        Ok((agreement != 0.0).then_some(agreement < 0.0))
    }

    /// Where the corners of a triangle are in its textures, (0, 0) at the lower left.
    pub(super) fn coordinates(
        &self,
        vertices: [usize; 3],
    ) -> Result<[[Option<DVec2>; 3]; 2], GltfFault> {
        let mut found = [[None; 3]; 2];
        for (found, coordinates) in found.iter_mut().zip(&self.coordinates) {
            let Some((mapping, elements)) = coordinates else {
                continue;
            };
            for (found, vertex) in found.iter_mut().zip(vertices) {
                let DVec2 { x, y } = mapping.apply(elements.get(vertex)?.into());
                *found = Some(DVec2::new(x, 1.0 - y));
            }
        }
        Ok(found)
    }
}
