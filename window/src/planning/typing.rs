//! Words that a person types on the planning screen: a target's name, her own.

use egui::{Event, Key};

/// What the words are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum For {
    /// Another name for the selected target.
    Name,
    /// Who confirms the plan.
    Confirm,
}

/// Words that are being typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Typing {
    /// What they are for.
    pub(crate) what: For,
    /// What there is of them.
    pub(crate) text: String,
}

/// What a key did to them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Typed {
    /// They go on.
    Goes,
    /// They are to be used.
    Done,
    /// They are given up.
    GivenUp,
}

impl Typing {
    /// Words with at most `most` bytes, changed by what happened.
    pub(crate) fn take(&mut self, events: &[Event], most: usize) -> Typed {
        for event in events {
            match event {
                Event::Text(text) if self.text.len() + text.len() <= most => self.text.push_str(text),
                Event::Key { key, pressed: true, .. } => match key {
                    Key::Backspace => drop(self.text.pop()),
                    Key::Escape => return Typed::GivenUp,
                    Key::Enter => {
                        self.text = self.text.trim().to_owned();
                        return if self.text.is_empty() {
                            Typed::GivenUp
                        } else {
                            Typed::Done
                        };
                    }
                    _ => {}
                },
                _ => {}
            }
        }
        Typed::Goes
    }

    /// What is asked of the person.
    pub(crate) const fn question(&self) -> &'static str {
        match self.what {
            For::Name => "Name of the target (Enter takes it, Esc gives it up):",
            For::Confirm => "Your name confirms the plan, which is then read-only (Enter, Esc gives it up):",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::Modifiers;

    fn key(key: Key) -> Event {
        Event::Key {
            key,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: Modifiers::default(),
        }
    }

    #[test]
    fn words_are_typed_mended_and_taken_or_given_up() {
        let mut typing = Typing {
            what: For::Name,
            text: "a".to_owned(),
        };
        let text = |text: &str| Event::Text(text.to_owned());
        assert_eq!(
            typing.take(&[text("b"), text("é"), key(Key::Backspace), text(" ")], 40),
            Typed::Goes
        );
        assert_eq!(
            (typing.take(&[key(Key::Enter)], 40), typing.text.as_str()),
            (Typed::Done, "ab")
        );
        // No longer than there is room for, never half a letter.
        assert_eq!(typing.take(&[text("é"), text("é")], 4), Typed::Goes);
        assert_eq!(typing.text, "abé");
        assert_eq!(typing.take(&[key(Key::Escape)], 40), Typed::GivenUp);
        typing.text = " ".to_owned();
        assert_eq!(typing.take(&[key(Key::Enter)], 40), Typed::GivenUp);
    }
}
