//! Measuring a case by what a run is made of.

use scene::{Rgb, Scene, Solution};

use super::case::{Case, Measure};
use super::{VerifyError, dense, path_tracer};
use crate::Solve;
use crate::compact_rows::Row;
use crate::form_factors::{FormFactors, Needed};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;
use crate::settings::{
    BackendChoice, Drawing, FormFactorSettings, SolutionSettings, SolveSettings, SolverChoice,
};

/// What came out, and what should have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The right value.
    pub expected: f64,
    /// The value that came out.
    pub computed: f64,
}

impl Measured {
    /// Departure from the expected value: relative, or absolute where that is 0. Dimensionless.
    pub fn error(&self) -> f64 {
        let difference = (self.computed - self.expected).abs();
        if self.expected == 0.0 {
            difference
        } else {
            difference / self.expected.abs()
        }
    }
}

/// Residual at which a dense solve is compared.
const DENSE_RESIDUAL: f64 = 1e-7;

/// Residual of a room that is solved for its light, as by default in a run.
const ROOM_RESIDUAL: f64 = 1e-5;

/// Residual of a furnace, before it grows by 1 / (1 - rho).
const FURNACE_RESIDUAL: f64 = 1e-6;

/// Far more than any case needs; a solver that does not get there is reported by its error.
const MOST_ITERATIONS: u64 = 100_000;

/// Irradiances of rooms that were solved before, W/m^2: a room has several cases.
#[derive(Debug, Default)]
pub struct Solved(Vec<(SolvedRoom, Vec<Rgb>)>);

/// A room, and how it was solved.
type SolvedRoom = (&'static str, FormFactorSettings, BackendChoice);

impl Solved {
    fn get_or_solve(
        &mut self,
        key: SolvedRoom,
        solve: impl FnOnce() -> Result<Solution, VerifyError>,
    ) -> Result<&[Rgb], VerifyError> {
        let known = self.0.iter().position(|(room, _)| *room == key);
        let index = if let Some(index) = known {
            index
        } else {
            self.0.push((key, solve()?.irradiance));
            self.0.len() - 1
        };
        Ok(&self.0[index].1)
    }
}

/// The run whose solution, or whose form factors, a case measures.
pub fn run_of(
    case: &Case,
    form_factors: FormFactorSettings,
    backend: BackendChoice,
) -> SolveSettings {
    let no_more = SolveSettings::default().tolerance;
    let (solver, tolerance, iterations) = match case.measure {
        Measure::FormFactor { .. } | Measure::Closure => (SolverChoice::Jacobi, no_more, 0),
        Measure::Irradiance { .. } => (SolverChoice::Jacobi, no_more, 1),
        Measure::Radiosity => {
            // Grows by 1 / (1 - rho), which is what is expected.
            let residual = FURNACE_RESIDUAL / case.expected.value();
            (SolverChoice::Jacobi, residual, MOST_ITERATIONS)
        }
        Measure::Reflected { .. } => (SolverChoice::Jacobi, ROOM_RESIDUAL, MOST_ITERATIONS),
        Measure::DenseSolve { solver } => (solver, DENSE_RESIDUAL, MOST_ITERATIONS),
    };
    SolveSettings {
        solution: SolutionSettings {
            form_factors,
            solver,
            ..SolutionSettings::default()
        },
        drawing: Drawing {
            backend,
            // What its rows are worth is what comes out.
            is_gpu_tried: false,
            ..Drawing::default()
        },
        max_iterations: Some(iterations),
        tolerance,
        ..SolveSettings::default()
    }
}

/// Measures one case. Also says who made the rows: `cpu`, `gpu` or `formula`.
pub fn measure(
    case: &Case,
    settings: FormFactorSettings,
    choice: BackendChoice,
    solved: &mut Solved,
) -> Result<(Measured, &'static str), VerifyError> {
    let scene = case.scene.build()?;
    let run = run_of(case, settings, choice);
    let form_factors = FormFactors::new(&scene, settings, run.drawing);
    let mut bench = Bench {
        scene: &scene,
        run,
        rows: form_factors.rows(Needed::All)?,
    };
    let measured = bench.measure(case, |room| (room, settings, choice), solved)?;
    let backend = if bench.rows.has_hemicubes() {
        bench.rows.backend()
    } else {
        "formula"
    };
    Ok((measured, backend))
}

/// A scene and its rows.
struct Bench<'a> {
    scene: &'a Scene,
    run: SolveSettings,
    rows: RowCache<'a>,
}

