//! Lamps: a narrow view for each surface that matters as a source.
//!
//! # Theory
//! A small bright surface covers three pixels of one hemicube and seven of the next: the worst error of
//! the method, since light comes from there. Its form factor is known exactly where nothing hides it
//! ([`polygon_form_factor`](crate::polygon_form_factor)), so only the visible fraction is left to find: by
//! drawing the surfaces into a small item buffer whose frustum just encloses the lamp. Per point of a
//! patch
//!
//! F_lamp = F_exact v,   v = sum of w over pixels that see the lamp / sum of w over pixels of the lamp,
//!
//! with w = z / |d|^4 for a pixel along d, z its height over the horizon: proportional to the pixel's own
//! delta form factor. A lamp that nothing hides is exact.
//!
//! # Practice
//! Emitting surfaces of one material that touch are one lamp where they lie in one plane or make a
//! convex body, of which no part hides another. A lamp matters to a patch when, unhidden, it
//! would bring at least a hundredth (LEAST_SHARE) of all that lamps could bring there, and it is among the first
//! eight (MOST_VIEWS) by that measure: a thousand equal lamps are left to the hemicube, where their errors
//! average out. Where one piece hides all of a lamp from a point, it is not looked at from there. In the patch's row
//! the hemicube's entries for the lamp give way to these, and the others are scaled so that the row still sums to
//! what it did.

mod find;
mod merge;
mod piece;
mod view;

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use thread_local::ThreadLocal;

use self::find::{Lamp, lamps};
use self::view::LampViewer;
use crate::hemicubes::Hemicubes;
use crate::receivers::ReceiverId;
use crate::rows::{BackendError, RowBatch, RowSource};
use crate::settings::{LampViews, Maps};

/// Form factor rows in which lamps have their own views.
pub struct LampRows<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    lamps: Arc<[Lamp]>,
    all: bool,
    inner: Box<dyn RowSource + 'a>,
    /// One for each thread that has looked.
    viewers: ThreadLocal<RefCell<LampViewer<'a>>>,
}

/// Rows of `source` in which lamps have their own views, as far as they are asked for; the thesis's maps
/// are left as the thesis has them.
pub fn with_lamps<'a>(
    hemicubes: &Arc<Hemicubes<'a>>,
    views: LampViews,
    source: Box<dyn RowSource + 'a>,
) -> Box<dyn RowSource + 'a> {
    let off = views == LampViews::Off || hemicubes.maps() == Maps::Thesis;
    let lamps = if off {
        Vec::new()
    } else {
        lamps(hemicubes.drawable())
    };
    if lamps.is_empty() {
        return source;
    }
    Box::new(LampRows {
        hemicubes: Arc::clone(hemicubes),
        lamps: lamps.into(),
        all: views == LampViews::All,
        inner: source,
        viewers: ThreadLocal::new(),
    })
}

impl RowSource for LampRows<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        let first = receivers.start;
        let mut drawn = self.inner.draw_rows(receivers)?;
        let Self {
            hemicubes,
            lamps,
            all,
            viewers,
            ..
        } = &*self;
        let rows = drawn.rows_mut().par_iter_mut().enumerate();
        rows.with_max_len(1).for_each(|(k, row)| {
            let viewer = viewers.get_or(|| RefCell::new(LampViewer::new(hemicubes, lamps, *all)));
            viewer
                .borrow_mut()
                .refine(ReceiverId(first + k as u32), row);
        });
        Ok(drawn)
    }

    fn preferred_batch(&self) -> u32 {
        self.inner.preferred_batch()
    }

    fn backend(&self) -> &'static str {
        self.inner.backend()
    }

    fn describe(&self) -> String {
        self.inner.describe()
    }

    fn identity(&self) -> String {
        self.inner.identity()
    }
}
