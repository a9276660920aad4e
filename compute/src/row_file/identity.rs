//! What decides the rows of a file.

use std::hash::Hasher;

use scene::{RecordedSettings, Scene};
use serde::{Deserialize, Serialize};
use twox_hash::XxHash3_64;

/// To be raised by every change of any bit of any row: where hemicubes stand and how they are turned, what their pixels see
/// and count, lamps' views, how rows are rounded.
const ROWS_REVISION: u32 = 2;

/// Everything that decides rows. Runs of equal identities draw the same rows, bit for bit; reflectances,
/// solvers, threads and memory are not in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// A field that this program does not know might be the one that differs.
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The version of the program that drew them, and the revision of what it draws.
    program: String,
    /// Name and adapter of the back end.
    backend: String,
    settings: RecordedSettings,
    /// XXH3-64 of all surfaces' corners, and of which surfaces are of one material: what is drawn as one region.
    geometry: u64,
    /// XXH3-64 of all surfaces' emissions. Lamps are viewed by these, and kept rows are exact where patches emit.
    emitters: u64,
    /// Who has rows.
    receivers: Receivers,
    /// What the rows' entries are of.
    sources: Sources,
}

/// The places that see.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Receivers {
    kind: ReceiverKind,
    count: u32,
    /// XXH3-64 of where they are: of patches, the depths of the surfaces' bisection trees.
    places: u64,
}

/// What a receiver is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum ReceiverKind {
    /// A patch, whose row is the mean over its hemicubes.
    Patches,
}

/// The patches that are seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sources {
    count: u32,
    /// XXH3-64 of the depths of the surfaces' bisection trees.
    depths: u64,
}

impl Identity {
    /// Of the rows by which the patches of one scene see those of another one over the same surfaces, or of the same
    /// one.
    ///
    /// `settings` are those that decide rows, named as on the command line; `backend` is its name and the adapter's,
    /// without what changes no bit: `cpu` on any number of threads is one.
    pub fn new(
        receivers: &Scene,
        sources: &Scene,
        settings: &impl Serialize,
        backend: &str,
    ) -> Self {
        Self {
            program: format!("{}, rows {ROWS_REVISION}", env!("CARGO_PKG_VERSION")),
            backend: backend.to_owned(),
            settings: RecordedSettings::new(settings),
            geometry: geometry(sources),
            emitters: emitters(sources),
            receivers: Receivers {
                kind: ReceiverKind::Patches,
                count: receivers.patch_count(),
                places: depths(receivers),
            },
            sources: Sources {
                count: sources.patch_count(),
                depths: depths(sources),
            },
        }
    }

    /// How many rows there are.
    pub fn receivers(&self) -> u32 {
        self.receivers.count
    }

    /// How many patches a row may have entries of.
    pub fn sources(&self) -> u32 {
        self.sources.count
    }

    /// In which ways `now` is another one, to be told after "this one has".
    pub fn differences(&self, now: &Self) -> Vec<String> {
        let mut differences = Vec::new();
        let mut compare = |is_same: bool, told: String| {
            if !is_same {
                differences.push(told);
            }
        };
        compare(
            self.program == now.program,
            format!("version {} instead of {}", now.program, self.program),
        );
        compare(
            self.backend == now.backend,
            format!("back end {} instead of {}", now.backend, self.backend),
        );
        for setting in self.settings.differences(&now.settings) {
            let (name, before, now) = (setting.name, setting.before, setting.now);
            compare(false, format!("{name} {now} instead of {before}"));
        }
        compare(self.geometry == now.geometry, "another geometry".to_owned());
        compare(self.emitters == now.emitters, "other emitters".to_owned());
        let count = |now: u32, before: u32| {
            if now == before {
                String::new()
            } else {
                format!(" ({now} instead of {before})")
            }
        };
        compare(
            self.receivers == now.receivers,
            format!(
                "other receivers{}",
                count(now.receivers.count, self.receivers.count)
            ),
        );
        compare(
            self.sources == now.sources,
            format!(
                "other sources{}",
                count(now.sources.count, self.sources.count)
            ),
        );
        differences
    }

    /// As a file has it.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        // Serialising strings and numbers to memory has no way to fail.
        serde_json::to_vec(self).unwrap_or_default()
    }
}

/// A hash of some numbers for each surface.
fn of_surfaces<const N: usize>(scene: &Scene, numbers: impl Fn(usize) -> [u32; N]) -> u64 {
    let mut hasher = XxHash3_64::new();
    for surface in 0..scene.surfaces().len() {
        hasher.write(bytemuck::cast_slice(&numbers(surface)));
    }
    hasher.finish()
}

/// Materials count by the first surface that is of them, whatever their numbers are.
fn geometry(scene: &Scene) -> u64 {
    let mut first = vec![None; scene.materials().len()];
    let first_of: Vec<u32> = (0..)
        .zip(scene.surfaces())
        .map(|(k, surface)| *first[surface.material.index()].get_or_insert(k))
        .collect();
    of_surfaces(scene, |k| {
        let [a, b, c] = scene.surfaces()[k]
            .corners
            .map(|p| p.to_array().map(f32::to_bits));
        [
            a[0],
            a[1],
            a[2],
            b[0],
            b[1],
            b[2],
            c[0],
            c[1],
            c[2],
            first_of[k],
        ]
    })
}

