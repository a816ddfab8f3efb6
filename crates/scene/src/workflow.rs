//! `[workflow]`: what a run demands of a person on its way to navigation.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::values::{Checked, number};

/// `[workflow]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RawWorkflow {
    /// Nothing is skipped: a person confirms whose the examination is, touches known points, and starts.
    pub strict: bool,
    /// A check passes where no touched point is off by more, mm.
    pub check_mm: f64,
    /// A check that is older does not hold any more, minutes.
    pub check_age_min: f64,
}

impl Default for RawWorkflow {
    fn default() -> Self {
        Self {
            strict: false,
            check_mm: 2.0,
            check_age_min: 30.0,
        }
    }
}

/// What a run demands of a person on its way to navigation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demands {
    /// Nothing is skipped. Else the run is research, and every screen says so.
    pub strict: bool,
    /// A check passes where no touched point is off by more, mm; above 0.
    pub check_mm: f64,
    /// A check that is older does not hold any more; above 0.
    pub check_age: Duration,
}

pub(super) fn checked(raw: &RawWorkflow) -> Checked<Demands> {
    let check_min = number("workflow.check_age_min", raw.check_age_min, 0.1..=1440.0, "min")?;
    Ok(Demands {
        strict: raw.strict,
        check_mm: number("workflow.check_mm", raw.check_mm, 0.01..=100.0, "mm")?,
        check_age: Duration::from_secs_f64(check_min * 60.0),
    })
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;
    use std::time::Duration;

    #[test]
    fn a_scene_is_research_unless_it_says_otherwise() {
        let of = |text: &str| Scene::parse(text, Path::new("s.toml")).unwrap().workflow;
        let default = of("");
        assert!(!default.strict);
        assert_eq!((default.check_mm, default.check_age), (2.0, Duration::from_secs(1800)));
        let strict = of("[workflow]\nstrict = true\ncheck_mm = 1.5\ncheck_age_min = 10");
        assert!(strict.strict);
        assert_eq!((strict.check_mm, strict.check_age), (1.5, Duration::from_secs(600)));
    }

    #[test]
    fn what_is_no_gate_is_refused_by_name() {
        for (line, said) in [
            (
                "check_mm = 0",
                "line 2, column 12, key workflow.check_mm: found 0; allowed: 0.01 to 100 mm",
            ),
            ("check_mm = nan", "key workflow.check_mm: found NaN"),
            (
                "check_age_min = -1",
                "key workflow.check_age_min: found -1; allowed: 0.1 to 1440 min",
            ),
            ("check_age_min = inf", "key workflow.check_age_min: found inf"),
            ("strict = 1", "expected a boolean"),
        ] {
            let error = Scene::parse(&format!("[workflow]\n{line}"), Path::new("s.toml")).unwrap_err();
            assert!(error.to_string().contains(said), "{error}");
        }
    }
}
