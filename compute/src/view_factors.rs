//! View factors between the scene's objects, as text.
//!
//! # Theory
//! The view factor of object A to object B is the fraction of the power that leaves A's fronts, where
//! all of A has the same radiosity, that arrives at B: the mean of A's form factors by area,
//!
//! F_AB = (sum_(i in A) A_i sum_(j in B) F_ij) / A_A,  A_A = sum_(i in A) A_i
//!
//! (Siegel and Howell, "Thermal radiation heat transfer", on finite areas). Exact ones are
//! reciprocal, A_A F_AB = A_B F_BA. Here both sides are sampled on their own, from A's hemicubes and
//! from B's, so their difference shows how good the sampling is.
//!
//! # Error
//! What both sides get wrong alike does not show in that difference. So some of A's patches are looked at more closely
//! ([`FormFactors::closer`]); F_iB then differs by d_i, the error of the patch's row but for a little. For the mean d and the variance
//! v of these m out of A's N patches, by area, the error of F_AB is
//!
//! sqrt(max(d^2 - v/m (1 - m/N), v/N)),
//!
//! the square of d less what comes from choosing m of them, and at least what independent errors come to.
//!
//! All of them together are off by the root mean square of these errors, each weighed by A's area, over that of the view factors:
//!
//! sqrt(sum_A A_A sum_B e_AB^2 / sum_A A_A sum_B F_AB^2).
//!
//! # Practice
//! Units are summed as integers over B, in f64 over A in patch order, so threads and batches do not
//! change a bit. Only pairs with F_AB > 0 have a line; F_AA is one of them where A sees itself.

mod as_near;

pub use as_near::{AsNear, Asked, ViewFactorsEnd, ViewFactorsReport, as_near_as};

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use scene::export::csv::quoted;
use scene::file::{FileError, write_atomically};
use scene::{ObjectId, PatchId, Scene};

use crate::FormFactors;
use crate::form_factors::Closely;
use crate::receivers::mixed;
use crate::row_cache::RowCache;
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};

/// The first line.
pub const HEADER: &str =
    "from,to,view_factor,area_from,area_to,row_sum_from,reciprocity_error,error";

/// Of an object's patches one in so many is looked at more closely, but so many at least and at most.
const CLOSER_EVERY: usize = 32;
const FEWEST_CLOSER: usize = 8;
const MOST_CLOSER: usize = 64;

/// View factors between objects, as far as rows were added.
#[derive(Clone, Debug)]
pub struct ViewFactors {
    /// One per patch.
    objects: Vec<ObjectId>,
    /// m^2, one per patch.
    patch_areas: Vec<f64>,
    /// m^2, one per object.
    areas: Vec<f64>,
    /// A_A F_AB in m^2 by B, one map per object A.
    exchange_areas: Vec<BTreeMap<u32, f64>>,
    /// Of the row being added, one per object.
    units: Vec<f64>,
    /// Patches that are to be looked at more closely, ascending, and their view factors by object.
    chosen: Vec<(PatchId, BTreeMap<u32, f64>)>,
    /// By A and B; empty before some were.
    errors: BTreeMap<(u32, u32), f64>,
}

/// Differences of some patches' view factors to one object.
#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    /// Sums over patches, by area: of areas, differences, and their squares.
    area: f64,
    sum: f64,
    squares: f64,
    count: f64,
}

impl ViewFactors {
    /// No rows yet.
    pub fn new(scene: &Scene) -> Self {
        let count = scene.objects().len();
        let mut objects = Vec::with_capacity(scene.patch_count() as usize);
        for (surface, tree) in scene.surfaces().iter().zip(scene.mesh().trees()) {
            objects.extend(tree.patches().map(|_| surface.object));
        }
        let patch_areas = scene.patch_areas();
        let mut areas = vec![0.0; count];
        for (object, area) in objects.iter().zip(&patch_areas) {
            areas[object.index()] += area;
        }
        Self {
            objects,
            patch_areas,
            areas,
            exchange_areas: vec![BTreeMap::new(); count],
            units: vec![0.0; count],
            chosen: Vec::new(),
            errors: BTreeMap::new(),
        }
    }

