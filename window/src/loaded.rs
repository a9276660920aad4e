//! What is read of a file: the scene, its solution, and where a camera would stand.

use std::path::Path;
use std::time::{Duration, Instant};

use display::default_camera::{self, Wishes};
use display::{Camera, Quantity, Shown, up};
use glam::DVec3;
use scene::file::FileError;
use scene::{Scene, Solution};
use visibility::Cull;

/// A file's content.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Its solution, where there is one.
    pub solution: Option<Solution>,
    /// Up in the picture, a unit vector along an axis.
    pub up: DVec3,
    /// The camera that `display` would choose.
    pub camera: Camera,
    /// How long it took.
    pub duration: Duration,
}

impl Loaded {
    /// Reads a file.
    ///
    /// # Errors
    /// One that cannot be read, or that is not whole.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let start = Instant::now();
        let (scene, solution) = scene::file::load(path)?;
        let loaded = Self::new(scene, solution);
        Ok(Self {
            duration: start.elapsed(),
            ..loaded
        })
    }

    /// The same of what has been read already.
    pub fn new(scene: Scene, solution: Option<Solution>) -> Self {
        let up = up::guess(&scene).direction();
        let wishes = Wishes {
            up,
            fov_degrees: None,
            aspect: None,
            cull: Cull::Nothing,
        };
        let camera = default_camera::choose(&scene, &wishes).camera;
        Self {
            scene,
            solution,
            up,
            camera,
            duration: Duration::ZERO,
        }
    }

    /// Whether there are values of a quantity.
    pub fn has(&self, quantity: Quantity) -> bool {
        let solution = self.solution.as_ref();
        match quantity {
            Quantity::Direct | Quantity::Indirect => self.has_function(),
            Quantity::Error => solution.and_then(Solution::error).is_some(),
            _ => true,
        }
    }

    /// Whether there is light between the patches' means.
    pub fn has_function(&self) -> bool {
        self.solution.as_ref().is_some_and(|s| s.function.is_some())
    }

    /// What of that which is asked for there is: the radiosity in place of what is missing.
    pub fn available(&self, shown: Shown) -> Shown {
        let is_there = self.has(shown.quantity);
        Shown {
            quantity: if is_there {
                shown.quantity
            } else {
                Quantity::Radiosity
            },
            is_luminous: shown.is_luminous && shown.quantity != Quantity::Reflectance,
            ..shown
        }
    }
}
