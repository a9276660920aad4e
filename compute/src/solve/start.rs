//! What a run goes on from.

use scene::{Provenance, RecordedSettings, Solution, State};

use super::{Remark, Run};
use crate::backend::RowOrigin;

impl Run<'_, '_> {
    /// The state to go on from: the given one where it was made with the same settings, else its irradiances alone.
    pub(super) fn start_from(&mut self, solution: Option<Solution>) -> Solution {
        let scene = self.scene;
        let mut now = self.settings.solution.recorded(scene.patch_count());
        if let Some(origin) = self.form_factors.origin() {
            origin.record_in(&mut now);
        }
        let mut start = solution.unwrap_or_else(|| Solution {
            provenance: Provenance {
                settings: Some(now.clone()),
                ..Provenance::default()
            },
            ..Solution::dark(scene)
        });
        if std::mem::take(&mut start.provenance.start_up_shots) > 0 {
            start.irradiance = Solution::dark(scene).irradiance;
        }
        if let Some(otherwise) = otherwise(start.provenance.settings.as_ref(), &now) {
            self.observer.remark(&Remark::Start(otherwise));
            start = Solution {
                irradiance: start.irradiance,
                provenance: Provenance {
                    iterations: start.provenance.iterations,
                    settings: Some(now),
                    // The residuals tell nothing about these settings, neither now nor in a file that is continued
                    // before these settings have done an iteration.
                    ..Provenance::default()
                },
                state: State::AtRest,
                function: None,
                layers: None,
            };
        }
        start
    }
}

/// In which way a solution was made that is not that of this run; `None` where it is the same.
fn otherwise(before: Option<&RecordedSettings>, now: &RecordedSettings) -> Option<String> {
    let Some(before) = before else {
        return Some("is of an older version, which does not say how it was solved".to_owned());
    };
    let mut differences = before.differences(now);
    // A back end that is still to be chosen, or that a file of an older version does not tell, is no other one.
    differences.retain(|difference| {
        let is_told = difference.before.0.is_some() && difference.now.0.is_some();
        difference.name != RowOrigin::SETTING || is_told
    });
    let then = differences
        .iter()
        .map(|d| format!("{} {}", d.name, d.before));
    let now = differences.iter().map(|d| d.now.to_string());
    (!differences.is_empty()).then(|| {
        format!(
            "was solved with {}, now {}",
            joined(then.collect()),
            joined(now.collect())
        )
    })
}

/// As a sentence has them: `a`, `a and b`, `a, b and c`.
fn joined(mut words: Vec<String>) -> String {
    let last = words.pop().unwrap_or_default();
    if words.is_empty() {
        last
    } else {
        format!("{} and {last}", words.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_differs_is_told_by_name() {
        let recorded = |value| RecordedSettings::new(&value);
        let now = recorded(json!({"points": "auto", "resolution": 128, "seed": "7"}));
        let told = |before| otherwise(Some(&recorded(before)), &now);
        assert_eq!(
            told(json!({"points": "auto", "resolution": 128, "seed": "7"})),
            None
        );
        assert_eq!(
            told(json!({"points": "auto", "resolution": 64, "seed": "7"})).unwrap(),
            "was solved with resolution 64, now 128"
        );
        assert_eq!(
            told(json!({"points": "centroid", "resolution": 64, "seed": "0"})).unwrap(),
            "was solved with points centroid, resolution 64 and seed 0, now auto, 128 and 7"
        );
    }

    #[test]
    fn back_ends_differ_where_both_are_known() {
        let recorded = |value| RecordedSettings::new(&value);
        let unknown = recorded(json!({"resolution": 128}));
        let [cpu, gpu] =
            ["cpu", "gpu"].map(|name| recorded(json!({"backend": name, "resolution": 128})));
        assert_eq!(
            otherwise(Some(&cpu), &gpu).unwrap(),
            "was solved with backend cpu, now gpu"
        );
        for (before, now) in [(&unknown, &gpu), (&cpu, &unknown), (&gpu, &gpu)] {
            assert_eq!(otherwise(Some(before), now), None);
        }
    }
}
