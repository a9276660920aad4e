//! Which raster is the faster one, by a short race on a scene's own hemicubes.

use std::time::{Duration, Instant};

use visibility::hemicube::pixel_count;

use super::adapter::Gpu;
use super::atlas::TILES_PER_HEMICUBE;
use super::item_buffer::AtlasDrawer;
use super::raster::Raster;
use crate::hemicubes::Hemicubes;
use crate::receivers::ReceiverId;
use crate::rows::BackendError;

/// A race that takes the slower one so long is long enough: far more than what a submission costs by
/// itself.
const ENOUGH: Duration = Duration::from_millis(5);
/// Hemicubes in the first race.
const FIRST_HEMICUBES: u32 = 4;
/// How many times as many there are in the next.
const GROWTH: u32 = 4;
/// Pixels of a tile up to which races are held: one of larger tiles could take a slow adapter seconds.
const MOST_PIXELS: u32 = 1 << 20;

/// Pixels of a hemicube times surfaces of the scene up to which races are held: the compute shader may try all of
/// them, where the pipeline is sure to be the faster one.
const MOST_TESTS: u64 = 1 << 30;

/// The faster raster of those that the adapter offers, or its first where there is no telling.
pub fn fastest(
    gpu: &Gpu,
    drawer: &mut AtlasDrawer,
    hemicubes: &Hemicubes,
) -> Result<Raster, BackendError> {
    let offered = Raster::offered_by(gpu);
    let resolution = drawer.layout().resolution;
    let surfaces = hemicubes.sources().scene().surfaces().len() as u64;
    let tests = pixel_count(resolution) as u64 * surfaces;
    let is_any = hemicubes.receivers().count() > 0;
    if offered.len() == 1 || !is_any || resolution.pow(2) > MOST_PIXELS || tests > MOST_TESTS {
        return Ok(offered[0]);
    }
    // The first drawing is not timed: drivers put some things off until then.
    race(gpu, drawer, hemicubes, 1)?;
    let most = drawer.layout().tiles() / TILES_PER_HEMICUBE as u32;
    let mut count = FIRST_HEMICUBES;
    loop {
        let times = race(gpu, drawer, hemicubes, count)?;
        let slowest = times.iter().map(|(time, _)| *time).max();
        if count >= most || slowest >= Some(ENOUGH) {
            let fastest = times.into_iter().min_by_key(|(time, _)| *time);
            return Ok(fastest.map_or(offered[0], |(_, raster)| raster));
        }
        count *= GROWTH;
    }
}

/// How long each raster takes for so many hemicubes, or as many as there is room for.
fn race(
    gpu: &Gpu,
    drawer: &mut AtlasDrawer,
    hemicubes: &Hemicubes,
    count: u32,
) -> Result<Vec<(Duration, Raster)>, BackendError> {
    Raster::offered_by(gpu)
        .iter()
        .map(|&raster| {
            add_sample(drawer, hemicubes, count);
            let mut encoder = gpu.encoder();
            drawer.draw(gpu, &mut encoder, raster);
            let start = Instant::now();
            gpu.run(encoder)?;
            Ok((start.elapsed(), raster))
        })
        .collect()
}

/// Adds a hemicube on each of so many patches all over the scene.
fn add_sample(drawer: &mut AtlasDrawer, hemicubes: &Hemicubes, count: u32) {
    let scene = hemicubes.sources().scene();
    let receivers = hemicubes.receivers();
    let rows = u64::from(receivers.count());
    for k in 0..u64::from(count) {
        let receiver = ReceiverId((k * rows / u64::from(count)) as u32);
        let own = receivers.surface(receiver);
        let frame = &receivers.frames(receiver)[0];
        for tile in 0..TILES_PER_HEMICUBE {
            if !drawer.has_room(scene, own, frame) {
                return;
            }
            let origin = drawer.layout().origin(k, tile);
            drawer.add(scene, own, frame, tile, origin);
        }
    }
}
