//! Durations and sizes as people write them: `90s`, `5min`, `0.2s`; `4GiB`, `512MiB`.

use std::time::Duration;

/// Units of time and their seconds.
const TIME_UNITS: [(&str, f64); 4] = [("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0)];

/// Units of size and their bytes.
const SIZE_UNITS: [(&str, f64); 8] = [
    ("B", 1.0),
    ("KiB", 1024.0),
    ("MiB", 1_048_576.0),
    ("GiB", 1_073_741_824.0),
    ("TiB", 1_099_511_627_776.0),
    ("kB", 1e3),
    ("MB", 1e6),
    ("GB", 1e9),
];

/// Reads a duration such as `90s`.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let seconds = parse(text, &TIME_UNITS, "90s")?;
    Duration::try_from_secs_f64(seconds).map_err(|error| format!("\"{text}\": {error}"))
}

/// Reads a size such as `4GiB`, in bytes.
pub fn parse_size(text: &str) -> Result<u64, String> {
    // A float to integer cast saturates, and 2^64 bytes are no limit at all.
    Ok(parse(text, &SIZE_UNITS, "4GiB")? as u64)
}

fn parse(text: &str, units: &[(&str, f64)], example: &str) -> Result<f64, String> {
    let text = text.trim();
    let unit_start = text
        .find(|c: char| c.is_ascii_alphabetic())
        .unwrap_or(text.len());
    let (number, unit) = (text[..unit_start].trim(), &text[unit_start..]);
    let names = || {
        units
            .iter()
            .map(|(name, _)| *name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    let &(_, factor) = units
        .iter()
        .find(|(name, _)| *name == unit)
        .ok_or_else(|| {
            format!(
                "\"{text}\" needs one of the units {}, as in {example}",
                names()
            )
        })?;
    match number.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value * factor),
        _ => Err(format!(
            "\"{text}\" is not a number >= 0 and a unit, as in {example}"
        )),
    }
}

/// A duration for people: `0.42 s`, `12.3 s`, `5 min 20 s`, `2 h 3 min`.
pub fn show_duration(duration: Duration) -> String {
    let seconds = duration.as_secs_f64();
    let whole = seconds.round() as u64;
    match whole {
        0..10 => format!("{seconds:.2} s"),
        10..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {} s", whole / 60, whole % 60),
        _ => format!("{} h {} min", whole / 3600, whole % 3600 / 60),
    }
}

/// A size for people: `1.5 GiB`.
pub fn show_size(bytes: u64) -> String {
    let (name, factor) = SIZE_UNITS[..5]
        .iter()
        .rev()
        .find(|(_, f)| bytes as f64 >= *f)
        .unwrap_or(&SIZE_UNITS[0]);
    let value = bytes as f64 / factor;
    if value < 10.0 && *name != "B" {
        format!("{value:.1} {name}")
    } else {
        format!("{value:.0} {name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_and_sizes_read_as_written() {
        assert_eq!(parse_duration("90s"), Ok(Duration::from_secs(90)));
        assert_eq!(parse_duration("5min"), Ok(Duration::from_mins(5)));
        assert_eq!(parse_duration("0.2s"), Ok(Duration::from_millis(200)));
        assert_eq!(parse_size("4GiB"), Ok(4 << 30));
        assert_eq!(parse_size("1.5 KiB"), Ok(1536));
        for bad in ["", "90", "s", "-1s", "nans", "1e400s", "5 parsecs", "1µs"] {
            assert!(parse_duration(bad).is_err(), "{bad}");
        }
        for bad in ["4", "GiB", "-4GiB", "4gib"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn what_is_shown_is_short() {
        assert_eq!(show_duration(Duration::from_secs(320)), "5 min 20 s");
        assert_eq!(show_duration(Duration::from_millis(420)), "0.42 s");
        assert_eq!(show_size(0), "0 B");
        assert_eq!(show_size(3 << 29), "1.5 GiB");
    }
}
