//! What a file holds without end, in bounded length: texts and lists.

use serde::Serialize;

/// Longer texts are cut off.
const MOST_LETTERS: usize = 400;
/// Longer lists are counted from there on.
const MOST_ENTRIES: usize = 300;

/// A text, cut off where it is too long; that is said.
pub(super) fn short(text: &str) -> String {
    match text.char_indices().nth(MOST_LETTERS) {
        None => text.to_owned(),
        Some((end, _)) => {
            let more = text[end..].chars().count();
            format!("{} ... ({more} more characters)", &text[..end])
        }
    }
}

/// The first entries of a list, and how many there were.
#[derive(Debug, Clone, Serialize)]
pub(super) struct List<T> {
    /// The first of them.
    pub(super) listed: Vec<T>,
    /// How many there were.
    pub(super) count: u64,
}

impl<T> Default for List<T> {
    fn default() -> Self {
        Self {
            listed: Vec::new(),
            count: 0,
        }
    }
}

impl<T> List<T> {
    pub(super) fn push(&mut self, entry: T) {
        self.count += 1;
        if self.listed.len() < MOST_ENTRIES {
            self.listed.push(entry);
        }
    }

    /// How many are not listed.
    pub(super) fn more(&self) -> u64 {
        self.count - self.listed.len() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_off_is_said() {
        assert_eq!(short("a mark"), "a mark");
        let long = short(&"é".repeat(1000));
        assert!(
            long.starts_with("éé") && long.ends_with("é ... (600 more characters)"),
            "{long}"
        );
        let mut list = List::default();
        (0..1000).for_each(|i| list.push(i));
        assert_eq!((list.listed.len(), list.count, list.more()), (300, 1000, 700));
    }
}
