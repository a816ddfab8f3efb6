//! COMMAND: a fixed list of questions. Nothing that a client commands changes the run or opens a file.

use igtl::{Body, Command, DeviceName, Message, Metadata, Name, Status, Text};

use crate::letter::Letter;

/// What may be asked.
pub(crate) const KNOWN: [&str; 3] = ["Version", "Devices", "State"];

/// The answer to a command: what `answer` says of its name, or that it is none of ours.
pub(crate) fn answer(device: DeviceName, asked: &Command, answer: impl Fn(&str) -> Option<String>) -> Letter {
    let name = asked.name.as_str().unwrap_or_default();
    let known = KNOWN.contains(&name).then(|| answer(name)).flatten();
    let (title, content, metadata) = match known {
        Some(content) => {
            let metadata = Metadata::EMPTY.with("Result", Text::new("true"));
            (asked.name, content, metadata)
        }
        None => {
            let words = format!("this server answers {}, and nothing else", KNOWN.join(", "));
            let metadata = Metadata::EMPTY
                .with("Result", Text::new("false"))
                .with("ErrorCode", Text::new(&Status::ILLEGAL_INSTRUCTION.to_string()))
                .with("Error", Text::new(&words));
            // Where the C++ library puts what is wrong.
            (Name::new("unknown instruction").unwrap_or_default(), words, metadata)
        }
    };
    let body = Body::CommandAnswer(Command {
        number: asked.number,
        name: title,
        content: Text::new(&content),
    });
    Letter::new(Message {
        metadata,
        ..Message::new(device, body)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use igtl::{Limits, Version, decode};

    fn answered(name: &str) -> (Command, Metadata) {
        let asked = Command {
            number: 77,
            name: Name::new(name).unwrap(),
            content: Text::new("<Command FileName=\"/etc/passwd\"/>"),
        };
        let letter = answer(DeviceName::EMPTY, &asked, |name| Some(format!("said {name}")));
        let wire = letter.wire(Version::Two).unwrap();
        let bytes: Vec<u8> = wire.rest(0).iter().flat_map(|piece| piece.to_vec()).collect();
        let message = decode(&bytes, &Limits::POSES).unwrap().0;
        match message.body {
            Body::CommandAnswer(answer) => (answer, message.metadata),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_known_question_is_answered_under_its_number() {
        let (answer, metadata) = answered("Version");
        assert_eq!((answer.number, answer.content), (77, Text::new("said Version")));
        assert_eq!(metadata.get("Result"), Some(&Text::new("true")));
    }

    #[test]
    fn what_a_client_commands_beyond_the_list_is_an_unknown_instruction() {
        for name in ["SaveConfig", "UpdateTransform", "StartRecording", "version", ""] {
            let (answer, metadata) = answered(name);
            assert_eq!((answer.number, metadata.get("ErrorCode")), (77, Some(&Text::new("12"))));
            assert!(answer.content.to_string().contains("nothing else"));
        }
    }
}
