//! Which faces see distant clusters, and what hides them.

use std::ops::Range;

use fearless_simd::{Level, dispatch};
use glam::{DQuat, EulerRot};
use proptest::prelude::*;

use super::super::clusters::Bounds;
use super::super::hierarchical_depth::HierarchicalDepth;
use super::*;
use crate::buffer::PADDING;
use crate::hemicube;

/// By how much boxes are taken to be too small, metres.
const MARGIN: f64 = 1e-6;

fn cluster(middle: DVec3, half: DVec3) -> Cluster {
    Cluster {
        bounds: Bounds {
            middle,
            half,
            radius: half.length(),
        },
        longest: 0.0,
        kind: Kind::Triangles,
        regions: 0..0,
        vertices: 0..0,
    }
}

fn vectors(range: std::ops::Range<f64>) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(range).prop_map(DVec3::from)
}

proptest! {
    /// A face that sees a point of a cluster is asked for it, and then all of the cluster is in front of the face, if
    /// some of it is above the horizon.
    #[test]
    fn faces_that_see_a_point_see_its_cluster_from_the_front(
        middle in vectors(-4.0..4.0),
        half in vectors(0.0..1.0),
        place in vectors(-1.0..1.0),
    ) {
        let cluster = cluster(middle, half);
        prop_assume!(is_distant(&cluster, middle, 128) && middle.z + half.z > 0.0);
        let point = middle + place * half;
        for (face, window) in hemicube::windows(128).iter().enumerate() {
            let [right, up, forward] = [window.right, window.up, window.forward];
            let (x, y, w) = (point.dot(right), point.dot(up), point.dot(forward));
            let is_seen = point.z > 0.0 && x.abs() <= w && y.abs() <= w;
            prop_assert!(!is_seen || may_be_in(face, middle, &cluster), "face {}", face);
            if may_be_in(face, middle, &cluster) {
                prop_assert!(middle.dot(forward) > cluster.bounds.radius, "face {}", face);
            }
        }
    }

    /// The pixel of a ray that meets a box, in its corners too, is among those that may see it, and no farther than
    /// the box's nearest.
    #[test]
    fn pixels_that_meet_a_box_may_see_it(
        face in 0..5_usize,
        [i, j] in prop::array::uniform2(0..64_usize),
        depth in 0.5..3.0_f64,
        half in vectors(0.0..0.3),
        offset in prop::array::uniform3(prop::sample::select(vec![-1.0, -0.4, 0.0, 0.7, 1.0])),
        turn in prop::array::uniform3(-3.0..3.0_f64),
    ) {
        let window = hemicube::windows(64)[face];
        prop_assume!(j < window.height);
        let turn = DQuat::from_euler(EulerRot::XYZ, turn[0], turn[1], turn[2]);
        let frame = Frame {
            position: DVec3::new(0.2, -0.3, 0.1),
            tangent: turn * DVec3::X,
            bitangent: turn * DVec3::Y,
            normal: turn * DVec3::Z,
        };
        let at = |corner: f64, k: usize| corner + (k as f64 + 0.5) * window.pixel;
        let ray = window.forward
            + at(window.left, i) * window.right
            + at(window.bottom, j) * window.up;
        let point = frame.position + frame.to_scene(depth * ray);
        let cluster = cluster(point + DVec3::from(offset) * half, half);
        let middle = frame.to_local(cluster.bounds.middle);
        prop_assume!(is_distant(&cluster, middle, 64));
        let pixels = Camera::new(&frame, &window, MARGIN).pixels(&cluster);
        let pixels = pixels.expect("a ray meets it");
        prop_assert!(pixels.columns.contains(&i) && pixels.rows.contains(&j));
        prop_assert!(f64::from(pixels.nearest) > 1.0 / depth);
        // No corner is nearer than the sphere round the box, which is in front of the eye; f32 rounds by 2^-24.
        let nearest = middle.dot(window.forward) - cluster.bounds.radius - MARGIN;
        prop_assert!(f64::from(pixels.nearest) <= (CLEARLY_FARTHER + 1e-7) / nearest);
    }

    /// As all pixels one by one, for pictures of any size.
    #[test]
    fn hidden_is_what_is_behind_all_pixels_of_its_blocks(
        [width, height] in prop::array::uniform2(1..40_usize),
        far in prop::collection::vec((0..40_usize, 0..40_usize), 0..40),
        columns in (0..40_usize, 1..40_usize),
        rows in (0..40_usize, 1..40_usize),
        nearest in prop::sample::select(vec![0.5_f32, 1.0, 1.5]),
    ) {
        let mut window = hemicube::windows(2)[0];
        (window.width, window.height) = (width, height);
        let mut inverse_depth = vec![0.0; (width + PADDING) * height];
        let mut depth = HierarchicalDepth::default();
        depth.start(&window);
        let hides = |depth: &mut HierarchicalDepth, inverse_depth: &[f32]| {
            let part = |(first, count): (usize, usize), most: usize| {
                let first = first.min(most - 1);
                first..(first + count).min(most)
            };
            let pixels = Rectangle {
                columns: part(columns, width),
                rows: part(rows, height),
                nearest,
            };
            let level = Level::new();
            let hides = dispatch!(level, simd => depth.hides(simd, inverse_depth, &pixels));
            let blocks = |range: &Range<usize>, most: usize| {
                range.start / 8 * 8..range.end.next_multiple_of(8).min(most)
            };
            let mut pixels = blocks(&pixels.rows, height)
                .flat_map(|j| blocks(&pixels.columns, width).map(move |i| (i, j)));
            let is_hidden = pixels.all(|(i, j)| inverse_depth[j * (width + PADDING) + i] > nearest);
            (hides, is_hidden)
        };
        let (before, is_hidden) = hides(&mut depth, &inverse_depth);
        prop_assert_eq!(before, is_hidden);
        for j in 0..height {
            for i in 0..width {
                let is_far = far.contains(&(i, j));
                inverse_depth[j * (width + PADDING) + i] = if is_far { 1.0 } else { 2.0 };
            }
        }
        depth.start(&window);
        let (after, is_hidden) = hides(&mut depth, &inverse_depth);
        prop_assert_eq!(after, is_hidden);
    }
}
