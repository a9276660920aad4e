//! Form factor rows from hemicubes drawn on the GPU. Twin of [`crate::cpu::CpuRows`].

use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use scene::PatchId;

use super::adapter::{AdapterChoice, Gpu};
use super::atlas::TILES_PER_HEMICUBE;
use super::item_buffer::AtlasDrawer;
use super::merger::Merger;
use super::structs::Tile;
use crate::hemicube::{self, Frame};
use crate::hemicubes::Hemicubes;
use crate::rows::{BackendError, RowBatch, RowSource};

/// The gpu back end.
#[derive(Debug)]
pub struct GpuRows<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    drawer: AtlasDrawer,
    merger: Merger,
    pace: Pace,
    /// What the merger will be told of the tiles added to the drawer.
    tiles: Vec<Tile>,
    // Last, so that it outlives what was made with it.
    gpu: Gpu,
}

impl<'a> GpuRows<'a> {
    /// A back end on the best adapter that the choice accepts.
    pub fn new(
        hemicubes: &Arc<Hemicubes<'a>>,
        choice: AdapterChoice,
    ) -> Result<Self, BackendError> {
        let gpu = Gpu::open(choice)?;
        let drawer = AtlasDrawer::new(&gpu, hemicubes.sources(), hemicubes.settings().resolution)?;
        let merger = Merger::new(&gpu, drawer.view(), drawer.layout(), hemicubes)?;
        let pace = Pace::new(drawer.layout().tiles());
        // What goes wrong up to here, such as memory running out, speaks against the adapter.
        if let Some(what) = gpu.failure() {
            return Err(gpu.unsuitable(format!("it cannot be set up ({what})")));
        }
        Ok(Self {
            hemicubes: Arc::clone(hemicubes),
            drawer,
            merger,
            pace,
            tiles: Vec::new(),
            gpu,
        })
    }

    /// The adapter's name and the interface it is driven through.
    pub fn adapter(&self) -> &str {
        self.gpu.name()
    }

    /// The item buffer of the hemicube at `frame` on a patch, in the layout and with the codes of
    /// [`crate::cpu::item_buffer::HemicubeDrawer::item_buffer`]. It is read back pixel by pixel, which
    /// is slow; rows never are.
    pub fn item_buffer(&mut self, patch: PatchId, frame: &Frame) -> Result<Vec<u32>, BackendError> {
        let scene = self.hemicubes.sources();
        let own = self.hemicubes.surface_of(patch);
        let frames = self.hemicubes.frames(patch);
        // A frame that is not one of the patch's own is drawn where the first of them is.
        let point = frames.iter().position(|f| f == frame).unwrap_or(0);
        let layout = self.drawer.layout();
        let mut ids = Vec::with_capacity(hemicube::pixel_count(layout.resolution));
        self.gpu.check()?;
        for tile in 0..TILES_PER_HEMICUBE {
            let number = self.hemicubes.first(patch) + point as u64;
            let origin = layout.origin(number, tile);
            self.drawer.add(scene, own, frame, tile, origin);
            let mut encoder = self.gpu.encoder();
            self.drawer.draw(&self.gpu, &mut encoder);
            self.gpu.run(encoder)?;
            ids.extend(self.drawer.read(&self.gpu, origin)?);
        }
        Ok(ids)
    }

    /// Rows of at most as many patches as the merger takes in a batch.
    fn draw_batch(&mut self, patches: Range<u32>) -> Result<RowBatch, BackendError> {
        self.merger.start(&self.gpu, patches.len() as u32);
        for (row, patch) in (0..).zip(patches.clone()) {
            let patch = PatchId(patch);
            let scene = self.hemicubes.sources();
            let own = self.hemicubes.surface_of(patch);
            let frames = self.hemicubes.frames(patch);
            for (number, frame) in (self.hemicubes.first(patch)..).zip(&frames) {
                for tile in 0..TILES_PER_HEMICUBE {
                    if self.tiles.len() as u32 >= self.pace.tiles
                        || !self.drawer.has_room(scene, own)
                    {
                        self.submit(|_, _| {})?;
                    }
                    let origin = self.drawer.layout().origin(number, tile);
                    self.drawer.add(scene, own, frame, tile, origin);
                    let tile = self.merger.tile(origin, row, tile, frames.len() as u32);
                    self.tiles.push(tile);
                }
            }
        }
        self.submit(Merger::finish)?;
        self.merger.read(&self.gpu, patches)
    }

    /// Draws and sums the tiles collected so far, and does what the merger is to do then.
    fn submit(
        &mut self,
        then: impl FnOnce(&Merger, &mut wgpu::CommandEncoder),
    ) -> Result<(), BackendError> {
        let start = Instant::now();
        let mut encoder = self.gpu.encoder();
        self.drawer.draw(&self.gpu, &mut encoder);
        self.merger.add(&self.gpu, &mut encoder, &self.tiles);
        then(&self.merger, &mut encoder);
        self.gpu.run(encoder)?;
        self.pace.learn(self.tiles.len() as u32, start.elapsed());
        self.tiles.clear();
        Ok(())
    }
}

