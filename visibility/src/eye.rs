//! Who looks: where an eye stands, what it stands on, and which sides of surfaces it sees.

use glam::DVec3;
use scene::SurfaceId;

use crate::Frame;
use crate::geometry::{Geometry, RegionFacts};
use crate::rounding::{is_in_plane, retreat};

/// What is done about the backs of surfaces, which are one-sided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    /// They occlude, and are seen as [`crate::Sample::BackFace`].
    Nothing,
    /// They are not there.
    BackFaces,
}

/// An eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Where it is, and the axes of its windows.
    pub frame: Frame,
    /// The surface that it lies on, if any. Nothing of that surface's region is seen.
    pub own: Option<SurfaceId>,
    /// Whether it sees only what is above the plane z = 0 of its frame.
    pub has_horizon: bool,
    /// What it sees of backs.
    pub cull: Cull,
}

impl Eye {
    /// An eye that sees fronts and backs above its horizon, on the surface `own` if on any.
    pub fn with_horizon(frame: &Frame, own: impl Into<Option<SurfaceId>>) -> Self {
        Self {
            frame: *frame,
            own: own.into(),
            has_horizon: true,
            cull: Cull::Nothing,
        }
    }

    /// An eye in free space, which sees in all directions.
    pub fn free(frame: &Frame, cull: Cull) -> Self {
        Self {
            frame: *frame,
            own: None,
            has_horizon: false,
            cull,
        }
    }
}

/// An eye in a scene, and what all strategies ask of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standpoint<'v> {
    pub geometry: &'v Geometry<'v>,
    pub frame: Frame,
    /// The region that the eye lies on, if any.
    pub own: Option<u32>,
    /// Largest magnitude of the coordinates by which the eye's plane is known, metres.
    pub reach: DVec3,
    pub has_horizon: bool,
    pub cull: Cull,
}

/// A plane as seen from an eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    /// True where the eye is behind it.
    pub is_back_face: bool,
    /// 1/w = inverse_depth . d, 1/m; backs are a hair too deep ([`retreat`]).
    pub inverse_depth: DVec3,
}

impl<'v> Standpoint<'v> {
    pub fn new(geometry: &'v Geometry<'v>, eye: &Eye) -> Self {
        let own = eye.own.map(|own| geometry.regions.region_of(own));
        Self {
            geometry,
            frame: eye.frame,
            own,
            reach: own.map_or(eye.frame.position.abs(), |own| {
                geometry.facts[own as usize].reach
            }),
            has_horizon: eye.has_horizon,
            cull: eye.cull,
        }
    }

    /// The plane of a region; `None` where it is edge-on within rounding.
    #[inline(always)]
    pub fn plane(&self, facts: &RegionFacts) -> Option<Plane> {
        let plane = self.any_plane(facts);
        let tolerance = self.geometry.plane_tolerance;
        let distance = self.distance_behind(facts).abs();
        let reach = facts.reach.max(self.reach);
        (!is_in_plane(distance, tolerance, facts.normal, reach)).then_some(plane)
    }

    /// The plane of a region that is known not to be edge-on.
    #[inline(always)]
    pub fn any_plane(&self, facts: &RegionFacts) -> Plane {
        let distance = self.distance_behind(facts);
        let is_back_face = distance > 0.0;
        Plane {
            is_back_face,
            inverse_depth: self.frame.vector_to_local(facts.normal)
                * (retreat(is_back_face) / distance),
        }
    }

    /// How far the eye is behind the plane of a region, negative in front, metres.
    #[inline(always)]
    fn distance_behind(&self, facts: &RegionFacts) -> f64 {
        facts.offset - facts.normal.dot(self.frame.position)
    }

    /// True where the highest point of a part of a region is at the horizon within rounding, or below it.
    #[inline(always)]
    pub fn is_at_horizon(&self, facts: &RegionFacts, height: f64) -> bool {
        let reach = facts.reach.max(self.reach);
        let tolerance = self.geometry.plane_tolerance;
        is_in_plane(height, tolerance, self.frame.normal, reach)
    }

    /// True for a region that is edge-on, or at the horizon with its largest height given, metres, within rounding.
    #[cold]
    pub fn leaves_out(&self, region: u32, height: f64) -> bool {
        let facts = &self.geometry.facts[region as usize];
        self.plane(facts).is_none() || self.is_at_horizon(facts, height)
    }

    /// The three e_k of the proportion e_0 : e_1 : e_2 of a region's coordinates along a ray, see
    /// [`Region::reference`](crate::regions::Region::reference).
    pub fn coordinates(&self, region: u32) -> [DVec3; 3] {
        let facts = &self.geometry.facts[region as usize];
        let reference = &self.geometry.regions.regions()[region as usize].reference;
        let [q0, q1, q2] = reference.map(|p| self.frame.to_local(p));
        let sign = if self.distance_behind(facts) > 0.0 {
            1.0
        } else {
            -1.0
        };
        [q1.cross(q2), q2.cross(q0), q0.cross(q1)].map(|e| sign * e)
    }
}
