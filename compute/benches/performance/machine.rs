//! What it is measured on, as far as the system tells.

use std::fs;
use std::path::Path;
use std::process::Command;

use compute::quantity::show_size;

use crate::arguments::{Section, command_of};
use crate::text::{heading, table};

/// The section.
pub fn section() -> String {
    let facts: Vec<Vec<String>> = [
        ("processor", cpu_field("model name")),
        ("cores", Some(cores().to_string())),
        ("last cache", last_cache()),
        ("memory", memory()),
        ("system", system()),
        ("load before", load()),
        ("compiler", output("rustc", &["--version"])),
        (
            "program",
            Some(format!("compute {}", env!("CARGO_PKG_VERSION"))),
        ),
        ("commit", commit()),
    ]
    .into_iter()
    .filter_map(|(name, value)| Some(vec![name.to_owned(), value?]))
    .collect();
    format!(
        "{}All numbers below are from this machine ({}). The load is the mean number of busy threads in the \
         minute before: above 0 others were at work too, and times are too long by what they took.\n\n{}",
        heading("Machine"),
        command_of(Section::Machine),
        table(&["", ""], 2, &facts)
    )
}

/// Threads that run at once.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The value of a line `name: value`.
fn field(text: &str, name: &str) -> Option<String> {
    text.lines().find_map(|line| {
        let (key, value) = line.split_once([':', '='])?;
        (key.trim() == name).then(|| value.trim().trim_matches('"').to_owned())
    })
}

fn cpu_field(name: &str) -> Option<String> {
    field(&fs::read_to_string("/proc/cpuinfo").ok()?, name)
}

fn last_cache() -> Option<String> {
    let size = (0..5).rev().find_map(|k| {
        let path = format!("/sys/devices/system/cpu/cpu0/cache/index{k}/size");
        fs::read_to_string(path).ok()
    })?;
    let kibibytes: u64 = size.trim().strip_suffix('K')?.parse().ok()?;
    Some(show_size(kibibytes * 1024))
}

fn memory() -> Option<String> {
    let total = field(&fs::read_to_string("/proc/meminfo").ok()?, "MemTotal")?;
    let kibibytes: u64 = total.strip_suffix("kB")?.trim().parse().ok()?;
    Some(show_size(kibibytes * 1024))
}

fn system() -> Option<String> {
    let name = fs::read_to_string("/etc/os-release")
        .ok()
        .and_then(|text| field(&text, "PRETTY_NAME"));
    let kernel = fs::read_to_string("/proc/sys/kernel/osrelease").ok();
    match (name, kernel) {
        (Some(name), Some(kernel)) => Some(format!("{name}, kernel {}", kernel.trim())),
        (name, _) => name,
    }
}

fn load() -> Option<String> {
    let text = fs::read_to_string("/proc/loadavg").ok()?;
    text.split_whitespace().next().map(str::to_owned)
}

fn commit() -> Option<String> {
    let git = |arguments: &[&str]| {
        let folder = ["-C", env!("CARGO_MANIFEST_DIR")];
        output("git", &[&folder, arguments].concat())
    };
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    // The document itself is about to change.
    let changes = git(&[
        "status",
        "--porcelain",
        "-uno",
        "--",
        "*.rs",
        "*.wgsl",
        "*.toml",
    ])?;
    Some(if changes.is_empty() {
        commit
    } else {
        format!("{commit}, with changes")
    })
}

/// What a program prints, if it is there and succeeds.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program)
        .args(arguments)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
