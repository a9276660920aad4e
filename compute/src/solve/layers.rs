//! Taking the light of sources apart: by lamps, or by bounces.
//!
//! # Theory
//! The equation is linear: with the emission E_g of one lamp, B_g = E_g + rho H_g, H_g = F B_g, and the sum over lamps is the
//! solution. So it is with bounces: H_1 = F E, H_(n+1) = F (rho H_n).
//!
//! # Practice
//! What sources receive is not quite what their rows say, H = F B (`corrected.rs`): each source receives s = H / (F B) times as much
//! on the mean, by channel. That factor is taken to be every layer's own, so that the layers sum to H. It is far from 1 beside
//! lamps only, where another lamp's light is scaled with it; the rest of the scene sees that as a part of a reflection.

use scene::Rgb;
use scene::layers::{Lamp, LayerKind};

use super::corrected::{Corrected, gather_from};
use crate::function::SourceLayer;
use crate::problem::Problem;
use crate::rows::BackendError;
use crate::solver::Update;

/// Iterations are enough when they are so many: those of a lamp alone fall as those of all do.
const MOST_ITERATIONS: u64 = 200;

/// The bounces of each layer but the last, first and last.
const BOUNCES: [[usize; 2]; 3] = [[1, 1], [2, 2], [3, 5]];

/// The layers of what sources receive; `None` where it is cancelled.
pub(super) fn of(
    solved: &mut Corrected,
    kind: LayerKind,
) -> Result<Option<Vec<SourceLayer>>, BackendError> {
    let start = solved.irradiance().to_vec();
    let gather = gather_from(solved.problem().clone(), Update::AfterIteration, start);
    let Some(by_rows) = solved.run(gather, 1)? else {
        return Ok(None);
    };
    let pairs = solved.irradiance().iter().zip(&by_rows);
    let scales = pairs
        .map(|(&all, &by_row)| quotient(all, by_row, Rgb::ONE))
        .collect();
    let apart = Apart { solved, scales };
    match kind {
        LayerKind::Lamps => apart.lamps(),
        LayerKind::Bounces => apart.bounces(),
    }
}

/// A solution that is taken apart.
struct Apart<'s, 'r, 'a> {
    solved: &'s mut Corrected<'r, 'a>,
    /// What sources receive over what their rows say, dimensionless, one per source.
    scales: Vec<Rgb>,
}

impl Apart<'_, '_, '_> {
    fn lamps(mut self) -> Result<Option<Vec<SourceLayer>>, BackendError> {
        let lamps = Lamp::of(self.solved.sources());
        let mut layers = Vec::with_capacity(lamps.len());
        for (name, lamp) in lamps {
            let emission = self.emission_of(lamp);
            let problem = self.problem(emission.clone(), true);
            let Some(irradiance) = self.received(problem, Update::AtOnce, MOST_ITERATIONS)? else {
                return Ok(None);
            };
            layers.push(SourceLayer {
                name,
                lamp: Some(lamp),
                emission,
                reflected: Vec::new(),
                irradiance,
            });
        }
        let all = self.solved.irradiance();
        // What the iterations have left.
        for (source, &all) in all.iter().enumerate() {
            let sum: Rgb = layers.iter().map(|layer| layer.irradiance[source]).sum();
            let scale = quotient(all, sum, Rgb::ZERO);
            for layer in &mut layers {
                layer.irradiance[source] *= scale;
            }
        }
        for layer in &mut layers {
            layer.reflected = self.reflected(&layer.irradiance);
        }
        Ok(Some(layers))
    }

    fn bounces(mut self) -> Result<Option<Vec<SourceLayer>>, BackendError> {
        let dark = vec![Rgb::ZERO; self.scales.len()];
        let mut rest = self.solved.irradiance().to_vec();
        let mut layers = Vec::new();
        let mut emission = self.solved.problem().emission.clone();
        // What arrives next is what these send out.
        let mut sent = emission.clone();
        for [first, last] in BOUNCES {
            let mut layer = SourceLayer {
                name: if first == last {
                    format!("bounce {first}")
                } else {
                    format!("bounces {first} to {last}")
                },
                lamp: None,
                emission: std::mem::replace(&mut emission, dark.clone()),
                reflected: dark.clone(),
                irradiance: dark.clone(),
            };
            for bounce in first..=last {
                if bounce > 1 {
                    add(&mut layer.reflected, &sent);
                }
                let problem = self.problem(sent, false);
                let Some(received) = self.received(problem, Update::AfterIteration, 1)? else {
                    return Ok(None);
                };
                // Roundings may make the parts more than all.
                let received: Vec<Rgb> = received
                    .iter()
                    .zip(&rest)
                    .map(|(&part, &rest)| part.min(rest))
                    .collect();
                for (rest, part) in rest.iter_mut().zip(&received) {
                    *rest -= *part;
                }
                add(&mut layer.irradiance, &received);
                sent = self.reflected(&received);
            }
            layers.push(layer);
        }
        let mut reflected = sent;
        add(&mut reflected, &self.reflected(&rest));
        let [_, last] = BOUNCES[BOUNCES.len() - 1];
        layers.push(SourceLayer {
            name: format!("bounces from {}", last + 1),
            lamp: None,
            emission,
            reflected,
            irradiance: rest,
        });
        Ok(Some(layers))
    }

    /// The emission of a lamp's sources, W/m^2, one per source.
    fn emission_of(&self, lamp: Lamp) -> Vec<Rgb> {
        let scene = self.solved.sources();
        let surfaces = scene.surfaces().iter().zip(scene.mesh().trees());
        let emissions = surfaces.flat_map(|(surface, tree)| {
            let emission = scene.material(surface.material).emission;
            let emission = if lamp.has(surface) {
                emission
            } else {
                Rgb::ZERO
            };
            tree.patches().map(move |_| emission)
        });
        emissions.collect()
    }

    /// The equation with another emission, W/m^2, and with the scaled reflectances or without any.
    fn problem(&self, emission: Vec<Rgb>, reflects: bool) -> Problem {
        let problem = self.solved.problem();
        let scaled = problem.reflectance.iter().zip(&self.scales);
        let reflectance = if reflects {
            scaled.map(|(&rho, &scale)| rho * scale).collect()
        } else {
            vec![Rgb::ZERO; self.scales.len()]
        };
        Problem {
            areas: problem.areas.clone(),
            reflectance,
            emission,
        }
    }

    /// What sources receive by a problem, from darkness on; `None` where it is cancelled.
    fn received(
        &mut self,
        problem: Problem,
        update: Update,
        most: u64,
    ) -> Result<Option<Vec<Rgb>>, BackendError> {
        let dark = vec![Rgb::ZERO; self.scales.len()];
        let by_rows = self.solved.run(gather_from(problem, update, dark), most)?;
        Ok(by_rows.map(|by_rows| {
            let scaled = by_rows.iter().zip(&self.scales);
            scaled.map(|(&by_row, &scale)| scale * by_row).collect()
        }))
    }

    fn reflected(&self, irradiance: &[Rgb]) -> Vec<Rgb> {
        let reflectance = self.solved.problem().reflectance.iter();
        reflectance
            .zip(irradiance)
            .map(|(&rho, &h)| rho * h)
            .collect()
    }
}

fn add(to: &mut [Rgb], more: &[Rgb]) {
    for (to, &more) in to.iter_mut().zip(more) {
        *to += more;
    }
}

/// A quotient by channel, and this where there is nothing to divide by.
fn quotient(a: Rgb, b: Rgb, otherwise: Rgb) -> Rgb {
    Rgb::select(b.cmpgt(Rgb::ZERO), a / b, otherwise)
}
