//! The command line of `compute verify`, turned into [`verify::Settings`].

use clap::Args;

use super::choice;
use super::form_factors::FormFactorArguments;
use crate::settings::FormFactorSettings;
use crate::verify::{Backends, Format, Settings, VerifyError, select};

/// Show how far this program is from answers that are known, case by case
///
/// Measures a bank of cases: form factors in closed form, closed rooms, furnaces, solvers against a
/// dense linear solve. Prints a line a case: name, quantity, expected value and its source, computed
/// value, relative error (absolute where 0 is expected), tolerance, verdict. Tolerances are those of
/// the default settings. Exit codes: 0 all cases hold, 1 some case misses, 2 wrong usage.
#[derive(Debug, Args)]
pub(super) struct VerifyArguments {
    #[command(flatten)]
    form_factors: FormFactorArguments,
    /// Who draws: auto (as in a run by default), cpu, gpu (software ones too), or all of these
    #[arg(long, default_value = "auto", value_parser = choice(&[
        ("auto", Backends::Auto), ("cpu", Backends::Cpu), ("gpu", Backends::Gpu), ("all", Backends::All)]))]
    backend: Backends,
    /// Only the case of this name, or those with this in their names
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    /// Write JSON: an array with one object a case
    #[arg(long, conflicts_with = "markdown")]
    json: bool,
    /// Write the document on accuracy: all cases, the thesis's multipliers, error against resolution
    /// and points
    #[arg(long)]
    markdown: bool,
}

impl VerifyArguments {
    /// What is asked for; a pattern that fits no case is an error.
    pub fn settings(self) -> Result<Settings, VerifyError> {
        select(self.case.as_deref())?;
        Ok(Settings {
            form_factors: self.form_factors.settings(FormFactorSettings::default()),
            backends: self.backend,
            case: self.case,
            format: match (self.json, self.markdown) {
                (true, _) => Format::Json,
                (_, true) => Format::Markdown,
                _ => Format::Text,
            },
        })
    }
}
