//! Laws of cameras: where patches appear, and where a camera stands that nobody placed.

mod common;

use std::sync::Arc;

use common::{Builder, closed_cube};
use display::probe::Probe;
use display::{Axis, Mode, Picture, RenderSettings, Size, render, shade, up};
use glam::{DVec3, Vec3};
use scene::Scene;
use visibility::{Cull, Drawable, Sample};

const SIZE: Size = Size {
    width: 80,
    height: 60,
};

fn ids_settings() -> RenderSettings {
    RenderSettings {
        mode: Mode::Ids,
        raw_ids: true,
        size: Some(SIZE),
        ..RenderSettings::default()
    }
}

/// The patch in each pixel, by the bytes of an IDs picture.
fn decode(picture: &Picture) -> Vec<Option<u32>> {
    let pixels = picture.mapped.as_rgba8().unwrap().pixels();
    pixels
        .map(|p| match p.0 {
            [r, g, b, 255] => Some(u32::from(r) << 16 | u32::from(g) << 8 | u32::from(b)),
            [0, 0, 0, 0] => None,
            other => panic!("{other:?} is neither a patch nor nothing"),
        })
        .collect()
}

/// Shares of a view's solid angle: fronts, backs, nothing.
fn shares(scene: &Scene, picture: &Picture, cull: Cull) -> [f64; 3] {
    let mut probe = Probe::new(&Arc::new(Drawable::new(scene)));
    let window = picture.camera.window(picture.view, 1);
    let mut shares = [0.0; 3];
    let mut probe = probe.at(picture.camera.eye, cull, window.pixel_count());
    probe.look(&window, |ray| {
        shares[match ray.sample {
            Sample::Front { .. } => 0,
            Sample::BackFace(_) => 1,
            Sample::Nothing => 2,
        }] += ray.solid_angle;
    });
    let total: f64 = shares.iter().sum();
    shares.map(|share| share / total)
}

#[test]
fn camera_rays_hit_the_patch_that_a_ray_through_the_cube_meets() {
    let scene = closed_cube(7);
    let settings = RenderSettings {
        eye: Some(DVec3::new(-0.5, 0.2, 0.7)),
        look_at: Some(DVec3::new(0.3, -0.1, -0.4)),
        fov_degrees: Some(70.0),
        ..ids_settings()
    };
    let picture = render(&scene, None, &settings).unwrap();
    let camera = picture.camera;
    let window = camera.window(SIZE, 1);
    for (pixel, id) in decode(&picture).into_iter().enumerate() {
        let (i, j) = (pixel % 80, 59 - pixel / 80);
        let direction = camera.forward
            + (window.left + (i as f64 + 0.5) * window.pixel) * camera.right
            + (window.bottom + (j as f64 + 0.5) * window.pixel) * camera.up;
        // From inside the cube |x|, |y|, |z| < 1 a ray leaves by the nearest of the planes ahead.
        let to_planes = (direction.signum() - camera.eye) / direction;
        let hit = camera.eye + to_planes.min_element() * direction;
        let patch = scene.patch(scene::PatchId(id.unwrap()));
        let [p0, p1, p2] = patch.corners.map(Vec3::as_dvec3);
        let normal = (p1 - p0).cross(p2 - p0);
        for (p, q) in [(p0, p1), (p1, p2), (p2, p0)] {
            // f32 rounding of barycentric coordinates, over 2^3 halvings on the way down.
            let side = (q - p).cross(hit - p).dot(normal) / normal.length_squared();
            assert!(
                side > -1e-5,
                "pixel {pixel}: {hit} is {side} outside of patch {id:?}"
            );
        }
        assert!((hit - p0).dot(normal.normalize()).abs() < 1e-6);
    }
}

#[test]
fn centroids_appear_where_the_camera_projects_them() {
    let scene = closed_cube(5);
    let settings = RenderSettings {
        eye: Some(DVec3::new(-0.9, -0.3, 0.8)),
        look_at: Some(DVec3::ZERO),
        ..ids_settings()
    };
    let size = Size {
        width: 640,
        height: 480,
    };
    let picture = render(
        &scene,
        None,
        &RenderSettings {
            size: Some(size),
            ..settings
        },
    )
    .unwrap();
    let seen = decode(&picture);
    let mut found = 0;
    for patch in 0..scene.patch_count() {
        let centroid = scene.patch(scene::PatchId(patch)).centroid();
        if let Some([x, y]) = picture.camera.project(centroid, size)
            && (0.0..640.0).contains(&x)
            && (0.0..480.0).contains(&y)
        {
            assert_eq!(seen[y as usize * 640 + x as usize], Some(patch));
            found += 1;
        }
    }
    assert!(found > 50, "only {found} centroids in the picture");
}

