//! Laws of camera paths: where they are at their key frames, and how far they stray between them.

use display::camera_path::{CameraPath, CameraPathFault};
use glam::DVec3;
use proptest::prelude::*;

/// A key frame's time, eye, look-at.
type Key = (f64, DVec3, DVec3);

fn text(keys: &[Key]) -> String {
    let point = |p: &DVec3| format!("{},{},{}", p.x, p.y, p.z);
    let lines = keys.iter().map(|(time, eye, look_at)| {
        // The shortest text that is the same f64.
        format!("{time} {} {}\n", point(eye), point(look_at))
    });
    lines.collect()
}

fn path(keys: &[Key]) -> CameraPath {
    CameraPath::parse(&text(keys)).unwrap()
}

/// Two to seven key frames at very uneven times, on a grid so coarse that points are often repeated.
fn any_keys() -> impl Strategy<Value = Vec<Key>> {
    let point =
        || prop::array::uniform3(-3_i32..=3).prop_map(|p| 1.7 * DVec3::from(p.map(f64::from)));
    let key = (-3.0_f64..3.0, point(), point());
    prop::collection::vec(key, 2..=7).prop_map(|keys| {
        let mut time = -5.0;
        let keys = keys.into_iter().map(|(exponent, eye, look_at)| {
            time += 10.0_f64.powf(exponent);
            let look_at = if eye == look_at {
                eye + DVec3::Y
            } else {
                look_at
            };
            (time, eye, look_at)
        });
        keys.collect()
    })
}

/// Rounding of a few sums of numbers below 100.
const ROUNDING: f64 = 1e-12;

proptest! {
    #[test]
    fn path_is_at_its_key_frames_exactly(keys in any_keys()) {
        let path = path(&keys);
        for &(time, eye, look_at) in &keys {
            let pose = path.at(time);
            prop_assert_eq!((pose.eye, pose.look_at), (eye, look_at));
        }
    }

    #[test]
    fn eye_is_nowhere_further_from_its_chord_than_half_of_it(keys in any_keys()) {
        let path = path(&keys);
        for pair in keys.windows(2) {
            let [(t0, from, _), (t1, to, _)] = [pair[0], pair[1]];
            let chord = to - from;
            for k in 0..=50 {
                let eye = path.at(t0 + f64::from(k) / 50.0 * (t1 - t0)).eye;
                let along = ((eye - from).dot(chord) / chord.length_squared().max(1e-300)).clamp(0.0, 1.0);
                let off = eye.distance(from + along * chord);
                prop_assert!(off <= 0.5 * chord.length() + ROUNDING, "{off} m of {chord}");
            }
        }
    }

    #[test]
    fn eye_moves_without_a_jump(keys in any_keys()) {
        // A monotone cubic is at most 3 times as fast as its mean. By s, a piece of chord L moves at most
        // 1.5 L by w, and 2 L by each tangent, since (s (1 - s)^2)' is at most 1.
        const FASTEST: f64 = 3.0 * (1.5 + 2.0 + 2.0);
        const STEPS: i32 = 1000;
        let path = path(&keys);
        for pair in keys.windows(2) {
            let [(t0, from, _), (t1, to, _)] = [pair[0], pair[1]];
            let at = |k: i32| path.at(t0 + f64::from(k) / f64::from(STEPS) * (t1 - t0)).eye;
            for k in 0..STEPS {
                let step = at(k).distance(at(k + 1));
                let limit = FASTEST * from.distance(to) / f64::from(STEPS);
                // Times that are close to each other have fewer digits.
                prop_assert!(step <= 1.01 * limit + ROUNDING, "{step} m at {k}, not {limit}");
            }
        }
    }

    #[test]
    fn eye_is_never_where_it_looks(keys in any_keys()) {
        let path = path(&keys);
        for pose in path.frames(500.0 / path.duration()) {
            prop_assert!(pose.eye != pose.look_at, "{pose:?}");
            prop_assert!(pose.eye.is_finite() && pose.look_at.is_finite());
        }
    }
}

#[test]
fn straight_way_at_even_times_has_one_speed() {
    let (start, step) = (DVec3::new(-2.0, 1.6, 7.0), DVec3::new(0.7, -0.1, -1.3));
    let keys: Vec<Key> = (0..6)
        .map(|k| {
            let eye = start + f64::from(k) * step;
            (2.0 + 0.5 * f64::from(k), eye, eye + DVec3::NEG_Z)
        })
        .collect();
    let path = path(&keys);
    for k in 0..=1000 {
        let share = f64::from(k) / 1000.0;
        let pose = path.at(2.0 + 2.5 * share);
        assert!(pose.eye.distance(start + 5.0 * share * step) < ROUNDING);
        assert!(pose.look_at.distance(pose.eye + DVec3::NEG_Z) < ROUNDING);
    }
}

