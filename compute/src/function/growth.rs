//! Where a mesh grows, and what it is worth.

use std::f64::consts::SQRT_2;

use glam::DVec3;
use scene::function::{IrradianceFunction, NodeId, Refinement, VertexId};
use scene::{PatchId, Scene, SceneError};

use super::checks::{self, Candidate, Check, Part};
use super::gatherer::{Light, Look};
use super::{ErrorByCause, Errors, reflectances};
use crate::settings::Target;

/// Leaves that make this share of the sum of what they are likely to miss are bisected.
const MARKED: f64 = 0.4;

/// The fewest points at which a function is checked at a time, and their number as a share of the leaves beyond that.
const FEWEST_CHECKS: usize = 256;
const CHECKED: f64 = 0.02;

/// What one value a patch is taken to miss of it, relative, when points are drawn: most where it is bright, beside lamps.
const FLAT_MISSES: f64 = 0.1;

/// The function is checked whenever it has grown by this factor, and more often where little may be missing.
const GROWN: f64 = 1.5;

/// The share of the mean radiosity below which differences of radiosity count for less and less.
const FLOOR: f64 = 0.05;

/// The mean square of what is linear between three independent values, over theirs: the mean over a triangle of the sum of its
/// squared barycentric coordinates.
const VERTEX_NOISE: f64 = 0.5;

/// The least share of what is asked of all causes together that the mesh gets, squared; where the others leave less, it cannot be
/// reached.
const LEAST_ROOM: f64 = 0.1;

/// The share of what is asked of all causes together, squared, that the size of sources may take before they are refined.
const SOURCES_SHARE: f64 = 0.2;

/// A mesh is better if its squared error is below this share of the least so far, and after so many checks without that it will
/// not become better.
const BETTER: f64 = 0.9;
const PATIENCE: u32 = 3;

/// A patch that has no vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlatPatch {
    pub patch: PatchId,
    /// m^2.
    pub area: f64,
    /// Reflected radiosity, W/m^2.
    pub radiosity: DVec3,
}

/// A mesh on its way.
pub(super) struct Growth<'s> {
    mesh: Refinement,
    scene: &'s Scene,
    /// What has no vertices.
    flat: Vec<FlatPatch>,
    target: Target,
    /// What is asked of the mesh, squared, power then visible.
    asked: [f64; 2],
    /// One per surface.
    reflectance: Vec<DVec3>,
    /// One per vertex that has gathered.
    lights: Vec<Light>,
    /// What the last checks have found, each as if all of its leaf missed as much, by target.
    found: Vec<(NodeId, [f64; 2])>,
    /// What is missing, over what corners say is likely to be, as the last checks say; by target.
    calibration: Option<[f64; 2]>,
    /// What pixels bring to a point, squared, power then visible, as the last second look says.
    noise: [f64; 2],
    /// How many vertices there were when it was checked last.
    checked_at: u32,
    /// The mesh's least error so far, squared, power then visible, and how many checks since then have found no better one.
    least: ([f64; 2], u32),
}

impl<'s> Growth<'s> {
    /// A mesh whose vertices have no light as yet, and what has no vertices.
    pub fn new(scene: &'s Scene, mesh: Refinement, flat: Vec<FlatPatch>, target: Target) -> Self {
        let mut growth = Self {
            scene,
            flat,
            mesh,
            target,
            asked: [f64::INFINITY; 2],
            reflectance: reflectances(scene),
            lights: Vec::new(),
            found: Vec::new(),
            calibration: None,
            noise: [0.0; 2],
            checked_at: 0,
            least: ([f64::INFINITY; 2], 0),
        };
        growth.asked = growth.target_squared();
        growth
    }

    pub fn mesh(&self) -> &Refinement {
        &self.mesh
    }

    /// The area that has vertices, m^2.
    pub fn area(&self) -> f64 {
        self.mesh.leaves().map(|leaf| self.mesh.area(leaf)).sum()
    }

    /// The vertices that have no light yet.
    pub fn new_vertices(&self) -> impl Iterator<Item = VertexId> + use<> {
        (self.lights.len() as u32..self.mesh.vertex_count()).map(VertexId)
    }

    /// Gives them theirs.
    pub fn take(&mut self, lights: Vec<Light>) {
        self.lights.extend(lights);
    }

