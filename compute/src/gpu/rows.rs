//! Form factor rows from hemicubes drawn on the GPU. Twin of [`crate::cpu::CpuRows`].

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use visibility::{Frame, hemicube};

use super::adapter::Gpu;
use super::atlas::TILES_PER_HEMICUBE;
use super::item_buffer::AtlasDrawer;
use super::merger::{FinishedBatch, Merger, SLOTS};
use super::pace::Pace;
use super::race;
use super::raster::Raster;
use super::structs::Tile;
use crate::hemicubes::Hemicubes;
use crate::receivers::ReceiverId;
use crate::rows::{BackendError, RowBatch, RowSource};
use crate::settings::AdapterChoice;

/// Submissions in a batch that is asked for, so that most are prepared while another is drawn. Few enough
/// that an interrupt is answered soon.
const SUBMISSIONS_PER_BATCH: u32 = 4;

/// What the device was given to do.
#[derive(Debug)]
struct Submission {
    index: wgpu::SubmissionIndex,
    submitted: Instant,
    tiles: u32,
    /// The rows that it completes.
    batch: Option<FinishedBatch>,
}

/// The gpu back end.
#[derive(Debug)]
pub struct GpuRows<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    drawer: AtlasDrawer,
    merger: Merger,
    raster: Raster,
    pace: Pace,
    /// What the merger will be told of the tiles added to the drawer.
    tiles: Vec<Tile>,
    /// What the device has to do, the oldest first.
    in_flight: VecDeque<Submission>,
    /// The rows read so far.
    rows: RowBatch,
    // Last, so that it outlives what was made with it.
    gpu: Gpu,
}

impl<'a> GpuRows<'a> {
    /// A back end on the best adapter that the choice accepts, with the raster that is faster there.
    pub fn new(
        hemicubes: &Arc<Hemicubes<'a>>,
        choice: AdapterChoice,
    ) -> Result<Self, BackendError> {
        Self::with_raster(hemicubes, choice, None)
    }

    /// The same with a raster of one's own choice, where one is given.
    pub fn with_raster(
        hemicubes: &Arc<Hemicubes<'a>>,
        choice: AdapterChoice,
        raster: Option<Raster>,
    ) -> Result<Self, BackendError> {
        let gpu = Gpu::open(choice)?;
        let mut drawer =
            AtlasDrawer::new(&gpu, hemicubes.sources().scene(), hemicubes.resolution())?;
        let merger = Merger::new(&gpu, drawer.view(), drawer.layout(), hemicubes)?;
        let pace = Pace::new(drawer.layout().tiles());
        let raster = match raster {
            None => race::fastest(&gpu, &mut drawer, hemicubes),
            Some(raster) => Ok(raster),
        };
        // What goes wrong up to here, such as memory running out, speaks against the adapter.
        if let Some(what) = gpu.failure() {
            return Err(gpu.unsuitable(format!("it cannot be set up ({what})")));
        }
        let raster = raster?;
        if !Raster::offered_by(&gpu).contains(&raster) {
            return Err(gpu.unsuitable(format!("it has no {}", raster.describe())));
        }
        Ok(Self {
            hemicubes: Arc::clone(hemicubes),
            drawer,
            merger,
            raster,
            pace,
            tiles: Vec::new(),
            in_flight: VecDeque::new(),
            rows: RowBatch::new(0),
            gpu,
        })
    }

    /// The adapter's name and the interface it is driven through.
    pub fn adapter(&self) -> &str {
        self.gpu.name()
    }

    /// Loses the device, as a driver does that is reset; for tests.
    #[doc(hidden)]
    pub fn lose_device(&self) {
        self.gpu.device.destroy();
    }

    /// The item buffer of the hemicube at `frame` of a receiver, in the layout and with the codes of
    /// [`visibility::item_buffer::HemicubeDrawer::item_buffer`]. It is read back pixel by pixel, which
    /// is slow; rows never are.
    pub fn item_buffer(
        &mut self,
        receiver: ReceiverId,
        frame: &Frame,
    ) -> Result<Vec<u32>, BackendError> {
        let hemicubes = Arc::clone(&self.hemicubes);
        let (scene, receivers) = (hemicubes.sources().scene(), hemicubes.receivers());
        let own = receivers.surface(receiver);
        let frames = receivers.frames(receiver);
        // A frame that is not one of the receiver's own is drawn where the first of them is.
        let point = frames.iter().position(|f| f == frame).unwrap_or(0);
        let layout = self.drawer.layout();
        let mut ids = Vec::with_capacity(hemicube::pixel_count(layout.resolution));
        self.gpu.check()?;
        for tile in 0..TILES_PER_HEMICUBE {
            let number = receivers.first_point(receiver) + point as u64;
            let origin = layout.origin(number, tile);
            self.drawer.add(scene, own, frame, tile, origin);
            let mut encoder = self.gpu.encoder();
            self.drawer.draw(&self.gpu, &mut encoder, self.raster);
            self.gpu.run(encoder)?;
            ids.extend(self.drawer.read(&self.gpu, origin)?);
        }
        Ok(ids)
    }

