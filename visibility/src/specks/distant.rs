//! Clusters of triangles so far away that all that a face sees of them are specks: drawn face by face, the nearest
//! first, but for those that are hidden.
//!
//! What is hidden by all that has been drawn before, block by block of pixels ([`super::hierarchical_depth`]), costs no
//! more than its cluster's box.

#[cfg(test)]
mod tests;

use std::f64::consts::SQRT_2;

use fearless_simd::{Simd, f32x8, i32x4, i32x8, prelude::*};
use glam::{DVec3, Vec3};

use super::candidates::{Candidates, GROWTH, MOST_PIXELS, Target, held};
use super::clusters::{Cluster, Clusters, Kind, LANES, REGIONS};
use super::hierarchical_depth::Rectangle;
use crate::rounding::BOX_MARGIN;
use crate::{Frame, Window};

/// The longest side of a distant cluster's triangles, in pixels in the middle of a face's sides; in its middle that
/// is half as many. Tuned on `benches/dense.rs`.
const LONGEST: f64 = 4.0;

/// The least distance of a distant cluster, in radii of its box. At this distance every face that sees a part of the
/// cluster has the whole cluster in front of it, so that no vertex needs clipping. (From [`may_be_in`], and since the
/// cluster is not below the horizon: if a part were behind the face, the distance would be below 3.7 radii.)
const FAR: f64 = 4.0;

/// The nearest inverse depth of a box is raised by this factor before it is compared, for rounding.
const CLEARLY_FARTHER: f64 = 1.0 + 1e-5;

/// A cluster, by how far away its group is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Distant {
    /// The bits of an f32 that is not negative: in the same order.
    distance: u32,
    cluster: u32,
}

impl Distant {
    /// `distance` is in metres.
    pub fn new(distance: f64, cluster: u32) -> Self {
        Self {
            distance: (distance as f32).to_bits(),
            cluster,
        }
    }

    /// The cluster itself.
    pub fn of(self, clusters: &Clusters) -> &Cluster {
        &clusters.all[self.cluster as usize]
    }
}

/// True where all triangles of a cluster are small to an eye. Its middle is given in the eye's frame, metres.
pub(crate) fn is_distant(cluster: &Cluster, middle: DVec3, resolution: u32) -> bool {
    let (distance, radius) = (middle.length(), cluster.bounds.radius);
    let longest = f64::from(cluster.longest) * f64::from(resolution);
    cluster.kind == Kind::Triangles
        && distance > FAR * radius
        && longest <= LONGEST * (distance - radius)
}

/// False where a face of a hemicube sees none of a cluster whose middle is given in the eye's frame, metres.
pub(crate) fn may_be_in(face: usize, middle: DVec3, cluster: &Cluster) -> bool {
    let (forward, across, along) = match face {
        0 => (middle.z, middle.x.abs(), middle.y.abs()),
        1 => (middle.x, middle.y.abs(), middle.z),
        2 => (middle.y, middle.x.abs(), middle.z),
        3 => (-middle.x, middle.y.abs(), middle.z),
        _ => (-middle.y, middle.x.abs(), middle.z),
    };
    across.max(along) - forward <= SQRT_2 * cluster.bounds.radius
}

/// A window as it lies in the scene.
struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels from the picture's middle to its lower left corner, to the right and up.
    left: f64,
    bottom: f64,
    /// Pixels a radian in the middle.
    scale: f64,
    width: usize,
    height: usize,
    /// By how much boxes are too small, metres.
    margin: f64,
}

impl Camera {
    fn new(frame: &Frame, window: &Window, margin: f64) -> Self {
        Self {
            eye: frame.position,
            right: frame.to_scene(window.right),
            up: frame.to_scene(window.up),
            forward: frame.to_scene(window.forward),
            left: window.left / window.pixel,
            bottom: window.bottom / window.pixel,
            scale: 1.0 / window.pixel,
            width: window.width,
            height: window.height,
            margin,
        }
    }