impl Bench<'_> {
    fn measure(
        &mut self,
        case: &Case,
        key: impl Fn(&'static str) -> SolvedRoom,
        solved: &mut Solved,
    ) -> Result<Measured, VerifyError> {
        let expected = case.expected.value();
        let known = |computed| Measured { expected, computed };
        let farthest = |values: Vec<f64>| {
            let off = |value: &f64| (value - expected).abs();
            let found = values.into_iter().max_by(|a, b| off(a).total_cmp(&off(b)));
            known(found.unwrap_or(f64::NAN))
        };
        Ok(match &case.measure {
            &Measure::FormFactor { from, to } => known(self.form_factor(from, to)?),
            &Measure::Irradiance { of } => known(self.irradiance(of)?),
            Measure::Closure => farthest(self.row_sums()?),
            Measure::Radiosity => {
                let solved = self.radiosity()?;
                farthest(solved.into_iter().map(|b| f64::from(b.x)).collect())
            }
            &Measure::Reflected {
                room,
                ref reference,
                statistic,
            } => {
                let irradiance = solved.get_or_solve(key(room), || self.solution())?;
                let problem = Problem::new(self.scene);
                known(path_tracer::statistic(
                    statistic, &problem, irradiance, reference,
                ))
            }
            &Measure::DenseSolve { solver } => self.dense_solve(solver)?,
        })
    }

    /// Hands the rows of consecutive patches to `each`.
    fn each_row(
        &mut self,
        patches: std::ops::Range<u32>,
        mut each: impl FnMut(u32, Row),
    ) -> Result<(), VerifyError> {
        let mut patch = patches.start;
        while patch < patches.end {
            let batch = self.rows.batch_with(patch)?;
            let drawn = batch.receivers();
            for i in patch..drawn.end.min(patches.end) {
                each(i, batch.row((i - drawn.start) as usize));
            }
            patch = drawn.end;
        }
        Ok(())
    }

    /// Runs of the patches of an object, in order.
    fn patches_of(&self, object: &str) -> Vec<std::ops::Range<u32>> {
        let mut runs: Vec<std::ops::Range<u32>> = Vec::new();
        for (surface, tree) in self.scene.surfaces().iter().zip(self.scene.mesh().trees()) {
            if self.scene.object(surface.object) != object {
                continue;
            }
            let patches = tree.patches();
            match runs.last_mut() {
                Some(last) if last.end == patches.start => last.end = patches.end,
                _ => runs.push(patches),
            }
        }
        runs
    }

    /// sum_i A_i sum_j F_ij / sum_i A_i over the patches i of `from` and j of `to`.
    fn form_factor(&mut self, from: &str, to: &str) -> Result<f64, VerifyError> {
        let areas = self.scene.patch_areas();
        let mut is_target = vec![false; areas.len()];
        for run in self.patches_of(to) {
            is_target[run.start as usize..run.end as usize].fill(true);
        }
        let (mut weighted, mut area) = (0.0, 0.0);
        for run in self.patches_of(from) {
            self.each_row(run, |i, row| {
                let units: f64 = row
                    .into_iter()
                    .filter(|entry| is_target[entry.source as usize])
                    .map(|entry| f64::from(entry.units))
                    .sum();
                weighted += areas[i as usize] * units;
                area += areas[i as usize];
            })?;
        }
        Ok(weighted / area / f64::from(UNITS_PER_ONE))
    }

    /// Mean irradiance of an object after one iteration, first channel, W/m^2.
    fn irradiance(&self, of: &str) -> Result<f64, VerifyError> {
        let solution = self.solution()?;
        let areas = self.scene.patch_areas();
        let patches = || {
            self.patches_of(of)
                .into_iter()
                .flatten()
                .map(|i| i as usize)
        };
        let received: f64 = patches()
            .map(|i| areas[i] * f64::from(solution.irradiance[i].x))
            .sum();
        let area: f64 = patches().map(|i| areas[i]).sum();
        Ok(received / area)
    }

    /// One per patch, dimensionless.
    fn row_sums(&mut self) -> Result<Vec<f64>, VerifyError> {
        let mut sums = Vec::new();
        self.each_row(0..self.scene.patch_count(), |_, row| {
            let units: f64 = row.into_iter().map(|entry| f64::from(entry.units)).sum();
            sums.push(units / f64::from(UNITS_PER_ONE));
        })?;
        Ok(sums)
    }

    /// What the run comes to.
    fn solution(&self) -> Result<Solution, VerifyError> {
        let solved = Solve::new(self.scene).settings(self.run).run()?;
        Ok(solved.into_solution())
    }

    /// Radiosities, W/m^2, one per patch.
    fn radiosity(&self) -> Result<Vec<Rgb>, VerifyError> {
        Ok(self.solution()?.radiosity(self.scene))
    }

    /// The patch and channel in which a solver is farthest from the dense solution, relatively.
    fn dense_solve(&mut self, choice: SolverChoice) -> Result<Measured, VerifyError> {
        let solved = self.radiosity()?;
        let problem = Problem::new(self.scene);
        let n = problem.patch_count();
        // What patch i gathers from patch j, dimensionless.
        let mut gathered = vec![vec![0.0; n]; n];
        self.each_row(0..n as u32, |i, row| {
            let i = i as usize;
            for entry in row {
                let (j, factor) = (
                    entry.source as usize,
                    f64::from(entry.units) / f64::from(UNITS_PER_ONE),
                );
                if choice == SolverChoice::Shooting {
                    gathered[j][i] = factor * problem.areas[i] / problem.areas[j];
                } else {
                    gathered[i][j] = factor;
                }
            }
        })?;
        let mut worst = Measured {
            expected: 1.0,
            computed: 1.0,
        };
        for channel in 0..3 {
            let matrix = (0..n)
                .map(|i| {
                    let rho = f64::from(problem.reflectance[i][channel]);
                    let mut row: Vec<f64> = gathered[i].iter().map(|f| -rho * f).collect();
                    row[i] += 1.0;
                    row
                })
                .collect();
            let emission = problem.emission.iter().map(|e| f64::from(e[channel]));
            let exact = dense::solve(matrix, emission.collect());
            for (&expected, radiosity) in exact.iter().zip(&solved) {
                let here = Measured {
                    expected,
                    computed: f64::from(radiosity[channel]),
                };
                if here.error() >= worst.error() {
                    worst = here;
                }
            }
        }
        Ok(worst)
    }
}