#[test]
fn straight_way_stays_straight_and_forward_at_uneven_times() {
    let places = [0.0, 0.1, 4.0, 4.5, 20.0];
    let times = [0.0, 3.0, 3.1, 9.0, 9.5];
    let direction = DVec3::new(2.0, 3.0, 6.0) / 7.0;
    let keys: Vec<Key> = times
        .into_iter()
        .zip(places)
        .map(|(time, place)| (time, place * direction, DVec3::X * 100.0))
        .collect();
    let path = path(&keys);
    for k in 0..=1000 {
        let eye = path.at(9.5 * f64::from(k) / 1000.0).eye;
        assert!(eye.cross(direction).length() < ROUNDING, "{eye}");
    }
}

#[test]
fn speed_has_no_jump_at_key_frames() {
    let keys = [
        (0.0, DVec3::ZERO, DVec3::X),
        (1.0, DVec3::new(1.0, 0.0, 2.0), DVec3::X),
        (4.0, DVec3::new(3.0, 1.0, 2.0), DVec3::X),
        (4.5, DVec3::new(3.0, 4.0, 0.0), DVec3::X),
        (8.0, DVec3::new(0.0, 4.0, 0.0), DVec3::X),
    ];
    let path = path(&keys);
    // Speeds are some 6 m/s at most and change within a quarter of a second: accelerations below 100 m/s^2.
    let (step, limit) = (1e-6, 1e-4);
    for (time, eye, _) in &keys[1..4] {
        let before = (*eye - path.at(time - step).eye) / step;
        let after = (path.at(time + step).eye - *eye) / step;
        assert!(before.length() > 0.1, "{before} m/s at {time} s");
        assert!(before.distance(after) < limit, "{before} {after}");
    }
}

#[test]
fn camera_waits_where_a_point_is_repeated() {
    let place = DVec3::new(3.0, 1.0, 2.0);
    let keys = [
        (0.0, DVec3::ZERO, DVec3::X),
        (1.0, place, DVec3::X),
        (5.0, place, DVec3::Y),
        (6.0, DVec3::new(-2.0, 5.0, 0.0), DVec3::Y),
    ];
    let path = path(&keys);
    for k in 0..=100 {
        assert_eq!(path.at(1.0 + 0.04 * f64::from(k)).eye, place);
    }
    // It comes to rest: in the last thousandth of a second it is slower than a hundredth of its mean speed.
    assert!(path.at(0.999).eye.distance(place) < 0.001 * 0.01 * place.length());
}

#[test]
fn camera_that_meets_what_it_looks_at_looks_as_in_the_nearer_key_frame() {
    let path = CameraPath::parse("0 -1,0,0 1,0,0\n2 1,0,0 -1,0,0").unwrap();
    for (time, forward) in [
        (0.0, 1.0),
        (0.9999, 1.0),
        (1.0, 1.0),
        (1.0001, -1.0),
        (2.0, -1.0),
    ] {
        let pose = path.at(time);
        let direction = (pose.look_at - pose.eye).normalize();
        assert_eq!(direction, DVec3::X * forward, "at {time} s");
    }
}

#[test]
fn camera_far_from_the_origin_never_looks_at_itself() {
    // Of coordinates of 1e12 an f64 tells 0.0001 apart.
    let path = CameraPath::parse("0 1e12,0,0 1e12,1e-9,0\n1 -1e12,1,0 -1e12,0,1e-200\n").unwrap();
    for pose in path.frames(1000.0) {
        assert!(pose.eye != pose.look_at, "{pose:?}");
    }
}

#[test]
fn angle_of_view_carries_over_and_stays_between_its_key_frames() {
    let path = CameraPath::parse(
        "0 0,0,0 1,0,0\n1 0,0,0 1,0,0 40\n2 0,0,0 1,0,0\n3 0,0,0 1,0,0 90 # wide\n4 0,0,0 1,0,0 60",
    )
    .unwrap();
    let fov = |time| path.at(time).fov_degrees.unwrap();
    for (time, expected) in [
        (0.0, 40.0),
        (0.5, 40.0),
        (1.5, 40.0),
        (2.0, 40.0),
        (3.0, 90.0),
    ] {
        assert_eq!(path.at(time).fov_degrees, Some(expected), "at {time} s");
    }
    for k in 1..100 {
        let fov = fov(2.0 + 0.01 * f64::from(k));
        assert!(fov > 40.0 && fov < 90.0, "{fov}");
    }
    assert_eq!(path.at(4.0).fov_degrees, Some(60.0));
    let without = CameraPath::parse("0 0,0,0 1,0,0\n1 0,0,0 1,0,0").unwrap();
    assert_eq!(without.at(0.5).fov_degrees, None);
}

