//! Pictures and exports of scenes and solutions, made on the CPU: no graphics card, no screen.
//!
//! A picture is an item buffer seen from a [`Camera`] ([`visibility`]), many samples a pixel,
//! each looked up in the patches' values ([`shade`]) and mapped to display light ([`tone`]). What
//! the program does is [`run`]; [`render`] and [`patch_colors`] serve other programs.
//!
//! | module | concept |
//! |---|---|
//! | [`settings`] | what is asked for, checked |
//! | [`camera`], [`default_camera`], [`kind`], [`probe`], [`up`] | where the picture is taken from |
//! | [`quantity`], [`shade`], [`smooth`] | the light that a pixel sees |
//! | [`luminance`], [`range`], [`scale`], [`tone`] | from W/m^2 to display light |
//! | [`legend`], [`ticks`], [`text`], [`number`] | the false colours' legend |
//! | [`contours`], [`distinct`], [`picture`], [`output`] | the finished picture, and files |
//! | [`table`] | what objects and materials receive and emit |
//! | [`compare`], [`difference`], [`input`] | how far a picture is from another one, as numbers and as a map |
//! | [`by_position`], [`places`] | how far a solution is from another one, by area |
//! | [`camera_path`], [`spline`], [`animation`] | a camera that moves, and its frames as files |
//! | [`mix`] | layers of light with other factors |
//! | [`plot`] | a report of `compute` as charts |
//! | [`hemicube`], [`unfolding`], [`multipliers`] | what a patch sees, and how much of it counts |
//! | [`hemicube_picture`], [`maps_picture`], [`panels`] | that as pictures |

pub mod animation;
pub mod by_position;
pub mod camera;
pub mod camera_path;
pub mod cli;
pub mod compare;
mod comparing;
pub mod contours;
pub mod dark;
pub mod default_camera;
pub mod difference;
pub mod distinct;
pub mod hemicube;
pub mod hemicube_picture;
pub mod input;
pub mod kind;
pub mod legend;
pub mod luminance;
pub mod maps_picture;
pub mod mix;
mod moving;
pub mod multipliers;
pub mod number;
pub mod output;
pub mod panels;
pub mod picture;
pub mod places;
pub mod plot;
pub mod probe;
pub mod quantity;
pub mod range;
mod run;
pub mod scale;
pub mod settings;
pub mod shade;
mod shown;
pub mod smooth;
pub mod spline;
pub mod table;
pub mod text;
pub mod ticks;
mod told;
pub mod tone;
pub mod unfolding;
pub mod up;
mod window;

pub use camera::Camera;
pub use picture::{Picture, patch_colors, render};
pub use quantity::{Channel, Quantity, Shown};
pub use run::run;
pub use scene::Axis;
pub use settings::{
    Comparing, ExportFormat, ImageFormat, Job, Mode, Moving, Range, RenderSettings, Settings,
    SettingsError, Size,
};
