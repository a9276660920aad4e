//! Gathering from rows as they are kept, without an entry being written out.

use fearless_simd::{Level, Simd, dispatch, f32x4, f32x8, f64x4, i32x4, prelude::*, u16x8, u32x4};
use fearless_simd_macros::simd;
use glam::DVec3;
use scene::Rgb;

use super::{BLOCK, Header, LANES, Row, WIDE, step};
use crate::rows::UNITS_PER_ONE;

/// Radiosities by channel, W/m^2, as decoding reads them: one per patch, and as many more as fill a block.
#[derive(Clone, Debug)]
pub struct Channels([Vec<f32>; 3]);

impl Channels {
    /// One per patch.
    pub fn new(radiosity: impl ExactSizeIterator<Item = Rgb>) -> Self {
        let length = radiosity.len().next_multiple_of(BLOCK);
        let mut channels = Self([(); 3].map(|()| vec![0.0; length]));
        for (patch, radiosity) in radiosity.enumerate() {
            channels.set(patch, radiosity);
        }
        channels
    }

    /// Changes one patch's.
    #[inline]
    pub fn set(&mut self, patch: usize, radiosity: Rgb) {
        for (channel, value) in self.0.iter_mut().zip(radiosity.to_array()) {
            channel[patch] = value;
        }
    }
}

/// Gathers by the best instructions there are; all give the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Gatherer {
    level: Level,
}

impl Default for Gatherer {
    fn default() -> Self {
        Self {
            level: Level::new(),
        }
    }
}

impl Gatherer {
    /// Irradiance H = sum_j F_ij B_j, W/m^2.
    #[inline]
    pub fn irradiance(self, row: Row, radiosity: &Channels) -> Rgb {
        (self.gather(row, radiosity) / f64::from(UNITS_PER_ONE)).as_vec3()
    }

    /// sum_j units_j B_j over a row's entries. Each product is exact in f64, and each of eight sums adds up
    /// every eighth patch, in their order.
    #[inline]
    pub fn gather(self, row: Row, radiosity: &Channels) -> DVec3 {
        dispatch!(self.level, simd => gather(simd, row, radiosity))
    }
}

#[simd]
fn gather<S: Simd>(simd: S, row: Row, radiosity: &Channels) -> DVec3 {
    let [red, green, blue] = &radiosity.0;
    let mut sums = [[f64x4::splat(simd, 0.0); 2]; 3];
    let numbers = row.numbers;
    let (mut next_block, mut at) = (0, 0);
    for &header in row.headers {
        let header = Header::new(header);
        let block = next_block + header.skipped as usize;
        next_block = block + 1;
        for half in 0..2 {
            let bits = header.bits >> (LANES * half) & 0xff;
            let length = bits.count_ones() as usize;
            let mask = <u16x8<S> as SimdBase<S>>::Mask::from_bitmask(simd, u64::from(bits));
            let read = |at: usize| {
                let numbers = u16x8::from_slice(simd, &numbers[at..at + LANES]).expand(mask);
                numbers.widen()
            };
            let (low, high) = read(at);
            let units: f32x8<S> = if header.storage == WIDE {
                let (low_upper, high_upper) = read(at + length);
                let low: u32x4<S> = low | (low_upper << 16);
                let high: u32x4<S> = high | (high_upper << 16);
                at += 2 * length;
                let low: f32x4<S> = low.bitcast();
                let high: f32x4<S> = high.bitcast();
                low.combine(high)
            } else {
                at += length;
                let low: f32x4<S> = low.bitcast::<i32x4<S>>().to_float();
                let high: f32x4<S> = high.bitcast::<i32x4<S>>().to_float();
                low.combine(high) * step(header.storage)
            };
            let units: (f64x4<S>, f64x4<S>) = units.widen();
            let first = block * BLOCK + LANES * half;
            for (sums, channel) in sums.iter_mut().zip([red, green, blue]) {
                let values = f32x8::from_slice(simd, &channel[first..first + LANES]).widen();
                sums[0] = units.0.mul_add(values.0, sums[0]);
                sums[1] = units.1.mul_add(values.1, sums[1]);
            }
        }
    }
    let sum = |[low, high]: [f64x4<S>; 2]| {
        let four: [f64; 4] = (low + high).into();
        (four[0] + four[2]) + (four[1] + four[3])
    };
    DVec3::new(sum(sums[0]), sum(sums[1]), sum(sums[2]))
}
