//! Lights of `KHR_lights_punctual`, which have no extent: bodies of a small radius r stand in for them.
//!
//! # Theory
//! A light has the intensity I, which the format gives in candela. What this program computes with is radiant, so a candela
//! is taken as 1 W/sr. A convex diffuse emitter of exitance M has the radiance M/pi and, seen from afar, the intensity
//! M/pi times its projected area (Lambert, "Photometria", 1760).
//! - Point light: a sphere, whose projected area is pi r^2 from all sides, so that M = I / r^2. Its power is 4 pi I. The
//!   sphere is a polyhedron of 80 triangles whose *mean* projected area is pi r^2; that of a convex body is a quarter of its
//!   area (Cauchy, 1832), so that the power is 4 pi I exactly.
//! - Spot light: a disc across its axis, of the area pi r^2, so that M = I / r^2 again. On the axis its intensity is I,
//!   beside it I cos(angle), over the whole half space in front; its power is pi I. No diffuse emitter has a narrower cone
//!   than this, so the cone's angles are left out.
//! - Directional lights come from infinitely far away, and are left out.
//!
//! The bodies reflect nothing. They do not scale with their nodes. `range` only says where a renderer may leave a light out.
//!
//! # Units
//! Blender exports lamps of P watts with I = 683 P / (4 pi) in its mode "Standard", and with I = P / (4 pi), which is the one
//! for this program, in the mode "Unitless".

use std::f64::consts::PI;

use glam::DVec3;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::document::Document;
use super::error::wrong;
use super::names::first_name;
use super::nodes::Placed;
use crate::import::ImportOptions;
use crate::{Material, Rgb};

/// Radius of the bodies, metres.
const RADIUS: f64 = 0.01;

/// Corners of a disc.
const DISC: u32 = 16;

/// A body that stands in for a light.
pub(super) struct Body {
    /// As an object asks for it.
    pub name: String,
    pub material: Material,
    /// Counter-clockwise from outside, metres.
    pub triangles: Vec<[DVec3; 3]>,
}

