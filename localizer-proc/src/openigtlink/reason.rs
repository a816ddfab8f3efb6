//! The newest reason why a pose was refused, for the status, which has room for few words.

/// It is said for so long after it came last, ns.
const SAID_NS: i64 = 2_000_000_000;
/// Characters of it that are said.
const CHARACTERS: usize = 48;

/// The newest reason, with its time.
#[derive(Debug, Clone, Default)]
pub(super) struct Reason(Option<(String, i64)>);

impl Reason {
    /// This one came.
    pub(super) fn came(&mut self, words: &str, now_ns: i64) {
        self.0 = Some((cut(words), now_ns));
    }

    /// It in words, where it is new enough to be so still; else nothing.
    pub(super) fn words(&self, now_ns: i64) -> &str {
        let is_new = |at_ns: i64| now_ns.saturating_sub(at_ns) <= SAID_NS;
        self.0
            .as_ref()
            .filter(|(_, at_ns)| is_new(*at_ns))
            .map_or("", |(words, _)| words)
    }
}

/// The beginning of what is too long, and a mark of that.
fn cut(words: &str) -> String {
    match words.char_indices().nth(CHARACTERS) {
        None => words.to_owned(),
        Some(_) => words.chars().take(CHARACTERS - 1).chain(['…']).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_is_said_while_it_is_new_and_a_long_one_is_cut_with_a_mark() {
        let mut reason = Reason::default();
        assert_eq!(reason.words(0), "");
        reason.came("a", 0);
        reason.came("b", 1);
        assert_eq!((reason.words(SAID_NS + 1), reason.words(SAID_NS + 2)), ("b", ""));
        reason.came(&"ä".repeat(49), 0);
        assert_eq!(reason.words(0), format!("{}…", "ä".repeat(47)));
        reason.came(&"ä".repeat(48), 0);
        assert_eq!(reason.words(0), "ä".repeat(48));
    }
}
