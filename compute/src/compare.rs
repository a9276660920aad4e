//! How far one solution of a scene is from another.
//!
//! Both errors are those of [`crate::function`]: of the reflected radiosity rho H as a picture shows it, over the area that light
//! reaches in either. Patches may differ, surfaces may not.

use glam::DVec3;
use scene::{Scene, Solution, Surface, SurfaceId};

use crate::function::{Errors, VISIBLE_FLOOR};

/// Points at which solutions are compared, at least.
const POINTS: f64 = 40_000.0;

/// The steps of a sequence that fills a square evenly (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// The errors of a solution if another one is right; `None` where they are not of the same surfaces.
pub fn errors(shown: (&Scene, &Solution), right: (&Scene, &Solution)) -> Option<Errors> {
    let same = |(a, b): (&Surface, &Surface)| a.corners == b.corners;
    let (surfaces, others) = (shown.0.surfaces(), right.0.surfaces());
    if surfaces.len() != others.len() || !surfaces.iter().zip(others).all(same) {
        return None;
    }
    let scene = right.0;
    let spacing = scene.area() / POINTS;
    let mut pairs = Vec::new();
    for (id, surface) in (0..).map(SurfaceId).zip(surfaces) {
        let rho = scene.material(surface.material).reflectance.as_dvec3();
        let count = (surface.area() / spacing).ceil();
        for _ in 0..count as u64 {
            let [u, v] = STEPS.map(|step| (pairs.len() as f64 * step).fract());
            let root = u.sqrt();
            let within = [1.0 - root, root * (1.0 - v), root * v].map(|w| w as f32);
            let [shown, right] = [shown, right].map(|of| rho * irradiance(of, id, within));
            pairs.push((surface.area() / count, shown, right));
        }
    }
    pairs.retain(|&(_, shown, right)| shown != DVec3::ZERO || right != DVec3::ZERO);
    let sum = |value: &dyn Fn(DVec3, DVec3) -> f64| -> f64 {
        let terms = pairs
            .iter()
            .map(|&(area, shown, right)| area * value(shown, right));
        terms.sum()
    };
    let area = sum(&|_, _| 1.0).max(f64::MIN_POSITIVE);
    let mean = sum(&|_, right| right.element_sum() / 3.0) / area;
    let power = sum(&|shown, right| (shown - right).length_squared())
        / sum(&|_, right| right.length_squared()).max(f64::MIN_POSITIVE);
    let visible = sum(&|shown, right| {
        let base = right + (VISIBLE_FLOOR * mean).max(f64::MIN_POSITIVE);
        ((shown - right) / base).length_squared() / 3.0
    }) / area;
    Some(Errors {
        power: power.sqrt(),
        visible: visible.sqrt(),
    })
}

/// What a point of a surface receives, W/m^2, by the function where there is one.
fn irradiance(
    (scene, solution): (&Scene, &Solution),
    surface: SurfaceId,
    within: [f32; 3],
) -> DVec3 {
    let function = solution.function.as_ref();
    let by_function =
        function.and_then(|function| function.interpolate(function.irradiance(), surface, within));
    let by_patch = || {
        let (patch, _) = scene.mesh().locate(surface, within);
        solution.irradiance[patch.index()]
    };
    by_function.unwrap_or_else(by_patch).as_dvec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A solution that is a tenth too bright everywhere is off by a tenth of the power; of what is visible a little less, since a
    /// twentieth of the mean is added to what is right.
    #[test]
    fn what_is_a_tenth_too_bright_is_off_by_a_tenth() {
        let made = genx::make(&genx::Settings::new(genx::Model::Furnace)).unwrap();
        let scene = made.scene;
        let mut right = Solution::dark(&scene);
        right.irradiance.fill(scene::Rgb::ONE);
        let mut shown = right.clone();
        shown.irradiance.fill(scene::Rgb::splat(1.1));
        let found = errors((&scene, &shown), (&scene, &right)).unwrap();
        assert!((found.power - 0.1).abs() < 1e-6, "{found:?}");
        assert!((found.visible - 0.1 / 1.05).abs() < 1e-6, "{found:?}");
        assert_eq!(
            errors((&scene, &right), (&scene, &right)),
            Some(Errors::default())
        );
    }
}
