//! All hemicubes of a scene: how many each patch has, where they stand, what their pixels count.
//!
//! # Theory
//! A form factor between patches is the mean over the first patch of what its points see of the second.
//! One hemicube at the centroid is the midpoint rule. Better rules stand on the patch's own bisection
//! tree, so that their points have equal weights and cover equal areas:
//!
//! - the centroids of the 2^k triangles of the tree's level k, right for what is linear over each;
//! - three points in each of them, at barycentric coordinates (2/3, 1/6, 1/6) and their permutations,
//!   right for what is quadratic (Hammer and Stroud, "Numerical integration over simplexes and cones",
//!   Mathematical Tables and Other Aids to Computation 10, 1956).
//!
//! For two faces of a cube, each two triangles, three points in each of two triangles make errors of 0.06
//! and 0.01 percent, 32 centroids 0.3 and 0.08.
//!
//! # Practice
//! Hemicubes are numbered through the scene, patch by patch. A hemicube's place on the gpu follows from its number, its
//! turn about its normal from where it stands, so that rows do not depend on what is drawn with them.

mod point_count;
mod turn;

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use scene::{PatchId, Scene, SurfaceId};
use visibility::{Drawable, Frame};

use crate::delta_form_factors::DeltaFormFactors;
use crate::rows::UNITS_PER_ONE;
use crate::settings::{FormFactorSettings, Points};
use turn::turn;

/// Where the hemicubes of one patch stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// At the centroids of the triangles after some bisections.
    Centroids { bisections: u32 },
    /// At three points in each triangle after some bisections.
    ThreePoint { bisections: u32 },
    /// At the corners, drawn in a little.
    Corners,
}

/// Share of the way to the centroid by which points at a patch's corners are drawn in, so that they
/// lie on the patch and not in the plane of the wall that meets it there.
const CORNER_INSET: f64 = 1.0 / 64.0;

impl Rule {
    /// Points a patch.
    fn count(self) -> u32 {
        match self {
            Self::Centroids { bisections } => 1 << bisections,
            Self::ThreePoint { bisections } => 3 << bisections,
            Self::Corners => 3,
        }
    }

    /// The points of a triangle, in the order of its bisection tree.
    fn points(self, corners: [DVec3; 3]) -> Vec<DVec3> {
        let parts = |bisections: u32| {
            (0..1 << bisections).map(move |code| {
                scene::bisection::leaf_corners(bisections, code)
                    .map(|b| b.x * corners[0] + b.y * corners[1] + b.z * corners[2])
            })
        };
        let centroid = |[a, b, c]: [DVec3; 3]| (a + b + c) / 3.0;
        match self {
            Self::Centroids { bisections } => parts(bisections).map(centroid).collect(),
            Self::ThreePoint { bisections } => parts(bisections)
                .flat_map(|part| {
                    let sum = part[0] + part[1] + part[2];
                    part.map(|corner| 0.5 * corner + sum / 6.0)
                })
                .collect(),
            Self::Corners => {
                let inwards = centroid(corners);
                corners
                    .map(|corner| corner.lerp(inwards, CORNER_INSET))
                    .to_vec()
            }
        }
    }
}

/// All hemicubes of a scene.
#[derive(Debug)]
pub struct Hemicubes<'a> {
    receivers: &'a Scene,
    drawable: Arc<Drawable<'a>>,
    settings: FormFactorSettings,
    /// Where patches have different rules: the number of each patch's first hemicube, then that of all.
    firsts: Option<Vec<u32>>,
    /// By the number of hemicubes a patch has.
    delta_form_factors: BTreeMap<u32, DeltaFormFactors>,
}

impl<'a> Hemicubes<'a> {
    /// The hemicubes of a scene; for [`Points::Auto`] each patch's surroundings are looked at, on the
    /// threads of the rayon pool it is called in.
    pub fn new(scene: &'a Scene, settings: FormFactorSettings) -> Self {
        Self::between(scene, &Arc::new(Drawable::new(scene)), settings)
    }

    /// Hemicubes that stand on the patches of one mesh and see those of another one, over the same surfaces: a
    /// row has an entry for each of `sources`' patches. Each of those is one of `receivers`' or several.
    ///
    /// # Panics
    /// Where the surfaces are not as many.
    pub fn between(
        receivers: &'a Scene,
        sources: &Arc<Drawable<'a>>,
        settings: FormFactorSettings,
    ) -> Self {
        assert_eq!(receivers.surfaces().len(), sources.scene().surfaces().len());
        let mut hemicubes = Self {
            receivers,
            drawable: Arc::clone(sources),
            settings,
            firsts: (settings.points == Points::Auto)
                .then(|| point_count::firsts(receivers, sources)),
            delta_form_factors: BTreeMap::new(),
        };
        let mut counts: Vec<u32> = match &hemicubes.firsts {
            Some(firsts) => firsts.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            None => vec![hemicubes.rule(PatchId(0)).count()],
        };
        counts.sort_unstable();
        counts.dedup();
        let table = |count: u32| {
            let units = UNITS_PER_ONE / count;
            (
                count,
                DeltaFormFactors::new(settings.maps, settings.resolution, units),
            )
        };
        hemicubes.delta_form_factors = counts.into_iter().map(table).collect();
        hemicubes
    }

