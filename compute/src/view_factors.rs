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
//! # Practice
//! Units are summed as integers over B, in f64 over A in patch order, so threads and batches do not
//! change a bit. Only pairs with F_AB > 0 have a line; F_AA is one of them where A sees itself.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use scene::export::csv::quoted;
use scene::file::{FileError, write_atomically};
use scene::{ObjectId, Scene};

use crate::row_cache::RowCache;
use crate::rows::{Entry, UNITS_PER_ONE};

/// The first line.
pub const HEADER: &str = "from,to,view_factor,area_from,area_to,row_sum_from,reciprocity_error";

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
        }
    }

    /// Adds a patch's row.
    pub fn add(&mut self, from: u32, row: impl Iterator<Item = Entry> + Clone) {
        for entry in row.clone() {
            self.units[self.objects[entry.source as usize].index()] += f64::from(entry.units);
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
                    "{},{},{},{},{},{},{}",
                    quoted(scene.object(from)),
                    quoted(scene.object(to)),
                    self.view_factor(from, to),
                    self.area(from),
                    self.area(to),
                    self.row_sum(from),
                    self.reciprocity_error(from, to),
                )?;
            }
        }
        Ok(())
    }
}

/// Writes the view factors between all objects, drawing the rows that are not kept.
pub fn save(path: &Path, scene: &Scene, rows: &mut RowCache) -> Result<(), FileError> {
    write_atomically(path, |out| {
        let mut view_factors = ViewFactors::new(scene);
        rows.for_each_row(|from, row| {
            view_factors.add(from, row.into_iter());
            Ok(())
        })?;
        view_factors.write(out, scene)
    })
}
