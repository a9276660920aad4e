//! A whole hemicube's item buffer: which patch each pixel sees.

use std::sync::Arc;

use scene::{NO_PATCH, SurfaceId};

use super::{Drawable, Projection, Raster};
use crate::hemicube::{self, Frame, Window};

/// A pixel that sees nothing: [`NO_PATCH`].
pub const NOTHING: u32 = NO_PATCH.0;
/// A pixel that sees the back of a surface: [`NO_PATCH`] and a bit above the 24 of an ID.
pub const BACK_FACE: u32 = 1 << 24 | NO_PATCH.0;

/// Draws hemicubes one after the other, for one thread.
#[derive(Clone, Debug)]
pub struct HemicubeDrawer<'a> {
    windows: [Window; 5],
    projection: Projection<'a>,
    raster: Raster,
}

impl<'a> HemicubeDrawer<'a> {
    /// A drawer of hemicubes of this resolution.
    pub fn new(drawable: &Arc<Drawable<'a>>, resolution: u32) -> Self {
        Self {
            windows: hemicube::windows(resolution),
            projection: Projection::new(drawable),
            raster: Raster::default(),
        }
    }

    /// Draws the hemicube at `frame` on the surface `own` and hands out its rows of patch IDs: face, row, IDs.
    pub fn draw(
        &mut self,
        own: SurfaceId,
        frame: &Frame,
        nothing: u32,
        back_face: u32,
        mut take: impl FnMut(usize, usize, &[u32]),
    ) {
        let resolution = self.windows[0].width as u32;
        self.projection.set_for_hemicube(resolution, frame, own);
        for (face, window) in self.windows.iter().enumerate() {
            self.raster
                .draw_or_cast(&mut self.projection, Some(face), window);
            self.raster
                .for_each_row(&self.projection, nothing, back_face, |row, ids| {
                    take(face, row, ids);
                });
        }
    }

    /// The item buffer of a hemicube in the layout of [`crate::hemicube`]: 3 R^2 patch IDs,
    /// [`NOTHING`] or [`BACK_FACE`].
    pub fn item_buffer(&mut self, own: SurfaceId, frame: &Frame) -> Vec<u32> {
        let size = self.windows[0].width;
        let mut ids = Vec::with_capacity(3 * size * size);
        self.draw(own, frame, NOTHING, BACK_FACE, |_, _, row| {
            ids.extend_from_slice(row);
        });
        ids
    }
}
