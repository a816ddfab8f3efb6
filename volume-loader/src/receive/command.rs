//! Command sets: what a peer asks, and the answers (PS3.7 section 6.3, annex E). Always implicit VR little endian, in one group.

use super::uid::Uid;

/// Command sets are a few hundred bytes; a longer one is none.
pub(crate) const MAX_BYTES: usize = 16 << 10;
/// What stands in CommandDataSetType where no data set follows.
const NO_DATA_SET: u16 = 0x0101;
/// Characters of an ErrorComment (LO).
const MAX_COMMENT: usize = 64;

/// Elements of group 0000.
const GROUP_LENGTH: u16 = 0x0000;
const CLASS: u16 = 0x0002;
const FIELD: u16 = 0x0100;
const MESSAGE: u16 = 0x0110;
const ANSWERED: u16 = 0x0120;
const DATA_SET: u16 = 0x0800;
const STATUS: u16 = 0x0900;
const COMMENT: u16 = 0x0902;
const INSTANCE: u16 = 0x1000;

/// C-STORE-RQ, C-ECHO-RQ and C-CANCEL-RQ.
const STORE: u16 = 0x0001;
const ECHO: u16 = 0x0030;
const CANCEL: u16 = 0x0FFF;
/// Set in what is an answer.
const ANSWER: u16 = 0x8000;

/// Why bytes are no command set. Positions are bytes of the command set, from 0.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(crate) enum CommandError {
    #[error("element at byte {byte}: {found} bytes are left, expected {expected}")]
    CutOff { byte: usize, expected: u64, found: usize },
    #[error("element at byte {byte} is of group {found:04X}, expected 0000")]
    Group { byte: usize, found: u16 },
    #[error("element (0000,{found:04X}) at byte {byte} does not come after (0000,{before:04X})")]
    Order { byte: usize, before: u16, found: u16 },
    #[error("element (0000,{element:04X}) has {found} bytes, expected {expected}")]
    Length {
        element: u16,
        found: usize,
        expected: usize,
    },
    #[error("the group length says {said} bytes, found {found}")]
    GroupLength { said: u32, found: usize },
    #[error("element (0000,{element:04X}) is missing")]
    Missing { element: u16 },
}

/// What a peer asks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Asked {
    Echo,
    /// Of which a data set is to be stored; `None` where the UID is missing or none.
    Store {
        class: Option<Uid>,
        instance: Option<Uid>,
    },
    /// Takes back what was never granted; no answer.
    Cancel,
    /// An answer to nothing.
    Answer,
    /// Something that is not done here.
    Other,
}

/// A command set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Command {
    pub field: u16,
    /// The peer's number of this message.
    pub message: u16,
    pub has_data_set: bool,
    pub asked: Asked,
    /// As they came, to be answered with; bounded by [`MAX_BYTES`].
    class: Vec<u8>,
    instance: Vec<u8>,
}

/// The statuses that are answered (PS3.4 table B.2-1, PS3.7 annex C).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Status {
    Success,
    /// Refused: no room, or beyond a limit.
    OutOfResources,
    /// The data set is not of the class or the instance that was announced.
    NoMatch,
    /// The data set cannot be understood.
    NotUnderstood,
    /// There is another one of that name.
    Different,
    InvalidInstance,
    Unrecognized,
}

impl Status {
    pub(crate) const fn code(self) -> u16 {
        match self {
            Self::Success => 0x0000,
            Self::OutOfResources => 0xA700,
            Self::NoMatch => 0xA900,
            Self::NotUnderstood => 0xC000,
            Self::Different => 0xC001,
            Self::InvalidInstance => 0x0117,
            Self::Unrecognized => 0x0211,
        }
    }
}

/// The elements of a command set by number, in order.
fn elements(bytes: &[u8]) -> Result<Vec<(u16, &[u8])>, CommandError> {
    let mut found: Vec<(u16, &[u8])> = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let byte = bytes.len() - rest.len();
        let cut_off = |expected| CommandError::CutOff {
            byte,
            expected,
            found: rest.len(),
        };
        let (head, value) = rest.split_first_chunk::<8>().ok_or(cut_off(8))?;
        let [g0, g1, e0, e1, l0, l1, l2, l3] = *head;
        let (group, element) = (u16::from_le_bytes([g0, g1]), u16::from_le_bytes([e0, e1]));
        let length = u32::from_le_bytes([l0, l1, l2, l3]);
        if group != 0 {
            return Err(CommandError::Group { byte, found: group });
        }
        if let Some(&(before, _)) = found.last().filter(|(before, _)| *before >= element) {
            return Err(CommandError::Order {
                byte,
                before,
                found: element,
            });
        }
        let value = value.split_at_checked(length as usize);
        let (value, after) = value.ok_or(cut_off(8 + u64::from(length)))?;
        found.push((element, value));
        rest = after;
    }
    Ok(found)
}

