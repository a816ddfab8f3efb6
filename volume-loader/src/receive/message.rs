//! From fragments to messages (PS3.7 section 6.3, PS3.8 annex E): a command set, then its data set, each in one context.

use std::collections::BTreeMap;

use dicom_ul::pdu::{PDataValue, PDataValueType};

use super::command::{Command, CommandError, MAX_BYTES};
use super::contexts::Context;

/// Why a fragment ends the association.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum MessageError {
    #[error("a fragment in context {0}, which was not accepted")]
    Context(u8),
    #[error("a fragment in context {found} within a message in context {expected}")]
    OtherContext { found: u8, expected: u8 },
    #[error("a data set without a command before it")]
    NoCommand,
    #[error("a command within the data set of another")]
    NoEnd,
    #[error("a command set of more than {MAX_BYTES} bytes")]
    TooLong,
    #[error("a command set that is none: {0}")]
    Command(#[from] CommandError),
}

/// What a fragment amounts to.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Step<'a> {
    /// More of the command set is to come.
    Begun,
    /// A command set is whole; its data set follows where it says so.
    Command(u8, Command),
    /// Of the data set.
    Data { bytes: &'a [u8], is_last: bool },
}

/// What is being received.
#[derive(Debug, Default)]
enum State {
    #[default]
    Between,
    Command(u8, Vec<u8>),
    Data(u8),
}

/// Puts fragments together. Of a data set nothing is held.
#[derive(Debug, Default)]
pub(crate) struct Messages {
    state: State,
}

impl Messages {
    /// Whether a message has begun and has not ended.
    pub(crate) fn is_within(&self) -> bool {
        !matches!(self.state, State::Between)
    }

    /// The next fragment.
    ///
    /// # Errors
    /// [`MessageError`]; the association is of no further use then.
    pub(crate) fn take<'a>(
        &mut self,
        value: &'a PDataValue,
        contexts: &BTreeMap<u8, Context>,
    ) -> Result<Step<'a>, MessageError> {
        let id = value.presentation_context_id;
        if !contexts.contains_key(&id) {
            return Err(MessageError::Context(id));
        }
        let expected = match &self.state {
            State::Between => id,
            State::Command(expected, _) | State::Data(expected) => *expected,
        };
        if id != expected {
            return Err(MessageError::OtherContext { found: id, expected });
        }
        match (std::mem::take(&mut self.state), &value.value_type) {
            (State::Between, PDataValueType::Command) => self.command(id, Vec::new(), value),
            (State::Command(_, bytes), PDataValueType::Command) => self.command(id, bytes, value),
            (State::Data(_), PDataValueType::Data) => {
                if !value.is_last {
                    self.state = State::Data(id);
                }
                Ok(Step::Data {
                    bytes: &value.data,
                    is_last: value.is_last,
                })
            }
            (State::Data(_), PDataValueType::Command) => Err(MessageError::NoEnd),
            (_, PDataValueType::Data) => Err(MessageError::NoCommand),
        }
    }

    fn command<'a>(&mut self, id: u8, mut bytes: Vec<u8>, value: &PDataValue) -> Result<Step<'a>, MessageError> {
        if bytes.len() + value.data.len() > MAX_BYTES {
            return Err(MessageError::TooLong);
        }
        bytes.extend_from_slice(&value.data);
        if !value.is_last {
            self.state = State::Command(id, bytes);
            return Ok(Step::Begun);
        }
        let command = Command::parse(&bytes)?;
        if command.has_data_set {
            self.state = State::Data(id);
        }
        Ok(Step::Command(id, command))
    }
}

#[cfg(test)]
mod tests {
    use super::super::command::request;
    use super::super::contexts::Class;
    use super::super::uid::Uid;
    use super::*;
    use crate::dicom::syntax::Syntax;

    fn contexts() -> BTreeMap<u8, Context> {
        let uid = |text: &str| Uid::checked(text.as_bytes()).unwrap();
        let context = Context {
            class: Class::Slices,
            class_uid: uid("1.2.840.10008.5.1.4.1.1.2"),
            syntax: Syntax::DEFAULT,
            syntax_uid: uid("1.2.840.10008.1.2"),
        };
        [(1, context.clone()), (3, context)].into()
    }

    fn value(id: u8, kind: PDataValueType, is_last: bool, data: &[u8]) -> PDataValue {
        PDataValue {
            presentation_context_id: id,
            value_type: kind,
            is_last,
            data: data.to_vec(),
        }
    }

    use PDataValueType::{Command as C, Data as D};

    #[test]
    fn pieces_of_a_command_and_its_data_become_a_message() {
        let (contexts, mut messages) = (contexts(), Messages::default());
        let bytes = request(1, 5, ["1.2", "1.2.3"], true);
        for byte in &bytes[..bytes.len() - 1] {
            assert_eq!(messages.take(&value(1, C, false, &[*byte]), &contexts), Ok(Step::Begun));
        }
        let last = value(1, C, true, &bytes[bytes.len() - 1..]);
        assert!(matches!(messages.take(&last, &contexts), Ok(Step::Command(1, command)) if command.message == 5));
        let data = value(1, D, false, b"ab");
        assert_eq!(
            messages.take(&data, &contexts),
            Ok(Step::Data {
                bytes: b"ab",
                is_last: false
            })
        );
        assert!(messages.is_within());
        assert!(messages.take(&value(1, D, true, b""), &contexts).is_ok());
        assert!(!messages.is_within());
        let echo = value(3, C, true, &request(0x30, 6, ["1.2.840.10008.1.1", ""], false));
        assert!(matches!(messages.take(&echo, &contexts), Ok(Step::Command(3, _))));
        assert!(!messages.is_within());
    }

    #[test]
    fn what_is_out_of_turn_ends_the_association() {
        let contexts = contexts();
        let store = request(1, 5, ["1.2", "1.2.3"], true);
        let rows: [(&[PDataValue], MessageError); 6] = [
            (&[value(5, C, true, &store)], MessageError::Context(5)),
            (&[value(1, D, true, b"x")], MessageError::NoCommand),
            (
                &[value(1, C, false, &store[..9]), value(3, C, true, &store[9..])],
                MessageError::OtherContext { found: 3, expected: 1 },
            ),
            (
                &[value(1, C, true, &store), value(3, D, true, b"x")],
                MessageError::OtherContext { found: 3, expected: 1 },
            ),
            (
                &[value(1, C, true, &store), value(1, C, true, &store)],
                MessageError::NoEnd,
            ),
            (
                &[value(1, C, false, &store), value(1, C, false, &[0; MAX_BYTES])],
                MessageError::TooLong,
            ),
        ];
        for (values, expected) in rows {
            let mut messages = Messages::default();
            let found = values.iter().find_map(|value| messages.take(value, &contexts).err());
            assert_eq!(found, Some(expected));
        }
    }
}
