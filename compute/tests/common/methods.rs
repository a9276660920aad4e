//! The solvers on their own, and the equations they solve, as dense matrices.

use compute::FormFactors;
use compute::form_factors::Needed;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::rows::UNITS_PER_ONE;
use compute::settings::{BackendChoice, Drawing, FormFactorSettings, LampViews, Points};
use compute::solver::{Gather, Shoot, Solver, Update};
use glam::DVec3;
use scene::{Rgb, Scene, Solution, State};

/// Half a unit in the last place of an f32, relative: what storing a value may round away.
pub const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Every patch's radiosity is stored as B = E + rho H: H, the product and the sum are rounded.
pub const ROUNDINGS_PER_RADIOSITY: f64 = 3.0;

pub const SETTINGS: FormFactorSettings = FormFactorSettings {
    points: Points::CENTROID,
    lamps: LampViews::Off,
    ..FormFactorSettings::new(32)
};

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    Jacobi,
    GaussSeidel,
    Shooting,
}

pub const METHODS: [Method; 3] = [Method::Jacobi, Method::GaussSeidel, Method::Shooting];

pub fn solver(method: Method, scene: &Scene, start: Solution) -> Box<dyn Solver> {
    let problem = Problem::new(scene);
    match method {
        Method::Jacobi => Box::new(Gather::new(problem, Update::AfterIteration, start)),
        Method::GaussSeidel => Box::new(Gather::new(problem, Update::AtOnce, start)),
        Method::Shooting => Box::new(Shoot::new(problem, start)),
    }
}

pub fn rows(scene: &Scene, budget_bytes: u64) -> RowCache<'_> {
    let drawing = Drawing {
        backend: BackendChoice::Cpu,
        memory_bytes: budget_bytes,
        ..Drawing::default()
    };
    let form_factors = FormFactors::new(scene, SETTINGS, drawing);
    form_factors.rows(Needed::All).unwrap()
}

/// Goes on until `iterations` more are done; steps that end none are free.
pub fn iterate(solver: &mut dyn Solver, rows: &mut RowCache, iterations: u64) {
    let end = solver.iterations() + iterations;
    while solver.iterations() < end {
        solver.step(rows).unwrap();
    }
}

/// Goes on until the residual is at most `residual`, and gives the iterations back.
pub fn converge(solver: &mut dyn Solver, rows: &mut RowCache, residual: f64) -> u64 {
    let before = solver.iterations();
    loop {
        iterate(solver, rows, 1);
        if solver.residual().unwrap() <= residual {
            return solver.iterations() - before;
        }
        assert!(solver.iterations() < 100_000, "{:?}", solver.residual());
    }
}

/// From the dark to this residual.
pub fn solved(method: Method, scene: &Scene, residual: f64) -> Solution {
    let mut rows = rows(scene, u64::MAX);
    let mut solver = solver(method, scene, Solution::dark(scene));
    converge(solver.as_mut(), &mut rows, residual);
    solver.snapshot()
}

/// F_ij as a matrix, row by row.
pub fn form_factors(scene: &Scene) -> Vec<Vec<f64>> {
    let mut rows = rows(scene, u64::MAX);
    let count = scene.patch_count() as usize;
    (0..count)
        .map(|i| {
            let batch = rows.batch_with(i as u32).unwrap();
            let mut row = vec![0.0; count];
            for entry in batch.row(i - batch.receivers().start as usize) {
                row[entry.source as usize] = f64::from(entry.units) / f64::from(UNITS_PER_ONE);
            }
            row
        })
        .collect()
}

/// The factors by which shooting distributes: G_ji = F_ij A_i / A_j, which is F_ji but for the
/// error of the hemicubes' reciprocity.
pub fn shooting_factors(scene: &Scene) -> Vec<Vec<f64>> {
    let form_factors = form_factors(scene);
    let areas = scene.patch_areas();
    (0..areas.len())
        .map(|j| {
            (0..areas.len())
                .map(|i| form_factors[i][j] * areas[i] / areas[j])
                .collect()
        })
        .collect()
}

pub fn factors(method: Method, scene: &Scene) -> Vec<Vec<f64>> {
    if method == Method::Shooting {
        shooting_factors(scene)
    } else {
        form_factors(scene)
    }
}

pub fn largest_row_sum(matrix: &[Vec<f64>]) -> f64 {
    matrix
        .iter()
        .map(|row| row.iter().sum())
        .fold(0.0, f64::max)
}

