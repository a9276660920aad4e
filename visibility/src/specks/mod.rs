//! Specks: triangles so small that few pixels of a hemicube's face have their centres near them, or none. The strategy
//! of hemicubes in scenes of 1,024 regions or more.
//!
//! # Theory
//! Where there are as many triangles as pixels, most triangles hold no pixel's centre, and setting one up for drawing,
//! edge by edge, costs more than all its pixels. Every vertex is projected into the face that it lies in. Three
//! look-ups and a few comparisons then show that a triangle lies between the centres, or which few it may hold. These
//! candidates are tested one by one, by the edge functions by which pieces are drawn ([`crate::spans`]): the picture is
//! the same but for pixels on edges.
//!
//! # Practice
//! A speck is a triangle that is a region by itself and lies in one face; all else is drawn as pieces. Regions are
//! looked at [cluster](clusters) by cluster: one below the horizon costs its box and no more, and a
//! [distant] one is left to the faces that see it. Vertices, corners of triangles and candidates
//! are dealt with several at a time.

mod candidates;
mod clusters;
mod distant;
mod hierarchical_depth;
#[cfg(test)]
mod tests;

use fearless_simd::{Simd, f32x4, f32x8, i32x4, prelude::*};
use fearless_simd_macros::simd;
use scene::SurfaceId;

pub(crate) use candidates::Target;
pub(crate) use clusters::Clusters;
pub(crate) use hierarchical_depth::HierarchicalDepth;

use crate::eye::Standpoint;
use crate::hemicube::{FACES, MAX_RESOLUTION};
use crate::spans::Projection;
use crate::vectors::Vectors;
use crate::{Frame, Window};
use candidates::{Candidates, GROWTH, MOST_PIXELS, held};
use clusters::{Cluster, Kind, LANES, REGIONS};
use distant::Distant;

/// Faces lie side by side at these distances, in pixels, so that what is in two of them is at least as wide as
/// [`MAX_RESOLUTION`]. After the last one is what lies below the horizon.
const FACE: i32 = 1 << 13;

/// The specks that an eye sees.
#[derive(Clone, Debug, Default)]
pub(crate) struct Specks {
    /// Of the vertices of one cluster in pixels from the lower left corner of the first face: x, y, -x, -y.
    places: Vec<[f32; 4]>,
    /// By the face that they are in: how many there are, and they, with room for more.
    of_faces: [(usize, Vec<Speck>); FACES],
    /// Clusters of which all that a face sees are specks, those near the eye first.
    distant: [Vec<Distant>; FACES],
    /// A bit for each region that is drawn.
    drawn: Vec<u64>,
}

/// A triangle, and the pixels whose centres it may hold: its region; its surface; the first column and row, in 16
/// bits each; the number of columns in 8 bits and which pixels of the rectangle they are, from [`held`], in the
/// others.
type Speck = [u32; 4];

impl Specks {
    /// Forgets all.
    pub fn clear(&mut self) {
        for (count, _) in &mut self.of_faces {
            *count = 0;
        }
        for clusters in &mut self.distant {
            clusters.clear();
        }
    }

