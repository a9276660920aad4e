//! Patches are those that `display` sees, and picks are what is drawn.

use scene::PatchId;
use window::looks::Looks;
use window::values::Values;

use crate::model::{
    SAMPLES, SIZE, asked, drawn, inside, outside, patches_of_display, renderer, room,
};

/// A graphics card rounds corners to 1/256 of a pixel, and `display` sees what a ray within 1/170 of a pixel meets: where they see
/// different patches, both are within a sample of each other.
fn expect_agreement(looks: Looks, camera: display::Camera) {
    let loaded = room();
    let asked = asked(camera, looks, None);
    let theirs = patches_of_display(&loaded, &asked);
    let samples = drawn(&loaded, &asked);
    let (width, height) = (SIZE.width * SAMPLES, SIZE.height * SAMPLES);
    let mut differing = 0;
    for (k, &(_, seen)) in samples.iter().enumerate() {
        if seen == theirs[k] {
            continue;
        }
        differing += 1;
        let (x, y) = (k as u32 % width, k as u32 / width);
        let beside = |x: u32, y: u32| theirs[(y * width + x) as usize] == seen;
        let is_beside = (y.saturating_sub(1)..=(y + 1).min(height - 1))
            .any(|y| (x.saturating_sub(1)..=(x + 1).min(width - 1)).any(|x| beside(x, y)));
        assert!(
            is_beside,
            "{seen:?} at {x}, {y} where display sees {:?}",
            theirs[k]
        );
    }
    // A sample has a side within 1/100 of it with a probability of some 2/100 for each side that crosses it; not every one is crossed.
    assert!(
        differing * 50 < samples.len(),
        "{differing} of {}",
        samples.len()
    );
    assert!(samples.iter().any(|(_, seen)| seen.is_some()) || looks.has_backs);
}

pub fn every_sample_sees_the_patch_that_display_sees() {
    for has_backs in [false, true] {
        let looks = Looks {
            has_backs,
            ..Looks::default()
        };
        for camera in [inside(), outside()] {
            expect_agreement(looks, camera);
        }
    }
}

pub fn backs_hide_what_is_behind_them_if_they_are_drawn() {
    let loaded = room();
    let count = |has_backs| {
        let looks = Looks {
            has_backs,
            ..Looks::default()
        };
        let samples = drawn(&loaded, &asked(outside(), looks, None));
        samples.iter().filter(|(_, seen)| seen.is_some()).count()
    };
    // The room is closed.
    assert_eq!(count(true), 0);
    assert!(count(false) > 0);
}

pub fn a_click_picks_the_patch_that_is_drawn_there() {
    let loaded = room();
    let looks = Looks::default();
    let asked = asked(outside(), looks, None);
    let mut renderer = renderer();
    assert_eq!(renderer.patch_at([0.5, 0.5]), None);
    let values = Values::new(&loaded, &looks).unwrap();
    let tone = looks.tone(values.range);
    renderer
        .set_scene(&loaded.scene, loaded.solution.as_ref(), &values, tone)
        .unwrap();
    renderer.draw(&asked);
    let samples = renderer.samples().unwrap();
    let [width, height] = renderer.sample_size().unwrap();
    let mut picked = 0;
    for (x, y) in [
        (0, 0),
        (width / 2, height / 2),
        (width / 3, height / 2),
        (width - 1, height - 1),
    ] {
        let share = [(x, width), (y, height)].map(|(k, count)| (k as f32 + 0.5) / count as f32);
        let (_, seen) = samples[(y * width + x) as usize];
        assert_eq!(renderer.patch_at(share), seen);
        picked += usize::from(seen.is_some());
    }
    assert!(picked > 0);
    // A pointer on the border or beyond.
    for share in [[1.0, 1.0], [-0.1, 2.0]] {
        assert_eq!(
            renderer.patch_at(share),
            renderer.patch_at(share.map(|s: f32| s.clamp(0.0, 0.999)))
        );
    }
}

pub fn an_outline_lies_on_the_picked_patch_alone() {
    let loaded = room();
    let plain = drawn(&loaded, &asked(inside(), Looks::default(), None));
    let (_, patch) = plain[plain.len() / 2];
    let patch: PatchId = patch.unwrap();
    let outlined = drawn(&loaded, &asked(inside(), Looks::default(), Some(patch)));
    let mut changed = 0;
    for (before, after) in plain.iter().zip(&outlined) {
        assert_eq!(before.1, after.1);
        if before.0 != after.0 {
            assert_eq!(before.1, Some(patch));
            changed += 1;
        }
    }
    assert!(changed > 0);
}

pub fn wires_change_colours_and_no_patch() {
    let loaded = room();
    let looks = Looks {
        has_wires: true,
        ..Looks::default()
    };
    let plain = drawn(&loaded, &asked(inside(), Looks::default(), None));
    let wired = drawn(&loaded, &asked(inside(), looks, None));
    assert!(
        plain
            .iter()
            .zip(&wired)
            .all(|(before, after)| before.1 == after.1)
    );
    let changed = plain.iter().zip(&wired).filter(|(a, b)| a.0 != b.0).count();
    assert!(
        changed > 0 && 2 * changed < plain.len(),
        "{changed} of {}",
        plain.len()
    );
}

pub fn a_picture_of_no_scene_is_empty() {
    let mut renderer = renderer();
    renderer.draw(&asked(inside(), Looks::default(), None));
    let samples = renderer.samples().unwrap();
    assert!(samples.iter().all(|(_, seen)| seen.is_none()));
    assert_eq!(renderer.failure(), None);
}
