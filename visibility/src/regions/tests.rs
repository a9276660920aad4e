//! Laws of regions.

mod shapes;

use glam::{DQuat, DVec2, DVec3, Vec3};
use proptest::prelude::*;
use scene::Scene;

use super::*;
use shapes::{grid, moved, odd_turn, refined, scene};

/// Difference of areas, relative: that of the pieces in the plane they are measured in, and as much again for
/// members that are not quite in it.
const AREA: f64 = 2.0 * pieces::AREA_TOLERANCE;

/// Rounding of unit vectors, which are products and roots of f64.
const DIRECTION: f64 = 1e-12;

/// Share of a region's size within which of an edge a point may be given to either side: see `locator.rs`, which
/// derives 9.6e-7 diagonals, and `partition.rs`, which adds 1e-6, a diagonal being at most sqrt 2 sizes.
const NEAR_EDGE: f64 = 1e-5;

fn area(corners: &[DVec3]) -> f64 {
    (2..corners.len())
        .map(|k| (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]))
        .sum::<DVec3>()
        .length()
        / 2.0
}

/// Least distance of a point inside from the sides, below 0 outside, in the plane.
fn inside(corners: &[DVec3], normal: DVec3, p: DVec3) -> f64 {
    (0..corners.len())
        .map(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            normal.cross(b - a).normalize().dot(p - a)
        })
        .fold(f64::INFINITY, f64::min)
}

fn piece_corners(regions: &Regions, piece: usize) -> Vec<DVec3> {
    let vertex = |&v: &u32| regions.vertices()[v as usize].as_dvec3();
    regions.corners(piece).iter().map(vertex).collect()
}

/// All that must hold for any scene.
fn check(scene: &Scene, regions: &Regions, samples: u32) {
    assert!(regions.pieces().len() <= scene.surfaces().len());
    let mut seen = vec![0; scene.surfaces().len()];
    for (index, region) in (0..).zip(regions.regions()) {
        for surface in &region.surfaces {
            seen[surface.index()] += 1;
            assert_eq!(regions.region_of(*surface), index);
        }
        assert!(region.surfaces.is_sorted());
        let [o, p, q] = region.reference;
        let front = (p - o).cross(q - o).normalize();
        assert!(
            front.dot(region.normal) > 1.0 - DIRECTION,
            "{front} {}",
            region.normal
        );
        let pieces: Vec<Vec<DVec3>> = region
            .pieces
            .clone()
            .map(|piece| {
                assert_eq!(regions.pieces()[piece as usize].region, index);
                piece_corners(regions, piece as usize)
            })
            .collect();
        let members: Vec<Vec<DVec3>> = region
            .surfaces
            .iter()
            .map(|&s| scene.surface(s).corners.map(Vec3::as_dvec3).to_vec())
            .collect();
        assert!(pieces.len() <= members.len());
        let sum = |polygons: &[Vec<DVec3>]| polygons.iter().map(|p| area(p)).sum::<f64>();
        let difference = (sum(&pieces) - sum(&members)).abs();
        assert!(difference <= AREA * sum(&members), "{difference}");
        for piece in &pieces {
            for k in 0..piece.len() {
                let [a, b, c] = [0, 1, 2].map(|n| piece[(k + n) % piece.len()]);
                assert!((b - a).cross(c - b).dot(region.normal) > 0.0, "{piece:?}");
            }
        }
        if let Some(locator) = &region.locator {
            check_points(region, locator, &pieces, &members, samples);
        } else {
            assert_eq!(region.surfaces.len(), 1);
        }
    }
    assert!(seen.iter().all(|&count| count == 1));
}

fn check_points(
    region: &Region,
    locator: &Locator,
    pieces: &[Vec<DVec3>],
    members: &[Vec<DVec3>],
    samples: u32,
) {
    let [o, p, q] = region.reference;
    let size = o.distance(p).max(o.distance(q)) / 2.0;
    let near = NEAR_EDGE * size;
    for (member, &surface) in locator.members().iter().zip(&region.surfaces) {
        assert_eq!(member.surface, surface);
    }
    for k in 0..samples {
        // The additive sequence of the plastic number (Roberts 2018) fills the box evenly.
        let x = (0.5 + f64::from(k) * 0.754_877_666_246_693).fract() / 2.0;
        let y = (0.5 + f64::from(k) * 0.569_840_290_998_053).fract() / 2.0;
        let point = o + x * (p - o) + y * (q - o);
        let holders = |polygons: &[Vec<DVec3>]| -> Option<Vec<usize>> {
            let depths: Vec<f64> = polygons
                .iter()
                .map(|polygon| inside(polygon, region.normal, point))
                .collect();
            depths
                .iter()
                .all(|depth| depth.abs() > near)
                .then(|| (0..depths.len()).filter(|&k| depths[k] > 0.0).collect())
        };
        let scale = 0.1 + 7.0 * f64::from(k % 10);
        let coordinates = [1.0 - x - y, x, y].map(|value| (scale * value) as f32);
        let found = locator.locate(coordinates);
        let Some(held) = holders(members) else {
            continue;
        };
        assert!(held.len() <= 1);
        if let [only] = held[..] {
            assert_eq!(found, only);
            let sum: f32 = coordinates.iter().sum();
            let rows = locator.members()[found].barycentric;
            let [u, v, w] = rows.map(|row| {
                (0..3)
                    .map(|j| row[j] * f64::from(coordinates[j]))
                    .sum::<f64>()
                    / f64::from(sum)
            });
            // Errors of distances from the sides, as they come out in a needle.
            let corners = &members[only];
            let longest = (0..3)
                .map(|k| corners[k].distance(corners[(k + 1) % 3]))
                .fold(0.0, f64::max);
            let tolerance = near * (1.0 + longest * longest / area(corners));
            let sides = [corners[1] - corners[0], corners[2] - corners[0]];
            let again = corners[0] + v * sides[0] + w * sides[1];
            assert!(again.distance(point) <= tolerance, "{again} {point}");
            assert!((u + v + w - 1.0).abs() * longest <= 2.0 * tolerance);
        }
        if let Some(pieces) = holders(pieces) {
            assert_eq!(pieces.len(), held.len());
        }
    }
}

