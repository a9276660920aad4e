//! Models of any size, anywhere, and with things far away.

use std::fmt::Write;

use compute::rows::UNITS_PER_ONE;
use glam::{DVec3, Vec3};
use scene::{Scene, Solution, Surface};

use super::all_rows;
use crate::common::methods::{
    METHODS, Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, iterate, largest_reflectance, radiosity,
    relative_difference, rows, solver,
};
use crate::common::{self, bits, block, folder, material, quad, shaken};

/// The closed, furnished and coloured room, no edge of which a ray meets exactly, with all lengths times a
/// factor.
fn room(factor: f32) -> Scene {
    let room = common::colourful_room(0.8);
    let mut surfaces = shaken(room.surfaces().to_vec());
    for surface in &mut surfaces {
        surface.corners = surface.corners.map(|p| factor * p);
    }
    let area = 0.8 * f64::from(factor).powi(2);
    common::scene(room.materials().to_vec(), surfaces, area)
}

fn solved(method: Method, scene: &Scene) -> Solution {
    let mut rows = rows(scene, u64::MAX);
    let mut solver = solver(method, scene, Solution::dark(scene));
    iterate(solver.as_mut(), &mut rows, 20);
    solver.snapshot()
}

/// Only ratios of lengths matter, and a power of two changes no digit of a coordinate: every form factor
/// and every radiosity is the same to the bit, from a picometre to a thousand million kilometres.
#[test]
fn sizes_by_a_power_of_two_give_the_same_bits() {
    let one = room(1.0);
    let rows = all_rows(&one, 32);
    for exponent in [-40, -20, 20, 40] {
        let scaled = room(2.0_f32.powi(exponent));
        assert_eq!(all_rows(&scaled, 32), rows, "2^{exponent}");
        for method in METHODS {
            let (a, b) = (solved(method, &one), solved(method, &scaled));
            assert_eq!(
                bits(&a.irradiance),
                bits(&b.irradiance),
                "{method:?} 2^{exponent}"
            );
        }
    }
}

/// 1e-6 and 1e6 round every coordinate anew, by 2^-24 of it: seen from a centroid 1/4 of the coordinate
/// away edges move by 4 2^-24 on a face, where pixels are 2/32 wide. So of the pixels on edges one in
/// (1/16) / (4 2^-24) = 260,000 sees the neighbour. A row has 3 32^2 pixels, all of them on edges at
/// most, and there are some 200 rows: two or three in all are expected, six in one row never. One pixel
/// is at most d = (2/32)^2 / pi of a form factor; it is taken from one patch and given to another.
///
/// So no row's sum of differences exceeds 12 d, and the radiosities, B = E + rho F B, differ by at most
/// rho 12 d / 2 of the largest, times 1 / (1 - rho), beside f32's own roundings.
#[test]
fn sizes_by_a_million_give_the_same_radiosities() {
    let one = room(1.0);
    let rows = all_rows(&one, 32);
    let count = one.patch_count() as usize;
    let units_per_one = f64::from(UNITS_PER_ONE);
    let pixel = (2.0_f64 / 32.0).powi(2) / std::f64::consts::PI;
    for factor in [1e-6, 1e6] {
        let scaled = room(factor);
        assert_eq!(scaled.patch_count(), one.patch_count(), "{factor}");
        let scaled_rows = all_rows(&scaled, 32);
        let mut differing = 0;
        for k in 0..count {
            let mut dense = vec![0.0; count];
            for entry in rows.row(k) {
                dense[entry.source as usize] += f64::from(entry.units) / units_per_one;
            }
            for entry in scaled_rows.row(k) {
                dense[entry.source as usize] -= f64::from(entry.units) / units_per_one;
            }
            let difference: f64 = dense.iter().map(|d| d.abs()).sum();
            differing += usize::from(difference > 0.0);
            assert!(difference <= 12.0 * pixel, "{factor}: row {k} {difference}");
        }
        // Of two or three expected, so many by chance once in a million times.
        assert!(differing <= 14, "{factor}: {differing} rows");
        let rho = largest_reflectance(&one);
        for method in [Method::Jacobi, Method::GaussSeidel] {
            let a = radiosity(&one, &solved(method, &one));
            let b = radiosity(&scaled, &solved(method, &scaled));
            let error = relative_difference(method, &one, &b, &a);
            let rounding = 2.0 * ROUNDINGS_PER_RADIOSITY * ROUNDING;
            let bound = (rho * 6.0 * pixel + rounding) / (1.0 - rho);
            assert!(error <= bound, "{method:?} {factor}: {error:e} > {bound:e}");
        }
    }
}

