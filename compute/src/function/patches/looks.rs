//! Looking at some patches more closely, and what that says of all.

use glam::DVec3;
use scene::PatchId;

use super::Taking;
use crate::function::checks::{Candidate, Check, Part, Sample, draw};
use crate::function::gatherer::Light;
use crate::function::growth::{causes, errors};
use crate::function::lit_mesh::{Ambient, LitMesh, Size, sum};
use crate::function::vertices::Place;
use crate::function::{ErrorByCause, Errors, FunctionFault};

/// The fewest patches that are looked at more closely at a time, and their number as a share of all beyond that.
const FEWEST_CHECKS: usize = 256;
const CHECKED: f64 = 0.01;

/// The fewest places that look at what varies within patches, and their number as a share of those.
const FEWEST_LOOKS: usize = 96;
const LOOKS: f64 = 0.375;

/// What a patch is likely to be off by that has gathered at more points, as a share of what it was off by, squared, before somebody
/// knows.
const AFTERWARDS: f64 = 0.1;

/// The fewest looks that tell that.
const FEWEST_KNOWN: usize = 8;

/// What looks have found.
pub(super) struct Looked {
    /// Patches, and what they receive at more points.
    pub closer: Vec<(PatchId, Light)>,
    /// As much area as each stands for, m^2.
    areas: Vec<f64>,
    /// Places that have looked at what varies within patches.
    within: Sample,
}

impl Taking<'_, '_> {
    /// Looks at some patches more closely, and at what varies within others; `None` where it is cancelled.
    pub(super) fn look(
        &mut self,
        lit: &LitMesh,
        likely: &[[f64; 2]],
        size: &Size,
    ) -> Result<Option<Looked>, FunctionFault> {
        self.round += 1;
        let of_sources = self.of_sources(lit, size);
        let (mut closer, mut within) = (Vec::new(), Vec::new());
        for (patch, &[power, visible]) in (0..).map(PatchId).zip(likely) {
            let surface = self.scene.mesh().surface_of(patch);
            let radiosity = self.radiosity(patch);
            if radiosity == DVec3::ZERO {
                continue;
            }
            let candidate = Candidate {
                part: Part::Patch(patch, radiosity),
                surface,
                in_part: [DVec3::X, DVec3::Y, DVec3::Z],
                corners: self.scene.patch_in_surface(patch),
                area: self.areas[patch.index()],
            };
            closer.push((candidate, [candidate.area, power, visible]));
            let [power, visible] = of_sources[patch.index()];
            within.push((candidate, [candidate.area, power, visible]));
        }
        let count = FEWEST_CHECKS.max((CHECKED * closer.len() as f64) as usize);
        let looks = FEWEST_LOOKS.max((LOOKS * count as f64) as usize);
        let checks = draw(&closer, count, self.round);
        let patches: Vec<PatchId> = checks.iter().filter_map(patch_of).collect();
        let Some(lights) = self.gather(&patches)? else {
            return Ok(None);
        };
        let places = draw(&within, looks, self.round);
        let means = lit.means(self.gatherer.sources());
        let function = self.gatherer.within(lit.function()?, &means);
        let at: Vec<Place> = places.iter().map(|place| place.place).collect();
        let Some(found) = self.gatherer.look_again(&function, &at) else {
            return Ok(None);
        };
        let of_patches = places.iter().filter_map(patch_of);
        Ok(Some(Looked {
            closer: patches.into_iter().zip(lights).collect(),
            areas: checks.iter().map(|check| check.area).collect(),
            within: Sample {
                lights: of_patches.map(|patch| self.light(patch)).collect(),
                checks: places,
                looks: found.into_iter().enumerate().collect(),
            },
        }))
    }

    /// What looks say of the means.
    pub(super) fn judge(
        &mut self,
        lit: &LitMesh,
        size: &Size,
        likely: &[[f64; 2]],
        looked: &Looked,
    ) -> ErrorByCause {
        let mut ambient = Ambient::default();
        for (&(patch, ref light), &area) in looked.closer.iter().zip(&looked.areas) {
            let more = light.irradiance() - self.patches[patch.index()].irradiance;
            let rho = self.reflected(patch, DVec3::ONE);
            ambient.add(area, rho, more, light.by_sources);
        }
        let ambient = ambient.share(lit.absorbing_area());
        // Of patches with their row's points and of the others: what they are off by, and how many looks say so.
        let (mut off, mut looks) = ([[0.0; 2]; 2], [0; 2]);
        for (&(patch, ref light), area) in looked.closer.iter().zip(&looked.areas) {
            let kind = self.kind(patch);
            let stands_for = area / self.areas[patch.index()];
            // As it would be if all patches were right.
            let mut light = *light;
            light.by_sources += ambient * light.by_sources;
            let each = self.off(size, patch, &light);
            off[kind] = sum(off[kind], each.map(|off| stands_for * off));
            looks[kind] += 1;
        }
        let mut expected = [[0.0; 2]; 2];
        for (patch, &likely) in (0..).map(PatchId).zip(likely) {
            let kind = self.kind(patch);
            expected[kind] = sum(expected[kind], likely);
        }
        for kind in 0..2 {
            self.calibration[kind] = [0, 1].map(|t| {
                if looks[kind] >= FEWEST_KNOWN {
                    off[kind][t] / expected[kind][t].max(f64::MIN_POSITIVE)
                } else if kind == 1 {
                    AFTERWARDS
                } else {
                    1.0
                }
            });
        }
        let [sources, _] = causes(lit, &looked.within);
        ErrorByCause {
            sampling: errors(sum(off[0], off[1])),
            sources: errors(sources),
            iterations: Errors::splat(self.order.iterations.unwrap_or(0.0)),
            ..ErrorByCause::default()
        }
        .added_up()
    }

    /// 0 for a patch that has its row's points, 1 for others.
    fn kind(&self, patch: PatchId) -> usize {
        usize::from(self.patches[patch.index()].was_off.is_some())
    }

    /// What patches are estimated to be off by, by target and area.
    pub(super) fn estimated(&self, likely: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let of_patch = |(patch, likely): (PatchId, &[f64; 2])| {
            let calibration = self.calibration[self.kind(patch)];
            [0, 1].map(|t| calibration[t] * likely[t])
        };
        (0..).map(PatchId).zip(likely).map(of_patch).collect()
    }
}

/// Whose mean a check looks at.
fn patch_of(check: &Check) -> Option<PatchId> {
    match check.part {
        Part::Patch(patch, _) => Some(patch),
        Part::Leaf(_) => None,
    }
}