fn checked(triangles: Vec<[DVec3; 3]>) -> Regions {
    let scene = scene(triangles);
    let regions = Regions::new(&scene);
    check(&scene, &regions, 2000);
    regions
}

#[test]
fn a_wall_of_800_triangles_is_one_rectangle() {
    for (turn, by) in [
        (DQuat::IDENTITY, DVec3::ZERO),
        (odd_turn(), DVec3::new(3.0, -2.0, 0.5)),
    ] {
        let regions = checked(moved(grid(20, 20, |_, _| true), turn, by));
        assert_eq!(regions.regions().len(), 1);
        assert_eq!(regions.pieces().len(), 1);
        assert_eq!(regions.corners(0).len(), 4);
    }
}

#[test]
fn an_l_is_two_pieces() {
    let l = grid(8, 8, |i, j| i < 3 || j < 4);
    for turn in [DQuat::IDENTITY, odd_turn()] {
        let regions = checked(moved(l.clone(), turn, DVec3::splat(1.3)));
        assert_eq!(regions.regions().len(), 1);
        assert_eq!(regions.pieces().len(), 2);
    }
}

#[test]
fn a_wall_with_windows_is_few_pieces() {
    let wall = grid(16, 9, |i, j| !(i % 4 == 2 && (j % 5 == 2 || j % 5 == 3)));
    for turn in [DQuat::IDENTITY, odd_turn()] {
        let regions = checked(moved(wall.clone(), turn, DVec3::splat(-0.7)));
        assert_eq!(regions.regions().len(), 1);
        // Eight holes, each with four reflex corners: at most 4 (32 + 1) pieces, by Hertel and Mehlhorn's bound
        // of which a third is usual.
        assert!(regions.pieces().len() <= 40, "{}", regions.pieces().len());
    }
}

#[test]
fn holes_that_touch_in_a_corner_are_kept() {
    let wall = grid(7, 7, |i, j| !((i, j) == (2, 2) || (i, j) == (3, 3)));
    let regions = checked(moved(wall, odd_turn(), DVec3::ZERO));
    assert_eq!(regions.regions().len(), 1);
    assert!(regions.pieces().len() <= 12);
}

#[test]
fn both_sides_of_a_wall_are_two_regions() {
    let mut wall = grid(5, 5, |_, _| true);
    let back: Vec<[DVec3; 3]> = wall.iter().map(|&[a, b, c]| [a, c, b]).collect();
    wall.extend(back);
    let regions = checked(moved(wall, odd_turn(), DVec3::X));
    assert_eq!(regions.regions().len(), 2);
    assert_eq!(regions.pieces().len(), 2);
}

#[test]
fn repeated_triangles_are_drawn_one_by_one() {
    let mut wall = grid(3, 3, |_, _| true);
    wall.push(wall[4]);
    let scene = scene(wall);
    let regions = Regions::new(&scene);
    assert_eq!(regions.regions().len(), scene.surfaces().len());
    assert_eq!(regions.pieces().len(), scene.surfaces().len());
}