    /// Chooses patches that are to be looked at more closely, before any row is added: of each object one by chance in each of equal
    /// runs. One in the same place of each would be one in the same place of each surface's tree, and might never be at a rim.
    fn choose(&mut self) {
        let mut patches: Vec<Vec<u32>> = vec![Vec::new(); self.areas.len()];
        for (patch, object) in (0..).zip(&self.objects) {
            patches[object.index()].push(patch);
        }
        let mut chosen = Vec::new();
        for patches in patches {
            let count = patches.len().div_ceil(CLOSER_EVERY);
            let count = count.clamp(FEWEST_CLOSER, MOST_CLOSER).min(patches.len());
            let starts = (0..=count).map(|k| k * patches.len() / count);
            let starts: Vec<usize> = starts.collect();
            let runs = starts.windows(2).map(|ends| &patches[ends[0]..ends[1]]);
            let one = |run: &[u32]| run[mixed(u64::from(run[0])) as usize % run.len()];
            chosen.extend(runs.map(|run| (PatchId(one(run)), BTreeMap::new())));
        }
        chosen.sort_by_key(|&(patch, _)| patch);
        self.chosen = chosen;
    }

    /// View factors of a row by object.
    fn by_object(&self, row: impl Iterator<Item = Entry>) -> BTreeMap<u32, f64> {
        let mut by_object = BTreeMap::new();
        for entry in row {
            let to = self.objects[entry.source as usize];
            *by_object.entry(to.0).or_default() +=
                f64::from(entry.units) / f64::from(UNITS_PER_ONE);
        }
        by_object
    }

    /// The errors of view factors by A and B, as the chosen patches tell that are looked at more closely.
    fn errors_by(
        &self,
        form_factors: &FormFactors,
        closely: Closely,
    ) -> Result<BTreeMap<(u32, u32), f64>, BackendError> {
        let chosen = self.chosen.iter().map(|&(patch, _)| patch).collect();
        let mut backend = form_factors.closer(chosen, closely)?;
        let mut differences: BTreeMap<(u32, u32), Differences> = BTreeMap::new();
        let mut counts = vec![0.0; self.areas.len()];
        let mut next: u32 = 0;
        while (next as usize) < self.chosen.len() {
            let batch = backend.source.preferred_batch().max(1);
            let end = (self.chosen.len() as u32).min(next.saturating_add(batch));
            let rows = backend.source.draw_rows(next..end)?;
            for k in next..end {
                let (patch, before) = &self.chosen[k as usize];
                let row = rows.row((k - next) as usize).iter().copied();
                let closer = self.by_object(row);
                let from = self.objects[patch.index()];
                let area = self.patch_areas[patch.index()];
                counts[from.index()] += 1.0;
                for to in 0..self.areas.len() as u32 {
                    let [closer, before] = [&closer, before].map(|of| of.get(&to).unwrap_or(&0.0));
                    let all = differences.entry((from.0, to)).or_default();
                    all.area += area;
                    all.sum += area * (closer - before);
                    all.squares += area * (closer - before).powi(2);
                    all.count += 1.0;
                }
            }
            next = end;
        }
        let mut patches = vec![0.0; self.areas.len()];
        for object in &self.objects {
            patches[object.index()] += 1.0;
        }
        let error = |((from, to), all): ((u32, u32), Differences)| {
            ((from, to), all.error(patches[from as usize]))
        };
        Ok(differences.into_iter().map(error).collect())
    }

    /// How much view factors are others than these, by A and B.
    fn changes(&self, before: &Self) -> BTreeMap<(u32, u32), f64> {
        let count = self.areas.len() as u32;
        let pairs = (0..count).flat_map(|from| (0..count).map(move |to| (from, to)));
        let change = |(from, to): (u32, u32)| {
            let [now, before] =
                [self, before].map(|of| of.view_factor(ObjectId(from), ObjectId(to)));
            ((from, to), (now - before).abs())
        };
        pairs.map(change).collect()
    }

    /// What such errors come to together, relative.
    fn mean_error(&self, errors: &BTreeMap<(u32, u32), f64>) -> f64 {
        let area = |from: u32| self.areas[from as usize];
        let wrong = errors
            .iter()
            .map(|(&(from, _), error)| area(from) * error * error);
        let rows = (0..).zip(&self.exchange_areas);
        let right = rows.flat_map(|(from, to)| {
            let exchanged = to.values().map(move |exchange_area| exchange_area.powi(2));
            exchanged.map(move |square| square / area(from))
        });
        let right: f64 = right.sum();
        if right > 0.0 {
            (wrong.sum::<f64>() / right).sqrt()
        } else {
            0.0
        }
    }

    /// The estimate of the error of F_AB, over F_AB; `None` where nothing was looked at more closely.
    pub fn error(&self, from: ObjectId, to: ObjectId) -> Option<f64> {
        let error = self.errors.get(&(from.0, to.0))?;
        Some(error / self.view_factor(from, to))
    }

