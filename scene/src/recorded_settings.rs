//! What a file says of the settings of its solution.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The settings on which a solution depends, by name, as the program that solved it gave them. Here they mean
/// nothing, and are compared one by one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RecordedSettings(BTreeMap<String, Value>);

/// A setting that is not what it was.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it was.
    pub before: Recorded<'a>,
    /// What it is.
    pub now: Recorded<'a>,
}

/// The value of a setting; `None` where a program did not have it yet, or has it no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recorded<'a>(pub Option<&'a Value>);

impl RecordedSettings {
    /// Settings that serialise as an object; any others are recorded as none.
    pub fn new(settings: &impl Serialize) -> Self {
        match serde_json::to_value(settings) {
            Ok(Value::Object(fields)) => Self(fields.into_iter().collect()),
            _ => Self::default(),
        }
    }

    /// The value of a setting.
    pub fn get(&self, name: &str) -> Recorded<'_> {
        Recorded(self.0.get(name))
    }

    /// All settings and their values, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Recorded<'_>)> {
        let settings = self.0.iter();
        settings.map(|(name, value)| (name.as_str(), Recorded(Some(value))))
    }

    /// Records a setting, whatever it was.
    pub fn set(&mut self, name: &str, value: impl Into<Value>) {
        self.0.insert(name.to_owned(), value.into());
    }

    /// The settings that are others in `now`, by name.
    pub fn differences<'a>(&'a self, now: &'a Self) -> Vec<Difference<'a>> {
        let names: BTreeSet<&String> = self.0.keys().chain(now.0.keys()).collect();
        names
            .into_iter()
            .map(|name| Difference {
                name,
                before: Recorded(self.0.get(name)),
                now: Recorded(now.0.get(name)),
            })
            .filter(|difference| difference.before != difference.now)
            .collect()
    }
}

impl fmt::Display for Recorded<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            None => f.write_str("unset"),
            Some(Value::String(text)) => f.write_str(text),
            Some(value) => write!(f, "{value}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_set_is_recorded_and_what_was_is_not() {
        let mut settings = RecordedSettings::new(&json!({"a": 128}));
        settings.set("a", 64);
        settings.set("b", "auto");
        assert_eq!(
            settings,
            RecordedSettings::new(&json!({"a": 64, "b": "auto"}))
        );
        assert_eq!(settings.get("b"), Recorded(Some(&json!("auto"))));
        assert_eq!(settings.get("c"), Recorded(None));
    }

    #[test]
    fn settings_differ_by_name_whatever_their_order_is() {
        let before = RecordedSettings::new(&json!({"a": 128, "b": "auto", "c": 0.5, "d": "off"}));
        let now = RecordedSettings::new(&json!({"e": true, "d": "off", "b": "12", "a": 64}));
        assert_eq!(before.differences(&before), []);
        let told: Vec<String> = before
            .differences(&now)
            .iter()
            .map(|d| format!("{}: {}, now {}", d.name, d.before, d.now))
            .collect();
        assert_eq!(
            told,
            [
                "a: 128, now 64",
                "b: auto, now 12",
                "c: 0.5, now unset",
                "e: unset, now true"
            ]
        );
    }
}