    /// Starts with some vertices, axis after axis, metres, seen from a frame whose hemicube has this resolution.
    #[inline(always)]
    fn place<S: Simd>(&mut self, simd: S, from: [&[f32]; 3], frame: &Frame, resolution: u32) {
        let [from_x, from_y, from_z] = from;
        let half = 0.5 * resolution as f32;
        let zero = f32x8::splat(simd, 0.0);
        let below = f32x8::splat(simd, FACE as f32 * FACES as f32);
        self.places.resize(from_x.len(), [0.0; 4]);
        for first in (0..from_x.len()).step_by(LANES) {
            let part = first..first + LANES;
            let from = [
                &from_x[part.clone()],
                &from_y[part.clone()],
                &from_z[part.clone()],
            ];
            let [x, y, z] = to_local(simd, frame, from);
            let is_along_y = x.abs().simd_ge(y.abs());
            let across = is_along_y.select(x, y);
            let along = is_along_y.select(y, -x);
            let most = across.abs();
            let is_top = z.simd_ge(most);
            // The number of the side and the axis along its rows, see `hemicube::windows`.
            let is_first = across.simd_gt(zero);
            let side = is_along_y.select(zero + 1.0, zero + 2.0);
            let side = is_first.select(side, side + 2.0);
            let along = is_first.select(along, -along);
            let scale = (f32x8::splat(simd, half) / z.max(most)).min(f32::MAX);
            let right = is_top.select(x, along) * scale + half;
            let up = is_top.select(y * scale + half, z * scale);
            let right = right + is_top.select(zero, side) * FACE as f32;
            let is_above = z.simd_gt(zero);
            let (right, up) = (is_above.select(right, below), is_above.select(up, zero));
            let (left, down) = (-right, -up);
            let (even, odd) = (right.interleave(left), up.interleave(down));
            let (low, high) = (even.0.interleave(odd.0), even.1.interleave(odd.1));
            let places = self.places[part].chunks_exact_mut(2);
            for (places, four) in places.zip([low.0, low.1, high.0, high.1]) {
                four.store_slice(bytemuck::cast_slice_mut(places));
            }
        }
    }

    fn draw_as_piece(&mut self, region: u32) {
        self.drawn[region as usize / 64] |= 1 << (region % 64);
    }

    /// Tells region by region what is a speck, and of which face, and what is to be drawn.
    #[inline(always)]
    fn set_near<S: Simd>(
        &mut self,
        simd: S,
        clusters: &Clusters,
        cluster: &Cluster,
        at: &Standpoint,
        resolution: u32,
    ) {
        self.place(simd, clusters.vertices_of(cluster), &at.frame, resolution);
        for (count, specks) in &mut self.of_faces {
            let needed = *count + REGIONS;
            if specks.len() < needed {
                specks.resize(2 * needed, Speck::default());
            }
        }
        let most_pixels = match cluster.kind {
            Kind::Triangles => MOST_PIXELS,
            _ => 0,
        };
        let to_last = [GROWTH - 0.5, GROWTH - 0.5, GROWTH + 0.5, GROWTH + 0.5];
        let to_last = f32x4::from_slice(simd, &to_last);
        for place in cluster.places() {
            let region = clusters.regions[place];
            let corners = clusters.corners[place].map(usize::from);
            let a = f32x4::from_slice(simd, &self.places[corners[0]]);
            let b = f32x4::from_slice(simd, &self.places[corners[1]]);
            let c = f32x4::from_slice(simd, &self.places[corners[2]]);
            let d = f32x4::from_slice(simd, &self.places[corners[3]]);
            // The last pixel along each axis, and the opposite of the first.
            let bounds = (a.max(b).max(c.max(d)) + to_last).floor();
            let [right, up, left, down] = *bounds.to_int::<i32x4<S>>().as_array();
            let (columns, rows) = (right + left + 1, up + down + 1);
            let is_near_centre = columns > 0 && rows > 0;
            let is_in_faces = columns >= MAX_RESOLUTION as i32;
            if is_in_faces || is_near_centre && columns * rows > most_pixels {
                self.draw_as_piece(region);
                continue;
            }
            let face = right >> FACE.ilog2();
            if !is_near_centre || at.own == Some(region) || face as usize >= FACES {
                continue;
            }
            let mut x = [0.0; 3];
            let mut y = [0.0; 3];
            for k in 0..3 {
                x[k] = self.places[corners[k]][0] + (left as f32 - 0.5);
                y[k] = self.places[corners[k]][1] + (down as f32 - 0.5);
            }
            let pixels = held(simd, x, y, columns, rows);
            let (count, specks) = &mut self.of_faces[face as usize];
            let first = (-left - FACE * face) | (-down) << 16;
            let size = columns as u32 | pixels << 8;
            specks[*count] = [region, clusters.surfaces[place].0, first as u32, size];
            *count += usize::from(pixels != 0);
        }
    }
}

