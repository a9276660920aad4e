//! What is said of a function.

use std::fmt::Write as _;

use scene::{ObjectId, Scene};
use serde::Serialize;

use crate::settings::Target;

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
    /// Estimates of its error, by cause; null where light reaches nothing, and after too few iterations.
    pub error: Option<ErrorByCause>,
    /// Points at which patches have gathered, where it is their means that an error is asked of, and there are no vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<u64>,
    /// Whether that is as small as was asked for.
    pub is_reached: bool,
    /// Why there are no more vertices.
    pub stopped_by: FunctionEnd,
    /// The cause that has most of the error, of the power error where that is asked for; left out where it is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mostly_by: Option<Cause>,
    /// The object that has most of the estimated error; null where there is none.
    #[serde(skip)]
    pub mostly_on: Option<ObjectId>,
}

/// Why a function has no more vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FunctionEnd {
    /// Its error is as small as was asked for.
    Error,
    /// It has as many as it may.
    Vertices,
    /// The time was over.
    TimeLimit,
    /// Somebody stopped it: it is as it was when its error was measured last.
    Interrupt,
    /// More of them would not bring it there.
    OtherCauses,
}

/// What makes a function wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// That it is linear between vertices, and one value a patch elsewhere.
    Mesh,
    /// That sources are as large as they are.
    Sources,
    /// That hemicubes have pixels.
    Pixels,
    /// That the iteration came to an end.
    Iterations,
    /// That patches' means are taken at few points, by hemicubes of few pixels.
    Sampling,
}

impl Cause {
    fn describe(self) -> &'static str {
        match self {
            Self::Mesh => "the mesh",
            Self::Sources => "the size of sources",
            Self::Pixels => "pixels",
            Self::Iterations => "iterations",
            Self::Sampling => "points and pixels",
        }
    }
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
    /// Of patches' means: that they are taken at few points, by hemicubes of few pixels.
    pub sampling: Errors,
}

impl ErrorByCause {
    /// The causes, each once.
    fn causes(&self) -> [(Errors, Cause); 5] {
        [
            (self.mesh, Cause::Mesh),
            (self.sources, Cause::Sources),
            (self.pixels, Cause::Pixels),
            (self.iterations, Cause::Iterations),
            (self.sampling, Cause::Sampling),
        ]
    }

    /// The same with the total of the causes: such as know nothing of each other add up in squares.
    #[must_use]
    pub(super) fn added_up(self) -> Self {
        let total = |of: fn(&Errors) -> f64| {
            let squares = self.causes().map(|(cause, _)| of(&cause).powi(2));
            squares.iter().sum::<f64>().sqrt()
        };
        Self {
            total: Errors {
                power: total(|errors| errors.power),
                visible: total(|errors| errors.visible),
            },
            ..self
        }
    }

    /// The cause that has most of the error, of that which is asked for.
    pub(super) fn worst(&self, target: &Target) -> Cause {
        let size = |error: Errors| match target.power {
            Some(_) => error.power,
            None => error.visible,
        };
        // Of equal ones the first.
        let causes = self.causes().into_iter().rev();
        let worst = causes.max_by(|(a, _), (b, _)| size(*a).total_cmp(&size(*b)));
        worst.map_or(Cause::Mesh, |(_, cause)| cause)
    }
}

impl FunctionReport {
    /// A line for people about the function of this scene.
    pub fn describe(&self, scene: &Scene) -> String {
        let Some(error) = &self.error else {
            return if self.checks > 0 {
                format!(
                    "unknown, since so few iterations do not tell what is left; {}",
                    self.places()
                )
            } else {
                "none: light reaches nothing that reflects it".into()
            };
        };
        let Errors { power, visible } = error.total;
        let mut line = format!(
            "{:.2} % power, {:.2} % visible",
            100.0 * power,
            100.0 * visible
        );
        if let Some(cause) = self.mostly_by {
            write!(line, ", mostly by {}", cause.describe()).ok();
        }
        if let Some(object) = self.mostly_on {
            write!(line, ", on \"{}\"", scene.object(object)).ok();
        }
        write!(line, "; {}", self.places()).ok();
        if self.covered < MOSTLY {
            write!(line, " on {:.0} % of the area", 100.0 * self.covered).ok();
        }
        line += match self.stopped_by {
            FunctionEnd::Error => "",
            FunctionEnd::Vertices => {
                "; more than was asked for, which takes more vertices than there may be"
            }
            FunctionEnd::TimeLimit => "; more than was asked for, stopped by --time-limit",
            FunctionEnd::Interrupt => "; interrupted before it was what was asked for",
            FunctionEnd::OtherCauses => {
                "; more than was asked for, and more of them would not help"
            }
        };
        line
    }

    /// How many there are of what has gathered.
    fn places(&self) -> String {
        match self.points {
            Some(points) => format!("{points} points of patches"),
            None => format!("{} vertices", self.vertices),
        }
    }
}

/// The object on which patches have most of the error that is estimated of them, W/m^2.
pub(super) fn worst_object(scene: &Scene, error: &[f32]) -> Option<ObjectId> {
    let mut of_object = vec![0.0; scene.objects().len()];
    for (surface, tree) in scene.surfaces().iter().zip(scene.mesh().trees()) {
        let area = surface.area() / f64::from(1_u32 << tree.depth);
        let squares = tree
            .patches()
            .map(|patch| f64::from(error[patch as usize]).powi(2));
        of_object[surface.object.index()] += area * squares.sum::<f64>();
    }
    let worst = (0..).map(ObjectId).zip(of_object);
    let worst = worst.max_by(|(_, a), (_, b)| a.total_cmp(b));
    worst
        .filter(|&(_, error)| error > 0.0)
        .map(|(object, _)| object)
}

/// The share of the area that has vertices from which on nothing is said of the rest.
const MOSTLY: f64 = 0.95;
