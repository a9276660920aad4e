//! Laws of planes that are put in order: nothing overlaps, nothing is lost, and the order of the file decides nothing.

use genx::cut::{Cut, Model, put_in_order};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use scene::weld::{Place, places};
use scene::{Material, MaterialId, ObjectId, Rgb, Surface};

/// A rectangle of the plane z = 0: from, to.
type Rectangle = [[f64; 2]; 2];

fn area([[x0, y0], [x1, y1]]: Rectangle) -> f64 {
    (x1 - x0) * (y1 - y0)
}

/// A plane with things in it, one object each; `emitting` ones are lamps.
#[derive(Clone, Debug)]
struct Plane {
    rectangles: Vec<Rectangle>,
    emitting: Vec<bool>,
    /// Those that face the other way: all but these face up.
    turned: Vec<bool>,
    /// From the plane z = 0 to where it is.
    turn: DQuat,
    shift: DVec3,
}

struct Cutted {
    surfaces: Vec<Surface>,
    faces: Vec<u32>,
    told: Vec<String>,
}

impl Plane {
    /// Cut, the faces in this order.
    fn cut(&self, order: &[usize]) -> Cutted {
        let material = |emission: f32| Material {
            name: "m".into(),
            reflectance: Rgb::splat(0.5),
            emission: Rgb::splat(emission),
        };
        let materials = [material(0.0), material(1.0)];
        let objects: Vec<String> = (0..self.rectangles.len()).map(|k| k.to_string()).collect();
        let (mut surfaces, mut faces) = (Vec::new(), Vec::new());
        for &k in order {
            let [[x0, y0], [x1, y1]] = self.rectangles[k];
            let at = |x: f64, y: f64| (self.turn * DVec3::new(x, y, 0.0) + self.shift).as_vec3();
            let [a, b, c, d] = [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)];
            for mut corners in [[a, b, c], [a, c, d]] {
                if self.turned[k] {
                    corners.reverse();
                }
                faces.push(surfaces.len() as u32);
                surfaces.push(Surface {
                    corners,
                    material: MaterialId(u32::from(self.emitting[k])),
                    object: ObjectId(k as u32),
                });
            }
        }
        let model = Model {
            surfaces: &mut surfaces,
            faces: &mut faces,
            materials: &materials,
            objects: &objects,
            opening: None,
        };
        let told = put_in_order(model, Cut::On).unwrap();
        Cutted {
            surfaces,
            faces,
            told,
        }
    }

    /// What is seen of each rectangle, m^2: cells between all borders belong to the one of each side that stays there.
    fn visible(&self) -> Vec<f64> {
        let borders = |axis: usize| {
            let mut borders: Vec<f64> = self
                .rectangles
                .iter()
                .flat_map(|r| [r[0][axis], r[1][axis]])
                .collect();
            borders.sort_by(f64::total_cmp);
            borders
        };
        let (xs, ys) = (borders(0), borders(1));
        let mut visible = vec![0.0; self.rectangles.len()];
        for x in xs.windows(2) {
            for y in ys.windows(2) {
                let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
                let holds =
                    |r: &Rectangle| (0..2).all(|k| r[0][k] < middle[k] && middle[k] < r[1][k]);
                let there = (0..self.rectangles.len()).filter(|&k| holds(&self.rectangles[k]));
                let rank = |k: &usize| (!self.emitting[*k], area(self.rectangles[*k]));
                for is_turned in [false, true] {
                    let side = there.clone().filter(|&k| self.turned[k] == is_turned);
                    let top = side.min_by(|a, b| rank(a).partial_cmp(&rank(b)).unwrap());
                    if let Some(top) = top {
                        visible[top] += (x[1] - x[0]) * (y[1] - y[0]);
                    }
                }
            }
        }
        visible
    }
}

/// The least height of a triangle, or up to twice that, metres.
fn height(surface: &Surface) -> f64 {
    surface.area() / surface.side_lengths().into_iter().fold(0.0, f64::max)
}