#[test]
fn eye_is_in_the_models_own_coordinates() {
    let origin = DVec3::new(1e6, -2e6, 500.0);
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    builder.room(Vec3::NEG_ONE, Vec3::ONE, &[], material, 5);
    let moved = builder.scene_at(origin);
    let (eye, look_at) = (DVec3::new(-0.5, 0.2, 0.7), DVec3::new(0.3, -0.1, -0.4));
    let at = |offset: DVec3| RenderSettings {
        eye: Some(eye + offset),
        look_at: Some(look_at + offset),
        ..ids_settings()
    };
    let expected = render(&closed_cube(5), None, &at(DVec3::ZERO)).unwrap();
    let picture = render(&moved, None, &at(origin)).unwrap();
    // f64 coordinates about 1e6 have steps of 1e-10: no pixel of 1e-2 notices.
    assert_eq!(decode(&picture), decode(&expected));
}

#[test]
fn default_camera_of_a_closed_box_is_inside_and_sees_fronts_only() {
    for extent in [
        Vec3::ONE,
        Vec3::new(5.0, 5.0, 2.0),
        Vec3::new(1.0, 0.4, 12.0),
    ] {
        let mut builder = Builder::default();
        let material = builder.material(0.5, 0.0);
        builder.room(-extent, extent, &[], material, 3);
        let scene = builder.scene();
        let picture = render(&scene, None, &ids_settings()).unwrap();
        assert!(
            picture.camera.eye.abs().cmplt(extent.as_dvec3()).all(),
            "{extent}"
        );
        assert_eq!(shares(&scene, &picture, Cull::Nothing)[1..], [0.0, 0.0]);
    }
}

#[test]
fn default_camera_of_a_box_with_a_missing_side_looks_in_through_it() {
    for side in 0..6 {
        let mut builder = Builder::default();
        let material = builder.material(0.5, 0.0);
        builder.room(Vec3::NEG_ONE, Vec3::ONE, &[side], material, 3);
        let scene = builder.scene();
        let picture = render(
            &scene,
            None,
            &RenderSettings {
                size: None,
                ..ids_settings()
            },
        )
        .unwrap();
        let mut outward = DVec3::AXES[side / 2];
        if side % 2 == 0 {
            outward = -outward;
        }
        assert!(picture.camera.eye.dot(outward) > 1.0, "side {side}");
        let [fronts, backs, nothing] = shares(&scene, &picture, Cull::Nothing);
        assert!(
            backs == 0.0 && fronts > 0.9,
            "side {side}: {fronts} {backs} {nothing}"
        );
    }
}

#[test]
fn default_camera_does_not_stand_in_a_column() {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    builder.room(Vec3::ZERO, Vec3::new(10.0, 3.0, 6.0), &[], material, 2);
    // Columns wherever a corner would tempt.
    for (x, z) in [(0.2, 0.2), (9.0, 0.2), (0.2, 5.0), (9.0, 5.0), (4.5, 2.5)] {
        builder.block(
            Vec3::new(x, 0.0, z),
            Vec3::new(x + 0.8, 3.0, z + 0.8),
            material,
            2,
        );
    }
    let scene = builder.scene();
    let picture = render(&scene, None, &ids_settings()).unwrap();
    assert!(shares(&scene, &picture, Cull::Nothing)[1] <= 0.0);
}

#[test]
fn default_camera_of_a_solid_is_outside_and_holds_all_of_it() {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    builder.block(Vec3::NEG_ONE, Vec3::new(1.0, 0.5, 3.0), material, 3);
    let scene = builder.scene();
    let picture = render(&scene, None, &ids_settings()).unwrap();
    let [fronts, backs, _] = shares(&scene, &picture, Cull::Nothing);
    assert!(fronts > 0.1 && backs == 0.0);
    for patch in 0..scene.patch_count() {
        for corner in scene.patch(scene::PatchId(patch)).corners {
            let [x, y] = picture.camera.project(corner.as_dvec3(), SIZE).unwrap();
            assert!((0.0..80.0).contains(&x) && (0.0..60.0).contains(&y));
        }
    }
}

