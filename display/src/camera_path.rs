//! The way of a camera through a scene: key frames in a text file, and the poses between them.
//!
//! # The file
//! A key frame a line, its fields separated by spaces or tabs:
//!
//! ```text
//! # TIME  EYE          LOOK-AT      FOV
//! 0       4,1.6,7      0,1,0        60
//! 2.5     1,1.6,3      0,1,0
//! 4       1,1.6,-2     1,1.6,-6     75
//! ```
//!
//! TIME is in seconds and ascends. EYE, where the camera is, and LOOK-AT, the point in the middle of the picture,
//! are X,Y,Z without spaces, in the model's own coordinates. FOV, the vertical angle of view in degrees, may be
//! left out: it is that of the line before, or of the first line that has one; without any it is left to who
//! takes the pictures. What follows a `#` is a comment; lines may be blank.
//!
//! # Between key frames
//! Eye and look-at go along a curve of [`crate::spline`] each, the angle of view along a monotone cubic. They are
//! at their key frames exactly.
//!
//! The two curves may meet, where there is no direction to look in. Where the look-at comes nearer to the eye than
//! a thousandth of what it is at the nearer of the two key frames around, the camera looks as it does in
//! that key frame.

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::spline::{Curve, Moment, Monotone};

/// The largest coordinate and time; squares of it are far from overflow.
const MAX_NUMBER: f64 = 1e12;

/// Share of a key frame's distance from eye to look-at, below which they have no direction of their own.
const CLOSE: f64 = 1e-3;

/// Smallest distance from eye to look-at over the eye's largest coordinate: some thousand roundings of an f64, so
/// that they stay two points.
const APART: f64 = 1e-12;

/// Where a camera is and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in the model's own coordinates.
    pub eye: DVec3,
    /// The point in the middle of the picture, in the model's own coordinates; never the eye.
    pub look_at: DVec3,
    /// Vertical angle of view, degrees, between 0 and 180; `None` where the path has none.
    pub fov_degrees: Option<f64>,
}

/// A camera's way.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// Seconds, ascending, two or more; one per key frame.
    times: Vec<f64>,
    /// One per key frame.
    keys: Vec<Pose>,
    eye: Curve,
    look_at: Curve,
    fov_degrees: Option<Monotone>,
}

impl CameraPath {
    /// Reads a file of key frames.
    pub fn read(path: &Path) -> Result<Self, CameraPathError> {
        let fail = |fault| CameraPathError {
            path: path.to_owned(),
            fault,
        };
        let bytes = std::fs::read(path).map_err(|source| fail(source.into()))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
            let line = valid.split(|&byte| byte == b'\n').count();
            fail(CameraPathFault::NoText { line })
        })?;
        Self::parse(&text).map_err(fail)
    }

    /// The path that a file with this text has.
    pub fn parse(text: &str) -> Result<Self, CameraPathFault> {
        let (mut times, mut keys): (Vec<f64>, Vec<Pose>) = Default::default();
        for (index, text) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let line = index + 1;
            let fields: Vec<&str> = text
                .split('#')
                .next()
                .unwrap_or_default()
                .split_whitespace()
                .collect();
            if fields.is_empty() {
                continue;
            }
            let (time, key) = key_frame(line, &fields)?;
            if let Some(&before) = times.last()
                && time <= before
            {
                return Err(CameraPathFault::Order { line, time, before });
            }
            times.push(time);
            keys.push(key);
        }
        if keys.len() < 2 {
            return Err(CameraPathFault::TooFew { found: keys.len() });
        }
        Ok(Self::through(times, keys))
    }

    /// Through two or more checked key frames.
    fn through(times: Vec<f64>, mut keys: Vec<Pose>) -> Self {
        let mut fov = keys.iter().find_map(|key| key.fov_degrees);
        for key in &mut keys {
            fov = key.fov_degrees.or(fov);
            key.fov_degrees = fov;
        }
        let fovs: Option<Vec<f64>> = keys.iter().map(|key| key.fov_degrees).collect();
        Self {
            eye: Curve::new(&times, keys.iter().map(|key| key.eye).collect()),
            look_at: Curve::new(&times, keys.iter().map(|key| key.look_at).collect()),
            fov_degrees: fovs.map(|fovs| Monotone::new(&times, fovs)),
            times,
            keys,
        }
    }

    /// The first and the last key frame's time, seconds.
    pub fn ends(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }

    /// Seconds from the first key frame to the last.
    pub fn duration(&self) -> f64 {
        let [first, last] = self.ends();
        last - first
    }

    /// The pose at a time of the file, seconds; before the first key frame and after the last it is theirs.
    pub fn at(&self, seconds: f64) -> Pose {
        let moment = Moment::new(&self.times, seconds);
        let eye = self.eye.at(moment);
        let look_at = self.look_at.at(moment);
        let fov_degrees = self.fov_degrees.as_ref().map(|fov| fov.at(moment));
        let key = self.keys[moment.piece + usize::from(moment.share > 0.5)];
        let forward = key.look_at - key.eye;
        let is_key = moment.share <= 0.0 || moment.share >= 1.0;
        let look_at = if is_key || eye.distance(look_at) > CLOSE * forward.length() {
            look_at
        } else {
            let distance = forward.length().max(APART * eye.abs().max_element());
            eye + distance * forward.try_normalize().unwrap_or(DVec3::NEG_Z)
        };
        Pose {
            eye,
            look_at,
            fov_degrees,
        }
    }

    /// Poses at even times, the first and the last key frame's included, as near to this rate as that allows.
    ///
    /// There are round([`CameraPath::duration`] x rate) + 1 of them, two at least and 2^31 - 1 at most.
    pub fn frames(&self, frames_per_second: f64) -> impl ExactSizeIterator<Item = Pose> {
        // A rate that is no number counts as 0.
        let steps = (self.duration() * frames_per_second)
            .round()
            .clamp(1.0, f64::from(i32::MAX - 1)) as u32;
        let count = steps.max(1) + 1;
        let [first, last] = self.ends();
        (0..count).map(move |number| {
            let share = f64::from(number) / f64::from(count - 1);
            // Exact at both ends, unlike first + share * (last - first).
            self.at((1.0 - share) * first + share * last)
        })
    }
}

