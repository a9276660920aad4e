//! Irradiance as a function: meshes that conform however they grow, and values that are linear between vertices.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::function::{IrradianceFunction, Node, NodeId, Refinement, VertexMesh};
use scene::{Material, MaterialId, ObjectId, PatchId, Rgb, Scene, SceneError, Surface, SurfaceId};

/// What a mesh is made of.
type Parts = (Vec<u32>, Vec<Node>, Vec<Vec3>);

/// Triangles in the plane z = 0, of one material.
fn scene(triangles: &[[[f32; 2]; 3]], depth: u32) -> Scene {
    let surfaces: Vec<Surface> = triangles
        .iter()
        .map(|corners| Surface {
            corners: corners.map(|[x, y]| Vec3::new(x, y, 0.0)),
            material: MaterialId(0),
            object: ObjectId(0),
        })
        .collect();
    let wall = Material {
        name: "wall".into(),
        reflectance: Rgb::splat(0.5),
        emission: Rgb::ZERO,
    };
    let depths = vec![depth; surfaces.len()];
    Scene::new(
        vec![wall],
        vec!["all".into()],
        surfaces,
        &depths,
        DVec3::ZERO,
    )
    .unwrap()
}

/// Four triangles about a point that is not in the middle: no two of them have a common longest side.
fn fan(middle: [f32; 2]) -> Scene {
    let rim = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]];
    let triangle = |k: usize| [rim[k], rim[(k + 1) % 4], middle];
    scene(&[0, 1, 2, 3].map(triangle), 3)
}

fn whole(scene: &Scene) -> Refinement {
    Refinement::new(scene, |_| true, |_, _| true)
}

/// Bisects the leaf in each of these places among the leaves.
fn grow(mesh: &mut Refinement, places: &[prop::sample::Index]) {
    for place in places {
        let leaves: Vec<NodeId> = mesh.leaves().collect();
        mesh.bisect(leaves[place.index(leaves.len())]);
    }
}

fn places() -> impl Strategy<Value = Vec<prop::sample::Index>> {
    vec(any::<prop::sample::Index>(), 0..60)
}

/// A function that is linear over the plane z = 0.
fn plane(position: DVec3) -> f32 {
    (1.0 + 0.25 * position.x + 0.5 * position.y) as f32
}

fn function_of(mesh: &VertexMesh, value: impl Fn(Vec3) -> f32) -> IrradianceFunction {
    let values: Vec<Rgb> = mesh
        .vertices()
        .iter()
        .map(|&p| Rgb::splat(value(p)))
        .collect();
    IrradianceFunction::new(mesh.clone(), values.clone(), values).unwrap()
}