/// What is there, whatever the order.
fn parts(cut: &Cutted) -> Vec<([Place; 3], u32, u32)> {
    let part = |s: &Surface| (places(s.corners), s.material.0, s.object.0);
    let mut parts: Vec<_> = cut.surfaces.iter().map(part).collect();
    parts.sort_unstable();
    parts
}

fn plane() -> impl Strategy<Value = Plane> {
    // On a grid borders meet; off it they do not.
    let coordinate =
        prop_oneof![1 => (0..16_u8).prop_map(|k| f64::from(k) / 4.0), 2 => 0.0..4.0_f64];
    let side = prop_oneof![1 => (1..8_u8).prop_map(|k| f64::from(k) / 4.0), 2 => 0.05..2.0_f64];
    let rectangle = (coordinate.clone(), coordinate, side.clone(), side)
        .prop_map(|(x, y, dx, dy)| [[x, y], [x + dx, y + dy]]);
    let thing = (
        rectangle,
        prop::bool::weighted(0.3),
        prop::bool::weighted(0.3),
    );
    let things = prop::collection::vec(thing, 1..6);
    let axis = prop_oneof![
        Just(DVec3::Z),
        Just(DVec3::X),
        Just(DVec3::new(0.3, 0.5, 0.8))
    ];
    (things, axis, -3.0..3.0_f64, -9.0..9.0_f64).prop_map(|(things, axis, angle, shift)| {
        let whole = ([[-0.5, -0.5], [6.5, 6.5]], false, false);
        let things: Vec<_> = things.into_iter().chain([whole]).collect();
        Plane {
            rectangles: things.iter().map(|thing| thing.0).collect(),
            emitting: things.iter().map(|thing| thing.1).collect(),
            turned: things.iter().map(|thing| thing.2).collect(),
            turn: DQuat::from_axis_angle(axis.normalize(), angle),
            shift: DVec3::new(shift, 0.5 * shift, 1.0),
        }
    })
}

proptest! {
    /// Corners are f32 near 10 m: borders move by some steps of 1e-6 m, over some 100 m of borders.
    #[test]
    fn each_thing_keeps_what_is_seen_of_it(plane in plane()) {
        let order: Vec<usize> = (0..plane.rectangles.len()).collect();
        // Which of two of equal areas stays, their corners decide.
        let sizes: Vec<f64> = plane.rectangles.iter().map(|&r| area(r)).collect();
        let differ = |k: usize| sizes[..k].iter().all(|a| (a / sizes[k] - 1.0).abs() > 1e-4);
        prop_assume!((0..sizes.len()).all(differ));
        let cut = plane.cut(&order);
        let mut areas = vec![0.0; plane.rectangles.len()];
        for surface in &cut.surfaces {
            areas[surface.object.index()] += surface.area();
        }
        for (k, (found, expected)) in areas.iter().zip(plane.visible()).enumerate() {
            prop_assert!((found - expected).abs() < 1e-3, "{k}: {found}, {expected}: {plane:?}");
        }
        prop_assert_eq!(cut.faces.len(), cut.surfaces.len());
        // In the plane, facing as before.
        let normal = plane.turn * DVec3::Z;
        for surface in &cut.surfaces {
            // A sliver's normal is off by rounding over its height.
            let height = height(surface);
            let side = if plane.turned[surface.object.index()] { -1.0 } else { 1.0 };
            let cosine = side * surface.normal().dot(normal);
            prop_assert!(cosine > 0.99 || height < 1e-4, "{surface:?}");
        }
    }

    /// What lies on both sides of the plane has the same three corners on both.
    #[test]
    fn sides_are_cut_alike(plane in plane()) {
        let order: Vec<usize> = (0..plane.rectangles.len()).collect();
        let cut = plane.cut(&order);
        let is_turned = |s: &&Surface| plane.turned[s.object.index()];
        let mirrored = |s: &Surface| {
            let [a, b, c] = s.corners;
            places([a, c, b])
        };
        let (backs, fronts): (Vec<&Surface>, Vec<&Surface>) = cut.surfaces.iter().partition(is_turned);
        let fronts: std::collections::HashSet<_> = fronts.iter().map(|s| places(s.corners)).collect();
        // The whole plane has a front, but for slivers between an edge and its path of grid points.
        for back in backs.into_iter().filter(|back| height(back) > 1e-5) {
            prop_assert!(fronts.contains(&mirrored(back)), "{back:?}");
        }
    }

    #[test]
    fn the_order_of_the_file_decides_nothing(plane in plane(), seed in any::<u64>()) {
        let order: Vec<usize> = (0..plane.rectangles.len()).collect();
        let mut other = order.clone();
        other.rotate_left(seed as usize % order.len());
        other.reverse();
        prop_assert_eq!(parts(&plane.cut(&order)), parts(&plane.cut(&other)));
    }

    #[test]
    fn what_is_in_order_stays(plane in plane()) {
        let order: Vec<usize> = (0..plane.rectangles.len()).collect();
        let mut cut = plane.cut(&order);
        let before = cut.surfaces.clone();
        let material = Material { name: "m".into(), reflectance: Rgb::ZERO, emission: Rgb::ZERO };
        let objects: Vec<String> = order.iter().map(ToString::to_string).collect();
        let model = Model {
            surfaces: &mut cut.surfaces,
            faces: &mut cut.faces,
            materials: &[material.clone(), material],
            objects: &objects,
            opening: None,
        };
        let told = put_in_order(model, Cut::On).unwrap();
        prop_assert!(told.is_empty(), "{told:?}");
        prop_assert_eq!(cut.surfaces, before);
    }
}