/// The key frame of a line's fields.
fn key_frame(line: usize, fields: &[&str]) -> Result<(f64, Pose), CameraPathFault> {
    let (time, eye, look_at, fov) = match *fields {
        [time, eye, look_at] => (time, eye, look_at, None),
        [time, eye, look_at, fov] => (time, eye, look_at, Some(fov)),
        _ => {
            let found = fields.len();
            return Err(CameraPathFault::Fields { line, found });
        }
    };
    let time = number(line, "time", time, time)?;
    let eye = point(line, "eye", eye)?;
    let look_at = point(line, "look-at", look_at)?;
    if eye == look_at {
        return Err(CameraPathFault::NoDirection { line, eye });
    }
    let fov_degrees = match fov {
        None => None,
        Some(text) => Some(
            text.parse()
                .ok()
                .filter(|&fov: &f64| fov > 0.0 && fov < 180.0)
                .ok_or_else(|| CameraPathFault::Fov {
                    line,
                    value: text.to_owned(),
                })?,
        ),
    };
    let pose = Pose {
        eye,
        look_at,
        fov_degrees,
    };
    Ok((time, pose))
}

/// Three numbers between commas.
fn point(line: usize, name: &'static str, text: &str) -> Result<DVec3, CameraPathFault> {
    let mut parts = text.split(',');
    let (Some(x), Some(y), Some(z), None) =
        (parts.next(), parts.next(), parts.next(), parts.next())
    else {
        return Err(CameraPathFault::Point {
            line,
            name,
            value: text.to_owned(),
        });
    };
    let number = |part: &str| number(line, name, part, text);
    Ok(DVec3::new(number(x)?, number(y)?, number(z)?))
}

/// A finite number of the field `field`, within the limit.
fn number(
    line: usize,
    name: &'static str,
    text: &str,
    field: &str,
) -> Result<f64, CameraPathFault> {
    let number = text.parse().ok();
    number
        .filter(|number: &f64| number.abs() <= MAX_NUMBER)
        .ok_or_else(|| CameraPathFault::Number {
            line,
            name,
            value: field.to_owned(),
        })
}

/// A file that is no camera path.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct CameraPathError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: CameraPathFault,
}

/// What can be wrong with a camera path. Lines count from 1.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum CameraPathFault {
    #[error("cannot read: {0}")]
    Io(#[from] std::io::Error),
    #[error("line {line}: not UTF-8 text; save the key frames as plain text")]
    NoText { line: usize },
    #[error(
        "line {line}: {found} fields, a key frame has 3 or 4: TIME X,Y,Z X,Y,Z [FOV], without spaces in X,Y,Z"
    )]
    Fields { line: usize, found: usize },
    #[error(
        "line {line}: {name} {value:?} must be three numbers X,Y,Z, without spaces between them"
    )]
    Point {
        line: usize,
        name: &'static str,
        value: String,
    },
    #[error("line {line}: {name} {value:?}: each number must be between -1e12 and 1e12")]
    Number {
        line: usize,
        name: &'static str,
        value: String,
    },
    #[error(
        "line {line}: time {time} s is not above {before} s, that of the key frame before; sort the lines by time"
    )]
    Order { line: usize, time: f64, before: f64 },
    #[error("line {line}: eye and look-at are both {eye}; move one of them")]
    NoDirection { line: usize, eye: DVec3 },
    #[error(
        "line {line}: angle of view {value:?} must be a number of degrees between 0 and 180; 60 suits a room"
    )]
    Fov { line: usize, value: String },
    #[error("{found} key frames, a path has at least 2; add lines TIME X,Y,Z X,Y,Z [FOV]")]
    TooFew { found: usize },
}