fn emitters(scene: &Scene) -> u64 {
    of_surfaces(scene, |k| {
        let material = scene.material(scene.surfaces()[k].material);
        material.emission.to_array().map(f32::to_bits)
    })
}

fn depths(scene: &Scene) -> u64 {
    of_surfaces(scene, |k| [scene.mesh().trees()[k].depth])
}

#[cfg(test)]
pub(super) mod tests {
    use glam::{DVec3, Vec3};
    use scene::{Material, MaterialId, ObjectId, Rgb, Surface};
    use serde_json::json;

    use super::*;

    /// What a scene of two squares is made of.
    #[derive(Clone)]
    struct Parts {
        height: f32,
        /// One per surface.
        materials: [u32; 4],
        depths: [u32; 4],
        reflectance: f32,
        emission: f32,
    }

    const PARTS: Parts = Parts {
        height: 1.0,
        materials: [0, 0, 1, 2],
        depths: [1, 2, 0, 0],
        reflectance: 0.5,
        emission: 3.0,
    };

    fn scene(parts: &Parts) -> Scene {
        let material = |emission| Material {
            name: String::new(),
            reflectance: Rgb::splat(parts.reflectance),
            emission,
        };
        let lamp = material(Rgb::splat(parts.emission));
        let wall = material(Rgb::ZERO);
        let surface = |k: usize| {
            let z = if k < 2 { 0.0 } else { parts.height };
            let opposite = Vec3::new((k % 2) as f32, (k % 2) as f32, z);
            Surface {
                corners: [Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z), opposite],
                material: MaterialId(parts.materials[k]),
                object: ObjectId(0),
            }
        };
        Scene::new(
            vec![wall.clone(), lamp, wall.clone(), wall],
            vec![String::new()],
            (0..4).map(surface).collect(),
            &parts.depths,
            DVec3::ZERO,
        )
        .unwrap()
    }

    /// The identity of the rows of a scene of 2^`depth` patches.
    pub(in crate::row_file) fn of_one_surface(depth: u32) -> Identity {
        let wall = Material {
            name: String::new(),
            reflectance: Rgb::ZERO,
            emission: Rgb::ZERO,
        };
        let surface = Surface {
            corners: [Vec3::X, Vec3::Y, Vec3::ZERO],
            material: MaterialId(0),
            object: ObjectId(0),
        };
        let objects = vec![String::new()];
        let scene = Scene::new(vec![wall], objects, vec![surface], &[depth], DVec3::ZERO).unwrap();
        Identity::new(&scene, &scene, &(), "cpu")
    }

    fn of(parts: &Parts) -> Identity {
        let scene = scene(parts);
        Identity::new(&scene, &scene, &json!({"resolution": 64}), "cpu")
    }

    #[test]
    fn what_decides_no_row_is_not_in_it() {
        let other_reflectance = Parts {
            reflectance: 0.7,
            ..PARTS
        };
        let renumbered = Parts {
            materials: [3, 3, 1, 2],
            ..PARTS
        };
        for parts in [other_reflectance, renumbered] {
            assert_eq!(of(&PARTS).differences(&of(&parts)), [""; 0]);
            assert_eq!(of(&PARTS), of(&parts));
        }
    }

    #[test]
    fn what_differs_is_told() {
        let told = |parts: Parts| {
            assert_ne!(of(&PARTS), of(&parts));
            of(&PARTS).differences(&of(&parts)).join(", ")
        };
        let other_height = Parts {
            height: 2.0,
            ..PARTS
        };
        assert_eq!(told(other_height), "another geometry");
        let other_emission = Parts {
            emission: 4.0,
            ..PARTS
        };
        assert_eq!(told(other_emission), "other emitters");
        // Two walls of one material are one region.
        let joined = Parts {
            materials: [0, 0, 1, 0],
            ..PARTS
        };
        assert_eq!(told(joined), "another geometry");
        let same_count = Parts {
            depths: [2, 1, 0, 0],
            ..PARTS
        };
        assert_eq!(told(same_count), "other receivers, other sources");
        let finer = Parts {
            depths: [1, 3, 0, 0],
            ..PARTS
        };
        assert_eq!(
            told(finer),
            "other receivers (12 instead of 8), other sources (12 instead of 8)"
        );
    }

    #[test]
    fn settings_and_back_ends_are_told_one_by_one() {
        let scene = scene(&PARTS);
        let before = Identity::new(
            &scene,
            &scene,
            &json!({"resolution": 64, "maps": "exact"}),
            "cpu",
        );
        let now = Identity::new(
            &scene,
            &scene,
            &json!({"resolution": 128, "maps": "exact", "lamps": "off"}),
            "gpu, an adapter",
        );
        assert_eq!(
            before.differences(&now),
            [
                "back end gpu, an adapter instead of cpu",
                "lamps off instead of unset",
                "resolution 128 instead of 64"
            ]
        );
        let read: Identity = serde_json::from_slice(&now.to_bytes()).unwrap();
        assert_eq!(read, now);
    }
}
