//! Tables of sensors (RFC 4180): read with every line checked, and written with columns added.

use std::collections::HashSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use csv::StringRecord;
use glam::DVec3;
use scene::{MAX_PATCHES, Scene};

use crate::gather::Received;
use crate::receivers::Sensor;

/// The columns that a table must have, in the model's own coordinates, and a direction of any length.
const NEEDED: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

/// The columns that are added.
const ADDED: [&str; 8] = [
    "irradiance_r",
    "irradiance_g",
    "irradiance_b",
    "direct_r",
    "direct_g",
    "direct_b",
    "openings",
    "back_faces",
];

/// Why a table could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct TableError {
    /// The file.
    path: PathBuf,
    /// What is wrong with it.
    fault: TableFault,
}

/// What can be wrong with a table.
#[derive(Debug, thiserror::Error)]
enum TableFault {
    #[error("cannot be read as CSV: {0}")]
    Csv(#[from] csv::Error),
    #[error("there is no column \"{missing}\"; its columns are: {}; sensors need {}", found.join(", "), NEEDED.join(", "))]
    Missing {
        missing: &'static str,
        found: Vec<String>,
    },
    #[error("column \"{name}\" is there more than once")]
    Twice { name: &'static str },
    #[error("there are no sensors below the line of names")]
    Empty,
    #[error("line {line}: {fields} fields, the line of names has {columns}")]
    Fields {
        line: usize,
        fields: usize,
        columns: usize,
    },
    #[error("line {line}: {name} is \"{value}\", which is no finite number")]
    Number {
        line: usize,
        name: &'static str,
        value: String,
    },
    #[error("line {line}: the normal is 0 0 0; give the direction that the sensor faces")]
    Normal { line: usize },
    #[error("line {line}: more sensors than {MAX_PATCHES}; cut the table into several")]
    TooMany { line: usize },
}

/// A table of sensors.
#[derive(Debug)]
pub struct Table {
    names: StringRecord,
    rows: Vec<StringRecord>,
    /// One per row, relative to the scene's origin.
    sensors: Vec<Sensor>,
}

impl Table {
    /// Reads a table for a scene.
    pub fn read(path: &Path, scene: &Scene) -> Result<Self, TableError> {
        let fail = |fault| TableError {
            path: path.to_owned(),
            fault,
        };
        let bytes = std::fs::read(path).map_err(|error| fail(csv::Error::from(error).into()))?;
        Self::parse(&bytes, scene).map_err(fail)
    }

    fn parse(bytes: &[u8], scene: &Scene) -> Result<Self, TableFault> {
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(bytes);
        let names = reader.headers()?.clone();
        let mut columns = [0; 6];
        for (column, name) in columns.iter_mut().zip(NEEDED) {
            let mut places = (0..names.len()).filter(|&k| &names[k] == name);
            *column = places.next().ok_or_else(|| TableFault::Missing {
                missing: name,
                found: names.iter().map(str::to_owned).collect(),
            })?;
            if places.next().is_some() {
                return Err(TableFault::Twice { name });
            }
        }
        let mut table = Self {
            names,
            rows: Vec::new(),
            sensors: Vec::new(),
        };
        for row in reader.records() {
            let row = row?;
            let line = || line_of(bytes, &row);
            if table.rows.len() == MAX_PATCHES as usize {
                return Err(TableFault::TooMany { line: line() });
            }
            if row.len() != table.names.len() {
                return Err(TableFault::Fields {
                    line: line(),
                    fields: row.len(),
                    columns: table.names.len(),
                });
            }
            let mut values = [0.0; 6];
            for ((value, name), column) in values.iter_mut().zip(NEEDED).zip(columns) {
                let text = &row[column];
                *value = text
                    .parse()
                    .ok()
                    .filter(|value: &f64| value.is_finite())
                    .ok_or_else(|| TableFault::Number {
                        line: line(),
                        name,
                        value: text.to_owned(),
                    })?;
            }
            let [x, y, z, nx, ny, nz] = values;
            // Directions of any length, the longest and the shortest too.
            let normal = DVec3::new(nx, ny, nz);
            let normal = normal / normal.abs().max_element();
            let normal = normal
                .try_normalize()
                .ok_or_else(|| TableFault::Normal { line: line() })?;
            table.sensors.push(Sensor {
                position: scene.to_scene(DVec3::new(x, y, z)),
                normal,
            });
            table.rows.push(row);
        }
        if table.rows.is_empty() {
            return Err(TableFault::Empty);
        }
        Ok(table)
    }

    /// One per row.
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// Writes the table with what each sensor has received. Numbers have the digits that lead back to the same f32.
    pub fn write(&self, out: &mut dyn Write, received: &[Received]) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        let names = self.output_names();
        writer.write_record(names.iter().map(String::as_str).chain(ADDED))?;
        for (row, received) in self.rows.iter().zip(received) {
            let Received {
                irradiance,
                direct,
                openings,
                back_faces,
            } = received;
            let [h, d] = [irradiance.to_array(), direct.to_array()];
            let shares = [*openings as f32, *back_faces as f32];
            let added = h.into_iter().chain(d).chain(shares);
            for field in row {
                writer.write_field(field)?;
            }
            for value in added {
                writer.write_field(value.to_string())?;
            }
            writer.write_record(None::<&[u8]>)?;
        }
        writer.flush()
    }

    /// The names of the table's own columns; those that clash with added ones begin with `in_`.
    fn output_names(&self) -> Vec<String> {
        let mut taken: HashSet<String> = ADDED.map(str::to_owned).into();
        taken.extend(
            self.names
                .iter()
                .filter(|name| !ADDED.contains(name))
                .map(str::to_owned),
        );
        self.names
            .iter()
            .map(|name| {
                if !ADDED.contains(&name) {
                    return name.to_owned();
                }
                let mut other = format!("in_{name}");
                while !taken.insert(other.clone()) {
                    other.insert_str(0, "in_");
                }
                other
            })
            .collect()
    }
}

/// The line in which a row begins, counted from 1: where the reader has found it, behind empty lines.
fn line_of(bytes: &[u8], row: &StringRecord) -> usize {
    let start = row.position().map_or(0, |at| at.byte() as usize);
    let is_break = |byte: &&u8| matches!(byte, b'\r' | b'\n');
    let breaks = bytes[start.min(bytes.len())..].iter().take_while(is_break);
    let before = &bytes[..(start + breaks.count()).min(bytes.len())];
    before.split(|&byte| byte == b'\n').count()
}
