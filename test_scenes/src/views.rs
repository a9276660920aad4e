//! What hemicubes must see, by the reference, and how item buffers differ from it.

use std::fmt;

use scene::{PatchId, Scene};
use visibility::reference::{self, Reference};
use visibility::{Eye, Frame, hemicube};

/// Pixels along a face.
pub const VIEW_RESOLUTION: u32 = 32;

/// Hemicubes a scene.
const HEMICUBES: u32 = 12;

/// A hemicube, and what the reference sees through it.
struct View<'a> {
    patch: PatchId,
    frame: Frame,
    ids: Vec<u32>,
    reference: Reference<'a>,
}

/// Hemicubes all over a scene, turned in all directions, and what the reference sees through them.
pub struct Views<'a>(Vec<View<'a>>);

/// How item buffers differ from what the reference sees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// All that were compared.
    pub pixels: usize,
    /// Those that see something else than the reference.
    pub differing: usize,
    /// Those of them that see what the reference does not see beside the pixel's centre either.
    pub wrong: usize,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            pixels,
            differing,
            wrong,
        } = self;
        write!(
            f,
            "{differing} of {pixels} pixels differ, {wrong} are wrong"
        )
    }
}

impl<'a> Views<'a> {
    /// Those of a scene.
    pub fn of(scene: &'a Scene) -> Self {
        let patches = (0..HEMICUBES).map(|k| PatchId(scene.patch_count() / HEMICUBES * k));
        let view = |patch: PatchId| {
            let geometry = scene.patch(patch);
            let own = geometry.surface;
            let normal = scene.surface(own).normal();
            let turn = 0.7 * f64::from(patch.0);
            let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), turn);
            View {
                patch,
                frame,
                ids: reference::item_buffer(scene, own, &frame, VIEW_RESOLUTION),
                reference: Reference::new(scene, &Eye::with_horizon(&frame, own)),
            }
        };
        Self(patches.map(view).collect())
    }

    /// Compares item buffers, of [`VIEW_RESOLUTION`], with what the reference sees. A pixel that differs is wrong where
    /// the reference sees nothing of the kind within `hair` pixels of its centre.
    pub fn compare(
        &self,
        hair: f64,
        mut item_buffer: impl FnMut(PatchId, &Frame) -> Vec<u32>,
    ) -> Difference {
        let mut difference = Difference::default();
        for view in &self.0 {
            let seen = item_buffer(view.patch, &view.frame);
            assert_eq!(seen.len(), view.ids.len());
            difference.pixels += seen.len();
            for (pixel, (id, expected)) in seen.iter().zip(&view.ids).enumerate() {
                if id != expected {
                    difference.differing += 1;
                    let is_beside = beside(&view.reference, pixel, hair).any(|other| other == *id);
                    difference.wrong += usize::from(!is_beside);
                }
            }
        }
        difference
    }
}

/// What the reference sees at most a hair beside a pixel's centre, in some directions and distances.
fn beside(reference: &Reference, pixel: usize, hair: f64) -> impl Iterator<Item = u32> {
    let size = VIEW_RESOLUTION as usize;
    let (i, j) = (pixel % size, pixel / size);
    let (face, j) = if j < size {
        (0, j)
    } else {
        (1 + (j - size) / (size / 2), (j - size) % (size / 2))
    };
    let window = hemicube::windows(VIEW_RESOLUTION)[face];
    let ray = window.direction(i, j);
    let steps = [1.0, 0.25, 1.0 / 16.0].map(|share| share * hair * window.pixel);
    let around = (0..16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0);
    around
        .flat_map(move |angle| steps.map(|step| (step * angle.cos(), step * angle.sin())))
        .map(move |(x, y)| reference.along(ray + x * window.right + y * window.up))
}
