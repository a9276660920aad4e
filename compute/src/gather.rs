//! The irradiance of sensors: what receivers that are no patches see of a solution.
//!
//! H = sum_j F_j B_j over the sources j, F_j the sensor's form factors, B_j the sources' radiosities, W/m^2. Its direct
//! part is sum_j F_j E_j, what arrives from the emitters themselves.

use scene::{Rgb, Solution};

use crate::FormFactors;
use crate::backend::Backend;
use crate::problem::Problem;
use crate::receivers::{Receivers, Sensor, Sensors};
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};
use crate::settings::Seed;
use crate::sources::Sources;

/// What a sensor receives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// Irradiance H, W/m^2.
    pub irradiance: Rgb,
    /// The part of it that comes from emitters without reflection, W/m^2.
    pub direct: Rgb,
    /// Share of the hemisphere, weighted by its cosine, that sees nothing.
    pub openings: f64,
    /// The same that sees backs of surfaces.
    pub back_faces: f64,
}

/// Sensors in a solved scene, and who looks from them.
pub struct Gathering<'a> {
    /// Of the patches, W/m^2: by the function, where there is one.
    radiosity: Vec<Rgb>,
    emission: Vec<Rgb>,
    backend: Backend<'a>,
    count: u32,
    on_surfaces: u32,
    next: u32,
}

impl<'a> Gathering<'a> {
    /// Gets ready. At most 2^24 - 1 sensors.
    ///
    /// # Errors
    /// A back end that does not open.
    pub fn new(
        form_factors: &FormFactors<'a>,
        solution: &Solution,
        sensors: &[Sensor],
    ) -> Result<Self, BackendError> {
        let scene = form_factors.scene();
        let sources = Sources::patches_of(scene);
        let sensors = Sensors::new(sources.drawable(), sensors, Seed::DEFAULT);
        let (count, on_surfaces) = (sensors.count(), sensors.on_surfaces());
        let backend = form_factors.at(Box::new(sensors), sources)?;
        let problem = Problem::new(scene);
        let means = solution.mean_irradiance(scene).into_iter().enumerate();
        Ok(Self {
            radiosity: means.map(|(i, h)| problem.radiosity(i, h)).collect(),
            emission: scene.patch_emissions(),
            backend,
            count,
            on_surfaces,
            next: 0,
        })
    }

    /// How many sensors lie on surfaces.
    pub fn on_surfaces(&self) -> u32 {
        self.on_surfaces
    }

    /// Who looks, for people.
    pub fn describe_source(&self) -> String {
        self.backend.source.describe()
    }

    /// Something the user should know about the choice of the back end.
    pub fn remark(&self) -> Option<&str> {
        self.backend.choice.remark.as_deref()
    }

    /// Lets the next sensors gather, as many as suit the back end; none are left where it hands out none.
    ///
    /// # Errors
    /// A back end that cannot go on.
    pub fn step(&mut self) -> Result<Vec<Received>, BackendError> {
        let end = (self.next + self.backend.source.preferred_batch().max(1)).min(self.count);
        let rows = self.backend.source.draw_rows(self.next..end)?;
        self.next = end;
        let one = f64::from(UNITS_PER_ONE);
        Ok((0..rows.receivers().len())
            .map(|k| {
                let unseen = rows.unseen(k);
                Received {
                    irradiance: sum(rows.row(k), &self.radiosity),
                    direct: sum(rows.row(k), &self.emission),
                    openings: f64::from(unseen.open) / one,
                    back_faces: f64::from(unseen.back_face) / one,
                }
            })
            .collect())
    }
}

/// The sum over a row of the form factors times some exitances, one per source, W/m^2.
fn sum(row: &[Entry], exitances: &[Rgb]) -> Rgb {
    let sum: glam::DVec3 = row
        .iter()
        .map(|entry| f64::from(entry.units) * exitances[entry.source as usize].as_dvec3())
        .sum();
    (sum / f64::from(UNITS_PER_ONE)).as_vec3()
}
