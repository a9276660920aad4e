//! Helpers shared by the tests across the programs.
//!
//! Cargo tells a test only the programs of its own package (`CARGO_BIN_EXE_*`), and these tests run
//! those of other packages. So the first use of [`program`] in a test binary runs `cargo build`, in the
//! profile and the target folder of the test itself, and takes the programs from there: they are never
//! older than the sources. It builds what `cargo test --workspace` builds, tests included, because with
//! less Cargo would choose other features of the libraries and build those again; so after that command
//! there is nothing left to build.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use glam::DVec3;
use tempfile::TempDir;

/// Where a program is. It is built if it is not.
///
/// # Panics
/// When it cannot be built.
pub fn program(name: &str) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER
        .get_or_init(build)
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
}

/// Builds the programs, and gives the folder they are in.
fn build() -> PathBuf {
    // target/PROFILE/deps/TEST
    let test = std::env::current_exe().unwrap();
    let folder = test.parent().and_then(Path::parent).unwrap();
    let profile = match folder.file_name().and_then(|name| name.to_str()).unwrap() {
        // The only profile whose folder has another name.
        "debug" => "dev",
        other => other,
    };
    let status = cargo()
        .args(["build", "--quiet", "--locked", "--profile", profile])
        .args(["--workspace", "--bins", "--tests"])
        .arg("--target-dir")
        .arg(folder.parent().unwrap())
        .status();
    assert!(status.unwrap().success(), "the programs cannot be built");
    folder.to_owned()
}

/// Cargo, in the workspace's folder.
pub fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(workspace());
    cargo
}

/// The workspace's folder.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// A file of the reference data, which `compute verify` has too.
pub fn data(name: &str) -> PathBuf {
    workspace().join("compute/src/verify/data").join(name)
}

/// A folder that is removed at the end of the test.
///
/// # Panics
/// When it cannot be made.
pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// Runs a program in a folder to its end, whatever that is.
///
/// # Panics
/// When it cannot be started.
pub fn output(folder: &TempDir, name: &str, arguments: &[&str]) -> Output {
    Command::new(program(name))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs a program in a folder, and gives what it has printed.
///
/// # Panics
/// When it does not end well.
#[track_caller]
pub fn run(folder: &TempDir, name: &str, arguments: &[&str]) -> String {
    let output = output(folder, name, arguments);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{name} {arguments:?}: {output:?}"
    );
    String::from_utf8(output.stdout).unwrap()
}

/// Whether the gpu back end finds an adapter, as `compute` tells it.
///
/// # Panics
/// When it finds one that it cannot use.
pub fn has_adapter() -> bool {
    let folder = folder();
    run(&folder, "genx", &["a.rad", "furnace", "--max-area", "inf"]);
    let output = output(
        &folder,
        "compute",
        &["a.rad", "b.rad", "2", "--backend", "gpu"],
    );
    let message = String::from_utf8_lossy(&output.stderr);
    let is_missing = message.contains("no GPU adapter");
    assert!(output.status.success() || is_missing, "{message}");
    !is_missing
}

/// One patch of `display --export FILE.csv`. Linear RGB, W/m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchRow {
    /// In the model's own coordinates, metres.
    pub centroid: DVec3,
    /// m^2.
    pub area: f64,
    /// Dimensionless.
    pub reflectance: DVec3,
    /// E.
    pub emission: DVec3,
    /// H.
    pub irradiance: DVec3,
    /// B.
    pub radiosity: DVec3,
}

/// All patches of a solved file, by way of `display`.
///
/// # Panics
/// When the table is not as it must be.
#[track_caller]
pub fn patches(folder: &TempDir, file: &str) -> Vec<PatchRow> {
    run(folder, "display", &[file, "--export", "patches.csv"]);
    let table = Table::read(&folder.path().join("patches.csv"));
    (0..table.rows.len())
        .map(|row| {
            let rgb = |name| table.rgb(row, name);
            PatchRow {
                centroid: DVec3::new(
                    table.number(row, "cx"),
                    table.number(row, "cy"),
                    table.number(row, "cz"),
                ),
                area: table.number(row, "area"),
                reflectance: rgb("rho"),
                emission: rgb("emission"),
                irradiance: rgb("irradiance"),
                radiosity: rgb("radiosity"),
            }
        })
        .collect()
}

/// A table of comma-separated values whose fields hold no commas.
#[derive(Clone, Debug)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a file.
    ///
    /// # Panics
    /// When it is no table.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines().map(fields);
        let header = lines.next().unwrap();
        let rows: Vec<Vec<String>> = lines.collect();
        for row in &rows {
            assert_eq!(row.len(), header.len(), "{row:?}");
        }
        Self { header, rows }
    }

    /// Rows below the header.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is nothing below the header.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// A field, by the name of its column.
    ///
    /// # Panics
    /// When there is none.
    fn field(&self, row: usize, column: &str) -> &str {
        let index = self.header.iter().position(|name| name == column);
        let index = index.unwrap_or_else(|| panic!("there is no column {column}"));
        &self.rows[row][index]
    }

    /// A text, by the name of its column.
    ///
    /// # Panics
    /// When there is none.
    pub fn text(&self, row: usize, column: &str) -> &str {
        self.field(row, column)
    }

    /// A number, by the name of its column.
    ///
    /// # Panics
    /// When there is none.
    pub fn number(&self, row: usize, column: &str) -> f64 {
        self.field(row, column).parse().unwrap()
    }

    /// The columns `NAME_r`, `NAME_g` and `NAME_b`, which are f32s.
    ///
    /// # Panics
    /// When one is missing or is no number.
    pub fn rgb(&self, row: usize, name: &str) -> DVec3 {
        let channels = ["r", "g", "b"].map(|c| format!("{name}_{c}"));
        // By way of f32: its shortest digits stand for another f64.
        let value = |column: String| -> f32 { self.field(row, &column).parse().unwrap() };
        DVec3::from(channels.map(|column| f64::from(value(column))))
    }
}

/// How far reflected radiosities are from others: area-weighted root mean square of rho (H - H'), over
/// that of rho H', all patches and channels. Emission is left out; lamps would flatter every result.
pub fn reflected_error(
    patches: &[PatchRow],
    irradiance: impl Fn(usize) -> DVec3,
    reference: impl Fn(usize) -> DVec3,
) -> f64 {
    let (mut error, mut size) = (0.0, 0.0);
    for (i, patch) in patches.iter().enumerate() {
        let expected = reference(i);
        let difference = irradiance(i) - expected;
        error += patch.area * (patch.reflectance * difference).length_squared();
        size += patch.area * (patch.reflectance * expected).length_squared();
    }
    (error / size).sqrt()
}
