//! One case: a scene, what is measured in it, what must come out, and how far off it may be.

use super::shapes::SceneBuilder;

/// A case of the bank.
#[derive(Clone, Debug)]
pub struct Case {
    /// Unique among the cases.
    pub name: String,
    /// What is measured, for people.
    pub quantity: String,
    /// What is measured, for the program.
    pub measure: Measure,
    /// The value that is right.
    pub expected: Expected,
    /// Where that value comes from.
    pub source: String,
    /// How far off it may be.
    pub tolerance: Tolerance,
    /// The scene it is measured in.
    pub scene: SceneBuilder,
}

/// The right value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// Known beforehand, in the quantity's unit.
    Value(f64),
    /// Of the patch and channel that is farthest from the dense solution, that solution.
    DenseSolution,
}

impl Expected {
    /// The value; 0 where it is not known beforehand.
    pub fn value(self) -> f64 {
        match self {
            Self::Value(value) => value,
            Self::DenseSolution => 0.0,
        }
    }
}

/// What is measured. Names are those of the scene's objects.
#[derive(Clone, Debug, PartialEq)]
pub enum Measure {
    /// Area-weighted form factor between two objects, from the rows of the first, dimensionless.
    FormFactor {
        /// Whose rows are drawn.
        from: &'static str,
        /// Whose patches are looked for in them.
        to: &'static str,
    },
    /// Mean irradiance of an object, W/m^2, where everything else is dark but for one that emits
    /// 1 W/m^2: the form factor again, but as it is used.
    Irradiance {
        /// The receiver.
        of: &'static str,
    },
    /// The row sum that is farthest from 1, dimensionless.
    Closure,
    /// The radiosity that is farthest from the expected one, W/m^2, first channel.
    Radiosity,
    /// How far the reflected radiosities are from a reference's, dimensionless.
    Reflected {
        /// Name of the scene, which several cases share.
        room: &'static str,
        /// Irradiance, W/m^2, one per patch.
        reference: Vec<scene::Rgb>,
        /// What is made of the departures.
        statistic: super::path_tracer::Statistic,
    },
    /// The radiosity, W/m^2, that is farthest from a dense linear solve of the same rows.
    DenseSolve {
        /// The solver that is held against it.
        solver: crate::settings::SolverChoice,
    },
}

/// How far off a result may be at default settings, and why that far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative to the expected value; absolute where that is 0. Dimensionless.
    pub relative: f64,
    /// The errors it covers.
    pub reason: &'static str,
}

/// Patches that the shape whose rows are drawn is cut into, at least. With 128, the noise of the
/// pixels, some 0.2 percent in one hemicube of 128 pixels, averages out to 0.02 percent.
pub const PATCHES: u32 = 128;

/// Polygons in full view.
pub const UNOCCLUDED: Tolerance = Tolerance {
    relative: 1e-3,
    reason: "pixels 0.02 % (0.2 % a hemicube, 128 patches), the rest for points that stand for areas",
};

/// A receiver of the size of a point has one hemicube only: a target in full view has to be exact.
pub const POINT: Tolerance = Tolerance {
    relative: 1e-3,
    reason: "one point: the target's outline, cut by pixels",
};

/// The same between tessellated shapes.
pub const TESSELLATED: Tolerance = Tolerance {
    relative: 1e-3 + super::shapes::TESSELLATION,
    reason: "as in full view, and 0.05 % for curved shapes made of triangles",
};

/// What stands between casts shadows whose edges cross patches and pixels.
pub const OCCLUDED: Tolerance = Tolerance {
    relative: 5e-3,
    reason: "edges of shadows across patches and pixels",
};

/// Two hemicubes a wall, one on each of its triangles.
pub const COARSE: Tolerance = Tolerance {
    relative: 5e-3,
    reason: "pixels 0.15 % (two patches), the rest for points that stand for areas",
};

/// Nothing can be seen through a wall.
pub const NOTHING: Tolerance = Tolerance {
    relative: 0.0,
    reason: "exact: integers are summed",
};

/// Integers are summed, so a closed room has nothing to round.
pub const CLOSED: Tolerance = Tolerance {
    relative: 1e-6,
    reason: "no ray may leave a closed room; 4000 of 2^32 units",
};

/// What a solver may differ from a dense solve by.
pub const SOLVED: Tolerance = Tolerance {
    relative: 1e-5,
    reason: "solved to a residual of 1e-7, stored as f32; reflectance at most 0.75 amplifies by 4",
};

/// The same for shooting, which adds up what arrives in some thousand shots as f32.
pub const SHOT: Tolerance = Tolerance {
    relative: 1e-4,
    reason: "sums of thousands of shots, stored as f32",
};

/// Of a furnace: closure and the solver's residual, both 1e-6, grow by 1 / (1 - rho).
pub fn furnace(reflectance: f64) -> Tolerance {
    Tolerance {
        relative: 2e-6 / (1.0 - reflectance),
        reason: "closure 1e-6 and residual 1e-6, amplified by 1 / (1 - rho)",
    }
}
