//! Laws of what is shown, and of the table of objects.

mod common;

use common::{closed_cube, lit_room, solution};
use compute::Solve;
use compute::settings::{BackendChoice, Quality};
use display::quantity::LUMENS_PER_WATT;
use display::scale::luminance;
use display::settings::Rows;
use display::table;
use display::{Channel, Mode, Quantity, RenderSettings, SettingsError, Shown, Size, render};
use scene::{Rgb, Scene, Solution};

/// Roundings of a few f32 operations.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

fn shown(quantity: Quantity) -> Shown {
    Shown {
        quantity,
        ..Shown::default()
    }
}

fn linear(scene: &Scene, solution: &Solution, shown: Shown) -> Vec<Rgb> {
    let settings = RenderSettings {
        mode: Mode::Linear,
        shown,
        size: Some(Size {
            width: 48,
            height: 36,
        }),
        ..RenderSettings::default()
    };
    render(scene, Some(solution), &settings).unwrap().linear
}

/// The lit room with a function between its patches.
fn solved_room() -> (Scene, Solution) {
    let (scene, _) = lit_room();
    let mut settings = Quality::Draft.settings();
    settings.drawing.backend = BackendChoice::Cpu;
    let solved = Solve::new(&scene).settings(settings).run().unwrap();
    let solution = solved.into_solution();
    assert!(solution.function.is_some());
    (scene, solution)
}

#[test]
fn direct_and_indirect_irradiance_are_the_irradiance() {
    let (scene, solution) = solved_room();
    let of = |quantity| linear(&scene, &solution, shown(quantity));
    let [direct, indirect, all] =
        [Quantity::Direct, Quantity::Indirect, Quantity::Irradiance].map(of);
    let mut is_lit = [false; 2];
    for ((&direct, indirect), all) in direct.iter().zip(indirect).zip(all) {
        // A vertex where a correction takes more than all reflected light has no indirect light.
        assert!(
            (direct + indirect).abs_diff_eq(all, 1e-3 * all.max_element() + 1e-6),
            "{direct} {indirect} {all}"
        );
        is_lit = [is_lit[0] || direct.x > 0.0, is_lit[1] || indirect.x > 0.0];
    }
    assert_eq!(is_lit, [true; 2]);
    for quantity in [Quantity::Direct, Quantity::Indirect, Quantity::Irradiance] {
        let patches = shown(quantity).of_patches(&scene, Some(&solution)).unwrap();
        assert!(patches.iter().any(|value| value.x > 0.0), "{quantity}");
    }
}

#[test]
fn radiosity_is_emission_and_what_is_reflected_of_the_irradiance() {
    let (scene, solution) = solved_room();
    let of = |quantity| linear(&scene, &solution, shown(quantity));
    let radiosity = of(Quantity::Radiosity);
    let radiance = of(Quantity::Radiance);
    for (radiosity, radiance) in radiosity.iter().zip(radiance) {
        let expected = *radiosity / std::f32::consts::PI;
        assert!(radiance.abs_diff_eq(expected, ROUNDING * expected.max_element()));
    }
    let patches = |quantity| shown(quantity).of_patches(&scene, Some(&solution)).unwrap();
    let radiosity = patches(Quantity::Radiosity);
    let parts = patches(Quantity::Emission)
        .into_iter()
        .zip(patches(Quantity::Reflectance))
        .zip(patches(Quantity::Irradiance));
    for (b, ((e, rho), h)) in radiosity.into_iter().zip(parts) {
        assert!(b.abs_diff_eq(e + rho * h, ROUNDING * b.max_element()));
    }
}

/// 1 W/m^2 of white light has 179 lx.
#[test]
fn luminous_values_are_lumens_of_the_luminance() {
    let (scene, solution) = solved_room();
    for quantity in [
        Quantity::Irradiance,
        Quantity::Radiosity,
        Quantity::Radiance,
    ] {
        let watts = linear(&scene, &solution, shown(quantity));
        let luminous = Shown {
            is_luminous: true,
            ..shown(quantity)
        };
        let lumens = linear(&scene, &solution, luminous);
        for (watts, lumens) in watts.into_iter().zip(lumens) {
            let (found, expected) = (luminance(lumens), LUMENS_PER_WATT * luminance(watts));
            assert!(
                (found - expected).abs() <= ROUNDING * expected,
                "{found} {expected}"
            );
        }
    }
    let cube = closed_cube(0);
    let white = common::solution(&cube, |_| Rgb::ONE);
    let lux = Shown {
        is_luminous: true,
        ..shown(Quantity::Irradiance)
    };
    let values = lux.of_patches(&cube, Some(&white)).unwrap();
    assert!((luminance(values[0]) - 179.0).abs() < 179.0 * ROUNDING);
    assert_eq!(lux.unit(), "lx");
}

#[test]
fn one_channel_is_a_grey_of_its_value() {
    let scene = closed_cube(0);
    let value = Rgb::new(1.0, 2.0, 4.0);
    let solution = solution(&scene, |_| value);
    for (channel, expected) in [
        (Channel::All, value),
        (Channel::Red, Rgb::splat(1.0)),
        (Channel::Green, Rgb::splat(2.0)),
        (Channel::Blue, Rgb::splat(4.0)),
        (Channel::Luminance, Rgb::splat(luminance(value))),
    ] {
        let shown = Shown {
            channel,
            ..shown(Quantity::Irradiance)
        };
        let found = linear(&scene, &solution, shown);
        let is_so = |found: &Rgb| found.abs_diff_eq(expected, 4.0 * ROUNDING);
        assert!(found.iter().all(is_so), "{channel}");
    }
}

#[test]
fn parts_that_a_solution_does_not_have_are_an_error() {
    let (scene, solution) = lit_room();
    for quantity in [Quantity::Direct, Quantity::Indirect] {
        let found = shown(quantity).of_patches(&scene, Some(&solution));
        assert!(matches!(found, Err(SettingsError::NoParts { .. })));
    }
}

/// In a closed room what is received is what is sent out: emitted and reflected.
#[test]
fn a_table_balances_power() {
    let scene = closed_cube(3);
    let solution = solution(&scene, |_| Rgb::new(1.0, 2.0, 3.0));
    let radiosity = shown(Quantity::Radiosity);
    let values = radiosity.of_patches(&scene, Some(&solution)).unwrap();
    let rows = table::rows(&scene, Some(&solution), radiosity, &values, Rows::Objects);
    assert_eq!(rows.len(), 1);
    let row = &rows[0];
    assert_eq!(row.patches, scene.patch_count());
    // Six sides of 4 m^2, and the mean of the channels, half of which is reflected.
    assert!(
        (row.area - 24.0).abs() < 1e-9 && (row.received - 48.0).abs() < 1e-6,
        "{row:?}"
    );
    assert!(row.emitted == 0.0);
    let expected = f64::from(luminance(Rgb::new(0.5, 1.0, 1.5)));
    for value in row.luminance {
        assert!((value - expected).abs() < 1e-6, "{row:?}");
    }
    let (room, solution) = lit_room();
    let values = radiosity.of_patches(&room, Some(&solution)).unwrap();
    let by_material = table::rows(&room, Some(&solution), radiosity, &values, Rows::Materials);
    assert_eq!(by_material.len(), 3);
    let emitted: f64 = by_material.iter().map(|row| row.emitted).sum();
    let expected = room.emitted_power().element_sum() / 3.0;
    assert!(
        (emitted / expected - 1.0).abs() < 1e-6,
        "{emitted} {expected}"
    );
    let text = table::text(&by_material, radiosity, Rows::Materials);
    assert_eq!(text.lines().count(), 5, "{text}");
}
