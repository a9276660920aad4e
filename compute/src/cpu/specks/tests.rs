//! What is behind a horizon costs nothing.

use std::sync::Arc;

use glam::DVec3;
use scene::PatchId;

use super::*;
use crate::cpu::drawable::{Dense, Drawable};
use crate::cpu::test_scenes::{Triangle, bumpy_sphere, scene};
use crate::hemicubes::Hemicubes;
use crate::settings::{FormFactorSettings, Points};

/// Seen from its own outside, a ball is behind the horizon, but for some bumps. Nothing is set up of what is in
/// clusters that are all behind it; of one at the horizon, of which all may be, half is above.
#[test]
fn clusters_behind_the_horizon_cost_nothing() {
    let outwards = |[a, b, c]: Triangle| [a, c, b];
    let ball = bumpy_sphere(24)
        .into_iter()
        .map(outwards)
        .collect::<Vec<_>>();
    let scene = scene(&ball, f64::INFINITY);
    let drawable = Arc::new(Drawable::with(&scene, Dense::Specks));
    let settings = FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(64)
    };
    let hemicubes = Hemicubes::between(&scene, &drawable, settings);
    let clusters = drawable.clusters.as_ref().unwrap();
    let mut projection = Projection::new(&drawable);
    let (mut above, mut tried) = (0, 0);
    for patch in (0..scene.patch_count()).step_by(101).map(PatchId) {
        let frame = hemicubes.frames(patch)[0];
        projection.set_for_hemicube(64, &frame, hemicubes.surface_of(patch));
        let height = |corner: DVec3| frame.to_local(corner).z;
        let is_above = |surface: &scene::Surface| {
            surface
                .corners
                .iter()
                .any(|corner| height(corner.as_dvec3()) > 0.0)
        };
        above += scene.surfaces().iter().filter(|s| is_above(s)).count();
        let specks = &projection.specks;
        tried += specks
            .drawn
            .iter()
            .map(|bits| bits.count_ones() as usize)
            .sum::<usize>();
        tried += specks
            .of_faces
            .iter()
            .map(|(count, _)| count)
            .sum::<usize>();
        for distant in specks.distant.iter().flatten() {
            let cluster = distant.of(clusters);
            assert!(!cluster.bounds.is_below(&frame), "{cluster:?}");
            tried += cluster.places().len();
        }
    }
    println!("{tried} tried, {above} above their horizons");
    assert!(
        above > 0 && tried <= 2 * above,
        "{tried} tried, {above} above"
    );
}
