//! How a connection stands, and what of it is told to people.

use std::collections::BTreeSet;

use crate::driver::Act;

/// Words that were told on a connection are not told again.
#[derive(Debug, Clone, Default)]
pub(crate) struct Once(BTreeSet<String>);

/// More different words of one connection are not told: a peer that says something new each time must not fill a log.
const MOST: usize = 64;
/// What stands for the rest: silence would pass for a peer with which nothing is wrong.
const NO_MORE: &str = "too much is told of this connection: the rest of it is not";

impl Once {
    /// Says this, unless it was said.
    pub(crate) fn say(&mut self, words: String) -> Option<Act> {
        if self.0.len() > MOST || !self.0.insert(words.clone()) {
            return None;
        }
        let is_last = self.0.len() > MOST;
        Some(Act::Tell(if is_last { NO_MORE.to_owned() } else { words }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_told_once_and_not_without_end() {
        let mut told = Once::default();
        assert_eq!(told.say("a".to_owned()), Some(Act::Tell("a".to_owned())));
        assert_eq!(told.say("a".to_owned()), None);
        let all: Vec<Act> = (0..1000).filter_map(|i| told.say(i.to_string())).collect();
        assert_eq!(all.len(), MOST);
        assert_eq!(all.last(), Some(&Act::Tell(NO_MORE.to_owned())));
    }
}
