//! The furnace by the three programs' command lines, on every back end.

use tests::{backends, folder, patches, run};

/// Rows sum to exactly 1 on every back end, so B = E / (1 - rho) but for the residual r, which leaves at
/// most r rho / (1 - rho), and for three f32 roundings an iteration, which add up to three times
/// 2^-24 / (1 - rho).
#[test]
fn furnace_radiosity_is_emission_over_one_minus_reflectance() {
    const RESIDUAL: f64 = 1e-6;
    for backend in backends() {
        for solver in ["jacobi", "gauss-seidel"] {
            for (reflectance, emission) in [("0", 2.5), ("0.5", 1.0), ("0.9", 100.0)] {
                let folder = folder();
                let power = emission.to_string();
                run(
                    &folder,
                    "genx",
                    &["a.rad", "furnace", "0.05", reflectance, &power],
                );
                let settings = [
                    "--backend",
                    backend,
                    "--solver",
                    solver,
                    "--tolerance",
                    "1e-6",
                ];
                run(
                    &folder,
                    "compute",
                    &[&["a.rad", "a.rad", "32"][..], &settings].concat(),
                );
                let rho = f64::from(reflectance.parse::<f32>().unwrap());
                let expected = emission / (1.0 - rho);
                let rounding = 3.0 / f64::from(1 << 24);
                // The residual is a mean over patches, of which none stands out where all are alike.
                let tolerance = (RESIDUAL * rho + rounding) / (1.0 - rho);
                for (i, patch) in patches(&folder, "a.rad").iter().enumerate() {
                    for radiosity in patch.radiosity.to_array() {
                        let error = (radiosity / expected - 1.0).abs();
                        assert!(
                            error <= tolerance,
                            "{backend}, {solver}, {reflectance}, patch {i}: {error:e}"
                        );
                    }
                }
            }
        }
    }
}

/// Shooting distributes by reciprocity, whose errors even out: all power is there, patch by patch it
/// is not.
#[test]
fn shooting_fills_the_furnace_with_the_same_power() {
    for backend in backends() {
        let folder = folder();
        run(&folder, "genx", &["a.rad", "furnace", "0.05", "0.5", "1"]);
        let settings = [
            "--backend",
            backend,
            "--solver",
            "shooting",
            "--tolerance",
            "1e-6",
        ];
        run(
            &folder,
            "compute",
            &[&["a.rad", "a.rad", "32"][..], &settings].concat(),
        );
        let patches = patches(&folder, "a.rad");
        let power: f64 = patches.iter().map(|p| p.area * p.radiosity.x).sum();
        // Six square metres at 2 W/m^2. Some thousand shots round three times each.
        assert!((power / 12.0 - 1.0).abs() < 1e-3, "{backend}: {power}");
    }
}
