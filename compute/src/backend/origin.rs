//! Where the rows of a solution come from.

use std::fmt;
use std::str::FromStr;

use scene::{Recorded, RecordedSettings};

use crate::rows::RowSource;
use crate::settings::BackendChoice;

/// Who draws hemicubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawer {
    /// The CPU.
    Cpu,
    /// A wgpu adapter.
    Gpu,
}

/// Where the rows of a solution come from: the same rows come from there again. A file has it beside the settings, in
/// their words: `cpu`, `gpu`, `formulas`, or `formulas+cpu` where coarser sources had formulas and finer ones not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RowOrigin {
    /// Whether they are formulas where they can be, see [`crate::convex`].
    pub has_formulas: bool,
    /// Who has drawn the others; `None` where there were none.
    pub drawer: Option<Drawer>,
}

/// All that a file can say.
const NAMES: [(&str, RowOrigin); 5] = [
    ("cpu", RowOrigin::new(false, Some(Drawer::Cpu))),
    ("gpu", RowOrigin::new(false, Some(Drawer::Gpu))),
    ("formulas", RowOrigin::new(true, None)),
    ("formulas+cpu", RowOrigin::new(true, Some(Drawer::Cpu))),
    ("formulas+gpu", RowOrigin::new(true, Some(Drawer::Gpu))),
];

impl RowOrigin {
    /// The name that it has among the settings of a file.
    pub const SETTING: &str = "backend";

    const fn new(has_formulas: bool, drawer: Option<Drawer>) -> Self {
        Self {
            has_formulas,
            drawer,
        }
    }

    /// What was asked for; `None` where that is open.
    pub fn asked_for(choice: BackendChoice) -> Option<Self> {
        match choice {
            BackendChoice::Auto => None,
            BackendChoice::Cpu => Some(Self::new(false, Some(Drawer::Cpu))),
            BackendChoice::Gpu => Some(Self::new(false, Some(Drawer::Gpu))),
        }
    }

    /// That of the rows that somebody makes.
    pub fn of(source: &dyn RowSource) -> Self {
        match (source.draws_hemicubes(), source.backend()) {
            (false, _) => Self::new(true, None),
            (true, "gpu") => Self::new(false, Some(Drawer::Gpu)),
            (true, _) => Self::new(false, Some(Drawer::Cpu)),
        }
    }

    /// That of these rows and others.
    #[must_use]
    pub fn and(self, others: Self) -> Self {
        Self {
            has_formulas: self.has_formulas || others.has_formulas,
            drawer: others.drawer.or(self.drawer),
        }
    }

    /// What a file says; `None` where it does not, as files of older versions.
    pub fn recorded_in(settings: &RecordedSettings) -> Option<Self> {
        match settings.get(Self::SETTING) {
            Recorded(Some(value)) => value.as_str()?.parse().ok(),
            Recorded(None) => None,
        }
    }

    /// Writes it beside the settings.
    pub fn record_in(self, settings: &mut RecordedSettings) {
        settings.set(Self::SETTING, self.to_string());
    }
}

impl fmt::Display for RowOrigin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = NAMES.iter().find(|(_, origin)| origin == self);
        f.write_str(name.map_or("unset", |(name, _)| name))
    }
}

impl FromStr for RowOrigin {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let name = NAMES.iter().find(|(name, _)| *name == text);
        name.map(|(_, origin)| *origin)
            .ok_or_else(|| format!("\"{text}\" is no back end"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn formulas_and_a_back_end_are_both_remembered() {
        let origin = |name: &str| name.parse::<RowOrigin>().unwrap();
        for (before, more, both) in [
            ("formulas", "gpu", "formulas+gpu"),
            ("formulas+cpu", "formulas", "formulas+cpu"),
            ("cpu", "cpu", "cpu"),
        ] {
            assert_eq!(origin(before).and(origin(more)), origin(both));
        }
        assert_eq!(RowOrigin::default().and(origin("cpu")), origin("cpu"));
    }

    #[test]
    fn what_is_recorded_reads_back() {
        for (name, origin) in NAMES {
            let mut settings = RecordedSettings::new(&json!({"points": "auto"}));
            assert_eq!(RowOrigin::recorded_in(&settings), None);
            origin.record_in(&mut settings);
            assert_eq!(RowOrigin::recorded_in(&settings), Some(origin));
            assert_eq!(origin.to_string(), name);
        }
        for unknown in [json!("npu"), json!(3), json!(null)] {
            let settings = RecordedSettings::new(&json!({"backend": unknown}));
            assert_eq!(RowOrigin::recorded_in(&settings), None);
        }
    }
}
