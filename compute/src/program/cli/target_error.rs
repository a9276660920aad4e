//! The error that is asked for, as on the command line.

use std::str::FromStr;

use crate::settings::Target;

/// The largest errors of an irradiance function, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TargetError {
    power: Option<f64>,
    visible: Option<f64>,
}

impl TargetError {
    /// What a run is asked for.
    pub fn target(self) -> Target {
        Target::of(self.power, self.visible)
    }
}

impl FromStr for TargetError {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut target = Self {
            power: None,
            visible: None,
        };
        for part in text.split(',') {
            let wrong = || {
                format!(
                    "\"{part}\" is no error such as 2% or 4%visible, above 0% and up to 100%, each once"
                )
            };
            let (number, of_what) = part.trim().split_once('%').ok_or_else(wrong)?;
            let error = match of_what.trim() {
                "" | "power" => &mut target.power,
                "visible" => &mut target.visible,
                _ => return Err(wrong()),
            };
            let percent: f64 = number.trim().parse().map_err(|_| wrong())?;
            if !(percent > 0.0 && percent <= 100.0) || error.is_some() {
                return Err(wrong());
            }
            *error = Some(0.01 * percent);
        }
        Ok(target)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_of_power_or_of_what_is_visible() {
        for (text, power, visible) in [
            ("2%", Some(0.02), None),
            ("2 % power", Some(0.02), None),
            ("3%visible", None, Some(0.03)),
            ("1%, 0.5% visible", Some(0.01), Some(0.005)),
            ("5%visible,100%", Some(1.0), Some(0.05)),
        ] {
            let found: TargetError = text.parse().unwrap();
            let near = |found: Option<f64>, expected: Option<f64>| match (found, expected) {
                (Some(found), Some(expected)) => (found - expected).abs() < 1e-15,
                (found, expected) => found.is_none() && expected.is_none(),
            };
            assert!(
                near(found.power, power) && near(found.visible, visible),
                "{text}"
            );
        }
        for text in [
            "2", "0%", "-1%", "101%", "nan%", "%", "", "2%,3%", "2%lux", "2%,",
        ] {
            assert!(text.parse::<TargetError>().is_err(), "{text}");
        }
    }
}
