//! What a run of the program did: the report, and its short form for people.

use std::path::Path;
use std::time::Duration;

use scene::{Scene, Solution};
use serde::Serialize;

use crate::backend::Trial;
use crate::certificate::Certificate;
use crate::energy::{Closure, Energy};
use crate::function::FunctionReport;
use crate::quantity::{show_duration, show_size};
use crate::settings::{SolutionSettings, SolveSettings};
use crate::solve::{Seconds, Solved, SourcesReport, StoppedBy};
use crate::solver::convergence::Convergence;
use crate::view_factors::ViewFactorsReport;

/// Everything about a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: &'static str,
    /// The scene.
    pub input: String,
    /// The result.
    pub output: String,
    /// What was asked for.
    pub settings: SettingsReport,
    /// Who drew.
    pub backend: BackendReport,
    /// Number of patches.
    pub patches: u32,
    /// Number of surfaces.
    pub surfaces: usize,
    /// Patches that no light can reach: they are dark, and their rows were neither needed nor drawn. 0 where all
    /// rows were asked for.
    pub unlit_patches: u32,
    /// Hemicubes drawn, those drawn again included.
    pub hemicubes_drawn: u64,
    /// The sources, where they are coarser than the patches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sources: Option<SourcesReport>,
    /// Form factors.
    pub rows: RowsReport,
    /// Seconds by stage.
    pub seconds: Seconds,
    /// Peak memory of the process, bytes; null where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Iterations the solution has had.
    pub iterations: u64,
    /// Of them, those before this run.
    pub iterations_before: u64,
    /// Share of the next iteration that is done, and kept for a run that goes on, 0 to 1.
    pub next_iteration_share: f64,
    /// Where the first iteration has not ended: the shots of the brightest patches whose light the result has to be seen, and from
    /// which no iteration goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start_up_shots: Option<u64>,
    /// Relative residual after each iteration that was done with these settings, dimensionless.
    pub residuals: Vec<f64>,
    /// What they tell of the way that is left; null where there are too few of them.
    pub convergence: Option<Convergence>,
    /// What a radiosity is likely to lack, over the patch's reflectance, W/m^2, by channel; shooting
    /// only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ambient_radiosity: Option<[f64; 3]>,
    /// Power balance.
    pub energy: Energy,
    /// Row sums; null where no row was drawn or read in this run.
    pub closure: Option<Closure>,
    /// Mean share of a hemisphere that sees back faces, by area; null as above.
    pub back_face_share: Option<f64>,
    /// What the form factors and the solution are worth.
    pub certificate: Certificate,
    /// What the irradiance function came to; null where none was asked for.
    pub function: Option<FunctionReport>,
    /// The names of the layers that the light was taken apart into; left out where none were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<Vec<String>>,
    /// How near view factors are; left out where no error was asked of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_factors: Option<ViewFactorsReport>,
    /// What the summary says of its error.
    #[serde(skip)]
    error_line: Option<String>,
    /// Why it ended.
    pub stopped_by: StoppedBy,
}

/// What was asked for.
#[derive(Clone, Debug, Serialize)]
pub struct SettingsReport {
    /// What decides the solution, each field one of this object.
    #[serde(flatten)]
    pub solution: SolutionSettings,
    /// Relative residual to stop at.
    pub tolerance: f64,
    /// Iterations to stop at.
    pub iterations: Option<u64>,
    /// Seconds to stop after.
    pub time_limit_seconds: Option<f64>,
    /// Threads.
    pub threads: usize,
    /// Budget of kept form factors.
    pub memory_bytes: u64,
    /// Whether a certificate beyond its tolerances is a failure.
    pub strict: bool,
}

/// Who drew.
#[derive(Clone, Debug, Serialize)]
pub struct BackendReport {
    /// `cpu` or `gpu`.
    pub name: &'static str,
    /// Threads, or the adapter's name.
    pub adapter: String,
    /// What the CPU and the GPU were compared by before one was taken; null where no GPU was tried.
    pub trial: Option<Trial>,
}

/// What became of the form factors.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RowsReport {
    /// Rows kept.
    pub kept: u64,
    /// Their memory, all of it counted.
    pub kept_bytes: u64,
    /// The same for each form factor that is not zero; null where no row is kept.
    pub bytes_per_entry: Option<f64>,
    /// Rows that were read from a file of an earlier run, or of this one, instead of drawn, each as often as it was read.
    pub read: u64,
}

