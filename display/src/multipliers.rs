//! The multiplier map: what each pixel of the unfolded hemicube counts, its delta form factor.
//!
//! The irradiance of the hemicube's point is H = sum_k dF_k B_k over the pixels k, dF_k their delta form factors,
//! dimensionless, and B_k the radiosities that they see, W/m^2 ([`compute::delta_form_factors`]).

use compute::delta_form_factors::DeltaFormFactors;
use compute::rows::UNITS_PER_ONE;
use compute::settings::Maps;
use glam::DVec3;
use scene::Rgb;
use visibility::hemicube::FACES;

use crate::unfolding::Unfolding;

/// Delta form factors in the plane.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Multipliers {
    /// One per pixel of the square, 0 in its empty corners.
    units: Vec<u32>,
    /// At least 1.
    largest: u32,
}

impl Multipliers {
    /// Those that compute counts by, for a patch of one point.
    pub fn new(maps: Maps, unfolding: Unfolding) -> Self {
        let factors = DeltaFormFactors::new(maps, unfolding.resolution(), UNITS_PER_ONE);
        let units = unfolding.lay_out(0, (0..FACES).map(|face| factors.face(face)));
        let largest = units.iter().copied().max().unwrap_or_default().max(1);
        Self { units, largest }
    }

    /// Delta form factors in units of 1/[`UNITS_PER_ONE`], one per pixel of the square, row by row from the top; 0 in its
    /// empty corners.
    pub fn units(&self) -> &[u32] {
        &self.units
    }

    /// The one of a pixel of the square as a part of the largest, 0 to 1.
    #[inline]
    pub fn relative(&self, pixel: usize) -> f32 {
        let units = self.units.get(pixel).copied().unwrap_or_default();
        units as f32 / self.largest as f32
    }

    /// The irradiance of a point whose pixels see these radiosities, both W/m^2.
    pub fn irradiance(&self, radiosities: &[Rgb]) -> Rgb {
        let products = self.units.iter().zip(radiosities);
        let sum: DVec3 = products
            .map(|(&units, radiosity)| f64::from(units) * radiosity.as_dvec3())
            .sum();
        (sum / f64::from(UNITS_PER_ONE)).as_vec3()
    }
}
