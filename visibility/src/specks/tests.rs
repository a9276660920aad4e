//! What is behind a horizon costs nothing.

use std::sync::Arc;

use glam::DVec3;
use scene::PatchId;
use test_scenes::{Triangle, bumpy_sphere, stone};

use super::*;
use crate::{Drawable, Strategy, Viewer};

/// Seen from its own outside, a ball is behind the horizon, but for some bumps. Nothing is set up of what is in
/// clusters that are all behind it; of one at the horizon, of which all may be, half is above.
#[test]
fn clusters_behind_the_horizon_cost_nothing() {
    let outwards = |[a, b, c]: Triangle| [a, c, b];
    let ball = bumpy_sphere(24)
        .into_iter()
        .map(outwards)
        .collect::<Vec<_>>();
    let scene = stone(&ball, f64::INFINITY);
    let drawable = Arc::new(Drawable::with_strategy(&scene, Strategy::Specks));
    let mut viewer = Viewer::new(&drawable);
    let (mut above, mut tested) = (0, 0);
    for patch in (0..scene.patch_count()).step_by(101).map(PatchId) {
        let geometry = scene.patch(patch);
        let normal = scene.surface(geometry.surface).normal();
        let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), 0.7);
        let hemicube = viewer.hemicube(64, &frame, geometry.surface);
        let (specks, clusters) = hemicube.specks.unwrap();
        let height = |corner: DVec3| frame.to_local(corner).z;
        let is_above = |surface: &scene::Surface| {
            surface
                .corners
                .iter()
                .any(|corner| height(corner.as_dvec3()) > 0.0)
        };
        above += scene.surfaces().iter().filter(|s| is_above(s)).count();
        tested += specks
            .drawn
            .iter()
            .map(|bits| bits.count_ones() as usize)
            .sum::<usize>();
        tested += specks
            .of_faces
            .iter()
            .map(|(count, _)| count)
            .sum::<usize>();
        for distant in specks.distant.iter().flatten() {
            let cluster = distant.of(clusters);
            assert!(!cluster.bounds.is_below(&frame), "{cluster:?}");
            tested += cluster.places().len();
        }
    }
    println!("{tested} tested, {above} above their horizons");
    assert!(
        above > 0 && tested <= 2 * above,
        "{tested} tested, {above} above"
    );
}
