//! Any number of threads.

use scene::Solution;

use super::all_rows;
use crate::common::methods::{METHODS, iterate, rows, solver};
use crate::common::{self, bits};

/// Rows are integers, and each sum of radiosities runs over a row in patch order: threads change not a
/// bit of form factors or radiosities, whether there are more of them than cores or not.
#[test]
fn one_to_sixteen_threads_give_the_same_bits() {
    let scene = common::colourful_room(0.3);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| {
            let solutions = METHODS.map(|method| {
                let mut rows = rows(&scene, u64::MAX);
                let mut solver = solver(method, &scene, Solution::dark(&scene));
                iterate(solver.as_mut(), &mut rows, 5);
                let solution = solver.snapshot();
                (bits(&solution.irradiance), solution.provenance.residuals)
            });
            (all_rows(&scene, 40), solutions)
        })
    };
    let one = run(1);
    for threads in 2..=16 {
        let many = run(threads);
        assert!(many.0 == one.0, "rows of {threads} threads");
        assert!(many.1 == one.1, "solutions of {threads} threads");
    }
}
