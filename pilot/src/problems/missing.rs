//! Samples that never came: a problem where the scene does not allow as many, a note where it does.

use scene::Limits;

use crate::metrics::PoseCounts;

/// More are missing than the scene allows.
pub(crate) fn problem(poses: &PoseCounts, limits: &Limits) -> Option<String> {
    (share(poses) > limits.max_missing_share).then(|| words(poses, limits))
}

/// Some are missing, and the scene allows as many: the exit code does not tell of them.
pub(crate) fn note(poses: &PoseCounts, limits: &Limits) -> Option<String> {
    (poses.missing > 0 && share(poses) <= limits.max_missing_share).then(|| words(poses, limits))
}

/// Of all samples; 0 where there were none.
fn share(poses: &PoseCounts) -> f64 {
    poses.missing as f64 / (poses.published + poses.missing).max(1) as f64
}

fn words(poses: &PoseCounts, limits: &Limits) -> String {
    format!(
        "{} of {} samples are missing, {}; limits.max_missing_share allows {}",
        poses.missing,
        poses.published + poses.missing,
        percent(share(poses)),
        percent(limits.max_missing_share)
    )
}

/// A share in percent; a small one with the digits that tell it from none.
fn percent(share: f64) -> String {
    match share > 0.0 && share < 1e-3 {
        true => format!("{:.1e} %", 100.0 * share),
        false => format!("{:.1} %", 100.0 * share),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use scene::Scene;
    use std::path::Path;

    pub(crate) fn limits(text: &str) -> Limits {
        Scene::parse(&format!("[limits]\n{text}"), Path::new(""))
            .unwrap()
            .limits
    }

    fn poses(published: u64, missing: u64) -> PoseCounts {
        PoseCounts {
            published,
            missing,
            ..PoseCounts::default()
        }
    }

    #[test]
    fn missing_samples_are_a_problem_beyond_the_share_that_is_allowed_and_a_note_up_to_it() {
        // The problem's words, or the note's; never both.
        let said = |published, missing, keys: &str| {
            let (poses, limits) = (poses(published, missing), limits(keys));
            let (problem, note) = (problem(&poses, &limits), note(&poses, &limits));
            assert!(problem.is_none() || note.is_none(), "{problem:?} {note:?}");
            (problem.is_some(), problem.or(note))
        };
        // One in a hundred is allowed unless the scene says otherwise.
        let (is_problem, words) = said(99, 1, "");
        let expected = "1 of 100 samples are missing, 1.0 %; limits.max_missing_share allows 1.0 %";
        assert_eq!((is_problem, words.as_deref()), (false, Some(expected)));
        let (is_problem, words) = said(98, 2, "");
        let expected = "2 of 100 samples are missing, 2.0 %; limits.max_missing_share allows 1.0 %";
        assert_eq!((is_problem, words.as_deref()), (true, Some(expected)));
        // Few of many do not round to none.
        let (is_problem, words) = said(479_955, 45, "");
        let words = words.unwrap();
        assert!(
            !is_problem && words.contains("45 of 480000 samples are missing, 9.4e-3 %"),
            "{words}"
        );
        assert!(!said(1, 99, "max_missing_share = 1.0").0);
        assert!(said(999, 1, "max_missing_share = 0.0").0);
        assert_eq!(said(0, 0, "max_missing_share = 0.0"), (false, None));
        assert_eq!(said(100, 0, ""), (false, None));
    }
}
