//! What stands on a wall.

use glam::Vec3;
use scene::{Surface, SurfaceId};
use visibility::Drawable;

use crate::sphere::Spheres;
use crate::triangle;

/// The feet of what stands on a scene's walls, which are sides of the surfaces there.
pub struct Feet<'d, 'a> {
    drawable: &'d Drawable<'a>,
    /// Of the polygons that are drawn, which are far fewer than surfaces where these are small parts of walls.
    triangles: Vec<Surface>,
    spheres: Spheres,
}

impl<'d, 'a> Feet<'d, 'a> {
    /// Those of what is drawn.
    pub fn new(drawable: &'d Drawable<'a>) -> Self {
        let regions = drawable.regions();
        let fan = |piece: usize| {
            let of_region = &regions.regions()[regions.pieces()[piece].region as usize];
            let like = drawable.scene().surface(of_region.surfaces[0]);
            let corners = regions.corners(piece);
            let corner = |k: usize| regions.vertices()[corners[k] as usize];
            (2..corners.len()).map(move |k| Surface {
                corners: [corner(0), corner(k - 1), corner(k)],
                ..*like
            })
        };
        let triangles: Vec<Surface> = (0..regions.pieces().len()).flat_map(fan).collect();
        Self {
            drawable,
            spheres: Spheres::new(&triangles),
            triangles,
        }
    }

    /// Whether something stands on the side of a surface with these ends, or crosses it there.
    pub fn is_foot(&self, surface: SurfaceId, ends: [Vec3; 2]) -> bool {
        let tolerance = self.drawable.plane_tolerance();
        let middle = 0.5 * (ends[0].as_dvec3() + ends[1].as_dvec3());
        let normal = self.drawable.normal_of(surface);
        let mut is_foot = false;
        self.spheres.for_each_within(tolerance, middle, |index, _| {
            let corners = self.triangles[index].corners.map(Vec3::as_dvec3);
            let is_off_plane = corners
                .iter()
                .any(|&corner| (corner - middle).dot(normal).abs() > tolerance);
            is_foot |= is_off_plane && triangle::distance(middle, corners) <= tolerance;
            tolerance
        });
        is_foot
    }
}
