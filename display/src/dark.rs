//! Why a picture is dark although something shines: light that falls on backs, which are black.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use scene::{ObjectId, Rgb, Scene, Surface};
use visibility::{Cull, Drawable, Sample};

use crate::camera::Camera;
use crate::default_camera::{Framing, INSIDE_FOV, Wishes};
use crate::probe::Probe;

/// Side of the faces of the picture of what a lamp shines on, pixels.
const PROBE_SIZE: usize = 32;

/// Share of a lamp's light on backs from which on something is likely to face the wrong way.
const MOST_ON_BACKS: f64 = 0.5;

/// How far before a lamp the eye is, as a share of the lamp's size.
const BEFORE: f64 = 1e-3;

/// How far from a lit surface a camera stands, in its sizes.
const DISTANCE: f64 = 2.0;

/// The object whose backs the strongest lamp shines on, where these get most of its light: `irradiance` has one element per
/// patch, W/m^2.
pub fn lit_from_behind<'s>(scene: &'s Scene, irradiance: &[Rgb]) -> Option<&'s str> {
    // Most light arrives somewhere: nobody need look.
    let areas = scene.patch_areas();
    let powers = irradiance.iter().zip(&areas);
    let received: f64 = powers
        .map(|(h, area)| h.as_dvec3().element_sum() * area)
        .sum();
    if received > MOST_ON_BACKS * scene.emitted_power().element_sum() {
        return None;
    }
    let power = |surface: &Surface| {
        let emission = scene.material(surface.material).emission;
        surface.area() * emission.as_dvec3().element_sum()
    };
    let lamp = strongest(scene, power)?;
    let drawable = Arc::new(Drawable::new(scene));
    let mut probe = Probe::new(&drawable);
    let normal = lamp.normal();
    let eye = centre(lamp) + BEFORE * lamp.area().sqrt() * normal;
    let mut lookout = probe.at(eye, Cull::Nothing, 6 * PROBE_SIZE * PROBE_SIZE);
    let mut all = 0.0;
    let mut backs: BTreeMap<u32, f64> = BTreeMap::new();
    lookout.look_around(PROBE_SIZE, |ray| {
        let light = ray.solid_angle * ray.direction.normalize().dot(normal).max(0.0);
        all += light;
        if let Sample::BackFace(surface) = ray.sample {
            *backs.entry(scene.surface(surface).object.0).or_default() += light;
        }
    });
    let on_backs: f64 = backs.values().sum();
    let most = backs.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let (object, _) = most.filter(|_| on_backs > MOST_ON_BACKS * all)?;
    Some(scene.object(ObjectId(object)))
}

/// A view of the surface that sends most light, from its front; `None` where none does.
pub fn before_light(
    scene: &Scene,
    values: &[Rgb],
    wishes: &Wishes,
    aspect: f64,
) -> Option<Framing> {
    let light = |surface: &Surface, patches: std::ops::Range<u32>| {
        let values = &values[patches.start as usize..patches.end as usize];
        let mean: f64 = values.iter().map(|v| v.as_dvec3().element_sum()).sum();
        surface.area() * mean / values.len() as f64
    };
    let surfaces = scene.surfaces().iter().zip(scene.mesh().trees());
    let lit = surfaces
        .map(|(surface, tree)| (light(surface, tree.patches()), surface))
        .filter(|(light, _)| *light > 0.0);
    let (_, surface) = lit.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let normal = surface.normal();
    let eye = centre(surface) + DISTANCE * surface.area().sqrt() * normal;
    // Looking along the axis that is up, anything is.
    let up = if normal.dot(wishes.up).abs() > 0.99 {
        normal.any_orthonormal_vector()
    } else {
        wishes.up
    };
    let fov = wishes.fov_degrees.unwrap_or(INSIDE_FOV);
    Some(Framing {
        camera: Camera::new(eye, -normal, up, fov),
        aspect,
    })
}

fn strongest(scene: &Scene, power: impl Fn(&Surface) -> f64) -> Option<&Surface> {
    let surfaces = scene.surfaces().iter();
    let lamps = surfaces.filter(|surface| power(surface) > 0.0);
    lamps.max_by(|a, b| power(a).total_cmp(&power(b)))
}

fn centre(surface: &Surface) -> DVec3 {
    surface
        .corners
        .map(Vec3::as_dvec3)
        .into_iter()
        .sum::<DVec3>()
        / 3.0
}
