//! What is said of a function.

use serde::Serialize;

/// Two errors of a function, relative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// What is wrong, over what is right, root mean square over the area.
    pub power: f64,
    /// The same of what is wrong over what is right in each place.
    pub visible: f64,
}

impl Errors {
    /// Both the same.
    pub(super) fn splat(error: f64) -> Self {
        Self {
            power: error,
            visible: error,
        }
    }
}

/// What a function came to.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FunctionReport {
    /// How many vertices it has.
    pub vertices: u32,
    /// How many triangles.
    pub triangles: u32,
    /// Share of the scene's area that has vertices; the rest has what its patches have.
    pub covered: f64,
    /// Points at which it was checked.
    pub checks: u32,
    /// Estimates of its error, by cause; null where light reaches nothing.
    pub error: Option<ErrorByCause>,
    /// Whether that is as small as was asked for.
    pub is_reached: bool,
}

/// What makes a function wrong, as far as is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorByCause {
    /// All causes together.
    pub total: Errors,
    /// That it is linear between vertices, and one value a patch elsewhere.
    pub mesh: Errors,
    /// That sources are as large as they are.
    pub sources: Errors,
    /// That hemicubes have pixels.
    pub pixels: Errors,
    /// That the iteration came to an end.
    pub iterations: Errors,
}

impl ErrorByCause {
    /// Causes that know nothing of each other add up in squares.
    pub(super) fn new(mesh: Errors, sources: Errors, pixels: Errors, iterations: Errors) -> Self {
        let total = |of: fn(&Errors) -> f64| {
            let causes = [mesh, sources, pixels, iterations];
            causes
                .iter()
                .map(|cause| of(cause).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        Self {
            total: Errors {
                power: total(|errors| errors.power),
                visible: total(|errors| errors.visible),
            },
            mesh,
            sources,
            pixels,
            iterations,
        }
    }

    /// The cause that has most of the power error.
    fn worst(&self) -> &'static str {
        let causes = [
            (self.mesh, "the mesh"),
            (self.sources, "the size of patches"),
            (self.pixels, "pixels"),
            (self.iterations, "iterations"),
        ];
        let worst = causes
            .iter()
            .max_by(|(a, _), (b, _)| a.power.total_cmp(&b.power));
        worst.map_or("", |(_, name)| name)
    }
}

impl std::fmt::Display for FunctionReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(error) = &self.error else {
            return f.write_str("none: light reaches nothing that reflects it");
        };
        let Errors { power, visible } = error.total;
        write!(
            f,
            "{:.2} % power, {:.2} % visible, mostly by {}; {} vertices",
            100.0 * power,
            100.0 * visible,
            error.worst(),
            self.vertices
        )?;
        if self.covered < MOSTLY {
            write!(f, " on {:.0} % of the area", 100.0 * self.covered)?;
        }
        if !self.is_reached {
            f.write_str("; more than was asked for")?;
        }
        Ok(())
    }
}

/// The share of the area that has vertices from which on nothing is said of the rest.
const MOSTLY: f64 = 0.95;
