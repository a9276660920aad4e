//! What can be seen from a point of a scene: item buffers of patches, on the CPU.
//!
//! A scene is laid out once, as a [`Drawable`]. A [`Viewer`] opens a [`View`] at an [`Eye`]; a [`Canvas`] draws it
//! through a [`Window`]; the [`Picture`] tells what its pixels see, as patch IDs or as [`Sample`]s.
//!
//! ```
//! use std::sync::Arc;
//!
//! use glam::{DVec3, Vec3};
//! use scene::{Material, MaterialId, ObjectId, Rgb, Scene, Surface};
//! use visibility::{Canvas, Cull, Drawable, Eye, Frame, Sample, Viewer, hemicube};
//!
//! // A triangle overhead, facing down.
//! let wall = Material { name: "wall".into(), reflectance: Rgb::splat(0.5), emission: Rgb::ZERO };
//! let corners = [Vec3::new(-9.0, -9.0, 1.0), Vec3::new(0.0, 9.0, 1.0), Vec3::new(9.0, -9.0, 1.0)];
//! let overhead = Surface { corners, material: MaterialId(0), object: ObjectId(0) };
//! let scene = Scene::new(vec![wall], vec!["all".into()], vec![overhead], &[0], DVec3::ZERO)?;
//!
//! let frame = Frame { position: DVec3::ZERO, tangent: DVec3::X, bitangent: DVec3::Y, normal: DVec3::Z };
//! let mut viewer = Viewer::new(&Arc::new(Drawable::new(&scene)));
//! let window = hemicube::windows(16)[0];
//! let view = viewer.view(&Eye::free(&frame, Cull::Nothing), 16 * 16);
//! let mut canvas = Canvas::default();
//! let picture = canvas.draw(&view, &window);
//! assert!(matches!(picture.sample(8, 8), Sample::Front { depth: 1.0, .. }));
//! # Ok::<(), scene::SceneError>(())
//! ```
//!
//! Hemicubes have a shorter way: [`item_buffer::HemicubeDrawer`].
//!
//! # Strategies
//! Pixels find what they see in one of three ways ([`Strategy`]): drawn as [`spans`], as [`specks`], or by [`rays`]. All
//! show the same picture but for pixels that lie on an edge, as does [`mod@reference`], which is slow and simple.
//!
//! [`spans`]: self#strategies
//! [`specks`]: self#strategies
//! [`rays`]: self#strategies

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would be for the baseline
// instruction set. That goes for closures too.
#![allow(clippy::inline_always)]

mod affine;
mod buffer;
mod drawable;
mod eye;
pub mod facets;
mod frame;
mod geometry;
pub mod hemicube;
pub mod item_buffer;
mod look_up;
mod outcode;
mod picture;
mod rays;
pub mod reference;
pub mod regions;
mod rounding;
pub mod runs;
mod spans;
mod specks;
mod vectors;
mod view;
mod window;

pub use drawable::{Drawable, Strategy};
pub use eye::{Cull, Eye};
pub use frame::Frame;
pub use picture::{Canvas, Picture, Sample};
pub use rounding::{COORDINATE_ULPS, is_in_plane, plane_tolerance, reach};
pub use view::{HemicubeView, View, Viewer};
pub use window::Window;