    /// `None` where the cluster is between pixels' centres or outside of the picture.
    fn pixels(&self, cluster: &Cluster) -> Option<Rectangle> {
        let middle = cluster.bounds.middle - self.eye;
        let along = |axis: DVec3| {
            let (at, half) = (middle.dot(axis), cluster.bounds.half.dot(axis.abs()));
            [at - half, at + half]
        };
        let [low_x, high_x] = along(self.right);
        let [low_y, high_y] = along(self.up);
        let [near, far] = along(self.forward);
        let inverse = [1.0 / near, 1.0 / far];
        let among = |low: f64, high: f64, corner: f64, count: usize| {
            let low = low * if low < 0.0 { inverse[0] } else { inverse[1] };
            let high = high * if high < 0.0 { inverse[1] } else { inverse[0] };
            let growth = f64::from(GROWTH);
            let first = low * self.scale - corner - 0.5 - growth;
            let last = high * self.scale - corner - 0.5 + growth;
            first.max(0.0).ceil() as usize..(last.max(-1.0) + 1.0).min(count as f64) as usize
        };
        let columns = among(low_x, high_x, self.left, self.width);
        let rows = among(low_y, high_y, self.bottom, self.height);
        let nearest = (CLEARLY_FARTHER / (near - self.margin).max(0.0)) as f32;
        let is_seen = !columns.is_empty() && !rows.is_empty();
        is_seen.then_some(Rectangle {
            columns,
            rows,
            nearest,
        })
    }

    /// Of each vertex of a cluster, among the pixels that may see the cluster, the last column and row that a
    /// triangle with this as its rightmost or uppermost corner may hold the centre of, and the opposites of the first
    /// ones.
    #[inline(always)]
    fn place<S: Simd>(
        &self,
        simd: S,
        vertices: [&[f32]; 3],
        pixels: &Rectangle,
        places: &mut [[i32; 4]],
        [to_x, to_y]: [&mut [f32]; 2],
    ) {
        let scale = f32x8::splat(simd, self.scale as f32);
        let [right, up, forward] = [
            self.right.as_vec3(),
            self.up.as_vec3(),
            self.forward.as_vec3(),
        ];
        // From the corner's to the first centre.
        let (left, bottom) = (self.left as f32 + 0.5, self.bottom as f32 + 0.5);
        let last_column = pixels.columns.end as f32 - 1.0;
        let last_row = pixels.rows.end as f32 - 1.0;
        let first_column = -(pixels.columns.start as f32);
        let first_row = -(pixels.rows.start as f32);
        for (k, places) in places.chunks_exact_mut(LANES).enumerate() {
            let part = LANES * k..LANES * (k + 1);
            let mut q = [f32x8::splat(simd, 0.0); 3];
            for axis in 0..3 {
                let (low, high) = f32x8::from_slice(simd, &vertices[axis][part.clone()]).widen();
                q[axis] = (low - self.eye[axis]).narrow(high - self.eye[axis]);
            }
            let scale = scale / (q[0] * forward.x + q[1] * forward.y + q[2] * forward.z);
            let x = (q[0] * right.x + q[1] * right.y + q[2] * right.z) * scale - left;
            let y = (q[0] * up.x + q[1] * up.y + q[2] * up.z) * scale - bottom;
            x.store_slice(&mut to_x[part.clone()]);
            y.store_slice(&mut to_y[part]);
            let right = (x + GROWTH).floor().min(last_column);
            let up = (y + GROWTH).floor().min(last_row);
            let left = (f32x8::splat(simd, GROWTH) - x).floor().min(first_column);
            let down = (f32x8::splat(simd, GROWTH) - y).floor().min(first_row);
            let (even, odd) = (right.interleave(left), up.interleave(down));
            let (low, high) = (even.0.interleave(odd.0), even.1.interleave(odd.1));
            for (k, four) in [low.0, low.1, high.0, high.1].into_iter().enumerate() {
                let four: i32x8<S> = four.to_int();
                four.store_slice(bytemuck::cast_slice_mut(&mut places[2 * k..2 * k + 2]));
            }
        }
    }
}

