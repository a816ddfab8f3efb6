//! The sign of life that each process gives, with its counters.

use iceoryx2::prelude::ZeroCopySend;

use super::{field_text, text_field};

/// In the note of a renderer whose graphics card is used no more; why follows.
pub const GPU_GIVEN_UP: &str = "GPU given up,";

/// In front of the note of a recorder that cannot write.
pub const NOT_RECORDING: &str = "NOT RECORDING";

/// In the note of a recorder that came after another had died in the middle of the run: what went out in between is in no file.
pub const RECORDED_ANEW: &str = "begun anew";

/// In front of the note of a localizer whose frames may have waited in a queue, and of how long, ms, rounded up.
pub const MAY_BE_OLDER: &str = "poses may be older by ms: ";

/// Published by each process a few times a second.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Heartbeat/2")]
pub struct Heartbeat {
    /// The process.
    pub pid: u32,
    /// Code of a [`ProcessState`].
    pub state: u32,
    /// When, ns on the run's clock.
    pub t_ns: i64,
    /// What the process has done so far.
    pub counters: Counters,
    /// Of the operator's window: the code that it painted last (24 bits), for whoever reads it back off the screen; of its watcher, the
    /// code that it read last; 0 of all others.
    pub painted_code: u64,
    /// When that was painted or read, ns on the run's clock.
    pub t_painted_ns: i64,
    /// Why it waits or what it does, in words.
    pub note: [u8; 96],
}

const _: () = assert!(size_of::<Heartbeat>() == 168 && size_of::<Counters>() == 40);

/// What a process has done since it started; each process fills in what applies.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Counters/1")]
pub struct Counters {
    /// Messages published: poses, frames or volumes. Of the pilot and the recorder, who take poses: the number of the newest
    /// pose that each has taken, and one.
    pub published: u64,
    /// Poses published as lost, or frames drawn without a pose. Of the recorder: messages that came while it could not write.
    pub lost: u64,
    /// Poses or messages that never were handled because newer ones had come.
    pub dropped: u64,
    /// Poses refused at the door.
    pub refused: u64,
    /// Messages written to disk.
    pub recorded: u64,
}

/// Where a process stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProcessState {
    /// Waits for what it needs, or loads.
    Starting,
    /// Does its work.
    Ready,
    /// Ends in an orderly way.
    Stopping,
}

impl ProcessState {
    const fn code(self) -> u32 {
        match self {
            Self::Starting => 0,
            Self::Ready => 1,
            Self::Stopping => 2,
        }
    }
}

impl Heartbeat {
    /// A sign of life of this process.
    pub fn new(state: ProcessState, t_ns: i64, counters: Counters, note: &str) -> Self {
        Self {
            pid: std::process::id(),
            state: state.code(),
            t_ns,
            counters,
            painted_code: 0,
            t_painted_ns: 0,
            note: marked(note),
        }
    }

    /// The same, of a window that painted `code` at `t_ns`.
    #[must_use]
    pub fn painted(self, code: u64, t_ns: i64) -> Self {
        Self {
            painted_code: code,
            t_painted_ns: t_ns,
            ..self
        }
    }

    /// Where the process stands; an unknown code counts as starting.
    pub fn process_state(&self) -> ProcessState {
        match self.state {
            1 => ProcessState::Ready,
            2 => ProcessState::Stopping,
            _ => ProcessState::Starting,
        }
    }

    /// The note in words.
    pub fn note_text(&self) -> String {
        field_text(&self.note)
    }
}

/// A note whose end is a mark where there is no room for all of it: what is cut off must not look as if it had not been said.
fn marked<const N: usize>(note: &str) -> [u8; N] {
    const MARK: &str = "…";
    if note.len() <= N {
        return text_field(note);
    }
    let end = note.floor_char_boundary(N.saturating_sub(MARK.len()));
    text_field(&format!("{}{MARK}", &note[..end]))
}

/// By how much a localizer that notes this says that its poses may be older than they look, ms.
pub fn may_be_older_ms(note: &str) -> Option<u64> {
    // Behind them a note may have words of the device.
    let rest = note.strip_prefix(MAY_BE_OLDER)?;
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    rest[..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first line of a device's VER stands in the note, and a device that said so was believed.
    #[test]
    fn what_a_note_says_further_on_is_not_what_the_localizer_says_of_its_queue() {
        for note in [
            format!("60 frames/s; device \"{MAY_BE_OLDER}9999\""),
            format!(" {MAY_BE_OLDER}9999"),
        ] {
            assert_eq!(may_be_older_ms(&note), None, "{note}");
        }
    }

    /// Of a list of names the last ones were missing, as if there were no more.
    #[test]
    fn a_note_that_is_cut_says_so() {
        let text = |note: &str| Heartbeat::new(ProcessState::Ready, 0, Counters::default(), note).note_text();
        assert_eq!(text(&"a".repeat(96)), "a".repeat(96));
        assert_eq!(text(&"a".repeat(97)), "a".repeat(93) + "…");
        // 93 is in the middle of a letter.
        assert_eq!(text(&"é".repeat(49)), "é".repeat(46) + "…");
    }

    #[test]
    fn how_much_older_poses_may_be_comes_through_a_note() {
        let note = format!("{MAY_BE_OLDER}3021 (a queue); 60 frames/s");
        assert_eq!(may_be_older_ms(&note), Some(3021));
        assert_eq!(may_be_older_ms(&format!("{MAY_BE_OLDER}7")), Some(7));
        for none in ["60 frames/s", MAY_BE_OLDER, "poses may be older by ms: -3"] {
            assert_eq!(may_be_older_ms(none), None);
        }
    }
}
