//! What is told of a device on one connection, and what the status says of it.

use std::mem::{Discriminant, discriminant};

use ndi::Fault;
use ndi::session::Notice;

use crate::driver::Act;
use crate::state::Once;

/// Told once on a connection; how often it was so stands in the status.
const OF_BEFORE: &str = "the device, or what is between, gave a reply of before (the number of its frame goes back): such replies are not used. \
                         If another device is there now: `pilot restart localizer`";
/// Different words of one kind that are told: numbers in them may be others each time, and would leave no room for what is told later.
const MOST_ALIKE: usize = 4;
/// The same of replies that are refused for one kind of fault.
const MOST_FAULTS: usize = 2;
/// Tools have a handle each, and others after a reset.
const MOST_LOADED: usize = 32;
/// What stands for the rest of a kind.
const MORE: &str = "the device gives more of one kind than is told of this connection";
/// What was wrong is said for so long after it came last, ns.
const SAID_NS: i64 = 2_000_000_000;

/// Of one kind are notices that differ by the numbers in them: replies are refused for many kinds of faults.
type Kind = (Discriminant<Notice>, Option<Discriminant<Fault>>);

/// What was told, and what was counted.
#[derive(Debug, Default)]
pub(super) struct Told {
    once: Once,
    /// What was told of each kind, no more than is told of one.
    kinds: Vec<(Kind, Vec<String>)>,
    /// Replies of before, and when the newest came.
    of_before: (u64, i64),
    /// When a frame came last whose number stands still.
    stood_ns: Option<i64>,
    jumps: u64,
}

impl Told {
    /// These words, once.
    pub(super) fn say(&mut self, words: String) -> Option<Act> {
        self.once.say(words)
    }

    /// What is done about this one, which came at `now_ns`.
    pub(super) fn notice(&mut self, notice: &Notice, now_ns: i64) -> Vec<Act> {
        let mut acts = Vec::new();
        match notice {
            // Polls are more frequent than frames.
            Notice::SameFrame { .. } | Notice::NoFrame => return acts,
            Notice::Jump { .. } => self.jumps += 1,
            Notice::Back { .. } => self.of_before = (self.of_before.0 + 1, now_ns),
            Notice::Stands { .. } => self.stood_ns = Some(now_ns),
            _ => {}
        }
        if is_refusal(notice) {
            acts.push(Act::Refused);
        }
        acts.extend(self.words_of(notice));
        acts
    }

    fn words_of(&mut self, notice: &Notice) -> Option<Act> {
        if let Notice::Back { .. } = notice {
            return self.once.say(OF_BEFORE.to_owned());
        }
        let (kind, words) = (kind(notice), notice.to_string());
        let place = self.kinds.iter().position(|(other, _)| *other == kind);
        let place = place.unwrap_or_else(|| {
            self.kinds.push((kind, Vec::new()));
            self.kinds.len() - 1
        });
        let told = self.kinds.get_mut(place).map(|(_, told)| told)?;
        if told.contains(&words) {
            return None;
        }
        if told.len() >= most(notice) {
            return self.once.say(MORE.to_owned());
        }
        told.push(words.clone());
        self.once.say(words)
    }

    /// What was wrong lately, for the status.
    pub(super) fn wrong(&self, now_ns: i64) -> String {
        let is_new = |at_ns: i64| now_ns.saturating_sub(at_ns) <= SAID_NS;
        if self.stood_ns.is_some_and(is_new) {
            return "the number of frames stands still: not used".to_owned();
        }
        match self.of_before {
            (0, _) => String::new(),
            (_, at_ns) if is_new(at_ns) => self.of_before(),
            _ => String::new(),
        }
    }

    /// What was counted, before `words`.
    pub(super) fn before(&self, words: &str, now_ns: i64) -> String {
        let of_before = self.of_before();
        let is_said = self.wrong(now_ns) == of_before;
        let jumps = match self.jumps {
            0 => String::new(),
            1 => "1 jump of frame numbers".to_owned(),
            count => format!("{count} jumps of frame numbers"),
        };
        let parts = [if is_said { "" } else { &of_before }, &jumps, words];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join("; ")
    }

    fn of_before(&self) -> String {
        match self.of_before {
            (0, _) => String::new(),
            (count, _) => format!("{count} replies of before not used"),
        }
    }
}

/// Of which something was left out.
const fn is_refusal(notice: &Notice) -> bool {
    matches!(
        notice,
        Notice::Malformed(_)
            | Notice::Refused { .. }
            | Notice::NotAnAnswer { .. }
            | Notice::Unanswered { .. }
            | Notice::Back { .. }
            | Notice::Stands { .. }
    )
}

fn kind(notice: &Notice) -> Kind {
    let fault = match notice {
        Notice::Malformed(malformed) => Some(discriminant(&malformed.fault)),
        _ => None,
    };
    (discriminant(notice), fault)
}

/// How many different words of its kind are told.
const fn most(notice: &Notice) -> usize {
    match notice {
        Notice::Jump { .. } => 1,
        Notice::Loaded { .. } => MOST_LOADED,
        Notice::Malformed(_) => MOST_FAULTS,
        _ => MOST_ALIKE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndi::Handle;

    /// Stated: 64 jumps, word by word, and then nothing. True: behind them a tool was unplugged.
    #[test]
    fn numbers_that_jump_again_and_again_leave_room_for_what_comes_later() {
        let mut told = Told::default();
        let jump = |to| Notice::Jump { from: to + 1, to };
        let words: Vec<Act> = (0..1000).flat_map(|to| told.notice(&jump(to), 0)).collect();
        let first = Act::Tell("frame 0 after frame 1".to_owned());
        assert_eq!(words, [first, Act::Tell(MORE.to_owned())]);
        let system = |bits| Notice::System(ndi::status::SystemStatus(bits));
        let statuses = (0..1000).flat_map(|bits| told.notice(&system(bits), 0));
        // As many, and that there is more.
        assert_eq!(statuses.count(), MOST_ALIKE);
        let unplugged = told.notice(&Notice::Unplugged(Handle(1)), 0);
        assert_eq!(unplugged, [Act::Tell("the tool of handle 01 was unplugged".to_owned())]);
        assert_eq!(told.before("device", 0), "1000 jumps of frame numbers; device");
    }

    #[test]
    fn what_was_left_out_is_said_first_while_it_is_new_and_counted_afterwards() {
        let mut told = Told::default();
        let back = Notice::Back { from: 9, to: 5 };
        assert_eq!(told.notice(&back, 5), [Act::Refused, Act::Tell(OF_BEFORE.to_owned())]);
        assert_eq!(told.notice(&back, 6), [Act::Refused]);
        let words = |told: &Told, now_ns| [told.wrong(now_ns), told.before("device", now_ns)];
        assert_eq!(words(&told, 7), ["2 replies of before not used", "device"]);
        let late = SAID_NS + 7;
        assert_eq!(words(&told, late), ["", "2 replies of before not used; device"]);
        let stands = |number| Notice::Stands { number };
        assert_eq!(told.notice(&stands(5), late).len(), 2);
        assert_eq!(told.notice(&stands(6), late), [Act::Refused], "the same words");
        assert_eq!(told.wrong(late), "the number of frames stands still: not used");
    }

    /// What is told of an event has so much room.
    #[test]
    fn what_to_do_about_replies_of_before_is_told_whole() {
        assert!(OF_BEFORE.len() <= bus::message::Event::TEXT);
    }
}
