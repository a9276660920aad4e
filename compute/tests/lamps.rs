//! Laws of the lamps' own views.

mod common;

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::lamps::with_lamps;
use compute::polygon_form_factor::point_to_triangle;
use compute::receivers::ReceiverId;
use compute::rows::{RowBatch, UNITS_PER_ONE};
use compute::settings::{FormFactorSettings, LampViews, Maps, Points};
use compute::sources::Sources;
use glam::{DVec3, Vec3};
use scene::{PatchId, Scene};
use test_scenes::{furnished_sphere, stone};
use visibility::{Drawable, Frame, Strategy};

fn settings(points: Points) -> FormFactorSettings {
    FormFactorSettings {
        points,
        ..FormFactorSettings::new(32)
    }
}

fn rows(scene: &Scene, settings: FormFactorSettings, views: LampViews) -> RowBatch {
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    with_lamps(&hemicubes, views, Box::new(CpuRows::new(&hemicubes)))
        .draw_rows(0..scene.patch_count())
        .unwrap()
}

/// A closed room with a small lamp hanging under its ceiling, and a screen under a half of the lamp if
/// `screened`; surfaces 12 and 13 are the lamp.
fn room(screened: bool, max_area: f64) -> Scene {
    let mut surfaces = common::block(Vec3::ZERO, Vec3::new(2.0, 2.0, 2.0), false, 0);
    let plate = |low: [f32; 2], high: [f32; 2], z: f32, material| {
        let at = |x, y| Vec3::new(x, y, z);
        // Counter-clockwise from below.
        common::quad(
            [
                at(low[0], low[1]),
                at(low[0], high[1]),
                at(high[0], high[1]),
                at(high[0], low[1]),
            ],
            material,
        )
    };
    surfaces.extend(plate([0.9, 0.9], [1.1, 1.1], 1.9, 1));
    if screened {
        surfaces.extend(plate([0.0, 0.0], [1.0, 2.0], 1.8, 0));
    }
    common::scene(
        vec![common::material(0.5, 0.0), common::material(0.0, 100.0)],
        surfaces,
        max_area,
    )
}

fn lamp_units(scene: &Scene, row: &[compute::rows::Entry]) -> f64 {
    row.iter()
        .filter(|e| (12..14).contains(&scene.mesh().surface_of(PatchId(e.source)).0))
        .map(|e| f64::from(e.units))
        .sum()
}

/// The lamp's exact factor from one point.
fn exact(scene: &Scene, frame: &Frame) -> f64 {
    scene.surfaces()[12..14]
        .iter()
        .filter(|s| (frame.position - s.corners[0].as_dvec3()).dot(s.normal()) > 1e-6)
        .map(|s| point_to_triangle(s.corners.map(|p| frame.to_local(p.as_dvec3()))))
        .sum()
}

/// Sums in f64 leave 1e-12, entries are rounded to 2^-24 of themselves.
#[test]
fn lamp_that_nothing_hides_is_exact() {
    let scene = room(false, 0.05);
    for points in [Points::CENTROID, Points::Bisected { bisections: 2 }] {
        let settings = settings(points);
        let rows = rows(&scene, settings, LampViews::Auto);
        let mut lit = 0;
        for patch in 0..scene.patch_count() {
            let frames = Hemicubes::new(&scene, settings)
                .receivers()
                .frames(ReceiverId(patch));
            let expected =
                frames.iter().map(|frame| exact(&scene, frame)).sum::<f64>() / frames.len() as f64;
            let own = scene.mesh().surface_of(PatchId(patch)).0;
            // The ceiling sees the lamp's back, from above; the lamp does not see itself.
            if own >= 12 || expected == 0.0 {
                continue;
            }
            let seen = lamp_units(&scene, rows.row(patch as usize)) / f64::from(UNITS_PER_ONE);
            assert!(
                (seen / expected - 1.0).abs() < 2.0 * common::methods::ROUNDING,
                "{patch}: {seen} {expected}"
            );
            lit += 1;
        }
        assert!(lit > 100);
    }
}

/// Entries are rounded to half of 2^-24 of themselves.
#[test]
fn rows_keep_their_sums() {
    for scene in [
        room(false, 0.1),
        room(true, 0.1),
        common::furnished_room(0.2),
    ] {
        let settings = settings(Points::Bisected { bisections: 1 });
        let drawn = rows(&scene, settings, LampViews::Off);
        for views in [LampViews::Auto, LampViews::All] {
            let refined = rows(&scene, settings, views);
            for k in 0..scene.patch_count() as usize {
                let sum = |rows: &RowBatch| {
                    let unseen = rows.unseen(k);
                    let seen: f64 = rows.row(k).iter().map(|e| f64::from(e.units)).sum();
                    seen + f64::from(unseen.open) + f64::from(unseen.back_face)
                };
                for rows in [&drawn, &refined] {
                    let error = sum(rows) / f64::from(UNITS_PER_ONE) - 1.0;
                    assert!(error.abs() < common::methods::ROUNDING, "{k}: {error}");
                }
                assert!(refined.row(k).is_sorted_by(|a, b| a.source < b.source));
            }
        }
    }
}