    /// Reflected radiosities at the corners of a leaf, W/m^2.
    fn radiosities(&self, leaf: NodeId) -> [DVec3; 3] {
        let rho = self.reflectance[self.mesh.surface(leaf).index()];
        self.mesh
            .corners(leaf)
            .map(|vertex| rho * self.lights[vertex.0 as usize].irradiance)
    }

    /// What reflected radiosities are compared with.
    fn size(&self) -> Size {
        let mut size = Size::default();
        for leaf in self.mesh.leaves() {
            let [a, b, c] = self.radiosities(leaf);
            let area = self.mesh.area(leaf);
            size.area += area;
            // Of what is linear between the corners.
            let square = (a * a + b * b + c * c + a * b + b * c + c * a).element_sum() / 6.0;
            size.square += area * square;
            size.mean += area * (a + b + c).element_sum() / 9.0;
        }
        for &FlatPatch {
            area, radiosity, ..
        } in &self.flat
        {
            size.area += area;
            size.square += area * radiosity.length_squared();
            size.mean += area * radiosity.element_sum() / 3.0;
        }
        size.square /= size.area.max(f64::MIN_POSITIVE);
        size.mean /= size.area.max(f64::MIN_POSITIVE);
        size
    }

    /// A difference of radiosities as each target weighs it: squared, over what the target relates it to.
    fn weighed(difference: DVec3, radiosity: DVec3, size: &Size) -> [f64; 2] {
        let power = difference.length_squared() / size.square.max(f64::MIN_POSITIVE);
        let floor = FLOOR * size.mean;
        let relative = difference / (radiosity.max(DVec3::ZERO) + floor.max(f64::MIN_POSITIVE));
        [
            power / size.area,
            relative.length_squared() / 3.0 / size.area,
        ]
    }

    /// What each leaf is likely to miss, by target: the largest difference of its corners, by area.
    fn likely(&self, size: &Size) -> Vec<(NodeId, [f64; 2])> {
        let of_leaf = |leaf: NodeId| {
            let corners = self.radiosities(leaf);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let area = self.mesh.area(leaf);
            let mut most = [0.0_f64; 2];
            for k in 0..3 {
                let difference = corners[k] - corners[(k + 1) % 3];
                let weighed = Self::weighed(difference, middle, size);
                most = [0, 1].map(|t| most[t].max(area * weighed[t]));
            }
            (leaf, most)
        };
        self.mesh.leaves().map(of_leaf).collect()
    }

    /// What is asked of all causes together, squared, power then visible; infinite where nothing is.
    fn target_squared(&self) -> [f64; 2] {
        [self.target.power, self.target.visible]
            .map(|error| error.map_or(f64::INFINITY, |error| error * error))
    }

    /// Whether there may be no more vertices.
    pub fn is_full(&self) -> bool {
        self.mesh.vertex_count() >= self.target.most_vertices
    }

    /// Whether it is time to check.
    pub fn wants_checks(&self) -> bool {
        let vertices = self.mesh.vertex_count();
        if self.is_full() || f64::from(vertices) >= GROWN * f64::from(self.checked_at) {
            return true;
        }
        let Some(calibration) = self.calibration else {
            return true;
        };
        let likely = self.likely(&self.size());
        let asked = self.asked;
        let is_likely = |t: usize| {
            let sum: f64 = likely.iter().map(|(_, missing)| missing[t]).sum();
            calibration[t] * sum <= asked[t]
        };
        is_likely(0) && is_likely(1)
    }

