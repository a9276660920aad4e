//! `cargo run --release -p demo`: makes the Cornell box and a hall with columns, solves both, and
//! writes pictures of every step, as the thesis shows them. Also an example of the libraries' use.

mod pictures;
mod solve;
mod table;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use anyhow::Context;
use clap::Parser;
use genx::Model;

/// Makes two scenes, solves them, and writes pictures of iterations 1, 2 and the last.
#[derive(Debug, Parser)]
struct Arguments {
    /// Folder for the pictures and the solved scenes; made if it is not there
    #[arg(default_value = "out")]
    folder: PathBuf,
    /// Height of the pictures, pixels
    #[arg(long, default_value_t = 768, value_parser = clap::value_parser!(u32).range(64..=4096))]
    height: u32,
    /// Write the pictures alone
    #[arg(long)]
    pictures_only: bool,
    /// Pixels along a hemicube's face: even, 2 to 4096 [default: 32]
    #[arg(long, value_parser = compute::program::cli::parse_resolution)]
    resolution: Option<u32>,
    /// Who draws the hemicubes: auto, cpu or gpu
    #[arg(long, default_value = "auto", value_parser = compute::program::cli::backend_parser())]
    backend: compute::settings::BackendChoice,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("demo: error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let start = Instant::now();
    let folder = &arguments.folder;
    std::fs::create_dir_all(folder)
        .with_context(|| format!("the folder {} cannot be made", folder.display()))?;
    let mut results = Vec::new();
    for (name, model) in [("cornell", Model::Cornell), ("hall", Model::Hall)] {
        let made = genx::make(&genx::Settings::new(model))?;
        println!("{name}: {} patches, solving ...", made.scene.patch_count());
        let solved = solve::solve(&made.scene, arguments.resolution, arguments.backend)?;
        pictures::write(folder, name, &made.scene, &solved, arguments.height)?;
        if !arguments.pictures_only {
            let path = folder.join(format!("{name}-solved.rad"));
            scene::file::save(&path, &made.scene, solved.states.last())?;
        }
        results.push((name, solved.summary));
    }
    println!("\n{}", table::format(&results));
    println!(
        "The pictures are in {}: log maps and false colours after iterations 1, 2 and the last, and patch IDs.",
        std::path::absolute(folder)
            .unwrap_or_else(|_| folder.clone())
            .display()
    );
    println!("{:.1} s in all.", start.elapsed().as_secs_f64());
    Ok(())
}
