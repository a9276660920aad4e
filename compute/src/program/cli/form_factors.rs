//! The part of a command line that decides form factors, turned into [`FormFactorSettings`].

use clap::Args;

use super::{choice, parse_resolution};
use crate::settings::{ClosedForms, FormFactorSettings, LampViews, Maps, Points, Seed};

/// RESOLUTION, and where hemicubes stand and what they count.
#[derive(Debug, Args)]
pub(super) struct FormFactorArguments {
    /// Pixels along a hemicube's face: even, 2 to 4096 [default: 128]
    #[arg(value_name = "RESOLUTION", value_parser = parse_resolution)]
    resolution: Option<u32>,
    /// What the pixels count: exact integrals, or the thesis's multipliers for comparison
    #[arg(long, default_value = "exact", value_parser = choice(&[
        ("exact", Maps::Exact), ("thesis", Maps::Thesis)]))]
    maps: Maps,
    /// Where a patch's hemicubes stand: auto (one, or three and more where other surfaces are near),
    /// centroid, vertices, or N points of equal weight: 1, 2, 4 ... 1024 centroids of equal areas, or 3,
    /// 6, 12 ... 3072 by a rule of higher order [default: auto]
    #[arg(long)]
    points: Option<Points>,
    /// Hemicubes are turned about their normals, each by its own angle: a number picks the angles, "aligned"
    /// turns none
    #[arg(long, default_value = "0", value_name = "SEED")]
    seed: Seed,
    /// Exact views of lamps beside the hemicube: of those that matter, none, or all
    #[arg(long, default_value = "auto", value_parser = choice(&[
        ("auto", LampViews::Auto), ("off", LampViews::Off), ("all", LampViews::All)]))]
    lamps: LampViews,
    /// Form factors by formula instead of hemicubes: auto (with --backend auto, in convex rooms in which nothing
    /// hides anything, where that is faster), or off
    #[arg(long, default_value = "auto", value_parser = choice(&[
        ("auto", ClosedForms::Auto), ("off", ClosedForms::Off)]))]
    closed_forms: ClosedForms,
}

impl FormFactorArguments {
    /// What is asked for. What is not is as in a run that leaves it at patches' means, or as in one that gathers a function.
    pub fn settings(self, has_function: bool) -> FormFactorSettings {
        let defaults = if has_function {
            FormFactorSettings {
                points: Points::CENTROID,
                ..FormFactorSettings::new(32)
            }
        } else {
            FormFactorSettings::default()
        };
        FormFactorSettings {
            resolution: self.resolution.unwrap_or(defaults.resolution),
            maps: self.maps,
            points: self.points.unwrap_or(defaults.points),
            seed: self.seed,
            lamps: self.lamps,
            closed_forms: self.closed_forms,
        }
    }
}
