//! Stamps of tool and patient, and when their messages come.

use super::*;

const T: &str = "StylusToTracker";
const R: &str = "ReferenceToTracker";

/// What a client makes of tool and patient, 20 times a second: when each comes after the beginning of its frame, ms, and under which stamp.
fn follow(client: &mut OpenIgtLink, frames_from: std::ops::Range<i64>, behind_ms: i64, apart_ms: i64) -> Vec<Frame> {
    let mut all = Vec::new();
    for k in frames_from {
        let began_ns = 50 * MS * k;
        for ms in 0..50 {
            let now_ns = began_ns + ms * MS;
            let mut acts = client.tick(now_ns);
            if ms == 0 {
                acts.extend(client.bytes(&transform(T, began_ns, k as f32, Some("OK")), now_ns));
            }
            if ms == behind_ms {
                let at_ns = began_ns + apart_ms * MS;
                acts.extend(client.bytes(&transform(R, at_ns, 5.0, Some("OK")), now_ns));
            }
            all.extend(frames(acts));
        }
    }
    all
}

fn whole(frames: &[Frame]) -> usize {
    let is_whole = |frame: &&Frame| frame.seen.len() == 2 && frame.seen.iter().all(|seen| seen.outcome.is_ok());
    frames.iter().filter(is_whole).count()
}

/// The patient's message came 30 ms after the tool's at 20 Hz: never a pose, and not a word of what was left out.
#[test]
fn a_patient_whose_message_comes_later_is_waited_for() {
    for behind_ms in [30, 45] {
        let mut client = client(StatusRule::Required);
        let early = follow(&mut client, 0..40, behind_ms, 0);
        assert_eq!(client.wrong(), "ReferenceToTracker comes too late for its frame");
        let found = follow(&mut client, 40..140, behind_ms, 0);
        assert_eq!((whole(&found), found.len()), (100, 100), "{behind_ms}");
        // Until it was known, each was left out, and no stamp came twice.
        let mut stamps: Vec<i64> = early.iter().chain(&found).map(|frame| frame.device_ns).collect();
        stamps.dedup();
        assert_eq!(stamps.len(), early.len() + found.len());
        // Where it comes no more, the tool's frames are not held up for long.
        let none = follow(&mut client, 140..240, -1, 0);
        let last = none.last().unwrap();
        assert_eq!((none.len(), last.first_ns), (100, 50 * MS * 239));
        assert_eq!(client.due_ns(), None);
    }
}

/// Under a clock that goes on each 15.6 ms, a tool and the patient of 10 ms later share a stamp now and then: more than half the time
/// between two frames, and nothing is waited for so long there.
#[test]
fn a_patient_of_another_instant_is_not_waited_for() {
    let mut client = client(StatusRule::Required);
    let mut all = Vec::new();
    for k in 0..2000_i64 {
        for (name, now_ns) in [(T, 16_666_667 * k), (R, 16_666_667 * k + 10 * MS)] {
            if let Some(due_ns) = client.due_ns().filter(|due_ns| *due_ns <= now_ns) {
                all.extend(frames(client.tick(due_ns)));
            }
            let stamp_ns = now_ns / 15_600_000 * 15_600_000;
            let bytes = transform(name, stamp_ns, k as f32, Some("OK"));
            all.extend(frames(client.bytes(&bytes, now_ns)));
        }
    }
    let most_ns = all.iter().map(|frame| frame.arrival_ns - frame.first_ns).max();
    assert!(most_ns < Some(10 * MS), "{most_ns:?}");
}

/// Each message had a stamp of its own: `marker not seen` and `reference lost` in turn, and the status said nothing of why.
#[test]
fn stamps_that_tool_and_patient_never_share_are_what_is_wrong() {
    let mut client = client(StatusRule::Required);
    let found = follow(&mut client, 0..18, 1, 1);
    assert_eq!((whole(&found), client.wrong()), (0, String::new()));
    let found = follow(&mut client, 18..40, 1, 1);
    assert_eq!(
        (whole(&found), &*client.wrong()),
        (0, "tool and patient never have one stamp")
    );
    // Said no more once they do.
    let found = follow(&mut client, 40..90, 1, 0);
    assert!(whole(&found) >= 49);
    assert_eq!(client.wrong(), "");
}
