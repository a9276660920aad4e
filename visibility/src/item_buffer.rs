//! Item buffers of whole hemicubes: which patch each pixel sees.

use std::sync::Arc;

use scene::{NO_PATCH, SurfaceId};

use crate::Frame;
use crate::drawable::Drawable;
use crate::hemicube::{FACES, pixel_count};
use crate::picture::Canvas;
use crate::view::Viewer;

/// A pixel that sees nothing: [`NO_PATCH`].
pub const NOTHING: u32 = NO_PATCH.0;
/// A pixel that sees the back of a surface: [`NO_PATCH`] and a bit above the 24 of an ID.
pub const BACK_FACE: u32 = 1 << 24 | NO_PATCH.0;

/// Draws hemicubes one after the other, for one thread.
#[derive(Clone, Debug)]
pub struct HemicubeDrawer<'a> {
    resolution: u32,
    viewer: Viewer<'a>,
    canvas: Canvas,
}

impl<'a> HemicubeDrawer<'a> {
    /// A drawer of hemicubes of this resolution.
    pub fn new(drawable: &Arc<Drawable<'a>>, resolution: u32) -> Self {
        Self {
            resolution,
            viewer: Viewer::new(drawable),
            canvas: Canvas::default(),
        }
    }

    /// Draws the hemicube at `frame` on the surface `own`, if on any, and hands out its rows of patch IDs: face, row, IDs.
    pub fn draw(
        &mut self,
        own: impl Into<Option<SurfaceId>>,
        frame: &Frame,
        nothing: u32,
        back_face: u32,
        mut take: impl FnMut(usize, usize, &[u32]),
    ) {
        let hemicube = self.viewer.hemicube(self.resolution, frame, own);
        for face in 0..FACES {
            let mut picture = self.canvas.draw_face(&hemicube, face);
            picture.for_each_row(nothing, back_face, |row, ids| take(face, row, ids));
        }
    }

    /// The item buffer of a hemicube in the layout of [`crate::hemicube`]: 3 R^2 patch IDs,
    /// [`NOTHING`] or [`BACK_FACE`].
    pub fn item_buffer(&mut self, own: impl Into<Option<SurfaceId>>, frame: &Frame) -> Vec<u32> {
        let mut ids = Vec::with_capacity(pixel_count(self.resolution));
        self.draw(own, frame, NOTHING, BACK_FACE, |_, _, row| {
            ids.extend_from_slice(row);
        });
        ids
    }
}
