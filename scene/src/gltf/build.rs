//! From a document to the triangles of a model.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};

use super::GltfFault;
use super::content::{Content, Instance, Part, content, left_out};
use super::document::Document;
use super::error::wrong;
use super::lights;
use super::materials::{Materials, TERMS};
use super::names::Names;
use super::nodes;
use crate::import::origin::{Bounds, Overflow, centred};
use crate::import::{Draft, ImportOptions, ImportReport, ImportedModel, Looks, Piece};
use crate::{Axis, MaterialId, ModelAxes, ObjectId, Surface};

/// The share of its power that a light may lose or gain by the rounding of its body's corners.
const MOST_ROUNDING: f64 = 0.01;

/// What stands in for lights, as an object.
struct Body {
    object: ObjectId,
    material: MaterialId,
    /// Counter-clockwise from outside, metres.
    triangles: Vec<[DVec3; 3]>,
}

/// Builds the model.
pub(super) fn build(
    document: &Document,
    options: &ImportOptions,
) -> Result<ImportedModel, GltfFault> {
    let mut report = ImportReport::default();
    let hierarchy = nodes::hierarchy(&document.root, &mut report.warnings)?;
    let mut materials = Materials::new(document, options);
    let mut names = Names::default();
    let content = content(
        document,
        &hierarchy,
        &mut materials,
        &mut names,
        &mut report,
    )?;
    let mut objects = content.objects.clone();
    let lights = lights::bodies(document, &hierarchy.placed, options, &mut report.warnings)?;
    let bodies = lights.into_iter().map(|light| {
        objects.push(names.name(&light.name));
        Body {
            object: ObjectId(objects.len() as u32 - 1),
            material: MaterialId(materials.add(light.material) as u32),
            triangles: light.triangles,
        }
    });
    let bodies: Vec<Body> = bodies.collect();
    report.warnings.extend(left_out(document));
    report.warnings.extend(names.warning());

    let unit = options.axes.unit;
    let mut bounds = Bounds::NOTHING;
    content.for_each_corner(|corner| bounds = bounds.with(unit * corner))?;
    for &corner in bodies
        .iter()
        .flat_map(|body| body.triangles.iter().flatten())
    {
        bounds = bounds.with(corner);
    }
    let mut draft = Draft {
        pieces: Vec::new(),
        looks: Looks::new(materials.into_taken(), options, TERMS),
        objects,
        triangles: 0,
        absent: BTreeMap::new(),
        origin: bounds.origin(),
        axes: ModelAxes {
            up: options.axes.up.or(Some(Axis::Y)),
            ..options.axes
        },
        report,
    };
    let mut first_degenerate = None;
    for (object, instance) in content.instances.iter().enumerate() {
        for part in content.parts(instance)? {
            let degenerate = add_part(&mut draft, instance, part, ObjectId(object as u32))?;
            first_degenerate = first_degenerate.or(degenerate);
        }
    }
    draft.warn_of_absent();
    if draft.pieces.is_empty() {
        let triangles = draft.triangles;
        return Err(match first_degenerate {
            Some(_) => GltfFault::NothingLeft { triangles },
            None => GltfFault::AllTransparent { triangles },
        });
    }
    if let Some(first) = first_degenerate {
        draft.report.warnings.push(format!(
            "{} of {} triangles have no area and are dropped (the first is {})",
            draft.report.degenerate_dropped,
            draft.triangles,
            place_of(first, &content)
        ));
    }
    for body in &bodies {
        add_body(&mut draft, body)?;
    }
    let mut model = draft.finish(options, &|place| place_of(place, &content));
    model.files.extend(document.files.iter().cloned());
    Ok(model)
}

/// How warnings call a triangle of the file.
fn place_of(triangle: usize, content: &Content) -> String {
    let of_object = content.instances.iter().zip(&content.objects).rev();
    let mut of_object = of_object.skip_while(|(instance, _)| instance.start > triangle);
    match of_object.next() {
        Some((instance, name)) => {
            format!(
                "triangle {} of object \"{name}\"",
                triangle - instance.start + 1
            )
        }
        None => format!("triangle {}", triangle + 1),
    }
}

/// Adds the triangles of a primitive, and gives the first that has no area.
fn add_part(
    draft: &mut Draft,
    instance: &Instance,
    part: &Part,
    object: ObjectId,
) -> Result<Option<usize>, GltfFault> {
    let unit = draft.axes.unit;
    let mut first_degenerate = None;
    for triangle in 0..part.primitive.triangles {
        let place = draft.triangles;
        draft.triangles += 1;
        if draft.leaves_out(part.material) {
            continue;
        }
        let vertices = part.primitive.vertices(triangle)?;
        let found = instance.triangle(&part.primitive, vertices)?;
        let of_look = part.primitive.place_of_look(vertices)?;
        let mut corners = [Vec3::ZERO; 3];
        for (corner, &position) in corners.iter_mut().zip(&found.corners) {
            *corner = centred(unit * position, draft.origin)
                .map_err(|overflow| too_far(instance.placed.thing(), overflow))?;
        }
        if found.is_mirrored {
            corners.swap(1, 2);
        }
        let warnings = &mut draft.report.warnings;
        let surface = Surface {
            corners,
            material: draft.looks.id(part.material, &of_look, warnings),
            object,
        };
        if surface.is_degenerate() {
            draft.report.degenerate_dropped += 1;
            first_degenerate.get_or_insert(place);
        } else if part.is_double_sided {
            push_both_sides(&mut draft.pieces, surface, place);
        } else {
            draft.pieces.push(Piece {
                surface,
                face: place as u32,
                place,
                is_against: found.is_against,
            });
        }
    }
    Ok(first_degenerate)
}

/// Adds a triangle that has fronts on both sides.
fn push_both_sides(pieces: &mut Vec<Piece>, surface: Surface, place: usize) {
    let [a, b, c] = surface.corners;
    for corners in [[a, b, c], [a, c, b]] {
        pieces.push(Piece {
            surface: Surface { corners, ..surface },
            face: place as u32,
            place,
            is_against: None,
        });
    }
}

/// Adds what stands in for a light.
fn add_body(draft: &mut Draft, body: &Body) -> Result<(), GltfFault> {
    let thing = match draft.objects.get(body.object.index()) {
        Some(name) => format!("light \"{name}\""),
        None => "a light".to_owned(),
    };
    let [mut area, mut rounded_area] = [0.0; 2];
    for corners in &body.triangles {
        let place = draft.triangles;
        draft.triangles += 1;
        let mut rounded = [Vec3::ZERO; 3];
        for (rounded, &corner) in rounded.iter_mut().zip(corners) {
            let found = centred(corner, draft.origin);
            *rounded = found.map_err(|overflow| too_far(thing.clone(), overflow))?;
        }
        let surface = Surface {
            corners: rounded,
            material: body.material,
            object: body.object,
        };
        let [a, b, c] = corners;
        area += 0.5 * (b - a).cross(c - a).length();
        rounded_area += surface.area();
        if !surface.is_degenerate() {
            draft.pieces.push(Piece {
                surface,
                face: place as u32,
                place,
                is_against: None,
            });
        }
    }
    if (rounded_area - area).abs() > MOST_ROUNDING * area {
        return Err(wrong(
            thing,
            "what stands in for it is so small beside the model that rounding changes its power; give a larger --light-radius",
        ));
    }
    Ok(())
}

fn too_far(thing: String, overflow: Overflow) -> GltfFault {
    let Overflow { value, from_centre } = overflow;
    GltfFault::Overflow {
        thing,
        value,
        from_centre,
    }
}
