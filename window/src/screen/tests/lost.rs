//! Without a pose that may be followed nothing on the screen, and nothing in the tree, is a distance, an angle or a depth.

use super::samples::{all, planned, without_a_pose};
use super::stage::{Told, stage, told};
use super::{SCREENS, monitor};
use crate::screen::Look;

/// Everything that a node says.
fn texts(node: &Told) -> impl Iterator<Item = &str> {
    let more = [node.key.as_deref(), node.description.as_deref()];
    [Some(node.name.as_str())].into_iter().chain(more).flatten()
}

/// Whether digits of this text are none of the tool's: ages, times, names of examinations and registrations, keys, numbers of views, how
/// far off the screen is read.
fn is_harmless(text: &str) -> bool {
    let is_number = |text: &str| text.parse::<f64>().is_ok();
    let age = |text: &str| {
        let words: Vec<&str> = text.split_whitespace().collect();
        matches!(words[..], [number, "ms" | "s"] if is_number(number))
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.contains(&"mm") || text.contains(['\u{b0}', '%']) {
        return false;
    }
    let parts = text.split(", ").map(|part| {
        let part = part.trim();
        let is_age = |text: &str| text.strip_suffix(" OLD").or(text.strip_suffix(" old")).is_some_and(age);
        let named = ["REC ", "CT ", "reg ", "view ", "of ", "READABLE TO "];
        is_age(part)
            || part
                .strip_prefix("pose ")
                .is_some_and(|rest| is_age(rest.split("   ").next().unwrap_or_default()))
            || named.iter().any(|name| part.starts_with(name))
            || ["F6", "F9", "Back 5 s", "On 5 s"].contains(&part)
            || !part.contains(|letter: char| letter.is_ascii_digit())
    });
    parts.into_iter().all(|harmless| harmless)
}

#[test]
fn no_distance_angle_or_depth_is_left_anywhere() {
    let mut asked = 0;
    for (name, sample) in without_a_pose() {
        for look in [
            Look::default(),
            Look {
                enlarged: Some(2),
                ..Look::default()
            },
            Look {
                only_sight: true,
                ..Look::default()
            },
        ] {
            let harness = stage(sample.model(), monitor(SCREENS[1]), look);
            for text in told(&harness).iter().flat_map(texts) {
                assert!(is_harmless(text), "{name}: {text}");
                asked += 1;
            }
        }
    }
    println!("{asked} texts");
    assert!(asked > 1000);
}

/// The question above can be answered with no.
#[test]
fn a_pose_that_may_be_followed_has_distances_and_an_angle() {
    let harness = stage(planned().model(), monitor(SCREENS[1]), Look::default());
    let told = told(&harness);
    let bad: Vec<&str> = told.iter().flat_map(texts).filter(|text| !is_harmless(text)).collect();
    for part in ["24.9", "1.3", "12.5", "\u{b0}", "tip 95 %", "the sight"] {
        assert!(bad.iter().any(|text| text.contains(part)), "{part}: {bad:?}");
    }
    assert!(!is_harmless("37.4") && !is_harmless("NO POSE, 12.5 mm") && !is_harmless("3.2\u{b0}"));
    assert!(all().len() > 20);
}