impl RowSource for GpuRows<'_> {
    fn draw_rows(&mut self, patches: Range<u32>) -> Result<RowBatch, BackendError> {
        self.gpu.check()?;
        let mut rows = RowBatch::new(patches.start);
        let mut start = patches.start;
        while start < patches.end {
            let end = patches
                .end
                .min(start.saturating_add(self.merger.max_rows()));
            let batch = self.draw_batch(start..end)?;
            if end - start == patches.len() as u32 {
                return Ok(batch);
            }
            rows.append(&batch);
            start = end;
        }
        Ok(rows)
    }

    /// A submission's worth of hemicubes; it grows from small as the adapter turns out to be fast.
    fn preferred_batch(&self) -> u32 {
        let patches = u64::from(self.hemicubes.receivers().patch_count().max(1));
        let hemicubes_per_row = self.hemicubes.total().div_ceil(patches) as u32;
        (self.pace.tiles / (TILES_PER_HEMICUBE as u32 * hemicubes_per_row))
            .clamp(1, self.merger.max_rows())
    }

    fn describe(&self) -> String {
        format!("gpu, {}", self.adapter())
    }
}

/// How many tiles go into a submission.
#[derive(Clone, Copy, Debug)]
struct Pace {
    tiles: u32,
    most: u32,
}

impl Pace {
    /// How long a submission should take. Watchdogs bite after 2 s and up; a desktop that shares
    /// the GPU stutters after a fraction of that; a tenth of a second makes any overhead small.
    const TARGET: Duration = Duration::from_millis(100);
    /// Hemicubes in the first submission, with nothing known about the adapter.
    const FIRST_HEMICUBES: u32 = 8;
    /// The most that one measurement makes submissions grow.
    const MAX_GROWTH: f64 = 4.0;

    fn new(most: u32) -> Self {
        let first = Self::FIRST_HEMICUBES * TILES_PER_HEMICUBE as u32;
        Self {
            tiles: first.min(most),
            most,
        }
    }

    /// Takes into account that a submission of that many tiles took that long.
    fn learn(&mut self, tiles: u32, duration: Duration) {
        let per_tile = duration.as_secs_f64() / f64::from(tiles.max(1));
        // A small submission says little of a large one.
        let most = (f64::from(tiles) * Self::MAX_GROWTH).max(self.tiles.into());
        let mut wanted = (Self::TARGET.as_secs_f64() / per_tile).min(most);
        if duration <= Self::TARGET {
            // A batch's last submission is a small one, and is mostly overhead.
            wanted = wanted.max(self.tiles.into());
        }
        self.tiles = (wanted as u32).clamp(1, self.most);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{FormFactorSettings, Points};
    use glam::{DVec3, Vec3};
    use scene::{Material, MaterialId, ObjectId, Scene, Surface};

    fn scene() -> Scene {
        let material = Material {
            name: "grey".into(),
            reflectance: Vec3::splat(0.5),
            emission: Vec3::ZERO,
        };
        let surface = |corners| Surface {
            corners,
            material: MaterialId(0),
            object: ObjectId(0),
        };
        let surfaces = vec![
            surface([Vec3::ZERO, Vec3::X, Vec3::Y]),
            surface([Vec3::Z, Vec3::Y + Vec3::Z, Vec3::X + Vec3::Z]),
        ];
        Scene::new(
            vec![material],
            vec!["two".into()],
            surfaces,
            &[4, 4],
            DVec3::ZERO,
        )
        .unwrap()
    }

    #[test]
    fn a_lost_device_is_an_error_from_then_on_and_no_panic() {
        let scene = scene();
        let settings = FormFactorSettings {
            points: Points::CENTROID,
            ..FormFactorSettings::new(20)
        };
        let hemicubes = Arc::new(Hemicubes::new(&scene, settings));
        let mut rows = match GpuRows::new(&hemicubes, AdapterChoice::Any) {
            Ok(rows) => rows,
            Err(BackendError::NoAdapter)
                if std::env::var_os("REQUIRE_GPU").is_none_or(|value| value != "1") =>
            {
                eprintln!("skipped: there is no GPU adapter");
                return;
            }
            Err(error) => panic!("{error}"),
        };
        assert_eq!(rows.draw_rows(0..4).unwrap().patches(), 0..4);
        rows.gpu.device.destroy();
        for _ in 0..3 {
            let lost = rows.draw_rows(4..8);
            assert!(
                matches!(lost, Err(BackendError::DeviceLost { .. })),
                "{lost:?}"
            );
        }
        let frame = hemicubes.frames(PatchId(0))[0];
        let lost = rows.item_buffer(PatchId(0), &frame);
        assert!(
            matches!(lost, Err(BackendError::DeviceLost { .. })),
            "{lost:?}"
        );
    }

    #[test]
    fn submissions_grow_towards_the_target_and_shrink_at_once() {
        let mut pace = Pace::new(1000);
        let per_tile = Pace::TARGET / 500;
        for _ in 0..5 {
            let before = pace.tiles;
            pace.learn(before, per_tile * before);
            assert!(f64::from(pace.tiles) <= f64::from(before) * Pace::MAX_GROWTH);
        }
        assert!((499..=500).contains(&pace.tiles), "{}", pace.tiles);
        // A last, small submission teaches nothing new.
        pace.learn(3, per_tile * 30);
        assert!((499..=500).contains(&pace.tiles), "{}", pace.tiles);
        pace.learn(500, Pace::TARGET * 100);
        assert_eq!(pace.tiles, 5);
        pace.learn(5, Pace::TARGET * 1000);
        assert_eq!(pace.tiles, 1);
        pace.learn(1, Duration::ZERO);
        assert_eq!(pace.tiles, 4);
        Pace::new(2).learn(2, Duration::ZERO);
    }
}