/// The last column and row of a triangle and the opposites of its first ones.
#[inline(always)]
fn around<S: Simd>(simd: S, places: &[[i32; 4]], [a, b, c, _]: [u8; 4]) -> i32x4<S> {
    let a = i32x4::from_slice(simd, &places[usize::from(a)]);
    let b = i32x4::from_slice(simd, &places[usize::from(b)]);
    let c = i32x4::from_slice(simd, &places[usize::from(c)]);
    a.max(b).max(c)
}

/// Draws distant clusters, the nearest of which are first.
#[inline(always)]
pub(crate) fn draw<S: Simd>(
    simd: S,
    clusters: &Clusters,
    distant: &[Distant],
    candidates: &mut Candidates,
    target: &mut Target,
) {
    let margin = BOX_MARGIN * target.at.geometry.plane_tolerance;
    let camera = Camera::new(&target.at.frame, &candidates.window, margin);
    let mut places = [[0; 4]; 4 * REGIONS];
    let (mut x, mut y) = ([0.0; 4 * REGIONS], [0.0; 4 * REGIONS]);
    let mut near_centres = [0; REGIONS];
    for next in distant {
        let cluster = next.of(clusters);
        let Some(pixels) = camera.pixels(cluster) else {
            continue;
        };
        if target
            .depth
            .hides(simd, &target.buffer.inverse_depth, &pixels)
        {
            continue;
        }
        let vertices = clusters.vertices_of(cluster);
        let places = &mut places[..vertices[0].len()];
        camera.place(simd, vertices, &pixels, places, [&mut x, &mut y]);
        let corners = &clusters.corners[cluster.places()];
        let regions = clusters.regions_of(cluster);
        let mut count = 0;
        for (k, &corners) in corners.iter().enumerate() {
            let around = around(simd, places, corners);
            let pixels = around + around.slide::<2>(around);
            near_centres[count] = k;
            let is_near_centre = pixels.simd_lt(0).to_bitmask().trailing_zeros() >= 2;
            count += usize::from(is_near_centre);
        }
        for &k in &near_centres[..count] {
            let mut triangle = Triangle {
                region: regions[k],
                around: *around(simd, places, corners[k]).as_array(),
                corners: [Vec3::ZERO; 3],
                x: [0.0; 3],
                y: [0.0; 3],
            };
            for (to, &from) in corners[k][..3].iter().enumerate() {
                let from = usize::from(from);
                triangle.corners[to] =
                    Vec3::from_array([vertices[0][from], vertices[1][from], vertices[2][from]]);
                triangle.x[to] = x[from];
                triangle.y[to] = y[from];
            }
            triangle.draw(simd, candidates, target);
        }
    }
}

/// A triangle that may hold pixels' centres.
struct Triangle {
    region: u32,
    /// Metres.
    corners: [Vec3; 3],
    /// Its corners' places in pixels from the centre of the first one.
    x: [f32; 3],
    y: [f32; 3],
    /// See [`around`].
    around: [i32; 4],
}

impl Triangle {
    /// Makes candidates of the pixels whose centres it may hold.
    #[inline(always)]
    fn draw<S: Simd>(&self, simd: S, candidates: &mut Candidates, target: &mut Target) {
        let [right, up, left, down] = self.around;
        // Hardly ever more than one rectangle.
        let most_columns = (right + left + 1).min(MOST_PIXELS);
        let most_rows = MOST_PIXELS / most_columns;
        for bottom in (-down..=up).step_by(most_rows as usize) {
            for left in (-left..=right).step_by(most_columns as usize) {
                let columns = most_columns.min(right - left + 1);
                let rows = most_rows.min(up - bottom + 1);
                let (mut x, mut y) = (self.x, self.y);
                for k in 0..3 {
                    x[k] -= left as f32;
                    y[k] -= bottom as f32;
                }
                let mut pixels = held(simd, x, y, columns, rows);
                while pixels != 0 {
                    let pixel = pixels.trailing_zeros() as i32;
                    pixels &= pixels - 1;
                    let (i, j) = (left + pixel % columns, bottom + pixel / columns);
                    if candidates.add(self.region, [i as u32, j as u32], self.corners) {
                        candidates.draw(simd, target);
                    }
                }
            }
        }
    }
}
