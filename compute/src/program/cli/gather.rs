//! The command line of `compute gather`, turned into [`GatherSettings`].

use std::path::PathBuf;

use clap::Args;

use super::{backend_parser, check_different, choice, parse_resolution};
use crate::program::GatherSettings;
use crate::settings::{BackendChoice, FormFactorSettings, LampViews};

/// Tell the irradiance at points of one's own in a solved scene
///
/// Reads points and normals from a table (CSV with a line of names: x, y, z, nx, ny, nz in the model's own coordinates,
/// in any order; other columns are passed through), and writes the same table with these columns added: irradiance_r,
/// irradiance_g, irradiance_b, direct_r, direct_g, direct_b (W/m^2; direct is what comes from emitters without
/// reflection), openings and back_faces (shares of what the point sees). A sensor hides nothing; one that lies on a
/// surface sees nothing of that surface's plane.
#[derive(Debug, Args)]
pub(super) struct GatherArguments {
    /// Solved scene
    #[arg(value_name = "SOLVED")]
    solved: PathBuf,
    /// Points and normals
    #[arg(long, value_name = "POINTS.csv")]
    sensors: PathBuf,
    /// Where they go with what they receive
    #[arg(long, value_name = "VALUES.csv")]
    out: PathBuf,
    /// Pixels along a hemicube's face: even, 2 to 4096
    #[arg(value_name = "RESOLUTION", default_value = "128", value_parser = parse_resolution)]
    resolution: u32,
    /// Exact views of lamps beside the hemicube, as in a run
    #[arg(long, default_value = "auto", value_parser = choice(&[
        ("auto", LampViews::Auto), ("off", LampViews::Off), ("all", LampViews::All)]))]
    lamps: LampViews,
    /// Who draws: auto keeps who has drawn for SOLVED, else chooses as a run does
    #[arg(long, default_value = "auto", value_parser = backend_parser())]
    backend: BackendChoice,
    /// Threads of the CPU; one for each core if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl GatherArguments {
    /// What is asked for; an output that is an input is an error.
    pub fn settings(self) -> Result<GatherSettings, String> {
        let files = [
            ("SOLVED", Some(&self.solved)),
            ("--sensors", Some(&self.sensors)),
            ("--out", Some(&self.out)),
        ];
        check_different(&files, 2)?;
        Ok(GatherSettings {
            solved: self.solved,
            sensors: self.sensors,
            output: self.out,
            form_factors: FormFactorSettings {
                lamps: self.lamps,
                ..FormFactorSettings::new(self.resolution)
            },
            backend: self.backend,
            threads: self.threads.map(usize::from),
        })
    }
}