/// Peak resident memory of this process, bytes, where the system tells (Linux).
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// The files of a run.
#[derive(Clone, Copy, Debug)]
pub struct Files<'a> {
    /// The scene.
    pub input: &'a Path,
    /// The result.
    pub output: &'a Path,
}

impl Report {
    /// The report of a run on the threads of the rayon pool it is called in.
    pub fn new(
        files: &Files,
        scene: &Scene,
        settings: &SolveSettings,
        strict: bool,
        solved: &Solved,
    ) -> Self {
        let solution = solved.solution();
        Self {
            version: env!("CARGO_PKG_VERSION"),
            input: files.input.display().to_string(),
            output: files.output.display().to_string(),
            settings: SettingsReport::new(settings, rayon::current_num_threads(), strict),
            backend: BackendReport {
                name: solved.backend,
                adapter: solved.adapter.clone(),
                trial: solved.trial,
            },
            patches: scene.patch_count(),
            surfaces: scene.surfaces().len(),
            unlit_patches: solved.unlit_patches,
            hemicubes_drawn: solved.rows.hemicubes,
            sources: solved.sources,
            rows: RowsReport {
                kept: solved.rows.kept_rows,
                kept_bytes: solved.rows.kept_bytes,
                bytes_per_entry: solved.rows.bytes_per_entry(),
                read: solved.rows.read_rows,
            },
            seconds: solved.seconds,
            peak_memory_bytes: peak_memory_bytes(),
            iterations: solution.provenance.iterations,
            iterations_before: solved.iterations_before,
            next_iteration_share: solution.next_iteration_share(),
            start_up_shots: Some(solution.provenance.start_up_shots).filter(|&shots| shots > 0),
            residuals: solution.provenance.residuals.clone(),
            convergence: solved.convergence,
            ambient_radiosity: solved.ambient_radiosity,
            energy: solved.energy,
            closure: solved.closure,
            back_face_share: solved.back_face_share,
            certificate: solved.certificate().clone(),
            function: solved.function,
            layers: settings.layers.map(|_| layer_names(solution)),
            view_factors: None,
            error_line: solved.function.map(|function| function.describe(scene)),
            stopped_by: solved.stopped_by,
        }
    }

    /// The same with how near view factors are, where an error was asked of them.
    #[must_use]
    pub fn with_view_factors(self, view_factors: Option<ViewFactorsReport>) -> Self {
        let line = view_factors.as_ref().map(ViewFactorsReport::describe);
        Self {
            view_factors,
            error_line: line.or(self.error_line),
            ..self
        }
    }

    /// Why the run counts as a failure though its result is written.
    pub fn strict_failure(&self) -> Option<String> {
        let mut violations = self.certificate.violations.clone();
        let is_unreached = self.function.is_some_and(|function| !function.is_reached)
            || self.view_factors.is_some_and(|factors| !factors.is_reached);
        let error = self.error_line.iter().filter(|_| is_unreached);
        violations.extend(error.map(|error| format!("its error is {error}")));
        (self.settings.strict && !violations.is_empty())
            .then(|| format!("{} is written, but {}", self.output, violations.join("; ")))
    }

