//! Vectors of three coordinates, four at a time.

use fearless_simd::{Simd, f64x4};
use glam::DVec3;

use crate::Frame;

/// Four vectors.
#[derive(Clone, Copy)]
pub(crate) struct Vectors<S: Simd> {
    pub x: f64x4<S>,
    pub y: f64x4<S>,
    pub z: f64x4<S>,
}

impl<S: Simd> Vectors<S> {
    /// Points, as [`Frame::to_local`] has them, bit by bit.
    #[inline(always)]
    pub fn in_frame(self, frame: &Frame) -> Self {
        let from = frame.position;
        let v = Self {
            x: self.x - from.x,
            y: self.y - from.y,
            z: self.z - from.z,
        };
        Self {
            x: v.along(frame.tangent),
            y: v.along(frame.bitangent),
            z: v.along(frame.normal),
        }
    }

    /// Products with one vector.
    #[inline(always)]
    pub fn along(self, v: DVec3) -> f64x4<S> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    #[inline(always)]
    pub fn dot(self, v: Self) -> f64x4<S> {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    #[inline(always)]
    pub fn cross(self, v: Self) -> Self {
        Self {
            x: self.y * v.z - v.y * self.z,
            y: self.z * v.x - v.z * self.x,
            z: self.x * v.y - v.x * self.y,
        }
    }

    #[inline(always)]
    pub fn minus(self, v: Self) -> Self {
        Self {
            x: self.x - v.x,
            y: self.y - v.y,
            z: self.z - v.z,
        }
    }

    #[inline(always)]
    pub fn to_array(self) -> [f64x4<S>; 3] {
        [self.x, self.y, self.z]
    }
}
