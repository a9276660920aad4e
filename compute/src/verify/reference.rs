//! The form factors known in closed form, from `view_factors.json`.

use glam::DVec3;
use serde::Deserialize;

use super::VerifyError;
use super::case::{
    Case, Expected, Measure, NOTHING, OCCLUDED, PATCHES, POINT, TESSELLATED, Tolerance, UNOCCLUDED,
};
use super::shapes::{self, SceneBuilder, Triangle};

const DATA: &str = include_str!("view_factors.json");

/// Below this a target covers some hundred pixels at most, of the 49,152 of a hemicube of 128: what is so
/// small matters to somebody only as a lamp, so the target is one.
const LAMP_FORM_FACTOR: f64 = 1e-2;

/// Level of the spheres whose rows are drawn: 320 patches.
const SPHERE_FROM: u32 = 2;

/// Level of a sphere that is looked at.
const SPHERE_TO: u32 = 4;

/// x, y, z, metres.
type Corner = [f64; 3];

#[derive(Deserialize)]
struct Reference {
    cases: Vec<Entry>,
}

/// One closed form.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Entry {
    pub name: String,
    pub from: Shape,
    pub to: Shape,
    #[serde(default)]
    pub occluders: Vec<Vec<Corner>>,
    pub form_factor: f64,
    pub source: String,
}

/// What a form factor goes from or to, metres.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged)]
pub(super) enum Shape {
    Polygon {
        polygon: Vec<Corner>,
    },
    Point {
        point: Corner,
        normal: Corner,
    },
    Disk {
        disk: Corner,
        radius: f64,
        normal: Corner,
    },
    Sphere {
        sphere: Corner,
        radius: f64,
    },
}

fn polygon(corners: &[Corner]) -> Vec<Triangle> {
    let corners: Vec<DVec3> = corners.iter().copied().map(DVec3::from).collect();
    shapes::polygon(&corners)
}

impl Shape {
    pub fn is_point(&self) -> bool {
        matches!(self, Self::Point { .. })
    }

    pub fn is_curved(&self) -> bool {
        matches!(self, Self::Disk { .. } | Self::Sphere { .. })
    }

    /// Triangles of this shape as it takes part with the other one.
    pub fn triangles(&self, other: &Self, sphere_level: u32) -> Vec<Triangle> {
        match self {
            Self::Polygon { polygon: corners } => polygon(corners),
            Self::Point { point, normal } => shapes::point((*point).into(), (*normal).into()),
            Self::Disk {
                disk,
                radius,
                normal,
            } => shapes::disk((*disk).into(), *radius, (*normal).into()),
            Self::Sphere { sphere, radius } => {
                let inward = matches!(other, Self::Sphere { radius: inner, .. } if inner < radius);
                shapes::sphere((*sphere).into(), *radius, sphere_level, inward)
            }
        }
    }
}

impl Entry {
    pub fn triangles_from(&self) -> Vec<Triangle> {
        self.from.triangles(&self.to, SPHERE_FROM)
    }

    pub fn triangles_to(&self) -> Vec<Triangle> {
        let level = if self.from.is_point() {
            SPHERE_TO
        } else {
            SPHERE_FROM
        };
        self.to.triangles(&self.from, level)
    }

    fn tolerance(&self) -> Tolerance {
        if self.form_factor == 0.0 {
            NOTHING
        } else if !self.occluders.is_empty() {
            OCCLUDED
        } else if self.from.is_curved() || self.to.is_curved() {
            TESSELLATED
        } else if self.from.is_point() {
            POINT
        } else {
            UNOCCLUDED
        }
    }

    fn case(self) -> Case {
        // What a point is asked for is direct light.
        let lamp =
            self.from.is_point() || (self.form_factor > 0.0 && self.form_factor < LAMP_FORM_FACTOR);
        let (emission, measure, quantity) = if lamp {
            (
                1.0,
                Measure::Irradiance { of: "from" },
                "irradiance by unit emission",
            )
        } else {
            (
                0.0,
                Measure::FormFactor {
                    from: "from",
                    to: "to",
                },
                "form factor",
            )
        };
        let from = self.triangles_from();
        let patches = if self.from.is_point() { 1 } else { PATCHES };
        let mut scene = SceneBuilder::default().dark("from", patches, &from).object(
            "to",
            0.0,
            emission,
            1,
            &self.triangles_to(),
        );
        for occluder in &self.occluders {
            scene = scene.dark("occluder", 1, &shapes::two_sided(polygon(occluder)));
        }
        Case {
            tolerance: self.tolerance(),
            name: self.name,
            quantity: quantity.into(),
            measure,
            expected: Expected::Value(self.form_factor),
            source: self.source,
            scene,
        }
    }
}

/// The closed forms as they are in the file.
pub(super) fn entries() -> Result<Vec<Entry>, VerifyError> {
    Ok(serde_json::from_str::<Reference>(DATA)?.cases)
}

/// A case for each closed form.
pub(super) fn cases() -> Result<Vec<Case>, VerifyError> {
    Ok(entries()?.into_iter().map(Entry::case).collect())
}