/// What stands in for the lights of nodes.
pub(super) fn bodies(
    document: &Document,
    placed: &[Placed],
    options: &ImportOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<Body>, GltfFault> {
    let radius = options.light_radius.unwrap_or(RADIUS);
    let mut bodies = Vec::new();
    let (mut points, mut spots, mut suns, mut dark) = (vec![], vec![], vec![], vec![]);
    for placed in placed {
        let extensions = placed.node.extensions.as_ref();
        let Some(found) = extensions.and_then(|e| e.khr_lights_punctual.as_ref()) else {
            continue;
        };
        let light = document.get(found.light)?;
        let own_names = [placed.node.name.as_ref(), light.name.as_ref()];
        let name = first_name(own_names, || format!("node {}", placed.index));
        let exitance = exitance(light, radius).ok_or_else(|| {
            wrong(
                placed.thing(),
                format!(
                    "its light has intensity {} and colour {:?}, which make no exitance (finite, >= 0) of a body of radius {radius} m",
                    light.intensity, light.color
                ),
            )
        })?;
        let told = format!("\"{name}\"");
        if exitance == Rgb::ZERO {
            dark.push(told);
            continue;
        }
        let centre = options.axes.unit * placed.model_from_node.translation;
        let triangles = match light.type_ {
            Checked::Valid(Type::Point) => {
                points.push(told);
                sphere(centre, radius)
            }
            Checked::Valid(Type::Spot) => {
                let axis = placed.model_from_node.transform_vector3(DVec3::NEG_Z);
                let axis = axis.try_normalize().ok_or_else(|| {
                    wrong(
                        placed.thing(),
                        "its transform leaves its spot light no direction",
                    )
                })?;
                spots.push(told);
                disc(centre, axis, radius)
            }
            _ => {
                suns.push(told);
                continue;
            }
        };
        bodies.push(Body {
            material: Material {
                name: format!("light {name}"),
                reflectance: Rgb::ZERO,
                emission: exitance,
            },
            name,
            triangles,
        });
    }
    warn(&points, warnings, |them| {
        format!(
            "point lights have no extent: black spheres of radius {radius} m stand in for {them}, a candela taken as 1 W/sr; \
             --light-radius R and --light NAME=R,G,B say otherwise"
        )
    });
    warn(&spots, warnings, |them| {
        format!(
            "spot lights have no extent: black discs of radius {radius} m stand in for {them}, a candela taken as 1 W/sr; they shine \
             into the half space in front of them, also outside of their cones"
        )
    });
    warn(&suns, warnings, |them| {
        format!("directional lights are left out, since they come from infinitely far away: {them}")
    });
    warn(&dark, warnings, |them| {
        format!("lights without intensity are left out: {them}")
    });
    Ok(bodies)
}

/// Most names in a warning.
const MOST_NAMED: usize = 3;

fn warn(names: &[String], warnings: &mut Vec<String>, message: impl Fn(&str) -> String) {
    let named = names[..names.len().min(MOST_NAMED)].join(", ");
    match names.len().saturating_sub(MOST_NAMED) {
        0 if names.is_empty() => {}
        0 => warnings.push(message(&named)),
        more => warnings.push(message(&format!("{named} and {more} more"))),
    }
}

/// The exitance of a light's body, W/m^2.
fn exitance(light: &Light, radius: f64) -> Option<Rgb> {
    let scale = f64::from(light.intensity) / (radius * radius);
    let exitance = light
        .color
        .map(|channel| (scale * f64::from(channel)) as f32);
    let is_good = |value: &f32| value.is_finite() && *value >= 0.0;
    exitance.iter().all(is_good).then(|| Rgb::from(exitance))
}

/// A polyhedron of 80 triangles, of the area of a sphere of this radius.
fn sphere(centre: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let unit: Vec<[DVec3; 3]> = icosahedron()
        .into_iter()
        .flat_map(|[a, b, c]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let area: f64 = unit.iter().map(area).sum();
    let scale = radius * (4.0 * PI / area).sqrt();
    let place = |corners: [DVec3; 3]| corners.map(|corner| centre + scale * corner);
    unit.into_iter().map(place).collect()
}

/// The faces of an icosahedron with corners on the unit sphere: a corner at each pole, and two rings of five between them.
fn icosahedron() -> Vec<[DVec3; 3]> {
    // The rings' latitude: atan(1/2).
    let (height, radius) = (1.0 / 5f64.sqrt(), 2.0 / 5f64.sqrt());
    let ring = |k: u32, half: f64, height: f64| {
        let (sin, cos) = (2.0 * PI * (f64::from(k % 5) + half) / 5.0).sin_cos();
        DVec3::new(radius * cos, radius * sin, height)
    };
    let (top, bottom) = (DVec3::Z, DVec3::NEG_Z);
    let faces = |k: u32| {
        let [a, b] = [k, k + 1].map(|k| ring(k, 0.0, height));
        let [c, d] = [k, k + 1].map(|k| ring(k, 0.5, -height));
        [[top, a, b], [a, c, b], [b, c, d], [bottom, d, c]]
    };
    (0..5).flat_map(faces).collect()
}

/// A regular polygon across an axis, of the area of a disc of this radius.
fn disc(centre: DVec3, axis: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let step = 2.0 * PI / f64::from(DISC);
    let scale = radius * (2.0 * PI / (f64::from(DISC) * step.sin())).sqrt();
    let (x, y) = axis.any_orthonormal_pair();
    let corner = |k: u32| {
        let (sin, cos) = (step * f64::from(k % DISC)).sin_cos();
        centre + scale * (cos * x + sin * y)
    };
    (0..DISC)
        .map(|k| [centre, corner(k), corner(k + 1)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_vector([a, b, c]: &[DVec3; 3]) -> DVec3 {
        0.5 * (b - a).cross(c - a)
    }

    #[test]
    fn spheres_are_closed_face_outwards_and_have_the_area_of_a_sphere() {
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let triangles = sphere(centre, 0.5);
        assert_eq!(triangles.len(), 80);
        let sum: DVec3 = triangles.iter().map(area_vector).sum();
        assert!(sum.length() < 1e-12, "{sum}");
        for triangle in &triangles {
            assert!(area_vector(triangle).dot(triangle[0] - centre) > 0.0);
        }
        let area: f64 = triangles.iter().map(|t| area_vector(t).length()).sum();
        assert!((area - PI).abs() < 1e-12, "{area}");
    }

    #[test]
    fn discs_face_along_their_axis_and_have_the_area_of_a_disc() {
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        let sum: DVec3 = disc(DVec3::ONE, axis, 2.0).iter().map(area_vector).sum();
        assert!((sum - 4.0 * PI * axis).length() < 1e-12, "{sum}");
    }
}
