//! Where a mesh grows, and what it is worth.

use std::f64::consts::SQRT_2;

use glam::DVec3;
use scene::function::NodeId;
use scene::{Rgb, SurfaceId};

use super::checks::{Check, Part, Sample};
use super::gatherer::{Light, Look};
use super::lit_mesh::{Ambient, LitMesh, sum};
use super::{ErrorByCause, Errors};
use crate::settings::Target;

/// Leaves that make this share of the sum of what they are likely to miss are bisected.
const MARKED: f64 = 0.4;

/// Of what checks find to be missing, the share that corners are to tell at least, whatever spots are taken to be.
const LEAST_OTHERS: f64 = 0.1;

/// The function is checked whenever it has grown by this factor, and where little may be missing by the lesser one.
const GROWN: f64 = 1.5;
const HARDLY_GROWN: f64 = 1.1;

/// The mean square of what is linear between three independent values, over theirs: the mean over a triangle of the sum of its
/// squared barycentric coordinates.
const VERTEX_NOISE: f64 = 0.5;

/// The least share of what is asked of all causes together that the mesh gets, squared; where the others leave less, it cannot be
/// reached.
const LEAST_ROOM: f64 = 0.1;

/// The share of what is asked of all causes together, squared, that the size of sources may take before they are refined.
const SOURCES_SHARE: f64 = 0.2;

/// The share of what the size of sources brings, squared, that the noise of corrections for it may bring instead.
const WORTH: f64 = 0.5;

/// A mesh is better if its squared error is below this share of the least so far, and if after so many checks and with so many times
/// as many vertices it is not, it will not become better.
const BETTER: f64 = 0.9;
const PATIENCE: u32 = 3;
const MORE: f64 = 1.5;

/// A mesh on its way.
pub(super) struct Growth<'s> {
    lit: LitMesh<'s>,
    target: Target,
    /// What is asked of the mesh, squared, power then visible.
    asked: [f64; 2],
    /// What the last checks have found, each as if all of its leaf missed as much, by target.
    found: Vec<(NodeId, [f64; 2])>,
    /// What is missing, over what corners say is likely to be, as the last checks say; by target.
    calibration: Option<[f64; 2]>,
    /// What pixels bring to a point, squared, power then visible, as the last second look says.
    noise: [f64; 2],
    /// The same of what corrects for the size of sources.
    noise_of_corrections: [f64; 2],
    /// How many vertices there were when it was checked last.
    checked_at: u32,
    /// How often it was.
    round: u32,
    /// The mesh's least error so far, squared, power then visible, and how many vertices that took.
    least: ([f64; 2], u32),
    /// How many checks since then have found no better one.
    since: u32,
}

impl<'s> Growth<'s> {
    /// A mesh whose vertices have no light as yet.
    pub fn new(lit: LitMesh<'s>, target: Target) -> Self {
        let mut growth = Self {
            lit,
            target,
            asked: [f64::INFINITY; 2],
            found: Vec::new(),
            calibration: None,
            noise: [0.0; 2],
            noise_of_corrections: [0.0; 2],
            checked_at: 0,
            round: 0,
            least: ([f64::INFINITY; 2], 0),
            since: 0,
        };
        growth.asked = growth.target_squared();
        growth
    }