    /// The scene on whose patches they stand.
    pub fn receivers(&self) -> &'a Scene {
        self.receivers
    }

    /// The scene whose patches they see: the same one, but for [`Self::between`].
    pub fn sources(&self) -> &'a Scene {
        self.drawable.scene()
    }

    /// The surface that a patch, and so its hemicubes, stand on.
    pub fn surface_of(&self, patch: PatchId) -> SurfaceId {
        self.receivers.mesh().surface_of(patch)
    }

    /// The patches that a source is made of; itself, but for [`Self::between`].
    pub fn receivers_of(&self, source: PatchId) -> Range<u32> {
        let mesh = self.sources().mesh();
        let surface = mesh.surface_of(source);
        let (coarse, fine) = (mesh.tree(surface), self.receivers.mesh().tree(surface));
        fine.node(coarse.depth, source.0 - coarse.first_patch.0)
    }

    /// What item buffers draw of the sources.
    pub fn drawable(&self) -> &Arc<Drawable<'a>> {
        &self.drawable
    }

    /// What was asked for.
    pub fn settings(&self) -> FormFactorSettings {
        self.settings
    }

    /// How many hemicubes a patch has.
    pub fn count(&self, patch: PatchId) -> u32 {
        self.rule(patch).count()
    }

    /// Number of a patch's first hemicube, of those of all patches; for the patch after the last one, the
    /// number of all.
    pub fn first(&self, patch: PatchId) -> u64 {
        match &self.firsts {
            Some(firsts) => firsts[patch.0 as usize].into(),
            None => u64::from(patch.0) * u64::from(self.rule(patch).count()),
        }
    }

    /// How many hemicubes there are.
    pub fn total(&self) -> u64 {
        self.first(PatchId(self.receivers.patch_count()))
    }

    /// What the pixels of a patch that has `count` hemicubes count.
    ///
    /// # Panics
    /// Where no patch has that many.
    pub fn delta_form_factors(&self, count: u32) -> &DeltaFormFactors {
        &self.delta_form_factors[&count]
    }

    /// The tables of [`Self::delta_form_factors`], by the number of hemicubes of a patch, ascending.
    pub fn tables(&self) -> impl Iterator<Item = (u32, &DeltaFormFactors)> {
        self.delta_form_factors
            .iter()
            .map(|(&count, table)| (count, table))
    }

    /// Where the hemicubes of a patch stand; its form factors are the mean over them. Their normal is that of the
    /// wall that the patch's surface is drawn with: a sliver's own one is not known as well.
    pub fn frames(&self, patch: PatchId) -> Vec<Frame> {
        let geometry = self.receivers.patch(patch);
        let normal = self.drawable.normal_of(geometry.surface);
        let surface = self.receivers.surface(geometry.surface);
        let rule = self.rule(patch);
        let points = rule.points(geometry.corners.map(Vec3::as_dvec3));
        let on_surface = rule.points(self.receivers.patch_in_surface(patch));
        points
            .into_iter()
            .zip(on_surface)
            .map(|(point, barycentric)| {
                let turn = turn(surface, barycentric, self.settings.turns);
                Frame::on_patch(&geometry, normal, point, turn)
            })
            .collect()
    }

    fn rule(&self, patch: PatchId) -> Rule {
        match self.settings.points {
            Points::Bisected { bisections } => Rule::Centroids { bisections },
            Points::ThreePoint { bisections } => Rule::ThreePoint { bisections },
            Points::Vertices => Rule::Corners,
            Points::Auto => self
                .firsts
                .as_ref()
                .and_then(|firsts| firsts.get(patch.0 as usize..=patch.0 as usize + 1))
                .map_or(point_count::FEWEST, |pair| {
                    point_count::rule(pair[1] - pair[0])
                }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] = [
        DVec3::new(0.5, 0.25, 1.0),
        DVec3::new(3.0, 0.75, -1.0),
        DVec3::new(1.0, 2.0, 0.5),
    ];

    /// Mean over a triangle. A fine
    /// midpoint rule has an error of h^2/24 times second derivatives below 40, h^2 = 4^-9.
    fn mean(f: impl Fn(DVec3) -> f64) -> f64 {
        let fine = Rule::Centroids { bisections: 18 };
        let points = fine.points(CORNERS);
        points.iter().map(|&p| f(p)).sum::<f64>() / points.len() as f64
    }

    #[test]
    fn rules_are_right_to_their_degree() {
        let quadratic = |p: DVec3| 1.0 + p.x - 2.0 * p.z + p.x * p.y - p.y * p.y + 0.5 * p.z * p.x;
        let by = |rule: Rule| {
            let points = rule.points(CORNERS);
            assert_eq!(points.len() as u32, rule.count());
            points.iter().map(|&p| quadratic(p)).sum::<f64>() / points.len() as f64
        };
        let exact = mean(quadratic);
        for bisections in 0..4 {
            let error = (by(Rule::ThreePoint { bisections }) - exact).abs();
            assert!(error < 40.0 / 24.0 * 0.25_f64.powi(9), "{error}");
        }
        // The midpoint rule's error falls by two with each bisection, but is there.
        let error = |bisections| (by(Rule::Centroids { bisections }) - exact).abs();
        assert!(error(0) > 0.01 && error(4) < error(0) / 8.0);
    }

    #[test]
    fn points_lie_inside() {
        let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
        for rule in [
            Rule::Centroids { bisections: 3 },
            Rule::ThreePoint { bisections: 3 },
            Rule::Corners,
        ] {
            for p in rule.points(CORNERS) {
                let [a, b, c] = CORNERS;
                let parts = area([a, b, p]) + area([b, c, p]) + area([c, a, p]);
                assert!((parts / area(CORNERS) - 1.0).abs() < 1e-12, "{rule:?}");
            }
        }
    }
}
