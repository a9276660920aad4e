//! The table of a study.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::Context;
use scene::file::write_atomically;
use serde::{Deserialize, Serialize};

use super::grid::Variant;

/// One run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Row {
    /// The scene's name.
    pub scene: String,
    /// What is varied.
    pub knob: String,
    /// The command line after IN and OUT.
    pub options: String,
    /// Of the scene.
    pub patches: u32,
    /// Wall clock, without files.
    pub seconds: f64,
    /// Of these, hemicubes of sources and patches.
    pub drawing_seconds: f64,
    /// Those of sources and patches.
    pub hemicubes: u64,
    /// What was solved among, if not among patches.
    pub sources: Option<u32>,
    /// Where the function has gathered, if there is one.
    pub vertices: Option<u32>,
    /// What the run says of its errors, relative.
    pub stated_power: Option<f64>,
    pub stated_visible: Option<f64>,
    /// Against the reference, relative.
    pub power: Option<f64>,
    pub visible: Option<f64>,
    /// The scene whose reference that is.
    pub reference: String,
    /// Whether the time limit has ended it.
    pub is_late: bool,
}

/// A run, and whether no faster one of its scene is less wrong.
#[derive(Clone, Debug, Serialize)]
pub(super) struct WithFront<'r> {
    #[serde(flatten)]
    pub row: &'r Row,
    /// By the power error.
    pub is_on_power_front: bool,
    /// By the visible error.
    pub is_on_visible_front: bool,
}

/// All runs so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Table {
    rows: Vec<Row>,
}

impl Table {
    /// What an earlier run of the study has left, if anything.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        if !path.exists() {
            return Ok(Self::default());
        }
        let not_a_table = || format!("{} is no table of a study", path.display());
        let mut reader = csv::Reader::from_path(path).with_context(not_a_table)?;
        let rows: Result<Vec<Row>, csv::Error> = reader.deserialize().collect();
        Ok(Self {
            rows: rows.with_context(not_a_table)?,
        })
    }

    /// Writes all rows.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.serialize(row)?;
        }
        let bytes = writer.into_inner()?;
        Ok(write_atomically(path, |out| out.write_all(&bytes))?)
    }

    /// Adds a run.
    pub fn push(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// Whether there is this one.
    pub fn has(&self, scene: &str, variant: Variant) -> bool {
        let is_it = |row: &Row| {
            row.scene == scene && row.knob == variant.knob && row.options == variant.options
        };
        self.rows.iter().any(is_it)
    }

    /// The scenes' names, each once.
    pub fn scenes(&self) -> Vec<String> {
        let mut scenes: Vec<String> = Vec::new();
        for row in &self.rows {
            if !scenes.contains(&row.scene) {
                scenes.push(row.scene.clone());
            }
        }
        scenes
    }

    /// The rows of a scene.
    pub fn of_scene<'t>(&'t self, scene: &'t str) -> impl Iterator<Item = &'t Row> + Clone {
        self.rows.iter().filter(move |row| row.scene == scene)
    }

    /// Whether no run of the scene is both faster and less wrong.
    pub fn is_on_front(&self, row: &Row, error: fn(&Row) -> Option<f64>) -> bool {
        let Some(own) = error(row) else {
            return false;
        };
        let mut others = self.of_scene(&row.scene);
        !others.any(|other| {
            other.seconds < row.seconds && error(other).is_some_and(|other| other <= own)
        })
    }

    /// All rows with what they are among others.
    pub fn rows_with_front(&self) -> Vec<WithFront<'_>> {
        let rows = self.rows.iter();
        rows.map(|row| WithFront {
            row,
            is_on_power_front: self.is_on_front(row, |row| row.power),
            is_on_visible_front: self.is_on_front(row, |row| row.visible),
        })
        .collect()
    }

    /// For people: a line a run; an asterisk where no faster one is less wrong.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for scene in self.scenes() {
            writeln!(text, "{scene}").ok();
            writeln!(
                text,
                "  {:>9} {:>17} {:>17}  options",
                "seconds", "power error", "visible error"
            )
            .ok();
            for row in self.of_scene(&scene) {
                let shown = |error: fn(&Row) -> Option<f64>| {
                    let front = if self.is_on_front(row, error) {
                        "*"
                    } else {
                        " "
                    };
                    let percent = error(row).map(|error| format!("{:.2} %", 100.0 * error));
                    format!("{} {front}", percent.unwrap_or_default())
                };
                writeln!(
                    text,
                    "  {:>9.2} {:>17} {:>17}  {}",
                    row.seconds,
                    shown(|row| row.power),
                    shown(|row| row.visible),
                    row.options
                )
                .ok();
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(seconds: f64, power: f64) -> Row {
        Row {
            scene: "a".into(),
            seconds,
            power: Some(power),
            ..Row::default()
        }
    }

    #[test]
    fn the_front_is_what_nothing_faster_beats() {
        let table = Table {
            rows: vec![
                row(1.0, 0.05),
                row(2.0, 0.06),
                row(3.0, 0.01),
                row(4.0, 0.01),
            ],
        };
        let fronts = table.rows_with_front();
        let fronts: Vec<bool> = fronts.iter().map(|row| row.is_on_power_front).collect();
        assert_eq!(fronts, [true, false, true, false]);
    }

    #[test]
    fn a_table_reads_back_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("study.csv");
        let mut table = Table::read(&path).unwrap();
        table.push(row(1.5, 0.25));
        table.write(&path).unwrap();
        let read = Table::read(&path).unwrap();
        assert_eq!(format!("{:?}", read.rows), format!("{:?}", table.rows));
        std::fs::write(&path, "a,b\n1,2\n").unwrap();
        let message = format!("{:#}", Table::read(&path).unwrap_err());
        assert!(message.contains("is no table of a study"), "{message}");
    }
}