    /// Adds a patch's row.
    pub fn add(&mut self, from: u32, row: impl Iterator<Item = Entry> + Clone) {
        for entry in row.clone() {
            self.units[self.objects[entry.source as usize].index()] += f64::from(entry.units);
        }
        let chosen = self
            .chosen
            .binary_search_by_key(&from, |(patch, _)| patch.0);
        if let Ok(k) = chosen {
            self.chosen[k].1 = self.by_object(row.clone());
        }
        let area = self.patch_areas[from as usize];
        let exchange_areas = &mut self.exchange_areas[self.objects[from as usize].index()];
        for entry in row {
            let to = self.objects[entry.source as usize];
            let units = std::mem::take(&mut self.units[to.index()]);
            if units > 0.0 {
                *exchange_areas.entry(to.0).or_default() +=
                    area * (units / f64::from(UNITS_PER_ONE));
            }
        }
    }

    /// Area of an object, m^2.
    pub fn area(&self, object: ObjectId) -> f64 {
        self.areas[object.index()]
    }

    /// F_AB of A = `from` and B = `to`, dimensionless.
    pub fn view_factor(&self, from: ObjectId, to: ObjectId) -> f64 {
        let exchange_area = self.exchange_area(from, to);
        if exchange_area > 0.0 {
            exchange_area / self.areas[from.index()]
        } else {
            0.0
        }
    }

    /// Sum of F_AB over all B, dimensionless.
    pub fn row_sum(&self, from: ObjectId) -> f64 {
        let sum: f64 = self.exchange_areas[from.index()].values().sum();
        sum / self.areas[from.index()]
    }

    /// |A_A F_AB - A_B F_BA| over the larger of the two, dimensionless.
    pub fn reciprocity_error(&self, a: ObjectId, b: ObjectId) -> f64 {
        let (there, back) = (self.exchange_area(a, b), self.exchange_area(b, a));
        let larger = there.max(back);
        if larger > 0.0 {
            (there - back).abs() / larger
        } else {
            0.0
        }
    }

    /// A_A F_AB, m^2.
    fn exchange_area(&self, from: ObjectId, to: ObjectId) -> f64 {
        self.exchange_areas[from.index()]
            .get(&to.0)
            .copied()
            .unwrap_or(0.0)
    }

    /// Writes a line for each ordered pair with a view factor that is not zero, in the scene's order
    /// of objects.
    fn write(&self, out: &mut dyn Write, scene: &Scene) -> std::io::Result<()> {
        writeln!(out, "{HEADER}")?;
        for (from, to) in self.exchange_areas.iter().enumerate() {
            let from = ObjectId(from as u32);
            for &to in to.keys() {
                let to = ObjectId(to);
                writeln!(
                    out,
                    "{},{},{},{},{},{},{},{}",
                    quoted(scene.object(from)),
                    quoted(scene.object(to)),
                    self.view_factor(from, to),
                    self.area(from),
                    self.area(to),
                    self.row_sum(from),
                    self.reciprocity_error(from, to),
                    self.error(from, to)
                        .map_or_else(String::new, |error| error.to_string()),
                )?;
            }
        }
        Ok(())
    }
}

impl Differences {
    /// What the view factor of an object of so many patches is off by.
    fn error(self, patches: f64) -> f64 {
        let mean = self.sum / self.area;
        let variance = (self.squares / self.area - mean * mean).max(0.0);
        let by_choice = variance / self.count * (1.0 - self.count / patches);
        let least = if self.count < patches {
            variance / patches
        } else {
            0.0
        };
        (mean * mean - by_choice).max(least).sqrt()
    }
}

/// The view factors between all objects, with their errors, by these rows of `form_factors`. Those that are not kept are drawn.
///
/// # Errors
/// What a back end says; [`std::io::ErrorKind::Interrupted`] where it is cancelled.
pub fn view_factors(
    scene: &Scene,
    form_factors: &FormFactors,
    rows: &mut RowCache,
) -> std::io::Result<ViewFactors> {
    let mut view_factors = ViewFactors::new(scene);
    view_factors.choose();
    rows.for_each_row(|from, row| {
        view_factors.add(from, row.into_iter());
        Ok(())
    })?;
    let errors = view_factors.errors_by(form_factors, Closely::PointsAndPixels);
    view_factors.errors = errors.map_err(std::io::Error::other)?;
    Ok(view_factors)
}

/// Writes view factors between all objects.
///
/// # Errors
/// A file that cannot be written.
pub fn save(path: &Path, scene: &Scene, view_factors: &ViewFactors) -> Result<(), FileError> {
    write_atomically(path, |out| view_factors.write(out, scene))
}
