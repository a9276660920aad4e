//! `compute gather`: a table of sensors in, the same table with what they receive out.

mod table;

use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Context, bail};
use scene::file::{self, OutputLock, write_atomically};

use super::{GatherSettings, interrupt};
use crate::FormFactors;
use crate::cancel::CancelToken;
use crate::gather::{Gathering, Received};
use crate::quantity::show_duration;
use crate::settings::Drawing;
use table::Table;

/// Share of backs from which on a sensor counts as inside of something.
const INSIDE: f64 = 0.5;

/// Does what was asked for, and says what it has come to.
///
/// # Errors
/// Files that cannot be read or written, a scene that is not solved, a table that has no sensors. Then nothing is
/// written.
pub fn gather(settings: &GatherSettings, cancel: &CancelToken) -> anyhow::Result<ExitCode> {
    let _lock = OutputLock::acquire(&settings.output)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads.unwrap_or(0))
        .build()
        .context("the threads could not be started")?;
    pool.install(|| gather_all(settings, cancel))
}

fn gather_all(settings: &GatherSettings, cancel: &CancelToken) -> anyhow::Result<ExitCode> {
    let start = Instant::now();
    let (scene, solution) = file::load(&settings.solved)?;
    let Some(solution) = solution else {
        let solved = settings.solved.display();
        bail!("{solved}: the scene is not solved; solve it first: compute {solved} OUT");
    };
    let table = Table::read(&settings.sensors, &scene)?;
    let drawing = Drawing {
        backend: settings.backend,
        ..Drawing::default()
    };
    let form_factors = FormFactors::new(&scene, settings.form_factors, drawing).drawn_as(&solution);
    let mut gathering = Gathering::new(&form_factors, &solution, table.sensors())?;
    if let Some(remark) = gathering.remark() {
        eprintln!("compute: {remark}");
    }
    let mut received: Vec<Received> = Vec::with_capacity(table.sensors().len());
    loop {
        if cancel.is_cancelled() {
            eprintln!("compute: interrupted; nothing is written");
            return Ok(ExitCode::from(interrupt::EXIT_CODE));
        }
        let next = gathering.step()?;
        if next.is_empty() {
            break;
        }
        received.extend(next);
    }
    write_atomically(&settings.output, |out| table.write(out, &received))?;
    let inside = received.iter().filter(|r| r.back_faces > INSIDE).count();
    if inside > 0 {
        eprintln!(
            "compute: warning: {inside} of {} sensors see more backs of surfaces than fronts: they are inside of \
             something, or behind it",
            received.len()
        );
    }
    // The result is written: a reader that has gone away is no failure.
    writeln!(
        std::io::stdout(),
        "output         {}\nsensors        {}, {} of them on surfaces\nback end       {}\ntime           {}",
        settings.output.display(),
        received.len(),
        gathering.on_surfaces(),
        gathering.describe_source(),
        show_duration(start.elapsed()),
    )
    .ok();
    Ok(ExitCode::SUCCESS)
}