#[test]
fn each_pair_is_told_once_with_its_area() {
    let plane = Plane {
        rectangles: vec![
            [[0.0, 0.0], [4.0, 4.0]],
            [[1.0, 1.0], [2.0, 3.0]],
            [[1.5, 1.0], [2.5, 2.0]],
        ],
        emitting: vec![false, false, true],
        turned: vec![false; 3],
        turn: DQuat::IDENTITY,
        shift: DVec3::ZERO,
    };
    let told = plane.cut(&[0, 1, 2]).told;
    assert_eq!(
        told,
        [
            "\"1\" lies in the plane of \"0\", which is cut there: 1.5000e0 m^2",
            "\"2\" lies in the plane of \"0\", which is cut there: 1.0000e0 m^2",
            "\"2\" lies in the plane of \"1\", which is cut there: 5.0000e-1 m^2",
        ]
    );
}

/// A ceiling above its floor, a sheet of two sides, and faces that touch along an edge.
#[test]
fn what_does_not_overlap_keeps_its_bits() {
    let scene = test_scenes_room();
    let (mut surfaces, mut faces) = (scene.surfaces().to_vec(), scene.faces().to_vec());
    let sheet: Vec<Surface> = surfaces
        .iter()
        .map(|s| {
            let [a, b, c] = s.corners;
            Surface {
                corners: [a, c, b],
                ..*s
            }
        })
        .collect();
    surfaces.extend(&sheet);
    faces.extend(0..sheet.len() as u32);
    let (before, faces_before) = (surfaces.clone(), faces.clone());
    let model = Model {
        surfaces: &mut surfaces,
        faces: &mut faces,
        materials: scene.materials(),
        objects: scene.objects(),
        opening: None,
    };
    assert!(put_in_order(model, Cut::On).unwrap().is_empty());
    assert_eq!((surfaces, faces), (before, faces_before));
}

fn test_scenes_room() -> scene::Scene {
    genx::make(&genx::Settings::new(genx::Model::Hall))
        .unwrap()
        .scene
}

