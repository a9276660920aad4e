//! How far one solution of a scene is from another.
//!
//! Both errors are those of [`crate::function`]: of the reflected radiosity rho H as a picture shows it, over the area that light
//! reaches in either. Patches may differ, surfaces may not.

use glam::DVec3;
use scene::{Scene, Solution, Surface, SurfaceId};

use crate::function::{Errors, VISIBLE_FLOOR};

/// Points at which solutions are compared, at least.
pub const POINTS: f64 = 40_000.0;

/// The steps of a sequence that fills a square evenly (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// What a point shows, and what it should.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// What it stands for: an area, m^2, or a number of pixels.
    pub area: f64,
    /// Radiosity that it shows, W/m^2.
    pub shown: DVec3,
    /// Radiosity that is right, W/m^2.
    pub right: DVec3,
}

/// Both errors over some points: 0 where nothing differs, infinite where what is right is black and what is shown is not. What is right
/// and below 0, as filters of pictures leave it, counts as black in the visible error's denominator.
pub fn errors_over(points: &(impl Iterator<Item = Compared> + Clone)) -> Errors {
    let sum = |value: &dyn Fn(DVec3, DVec3) -> f64| -> f64 {
        let terms = points
            .clone()
            .map(|point| point.area * value(point.shown, point.right));
        terms.sum()
    };
    let wrong = sum(&|shown, right| (shown - right).length_squared());
    if wrong == 0.0 {
        return Errors::default();
    }
    let area = sum(&|_, _| 1.0);
    let floor = VISIBLE_FLOOR * sum(&|_, right| right.element_sum() / 3.0) / area;
    if floor <= 0.0 {
        return Errors {
            power: f64::INFINITY,
            visible: f64::INFINITY,
        };
    }
    let power = wrong / sum(&|_, right| right.length_squared());
    let visible = sum(&|shown, right| {
        let base = right.max(DVec3::ZERO) + floor;
        ((shown - right) / base).length_squared() / 3.0
    }) / area;
    Errors {
        power: power.sqrt(),
        visible: visible.sqrt(),
    }
}

/// Whether two scenes have the same surfaces, in the same order and relative to their origins.
pub fn are_same_surfaces(a: &Scene, b: &Scene) -> bool {
    let same = |(a, b): (&Surface, &Surface)| a.corners == b.corners;
    let (surfaces, others) = (a.surfaces(), b.surfaces());
    surfaces.len() == others.len() && surfaces.iter().zip(others).all(same)
}

/// The errors of a solution if another one is right; `None` where they are not of the same surfaces.
pub fn errors(shown: (&Scene, &Solution), right: (&Scene, &Solution)) -> Option<Errors> {
    if !are_same_surfaces(shown.0, right.0) {
        return None;
    }
    let scene = right.0;
    let spacing = scene.area() / POINTS;
    let mut points = Vec::new();
    for (id, surface) in (0..).map(SurfaceId).zip(scene.surfaces()) {
        let rho = scene.material(surface.material).reflectance.as_dvec3();
        let count = (surface.area() / spacing).ceil();
        for _ in 0..count as u64 {
            let [u, v] = STEPS.map(|step| (points.len() as f64 * step).fract());
            let root = u.sqrt();
            let within = [1.0 - root, root * (1.0 - v), root * v].map(|w| w as f32);
            let [shown, right] = [shown, right].map(|of| rho * irradiance_at(of, id, within));
            points.push(Compared {
                area: surface.area() / count,
                shown,
                right,
            });
        }
    }
    points.retain(Compared::is_lit);
    Some(errors_over(&points.iter().copied()))
}

impl Compared {
    /// Whether light reaches it in either solution.
    pub fn is_lit(&self) -> bool {
        self.shown != DVec3::ZERO || self.right != DVec3::ZERO
    }
}

/// What a point of a surface receives, W/m^2, by the function where there is one. `within` are barycentric coordinates in the surface.
pub fn irradiance_at(
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
    fn at(shown: f64, right: [f64; 3]) -> Compared {
        Compared {
            area: 2.0,
            shown: DVec3::splat(shown),
            right: DVec3::from_array(right),
        }
    }

    #[test]
    fn there_is_no_relative_error_of_what_is_black_unless_nothing_differs() {
        let errors_of = |points: &[Compared]| errors_over(&points.iter().copied());
        assert_eq!(errors_of(&[]), Errors::default());
        assert_eq!(errors_of(&[at(0.0, [0.0; 3])]), Errors::default());
        let black = errors_of(&[at(1.0, [0.0; 3])]);
        assert!(black.power == f64::INFINITY && black.visible == f64::INFINITY);
    }

    /// By hand: the mean is 0.8, its twentieth 0.04; without it what is below 0 and off by as much would be divided by nothing.
    #[test]
    fn what_is_right_and_below_zero_is_no_denominator() {
        let below = errors_over(&[at(0.0, [-0.04; 3]), at(1.64, [1.64; 3])].into_iter());
        let power = (0.04_f64.powi(2) / (0.04_f64.powi(2) + 1.64_f64.powi(2))).sqrt();
        assert!((below.power - power).abs() < 1e-12, "{below:?}");
        assert!((below.visible - 0.5_f64.sqrt()).abs() < 1e-12, "{below:?}");
    }
}
