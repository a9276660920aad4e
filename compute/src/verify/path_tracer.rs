//! Two rooms against a path tracer, which shares nothing with hemicubes.
//!
//! # Theory
//! Errors are those of the reflected radiosity rho H, for lamps, whose radiosity is given, would
//! flatter any result. Over all patches i and channels,
//!
//! rms = sqrt( sum A (rho H - rho H_ref)^2 / sum A (rho H_ref)^2 ),
//! bias = sum A (rho H - rho H_ref) / sum A rho H_ref, one a channel.
//!
//! H_ref is the mean irradiance of the patch's area. That of the exact discrete solution, with one
//! radiosity a patch and exact form factors, departs from it by an rms of 0.35 percent in the Cornell box and
//! 0.58 in the room with columns: no solver on these meshes can do better, except by luck. So both are
//! references.

use std::path::Path;

use glam::DVec3;
use scene::{Rgb, obj};

use super::VerifyError;
use super::case::{Case, Expected, Measure, Tolerance};
use super::shapes::SceneBuilder;

/// What is made of the departures from a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statistic {
    /// Area-weighted root of the mean square, relative to the reference's, dimensionless.
    Rms,
    /// Of the channel where it is largest, the sum's departure, relative, dimensionless.
    Bias,
}

/// A room and what may be expected there at default settings.
struct Room {
    name: &'static str,
    /// The model, its materials and its irradiances, see `data/README.md`.
    files: [&'static str; 3],
    /// Of the rms error against the path tracer.
    mean: Tolerance,
}

const ROOMS: [Room; 2] = [
    Room {
        name: "cornell box",
        files: [
            include_str!("data/cornell.obj"),
            include_str!("data/cornell.mtl"),
            include_str!("data/cornell.csv"),
        ],
        mean: Tolerance {
            relative: 6e-3,
            reason: "constant radiosity a patch 0.35 %, the path tracer's noise 0.09 %, the rest pixels and points",
        },
    },
    Room {
        name: "room with columns",
        files: [
            include_str!("data/room.obj"),
            include_str!("data/room.mtl"),
            include_str!("data/room.csv"),
        ],
        mean: Tolerance {
            relative: 8e-3,
            reason: "constant radiosity a patch 0.58 %, the path tracer's noise 0.08 %, the rest pixels and points",
        },
    },
];

const DISCRETE: Tolerance = Tolerance {
    relative: 4e-3,
    reason: "pixels and points; the reference's own form factors 0.05 %",
};

const BIAS: Tolerance = Tolerance {
    relative: 2e-3,
    reason: "errors of pixels average out over thousands of patches",
};

/// All cases against the path tracer.
pub(super) fn cases() -> Result<Vec<Case>, VerifyError> {
    let mut cases = Vec::new();
    for room in ROOMS {
        cases.extend(cases_of(&room)?);
    }
    Ok(cases)
}

fn cases_of(room: &Room) -> Result<[Case; 3], VerifyError> {
    let Reference {
        scene,
        mean,
        discrete,
    } = read(room)?;
    let case =
        |name: &str, quantity: &str, source: &str, statistic, reference: &[Rgb], tolerance| Case {
            name: format!("{}, {name}", room.name),
            quantity: quantity.into(),
            measure: Measure::Reflected {
                room: room.name,
                reference: reference.to_vec(),
                statistic,
            },
            expected: Expected::Value(0.0),
            source: source.into(),
            tolerance,
            scene: scene.clone(),
        };
    let (rms, tracer) = ("rms error of reflected radiosity", "Mitsuba 3.9.1, path");
    Ok([
        case("path tracer", rms, tracer, Statistic::Rms, &mean, room.mean),
        case(
            "exact form factors",
            rms,
            "View3D, direct solve",
            Statistic::Rms,
            &discrete,
            DISCRETE,
        ),
        case(
            "bias",
            "largest bias of a channel",
            tracer,
            Statistic::Bias,
            &mean,
            BIAS,
        ),
    ])
}

/// The scene, whose patches are its triangles, and its irradiances, W/m^2, one per patch.
struct Reference {
    scene: SceneBuilder,
    mean: Vec<Rgb>,
    discrete: Vec<Rgb>,
}

fn read(room: &Room) -> Result<Reference, VerifyError> {
    let [model, materials, irradiances] = room.files;
    let model = obj::parse(Path::new(room.name), model.as_bytes(), materials.as_bytes())?;
    Ok(Reference {
        scene: model.into(),
        mean: column(irradiances, "irradiance")?,
        discrete: column(irradiances, "irradiance_discrete")?,
    })
}

/// The columns `NAME_r`, `NAME_g`, `NAME_b` of a table.
fn column(table: &str, name: &str) -> Result<Vec<Rgb>, VerifyError> {
    let mut lines = table.lines().enumerate();
    let names: Vec<&str> = lines
        .next()
        .map_or("", |(_, line)| line)
        .split(',')
        .collect();
    let columns = ["r", "g", "b"].map(|channel| {
        let column = format!("{name}_{channel}");
        names.iter().position(|&name| name == column)
    });
    let rows = lines.map(|(index, line)| {
        let cells: Vec<&str> = line.split(',').collect();
        let value = |column: Option<usize>| cells.get(column?)?.parse().ok();
        let [r, g, b] = columns.map(value);
        let rgb = || Some(Rgb::new(r?, g?, b?));
        rgb().ok_or(VerifyError::Line { line: index + 1 })
    });
    rows.collect()
}

/// A statistic of the departures of irradiances from a reference, one irradiance per patch.
pub fn statistic(
    statistic: Statistic,
    problem: &crate::problem::Problem,
    irradiance: &[Rgb],
    reference: &[Rgb],
) -> f64 {
    let patches = || {
        (0..problem.patch_count()).map(|i| {
            let rho = problem.reflectance[i];
            let [reflected, right] = [irradiance[i], reference[i]].map(|h| (rho * h).as_dvec3());
            (problem.areas[i], reflected - right, right)
        })
    };
    match statistic {
        Statistic::Rms => {
            let error: f64 = patches().map(|(a, d, _)| a * d.length_squared()).sum();
            let norm: f64 = patches().map(|(a, _, r)| a * r.length_squared()).sum();
            (error / norm).sqrt()
        }
        Statistic::Bias => {
            let departure: DVec3 = patches().map(|(a, d, _)| a * d).sum();
            let total: DVec3 = patches().map(|(a, _, r)| a * r).sum();
            (departure / total).abs().max_element()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;

    #[test]
    fn the_discrete_solution_is_as_far_from_the_means_as_is_said() {
        for (room, patches, expected) in [(&ROOMS[0], 2082, 0.0035), (&ROOMS[1], 5636, 0.0058)] {
            let read = read(room).unwrap();
            let scene = read.scene.build().unwrap();
            assert_eq!(scene.patch_count(), patches);
            let problem = Problem::new(&scene);
            let rms = statistic(Statistic::Rms, &problem, &read.discrete, &read.mean);
            assert!((rms - expected).abs() < 1e-4, "{rms}");
            let rms = statistic(Statistic::Rms, &problem, &read.mean, &read.mean);
            assert!(rms.abs() < f64::MIN_POSITIVE, "{rms}");
        }
    }

    #[test]
    fn a_broken_line_is_named() {
        let header = "h_r,h_g,h_b";
        for line in ["1,2", "1,2,three", "", "1;2;3"] {
            let table = format!("{header}\n1,2,3\n{line}\n");
            let read = column(&table, "h");
            assert!(matches!(read, Err(VerifyError::Line { line: 3 })), "{line}");
        }
        let other = column("x,h_b,h_r,h_g\n0,3,1,2\n", "h").unwrap();
        assert_eq!(other, [Rgb::new(1.0, 2.0, 3.0)]);
        let missing = column("h_r,h_g\n1,2\n", "h");
        assert!(matches!(missing, Err(VerifyError::Line { line: 2 })));
    }
}
