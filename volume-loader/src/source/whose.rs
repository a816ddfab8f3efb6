//! Whose examination it is, on its way from a file to the bus.

use std::fmt;

use bus::message::{Identity, IdentitySource};

/// Whose examination it is, in the words of whoever says it. Goes to the bus and nowhere else.
#[derive(Clone, PartialEq, Eq)]
pub struct Whose {
    /// Who says it.
    pub source: IdentitySource,
    /// In the order of [`Identity::new`]: name, patient's number, birth date, date of the examination, what was examined.
    pub words: [String; 5],
}

impl Default for Whose {
    /// Nobody says it.
    fn default() -> Self {
        Self {
            source: IdentitySource::Unknown,
            words: Default::default(),
        }
    }
}

/// Says who says it, and nothing of what is said.
impl fmt::Debug for Whose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Whose({:?})", self.source)
    }
}

/// Bytes of the name on the bus, of the patient's number and what was examined, and of days.
const ROOM: [usize; 5] = [Identity::NAME, 64, 16, 16, 64];
/// Stands at the end of what was too long, so that it is not taken for the whole.
const CUT: char = '…';

impl Whose {
    /// In these words, each on one line, and cut off with a mark where it is longer than the bus has room for. Where all are
    /// empty nobody says it.
    pub fn said(source: IdentitySource, words: [String; 5]) -> Self {
        let mut rooms = ROOM.into_iter();
        let words = words.map(|words| fitted(&plain(&words), rooms.next().unwrap_or(0)));
        match words.iter().all(String::is_empty) {
            true => Self::default(),
            false => Self { source, words },
        }
    }
}

/// Control characters become spaces; none at either end.
fn plain(words: &str) -> String {
    words.replace(char::is_control, " ").trim().to_owned()
}

fn fitted(words: &str, room: usize) -> String {
    if words.len() <= room {
        return words.to_owned();
    }
    let kept = words.floor_char_boundary(room.saturating_sub(CUT.len_utf8()));
    format!("{}{CUT}", &words[..kept])
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::VolumeHash;
    use proptest::prelude::*;

    fn on_bus(whose: &Whose) -> [String; 5] {
        let words = whose.words.each_ref().map(String::as_str);
        Identity::new(VolumeHash([0; 32]), whose.source, words).words()
    }

    proptest! {
        #[test]
        fn whatever_is_said_is_on_the_bus_as_it_stands_here(words in prop::array::uniform5("(?s).{0,300}")) {
            let whose = Whose::said(IdentitySource::Examination, words.clone());
            prop_assert_eq!(&on_bus(&whose), &whose.words);
            for (said, words) in whose.words.iter().zip(&words) {
                prop_assert!(!said.contains(char::is_control) && said.trim() == said.as_str());
                // Whole, or marked as cut.
                let plain = plain(words);
                let start = said.strip_suffix(CUT).is_some_and(|start| plain.starts_with(start));
                prop_assert!(*said == plain || start, "{said:?} of {plain:?}");
            }
            prop_assert_eq!(format!("{:?}", whose), format!("Whose({:?})", whose.source));
        }
    }

    #[test]
    fn what_is_too_long_says_so_and_nothing_is_nobody() {
        let long = [
            "x".repeat(10_000),
            "文".repeat(40),
            String::new(),
            String::new(),
            "\u{1b}[2J\r\n".to_owned(),
        ];
        let whose = Whose::said(IdentitySource::Examination, long);
        assert_eq!(whose.words[0], format!("{}…", "x".repeat(253)));
        assert_eq!(whose.words[1], format!("{}…", "文".repeat(20)));
        assert_eq!(whose.words[4], "[2J");
        let blank = [" ", "\0", "", "\t", ""].map(str::to_owned);
        assert_eq!(Whose::said(IdentitySource::Examination, blank), Whose::default());
    }
}
