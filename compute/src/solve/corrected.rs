//! Solving once more where it is known better what sources receive.
//!
//! # Theory
//! A source's row says what arrives at some of its points, which is not what it receives on the mean, M(B), where light varies:
//! beside a lamp, across a shadow. M is known by the function that is gathered from the sources, but dearly. So the equation is
//! solved with the rows F and the defect that they had before, B' (Stetter, "The defect correction principle and
//! discretization methods", Numerische Mathematik 29, 1978):
//!
//! B = E + rho (F B + M(B') - F B'),
//!
//! which is that of M where B = B'.

use scene::layers::LayerKind;
use scene::{Provenance, Rgb, Scene, Solution, State};

use super::layers;
use crate::compact_rows::Row;
use crate::function::{Receives, Resolve, SourceLayer};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::BackendError;
use crate::solver::{Gather, Solver, Update};

/// Iterations are enough where the residual is as small as the tolerance or this, or when they are so many.
const LEAST_RESIDUAL: f64 = 1e-6;
const MOST_ITERATIONS: u64 = 200;

/// The equation among sources, and its solution.
pub(super) struct Corrected<'r, 'a> {
    rows: &'r mut RowCache<'a>,
    problem: Problem,
    /// W/m^2, one per source.
    irradiance: Vec<Rgb>,
    /// Of the relative residual.
    tolerance: f64,
    /// What the light is to be taken apart into.
    layers: Option<LayerKind>,
}

impl<'r, 'a> Corrected<'r, 'a> {
    /// Sources that receive this, W/m^2, with their rows to each other. `tolerance` is that of the relative residual.
    pub fn new(rows: &'r mut RowCache<'a>, irradiance: Vec<Rgb>, tolerance: f64) -> Self {
        Self {
            problem: Problem::new(rows.sources().scene()),
            rows,
            irradiance,
            tolerance: tolerance.max(LEAST_RESIDUAL),
            layers: None,
        }
    }

    /// The same, whose light is to be taken apart into these.
    #[must_use]
    pub fn with_layers(self, layers: Option<LayerKind>) -> Self {
        Self { layers, ..self }
    }

    /// What sources receive after so many iterations, or where they do not change any more; `None` where it is cancelled.
    fn iterate(
        &mut self,
        update: Update,
        besides: Vec<Rgb>,
        most: u64,
    ) -> Result<Option<Vec<Rgb>>, BackendError> {
        let gather = gather_from(self.problem.clone(), update, self.irradiance.clone());
        let gather = gather.with_besides(besides);
        self.run(gather, most)
    }

    /// Lets a solver iterate so many times, or until nothing changes any more; `None` where it is cancelled.
    pub(super) fn run(
        &mut self,
        mut gather: Gather,
        most: u64,
    ) -> Result<Option<Vec<Rgb>>, BackendError> {
        while gather.iterations() < most
            && gather
                .residual()
                .is_none_or(|residual| residual > self.tolerance)
        {
            if self.rows.cancel().is_cancelled() {
                return Ok(None);
            }
            gather.step(self.rows)?;
        }
        Ok(Some(gather.snapshot().irradiance))
    }

    /// The scene whose patches the sources are.
    pub(super) fn sources(&self) -> &Scene {
        self.rows.sources().scene()
    }

    /// The equation's known quantities, one per source.
    pub(super) fn problem(&self) -> &Problem {
        &self.problem
    }

    /// What sources receive, W/m^2, one per source.
    pub(super) fn irradiance(&self) -> &[Rgb] {
        &self.irradiance
    }
}

/// A solver that goes on from these irradiances, W/m^2.
pub(super) fn gather_from(problem: Problem, update: Update, irradiance: Vec<Rgb>) -> Gather {
    let start = Solution {
        irradiance,
        provenance: Provenance::default(),
        state: State::AtRest,
        function: None,
        layers: None,
    };
    Gather::new(problem, update, start)
}

impl Resolve for Corrected<'_, '_> {
    fn resolve(&mut self, known: &[Receives]) -> Result<Option<Vec<Rgb>>, BackendError> {
        let by_rows = if known
            .iter()
            .any(|known| matches!(known, Receives::OnTheMean(_)))
        {
            self.iterate(Update::AfterIteration, Vec::new(), 1)?
        } else {
            Some(self.irradiance.clone())
        };
        let Some(by_rows) = by_rows else {
            return Ok(None);
        };
        let defect = |(known, by_row): (&Receives, &Rgb)| match known {
            Receives::OnTheMean(mean) => (*mean - by_row.as_dvec3()).as_vec3(),
            Receives::BesidesItsRow(more) => more.as_vec3(),
        };
        let besides = known.iter().zip(&by_rows).map(defect).collect();
        let Some(irradiance) = self.iterate(Update::AtOnce, besides, MOST_ITERATIONS)? else {
            return Ok(None);
        };
        self.irradiance = irradiance;
        Ok(Some(self.irradiance.clone()))
    }

    fn layers(&mut self) -> Result<Option<Vec<SourceLayer>>, BackendError> {
        match self.layers {
            None => Ok(None),
            Some(kind) => layers::of(self, kind),
        }
    }

    fn for_each_row(&mut self, take: &mut dyn FnMut(usize, Row)) -> Result<bool, BackendError> {
        let unlit = self.rows.unlit().to_vec();
        let mut source = 0;
        while source < unlit.len() {
            if unlit[source] {
                source += 1;
                continue;
            }
            if self.rows.cancel().is_cancelled() {
                return Ok(false);
            }
            let batch = self.rows.batch_with(source as u32)?;
            let [start, end] = [batch.receivers().start, batch.receivers().end].map(|k| k as usize);
            for k in (source..end).filter(|&k| !unlit[k]) {
                take(k, batch.row(k - start));
            }
            source = end;
        }
        Ok(true)
    }
}

/// Who leaves it at what was solved.
pub(super) struct Uncorrected;

impl Resolve for Uncorrected {
    fn resolve(&mut self, _: &[Receives]) -> Result<Option<Vec<Rgb>>, BackendError> {
        Ok(None)
    }

    fn layers(&mut self) -> Result<Option<Vec<SourceLayer>>, BackendError> {
        Ok(None)
    }

    fn for_each_row(&mut self, _: &mut dyn FnMut(usize, Row)) -> Result<bool, BackendError> {
        Ok(false)
    }
}
