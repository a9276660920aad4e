//! Points at which somebody wants to know the irradiance.
//!
//! A sensor hides nothing. One that is said to lie on a surface does so within the digits of its coordinates only, and may
//! be behind that surface by rounding, where it would see nothing but its back. So a sensor that faces as a surface
//! does and is nearer to it than a hundred thousandth of the scene is moved onto it.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use scene::{Scene, SurfaceId};
use visibility::{Drawable, Frame};

use super::turn::turn_at;
use super::{ReceiverId, Receivers};
use crate::settings::Seed;
use crate::sphere::Spheres;

/// How far from a surface a sensor may be that lies on it, as a share of the scene's largest extent: six digits of a
/// coordinate are half as much off.
const ON_SURFACE: f64 = 1e-5;

/// The least cosine between the normals of a sensor and of the surface that it lies on: a degree.
const ALIKE: f64 = 0.9998;

/// A point and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Metres, relative to the scene's origin.
    pub position: DVec3,
    /// Unit vector.
    pub normal: DVec3,
}

/// Sensors as receivers of one point each.
#[derive(Debug)]
pub struct Sensors {
    sensors: Vec<Placed>,
    seed: Seed,
}

#[derive(Clone, Copy, Debug)]
struct Placed {
    sensor: Sensor,
    surface: Option<SurfaceId>,
}

impl Sensors {
    /// Sensors in a scene.
    pub fn new(drawable: &Arc<Drawable>, sensors: &[Sensor], seed: Seed) -> Self {
        let scene = drawable.scene();
        let spheres = Spheres::new(scene.surfaces());
        let [low, high] = scene.bounds();
        let reach = ON_SURFACE * f64::from((high - low).max_element());
        let place = |&sensor: &Sensor| {
            let mut nearest = (reach, None);
            spheres.for_each_within(reach, sensor.position, |index, _| {
                let id = SurfaceId(index as u32);
                if drawable.normal_of(id).dot(sensor.normal) >= ALIKE {
                    let distance = distance(scene, id, sensor.position);
                    if distance < nearest.0 {
                        nearest = (distance, Some(id));
                    }
                }
                reach
            });
            let Some(id) = nearest.1 else {
                return Placed {
                    sensor,
                    surface: None,
                };
            };
            let normal = drawable.normal_of(id);
            let corner = scene.surface(id).corners[0].as_dvec3();
            let height = (sensor.position - corner).dot(normal);
            Placed {
                sensor: Sensor {
                    position: sensor.position - height * normal,
                    normal,
                },
                surface: Some(id),
            }
        };
        Self {
            sensors: sensors.iter().map(place).collect(),
            seed,
        }
    }
}

impl Sensors {
    /// How many lie on surfaces.
    pub fn on_surfaces(&self) -> u32 {
        let on_surfaces = self
            .sensors
            .iter()
            .filter(|placed| placed.surface.is_some());
        on_surfaces.count() as u32
    }
}

impl Receivers for Sensors {
    fn count(&self) -> u32 {
        self.sensors.len() as u32
    }

    fn frames(&self, receiver: ReceiverId) -> Vec<Frame> {
        let Sensor { position, normal } = self.sensors[receiver.0 as usize].sensor;
        let turn = turn_at(position, self.seed);
        vec![Frame::at(
            position,
            normal,
            normal.any_orthonormal_vector(),
            turn,
        )]
    }

    fn surface(&self, receiver: ReceiverId) -> Option<SurfaceId> {
        self.sensors[receiver.0 as usize].surface
    }
}

/// Distance of a point from a surface, metres.
fn distance(scene: &Scene, surface: SurfaceId, point: DVec3) -> f64 {
    let corners = scene.surface(surface).corners.map(Vec3::as_dvec3);
    crate::triangle::distance(point, corners)
}
