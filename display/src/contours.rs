//! Contours: lines of one luminance on surfaces.
//!
//! A contour runs between two neighbouring pixels whose luminances lie on either side of a level, if both see one plane of one
//! material: over an edge the light jumps, and there is no line to be drawn. So it is what pixels see in their middle that counts, not
//! their mean, which at an edge is neither side's.

use glam::{DVec3, Vec3};
use scene::{PatchId, Rgb, Scene, Surface};

use crate::luminance::luminance;
use crate::settings::Size;
use crate::shade::Middle;

/// Rows of a picture for each pixel of a line's width.
const ROWS_PER_WIDTH: u32 = 500;

/// Cosine between normals, and distance over the scene's size, up to which two surfaces are in one plane.
const SAME_NORMAL: f64 = 0.9999;
const SAME_PLANE: f64 = 1e-4;

/// Display luminance above which a line is black, and below it white: half of the codes.
const DARK_INK_FROM: f32 = 0.214;

/// Draws contours at these levels over the pixels of a view, which are display light, linear RGB. `middles` has what each of them
/// sees.
pub fn draw(
    pixels: &mut [Rgb],
    scene: &Scene,
    size: Size,
    middles: &[Option<Middle>],
    levels: &[f64],
) {
    let is_on_line = lines(scene, size, middles, levels);
    for (pixel, is_on_line) in pixels.iter_mut().zip(is_on_line) {
        if is_on_line {
            let is_bright = luminance(*pixel) > DARK_INK_FROM;
            *pixel = if is_bright { Rgb::ZERO } else { Rgb::ONE };
        }
    }
}

/// Which pixels lie on a line.
fn lines(scene: &Scene, size: Size, middles: &[Option<Middle>], levels: &[f64]) -> Vec<bool> {
    let (width, height) = (size.width as usize, size.height as usize);
    let planes = Planes::new(scene);
    let mut is_on_line = vec![false; width * height];
    let reach = (size.height / ROWS_PER_WIDTH) as usize;
    for y in 0..height {
        for x in 0..width {
            let here = y * width + x;
            let right = (x + 1 < width).then_some(here + 1);
            let below = (y + 1 < height).then_some(here + width);
            for there in [right, below].into_iter().flatten() {
                let (Some(a), Some(b)) = (middles[here], middles[there]) else {
                    continue;
                };
                let [least, most] = {
                    let [a, b] = [a, b].map(|middle| f64::from(luminance(middle.value)));
                    [a.min(b), a.max(b)]
                };
                let crosses = |&level: &f64| least < level && level <= most;
                if !levels.iter().any(crosses) || !planes.are_one(a.patch, b.patch) {
                    continue;
                }
                for y in y..=(y + reach).min(height - 1) {
                    let row = y * width;
                    is_on_line[row + x..=row + (x + reach).min(width - 1)].fill(true);
                }
            }
        }
    }
    is_on_line
}

/// Tells which patches lie in one plane.
struct Planes<'a> {
    scene: &'a Scene,
    /// One per surface: its unit normal.
    normals: Vec<DVec3>,
    /// Distance up to which a point lies in a plane, metres.
    distance: f64,
}

impl<'a> Planes<'a> {
    fn new(scene: &'a Scene) -> Self {
        let [low, high] = scene.bounds().map(Vec3::as_dvec3);
        Self {
            scene,
            normals: scene.surfaces().iter().map(Surface::normal).collect(),
            distance: SAME_PLANE * (high - low).length(),
        }
    }

    fn are_one(&self, a: PatchId, b: PatchId) -> bool {
        let [a, b] = [a, b].map(|patch| self.scene.mesh().surface_of(patch));
        if a == b {
            return true;
        }
        let normal = self.normals[a.index()];
        let [first, second] = [a, b].map(|surface| self.scene.surface(surface));
        let between = (second.corners[0] - first.corners[0]).as_dvec3();
        first.material == second.material
            && normal.dot(self.normals[b.index()]) > SAME_NORMAL
            && between.dot(normal).abs() <= self.distance
    }
}

#[cfg(test)]
mod tests {
    use scene::{Material, MaterialId, ObjectId};

    use super::*;

    /// Two squares of two triangles each, the second one turned up by 90 degrees or in the plane of the first.
    fn scene(is_folded: bool) -> Scene {
        let far = if is_folded {
            Vec3::new(1.0, 0.0, 1.0)
        } else {
            Vec3::new(2.0, 0.0, 0.0)
        };
        let triangle = |corners| Surface {
            corners,
            material: MaterialId(0),
            object: ObjectId(0),
        };
        let material = Material {
            name: String::new(),
            reflectance: Rgb::splat(0.5),
            emission: Rgb::ZERO,
        };
        let (x, y) = (Vec3::X, Vec3::Y);
        let surfaces = vec![
            triangle([Vec3::ZERO, x, x + y]),
            triangle([x, far, far + y]),
        ];
        Scene::new(
            vec![material],
            vec![String::new()],
            surfaces,
            &[0, 0],
            DVec3::ZERO,
        )
        .unwrap()
    }

    const SIZE: Size = Size {
        width: 4,
        height: 1,
    };

    /// Of four pixels two see the first triangle and two the second one, which is twice as bright.
    fn lines_of(scene: &Scene, levels: &[f64]) -> Vec<bool> {
        let middle = |patch| {
            Some(Middle {
                patch: PatchId(patch),
                value: Rgb::splat((patch + 1) as f32),
            })
        };
        lines(scene, SIZE, &[0, 0, 1, 1].map(middle), levels)
    }

    #[test]
    fn lines_run_where_a_level_is_crossed_in_a_plane() {
        let flat = scene(false);
        assert_eq!(lines_of(&flat, &[1.5]), [false, true, false, false]);
        assert_eq!(lines_of(&flat, &[0.5, 2.5]), [false; 4]);
        assert_eq!(lines_of(&flat, &[]), [false; 4]);
    }

    #[test]
    fn light_that_jumps_over_an_edge_is_no_line() {
        assert_eq!(lines_of(&scene(true), &[1.5]), [false; 4]);
    }

    #[test]
    fn what_is_not_seen_has_no_lines() {
        let middle = Middle {
            patch: PatchId(0),
            value: Rgb::ONE,
        };
        let middles = [Some(middle), None, Some(middle), None];
        assert_eq!(lines(&scene(false), SIZE, &middles, &[0.5]), [false; 4]);
    }
}