/// A floor of two triangles and a wall across it: pieces lie on one side of the wall or the other, whatever the order.
#[test]
fn faces_are_cut_where_others_stand_on_them_or_cross_them() {
    for depth in [0.0, 0.5] {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).as_vec3();
        let quad = |[a, b, c, d]: [glam::Vec3; 4], object: u32| {
            [[a, b, c], [a, c, d]].map(|corners| Surface {
                corners,
                material: MaterialId(0),
                object: ObjectId(object),
            })
        };
        let floor = quad(
            [
                at(0.0, 0.0, 0.0),
                at(4.0, 0.0, 0.0),
                at(4.0, 3.0, 0.0),
                at(0.0, 3.0, 0.0),
            ],
            0,
        );
        let (low, high) = (-depth, 2.0);
        let wall = quad(
            [
                at(1.3, 0.4, low),
                at(2.9, 2.7, low),
                at(2.9, 2.7, high),
                at(1.3, 0.4, high),
            ],
            1,
        );
        let material = Material {
            name: "m".into(),
            reflectance: Rgb::ZERO,
            emission: Rgb::ZERO,
        };
        let mut seen = Vec::new();
        for order in [[floor, wall].concat(), [wall, floor].concat()] {
            let (mut surfaces, mut faces) = (order, (0..4).collect());
            let model = Model {
                surfaces: &mut surfaces,
                faces: &mut faces,
                materials: std::slice::from_ref(&material),
                objects: &["floor".into(), "wall".into()],
                opening: None,
            };
            let told = put_in_order(model, Cut::On).unwrap();
            assert_eq!(told.len(), 1, "{told:?}");
            let area = |object: u32| -> f64 {
                let of_object = surfaces.iter().filter(|s| s.object.0 == object);
                of_object.map(Surface::area).sum()
            };
            assert!(
                (area(0) - 12.0).abs() < 1e-5
                    && (area(1) - wall[0].area() - wall[1].area()).abs() < 1e-5
            );
            // Heights over the wall's line, metres: of a piece that reaches along the wall none lies on both sides.
            let across = DVec3::new(-2.3, 1.6, 0.0).normalize();
            let along = DVec3::new(1.6, 2.3, 0.0).normalize();
            let from = DVec3::new(1.3, 0.4, 0.0);
            for surface in surfaces.iter().filter(|s| s.object.0 == 0) {
                let corners = surface.corners.map(|p| p.as_dvec3() - from);
                let middle = corners.into_iter().sum::<DVec3>() / 3.0;
                let beside =
                    (0.1..2.7).contains(&middle.dot(along)) && middle.dot(across).abs() < 0.1;
                let [low, high] = [f64::min, f64::max].map(|f| {
                    corners
                        .map(|p| p.dot(across))
                        .into_iter()
                        .reduce(f)
                        .unwrap()
                });
                assert!(!beside || low > -1e-5 || high < 1e-5, "{surface:?}");
            }
            let parts = |s: &Surface| (places(s.corners), s.object.0);
            let mut parts: Vec<_> = surfaces.iter().map(parts).collect();
            parts.sort_unstable();
            seen.push(parts);
        }
        assert_eq!(seen[0], seen[1]);
    }
}

/// 3,000 rectangles about one axis, each of which crosses all others.
#[test]
fn what_explodes_is_an_error_and_changes_nothing() {
    let mut surfaces = Vec::new();
    for k in 0..3000_u32 {
        let (sin, cos) = (std::f64::consts::PI * f64::from(k) / 3000.0).sin_cos();
        let at = |along: f64, z: f64| DVec3::new(along * cos, along * sin, z).as_vec3();
        let [a, b, c, d] = [at(-1.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(-1.0, 1.0)];
        surfaces.extend([[a, b, c], [a, c, d]].map(|corners| Surface {
            corners,
            material: MaterialId(0),
            object: ObjectId(k % 2),
        }));
    }
    let before = surfaces.clone();
    let model = Model {
        surfaces: &mut surfaces,
        faces: &mut (0..6000).collect(),
        materials: &[Material {
            name: "m".into(),
            reflectance: Rgb::ZERO,
            emission: Rgb::ZERO,
        }],
        objects: &["left".into(), "right".into()],
        opening: None,
    };
    let error = put_in_order(model, Cut::On).unwrap_err().to_string();
    assert!(
        error.contains("of object \"") && error.contains("--cut off"),
        "{error}"
    );
    assert_eq!(surfaces, before);
}
