//! Corners at one place as one vertex.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::Vec3;

/// A position as bits that can be hashed and sorted.
pub type Place = [u32; 3];

/// The place of a position, metres: equal positions have equal places, 0 and -0 among them.
#[inline]
pub fn place(position: Vec3) -> Place {
    // -0 + 0 = 0
    position.to_array().map(|v| (v + 0.0).to_bits())
}

/// The places of a triangle's corners, the same whichever corner comes first.
pub fn places(corners: [Vec3; 3]) -> [Place; 3] {
    let mut places = corners.map(place);
    let least = (0..3).min_by_key(|&k| places[k]).unwrap_or(0);
    places.rotate_left(least);
    places
}

/// Positions, each once, by first use.
#[derive(Clone, Debug, Default)]
pub struct Vertices {
    indices: HashMap<Place, u32, BuildHasherDefault<Mix>>,
    positions: Vec<Vec3>,
}

impl Vertices {
    /// None yet, with room for some.
    pub fn with_capacity(count: usize) -> Self {
        Self {
            indices: HashMap::with_capacity_and_hasher(count, BuildHasherDefault::default()),
            positions: Vec::with_capacity(count),
        }
    }

    /// The index of a position, metres, which is new if it is that of the last vertex and was not there before.
    #[inline]
    pub fn index(&mut self, position: Vec3) -> u32 {
        *self.indices.entry(place(position)).or_insert_with(|| {
            self.positions.push(position + Vec3::ZERO);
            self.positions.len() as u32 - 1
        })
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.positions.len() as u32
    }

    /// The positions, metres, by their indices; no coordinate is -0.
    pub fn into_positions(self) -> Vec<Vec3> {
        self.positions
    }
}

/// Hashes the bits of coordinates, whose low bits are often all 0.
#[derive(Clone, Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        let mixed = (self.0 ^ self.0 >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed ^ mixed >> 32
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(4) {
            let mut word = [0; 4];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u32(u32::from_le_bytes(word));
        }
    }

    fn write_u32(&mut self, word: u32) {
        self.0 = (self.0 ^ u64::from(word))
            .wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .rotate_left(26);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_one_vertex_with_either_zero() {
        let mut vertices = Vertices::default();
        let a = Vec3::new(0.0, 1.0, 2.0);
        let b = Vec3::new(0.0, 1.0, 2.0_f32.next_up());
        assert_eq!([a, b, a].map(|p| vertices.index(p)), [0, 1, 0]);
        assert_eq!(vertices.index(Vec3::new(-0.0, 1.0, 2.0)), 0);
        assert_eq!(vertices.count(), 2);
        assert_eq!(vertices.into_positions(), [a, b]);
    }

    #[test]
    fn places_of_a_triangle_keep_its_side_but_not_its_first_corner() {
        let [a, b, c] = [Vec3::X, Vec3::Y, Vec3::Z];
        assert_eq!(places([a, b, c]), places([c, a, b]));
        assert_ne!(places([a, b, c]), places([a, c, b]));
    }
}