/// B of B_i = E_i + rho_i sum_j F_ij B_j by Gaussian elimination with pivoting, one channel at a
/// time.
pub fn dense_solution(scene: &Scene, factors: &[Vec<f64>]) -> Vec<DVec3> {
    let count = scene.patch_count() as usize;
    let (reflectance, emission) = (scene.patch_reflectances(), scene.patch_emissions());
    let mut radiosity = vec![DVec3::ZERO; count];
    for channel in 0..3 {
        let mut system: Vec<Vec<f64>> = (0..count)
            .map(|i| {
                let rho = f64::from(reflectance[i][channel]);
                let mut row: Vec<f64> = factors[i].iter().map(|f| -rho * f).collect();
                row[i] += 1.0;
                row.push(f64::from(emission[i][channel]));
                row
            })
            .collect();
        for column in 0..count {
            let pivot = (column..count)
                .max_by(|&a, &b| system[a][column].abs().total_cmp(&system[b][column].abs()))
                .unwrap();
            system.swap(column, pivot);
            let (above, below) = system.split_at_mut(column + 1);
            let pivot = &above[column];
            for row in below {
                let factor = row[column] / pivot[column];
                for (value, &p) in row[column..].iter_mut().zip(&pivot[column..]) {
                    *value -= factor * p;
                }
            }
        }
        for i in (0..count).rev() {
            let known: f64 = (i + 1..count)
                .map(|j| system[i][j] * radiosity[j][channel])
                .sum();
            radiosity[i][channel] = (system[i][count] - known) / system[i][i];
        }
    }
    radiosity
}

/// The norm in which an iteration of the method shrinks what is wrong.
///
/// Gathering multiplies by rho F, whose rows sum to at most rho: the largest value of any patch and
/// channel, W/m^2. Shooting multiplies by rho_j F_ij A_i / A_j: all that leaves i sums to at most rho, so
/// the power, W. (The reciprocal factors' own row sums are another matter: a small patch in a corner
/// receives half too much or too little.)
pub fn norm(method: Method, scene: &Scene, values: impl Iterator<Item = DVec3>) -> f64 {
    if method == Method::Shooting {
        let powers = values
            .zip(scene.patch_areas())
            .map(|(v, area)| area * v.abs().element_sum());
        powers.sum()
    } else {
        values.fold(0.0, |most, v| f64::max(most, v.abs().max_element()))
    }
}

/// How far a is from b, as a share of b.
pub fn relative_difference(method: Method, scene: &Scene, a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    norm(method, scene, a.iter().zip(b).map(|(a, b)| *a - *b))
        / norm(method, scene, b.iter().copied())
}

pub fn radiosity(scene: &Scene, solution: &Solution) -> Vec<DVec3> {
    let radiosity = solution.radiosity(scene);
    radiosity.into_iter().map(Rgb::as_dvec3).collect()
}

pub fn largest_reflectance(scene: &Scene) -> f64 {
    let reflectances = scene.patch_reflectances();
    let most = reflectances.iter().map(|r| r.max_element());
    f64::from(most.fold(0.0_f32, f32::max))
}

/// How far a solution of a closed room may be from its equation's exact one, relative, in the method's
/// [`norm`].
///
/// With q the largest reflectance, an error of e left in the equation is one of at most e / (1 - q) in
/// the solution. Left over are, for gathering, q times the last change; for shooting, q times what is
/// unshot.
///
/// Gathering rounds each radiosity anew in each iteration. A shot rounds what each patch has received to
/// two f32s, which is not shot on, and what each has unshot, which is: twice, of unshot powers that the
/// residuals tell, at most 1 before the first shot. Taking over is a shot of each patch, and a difference of two
/// radiosities.
pub fn error_bound(
    scene: &Scene,
    method: Method,
    solver: &mut dyn Solver,
    rows: &mut RowCache,
) -> f64 {
    let before = solver.snapshot();
    let values = radiosity(scene, &before);
    let q = largest_reflectance(scene);
    if method == Method::Shooting {
        let State::Shooting { unshot, .. } = before.state else {
            panic!("shooting has a state of its own")
        };
        let unshot = unshot.into_iter().map(Rgb::as_dvec3);
        let left = norm(method, scene, unshot) / norm(method, scene, values.into_iter());
        let residuals = before.provenance.residuals;
        let shots = residuals.len() as f64 + f64::from(scene.patch_count());
        let unshot_powers = 1.0 + residuals.iter().sum::<f64>();
        let passed_on = q * left + (2.0 * unshot_powers + ROUNDINGS_PER_RADIOSITY) * ROUNDING;
        (ROUNDINGS_PER_RADIOSITY + shots * ROUNDING) * ROUNDING + passed_on / (1.0 - q)
    } else {
        iterate(solver, rows, 1);
        let after = radiosity(scene, &solver.snapshot());
        let change = relative_difference(method, scene, &values, &after);
        (q * change + ROUNDINGS_PER_RADIOSITY * ROUNDING) / (1.0 - q)
    }
}