/// Eight points in a frame, of which there is one coordinate after the other, metres, as f32.
#[inline(always)]
fn to_local<S: Simd>(simd: S, frame: &Frame, [x, y, z]: [&[f32]; 3]) -> [f32x8<S>; 3] {
    let x = f32x8::from_slice(simd, x).widen();
    let y = f32x8::from_slice(simd, y).widen();
    let z = f32x8::from_slice(simd, z).widen();
    let low = Vectors {
        x: x.0,
        y: y.0,
        z: z.0,
    };
    let high = Vectors {
        x: x.1,
        y: y.1,
        z: z.1,
    };
    let (low, high) = (
        low.in_frame(frame).to_array(),
        high.in_frame(frame).to_array(),
    );
    [
        low[0].narrow(high[0]),
        low[1].narrow(high[1]),
        low[2].narrow(high[2]),
    ]
}

/// Tells for all regions but the eye's what are specks of a hemicube, and sets the others up as pieces.
#[simd]
pub(crate) fn set<S: Simd>(
    simd: S,
    at: &Standpoint,
    clusters: &Clusters,
    resolution: u32,
    specks: &mut Specks,
    projection: &mut Projection,
) {
    projection.clear();
    specks.clear();
    let frame = at.frame;
    specks.drawn.clear();
    specks.drawn.resize(clusters.regions.len().div_ceil(64), 0);
    for (first, bounds, group) in clusters.groups() {
        if bounds.is_below(&frame) {
            continue;
        }
        // Of all of them, so that they are drawn one after the other.
        let distance = bounds.middle.distance(frame.position);
        for (number, cluster) in (first..).zip(group) {
            if cluster.bounds.is_below(&frame) {
                continue;
            }
            let middle = frame.to_local(cluster.bounds.middle);
            if distant::is_distant(cluster, middle, resolution) {
                let from = Distant::new(distance, number);
                for (face, list) in specks.distant.iter_mut().enumerate() {
                    if distant::may_be_in(face, middle, cluster) {
                        list.push(from);
                    }
                }
            } else if cluster.kind == Kind::Others {
                for &region in clusters.regions_of(cluster) {
                    specks.draw_as_piece(region);
                }
            } else {
                specks.set_near(simd, clusters, cluster, at, resolution);
            }
        }
    }
    for list in &mut specks.distant {
        list.sort_unstable();
    }
    if let Some(own) = at.own {
        specks.drawn[own as usize / 64] &= !(1 << (own % 64));
    }
    for (word, &bits) in specks.drawn.iter().enumerate() {
        let mut left = bits;
        while left != 0 {
            let region = word as u32 * 64 + left.trailing_zeros();
            projection.add(at, region);
            left &= left - 1;
        }
    }
}

/// Draws the specks of a face over what is there: where one is nearer, or as near and before it in the scene, its depth
/// and number replace it.
#[simd]
pub(crate) fn draw<S: Simd>(
    simd: S,
    clusters: &Clusters,
    specks: &Specks,
    face: usize,
    window: &Window,
    target: &mut Target,
) {
    target.depth.start(window);
    let scene = target.at.geometry.scene;
    let mut candidates = Candidates::new(window);
    let (count, near) = &specks.of_faces[face];
    for &[region, surface, first, size] in &near[..*count] {
        let corners = scene.surface(SurfaceId(surface)).corners;
        let (left, bottom) = (first & 0xffff, first >> 16);
        let (columns, mut pixels) = (size & 0xff, size >> 8);
        while pixels != 0 {
            let pixel = pixels.trailing_zeros();
            pixels &= pixels - 1;
            let (i, j) = (left + pixel % columns, bottom + pixel / columns);
            // Half of an odd resolution is less than what the face is high.
            if j < window.height as u32 && candidates.add(region, [i, j], corners) {
                candidates.draw(simd, target);
            }
        }
    }
    distant::draw(
        simd,
        clusters,
        &specks.distant[face],
        &mut candidates,
        target,
    );
    candidates.draw(simd, target);
}