    /// The mesh as it is.
    pub fn lit(&self) -> &LitMesh<'s> {
        &self.lit
    }

    /// Gives the new vertices their light.
    pub fn take(&mut self, lights: Vec<Light>) {
        self.lit.take(lights);
    }

    /// What is asked of all causes together, squared, power then visible; infinite where nothing is.
    fn target_squared(&self) -> [f64; 2] {
        asked(&self.target)
    }

    /// Whether there may be no more vertices.
    pub fn is_full(&self) -> bool {
        self.lit.mesh().vertex_count() >= self.target.most_vertices
    }

    /// Whether it is time to check.
    pub fn wants_checks(&self) -> bool {
        let vertices = self.lit.mesh().vertex_count();
        let grown = f64::from(vertices) / f64::from(self.checked_at);
        if self.is_full() || grown >= GROWN {
            return true;
        }
        let Some(calibration) = self.calibration else {
            return true;
        };
        if grown < HARDLY_GROWN {
            return false;
        }
        let size = self.lit.size();
        let of_corners = all(&self.lit.likely(&size));
        let of_spots = all(&self.lit.likely_by_spots(&size));
        let asked = self.asked;
        let is_likely = |t: usize| calibration[t] * of_corners[t] + of_spots[t] <= asked[t];
        is_likely(0) && is_likely(1)
    }

    /// Points by chance at which to check, others for each round.
    pub fn checks(&mut self) -> Vec<Check> {
        self.checked_at = self.lit.mesh().vertex_count();
        self.round += 1;
        self.lit.checks(self.round)
    }

    /// What a sample says of the function, whose solution's iteration has this error.
    pub fn judge(&mut self, sample: &Sample, iterations: Errors) -> ErrorByCause {
        let [sources, pixels] = causes(&self.lit, sample);
        let pixels = sum(pixels, self.noise_of_corrections);
        self.noise = pixels;
        ErrorByCause {
            mesh: self.compare(sample),
            sources: errors(sources),
            pixels: errors(pixels.map(|square| VERTEX_NOISE * square)),
            iterations,
            ..ErrorByCause::default()
        }
        .added_up()
    }

    /// What the function misses at points at which this was gathered, but for what pixels bring.
    fn compare(&mut self, sample: &Sample) -> Errors {
        let Sample { checks, lights, .. } = sample;
        let size = self.lit.size();
        let (mut in_leaves, mut in_patches) = ([0.0; 2], [0.0; 2]);
        self.found.clear();
        for (check, light) in checks.iter().zip(lights) {
            let gathered = self.lit.reflectance(check) * light.irradiance();
            let weighed = |shown: DVec3| size.weighed(shown - gathered, gathered);
            match check.part {
                Part::Leaf(leaf) => {
                    let corners = self.lit.radiosities(leaf);
                    let weighed = weighed((0..3).map(|k| check.within[k] * corners[k]).sum());
                    in_leaves = [0, 1].map(|t| in_leaves[t] + check.area * weighed[t]);
                    let area = self.lit.mesh().area(leaf);
                    self.found.push((leaf, weighed.map(|w| area * w)));
                }
                Part::Patch(_, radiosity) => {
                    let weighed = weighed(radiosity);
                    in_patches = [0, 1].map(|t| in_patches[t] + check.area * weighed[t]);
                }
            }
        }
        let of_corners = all(&self.lit.likely(&size));
        let of_spots = all(&self.lit.likely_by_spots(&size));
        self.calibration = Some([0, 1].map(|t| {
            let others = (in_leaves[t] - of_spots[t]).max(LEAST_OTHERS * in_leaves[t]);
            others / of_corners[t].max(f64::MIN_POSITIVE)
        }));
        let missing = [0, 1].map(|t| in_leaves[t] + in_patches[t]);
        self.of_mesh(missing)
    }

    /// Whether more vertices have not made the mesh better for a while: then what is missing is not the mesh's.
    pub fn is_stuck(&mut self, mesh: Errors) -> bool {
        let found = squares(&mesh);
        let vertices = self.lit.mesh().vertex_count();
        let (least, at) = self.least;
        // What is small enough already may fall for ever.
        let falls = |t: usize| found[t] > self.asked[t] && found[t] < BETTER * least[t];
        if falls(0) || falls(1) {
            self.least = (found, vertices);
            self.since = 0;
        } else {
            self.since += 1;
        }
        self.since >= PATIENCE && f64::from(vertices) >= MORE * f64::from(at)
    }

    /// What is missing without what pixels bring, in a check and in the mean of three vertices.
    fn of_mesh(&self, missing: [f64; 2]) -> Errors {
        errors([0, 1].map(|t| (missing[t] - (1.0 + VERTEX_NOISE) * self.noise[t]).max(0.0)))
    }

    /// Whether these errors are as small as was asked for.
    pub fn is_reached(&self, errors: Errors) -> bool {
        is_below(errors, self.target_squared())
    }

    /// Whether these errors of the mesh are as small as they need be.
    pub fn is_enough(&self, mesh: Errors) -> bool {
        is_below(mesh, self.asked)
    }

    /// Asks of the mesh what the other causes leave of what is asked of all. Sources count unless they are going to be finer.
    pub fn ask(&mut self, error: &ErrorByCause, can_refine: bool) {
        let are_sources_final = !can_refine || !self.wants_finer_sources(error);
        let target = self.target_squared();
        let others = [error.pixels, error.iterations, error.sources];
        let others = others.iter().take(if are_sources_final { 3 } else { 2 });
        let others = others.map(squares).fold([0.0; 2], sum);
        self.asked = room(target, others);
    }

    /// Whether the size of sources takes more than its share of what is asked of all causes.
    pub fn wants_finer_sources(&self, error: &ErrorByCause) -> bool {
        let share = self.target_squared().map(|target| SOURCES_SHARE * target);
        !is_below(error.sources, share)
    }

    /// What this comes to that corrections are off by at places that look a second time, squared, power then visible.
    pub fn noise_of(&self, sample: &Sample, corrections: &[DVec3]) -> [f64; 2] {
        let size = self.lit.size();
        let for_others = sample.checks.len() as f64 / sample.looks.len().max(1) as f64;
        let places = sample.looks.iter().zip(corrections);
        let of_place = |(&(k, _), &correction): (&(usize, Look), &DVec3)| {
            let check = &sample.checks[k];
            let rho = self.lit.reflectance(check);
            let gathered = rho * sample.lights[k].irradiance();
            size.weighed(rho * correction, gathered)
                .map(|weighed| for_others * check.area * weighed)
        };
        places.map(of_place).fold([0.0; 2], sum)
    }

    /// Whether vertices may have such a noise, squared, of corrections that make the size of sources bring nothing: where it hardly
    /// counts, and where it counts less than what they bring.
    pub fn hardly_counts(&self, noise: [f64; 2]) -> bool {
        let target = self.target_squared();
        (0..2).all(|t| VERTEX_NOISE * noise[t] <= SOURCES_SHARE * target[t])
    }

    /// As above.
    pub fn is_worth(&self, noise: [f64; 2], error: &ErrorByCause) -> bool {
        let target = self.target_squared();
        let sources = squares(&error.sources);
        let least = |t: usize| (WORTH * sources[t]).max(SOURCES_SHARE * target[t]);
        (0..2).all(|t| VERTEX_NOISE * noise[t] <= least(t))
    }

    /// From now on what sources bring is corrected, with this noise.
    pub fn is_corrected(&mut self, noise: [f64; 2]) {
        self.noise_of_corrections = noise;
        self.start_again();
    }

    /// Gives all vertices another light.
    pub fn renew(&mut self, lights: &[Light]) {
        self.lit.renew(lights);
    }

    /// Gives patches that have no vertices theirs.
    pub fn light_patches(&mut self, irradiance: &[Rgb], is_lit: &dyn Fn(SurfaceId) -> bool) {
        self.lit.light_patches(irradiance, is_lit);
    }

    /// Forgets what checks have said of other light.
    fn start_again(&mut self) {
        self.least = ([f64::INFINITY; 2], 0);
        self.since = 0;
        self.calibration = None;
    }

    /// Bisects where most is likely to be missing, or was found to be. False where nothing can be bisected.
    pub fn grow(&mut self) -> bool {
        let before = self.lit.mesh().vertex_count();
        let size = self.lit.size();
        let asked = self.asked;
        let calibration = self.calibration.unwrap_or([1.0; 2]);
        let mut wanted: Vec<(f64, NodeId)> = Vec::new();
        let need = |missing: [f64; 2], scale: [f64; 2]| {
            // Whichever target is farther from what is asked.
            (0..2)
                .map(|t| scale[t] * missing[t] / asked[t])
                .fold(0.0, f64::max)
        };
        for (leaf, missing) in self.lit.likely(&size) {
            wanted.push((need(missing, calibration), leaf));
        }
        let found = std::mem::take(&mut self.found);
        for (leaf, missing) in self.lit.likely_by_spots(&size).into_iter().chain(found) {
            wanted.push((need(missing, [1.0; 2]), leaf));
        }
        wanted.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let all: f64 = wanted.iter().map(|(need, _)| need).sum();
        let mut marked = 0.0;
        for (need, leaf) in wanted {
            if marked > MARKED * all || self.is_full() {
                break;
            }
            marked += need;
            self.lit.bisect(leaf);
        }
        self.lit.mesh().vertex_count() > before
    }

    /// What is estimated of the error patch by patch, W/m^2.
    pub fn patch_errors(&self, error: &ErrorByCause) -> Vec<f32> {
        self.lit.patch_errors(error)
    }
}