/// A Wavefront file of the furnished room, all of its coordinates moved.
fn obj(offset: DVec3) -> String {
    let mut text = String::from("o room\n");
    let mut count = 0;
    for surface in common::furnished_room_surfaces() {
        for corner in surface.corners {
            // To 1/8 m: exact in f32 at the origin and in f64 1e7 m away.
            let p = (8.0 * corner.as_dvec3()).round() / 8.0 + offset;
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
            count += 1;
        }
        writeln!(text, "f {} {} {}", count - 2, count - 1, count).unwrap();
    }
    text
}

fn imported(offset: DVec3) -> Scene {
    let folder = folder();
    let path = folder.path().join("room.obj");
    std::fs::write(&path, obj(offset)).unwrap();
    let model = scene::obj::load(&path).unwrap();
    let scene = Scene::with_max_area(
        model.materials,
        model.objects,
        model.surfaces,
        0.5,
        model.origin,
    );
    // Through a file, as a user's would go.
    let file = common::save(folder.path(), "room.rad", &scene.unwrap());
    scene::file::load(&file).unwrap().0
}

/// Coordinates are f64 until they are moved near the origin, by a multiple of a power of two above the
/// model's extent: 8 m here, which divides 1e7. All that follows has the same bits, and the offset is
/// kept. In f32 a coordinate of 1e7 would be rounded to whole metres.
#[test]
fn a_model_1e7_away_gives_the_same_bits_and_keeps_its_offset() {
    let near = imported(DVec3::ZERO);
    let offset = DVec3::new(1e7, -1e7, 3e7);
    let far = imported(offset);
    assert_eq!(far.origin() - near.origin(), offset);
    assert_eq!(far.surfaces(), near.surfaces());
    assert_eq!(all_rows(&far, 32), all_rows(&near, 32));
}

/// What stands outside a closed room, however far away, changes not a bit of what is inside: the room's
/// walls hide it. (Distances of some thousands of rooms once hid walls from those beside them.)
#[test]
fn geometry_far_outside_a_closed_room_changes_no_bit_inside() {
    let surfaces = shaken(common::furnished_room_surfaces());
    let materials = vec![material(0.5, 0.0), material(0.3, 2.0)];
    let alone = common::scene(materials.clone(), surfaces.clone(), 0.5);
    let expected = all_rows(&alone, 32);
    for distance in [1e2, 1e3, 1e4, 1e5, 1e6, 1e7] {
        let mut surfaces = surfaces.clone();
        // A closed box of a tenth of the distance, all but its own size away; as one patch a side it
        // keeps the numbers of the room's patches.
        let (low, high) = (Vec3::splat(distance), Vec3::splat(1.1 * distance));
        surfaces.extend(block(low, high, true, 0));
        let depths: Vec<u32> = alone
            .mesh()
            .trees()
            .iter()
            .map(|tree| tree.depth)
            .chain([0; 12])
            .collect();
        let objects = vec!["all".to_owned()];
        let scene = Scene::new(materials.clone(), objects, surfaces, &depths, DVec3::ZERO).unwrap();
        let rows = all_rows(&scene, 32);
        let count = alone.patch_count() as usize;
        let differing = (0..count)
            .filter(|&k| rows.row(k) != expected.row(k) || rows.unseen(k) != expected.unseen(k))
            .count();
        assert_eq!(differing, 0, "of {count} rows, {distance} m");
    }
}

/// A box on a plane 1e7 m wide: from its side the plane fills all below the horizon, the sky all above it.
/// The hemicube's pixels are symmetric about its axis, which lies in the horizon: half of them look down,
/// none along it, and no row of them has more than a unit too many. The plane's end is 1e-7 below the
/// horizon, far from any pixel's centre.
#[test]
fn an_endless_floor_fills_half_of_what_a_wall_sees() {
    let far = 5e6;
    let floor = quad(
        [
            Vec3::new(-far, -far, 0.0),
            Vec3::new(far, -far, 0.0),
            Vec3::new(far, far, 0.0),
            Vec3::new(-far, far, 0.0),
        ],
        0,
    );
    let mut surfaces: Vec<Surface> = floor.to_vec();
    surfaces.extend(block(Vec3::ZERO, Vec3::ONE, true, 0));
    let scene = common::scene(vec![material(0.5, 1.0)], surfaces, f64::INFINITY);
    let resolution = 64;
    let rows = all_rows(&scene, resolution);
    let units_per_one = f64::from(UNITS_PER_ONE);
    // Two units for each run of pixels in the faces' 3 R rows.
    let rounding = 2.0 * 3.0 * f64::from(resolution) / units_per_one;
    for patch in (0..scene.patch_count()).map(scene::PatchId) {
        let surface = scene.surface(scene.mesh().surface_of(patch));
        if patch.0 < 2 || surface.normal().z.abs() > 0.5 {
            continue;
        }
        let row = rows.row(patch.0 as usize);
        let floor: f64 = row.iter().map(|e| f64::from(e.units)).sum::<f64>() / units_per_one;
        assert!((floor - 0.5).abs() <= rounding, "{patch:?}: {floor}");
    }
}