    /// Points by chance, in leaves by what they are likely to miss.
    pub fn checks(&mut self) -> Vec<Check> {
        let size = self.size();
        let likely = self.likely(&size);
        let of_patch = |flat: &FlatPatch| {
            let missing = Self::weighed(FLAT_MISSES * flat.radiosity, flat.radiosity, &size);
            missing.map(|missing| flat.area * missing)
        };
        let in_all = likely.iter().map(|(_, missing)| *missing);
        let in_all = in_all.chain(self.flat.iter().map(of_patch));
        let sums = in_all.fold([0.0; 2], |sums, missing| {
            [0, 1].map(|t| sums[t] + missing[t])
        });
        // By both targets, and by area, so that nothing is left out for good.
        let share = |missing: [f64; 2], area: f64| {
            let of_targets = (0..2).map(|t| missing[t] / sums[t].max(f64::MIN_POSITIVE));
            (of_targets.sum::<f64>() + area / size.area) / 3.0
        };
        let count = FEWEST_CHECKS.max((CHECKED * likely.len() as f64) as usize);
        self.checked_at = self.mesh.vertex_count();
        let in_leaves = likely.iter().map(|&(leaf, missing)| {
            let area = self.mesh.area(leaf);
            Candidate {
                part: Part::Leaf(leaf),
                surface: self.mesh.surface(leaf),
                corners: self.mesh.in_surface(leaf),
                area,
                share: share(missing, area),
            }
        });
        let in_patches = self.flat.iter().map(|flat| Candidate {
            part: Part::Patch(flat.radiosity),
            surface: self.scene.mesh().surface_of(flat.patch),
            corners: self.scene.patch_in_surface(flat.patch),
            area: flat.area,
            share: share(of_patch(flat), flat.area),
        });
        checks::draw(in_leaves.chain(in_patches), count, self.checked_at)
    }

    /// What the function misses at points at which this was gathered, but for what pixels bring.
    pub fn compare(&mut self, checks: &[Check], lights: &[Light]) -> Errors {
        let size = self.size();
        let (mut in_leaves, mut in_patches) = ([0.0; 2], [0.0; 2]);
        self.found.clear();
        for (check, light) in checks.iter().zip(lights) {
            let gathered = self.reflectance[check.place.surface.index()] * light.irradiance;
            let weighed = |shown: DVec3| Self::weighed(shown - gathered, gathered, &size);
            match check.part {
                Part::Leaf(leaf) => {
                    let corners = self.radiosities(leaf);
                    let weighed = weighed((0..3).map(|k| check.within[k] * corners[k]).sum());
                    in_leaves = [0, 1].map(|t| in_leaves[t] + check.area * weighed[t]);
                    let area = self.mesh.area(leaf);
                    self.found.push((leaf, weighed.map(|w| area * w)));
                }
                Part::Patch(radiosity) => {
                    let weighed = weighed(radiosity);
                    in_patches = [0, 1].map(|t| in_patches[t] + check.area * weighed[t]);
                }
            }
        }
        let likely = self.likely(&size);
        self.calibration = Some([0, 1].map(|t| {
            let sum: f64 = likely.iter().map(|(_, missing)| missing[t]).sum();
            in_leaves[t] / sum.max(f64::MIN_POSITIVE)
        }));
        let missing = [0, 1].map(|t| in_leaves[t] + in_patches[t]);
        self.of_mesh(missing)
    }