/// A triangle a thousand times as long as wide hangs in the room: pixels may miss it, its light may not
/// be lost. Views turn along it and are as fine as it is narrow, so that they find it from everywhere on the
/// floor (the ceiling sees it too wide for a view); and a lamp that is found and not hidden is exact, up to
/// the rounding of its entries.
#[test]
fn regression_light_of_a_sliver_is_not_lost() {
    let mut surfaces = common::block(Vec3::ZERO, Vec3::splat(2.0), false, 0);
    let at = |x, y| Vec3::new(x, y, 1.9);
    for corners in [
        [at(0.3, 0.4), at(1.65, 1.5), at(1.65, 1.498)],
        [at(0.3, 0.4), at(1.65, 1.498), at(1.65, 1.5)],
    ] {
        surfaces.push(scene::Surface {
            corners,
            material: scene::MaterialId(1),
            object: scene::ObjectId(0),
        });
    }
    let materials = vec![common::material(0.5, 0.0), common::material(0.0, 100.0)];
    let scene = common::scene(materials, surfaces, 0.1);
    let settings = settings(Points::CENTROID);
    let rows = rows(&scene, settings, LampViews::Auto);
    let (mut seen, mut expected) = (0.0, 0.0);
    for patch in (0..scene.patch_count()).map(PatchId) {
        let frame = Hemicubes::new(&scene, settings)
            .receivers()
            .frames(ReceiverId(patch.0))[0];
        if frame.position.z == 0.0 {
            let row = rows.row(patch.index());
            seen += lamp_units(&scene, row) / f64::from(UNITS_PER_ONE);
            expected += exact(&scene, &frame);
        }
    }
    assert!((seen / expected - 1.0).abs() < 1e-6, "{seen} {expected}");
}

/// From the floor below, the screen's edge x = 1 at height 1.8 hides about the half x < 1 of the
/// lamp. The view's 64 columns put that edge within
/// half a column, 1/64 of the half that is seen; so do they each of the lamp's four sides, 4/128 of the whole.
/// Together 3/64.
#[test]
fn half_hidden_lamp_counts_half() {
    let scene = room(true, 0.05);
    let settings = settings(Points::CENTROID);
    let rows = rows(&scene, settings, LampViews::Auto);
    let mut tested = 0;
    for patch in 0..scene.patch_count() {
        let frame = Hemicubes::new(&scene, settings)
            .receivers()
            .frames(ReceiverId(patch))[0];
        if frame.position.z != 0.0 || (frame.position.x - 1.0).abs() > 0.2 {
            continue;
        }
        // Exactly: what of the lamp lies beyond the plane through the point and the screen's edge.
        let edge = frame.position.x + (1.0 - frame.position.x) * 1.9 / 1.8;
        let at = |x, y| DVec3::new(x, y, 1.9);
        let corners =
            [at(edge, 0.9), at(edge, 1.1), at(1.1, 1.1), at(1.1, 0.9)].map(|p| frame.to_local(p));
        let expected = point_to_triangle([corners[0], corners[1], corners[2]])
            + point_to_triangle([corners[0], corners[2], corners[3]]);
        let seen = lamp_units(&scene, rows.row(patch as usize)) / f64::from(UNITS_PER_ONE);
        assert!(
            (seen / expected - 1.0).abs() < 3.0 / 64.0,
            "{patch}: {seen} {expected}"
        );
        tested += 1;
    }
    assert!(tested > 3, "{tested}");
}

#[test]
fn without_lamps_and_with_the_thesis_maps_nothing_changes() {
    let scene = room(false, 0.2);
    let exact = settings(Points::CENTROID);
    assert_ne!(
        rows(&scene, exact, LampViews::Auto),
        rows(&scene, exact, LampViews::Off)
    );
    let thesis = FormFactorSettings {
        maps: Maps::Thesis,
        ..exact
    };
    assert_eq!(
        rows(&scene, thesis, LampViews::Auto),
        rows(&scene, thesis, LampViews::Off)
    );
    let dark = common::scene(
        vec![common::material(0.5, 0.0)],
        common::block(Vec3::ZERO, Vec3::ONE, false, 0),
        0.1,
    );
    assert_eq!(
        rows(&dark, exact, LampViews::All),
        rows(&dark, exact, LampViews::Off)
    );
}

/// Views of lamps are windows of other sizes than a hemicube's. A pixel on an edge counts for one of two neighbours: at
/// most 4 / (pi 64^2) = 3e-4 of a row, and twice in a sum of differences; three such pixels may be in one.
#[test]
fn rows_of_all_strategies_are_the_same_but_for_pixels_on_edges() {
    let scene = stone(&furnished_sphere(), f64::INFINITY);
    let [drawn, others @ ..] =
        [Strategy::Spans, Strategy::Specks, Strategy::Rays].map(|strategy| -> Vec<RowBatch> {
            let drawable = Arc::new(Drawable::with_strategy(&scene, strategy));
            let hemicubes = Arc::new(Hemicubes::of_patches(
                Sources::drawn_as(&scene, &drawable),
                FormFactorSettings {
                    points: Points::CENTROID,
                    ..FormFactorSettings::new(64)
                },
            ));
            let inner = Box::new(CpuRows::new(&hemicubes));
            let mut rows = with_lamps(&hemicubes, LampViews::All, inner);
            let patches = (0..scene.patch_count()).step_by(61);
            patches
                .map(|patch| rows.draw_rows(patch..patch + 1).unwrap())
                .collect()
        });
    for (drawn, other) in others.iter().flat_map(|other| drawn.iter().zip(other)) {
        let mut difference = vec![0.0; scene.patch_count() as usize];
        for (row, sign) in [(drawn.row(0), 1.0), (other.row(0), -1.0)] {
            for entry in row {
                difference[entry.source as usize] += sign * f64::from(entry.units);
            }
        }
        let sum: f64 = difference.iter().map(|d| d.abs()).sum();
        let one = f64::from(UNITS_PER_ONE);
        assert!(sum < 2e-3 * one, "{:?}: {}", drawn.receivers(), sum / one);
    }
}
