//! Triangles that face the wrong way, or are there twice.

use std::cmp::Reverse;
use std::collections::HashMap;

use glam::DVec3;

use super::draft::{Draft, Piece};
use super::{ImportReport, Orient};
use crate::weld::{self, Place, places};

/// Turns triangles whose front is not where the file's own normals are. A face whose other side is a face of the file too is
/// half of a sheet and stays.
pub(super) fn turn_to_normals(
    pieces: &mut [Piece],
    orient: Orient,
    place: &dyn Fn(usize) -> String,
    report: &mut ImportReport,
) {
    let mut areas = [0.0, 0.0];
    for piece in pieces.iter() {
        if let Some(is_against) = piece.is_against {
            areas[usize::from(is_against)] += piece.surface.area();
        }
    }
    let [agree, against] = areas;
    let wants_turning = match orient {
        Orient::Winding => false,
        Orient::Normals => against > 0.0,
        Orient::Auto => against > 0.0 && against < agree,
    };
    let percent = 100.0 * against / (agree + against);
    if !wants_turning {
        if against > 0.0 && orient == Orient::Auto {
            report.warnings.push(format!(
                "{percent:.0} percent of the area faces away from the file's own normals; faces stay as they are wound: \
                 --orient normals turns them"
            ));
        }
        return;
    }
    // The normals of all faces by their corners.
    let mut sides: HashMap<Vec<Place>, Vec<DVec3>> = HashMap::new();
    for face in pieces.chunk_by(|a, b| a.place == b.place) {
        sides
            .entry(corners_of(face))
            .or_default()
            .push(normal_of(face));
    }
    let mut first = None;
    for face in pieces.chunk_by_mut(|a, b| a.place == b.place) {
        if face[0].is_against != Some(true) {
            continue;
        }
        let normal = normal_of(face);
        let others = &sides[&corners_of(face)];
        if others.iter().any(|other| other.dot(normal) < 0.0) {
            continue;
        }
        for piece in face {
            let [a, b, c] = piece.surface.corners;
            piece.surface.corners = [a, c, b];
            report.turned += 1;
            first.get_or_insert(piece.place);
        }
    }
    if let Some(first) = first {
        report.warnings.push(format!(
            "{} triangles, {percent:.0} percent of the area, were wound against the file's own normals (the first in {}) \
             and are turned; --orient winding leaves them",
            report.turned,
            place(first)
        ));
    }
}

/// The places of a face's corners, in no order that its winding decides.
fn corners_of(face: &[Piece]) -> Vec<Place> {
    let mut corners: Vec<Place> = face
        .iter()
        .flat_map(|piece| piece.surface.corners.map(weld::place))
        .collect();
    corners.sort_unstable();
    corners.dedup();
    corners
}

/// Along the vector area of a face.
fn normal_of(face: &[Piece]) -> DVec3 {
    let normal = |piece: &Piece| piece.surface.area() * piece.surface.normal();
    face.iter().map(normal).sum()
}

/// Drops triangles where another one lies, facing the same way. Of those that differ in more, the brightest lamp stays, else
/// the first by the names of material and object: the order of the file decides nothing.
pub(super) fn drop_repeated(draft: &mut Draft, place: &dyn Fn(usize) -> String) {
    let Draft {
        pieces,
        looks,
        objects,
        triangles,
        report,
        ..
    } = draft;
    let rank = |index: usize| {
        let surface = &pieces[index].surface;
        let material = looks.get(surface.material);
        let emission = material.emission.element_sum().to_bits();
        let object = &objects[surface.object.index()];
        (Reverse(emission), &material.name, object, index)
    };
    let keys = pieces.iter().map(|piece| places(piece.surface.corners));
    let mut keyed: Vec<([Place; 3], usize)> = keys.zip(0..).collect();
    keyed.sort_unstable();
    let mut is_dropped = vec![false; pieces.len()];
    let mut differ = 0;
    for same in keyed
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same| same.len() > 1)
    {
        let mut indices: Vec<usize> = same.iter().map(|&(_, index)| index).collect();
        indices.sort_by_key(|&index| rank(index));
        let material = |index: usize| pieces[index].surface.material;
        differ += indices[1..]
            .iter()
            .filter(|&&k| material(k) != material(indices[0]))
            .count();
        for &index in &indices[1..] {
            is_dropped[index] = true;
        }
    }
    let Some(first) = is_dropped.iter().position(|&dropped| dropped) else {
        return;
    };
    report.repeated_dropped = is_dropped.iter().filter(|&&dropped| dropped).count();
    let others = if differ > 0 {
        format!(
            "; {differ} of them have another material, of which the brightest stays, else the first by name"
        )
    } else {
        String::new()
    };
    report.warnings.push(format!(
        "{} of {triangles} triangles lie where another one lies, facing the same way, and are left out (the first in {}, of object \
         \"{}\"){others}",
        report.repeated_dropped,
        place(pieces[first].place),
        objects[pieces[first].surface.object.index()],
    ));
    let mut dropped = is_dropped.into_iter();
    pieces.retain(|_| !dropped.next().unwrap_or(false));
}
