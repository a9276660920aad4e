//! What sources receive on the mean by the function, and how much it varies within them.

use glam::DVec3;
use scene::function::{NodeId, Refinement};
use scene::{Scene, bisection};

use super::Receives;
use super::gatherer::Light;

/// The fewest leaves that tell the mean over a source better than its own row does.
const FEWEST_LEAVES: u32 = 4;

/// What a source receives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Means {
    pub receives: Receives,
    /// The mean of the function as it is, linear between vertices, W/m^2; `None` where it has no vertices.
    pub linear: Option<DVec3>,
    /// The variance over the source of what is reflected of it, summed over channels, (W/m^2)^2.
    pub variance: f64,
}

/// What sources receive by the function, one per source: their mean, or where they have so few vertices that their own rows tell
/// as much, what is not in these. `sources` is the scene whose patches they are;
/// the mesh has a light a vertex and a reflectance a surface.
///
/// What is linear misses where light is brightest, so that all would be too dark. Of a triangle's quarters it misses a quarter of
/// what it misses of the triangle if second derivatives are constant, so that three quarters of it are known: the
/// difference of both, and a third of that is what is missed yet (Romberg, "Vereinfachte numerische Integration", 1955).
pub(super) fn means(
    mesh: &Refinement,
    lights: &[Light],
    reflectance: &[DVec3],
    sources: &Scene,
) -> Vec<Means> {
    let mut parts = vec![Parts::default(); sources.patch_count() as usize];
    let missed = missed_of_means(mesh, lights);
    for leaf in mesh.leaves() {
        let tree = sources.mesh().tree(mesh.surface(leaf));
        let (depth, code) = mesh.bisections(leaf);
        let rho = reflectance[mesh.surface(leaf).index()];
        let corners = mesh.corners(leaf);
        let lights = corners.map(|vertex| &lights[vertex.0 as usize]);
        let area = mesh.area(leaf);
        if let Some(deeper) = depth.checked_sub(tree.depth) {
            let source = tree.first_patch.0 + (code >> deeper);
            let part = &mut parts[source as usize];
            part.add(area, lights, [DVec3::X, DVec3::Y, DVec3::Z], rho);
            part.missed += area * missed[leaf.0 as usize];
            continue;
        }
        let deeper = tree.depth - depth;
        for within in 0..1 << deeper {
            let source = tree.first_patch.0 + (code << deeper | within);
            let corners = bisection::leaf_corners(deeper, within);
            parts[source as usize].add(area, lights, corners, rho);
        }
    }
    parts.into_iter().map(Parts::means).collect()
}

/// What leaves are likely to miss of their means, W/m^2, one per triangle there is or was.
fn missed_of_means(mesh: &Refinement, lights: &[Light]) -> Vec<DVec3> {
    let mean = |node: NodeId| -> DVec3 {
        let corners = mesh.corners(node).into_iter();
        let irradiance = corners.map(|vertex| lights[vertex.0 as usize].irradiance());
        irradiance.sum::<DVec3>() / 3.0
    };
    let nodes = mesh.nodes();
    let mut missed = vec![DVec3::ZERO; nodes.len()];
    for node in nodes {
        let halves = mesh.halves(node);
        let quarters = halves.map(|halves| halves.map(|half| mesh.halves(half)));
        let Some([Some([a, b]), Some([c, d])]) = quarters else {
            continue;
        };
        let quarters = [a, b, c, d];
        let finer = quarters.map(mean).into_iter().sum::<DVec3>() / 4.0;
        for quarter in quarters {
            missed[quarter.0 as usize] = (finer - mean(node)) / 3.0;
        }
    }
    missed
}

/// Leaves within a source, or one that it is a part of.
#[derive(Clone, Copy, Debug, Default)]
struct Parts {
    leaves: u32,
    /// m^2.
    area: f64,
    /// Integrals, W.
    irradiance: DVec3,
    missed: DVec3,
    correction: DVec3,
    /// What is reflected, and its square, summed over channels.
    reflected: DVec3,
    square: f64,
}

impl Parts {
    /// One more, of so many m^2, with the light of its corners and its reflectance; the source's part of it has these corners
    /// in it.
    fn add(&mut self, area: f64, lights: [&Light; 3], corners: [DVec3; 3], rho: DVec3) {
        let reflected = corners.map(|at| {
            let lights = lights.iter().zip(at.to_array());
            rho * lights
                .map(|(light, w)| w * light.irradiance())
                .sum::<DVec3>()
        });
        self.reflected += area * reflected.into_iter().sum::<DVec3>() / 3.0;
        self.square += area * mean_square(reflected);
        let middle = corners.into_iter().sum::<DVec3>() / 3.0;
        let weights = (area * middle).to_array();
        self.leaves += 1;
        self.area += area;
        for (light, weight) in lights.into_iter().zip(weights) {
            self.irradiance += weight * light.irradiance();
            self.correction += weight * light.correction;
        }
    }

    fn means(self) -> Means {
        if self.leaves == 0 {
            return Means {
                receives: Receives::BesidesItsRow(DVec3::ZERO),
                linear: None,
                variance: 0.0,
            };
        }
        let receives = if self.leaves >= FEWEST_LEAVES {
            let mean = (self.irradiance + self.missed) / self.area;
            Receives::OnTheMean(mean.max(DVec3::ZERO))
        } else {
            Receives::BesidesItsRow(self.correction / self.area)
        };
        Means {
            receives,
            linear: Some(self.irradiance / self.area),
            variance: (self.square / self.area - (self.reflected / self.area).length_squared())
                .max(0.0),
        }
    }
}

/// The mean square, summed over channels, of what is linear between the corners of a triangle.
pub(super) fn mean_square([a, b, c]: [DVec3; 3]) -> f64 {
    (a * a + b * b + c * c + a * b + b * c + c * a).element_sum() / 6.0
}
