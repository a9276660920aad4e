//! Surfaces that lie in one plane, found by growing from the largest.
//!
//! # Theory
//! Rounding moves a point by at most t = u |n| . |p| out of a plane with normal n, u = 2^-24. The least squares
//! plane through k such points is off at a place x by at most t times the sum of |w_i|, w_i being the
//! weights of their heights, and so (Cauchy-Schwarz) by at most t sqrt(1 + d C^-1 d), where C is the
//! points' covariance in the plane and d is x relative to their mean. A point beside those that the plane was
//! fitted to may then be t (1 + sqrt(1 + d C^-1 d)) away from it. Each time the points have doubled the
//! plane is fitted again, and must be within 2 t of them all: a chain of facets that bend a little does not
//! get past that.
//!
//! # Practice
//! Each doubling visits all surfaces so far, so that the work is linear.

use glam::{DVec3, Vec3};
use scene::{Scene, Surface};

use super::ULP;
use super::weld::Welded;

/// Surfaces in one plane.
pub(super) struct Group {
    /// Ascending.
    pub surfaces: Vec<u32>,
    /// Unit normal of their plane.
    pub normal: DVec3,
    /// A point of it, metres.
    pub point: DVec3,
}

/// All groups of two surfaces or more, largest surface first; no surface is in two.
pub(super) fn groups(scene: &Scene, welded: &Welded) -> Vec<Group> {
    let surfaces = scene.surfaces();
    let mut seeds: Vec<(f64, u32)> = surfaces.iter().map(Surface::area).zip(0..).collect();
    seeds.sort_unstable_by(|(a, i), (b, j)| b.total_cmp(a).then(i.cmp(j)));
    let mut growth = Growth {
        surfaces,
        welded,
        taken: vec![false; surfaces.len()],
    };
    seeds
        .into_iter()
        .filter_map(|(_, seed)| growth.grow(seed))
        .collect()
}

struct Growth<'a> {
    surfaces: &'a [Surface],
    welded: &'a Welded,
    /// One per surface: in a group.
    taken: Vec<bool>,
}

impl Growth<'_> {
    fn grow(&mut self, seed: u32) -> Option<Group> {
        if self.taken[seed as usize] {
            return None;
        }
        self.taken[seed as usize] = true;
        let surface = &self.surfaces[seed as usize];
        let mut fit = Fit::new(surface);
        let mut plane = fit.plane()?;
        let mut group = vec![seed];
        // Those up to here are known to lie in `plane`.
        let mut sure = (1, fit);
        let mut is_loose = true;
        loop {
            self.spread(&mut group, &mut fit, &plane, is_loose);
            if group.len() == sure.0 {
                break;
            }
            let refitted = fit
                .plane()
                .filter(|plane| self.is_flat(&group, plane, fit.reach));
            if let Some(refitted) = refitted {
                plane = refitted;
                sure = (group.len(), fit);
                continue;
            }
            for surface in group.drain(sure.0..) {
                self.taken[surface as usize] = false;
            }
            fit = sure.1;
            // What is a bend was taken for the plane's uncertainty.
            if !is_loose {
                break;
            }
            is_loose = false;
        }
        if group.len() < 2 {
            return None;
        }
        group.sort_unstable();
        Some(Group {
            surfaces: group,
            normal: plane.normal,
            point: plane.mean,
        })
    }

    /// Adds neighbours in the plane until there are about twice as many as before.
    fn spread(&mut self, group: &mut Vec<u32>, fit: &mut Fit, plane: &Plane, is_loose: bool) {
        let goal = 2 * group.len();
        let material = self.surfaces[group[0] as usize].material;
        let mut next = 0;
        while next < group.len() && group.len() < goal {
            let surface = group[next];
            next += 1;
            for side in 0..3 {
                for other in self.welded.across(surface, side) {
                    let candidate = &self.surfaces[other as usize];
                    if self.taken[other as usize]
                        || candidate.material != material
                        || !plane.faces(candidate)
                    {
                        continue;
                    }
                    let mut wider = *fit;
                    for p in candidate.corners {
                        wider.add(p.as_dvec3());
                    }
                    let tolerance = ULP * plane.normal.abs().dot(wider.reach);
                    let is_in_plane = candidate.corners.iter().all(|p| {
                        let p = p.as_dvec3();
                        let uncertain = if is_loose { plane.spread(p) } else { 1.0 };
                        plane.height(p).abs() <= tolerance * (1.0 + uncertain)
                    });
                    if is_in_plane {
                        self.taken[other as usize] = true;
                        group.push(other);
                        *fit = wider;
                    }
                }
            }
        }
    }

    fn is_flat(&self, group: &[u32], plane: &Plane, reach: DVec3) -> bool {
        let tolerance = 2.0 * ULP * plane.normal.abs().dot(reach);
        group.iter().all(|&index| {
            let surface = &self.surfaces[index as usize];
            let mut corners = surface.corners.iter();
            plane.faces(surface) && corners.all(|p| plane.height(p.as_dvec3()).abs() <= tolerance)
        })
    }
}