    /// Adds the tiles of a receiver's hemicubes to the row of that number, and submits what is full.
    fn add_row(&mut self, receiver: ReceiverId, row: u32) -> Result<(), BackendError> {
        let hemicubes = Arc::clone(&self.hemicubes);
        let (scene, receivers) = (hemicubes.sources().scene(), hemicubes.receivers());
        let own = receivers.surface(receiver);
        let frames = receivers.frames(receiver);
        for (number, frame) in (receivers.first_point(receiver)..).zip(&frames) {
            for tile in 0..TILES_PER_HEMICUBE {
                if self.tiles.len() as u32 >= self.pace.tiles()
                    || !self.drawer.has_room(scene, own, frame)
                {
                    self.submit(0)?;
                }
                let origin = self.drawer.layout().origin(number, tile);
                self.drawer.add(scene, own, frame, tile, origin);
                let tile = self.merger.tile(origin, row, tile, frames.len() as u32);
                self.tiles.push(tile);
            }
        }
        Ok(())
    }

    /// Has the tiles collected so far drawn and summed; they complete so many rows, or none yet.
    fn submit(&mut self, row_count: u32) -> Result<(), BackendError> {
        let mut encoder = self.gpu.encoder();
        self.drawer.draw(&self.gpu, &mut encoder, self.raster);
        self.merger.add(&self.gpu, &mut encoder, &self.tiles);
        let batch = (row_count > 0).then(|| self.merger.finish(&self.gpu, &mut encoder, row_count));
        let submitted = Instant::now();
        let index = self.gpu.submit(encoder)?;
        if let Some(batch) = &batch {
            self.merger.ask(batch);
        }
        self.in_flight.push_back(Submission {
            index,
            submitted,
            tiles: self.tiles.len() as u32,
            batch,
        });
        self.tiles.clear();
        while self.in_flight.len() >= SLOTS {
            self.collect()?;
        }
        Ok(())
    }

    /// Waits for the oldest submission, and reads the rows that it completes.
    fn collect(&mut self) -> Result<(), BackendError> {
        let Some(submission) = self.in_flight.pop_front() else {
            return Ok(());
        };
        self.gpu.wait(submission.index)?;
        self.pace.ended(submission.tiles, submission.submitted);
        match submission.batch {
            Some(batch) => self.merger.read(&self.gpu, &batch, &mut self.rows),
            None => Ok(()),
        }
    }
}

impl RowSource for GpuRows<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        self.gpu.check()?;
        self.rows = RowBatch::new(receivers.start);
        let mut row = 0;
        for receiver in receivers.clone() {
            self.add_row(ReceiverId(receiver), row)?;
            row += 1;
            let next = ReceiverId(receiver + 1);
            let is_last = next.0 == receivers.end;
            let fits = || {
                let tiles =
                    self.hemicubes.receivers().point_count(next) * TILES_PER_HEMICUBE as u32;
                self.tiles.len() as u32 + tiles <= self.pace.tiles()
            };
            if is_last || row == self.merger.max_rows() || !fits() {
                self.submit(row)?;
                row = 0;
            }
        }
        while !self.in_flight.is_empty() {
            self.collect()?;
        }
        Ok(std::mem::replace(&mut self.rows, RowBatch::new(0)))
    }

    /// Several submissions' worth of hemicubes, so that the device seldom waits for the next; it grows
    /// from small as the adapter turns out to be fast.
    fn preferred_batch(&self) -> u32 {
        let rows = u64::from(self.hemicubes.receivers().count().max(1));
        let hemicubes_per_row = self.hemicubes.total().div_ceil(rows).max(1) as u32;
        let per_submission = (self.pace.tiles() / (TILES_PER_HEMICUBE as u32 * hemicubes_per_row))
            .clamp(1, self.merger.max_rows());
        SUBMISSIONS_PER_BATCH * per_submission
    }

    fn backend(&self) -> &'static str {
        "gpu"
    }

    fn describe(&self) -> String {
        format!("gpu, {}, {}", self.adapter(), self.raster.describe())
    }

    /// All ways to raster give the same bits.
    fn identity(&self) -> String {
        format!("gpu, {}", self.adapter())
    }
}