/// A flat ring that winds round one and a half times, over itself.
#[test]
fn surfaces_that_overlap_are_drawn_one_by_one() {
    let at = |k: u32, radius: f64| {
        let angle = f64::from(k) * 0.37;
        DVec3::new(angle.cos() * radius, angle.sin() * radius, 0.0)
    };
    let ring: Vec<[DVec3; 3]> = (0..25)
        .flat_map(|k| {
            let [a, b, c, d] = [at(k, 1.0), at(k, 2.0), at(k + 1, 2.0), at(k + 1, 1.0)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let regions = Regions::new(&scene(ring.clone()));
    assert_eq!(regions.regions().len(), ring.len());
    let regions = checked(ring[..30].to_vec());
    assert_eq!(regions.regions().len(), 1);
}

#[test]
fn facets_of_a_cylinder_stay_apart() {
    for count in [12_u32, 96, 1000] {
        let angle = std::f64::consts::TAU / f64::from(count);
        let at = |k: u32, z: f64| {
            let (sin, cos) = (angle * f64::from(k % count)).sin_cos();
            DVec3::new(cos, sin, z)
        };
        let triangles: Vec<[DVec3; 3]> = (0..count)
            .flat_map(|k| {
                let [a, b, c, d] = [at(k, 0.0), at(k + 1, 0.0), at(k + 1, 1.0), at(k, 1.0)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        let regions = checked(moved(triangles, odd_turn(), DVec3::ZERO));
        assert_eq!(regions.regions().len(), count as usize);
    }
}

/// Quadrilaterals between circles of latitude are planar: two triangles of one region, never more.
#[test]
fn facets_of_a_sphere_stay_apart() {
    let at = |i: u32, j: u32| {
        let (sin, cos) = (std::f64::consts::PI * f64::from(j) / 40.0).sin_cos();
        let (y, x) = (std::f64::consts::TAU * f64::from(i % 80) / 80.0).sin_cos();
        DVec3::new(sin * x, sin * y, cos)
    };
    let mut triangles = Vec::new();
    for (i, j) in (0..80).flat_map(|i| (1..39).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    let scene = scene(moved(triangles, odd_turn(), DVec3::ZERO));
    let regions = Regions::new(&scene);
    check(&scene, &regions, 20);
    assert!(regions.regions().iter().all(|r| r.surfaces.len() <= 2));
}

#[test]
fn points_far_outside_and_numbers_that_are_none_get_some_member() {
    let regions = checked(grid(4, 6, |i, j| i != 1 || j > 3));
    let locator = regions.regions()[0].locator.as_ref().unwrap();
    for a in [f32::NAN, -1e30, -1.0, 0.0, 1.0, f32::INFINITY] {
        for b in [f32::NAN, -3.0, 0.0, 1e-30, f32::MAX] {
            assert!(locator.locate([a, b, 1.0]) < locator.members().len());
            assert!(locator.locate([1.0, a, b]) < locator.members().len());
        }
    }
}

#[test]
fn a_fan_of_thousands_of_needles_is_merged() {
    let at = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k % 3000) / 3000.0).sin_cos();
        DVec3::new(cos, sin, 0.0)
    };
    let fan: Vec<_> = (0..3000).map(|k| [DVec3::ZERO, at(k), at(k + 1)]).collect();
    let scene = scene(fan);
    let regions = Regions::new(&scene);
    check(&scene, &regions, 50);
    assert_eq!(regions.regions().len(), 1);
    assert!(regions.pieces().len() <= 4);
}

#[test]
fn models_are_made_of_few_pieces() {
    use genx::{Model, Settings};
    let models = [
        Model::Cornell,
        Model::Cube,
        Model::Hall,
        Model::Bend,
        Model::Furnace,
    ];
    for model in models {
        let scene = genx::make(&Settings::new(model.clone())).unwrap().scene;
        let regions = Regions::new(&scene);
        check(&scene, &regions, 20);
        let counts = [
            scene.surfaces().len(),
            regions.regions().len(),
            regions.pieces().len(),
        ];
        assert!(2 * counts[1] <= counts[0], "{model:?}: {counts:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn random_triangulations_of_a_rectangle_are_one_rectangle(
        picks in prop::collection::vec((0_usize..1000, 0.3..0.7), 0..120),
        axis in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
        angle in 0.0..6.3,
        by in (-5.0..5.0, -5.0..5.0, -5.0..5.0),
    ) {
        let axis = DVec3::from(axis).try_normalize().unwrap_or(DVec3::X);
        let turn = DQuat::from_axis_angle(axis, angle);
        let (w, h) = (3.0, 2.0);
        let [a, b, c, d] = [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)]
            .map(|p| DVec2::from(p).extend(0.0));
        let triangles = refined(vec![[a, b, c], [a, c, d]], &picks);
        let regions = checked(moved(triangles, turn, by.into()));
        prop_assert_eq!(regions.regions().len(), 1);
        prop_assert_eq!(regions.pieces().len(), 1);
        prop_assert_eq!(regions.corners(0).len(), 4);
    }

    #[test]
    fn random_holes_are_kept(
        holes in prop::collection::vec((0_u32..10, 0_u32..8), 0..30),
        angle in 0.0..6.3,
    ) {
        let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), angle);
        let wall = grid(10, 8, |i, j| !holes.contains(&(i, j)));
        checked(moved(wall, turn, DVec3::new(0.1, 7.0, -2.0)));
    }

    #[test]
    fn any_triangles_make_regions(
        corners in prop::collection::vec((0_i32..4, 0_i32..4, 0_i32..2), 3..90),
    ) {
        let triangles: Vec<[DVec3; 3]> = corners
            .chunks_exact(3)
            .map(|c| [0, 1, 2].map(|k| DVec3::new(c[k].0.into(), c[k].1.into(), c[k].2.into())))
            .filter(|[a, b, c]| (b - a).cross(c - a).length() > 0.0)
            .collect();
        // A scene has at least one surface.
        prop_assume!(!triangles.is_empty());
        checked(triangles);
    }
}