/// What sources and pixels bring to a place, squared, each by target, as places tell that look a second time. What sources bring on
/// the whole is reflected on, as ambient light.
pub(super) fn causes(lit: &LitMesh, sample: &Sample) -> [[f64; 2]; 2] {
    let Sample {
        checks,
        lights,
        looks,
    } = sample;
    let size = lit.size();
    // Those that look stand for the others.
    let for_others = checks.len() as f64 / looks.len().max(1) as f64;
    let seen = || {
        looks.iter().map(|&(k, look)| {
            let rho = lit.reflectance(&checks[k]);
            (for_others * checks[k].area, rho, &lights[k], look)
        })
    };
    let mut ambient = Ambient::default();
    for (area, rho, light, look) in seen() {
        ambient.add(area, rho, look.by_function, light.by_sources);
    }
    let ambient = ambient.share(lit.absorbing_area());
    let mut sums = [[0.0; 2]; 2];
    for (area, rho, light, look) in seen() {
        let gathered = rho * light.irradiance();
        // Both looks have their own pixels.
        let by_pixels = (look.by_sources - light.by_sources) / SQRT_2;
        let by_sources = look.by_function + ambient * light.by_sources;
        for (sums, difference) in sums.iter_mut().zip([by_sources, by_pixels]) {
            let weighed = size.weighed(rho * difference, gathered);
            *sums = [0, 1].map(|t| sums[t] + area * weighed[t]);
        }
    }
    sums
}