proptest! {
    /// Each side of a leaf is that of one other leaf, or lies on the rim: then no vertex lies within a side. Leaves keep the
    /// orientation and the area of what they are parts of.
    #[test]
    fn meshes_conform_however_they_grow(x in 0.5_f32..3.5, y in 0.5_f32..2.5, places in places()) {
        let scene = fan([x, y]);
        let mut growing = whole(&scene);
        grow(&mut growing, &places);
        let mesh = growing.mesh().unwrap();
        let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
        for surface in (0..4).map(SurfaceId) {
            let mut area = 0.0;
            for (corners, depth) in mesh.leaves(surface) {
                for k in 0..3 {
                    *sides.entry([corners[k], corners[(k + 1) % 3]]).or_default() += 1;
                }
                let [a, b, c] = corners.map(|v| mesh.vertices()[v as usize].as_dvec3());
                let leaf = 0.5 * (b - a).cross(c - a).z;
                let expected = scene.surface(surface).area() / f64::from(1_u32 << depth);
                // Positions are f32.
                prop_assert!((leaf - expected).abs() < 1e-5, "{leaf}, {expected}");
                area += leaf;
            }
            prop_assert!((area - scene.surface(surface).area()).abs() < 1e-4);
        }
        for ([a, b], count) in &sides {
            prop_assert_eq!(*count, 1);
            let [p, q] = [a, b].map(|v| mesh.vertices()[*v as usize]);
            let [low, high] = [Vec3::ZERO, Vec3::new(4.0, 3.0, 1.0)];
            let on = |border: Vec3| p.cmpeq(border) & q.cmpeq(border);
            let is_rim = (on(low) | on(high)).bitmask() & 0b11 != 0;
            prop_assert_eq!(sides.contains_key(&[*b, *a]), !is_rim, "{} {}", p, q);
        }
        // Nothing is there twice.
        let mut positions: Vec<[u32; 3]> = mesh.vertices().iter().map(|&p| scene::weld::place(p)).collect();
        positions.sort_unstable();
        positions.dedup();
        prop_assert_eq!(positions.len(), mesh.vertex_count() as usize);
    }

    /// What is linear at the vertices is so between them, and its mean over a patch is its value in the patch's middle, be the
    /// patch larger than leaves or smaller. Positions are f32 of at most 4, values of at most 3.5.
    #[test]
    fn linear_functions_are_reproduced(
        x in 0.5_f32..3.5, y in 0.5_f32..2.5, places in places(), a in 0.0_f32..1.0, b in 0.0_f32..1.0
    ) {
        let scene = fan([x, y]);
        let mut growing = whole(&scene);
        grow(&mut growing, &places);
        let function = function_of(&growing.mesh().unwrap(), |p| plane(p.as_dvec3()));
        let at = [a.min(b), (a - b).abs(), 1.0 - a.max(b)];
        for surface in (0..4).map(SurfaceId) {
            let corners = scene.surface(surface).corners;
            let point: Vec3 = (0..3).map(|k| at[k] * corners[k]).sum();
            let found = function.interpolate(function.irradiance(), surface, at).unwrap();
            prop_assert!((found.x - plane(point.as_dvec3())).abs() < 1e-5, "{found} at {point}");
        }
        for patch in (0..scene.patch_count()).map(PatchId) {
            let found = function.mean_over(&scene, function.irradiance(), patch).unwrap();
            let expected = plane(scene.patch(patch).centroid());
            prop_assert!((found.x - expected).abs() < 1e-5, "{found}, {expected}");
        }
    }

    /// Means over patches are those over smaller parts of them.
    #[test]
    fn means_over_patches_are_means_over_their_points(places in places()) {
        let scene = fan([1.0, 2.0]);
        let mut growing = whole(&scene);
        grow(&mut growing, &places);
        let function = function_of(&growing.mesh().unwrap(), |p| (3.0 * p.x + p.y * p.y).sin() + 2.0);
        let finer = Scene::new(
            scene.materials().to_vec(),
            scene.objects().to_vec(),
            scene.surfaces().to_vec(),
            &[9; 4],
            DVec3::ZERO,
        )
        .unwrap();
        for patch in 0..scene.patch_count() {
            let mean = function.mean_over(&scene, function.irradiance(), PatchId(patch)).unwrap();
            let parts = (64 * patch..64 * patch + 64).map(PatchId);
            let of_parts = parts.map(|part| function.mean_over(&finer, function.irradiance(), part).unwrap());
            let of_parts = of_parts.sum::<Rgb>() / 64.0;
            prop_assert!((mean - of_parts).length() < 1e-5, "{mean}, {of_parts}");
        }
    }
}

