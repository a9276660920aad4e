//! Things that are taken out of a model on purpose, so that light leaves where they were.
//!
//! They are marked by a material of their own before planes are put in order, so that what lies below a pane in its wall's
//! plane is cut away with it, and taken out after that. A hole goes both ways: what is no closed body gets fronts on both sides,
//! so that whoever looks through the hole looks at one front of it.

use std::collections::{HashMap, HashSet};

use scene::weld::{Place, place, places};
use scene::{Material, MaterialId, Opening, Rgb, Surface};

use crate::changes::{Parts, UnknownName};

/// Marks the surfaces of materials or objects of these names, and tells by which material.
pub fn mark(parts: &mut Parts, names: &[String]) -> Result<Option<MaterialId>, UnknownName> {
    if names.is_empty() {
        return Ok(None);
    }
    let found: Vec<Vec<usize>> = names
        .iter()
        .map(|name| parts.surfaces_of(name))
        .collect::<Result<_, _>>()?;
    let mark = MaterialId(parts.materials.len() as u32);
    parts.materials.push(Material {
        name: "opening".to_owned(),
        reflectance: Rgb::ZERO,
        emission: Rgb::ZERO,
    });
    for mut surfaces in found {
        // What another name has taken out already.
        surfaces.retain(|&k| parts.surfaces[k].material != mark);
        for &k in &surfaces {
            parts.surfaces[k].material = mark;
        }
        parts.back(&without_backs(parts.surfaces, &surfaces));
    }
    Ok(Some(mark))
}

/// Takes out what is marked, and the mark.
pub fn take_out(parts: &mut Parts, mark: Option<MaterialId>) -> Vec<Opening> {
    let Some(mark) = mark else {
        return Vec::new();
    };
    let is_marked: Vec<bool> = parts.surfaces.iter().map(|s| s.material == mark).collect();
    let marked = parts.surfaces.iter().filter(|s| s.material == mark);
    let openings = marked
        .map(
            |&Surface {
                 corners, object, ..
             }| Opening { corners, object },
        )
        .collect();
    let mut marks = is_marked.iter();
    parts.surfaces.retain(|_| marks.next() == Some(&false));
    if let Some(faces) = &mut parts.faces {
        let mut marks = is_marked.iter();
        faces.retain(|_| marks.next() == Some(&false));
    }
    parts.materials.truncate(mark.index());
    openings
}

/// Those of the surfaces that need backs: none of a closed body, else all that have none.
fn without_backs(all: &[Surface], surfaces: &[usize]) -> Vec<usize> {
    // How often each edge runs from its lesser end to its greater one, less how often back.
    let mut runs: HashMap<[Place; 2], i64> = HashMap::new();
    let mut there = HashSet::new();
    for &k in surfaces {
        let corners = all[k].corners;
        there.insert(places(corners));
        for side in 0..3 {
            let [from, to] = [corners[side], corners[(side + 1) % 3]].map(place);
            let run = if from < to { 1 } else { -1 };
            *runs.entry([from.min(to), from.max(to)]).or_default() += run;
        }
    }
    if runs.values().all(|&run| run == 0) {
        return Vec::new();
    }
    let has_back = |&&k: &&usize| {
        let [a, b, c] = all[k].corners;
        there.contains(&places([a, c, b]))
    };
    surfaces.iter().filter(|k| !has_back(k)).copied().collect()
}
