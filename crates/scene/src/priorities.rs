//! `[priorities]`: which process gives way where a machine has too much to do.

use serde::{Deserialize, Serialize};

use super::values::{Checked, invalid};

/// `[priorities]`: nice values, where a lower one is served first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Priorities {
    /// Of the tracker, and of the replayer in its place. 0: that of the pilot, here and below.
    pub tracker: i32,
    /// Of every renderer.
    pub renderers: i32,
    /// Of the recorder.
    pub recorder: i32,
    /// Of the loader, which may read again while others navigate.
    pub volume_loader: i32,
    /// Whether tracker and renderers come before whatever has no real-time priority: they are served round-robin (SCHED_RR), and
    /// their nice values say nothing.
    pub real_time: bool,
}

impl Default for Priorities {
    fn default() -> Self {
        Self {
            tracker: 0,
            renderers: 0,
            recorder: 0,
            volume_loader: 5,
            real_time: false,
        }
    }
}

impl Priorities {
    /// The nice value of a process, by its name in the run; 0 for one that is not known.
    pub fn of(&self, process: &str) -> i32 {
        match process {
            "tracker" | "replay" => self.tracker,
            "recorder" => self.recorder,
            "volume-loader" => self.volume_loader,
            view if view.starts_with("view-") => self.renderers,
            _ => 0,
        }
    }
}

impl Priorities {
    /// Whether a process has a real-time priority, by its name in the run.
    pub fn is_real_time(&self, process: &str) -> bool {
        self.real_time && (matches!(process, "tracker" | "replay") || process.starts_with("view-"))
    }
}

pub(super) fn checked(raw: &Priorities) -> Checked<Priorities> {
    let all = [
        ("priorities.tracker", raw.tracker),
        ("priorities.renderers", raw.renderers),
        ("priorities.recorder", raw.recorder),
        ("priorities.volume_loader", raw.volume_loader),
    ];
    for (key, value) in all {
        if !(-20..=19).contains(&value) {
            return Err(invalid(key, value, "-20 (served first) to 19 (served last)"));
        }
    }
    Ok(*raw)
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use std::path::Path;

    #[test]
    fn each_process_has_that_of_its_kind() {
        let text = "[priorities]\ntracker = -10\nrenderers = -5\nrecorder = 3";
        let scene = Scene::parse(text, Path::new("s.toml")).unwrap();
        let found =
            ["tracker", "replay", "view-axial", "recorder", "volume-loader", "x"].map(|name| scene.priorities.of(name));
        assert_eq!(found, [-10, -10, -5, 3, 5, 0]);
    }

    #[test]
    fn what_no_system_has_is_refused_by_name() {
        for (key, value) in [
            ("tracker", -21),
            ("renderers", 20),
            ("recorder", i32::MIN),
            ("volume_loader", i32::MAX),
        ] {
            let error = Scene::parse(&format!("[priorities]\n{key} = {value}"), Path::new("s.toml"));
            let error = error.unwrap_err().to_string();
            assert!(
                error.contains(&format!("priorities.{key}")) && error.contains("-20 (served first)"),
                "{error}"
            );
        }
    }
}