    /// Whether more vertices have not made the mesh better for a while: then what is missing is not the mesh's.
    pub fn is_stuck(&mut self, mesh: Errors) -> bool {
        let found = [mesh.power.powi(2), mesh.visible.powi(2)];
        let (least, since) = &mut self.least;
        let falls = |t: usize| self.asked[t].is_finite() && found[t] < BETTER * least[t];
        if falls(0) || falls(1) {
            *least = found;
            *since = 0;
        } else {
            *since += 1;
        }
        *since >= PATIENCE
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

    /// What sources and pixels bring, by what places see when they look a second time.
    pub fn causes(&mut self, checks: &[Check], lights: &[Light], looks: &[Look]) -> [Errors; 2] {
        let size = self.size();
        let mut sums = [[0.0; 2]; 2];
        for ((check, light), look) in checks.iter().zip(lights).zip(looks) {
            let rho = self.reflectance[check.place.surface.index()];
            let gathered = rho * light.irradiance;
            // Both looks have their own pixels.
            let by_pixels = (look.by_sources - light.by_sources) / SQRT_2;
            for (sums, difference) in sums.iter_mut().zip([look.by_function, by_pixels]) {
                let weighed = Self::weighed(rho * difference, gathered, &size);
                *sums = [0, 1].map(|t| sums[t] + check.area * weighed[t]);
            }
        }
        let [sources, pixels] = sums;
        self.noise = pixels;
        [
            errors(sources),
            errors(pixels.map(|square| VERTEX_NOISE * square)),
        ]
    }

    /// Asks of the mesh what the other causes leave of what is asked of all; sources count where they are what they will be.
    pub fn ask(&mut self, error: &ErrorByCause, are_sources_final: bool) {
        let target = self.target_squared();
        let ErrorByCause {
            sources,
            pixels,
            iterations,
            ..
        } = error;
        let others = [*pixels, *iterations, *sources];
        let others = others.iter().take(if are_sources_final { 3 } else { 2 });
        let others = others.fold([0.0; 2], |sums, error| {
            [
                sums[0] + error.power.powi(2),
                sums[1] + error.visible.powi(2),
            ]
        });
        self.asked = [0, 1].map(|t| {
            let room = target[t] - others[t];
            // Where nothing is asked there is room; else a mesh that is much better than the rest is no use.
            if target[t].is_infinite() || room > LEAST_ROOM * target[t] {
                room
            } else {
                others[t]
            }
        });
    }

    /// Whether the mesh is good enough, but the size of sources takes more than its share of what is asked of all causes.
    pub fn wants_finer_sources(&self, error: &ErrorByCause) -> bool {
        let target = self.target_squared();
        let share = target.map(|target| SOURCES_SHARE * target);
        self.is_enough(error.mesh) && !is_below(error.sources, share)
    }

    /// Adds to what vertices receive, one value per vertex, W/m^2; the function is checked again.
    pub fn add(&mut self, more: &[DVec3]) {
        self.least = ([f64::INFINITY; 2], 0);
        for (light, &more) in self.lights.iter_mut().zip(more) {
            light.add_reflected(more);
        }
        self.calibration = None;
    }

    /// Bisects where most is likely to be missing, or was found to be.
    pub fn grow(&mut self) {
        let size = self.size();
        let asked = self.asked;
        let calibration = self.calibration.unwrap_or([1.0; 2]);
        let mut wanted: Vec<(f64, NodeId)> = Vec::new();
        let need = |missing: [f64; 2], scale: [f64; 2]| {
            // Whichever target is farther from what is asked.
            (0..2)
                .map(|t| scale[t] * missing[t] / asked[t])
                .fold(0.0, f64::max)
        };
        for (leaf, missing) in self.likely(&size) {
            wanted.push((need(missing, calibration), leaf));
        }
        for (leaf, missing) in std::mem::take(&mut self.found) {
            wanted.push((need(missing, [1.0; 2]), leaf));
        }
        wanted.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let all: f64 = wanted.iter().map(|(need, _)| need).sum();
        let mut sum = 0.0;
        for (need, leaf) in wanted {
            if sum > MARKED * all || self.is_full() {
                break;
            }
            sum += need;
            self.mesh.bisect(leaf);
        }
    }

    /// The function as it is; an error where a value is beyond what f32 holds.
    pub fn function(&self) -> Result<IrradianceFunction, SceneError> {
        let mesh = self.mesh.mesh()?;
        let lights = self.lights.iter();
        let irradiance = lights.clone().map(|light| light.irradiance.as_vec3());
        let direct = lights.map(|light| light.direct.as_vec3());
        IrradianceFunction::new(mesh, irradiance.collect(), direct.collect())
    }
}

/// Of sums of squares.
fn errors([power, visible]: [f64; 2]) -> Errors {
    Errors {
        power: power.sqrt(),
        visible: visible.sqrt(),
    }
}

/// Whether errors are at most the roots of these.
fn is_below(Errors { power, visible }: Errors, squares: [f64; 2]) -> bool {
    power.powi(2) <= squares[0] && visible.powi(2) <= squares[1]
}

/// The size of the mesh and of the reflected radiosity on it.
#[derive(Clone, Copy, Debug, Default)]
struct Size {
    /// m^2.
    area: f64,
    /// Mean of the square, summed over channels, (W/m^2)^2.
    square: f64,
    /// Mean over area and channels, W/m^2.
    mean: f64,
}

#[cfg(test)]
mod tests {
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
            let target = Target {
                power,
                visible,
                most_vertices: 100,
            };
            let mut growth = Growth::new(&scene, mesh.clone(), Vec::new(), target);
            let none = Errors::default();
            let error = ErrorByCause::new(none, none, Errors::splat(0.03), none);
            growth.ask(&error, true);
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