/// The margin is a fiftieth of the picture, and pixels are a sixtieth of it.
#[test]
fn default_camera_of_a_solid_is_filled_by_it() {
    for far in [
        Vec3::new(1.0, 0.5, 3.0),
        Vec3::new(9.0, -0.9, -0.9),
        Vec3::new(-0.8, 6.0, -0.8),
    ] {
        let mut builder = Builder::default();
        let material = builder.material(0.5, 0.0);
        builder.block(Vec3::NEG_ONE, far, material, 0);
        let scene = builder.scene();
        let picture = render(&scene, None, &ids_settings()).unwrap();
        let seen = decode(&picture);
        let (mut columns, mut rows) = (Vec::new(), Vec::new());
        for (k, _) in seen.iter().enumerate().filter(|(_, seen)| seen.is_some()) {
            columns.push(k % SIZE.width as usize);
            rows.push(k / SIZE.width as usize);
        }
        let beside = |places: Vec<usize>, side: u32| {
            let (low, high) = (places.iter().min().unwrap(), places.iter().max().unwrap());
            [*low, side as usize - 1 - high]
        };
        let beside = [beside(columns, SIZE.width), beside(rows, SIZE.height)];
        let is_filled = |beside: &[usize; 2]| beside.iter().all(|&pixels| pixels <= 1);
        assert!(beside.iter().any(is_filled), "{far}: {beside:?}");
    }
}

/// A room with so much open that it counts as no room: from outside one would see the backs of its walls.
#[test]
fn default_camera_of_a_ruin_is_not_behind_a_wall() {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    // Without a ceiling and two walls that are not opposite.
    builder.room(Vec3::NEG_ONE, Vec3::ONE, &[1, 3, 5], material, 3);
    let scene = builder.scene();
    let picture = render(&scene, None, &ids_settings()).unwrap();
    let [fronts, backs, _] = shares(&scene, &picture, Cull::Nothing);
    assert!(fronts > 10.0 * backs, "{fronts} {backs}");
}

#[test]
fn culling_backs_lets_one_look_into_a_closed_box_from_outside() {
    let scene = closed_cube(4);
    let eye = Some(DVec3::new(0.3, 0.4, 5.0));
    let closed = render(
        &scene,
        None,
        &RenderSettings {
            eye,
            ..ids_settings()
        },
    )
    .unwrap();
    assert!(
        decode(&closed).iter().all(Option::is_none),
        "backs are opaque and no patches"
    );
    let settings = RenderSettings {
        eye,
        cull_back_faces: true,
        ..ids_settings()
    };
    let open = render(&scene, None, &settings).unwrap();
    let seen = decode(&open)[30 * 80 + 40].unwrap();
    let normal = scene
        .surface(scene.mesh().surface_of(scene::PatchId(seen)))
        .normal();
    assert!(
        normal.distance(DVec3::Z) < 1e-6,
        "the far wall is in the middle"
    );

    // Nobody who asks for this wants to stand inside.
    let unplaced = render(
        &scene,
        None,
        &RenderSettings {
            eye: None,
            ..settings
        },
    )
    .unwrap();
    assert!(unplaced.camera.eye.abs().max_element() > 1.0);
    assert!(shares(&scene, &unplaced, Cull::BackFaces)[0] > 0.1);
}

#[test]
fn a_scene_of_one_triangle_can_be_seen() {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 1.0);
    builder.quad(
        [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
        material,
        0,
    );
    builder.surfaces.truncate(1);
    builder.depths.truncate(1);
    let scene = builder.scene();
    let picture = render(&scene, None, &ids_settings()).unwrap();
    assert!(decode(&picture).contains(&Some(0)));
}

#[test]
fn up_is_where_rooms_are_low_and_lamps_hang() {
    let room = |extent: Vec3, lamp: Option<usize>| {
        let mut builder = Builder::default();
        let wall = builder.material(0.5, 0.0);
        let shining = builder.material(0.5, 1.0);
        builder.room(
            -extent,
            extent,
            &lamp.map_or(vec![], |side| vec![side]),
            wall,
            0,
        );
        if let Some(side) = lamp {
            let others: Vec<usize> = (0..6).filter(|&other| other != side).collect();
            builder.room(-extent, extent, &others, shining, 0);
        }
        up::guess(&builder.scene())
    };
    assert_eq!(room(Vec3::new(5.0, 5.0, 2.0), None), Axis::Z);
    assert_eq!(room(Vec3::new(5.0, 2.0, 5.0), None), Axis::Y);
    assert_eq!(room(Vec3::ONE, Some(5)), Axis::Z);
    assert_eq!(room(Vec3::ONE, Some(3)), Axis::Y);
    assert_eq!(
        room(Vec3::new(5.0, 5.0, 2.0), Some(0)),
        Axis::Z,
        "a window is no ceiling lamp"
    );
    assert_eq!(room(Vec3::ONE, None), Axis::Y);
}

#[test]
fn item_buffer_of_a_camera_does_not_depend_on_the_threads() {
    let scene = closed_cube(6);
    let settings = RenderSettings {
        eye: Some(DVec3::new(0.1, 0.2, 0.3)),
        ..ids_settings()
    };
    let camera = render(&scene, None, &settings).unwrap().camera;
    let size = Size {
        width: 333,
        height: 222,
    };
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| shade::ids(&scene, &camera, size, Cull::Nothing))
    };
    assert!(with(1) == with(3));
}
