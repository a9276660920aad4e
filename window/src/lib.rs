//! A window onto a scene and its solution, in which one walks about.
//!
//! Surfaces are drawn and patches are looked up, as everywhere in the toolkit: the graphics card rasterises the few surfaces, and
//! each pixel goes down its surface's bisection tree to its patch, or to the leaf of the irradiance function that it sees. So a
//! picture costs by its pixels, not by its patches. What values mean and how they become colours is [`display`]'s.
//!
//! | module | concept |
//! |---|---|
//! | [`cli`], [`mod@open`] | the program: what is asked for, and a window on the screen |
//! | [`app`] | what the window is, from one frame to the next |
//! | [`loaded`], [`watch`] | the file's content, and that it may change |
//! | [`looks`], [`values`] | what is shown, and the numbers that it is made of |
//! | [`camera_control`], [`saved_views`], [`gestures`] | the camera, and what moves it |
//! | [`panels`], [`status`], [`legend`], [`pick`] | what is beside the picture |
//! | [`structs`], [`scene_buffers`], [`pipelines`], [`targets`], [`view`], [`renderer`] | the picture, on the graphics card |
//! | [`screen`], [`pace`] | when the picture is drawn, and how finely |

pub mod app;
pub mod camera_control;
pub mod cli;
pub mod gestures;
pub mod legend;
pub mod loaded;
pub mod looks;
pub mod mixer;
pub mod open;
pub mod pace;
pub mod panels;
pub mod pick;
pub mod pipelines;
pub mod renderer;
pub mod saved_views;
pub mod scene_buffers;
pub mod screen;
pub mod status;
pub mod structs;
pub mod targets;
pub mod values;
pub mod view;
pub mod watch;

pub use app::App;
pub use open::open;
