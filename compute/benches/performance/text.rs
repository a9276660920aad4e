//! Markdown: headings, tables, plots and numbers.

use std::fmt::Write;

/// A section's heading.
pub fn heading(title: &str) -> String {
    format!("\n## {title}\n\n")
}

/// A table; its first `left` columns are words, the others numbers.
pub fn table(header: &[&str], left: usize, rows: &[Vec<String>]) -> String {
    let rules: Vec<&str> = (0..header.len())
        .map(|k| if k < left { "---" } else { "--:" })
        .collect();
    let mut text = format!("| {} |\n|{}|\n", header.join(" | "), rules.join("|"));
    for row in rows {
        // Writing to a string cannot fail.
        writeln!(text, "| {} |", row.join(" | ")).ok();
    }
    text
}

/// A value and the mark it has in a plot.
pub type Point = (f64, char);

/// Columns of a plot for each power of ten.
const DECADE: usize = 20;

/// Values by their logarithms, a line for each label. Where two marks fall together the first is seen.
pub fn plot(unit: &str, lines: &[(String, Vec<Point>)]) -> String {
    let logs: Vec<f64> = lines
        .iter()
        .flat_map(|(_, points)| points.iter().map(|(value, _)| value.log10()))
        .filter(|log| log.is_finite())
        .collect();
    let low = logs.iter().copied().fold(f64::INFINITY, f64::min).floor();
    let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !low.is_finite() {
        return String::new();
    }
    let decades = (high.ceil() - low).max(1.0) as usize;
    let label_width = lines
        .iter()
        .map(|(label, _)| label.len())
        .max()
        .unwrap_or(0);
    let mut text = format!("\n```text\n{:label_width$} ", "");
    let mut scale = String::new();
    for exponent in low as i32..=low as i32 + decades as i32 {
        let mark = format!("{} {unit}", power_of_ten(exponent));
        write!(scale, "{mark:DECADE$}").ok();
    }
    text.push_str(scale.trim_end());
    for (label, points) in lines {
        let mut columns: Vec<char> = (0..=decades * DECADE)
            .map(|k| if k.is_multiple_of(DECADE) { '|' } else { ' ' })
            .collect();
        for (value, mark) in points.iter().rev() {
            let log = value.log10();
            if log.is_finite() {
                columns[((log - low) * DECADE as f64).round() as usize] = *mark;
            }
        }
        let line: String = columns.into_iter().collect();
        write!(text, "\n{label:>label_width$} {}", line.trim_end()).ok();
    }
    text.push_str("\n```\n");
    text
}

fn power_of_ten(exponent: i32) -> String {
    let decimals = usize::try_from(-exponent).unwrap_or(0);
    format!("{:.decimals$}", 10_f64.powi(exponent))
}

/// A whole number with its thousands apart.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Three significant figures, or the whole number where it has more.
pub fn figures(value: f64) -> String {
    if value <= 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let decimals = 2 - value.log10().floor() as i32;
    match usize::try_from(decimals) {
        Ok(decimals) if decimals > 0 => format!("{value:.decimals$}"),
        _ => count(value.round() as u64),
    }
}

/// A share of 1 in percent.
pub fn percent(share: f64) -> String {
    format!("{} %", figures(100.0 * share))
}

/// A number of things: "1 core", "2 cores".
pub fn number_of(value: usize, thing: &str) -> String {
    format!("{value} {thing}{}", if value == 1 { "" } else { "s" })
}
