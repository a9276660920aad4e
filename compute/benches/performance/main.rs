//! The document on performance, measured and written by one command.
//!
//! ```text
//! cargo bench -p compute --bench performance
//! cargo bench -p compute --bench performance -- --quick --only scaling
//! ```
//!
//! The first writes `docs/PERFORMANCE.md`. Every number is measured in the run that prints it.

mod arguments;
mod gpu;
mod iteration;
mod limits;
mod machine;
mod measure;
mod program;
mod reference;
mod scaling;
mod scenes;
mod solvers;
mod stages;
mod text;
mod thesis;

use std::fs;
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;

use arguments::{Plan, Section};
use program::Program;
use stages::Stages;

/// Where the document is, from this package's folder.
const DOCUMENT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/PERFORMANCE.md");

fn main() -> ExitCode {
    let Some(plan) = Plan::parse() else {
        eprintln!(
            "performance: nothing to test; `cargo bench -p compute --bench performance` measures"
        );
        return ExitCode::SUCCESS;
    };
    match run(&plan) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("performance: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(plan: &Plan) -> anyhow::Result<()> {
    let document = document(plan)?;
    // A part, or small sizes, must not replace the document.
    let path = match &plan.out {
        Some(path) => path.as_path(),
        None if plan.is_whole() => Path::new(DOCUMENT),
        None => {
            print!("{document}");
            return Ok(());
        }
    };
    fs::write(path, document).with_context(|| format!("{} cannot be written", path.display()))?;
    eprintln!("performance: {} is written", path.display());
    Ok(())
}

fn document(plan: &Plan) -> anyhow::Result<String> {
    let program = Program::new(plan)?;
    // First of all: it tells how busy the machine is without this.
    let machine = wanted(plan, Section::Machine, || Ok(machine::section()))?;
    let reference = wanted(plan, Section::Reference, || {
        reference::section(plan, &program)
    })?;
    let solvers = wanted(plan, Section::Solvers, || solvers::section(plan))?;
    let gpu = wanted(plan, Section::Gpu, || gpu::section(plan))?;
    let measured = if plan.wants(Section::Stages) || plan.wants(Section::Limits) {
        Some(Stages::measure(plan)?)
    } else {
        None
    };
    let of_stages = |section, write: fn(&Stages) -> String| match &measured {
        Some(stages) if plan.wants(section) => write(stages),
        _ => String::new(),
    };
    let stages = of_stages(Section::Stages, stages::section);
    let limits = of_stages(Section::Limits, limits::section);
    let scaling = wanted(plan, Section::Scaling, || scaling::section(plan, &program))?;
    // Last, so that it knows what is left of the budget.
    let thesis = wanted(plan, Section::Thesis, || thesis::section(plan, &program))?;

    let title = format!(
        "# Performance\n\n\
         What a run costs, what its stages cost, and how that grows. Written by\n\n\
         ```\n{}\n```\n\n\
         which measures everything anew; `-- --only SECTION` prints one section, `-- --quick` all of them at \
         small sizes, `-- --help` lists the rest. Everything but the section on back ends is the cpu back end's. \
         Times are wall clock; those of small pieces are medians of repetitions after one that is not counted.\n",
        arguments::command()
    );
    let sections = [
        title, machine, thesis, reference, solvers, stages, scaling, limits, gpu,
    ];
    Ok(format!("{}\n", sections.concat().trim_end()))
}

/// A section if it was asked for, else nothing.
fn wanted(
    plan: &Plan,
    section: Section,
    write: impl FnOnce() -> anyhow::Result<String>,
) -> anyhow::Result<String> {
    if plan.wants(section) {
        write()
    } else {
        Ok(String::new())
    }
}
