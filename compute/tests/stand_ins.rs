//! What stands in for scenes: walls that arrive as many triangles cost what they would as few, surfaces that arrive whole are meshed as
//! the light asks for, and either way the scene shows it.

mod common;

use common::{folder, load, save, solve, two_rooms};
use compute::Solve;
use compute::compare;
use compute::settings::{Quality, SourceArea, Target};
use compute::solve::Solved;
use glam::{DVec3, Vec3};
use scene::{Scene, Surface, SurfaceId};

const ASKED: f64 = 0.05;

/// Each surface as 4^levels, in one patch each.
fn tessellated(scene: &Scene, levels: u32) -> Scene {
    let mut surfaces = scene.surfaces().to_vec();
    for _ in 0..levels {
        let four = |surface: Surface| {
            let [a, b, c] = surface.corners;
            let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
            let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            parts.map(|corners| Surface { corners, ..surface })
        };
        surfaces = surfaces.into_iter().flat_map(four).collect();
    }
    let depths = vec![0; surfaces.len()];
    let (materials, objects) = (scene.materials().to_vec(), scene.objects().to_vec());
    Scene::new(materials, objects, surfaces, &depths, DVec3::ZERO).unwrap()
}

fn solved(scene: &Scene, source_area: SourceArea, error: f64) -> Solved {
    let mut settings = Quality::settings_for(Target::of(Some(error), None));
    settings.drawing.backend = compute::settings::BackendChoice::Cpu;
    settings.solution.source_area = source_area;
    Solve::new(scene).settings(settings).run().unwrap()
}

/// Hemicubes of sources and of vertices.
fn hemicubes(solved: &Solved) -> u64 {
    solved.rows.hemicubes + u64::from(solved.function.unwrap().vertices)
}

/// Twice the hemicubes are those that the wall's outline may ask for, and chance.
#[test]
fn a_wall_of_many_triangles_costs_what_one_of_few_does() {
    let few = two_rooms();
    let many = tessellated(&few, 4);
    assert!(many.surfaces().len() > 5_000);
    let [of_few, of_many] = [&few, &many].map(|scene| solved(scene, SourceArea::Auto, ASKED));
    assert!(
        hemicubes(&of_many) <= 2 * hemicubes(&of_few),
        "{} {}",
        hemicubes(&of_many),
        hemicubes(&of_few)
    );
    let report = of_many.function.unwrap();
    assert!(report.is_reached, "{report:?}");
    assert_eq!(of_many.irradiance().len(), many.patch_count() as usize);
    of_many.solution().validate(&many).unwrap();
    // Against as many sources as it has triangles, and many more vertices.
    let right = solved(&many, SourceArea::Patches, 0.4 * ASKED);
    let [shown, right] = [&of_many, &right].map(|solved| (&many, solved.solution()));
    let found = compare::errors(shown, right).unwrap();
    assert!(found.power < 1.5 * ASKED, "{found:?}");
}

/// What stands on a floor parts it, in whatever triangles it comes.
#[test]
fn light_does_not_pass_below_a_wall_of_many_triangles() {
    let scene = tessellated(&two_rooms(), 5);
    let solved = solved(&scene, SourceArea::Auto, ASKED);
    let function = solved.solution().function.as_ref().unwrap();
    let at = |surface: u32| {
        let surface = SurfaceId(surface);
        let third = [1.0 / 3.0; 3];
        let irradiance = function.interpolate(function.irradiance(), surface, third);
        let middle = scene.surface(surface).corners.iter().sum::<Vec3>() / 3.0;
        (middle, irradiance.unwrap().x)
    };
    let reflecting = (0..scene.surfaces().len() as u32).filter(|&surface| {
        let material = scene.surface(SurfaceId(surface)).material;
        !scene.material(material).is_emitter()
    });
    let all: Vec<(Vec3, f32)> = reflecting.map(at).collect();
    let brightest = all.iter().fold(0.0, |most: f32, (_, h)| most.max(*h));
    for (middle, irradiance) in all.iter().filter(|(middle, _)| middle.x > 2.0) {
        // A hemicube beside the wall may look through the crack of a rounding.
        assert!(*irradiance < 2e-3 * brightest, "{middle} {irradiance}");
    }
    assert!(
        all.iter()
            .any(|(middle, h)| middle.x < 2.0 && middle.x > 1.9 && *h > 0.01 * brightest)
    );
}

/// A floor of two patches, and a lamp over it of two, are no two sources: smaller ones stand in for them. Means over the patches are
/// those of the function.
#[test]
fn surfaces_that_come_whole_are_meshed_as_the_error_asks() {
    let meshed = two_rooms();
    let whole = meshed.coarsened(|_, _| 0);
    let of_whole = solved(&whole, SourceArea::Auto, 0.4 * ASKED);
    let report = of_whole.function.unwrap();
    assert!(report.is_reached, "{report:?}");
    assert!(of_whole.sources.unwrap().count > 8 * whole.patch_count());
    of_whole.solution().validate(&whole).unwrap();
    assert_eq!(
        of_whole.solution().error().unwrap().len(),
        whole.patch_count() as usize
    );
    let means = of_whole.solution().mean_irradiance(&whole);
    assert_eq!(of_whole.irradiance(), means);
    let right = solved(&meshed, SourceArea::Patches, 0.2 * ASKED);
    let found = compare::errors((&whole, of_whole.solution()), (&meshed, right.solution()));
    let found = found.unwrap();
    assert!(found.power < 1.5 * 0.4 * ASKED, "{found:?}");
}

/// A run that was stopped among what stands in for its scene begins anew, with the bits of one that was not.
#[test]
fn a_run_on_a_stand_in_goes_on_with_the_same_bits() {
    let scenes = [
        tessellated(&two_rooms(), 5),
        two_rooms().coarsened(|_, _| 0),
    ];
    for scene in &scenes {
        goes_on(scene);
    }
}

fn goes_on(scene: &Scene) {
    let folder = folder();
    save(folder.path(), "in.rad", scene);
    let arguments = ["--target-error", "5%", "--backend", "cpu"];
    solve(
        folder.path(),
        &[&["in.rad", "whole.rad"], &arguments[..]].concat(),
    );
    let whole = load(folder.path(), "whole.rad");
    assert!(whole.function.is_some());
    solve(
        folder.path(),
        &[
            &["in.rad", "part.rad", "--time-limit", "1ms"],
            &arguments[..],
        ]
        .concat(),
    );
    let part = load(folder.path(), "part.rad");
    assert!(part.function.is_none());
    solve(
        folder.path(),
        &[&["part.rad", "part.rad"], &arguments[..]].concat(),
    );
    assert_eq!(load(folder.path(), "part.rad"), whole);
}