    /// What a user should know of a result that is no failure.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        // Where they are failures they are told as such.
        if !self.settings.strict {
            warnings = self.certificate.warnings();
        }
        warnings.extend(self.not_converged());
        warnings
    }

    /// What is to be said where the residual has reached the tolerance, but the solution is far. Who set another limit
    /// knows that it is not converged.
    fn not_converged(&self) -> Option<String> {
        let convergence = self.convergence.as_ref()?;
        (self.stopped_by == StoppedBy::Tolerance)
            .then(|| convergence.warning(self.settings.tolerance))?
    }

    /// What became of the emitted power.
    fn power_lines(&self) -> Vec<String> {
        let [r, g, b] = self.energy.emitted_w;
        let mut lines = vec![format!(
            "emitted power  {:.6} W (red {r:.6}, green {g:.6}, blue {b:.6})",
            r + g + b
        )];
        if let Some(imbalance) = self.energy.imbalance {
            let sum = |w: Option<[f64; 3]>| w.map_or(0.0, |w| w.iter().sum());
            let share = |power: f64| 100.0 * power / (r + g + b);
            lines.push(format!(
                "power balance  absorbed {:.3} %, lost through openings {:.3} %, to back faces {:.3} %, imbalance {:.3} %",
                share(self.energy.absorbed_w.iter().sum()),
                share(sum(self.energy.lost_w)),
                share(sum(self.energy.back_faces_w)),
                100.0 * imbalance,
            ));
        }
        lines
    }

    /// A few lines for people.
    pub fn summary(&self) -> String {
        let mut lines = vec![
            format!("output         {}", self.output),
            format!(
                "scene          {} patches on {} surfaces",
                self.patches, self.surfaces
            ),
            format!(
                "back end       {} ({})",
                self.backend.name, self.backend.adapter
            ),
            format!(
                "time           {}: drawing {}, solving {}, files {}",
                show_duration(duration(self.seconds.total)),
                show_duration(duration(self.seconds.draw)),
                show_duration(duration(self.seconds.solve)),
                show_duration(duration(self.seconds.load + self.seconds.write)),
            ),
        ];
        if self.unlit_patches > 0 {
            lines.push(format!(
                "unlit          {} patches that no light can reach, not drawn",
                self.unlit_patches
            ));
        }
        if let Some(inside) = self.certificate.inside_patches.filter(|&inside| inside > 0) {
            lines.push(format!(
                "inside solids  {inside} patches, dark and left out of means and errors"
            ));
        }
        if self.hemicubes_drawn > 0 {
            lines.push(format!(
                "hemicubes      {} drawn, {:.0} a second; form factors take {}",
                self.hemicubes_drawn,
                self.hemicubes_drawn as f64 / self.seconds.draw.max(1e-9),
                show_size(self.rows.kept_bytes),
            ));
        }
        if self.rows.read > 0 {
            lines.push(format!(
                "rows           {} read from files instead of drawn",
                self.rows.read
            ));
        }
        lines.extend(self.power_lines());
        if let Some(closure) = self.closure {
            lines.push(format!(
                "row sums       {:.6} to {:.6}, mean {:.6}",
                closure.min, closure.max, closure.mean
            ));
        }
        lines.extend(self.sources.map(sources_line));
        lines.push(format!("certificate    {}", self.certificate.summary()));
        let residual = self
            .residuals
            .last()
            .map_or_else(|| "none".to_owned(), |residual| format!("{residual:.2e}"));
        if let Some(layers) = &self.layers {
            lines.push(if layers.is_empty() {
                "layers         none: what they are of came to no end, or patches gathered from coarser sources".to_owned()
            } else {
                format!("layers         {}: {}", layers.len(), layers.join(", "))
            });
        }
        if let Some(shots) = self.start_up_shots {
            lines.push(format!(
                "start-up       {shots} shots, to be seen until the first iteration ends"
            ));
        }
        let share = 100.0 * self.next_iteration_share;
        let next = if share > 0.0 {
            format!(" and {share:.1} % of the next")
        } else {
            String::new()
        };
        let error = self.convergence.map_or_else(String::new, |convergence| {
            format!(", estimated error {:.1e}", convergence.estimated_error)
        });
        let is_converged = self
            .residuals
            .last()
            .is_some_and(|&r| r <= self.settings.tolerance);
        let end = if self.stopped_by == StoppedBy::Interrupt && is_converged {
            "converged to the tolerance, then interrupted"
        } else if self.not_converged().is_some() {
            "converged to the tolerance, but not to the solution"
        } else {
            self.stopped_by.describe()
        };
        lines.push(format!(
            "result         {} iterations{next}, residual {residual}{error}, {end}",
            self.iterations,
        ));
        if let Some(error) = &self.error_line {
            lines.push(format!("error          {error}"));
        }
        lines.join("\n")
    }
}

fn layer_names(solution: &Solution) -> Vec<String> {
    let layers = solution.layers.iter().flat_map(|layers| &layers.layers);
    layers.map(|layer| layer.name.clone()).collect()
}

/// What was solved among, where it is coarser than the patches.
fn sources_line(sources: SourcesReport) -> String {
    let error = sources.estimated_error.map_or_else(String::new, |error| {
        format!(", which brings an error of about {:.2} %", 100.0 * error)
    });
    let gathered = sources.gathered_share.map_or_else(String::new, |share| {
        format!(
            "; {:.1} % of the patches have gathered from them",
            100.0 * share
        )
    });
    format!(
        "sources        {} of at most {:.3} m^2{error}{gathered}",
        sources.count, sources.max_area,
    )
}

fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or_default()
}

impl SettingsReport {
    /// The settings of a run on so many threads.
    pub fn new(settings: &SolveSettings, threads: usize, strict: bool) -> Self {
        Self {
            solution: settings.solution,
            tolerance: settings.tolerance,
            iterations: settings.max_iterations,
            time_limit_seconds: settings.time_limit.map(|limit| limit.as_secs_f64()),
            threads,
            memory_bytes: settings.drawing.memory_bytes,
            strict,
        }
    }
}
