//! What is tried.

/// Options of a run, and what they show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Variant {
    /// What is varied.
    pub knob: &'static str,
    /// The command line after IN and OUT.
    pub options: &'static str,
}

/// By what is varied: qualities, then single knobs of one or the other.
const GRID: [(&str, &[&str]); 9] = [
    (
        "quality",
        &[
            "--quality draft",
            "--quality standard",
            "--quality high",
            "--quality reference",
            "--quality mesh",
            "--quality thesis",
        ],
    ),
    (
        "resolution where vertices gather",
        &[
            "8 --quality standard",
            "16 --quality standard",
            "24 --quality standard",
            "48 --quality standard",
            "64 --quality standard",
            "128 --quality standard",
        ],
    ),
    (
        "resolution by patches",
        &[
            "26 --quality mesh --points centroid",
            "50 --quality mesh --points centroid",
            "100 --quality mesh --points centroid",
            "200 --quality mesh --points centroid",
            "400 --quality mesh --points centroid",
            "800 --quality mesh --points centroid",
        ],
    ),
    (
        "points",
        &[
            "--quality mesh --points centroid",
            "--quality mesh --points vertices",
            "--quality mesh --points 3",
            "--quality mesh --points 4",
            "64 --quality mesh --points 4",
        ],
    ),
    (
        "multipliers",
        &[
            "--quality mesh --points centroid --seed aligned --lamps off",
            "--quality mesh --points centroid --seed aligned --lamps off --maps thesis",
        ],
    ),
    (
        "lamps",
        &[
            "--quality standard --lamps off",
            "--quality mesh --points centroid --lamps off",
        ],
    ),
    (
        "solver",
        &[
            "--quality mesh --points centroid --solver jacobi",
            "--quality mesh --points centroid --solver gauss-seidel",
            "--quality mesh --points centroid --solver shooting",
        ],
    ),
    ("levels", &["--quality standard --source-area patches"]),
    (
        "error asked for",
        &[
            "--target-error 8%",
            "--target-error 4%",
            "--target-error 2%",
            "--target-error 1%",
            "--target-error 0.5%",
        ],
    ),
];

/// All of it.
pub(super) fn variants() -> impl Iterator<Item = Variant> {
    GRID.iter()
        .flat_map(|&(knob, all)| all.iter().map(move |&options| Variant { knob, options }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::cli::solve_settings;

    #[test]
    fn all_can_be_asked_for() {
        for variant in variants() {
            solve_settings(variant.options).unwrap();
        }
    }
}
