//! What stands at the top of the screen: whose it is, how good, recorded or not, watched or not.

use super::*;

/// A window that froze would be covered by nobody: the screen says so.
#[test]
fn a_screen_that_nobody_reads_back_says_so() {
    let unwatched = |watched_ns| {
        let sample = Sample { watched_ns, ..sample() };
        sample.model().facts.is_unwatched
    };
    assert_eq!(
        [None, Some(0), Some(1_400_000_000), Some(1_600_000_000), Some(i64::MAX)].map(unwatched),
        [true, false, false, true, true]
    );
}

#[test]
fn another_patients_identity_is_none() {
    let words = ["DOE^JANE", "0000001", "1950-01-01", "2026-11-20", ""];
    let own = Identity::new(VOLUME, bus::message::IdentitySource::Examination, words);
    let own = Sample {
        identity: Some(own),
        ..sample()
    };
    assert_eq!(own.model().facts.identity, "DOE^JANE");
    let other = Identity::new(VolumeHash([1; 32]), bus::message::IdentitySource::Examination, words);
    let other = Sample {
        identity: Some(other),
        ..sample()
    };
    assert_eq!(other.model().facts.identity, "PATIENT NOT KNOWN");
    // Before the run has an examination, nobody's is shown.
    let early = Sample {
        identity: own.identity,
        volume: None,
        ..sample()
    };
    assert_eq!(early.model().facts.identity, "PATIENT NOT KNOWN");
    assert_eq!(other.model().facts.volume, "CT 36363636");
    assert_eq!(
        own.model().facts.volume,
        "*1950-01-01  ID 0000001  CT 2026-11-20 36363636"
    );
    assert_eq!(
        Sample {
            identity: None,
            ..sample()
        }
        .model()
        .facts
        .identity,
        "PATIENT NOT KNOWN"
    );
}

/// A blank stood where the patient's name stands, and nothing spoke against it.
#[test]
fn a_name_without_a_letter_is_no_name() {
    for name in ["", " ", "^^^^", "\u{3000}", "\u{200b}", "-"] {
        let identity = Identity::new(
            VOLUME,
            bus::message::IdentitySource::Examination,
            [name, "4711", "", "", ""],
        );
        let facts = Sample {
            identity: Some(identity),
            ..sample()
        };
        let facts = facts.model().facts;
        assert_eq!(
            (facts.identity.as_str(), facts.identity_tone),
            ("NO NAME", Tone::Warning),
            "{name:?}"
        );
    }
}

#[test]
fn rec_stands_only_where_all_is_recorded() {
    use bus::message::{Counters, NOT_RECORDING, ProcessState, RECORDED_ANEW};
    let words = |state, lost, note: &str, age_ns| {
        let counters = Counters {
            lost,
            ..Counters::default()
        };
        let beat = bus::message::Heartbeat::new(state, CAPTURED_NS, counters, note);
        Sample {
            recorder: Some((Some(beat), age_ns)),
            ..sample()
        }
        .model()
        .facts
        .recording
    };
    let ready = ProcessState::Ready;
    assert_eq!(words(ready, 0, "300 on disk", 0), "REC 00:00:05");
    assert_eq!(
        words(ready, 0, &format!("{NOT_RECORDING}, 0 lost: no space"), 0),
        NOT_RECORDING
    );
    assert_eq!(words(ready, 3, "300 on disk", 0), "REC HAS GAPS: 3 lost");
    // The one before was killed, and half a second of poses was in no file: REC stood there as if nothing had been.
    assert_eq!(
        words(ready, 0, &format!("300 on disk; {RECORDED_ANEW}"), 0),
        "REC HAS GAPS"
    );
    assert_eq!(words(ready, 0, "300 on disk", 3_000_000_000), "RECORDER SILENT");
    assert_eq!(words(ProcessState::Starting, 0, "joined", 0), "NOT RECORDING YET");
    assert!(!words(ProcessState::Stopping, 0, "asked to stop", 0).starts_with("REC "));
    let silent = Sample {
        recorder: Some((None, 0)),
        ..sample()
    };
    assert_eq!(silent.model().facts.recording, "RECORDER SILENT");
    let none = Sample {
        recorder: None,
        ..sample()
    };
    assert_eq!(none.model().facts.recording, "NOT RECORDED");
}

#[test]
fn the_numbers_at_the_top_are_of_the_pose_that_is_shown() {
    let mut later = sample();
    let mut next = later.poses[0];
    next.seq += 1;
    next.t_capture_ns += 16_000_000;
    next.tip_mm = 9.0;
    later.poses.push(next);
    assert!(later.model().facts.registration.ends_with("tip 95 % 0.6 mm"));
    let lost = sample().in_state(FrameState::Lost(Lost::NotSeen));
    assert_eq!(lost.model().facts.registration, "reg b70989f4");
}