/// A fitted plane: w = mean.w + slopes . ((u, v) - (mean.u, mean.v)), where w is the axis of the scene it faces
/// most.
#[derive(Clone, Copy)]
struct Plane {
    axes: [usize; 3],
    normal: DVec3,
    mean: DVec3,
    /// Inverse of the points' covariance in u and v: uu, uv, vv.
    inverse_covariance: [f64; 3],
}

impl Plane {
    /// Distance, metres, above 0 in front.
    fn height(&self, p: DVec3) -> f64 {
        (p - self.mean).dot(self.normal)
    }

    /// How uncertain the plane is there, in uncertainties of a point.
    fn spread(&self, p: DVec3) -> f64 {
        let d = p - self.mean;
        let (u, v) = (d[self.axes[0]], d[self.axes[1]]);
        let [uu, uv, vv] = self.inverse_covariance;
        (1.0 + (uu * u * u + 2.0 * uv * u * v + vv * v * v).max(0.0)).sqrt()
    }

    /// Whether a surface faces the way the plane does, seen along its axis.
    fn faces(&self, surface: &Surface) -> bool {
        let [a, b, c] = surface.corners.map(Vec3::as_dvec3);
        let axis = self.axes[2];
        (b - a).cross(c - a)[axis] * self.normal[axis] > 0.0
    }
}

/// Sums for a least squares plane, relative to a first point.
#[derive(Clone, Copy)]
struct Fit {
    axes: [usize; 3],
    front: f64,
    base: DVec3,
    count: f64,
    /// Of the points: u, v and w.
    sums: DVec3,
    /// uu, uv, vv, uw, vw.
    products: [f64; 5],
    /// Largest magnitudes of the coordinates, metres.
    reach: DVec3,
}

impl Fit {
    fn new(surface: &Surface) -> Self {
        let normal = surface.normal();
        let w = normal.abs().max_position();
        let mut fit = Self {
            axes: [(w + 1) % 3, (w + 2) % 3, w],
            front: normal[w].signum(),
            base: surface.corners[0].as_dvec3(),
            count: 0.0,
            sums: DVec3::ZERO,
            products: [0.0; 5],
            reach: DVec3::ZERO,
        };
        for p in surface.corners {
            fit.add(p.as_dvec3());
        }
        fit
    }

    fn add(&mut self, p: DVec3) {
        let d = p - self.base;
        let [u, v, w] = self.axes.map(|axis| d[axis]);
        self.count += 1.0;
        self.sums += DVec3::new(u, v, w);
        for (sum, product) in self
            .products
            .iter_mut()
            .zip([u * u, u * v, v * v, u * w, v * w])
        {
            *sum += product;
        }
        self.reach = self.reach.max(p.abs());
    }

    /// `None` where the points are all in a line, to within rounding.
    fn plane(&self) -> Option<Plane> {
        let mean = self.sums / self.count;
        let [uu, uv, vv, uw, vw] = self.products.map(|sum| sum / self.count);
        let (uu, uv, vv) = (
            uu - mean.x * mean.x,
            uv - mean.x * mean.y,
            vv - mean.y * mean.y,
        );
        let (uw, vw) = (uw - mean.x * mean.z, vw - mean.y * mean.z);
        let determinant = uu * vv - uv * uv;
        if determinant.is_nan() || determinant <= f64::EPSILON * uu * vv {
            return None;
        }
        let slope_u = (uw * vv - vw * uv) / determinant;
        let slope_v = (vw * uu - uw * uv) / determinant;
        let [u, v, w] = self.axes;
        let (mut normal, mut centre) = (DVec3::ZERO, self.base);
        normal[u] = -slope_u * self.front;
        normal[v] = -slope_v * self.front;
        normal[w] = self.front;
        centre[u] += mean.x;
        centre[v] += mean.y;
        centre[w] += mean.z;
        let plane = Plane {
            axes: self.axes,
            normal: normal.normalize(),
            mean: centre,
            inverse_covariance: [vv / determinant, -uv / determinant, uu / determinant],
        };
        plane.normal.is_finite().then_some(plane)
    }
}