impl Command {
    /// Reads a whole command set.
    ///
    /// # Errors
    /// [`CommandError`].
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, CommandError> {
        let elements = elements(bytes)?;
        let value = |element: u16| elements.iter().find(|row| row.0 == element).map(|row| row.1);
        let number = |element: u16| match value(element) {
            None => Ok(None),
            Some([low, high]) => Ok(Some(u16::from_le_bytes([*low, *high]))),
            Some(other) => Err(CommandError::Length {
                element,
                found: other.len(),
                expected: 2,
            }),
        };
        let needed = |element| number(element)?.ok_or(CommandError::Missing { element });
        // Behind its own 12 bytes.
        match (value(GROUP_LENGTH), bytes.len().checked_sub(12)) {
            (Some([a, b, c, d]), Some(found)) if u32::from_le_bytes([*a, *b, *c, *d]) as usize == found => {}
            (Some([a, b, c, d]), found) => {
                let said = u32::from_le_bytes([*a, *b, *c, *d]);
                let found = found.unwrap_or(0);
                return Err(CommandError::GroupLength { said, found });
            }
            (_, _) => return Err(CommandError::Missing { element: GROUP_LENGTH }),
        }
        let field = needed(FIELD)?;
        let (class, instance) = (value(CLASS).unwrap_or_default(), value(INSTANCE).unwrap_or_default());
        let asked = match field {
            ECHO => Asked::Echo,
            STORE => Asked::Store {
                class: Uid::checked(class),
                instance: Uid::checked(instance),
            },
            CANCEL => Asked::Cancel,
            field if field & ANSWER != 0 => Asked::Answer,
            _ => Asked::Other,
        };
        let is_numbered = !matches!(asked, Asked::Cancel | Asked::Answer);
        let message = if is_numbered { needed(MESSAGE)? } else { 0 };
        Ok(Self {
            field,
            message,
            has_data_set: needed(DATA_SET)? != NO_DATA_SET,
            asked,
            class: class.to_vec(),
            instance: instance.to_vec(),
        })
    }

    /// The answer's command set. The comment is cut to what its element holds, and to plain characters.
    pub(crate) fn answer(&self, status: Status, comment: &str) -> Vec<u8> {
        let mut body = Vec::new();
        let echoed = |bytes: &[u8]| Uid::checked(bytes).map(|uid| uid.as_str().as_bytes().to_vec());
        if let Some(class) = echoed(&self.class) {
            put(&mut body, CLASS, &even(class, 0));
        }
        put(&mut body, FIELD, &(self.field | ANSWER).to_le_bytes());
        put(&mut body, ANSWERED, &self.message.to_le_bytes());
        put(&mut body, DATA_SET, &NO_DATA_SET.to_le_bytes());
        put(&mut body, STATUS, &status.code().to_le_bytes());
        if !comment.is_empty() {
            let plain = |c: char| c.is_ascii_graphic() && c != '\\' || c == ' ';
            let comment: String = comment.chars().filter(|c| plain(*c)).take(MAX_COMMENT).collect();
            put(&mut body, COMMENT, &even(comment.into_bytes(), b' '));
        }
        if let Some(instance) = echoed(&self.instance) {
            put(&mut body, INSTANCE, &even(instance, 0));
        }
        let mut bytes = Vec::new();
        put(&mut bytes, GROUP_LENGTH, &(body.len() as u32).to_le_bytes());
        bytes.extend(body);
        bytes
    }
}

fn put(bytes: &mut Vec<u8>, element: u16, value: &[u8]) {
    bytes.extend([0, 0]);
    bytes.extend(element.to_le_bytes());
    bytes.extend((value.len() as u32).to_le_bytes());
    bytes.extend(value);
}

