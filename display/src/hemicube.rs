//! What a patch sees: the item buffer of its hemicube, unfolded.
//!
//! The hemicube stands where that of a run of one point a patch does, at the patch's centroid, and is turned about the
//! normal as there ([`compute::receivers`]): its pixels see what that run's form factors were counted from.
//!
//! # Differences
//! By default a run has more points on some patches, and views of lamps that no hemicube has. Its irradiances differ from
//! what is counted here by what those are for.

use std::sync::Arc;

use compute::receivers::{Patches, ReceiverId, Receivers};
use compute::settings::{Points, Seed};
use glam::DVec3;
use scene::function::IrradianceFunction;
use scene::{PatchId, Rgb, Scene, SurfaceId};
use visibility::hemicube::FACES;
use visibility::item_buffer::{BACK_FACE, NOTHING};
use visibility::{Canvas, Drawable, Frame, Picture, Sample, Viewer};

use crate::settings::SettingsError;
use crate::unfolding::{ResolutionError, Unfolding};
use crate::up;

/// From this component along the scene's up on a direction points up: below it the patch lies flat within rounding.
const UPWARDS: f64 = 1e-6;

/// What a pixel of the unfolded hemicube sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The front of a patch.
    Patch(PatchId),
    /// The back of a surface.
    Back,
    /// No surface.
    Nothing,
    /// It is no pixel of the hemicube, but of the square's empty corners.
    Outside,
}

/// Why there is no hemicube to show.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum HemicubeError {
    #[error("patch {patch}: the scene has {count} patches; give a number below that")]
    Patch { patch: u32, count: u32 },
    #[error(transparent)]
    Resolution(#[from] ResolutionError),
    #[error(transparent)]
    Settings(#[from] SettingsError),
    #[error(
        "mode ids: a hemicube's picture has the IDs in every mode; use log, linear or false-color"
    )]
    ModeIds,
}

/// The unfolded hemicube of a patch.
#[derive(Clone, Debug)]
pub struct UnfoldedHemicube<'a> {
    drawable: Arc<Drawable<'a>>,
    own: Option<SurfaceId>,
    frame: Frame,
    unfolding: Unfolding,
    seen: Vec<Seen>,
}

impl<'a> UnfoldedHemicube<'a> {
    /// Draws the hemicube of a patch: resolution in pixels along a face, even, 2 to
    /// [`MAX_RESOLUTION`](visibility::hemicube::MAX_RESOLUTION).
    pub fn new(
        scene: &'a Scene,
        patch: PatchId,
        resolution: u32,
        seed: Seed,
    ) -> Result<Self, HemicubeError> {
        let unfolding = Unfolding::new(resolution)?;
        let drawable = Arc::new(Drawable::new(scene));
        let patches = Patches::new(scene, &drawable, Points::CENTROID, seed);
        let receiver = ReceiverId(patch.0);
        let frame = (receiver.0 < patches.count()).then(|| patches.frames(receiver));
        let Some(frame) = frame.and_then(|frames| frames.first().copied()) else {
            return Err(HemicubeError::Patch {
                patch: patch.0,
                count: scene.patch_count(),
            });
        };
        let own = patches.surface(receiver);
        let unfolding = upright(unfolding, scene, &frame);
        let mut hemicube = Self {
            own,
            frame,
            unfolding,
            seen: vec![Seen::Outside; unfolding.pixel_count()],
            drawable: Arc::clone(&drawable),
        };
        let mut seen = std::mem::take(&mut hemicube.seen);
        hemicube.draw(|face, picture| {
            picture.for_each_row(NOTHING, BACK_FACE, |j, ids| {
                for (i, &id) in ids.iter().enumerate() {
                    seen[unfolding.index(face, i, j)] = match id {
                        NOTHING => Seen::Nothing,
                        BACK_FACE => Seen::Back,
                        id => Seen::Patch(PatchId(id)),
                    };
                }
            });
        });
        Ok(Self { seen, ..hemicube })
    }

    /// Draws the five faces one after the other.
    fn draw(&self, mut take: impl FnMut(usize, &mut Picture)) {
        let mut viewer = Viewer::new(&self.drawable);
        let view = viewer.hemicube(self.unfolding.resolution(), &self.frame, self.own);
        let mut canvas = Canvas::default();
        for face in 0..FACES {
            take(face, &mut canvas.draw_face(&view, face));
        }
    }

    /// How it lies in the plane.
    pub fn unfolding(&self) -> Unfolding {
        self.unfolding
    }

    /// What its pixels see, row by row from the top: 2R x 2R.
    pub fn ids(&self) -> &[Seen] {
        &self.seen
    }

    /// Where it stands, metres, relative to the scene's origin; its normal points into the picture, in the middle.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The direction that points up in the picture's middle, a unit vector of the scene: on a wall the scene's up, within
    /// half a right angle.
    pub fn up_in_scene(&self) -> DVec3 {
        self.frame.to_scene(self.unfolding.up())
    }

    /// The radiosity that each pixel sees, W/m^2, in the order of [`Self::ids`]; 0 where that is no patch.
    ///
    /// `of_patches` has one element per patch, W/m^2. Where there is a function, and the surface has values of it, a pixel
    /// sees the one at its centre's own place, E + rho H.
    pub fn radiosities(
        &self,
        of_patches: &[Rgb],
        function: Option<&IrradianceFunction>,
    ) -> Vec<Rgb> {
        let of = |seen: &Seen| match seen {
            Seen::Patch(patch) => of_patches.get(patch.index()).copied().unwrap_or_default(),
            Seen::Back | Seen::Nothing | Seen::Outside => Rgb::ZERO,
        };
        let mut radiosities: Vec<Rgb> = self.seen.iter().map(of).collect();
        let Some(function) = function else {
            return radiosities;
        };
        let scene = self.drawable.scene();
        let at = |surface: SurfaceId, barycentric: [f32; 3]| {
            let irradiance = function.interpolate(function.irradiance(), surface, barycentric)?;
            let material = scene.material(scene.surface(surface).material);
            // Beyond the border by a rounding it may be below 0 by as little.
            Some(material.emission + material.reflectance * irradiance.max(Rgb::ZERO))
        };
        let size = self.unfolding.resolution() as usize;
        self.draw(|face, picture| {
            let height = if face == 0 { size } else { size / 2 };
            for j in 0..height {
                picture.for_each_sample(j, 0..size, |i, sample| {
                    if let Sample::Front {
                        surface,
                        barycentric,
                        ..
                    } = sample
                        && let Some(radiosity) = at(surface, barycentric)
                    {
                        radiosities[self.unfolding.index(face, i, j)] = radiosity;
                    }
                });
            }
        });
        radiosities
    }
}

/// The quarter turns by which the scene's up is most nearly up in the square; none for what lies flat.
fn upright(unfolding: Unfolding, scene: &Scene, frame: &Frame) -> Unfolding {
    let up = up::guess(scene).direction();
    let height = |turned: &Unfolding| frame.to_scene(turned.up()).dot(up);
    (0..4)
        .map(|quarter_turns| unfolding.turned(quarter_turns))
        .filter(|turned| height(turned) > UPWARDS)
        .max_by(|a, b| height(a).total_cmp(&height(b)))
        .unwrap_or(unfolding)
}
