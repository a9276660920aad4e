//! The part of a command line that decides form factors, turned into [`FormFactorSettings`].

use clap::Args;

use super::{choice, parse_resolution};
use crate::settings::{ClosedForms, FormFactorSettings, LampViews, Maps, Points, Seed};

/// RESOLUTION, and where hemicubes stand and what they count.
#[derive(Debug, Args)]
pub(super) struct FormFactorArguments {
    /// Pixels along a hemicube's face: even, 2 to 4096 [default: 128; 32 where vertices gather, 24 where patches do by
    /// their error]
    #[arg(value_name = "RESOLUTION", value_parser = parse_resolution)]
    resolution: Option<u32>,
    /// What the pixels count: exact integrals, or the thesis's multipliers for comparison [default: exact]
    #[arg(long, value_parser = choice(&[("exact", Maps::Exact), ("thesis", Maps::Thesis)]))]
    maps: Option<Maps>,
    /// Where a patch's hemicubes stand: auto (one, or three and more where other surfaces are near),
    /// centroid, vertices, or N points of equal weight: 1, 2, 4 ... 1024 centroids of equal areas, or 3,
    /// 6, 12 ... 3072 by a rule of higher order [default: auto; centroid where vertices gather]
    #[arg(long)]
    points: Option<Points>,
    /// Hemicubes are turned about their normals, each by its own angle: a number picks the angles, "aligned"
    /// turns none [default: 0]
    #[arg(long, value_name = "SEED")]
    seed: Option<Seed>,
    /// Exact views of lamps beside the hemicube: of those that matter, none, or all [default: auto]
    #[arg(long, value_parser = choice(&[
        ("auto", LampViews::Auto), ("off", LampViews::Off), ("all", LampViews::All)]))]
    lamps: Option<LampViews>,
    /// Form factors by formula instead of hemicubes: auto (with --backend auto, in convex rooms in which nothing
    /// hides anything, where that is faster), or off [default: auto]
    #[arg(long, value_parser = choice(&[
        ("auto", ClosedForms::Auto), ("off", ClosedForms::Off)]))]
    closed_forms: Option<ClosedForms>,
}

impl FormFactorArguments {
    /// Whether the resolution is given.
    pub fn has_resolution(&self) -> bool {
        self.resolution.is_some()
    }

    /// Whether it is said where hemicubes stand.
    pub fn has_points(&self) -> bool {
        self.points.is_some()
    }

    /// What is asked for, and what is not as in the defaults.
    pub fn settings(&self, defaults: FormFactorSettings) -> FormFactorSettings {
        FormFactorSettings {
            resolution: self.resolution.unwrap_or(defaults.resolution),
            maps: self.maps.unwrap_or(defaults.maps),
            points: self.points.unwrap_or(defaults.points),
            seed: self.seed.unwrap_or(defaults.seed),
            lamps: self.lamps.unwrap_or(defaults.lamps),
            closed_forms: self.closed_forms.unwrap_or(defaults.closed_forms),
        }
    }
}
