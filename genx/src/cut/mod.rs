//! Planes put in order: faces that lie in one plane, face the same way and overlap are cut, and of two in one place one stays;
//! and faces are cut along the lines on which others touch or cross them.
//!
//! # Why
//! What is seen first where two surfaces lie in one plane is decided by rounding and the order of the file: a lamp in the
//! plane of its ceiling shines through a part of itself, and light is made or lost. (Baum, Mann, Smith, Winget, "Making
//! radiosity usable", SIGGRAPH 1991, section 3, on coplanar faces.) A patch that lies on both sides of a wall that stands on its
//! floor has one radiosity for both rooms, so that light leaks below the wall; with an edge along the contact, shadows begin
//! there.
//!
//! # Which one stays
//! The one that a user means: an opening before all else, a lamp before what does not emit, else the one whose coplanar, connected faces have the
//! smaller area (a rug before its floor), else the one whose corners come first by their coordinates. The order in the
//! file decides nothing.
//!
//! # Practice
//! Faces are in one plane if the corners of the smaller are off the plane of the larger by [`PLANE_STEPS`] steps of an f32 at
//! the farthest coordinate at most, and overlap if they do so by twice that in every direction. All edges of faces that overlap,
//! directly or by way of others, make one arrangement in the coordinate plane that they face most, snapped to a grid
//! (`snap.rs`); its triangles, by a constrained Delaunay triangulation with exact predicates, are new surfaces. Corners of faces
//! keep their coordinates, and all other faces stay bit for bit.
//!
//! Faces of the two sides of a plane, those of a sheet or the foot of a column and its floor, are cut alike and all stay: their
//! corners are the same, so that neither is before the other, and from either side one sees the front that looks there.

mod arrangement;
mod contacts;
mod groups;
mod slivers;
mod snap;

use std::collections::BTreeMap;

use contacts::MOST_CONTACTS;
use glam::DVec3;
use groups::MOST_PAIRS;
use scene::{Material, MaterialId, Surface};
use snap::MOST_CROSSINGS;

pub use slivers::Uncut;

/// How far off a plane what lies in it may be, in steps of an f32 at the farthest coordinate of the model.
pub const PLANE_STEPS: f64 = 8.0;

/// The side of a pixel of the grid on which edges meet, in the same steps: corners that are nearer are one.
const PIXEL_STEPS: f64 = 2.0;

/// The most triangles that all faces are cut into.
const MOST_TRIANGLES: usize = 1 << 22;

/// What is done where faces overlap in one plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cut {
    /// They are cut, and one stays in each place.
    #[default]
    On,
    /// Nothing, and nothing is said.
    Off,
    /// It is said what would be.
    Report,
}

/// More of a model overlaps, touches or crosses than can be put in order.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "more than {limit} {what}, some of them of object \"{}\" and object \"{}\": clean the model, or give --cut off", objects[0], objects[1]
)]
pub struct TooMuchToCut {
    what: &'static str,
    limit: usize,
    objects: [String; 2],
}

/// The parts of a model that are put in order.
pub struct Model<'a> {
    /// All surfaces.
    pub surfaces: &'a mut Vec<Surface>,
    /// The file's triangle of each.
    pub faces: &'a mut Vec<u32>,
    /// All materials.
    pub materials: &'a [Material],
    /// All objects' names.
    pub objects: &'a [String],
    /// The material of what will be taken out.
    pub opening: Option<MaterialId>,
}

/// A face in its place among those that overlap: the least one stays.
type Rank = ([bool; 2], i64, [scene::weld::Place; 3]);