/// What leaves miss together.
fn all(leaves: &[(NodeId, [f64; 2])]) -> [f64; 2] {
    let each = leaves.iter().map(|&(_, missing)| missing);
    each.fold([0.0; 2], sum)
}

/// What a target asks of all causes together, squared, power then visible; infinite where it asks nothing.
pub(super) fn asked(target: &Target) -> [f64; 2] {
    [target.power, target.visible].map(|error| error.map_or(f64::INFINITY, |error| error * error))
}

/// What is asked of one cause where all together are asked for this and the others have that, squared, power then visible.
pub(super) fn room(target: [f64; 2], others: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|t| {
        let room = target[t] - others[t];
        // Where nothing is asked there is room; else one that is much better than the rest is no use.
        if target[t].is_infinite() || room > LEAST_ROOM * target[t] {
            room
        } else {
            others[t]
        }
    })
}

/// Power, then visible.
pub(super) fn squares(errors: &Errors) -> [f64; 2] {
    [errors.power.powi(2), errors.visible.powi(2)]
}

/// Of sums of squares.
pub(super) fn errors([power, visible]: [f64; 2]) -> Errors {
    Errors {
        power: power.sqrt(),
        visible: visible.sqrt(),
    }
}

/// Whether errors are at most the roots of these.
pub(super) fn is_below(Errors { power, visible }: Errors, squares: [f64; 2]) -> bool {
    power.powi(2) <= squares[0] && visible.powi(2) <= squares[1]
}

#[cfg(test)]
mod tests {
    use scene::Scene;
    use scene::function::Refinement;

    use super::*;

    /// A closed room without light as yet.
    fn scene() -> Scene {
        let furnace = genx::Settings::new(genx::Model::Furnace);
        genx::make(&furnace).unwrap().scene
    }

    /// Pixels bring an error that was not asked for: it asks nothing of the mesh, and what was asked for leaves it the rest.
    #[test]
    fn what_nobody_asks_for_asks_nothing_of_the_mesh() {
        let scene = scene();
        let mesh = Refinement::new(&scene, |_| true, |_, _| true);
        for (power, visible) in [(Some(0.05), None), (None, Some(0.05))] {
            let target = Target::of(power, visible);
            let lit = LitMesh::new(&scene, mesh.clone());
            let mut growth = Growth::new(lit, target);
            let error = ErrorByCause {
                pixels: Errors::splat(0.03),
                ..ErrorByCause::default()
            };
            growth.ask(&error, false);
            for (asked, target) in growth.asked.into_iter().zip([power, visible]) {
                if target.is_some() {
                    assert!((asked - 0.04 * 0.04).abs() < 1e-12, "{asked}");
                } else {
                    assert!(asked == f64::INFINITY, "{asked}");
                }
            }
        }
    }
}
