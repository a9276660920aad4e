//! What hemicubes at some places see once more: turned otherwise, and by the function itself.
//!
//! The difference between two turns is what pixels bring. The difference between the reflected light by the function, at each
//! pixel's own place, and by its mean over each source is what it brings that these are as large as they are: below
//! a box its shadow is not one value, and what stands in it is too bright.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use scene::Rgb;
use scene::function::IrradianceFunction;
use visibility::{Canvas, Drawable, Sample, Viewer};

use super::vertices::{Place, Places};
use crate::delta_form_factors::DeltaFormFactors;
use crate::receivers::{ReceiverId, Receivers};
use crate::rows::UNITS_PER_ONE;
use crate::settings::{Maps, Seed};

/// What is looked at.
pub(super) struct SecondLook<'l, 'a> {
    pub drawable: &'l Arc<Drawable<'a>>,
    pub resolution: u32,
    pub maps: Maps,
    /// The angles of the first look.
    pub seed: Seed,
    /// Reflected radiosity of each source, W/m^2.
    pub reflected: &'l [Rgb],
    pub within: &'l Within,
}

/// What sources are like within.
#[derive(Clone, Debug)]
pub(super) struct Within {
    pub function: IrradianceFunction,
    /// What each source would reflect on the mean by it, W/m^2.
    pub means: Vec<Rgb>,
    /// What it does over that, dimensionless: less where light is to be reflected a few times only.
    pub scales: Vec<Rgb>,
}

/// Irradiance from reflected light at a place, W/m^2.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reflected {
    /// From sources of one value each.
    pub by_sources: DVec3,
    /// How much more it is that sources are not.
    pub within: DVec3,
}

impl SecondLook<'_, '_> {
    /// What these places see, on the threads of the rayon pool it is called in.
    pub fn at(&self, places: &[Place]) -> Vec<Reflected> {
        let scene = self.drawable.scene();
        let turned = Places::new(scene, self.drawable, self.seed.otherwise());
        turned.extend(places.iter().copied());
        let delta_form_factors = DeltaFormFactors::new(self.maps, self.resolution, UNITS_PER_ONE);
        let look = |(viewer, canvas): &mut (Viewer, Canvas), receiver| {
            self.look(
                viewer,
                canvas,
                &turned,
                &delta_form_factors,
                ReceiverId(receiver),
            )
        };
        let receivers = (0..turned.count()).into_par_iter();
        let eyes = || (Viewer::new(self.drawable), Canvas::default());
        receivers.map_init(eyes, look).collect()
    }

    fn look(
        &self,
        viewer: &mut Viewer,
        canvas: &mut Canvas,
        places: &Places,
        delta_form_factors: &DeltaFormFactors,
        receiver: ReceiverId,
    ) -> Reflected {
        let scene = self.drawable.scene();
        let mut sums = Reflected::default();
        for frame in places.frames(receiver) {
            let view = viewer.hemicube(self.resolution, &frame, places.surface(receiver));
            for (face, window) in view.windows().iter().enumerate() {
                let picture = canvas.draw_face(&view, face);
                let factors = delta_form_factors.face(face).chunks_exact(window.width);
                for (j, factors) in factors.enumerate() {
                    picture.for_each_sample(j, 0..window.width, |i, sample| {
                        let Sample::Front {
                            surface,
                            barycentric,
                            ..
                        } = sample
                        else {
                            return;
                        };
                        let (source, _) = scene.mesh().locate(surface, barycentric);
                        let factor = f64::from(factors[i]);
                        let by_source = self.reflected[source.index()];
                        sums.by_sources += factor * by_source.as_dvec3();
                        let Within {
                            function,
                            means,
                            scales,
                        } = self.within;
                        let values = function.irradiance();
                        let material = scene.material(scene.surface(surface).material);
                        if let Some(irradiance) = function.interpolate(values, surface, barycentric)
                        {
                            let more = material.reflectance * irradiance - means[source.index()];
                            sums.within += factor * (scales[source.index()] * more).as_dvec3();
                        }
                    });
                }
            }
        }
        let units = f64::from(UNITS_PER_ONE);
        Reflected {
            by_sources: sums.by_sources / units,
            within: sums.within / units,
        }
    }
}
