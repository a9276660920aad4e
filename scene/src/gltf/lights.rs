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
//! Those of lights that are close together would hide each other; `clusters.rs` keeps them apart.
//!
//! # Units
//! Blender exports lamps of P watts with I = 683 P / (4 pi) in its mode "Standard", which is its default, and with
//! I = P / (4 pi), which is the one for this program, in the mode "Unitless". The file does not say which it was: a warning
//! names both.

use glam::DVec3;
use gltf::json::extensions::scene::khr_lights_punctual::{Light, Type};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::clusters::{Emitter, Shape, apart};
use super::document::Document;
use super::error::wrong;
use super::names::{first_name, told_of};
use super::nodes::Placed;
use crate::import::ImportOptions;
use crate::{Material, Rgb};

/// Radius of the bodies, metres.
const RADIUS: f64 = 0.01;

/// A body that stands in for a light.
pub(super) struct Body {
    /// As an object asks for it.
    pub name: String,
    pub material: Material,
    /// Counter-clockwise from outside, metres.
    pub triangles: Vec<[DVec3; 3]>,
}

/// Names of lights, by what is told of them.
#[derive(Default)]
struct Told {
    points: Vec<String>,
    spots: Vec<String>,
    suns: Vec<String>,
    dark: Vec<String>,
}

/// What stands in for the lights of nodes.
///
/// # Errors
/// Intensities and colours that are none, and exitances that single precision cannot have.
pub(super) fn bodies(
    document: &Document,
    placed: &[Placed],
    options: &ImportOptions,
    warnings: &mut Vec<String>,
) -> Result<Vec<Body>, GltfFault> {
    let radius = options.light_radius.unwrap_or(RADIUS);
    let mut told = Told::default();
    let mut emitters = Vec::new();
    for placed in placed {
        let extensions = placed.node.extensions.as_ref();
        if let Some(found) = extensions.and_then(|e| e.khr_lights_punctual.as_ref()) {
            let light = document.get(found.light)?;
            emitters.extend(emitter(placed, light, options.axes.unit, &mut told)?);
        }
    }
    told.warn(radius, warnings);
    let generator = document.root.asset.generator.as_deref();
    if generator.is_some_and(|name| name.contains("Blender")) && !emitters.is_empty() {
        warnings.push(
            "the file is from Blender, whose exporter makes lamps 683 times too bright for this program in the lighting mode \
             \"Standard\", its default: export with the mode \"Unitless\", or give --light-power NAME=W"
                .to_owned(),
        );
    }
    let bodies = apart(emitters, radius, warnings).into_iter().map(|body| {
        let exitance = exitance(body.intensity, body.radius).ok_or_else(|| {
            wrong(
                format!("light \"{}\"", body.name),
                format!(
                    "its intensity {} W/sr makes an exitance of a body of radius {:?} m that is no normal number of single \
                     precision; give another --light-radius",
                    body.intensity, body.radius
                ),
            )
        })?;
        Ok(Body {
            material: Material {
                name: format!("light {}", body.name),
                reflectance: Rgb::ZERO,
                emission: exitance,
            },
            name: body.name,
            triangles: body.triangles,
        })
    });
    bodies.collect()
}

/// The light of a node, if something can stand in for it.
fn emitter(
    placed: &Placed,
    light: &Light,
    unit: f64,
    told: &mut Told,
) -> Result<Option<Emitter>, GltfFault> {
    let name = name(placed, light);
    let quoted = format!("\"{name}\"");
    let is_spot = match light.type_ {
        Checked::Valid(Type::Point) => false,
        Checked::Valid(Type::Spot) => true,
        _ => {
            told.suns.push(quoted);
            return Ok(None);
        }
    };
    let Light {
        intensity, color, ..
    } = light;
    let intensity_of = |channel: f32| f64::from(*intensity) * f64::from(channel);
    let of_channels = DVec3::from(color.map(intensity_of));
    if !(of_channels.is_finite() && of_channels.min_element() >= 0.0) {
        return Err(wrong(
            placed.thing(),
            format!(
                "its light has intensity {intensity} and colour {color:?}, which have to be finite and at least 0"
            ),
        ));
    }
    if of_channels == DVec3::ZERO {
        told.dark.push(quoted);
        return Ok(None);
    }
    let shape = if is_spot {
        let axis = placed.model_from_node.transform_vector3(DVec3::NEG_Z);
        let axis = axis.try_normalize().ok_or_else(|| {
            wrong(
                placed.thing(),
                "its transform leaves its spot light no direction",
            )
        })?;
        told.spots.push(quoted);
        Shape::Disc { axis }
    } else {
        told.points.push(quoted);
        Shape::Sphere
    };
    Ok(Some(Emitter {
        name,
        place: unit * placed.model_from_node.translation,
        shape,
        intensity: of_channels,
    }))
}

/// What a light's object is called: as the node, unless the node's mesh is called so.
fn name(placed: &Placed, light: &Light) -> String {
    let of_node = placed.node.name.as_ref();
    let of_light = light.name.as_ref();
    let last_resort = || format!("node {}", placed.index);
    if placed.node.mesh.is_none() {
        return first_name([of_node, of_light], last_resort);
    }
    let of_light = of_light.filter(|&name| Some(name) != of_node);
    first_name([of_light], || {
        format!("{}.light", first_name([of_node], last_resort))
    })
}

/// The exitance of a body, W/m^2; `None` where single precision cannot have it.
fn exitance(intensity: DVec3, radius: f64) -> Option<Rgb> {
    let exact = (intensity / radius / radius).to_array();
    let single = exact.map(|channel| channel as f32);
    let is_good = |(value, exact): (&f32, &f64)| value.is_normal() || *exact == 0.0;
    let mut values = single.iter().zip(&exact);
    values.all(is_good).then(|| Rgb::from(single))
}

impl Told {
    fn warn(&self, radius: f64, warnings: &mut Vec<String>) {
        warnings.extend(told_of(&self.points, |them| {
            format!(
                "point lights have no extent: black spheres of radius {radius} m stand in for {them}, a candela taken as 1 W/sr; \
                 --light-radius R and --light NAME=R,G,B say otherwise"
            )
        }));
        warnings.extend(told_of(&self.spots, |them| {
            format!(
                "spot lights have no extent: black discs of radius {radius} m stand in for {them}, a candela taken as 1 W/sr; they \
                 shine into the half space in front of them, also outside of their cones"
            )
        }));
        warnings.extend(told_of(&self.suns, |them| {
            format!(
                "directional lights are left out, since they come from infinitely far away: {them}"
            )
        }));
        warnings.extend(told_of(&self.dark, |them| {
            format!("lights without intensity are left out: {them}")
        }));
    }
}