#[test]
fn frames_begin_and_end_at_key_frames_and_are_even() {
    let path = CameraPath::parse("0.1 0,0,0 1,0,0\n0.7 5,0,0 9,0,0").unwrap();
    for (rate, count) in [
        (10.0, 7),
        (25.0, 16),
        (0.1, 2),
        (0.0, 2),
        (-5.0, 2),
        (f64::NAN, 2),
    ] {
        let frames: Vec<_> = path.frames(rate).collect();
        assert_eq!(
            (path.frames(rate).len(), frames.len()),
            (count, count),
            "rate {rate}"
        );
        assert_eq!(frames[0], path.at(0.1));
        assert_eq!(frames[count - 1], path.at(0.7));
        assert_eq!(frames[count - 1].eye, DVec3::X * 5.0);
        for (k, frame) in frames.iter().enumerate() {
            // The time is rounded, at 8.3 m/s, as is the place.
            let expected = 5.0 * k as f64 / (count - 1) as f64;
            assert!((frame.eye.x - expected).abs() < ROUNDING);
        }
    }
    assert_eq!(path.frames(f64::INFINITY).len(), i32::MAX as usize);
    assert!((path.duration() - 0.6).abs() < 1e-15);
}

#[test]
fn time_outside_of_the_path_is_its_nearer_end() {
    let path = CameraPath::parse("1 0,0,0 1,0,0\n2 5,0,0 9,0,0").unwrap();
    for (time, key) in [
        (-1e300, 1.0),
        (f64::NEG_INFINITY, 1.0),
        (f64::NAN, 1.0),
        (7.0, 2.0),
        (f64::INFINITY, 2.0),
    ] {
        assert_eq!(path.at(time), path.at(key), "at {time} s");
    }
}

#[test]
fn comments_blank_lines_tabs_and_line_ends_of_windows_are_read() {
    let plain = CameraPath::parse("0 0,0,0 1,0,0\n1.5 5,0,0 9,0,-0.25 50\n").unwrap();
    let other = "\u{feff}# a walk\r\n\r\n  0\t0,0,0   1,0,0 # here\r\n#\r\n15e-1 5,0,0 9,0,-.25 50";
    assert_eq!(CameraPath::parse(other).unwrap(), plain);
}

#[test]
fn fault_names_its_line_the_thing_and_the_value() {
    let start = "# walk\n0 0,0,0 1,0,0\n";
    for (line, parts) in [
        ("1 0,0,0", &["line 3", "2 fields", "3 or 4"][..]),
        ("1 0,0,0 1,0,0 60 7", &["line 3", "5 fields"]),
        ("1 0, 0, 0 1,0,0", &["line 3", "5 fields", "without spaces"]),
        ("x 0,0,0 1,0,0", &["line 3", "time", "\"x\""]),
        ("nan 0,0,0 1,0,0", &["line 3", "time", "\"nan\""]),
        ("inf 0,0,0 1,0,0", &["line 3", "time", "\"inf\""]),
        ("1 0,0 1,0,0", &["line 3", "eye", "\"0,0\"", "X,Y,Z"]),
        ("1 0,0,0 1,0,0,0", &["line 3", "look-at", "\"1,0,0,0\""]),
        ("1 0,0,y 1,0,0", &["line 3", "eye", "\"0,0,y\""]),
        (
            "1 0,0,0 1,0,1.1e12",
            &["line 3", "look-at", "\"1,0,1.1e12\"", "1e12"],
        ),
        ("1 0,0,-inf 1,0,0", &["line 3", "eye", "-inf"]),
        ("0 0,0,0 1,0,0", &["line 3", "time 0 s", "not above 0 s"]),
        ("-2 0,0,0 1,0,0", &["line 3", "time -2 s"]),
        ("1 1,0,0 1,0,0", &["line 3", "eye and look-at", "[1, 0, 0]"]),
        ("1 0,0,0 1,0,0 0", &["line 3", "angle of view \"0\"", "180"]),
        ("1 0,0,0 1,0,0 180", &["line 3", "\"180\""]),
        ("1 0,0,0 1,0,0 nan", &["line 3", "\"nan\""]),
        ("", &["1 key frames", "at least 2"]),
    ] {
        let message = CameraPath::parse(&format!("{start}{line}\n"))
            .unwrap_err()
            .to_string();
        for part in parts {
            assert!(message.contains(part), "{line:?}: {message}");
        }
    }
    assert!(matches!(
        CameraPath::parse(""),
        Err(CameraPathFault::TooFew { found: 0 })
    ));
}

#[test]
fn fault_of_a_file_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("walk.txt");
    for (bytes, parts) in [
        (None, &["walk.txt", "cannot read"][..]),
        (
            Some(&b"0 0,0,0 1,0,0\n1 0,0,0\n"[..]),
            &["walk.txt", "line 2"],
        ),
        (
            Some(b"0 0,0,0 1,0,0\n# caf\xe9\n"),
            &["walk.txt", "line 2", "UTF-8"],
        ),
    ] {
        if let Some(bytes) = bytes {
            std::fs::write(&file, bytes).unwrap();
        }
        let message = CameraPath::read(&file).unwrap_err().to_string();
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    }
    std::fs::write(&file, "0 0,0,0 1,0,0\n1 0,1,0 1,0,0\n").unwrap();
    let path = CameraPath::read(&file).unwrap();
    assert_eq!(path.at(1.0).eye, DVec3::Y);
}
