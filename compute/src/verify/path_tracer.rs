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

use glam::DVec3;
use scene::{Material, Rgb};

use super::VerifyError;
use super::case::{Case, Expected, Measure, Tolerance};
use super::shapes::{SceneBuilder, Triangle};

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
    /// In the format that `cornell.txt` describes.
    data: &'static str,
    /// Of the rms error against the path tracer.
    mean: Tolerance,
}

const ROOMS: [Room; 2] = [
    Room {
        name: "cornell box",
        data: include_str!("cornell.txt"),
        mean: Tolerance {
            relative: 6e-3,
            reason: "constant radiosity a patch 0.35 %, the path tracer's noise 0.09 %, the rest pixels and points",
        },
    },
    Room {
        name: "room with columns",
        data: include_str!("room.txt"),
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
    } = read(room.data)?;
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

/// Reads the format that the file itself describes.
fn read(text: &str) -> Result<Reference, VerifyError> {
    let mut materials: Vec<Material> = Vec::new();
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut read = Reference {
        scene: SceneBuilder::default(),
        mean: Vec::new(),
        discrete: Vec::new(),
    };
    // Neighbours in the file that have one material are one object.
    let mut object: (usize, Vec<Triangle>) = (0, Vec::new());
    for (number, line) in text.lines().enumerate() {
        let bad = || VerifyError::Line { line: number + 1 };
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["m", name, ref rest @ ..] => {
                let [reflectance, emission] = triples(rest).ok_or_else(bad)?;
                materials.push(Material {
                    name: name.into(),
                    reflectance: reflectance.as_vec3(),
                    emission: emission.as_vec3(),
                });
            }
            ["v", ref rest @ ..] => {
                let [vertex] = triples(rest).ok_or_else(bad)?;
                vertices.push(vertex);
            }
            ["f", material, a, b, c, ref rest @ ..] => {
                let index = |word: &str| word.parse::<usize>().map_err(|_| bad());
                let vertex = |word| vertices.get(index(word)?).copied().ok_or_else(bad);
                let material = index(material)?;
                if material != object.0 {
                    let last = std::mem::replace(&mut object, (material, Vec::new()));
                    read.scene = add(read.scene, &materials, last).ok_or_else(bad)?;
                }
                object.1.push([vertex(a)?, vertex(b)?, vertex(c)?]);
                let [mean, discrete] = triples(rest).ok_or_else(bad)?;
                read.mean.push(mean.as_vec3());
                read.discrete.push(discrete.as_vec3());
            }
            [] | ["#", ..] => {}
            _ => return Err(bad()),
        }
    }
    let end = || VerifyError::Line {
        line: text.lines().count(),
    };
    read.scene = add(read.scene, &materials, object).ok_or_else(end)?;
    Ok(read)
}

fn add(
    scene: SceneBuilder,
    materials: &[Material],
    (material, triangles): (usize, Vec<Triangle>),
) -> Option<SceneBuilder> {
    Some(scene.with_material(materials.get(material)?.clone(), 1, &triangles))
}

/// N times three numbers, and nothing after them.
fn triples<const N: usize>(words: &[&str]) -> Option<[DVec3; N]> {
    let numbers: Vec<f64> = words
        .iter()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let triples: Vec<DVec3> = numbers
        .chunks(3)
        .map(|chunk| <[f64; 3]>::try_from(chunk).ok().map(DVec3::from))
        .collect::<Option<_>>()?;
    triples.try_into().ok()
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
            let read = read(room.data).unwrap();
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
        for line in ["v 1 2", "f 0 0 1 2 1 1 1", "m", "x", "v 1 2 three"] {
            let text = format!("m white .5 .5 .5 0 0 0\n{line}\n");
            assert!(
                matches!(read(&text), Err(VerifyError::Line { line: 2 })),
                "{line}"
            );
        }
    }
}