/// Cuts overlapping faces of one plane, as `cut` says, and tells of them, a line for each pair of objects.
///
/// # Errors
/// More that overlaps, touches or crosses than can be put in order; then nothing is changed.
pub fn put_in_order(mut model: Model, cut: Cut) -> Result<Vec<String>, TooMuchToCut> {
    if cut == Cut::Off {
        return Ok(Vec::new());
    }
    let too_much = |what, limit, faces: [u32; 2]| TooMuchToCut {
        what,
        limit,
        objects: faces.map(|k| {
            let object = model.surfaces[k as usize].object;
            model.objects[object.index()].clone()
        }),
    };
    let step = step_of(model.surfaces);
    let tolerance = PLANE_STEPS * step;
    let pairs = groups::near_pairs(model.surfaces, tolerance)
        .map_err(|faces| too_much("pairs of faces are near each other", MOST_PAIRS, faces))?;
    let contacts = contacts::contacts(model.surfaces, &pairs, tolerance)
        .map_err(|faces| too_much("faces touch or cross others", MOST_CONTACTS, faces))?;
    let has_contacts = |k: usize| !contacts[k].is_empty();
    let groups = groups::groups(model.surfaces, &pairs, tolerance, has_contacts);
    drop(pairs);
    if groups.is_empty() {
        return Ok(Vec::new());
    }
    let areas = groups::connected_areas(model.surfaces, tolerance);
    let rank = |k: usize| -> Rank {
        let surface = &model.surfaces[k];
        let is_dark = !model.materials[surface.material.index()].is_emitter();
        let is_filled = Some(surface.material) != model.opening;
        ([is_filled, is_dark], areas[k].0, areas[k].1)
    };
    // What takes whose place, by objects, m^2.
    let mut taken: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    let mut is_cut = vec![false; model.surfaces.len()];
    let mut added: Vec<(usize, Surface)> = Vec::new();
    let mut left = 0;
    for group in &groups {
        let contacts = group.iter().flat_map(|&k| &contacts[k]);
        let lines: Vec<[DVec3; 2]> = contacts.clone().map(|contact| contact.ends).collect();
        let pixel = PIXEL_STEPS * step;
        let mut others = contacts.map(|contact| contact.by);
        let other = others.next().unwrap_or(group[group.len() - 1] as u32);
        let faces = [group[0] as u32, other];
        let pieces = arrangement::cut(model.surfaces, group, &lines, pixel, rank)
            .map_err(|_| too_much("edges cross in one plane", MOST_CROSSINGS, faces))?;
        let Some(pieces) = pieces else {
            left += group.len();
            continue;
        };
        if added.len() + pieces.len() > MOST_TRIANGLES {
            let what = "triangles come of faces that others touch or cross";
            return Err(too_much(what, MOST_TRIANGLES, faces));
        }
        for piece in pieces {
            let winner = piece.members[0];
            for &loser in &piece.members[1..] {
                let objects = [winner, loser].map(|k| model.surfaces[k].object.0);
                *taken.entry(objects).or_default() += piece.area;
            }
            let surface = Surface {
                corners: piece.corners,
                ..model.surfaces[winner]
            };
            if !surface.is_degenerate() {
                added.push((winner, surface));
            }
        }
        for &k in group {
            is_cut[k] = true;
        }
    }
    let verb = if cut == Cut::On {
        "is cut"
    } else {
        "would be cut"
    };
    let told = taken.iter().map(|([winner, loser], area)| {
        let [winner, loser] = [winner, loser].map(|&object| &model.objects[object as usize]);
        format!("\"{winner}\" lies in the plane of \"{loser}\", which {verb} there: {area:.4e} m^2")
    });
    let mut told: Vec<String> = told.collect();
    let touched = (0..contacts.len()).filter(|&k| has_contacts(k) && is_cut[k]);
    if let Some(first) = touched.clone().next() {
        let name = |k: usize| &model.objects[model.surfaces[k].object.index()];
        told.push(format!(
            "{} faces {} along lines on which others touch or cross them (the first: \"{}\" by \"{}\")",
            touched.count(),
            if cut == Cut::On { "are cut" } else { "would be cut" },
            name(first),
            name(contacts[first][0].by as usize),
        ));
    }
    if left > 0 {
        told.push(format!(
            "{left} faces that overlap or touch others cannot be cut, and stay as they are"
        ));
    }
    if cut == Cut::On {
        replace(&mut model, &is_cut, added);
    }
    Ok(told)
}

/// Leaves out the surfaces that are cut, and puts what is made of each in its place.
fn replace(model: &mut Model, is_cut: &[bool], mut added: Vec<(usize, Surface)>) {
    added.sort_by_key(|(from, surface)| (*from, scene::weld::places(surface.corners)));
    let mut added = added.into_iter().peekable();
    let (mut surfaces, mut faces) = (Vec::new(), Vec::new());
    for (k, (surface, face)) in model.surfaces.iter().zip(model.faces.iter()).enumerate() {
        if !is_cut[k] {
            surfaces.push(*surface);
            faces.push(*face);
        }
        while let Some((_, surface)) = added.next_if(|(from, _)| *from == k) {
            surfaces.push(surface);
            faces.push(*face);
        }
    }
    *model.surfaces = surfaces;
    *model.faces = faces;
}

/// The step between neighbouring f32 at the farthest coordinate, metres.
fn step_of(surfaces: &[Surface]) -> f64 {
    let corners = surfaces.iter().flat_map(|surface| surface.corners);
    let reach = corners.fold(0.0_f32, |reach, p| reach.max(p.abs().max_element()));
    f64::from(reach.next_up()) - f64::from(reach)
}