fn even(mut value: Vec<u8>, padding: u8) -> Vec<u8> {
    if value.len() % 2 == 1 {
        value.push(padding);
    }
    value
}

/// A request as a peer writes it.
#[cfg(test)]
pub(crate) fn request(field: u16, message: u16, uids: [&str; 2], has_data_set: bool) -> Vec<u8> {
    let mut body = Vec::new();
    let uid = |text: &str| even(text.as_bytes().to_vec(), 0);
    put(&mut body, CLASS, &uid(uids[0]));
    put(&mut body, FIELD, &field.to_le_bytes());
    put(&mut body, MESSAGE, &message.to_le_bytes());
    let kind = if has_data_set { 0 } else { NO_DATA_SET };
    put(&mut body, DATA_SET, &kind.to_le_bytes());
    if !uids[1].is_empty() {
        put(&mut body, INSTANCE, &uid(uids[1]));
    }
    let mut bytes = Vec::new();
    put(&mut bytes, GROUP_LENGTH, &(body.len() as u32).to_le_bytes());
    bytes.extend(body);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CT: &str = "1.2.840.10008.5.1.4.1.1.2";

    #[test]
    fn a_request_is_read_and_answered_with_its_own_number() {
        let bytes = request(STORE, 7, [CT, "1.2.3"], true);
        let command = Command::parse(&bytes).unwrap();
        let uid = |text: &str| Uid::checked(text.as_bytes());
        assert_eq!(
            command.asked,
            Asked::Store {
                class: uid(CT),
                instance: uid("1.2.3")
            }
        );
        assert!(command.has_data_set && command.message == 7);
        let answer = command.answer(Status::NoMatch, "why\\ \u{1b}[2J not");
        let elements = elements(&answer).unwrap();
        let value = |element| elements.iter().find(|row| row.0 == element).unwrap().1;
        assert_eq!((value(FIELD), value(ANSWERED)), (&[1, 0x80][..], &[7, 0][..]));
        assert_eq!((value(STATUS), value(INSTANCE)), (&[0, 0xA9][..], &b"1.2.3\0"[..]));
        assert_eq!((value(COMMENT), value(DATA_SET)), (&b"why [2J not "[..], &[1, 1][..]));
        assert_eq!(value(GROUP_LENGTH), (answer.len() as u32 - 12).to_le_bytes());
        assert_eq!(Command::parse(&answer).unwrap().asked, Asked::Answer);
        let odd = Command::parse(&request(STORE, 1, [CT, "../1"], true)).unwrap();
        assert!(matches!(odd.asked, Asked::Store { instance: None, .. }));
        assert!(
            !odd.answer(Status::InvalidInstance, "")
                .windows(2)
                .any(|two| two == b"..")
        );
    }

    #[test]
    fn what_is_no_command_set_is_refused_by_place() {
        let good = request(STORE, 7, [CT, "1.2.3"], true);
        for end in 0..good.len() {
            assert!(Command::parse(&good[..end]).is_err(), "{end}");
        }
        let changed = |at: usize, byte: u8| {
            let mut bytes = good.clone();
            bytes[at] = byte;
            Command::parse(&bytes).unwrap_err()
        };
        assert!(matches!(changed(0, 8), CommandError::Group { byte: 0, found: 8 }));
        assert!(matches!(changed(8, 9), CommandError::GroupLength { .. }));
        assert!(matches!(changed(19, 255), CommandError::CutOff { byte: 12, .. }));
        assert!(matches!(changed(14, 0), CommandError::Order { byte: 12, .. }));
        let echo = [&good[..], &good[12..20]].concat();
        assert!(Command::parse(&echo).is_err());
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic_or_answer_what_is_no_uid(
            mut bytes in prop::collection::vec(any::<u8>(), 0..200),
            whole in any::<bool>(),
        ) {
            if whole && bytes.len() >= 12 {
                let length = bytes.len() as u32 - 12;
                bytes[..8].copy_from_slice(&[0, 0, 0, 0, 4, 0, 0, 0]);
                bytes[8..12].copy_from_slice(&length.to_le_bytes());
            }
            if let Ok(command) = Command::parse(&bytes) {
                let answer = command.answer(Status::NotUnderstood, &String::from_utf8_lossy(&bytes));
                prop_assert!(Command::parse(&answer).is_ok() && answer.len() < 400);
            }
        }
    }
}
