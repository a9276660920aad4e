//! The patches of a scene as receivers.

use std::sync::Arc;

use glam::Vec3;
use scene::{PatchId, Scene, SurfaceId};
use visibility::{Drawable, Frame};

use super::point_count;
use super::rule::Rule;
use super::turn::turn;
use super::{ReceiverId, Receivers};
use crate::settings::{Points, Seed};

/// The patches of a scene; receiver i is patch i.
#[derive(Debug)]
pub struct Patches<'a> {
    scene: &'a Scene,
    /// Of the same surfaces.
    drawable: Arc<Drawable<'a>>,
    points: Points,
    seed: Seed,
    /// Where patches have different rules: the number of each patch's first point, then that of all.
    firsts: Option<Vec<u32>>,
}

impl<'a> Patches<'a> {
    /// The patches of a scene; for [`Points::Auto`] each patch's surroundings are looked at, on the threads of the
    /// rayon pool it is called in. What is drawn may have coarser patches over the same surfaces.
    ///
    /// # Panics
    /// Where the surfaces are not as many.
    pub fn new(scene: &'a Scene, drawable: &Arc<Drawable<'a>>, points: Points, seed: Seed) -> Self {
        assert_eq!(scene.surfaces().len(), drawable.scene().surfaces().len());
        Self {
            scene,
            drawable: Arc::clone(drawable),
            points,
            seed,
            firsts: (points == Points::Auto).then(|| point_count::firsts(scene, drawable)),
        }
    }

    fn rule(&self, patch: u32) -> Rule {
        match self.points {
            Points::Bisected { bisections } => Rule::Centroids { bisections },
            Points::ThreePoint { bisections } => Rule::ThreePoint { bisections },
            Points::Vertices => Rule::Corners,
            Points::Auto => self
                .firsts
                .as_ref()
                .and_then(|firsts| firsts.get(patch as usize..=patch as usize + 1))
                .map_or(point_count::FEWEST, |pair| {
                    point_count::rule(pair[1] - pair[0])
                }),
        }
    }
}

impl Receivers for Patches<'_> {
    fn count(&self) -> u32 {
        self.scene.patch_count()
    }

    fn point_count(&self, receiver: ReceiverId) -> u32 {
        self.rule(receiver.0).count()
    }

    fn first_point(&self, receiver: ReceiverId) -> u64 {
        match &self.firsts {
            Some(firsts) => firsts[receiver.0 as usize].into(),
            None => u64::from(receiver.0) * u64::from(self.rule(receiver.0).count()),
        }
    }

    fn point_counts(&self) -> Vec<u32> {
        let mut counts: Vec<u32> = match &self.firsts {
            Some(firsts) => firsts.windows(2).map(|pair| pair[1] - pair[0]).collect(),
            None => vec![self.rule(0).count()],
        };
        counts.sort_unstable();
        counts.dedup();
        counts
    }

    fn frames(&self, receiver: ReceiverId) -> Vec<Frame> {
        self.frames_by(self.rule(receiver.0), PatchId(receiver.0))
    }

    fn surface(&self, receiver: ReceiverId) -> Option<SurfaceId> {
        Some(self.scene.mesh().surface_of(PatchId(receiver.0)))
    }
}

impl Patches<'_> {
    /// Their normal is that of the wall that the patch's surface is drawn with: a sliver's own one is not known as well.
    fn frames_by(&self, rule: Rule, patch: PatchId) -> Vec<Frame> {
        let geometry = self.scene.patch(patch);
        let normal = self.drawable.normal_of(geometry.surface);
        let surface = self.scene.surface(geometry.surface);
        let points = rule.points(geometry.corners.map(Vec3::as_dvec3));
        let on_surface = rule.points(self.scene.patch_in_surface(patch));
        points
            .into_iter()
            .zip(on_surface)
            .map(|(point, barycentric)| {
                let turn = turn(surface, barycentric, self.seed);
                Frame::on_patch(&geometry, normal, point, turn)
            })
            .collect()
    }
}

/// Some patches, each at so many times as many points or more, by a rule of another kind or order where these are more, and otherwise
/// turned.
#[derive(Debug)]
pub struct Closer<'a> {
    patches: Patches<'a>,
    chosen: Vec<PatchId>,
    rules: Vec<Rule>,
    /// The number of each receiver's first point, then that of all.
    firsts: Vec<u64>,
}

impl<'a> Closer<'a> {
    /// Some of these patches; receiver i is the i-th of them.
    pub fn new(mut patches: Patches<'a>, chosen: Vec<PatchId>, times: u32) -> Self {
        let rule = |patch: &PatchId| match (patches.rule(patch.0), times) {
            (rule, 1) => rule,
            (rule, times) => Rule::of_at_least(times * rule.count()),
        };
        let rules: Vec<Rule> = chosen.iter().map(rule).collect();
        let mut firsts = vec![0];
        for rule in &rules {
            firsts.push(firsts[firsts.len() - 1] + u64::from(rule.count()));
        }
        patches.seed = patches.seed.otherwise();
        Self {
            patches,
            chosen,
            rules,
            firsts,
        }
    }
}

impl Receivers for Closer<'_> {
    fn count(&self) -> u32 {
        self.chosen.len() as u32
    }

    fn point_count(&self, receiver: ReceiverId) -> u32 {
        self.rules[receiver.0 as usize].count()
    }

    fn first_point(&self, receiver: ReceiverId) -> u64 {
        self.firsts[receiver.0 as usize]
    }

    fn point_counts(&self) -> Vec<u32> {
        let mut counts: Vec<u32> = self.rules.iter().map(|rule| rule.count()).collect();
        counts.sort_unstable();
        counts.dedup();
        counts
    }

    fn frames(&self, receiver: ReceiverId) -> Vec<Frame> {
        let k = receiver.0 as usize;
        self.patches.frames_by(self.rules[k], self.chosen[k])
    }

    fn surface(&self, receiver: ReceiverId) -> Option<SurfaceId> {
        let patch = self.chosen[receiver.0 as usize];
        self.patches.surface(ReceiverId(patch.0))
    }
}