/// Two triangles of a square, the diagonal of which is the foot of something: each side has its own vertices along it, but where
/// one can go around its end.
#[test]
fn what_stands_on_a_side_parts_its_vertices() {
    let square = scene(
        &[
            [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
            [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        ],
        0,
    );
    let joined = whole(&square);
    assert_eq!(joined.vertex_count(), 4);
    let mut parted = Refinement::new(&square, |_| true, |_, _| false);
    assert_eq!(parted.vertex_count(), 6);
    let first = parted.leaves().next().unwrap();
    parted.bisect(first);
    assert_eq!(parted.leaves().count(), 3);

    // The foot ends in the middle of a fan: around it the wall is one.
    let scene = fan([2.0, 1.0]);
    let foot = [Vec3::new(2.0, 1.0, 0.0), Vec3::new(4.0, 3.0, 0.0)];
    let is_foot = |ends: [Vec3; 2]| foot == ends || foot == [ends[1], ends[0]];
    let mut parted = Refinement::new(&scene, |_| true, |_, ends| !is_foot(ends));
    // The rim's corner where the foot begins is two.
    assert_eq!(parted.vertex_count(), 6);
    for _ in 0..5 {
        let leaves: Vec<NodeId> = parted.leaves().collect();
        for leaf in leaves {
            parted.bisect(leaf);
        }
    }
    let mesh = parted.mesh().unwrap();
    let on_foot = mesh
        .vertices()
        .iter()
        .filter(|p| (p.x - p.y - 1.0).abs() < 1e-6 && p.x > 2.1);
    // Their middle, quarters and so on, and the corner, twice each.
    let places = on_foot.clone().map(|&p| scene::weld::place(p));
    let places: std::collections::BTreeSet<_> = places.collect();
    assert!(places.len() >= 4, "{places:?}");
    assert_eq!(on_foot.count(), 2 * places.len());
}

/// Surfaces without vertices have none.
#[test]
fn surfaces_may_have_what_their_patches_have() {
    let scene = fan([2.0, 1.0]);
    let mesh = Refinement::new(&scene, |surface| surface.0 != 2, |_, _| true)
        .mesh()
        .unwrap();
    let function = function_of(&mesh, |_| 1.0);
    let middle = [0.25, 0.25, 0.5];
    for surface in (0..4).map(SurfaceId) {
        let found = function.interpolate(function.irradiance(), surface, middle);
        assert_eq!(found, (surface.0 != 2).then_some(Rgb::ONE));
        assert_eq!(mesh.leaves(surface).len(), usize::from(surface.0 != 2));
    }
    assert_eq!(
        function.mean_over(&scene, function.irradiance(), PatchId(16)),
        None
    );
}

#[test]
fn parts_that_are_no_mesh_are_errors() {
    let scene = fan([2.0, 1.0]);
    let mut growing = whole(&scene);
    let first = growing.leaves().next().unwrap();
    growing.bisect(first);
    let mesh = growing.mesh().unwrap();
    let parts = || {
        (
            mesh.roots().to_vec(),
            mesh.nodes().to_vec(),
            mesh.vertices().to_vec(),
        )
    };
    let made = |(roots, nodes, vertices)| VertexMesh::new(4, roots, nodes, vertices);
    assert_eq!(made(parts()).unwrap(), mesh);
    let parent = mesh.nodes().iter().position(|node| node.child > 0).unwrap();
    let count = mesh.nodes().len() as u32;
    let faults: [&dyn Fn(&mut Parts); 8] = [
        &|(roots, ..)| _ = roots.pop(),
        &|(roots, ..)| roots[1] = roots[0],
        &|(roots, ..)| roots[1] = count,
        &|(_, nodes, _)| nodes[parent].child = count - 1,
        &|(_, nodes, _)| nodes[parent].child = parent as u32,
        &|(_, nodes, _)| nodes[parent].child = 0,
        &|(_, nodes, _)| nodes[0].vertices[2] = mesh.vertex_count(),
        &|(.., vertices)| vertices[0].x = f32::NAN,
    ];
    for fault in faults {
        let mut wrong = parts();
        fault(&mut wrong);
        assert!(matches!(made(wrong), Err(SceneError::VertexMesh { .. })));
    }
    let values = |value: f32, count: u32| vec![Rgb::splat(value); count as usize];
    let made = |irradiance, direct| IrradianceFunction::new(mesh.clone(), irradiance, direct);
    let good = || values(1.0, mesh.vertex_count());
    assert!(made(good(), good()).is_ok());
    assert!(matches!(
        made(good(), values(1.0, 2)),
        Err(SceneError::VertexValues { values: 2, .. })
    ));
    for value in [-1.0, f32::NAN, f32::INFINITY] {
        let mut wrong = good();
        wrong[3].y = value;
        assert!(matches!(
            made(wrong, good()),
            Err(SceneError::VertexValue { vertex: 3, .. })
        ));
        let function = made(good(), good()).unwrap();
        assert!(matches!(
            function.with_error(vec![0.0, value]),
            Err(SceneError::PatchError { patch: 1, .. })
        ));
    }
}

/// Where a vertex came to be is where it is.
#[test]
fn vertices_know_their_places_on_surfaces() {
    let scene = fan([1.0, 2.0]);
    let mut growing = whole(&scene);
    for round in 0..6 {
        let leaves: Vec<NodeId> = growing.leaves().collect();
        leaves
            .iter()
            .skip(round)
            .step_by(2)
            .for_each(|&leaf| growing.bisect(leaf));
    }
    let at = |surface: SurfaceId, w: DVec3| -> DVec3 {
        let corners = scene.surface(surface).corners.map(Vec3::as_dvec3);
        w.x * corners[0] + w.y * corners[1] + w.z * corners[2]
    };
    for vertex in (0..growing.vertex_count()).map(scene::function::VertexId) {
        let (surface, [place, inside]) = growing.place_of(vertex);
        let position = growing.position(vertex);
        assert!((at(surface, place) - position).length() < 1e-12);
        let on_side = place.min_element() <= 0.0;
        assert!(inside.min_element() > 0.0 || on_side && inside == place);
    }
    for leaf in growing.leaves() {
        let corners = growing
            .in_surface(leaf)
            .map(|w| at(growing.surface(leaf), w));
        let positions = growing.corners(leaf).map(|vertex| growing.position(vertex));
        for (a, b) in corners.iter().zip(positions) {
            assert!((*a - b).length() < 1e-12);
        }
    }
}
