//! Which object is to blame for power that is lost.
//!
//! The item buffers that rows are made of do not tell whose back a pixel sees, nor what an opening is a
//! hole in. So the hemicubes of the few patches that lose most are drawn again, on the CPU: to blame is
//! the object whose backs fill most of their view, or whose fronts border most of the pixels that see
//! nothing, while what was taken out of the model on purpose is in its place again.

use std::sync::Arc;

use scene::{MaterialId, ObjectId, Scene, Surface, SurfaceId};
use visibility::{Canvas, Drawable, Sample, Viewer, hemicube};

use crate::receivers::ReceiverId;
use crate::row_cache::RowCache;

/// What hemispheres can lose power to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Loss {
    /// What sees nothing.
    Opening,
    /// What sees the backs of surfaces, which are black.
    BackFaces,
}

/// The most pixels that are drawn to find who is to blame, unless a single hemicube has more: a fraction
/// of a second's work.
const MAX_PIXELS: usize = 1 << 23;

/// The object that is to blame for what the `worst` patches, worst first, lose.
pub(super) fn culprit(rows: &RowCache, loss: Loss, worst: &[(usize, f64)]) -> Option<String> {
    let hemicubes = rows.hemicubes();
    let shut = shut(hemicubes.sources().patches());
    let drawable = match &shut {
        Some(scene) => Arc::new(Drawable::new(scene)),
        None => Arc::clone(hemicubes.drawable()),
    };
    let scene = drawable.scene();
    let resolution = hemicubes.resolution();
    let mut blame = Blame {
        scene,
        loss,
        shares: vec![0; scene.objects().len()],
    };
    let mut viewer = Viewer::new(&drawable);
    let mut canvas = Canvas::default();
    let mut pixels = 0;
    // To set a surface up takes a few times as long as to fill a pixel.
    let work = hemicube::pixel_count(resolution) + 8 * scene.surfaces().len();
    'patches: for &(patch, _) in worst {
        let patch = ReceiverId(patch as u32);
        let own = hemicubes.receivers().surface(patch);
        let frames = hemicubes.receivers().frames(patch);
        let delta_form_factors = hemicubes.delta_form_factors(frames.len() as u32);
        for frame in frames {
            if pixels > 0 && pixels + work > MAX_PIXELS || rows.cancel().is_cancelled() {
                break 'patches;
            }
            pixels += work;
            let view = viewer.hemicube(resolution, &frame, own);
            for (face, window) in view.windows().iter().enumerate() {
                let picture = canvas.draw_face(&view, face);
                let factors = delta_form_factors.face(face);
                let mut below = vec![Sample::Nothing; window.width];
                for j in 0..window.height {
                    let mut row = Vec::with_capacity(window.width);
                    picture.for_each_sample(j, 0..window.width, |_, sample| row.push(sample));
                    blame.take(
                        &row,
                        (j > 0).then_some(&below),
                        &factors[j * window.width..],
                    );
                    below = row;
                }
            }
        }
    }
    let (object, &most) = blame
        .shares
        .iter()
        .enumerate()
        .max_by_key(|&(object, &share)| (share, std::cmp::Reverse(object)))?;
    (most > 0).then(|| scene.object(ObjectId(object as u32)).to_owned())
}

/// The scene with what was taken out on purpose in its place again; `None` where that is nothing.
fn shut(scene: &Scene) -> Option<Scene> {
    if scene.openings().is_empty() {
        return None;
    }
    let openings = scene.openings().iter().map(|opening| Surface {
        corners: opening.corners,
        material: MaterialId(0),
        object: opening.object,
    });
    let mut surfaces = scene.surfaces().to_vec();
    let mut depths: Vec<u32> = scene.mesh().trees().iter().map(|tree| tree.depth).collect();
    surfaces.extend(openings);
    depths.resize(surfaces.len(), 0);
    let (materials, objects) = (scene.materials().to_vec(), scene.objects().to_vec());
    Scene::new(materials, objects, surfaces, &depths, scene.origin()).ok()
}

/// Counts what objects have to do with a loss.
struct Blame<'a> {
    scene: &'a Scene,
    loss: Loss,
    /// One per object: units of form factors of its backs, or pixels of its fronts beside openings.
    shares: Vec<u64>,
}

impl Blame<'_> {
    /// A row of pixels, the one below it if there is one, and its delta form factors.
    fn take(&mut self, row: &[Sample], below: Option<&Vec<Sample>>, delta_form_factors: &[u32]) {
        match self.loss {
            Loss::BackFaces => {
                for (sample, &units) in row.iter().zip(delta_form_factors) {
                    if let &Sample::BackFace(surface) = sample {
                        self.add(surface, u64::from(units));
                    }
                }
            }
            Loss::Opening => {
                for pair in row.windows(2) {
                    self.border(&pair[0], &pair[1]);
                }
                for (sample, below) in row.iter().zip(below.into_iter().flatten()) {
                    self.border(sample, below);
                }
            }
        }
    }

    fn border(&mut self, a: &Sample, b: &Sample) {
        if let (Sample::Nothing, &Sample::Front { surface, .. })
        | (&Sample::Front { surface, .. }, Sample::Nothing) = (a, b)
        {
            self.add(surface, 1);
        }
    }

    fn add(&mut self, surface: SurfaceId, share: u64) {
        self.shares[self.scene.surface(surface).object.index()] += share;
    }
}
