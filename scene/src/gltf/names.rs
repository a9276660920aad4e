//! What things are called, and how they are told.

use std::collections::{HashMap, HashSet};

/// The first of some names that says anything, else the last resort.
pub(super) fn first_name<'a>(
    names: impl IntoIterator<Item = Option<&'a String>>,
    last_resort: impl FnOnce() -> String,
) -> String {
    let mut names = names.into_iter().flatten();
    let name = names.find(|name| !name.trim().is_empty());
    name.cloned().unwrap_or_else(last_resort)
}

/// Most names in a warning.
const MOST_NAMED: usize = 3;

/// What is told of some names, if there are any.
pub(super) fn told_of(names: &[String], message: impl Fn(&str) -> String) -> Option<String> {
    let named = names.iter().take(MOST_NAMED).cloned().collect::<Vec<_>>();
    let named = named.join(", ");
    match names.len().saturating_sub(MOST_NAMED) {
        0 if names.is_empty() => None,
        0 => Some(message(&named)),
        more => Some(message(&format!("{named} and {more} more"))),
    }
}

/// Names of objects, no two of which are equal.
#[derive(Default)]
pub(super) struct Names {
    /// How many objects asked for a name, and the number that the next one gets.
    asked: HashMap<String, [usize; 2]>,
    taken: HashSet<String>,
    /// Names that more than one object asked for.
    several: Vec<String>,
}

impl Names {
    /// A name for an object that asks for one.
    pub(super) fn name(&mut self, wanted: &str) -> String {
        let [asked, next] = self.asked.entry(wanted.to_owned()).or_insert([0, 2]);
        *asked += 1;
        if *asked == 2 {
            self.several.push(wanted.to_owned());
        }
        let mut name = wanted.to_owned();
        while !self.taken.insert(name.clone()) {
            name = format!("{wanted}.{next}");
            *next += 1;
        }
        name
    }

    /// Tells of names that objects would have shared.
    pub(super) fn warning(&self) -> Option<String> {
        let first = self.several.first()?;
        let more = match self.several.len() - 1 {
            0 => String::new(),
            more => format!(", and so are those of {more} other names"),
        };
        Some(format!(
            "several nodes are named \"{first}\": their objects are told apart by numbers behind the name{more}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn names_of_objects_are_never_equal() {
        let mut names = Names::default();
        let given = ["a", "a.2", "a", "a", "b", "a.2"].map(|name| names.name(name));
        assert_eq!(given, ["a", "a.2", "a.3", "a.4", "b", "a.2.2"]);
        assert!(names.warning().unwrap().contains("\"a\""));
    }
}
