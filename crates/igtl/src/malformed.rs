//! A refused message: what is wrong with it, where, whose it was, and whether the stream can go on.

use crate::fault::Fault;
use crate::fields::Fields;
use crate::name::{DeviceName, TypeName};

/// What may be done with a stream after a message of it was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recovery {
    /// The header says where the next message begins: go on there.
    NextMessage,
    /// Nothing says where the next message begins, or going there would cost too much: close the stream.
    Close,
}

/// A message that was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} from {:?}, byte {at} of the message: {fault}", named(.kind), .device)]
pub struct Malformed {
    /// What is wrong.
    pub fault: Fault,
    /// The byte at which it was found, from 0 at the start of the header.
    pub at: u64,
    /// The type in its header; empty where there is none that can be read.
    pub kind: TypeName,
    /// The device in its header; likewise.
    pub device: DeviceName,
    /// Whether the stream can go on.
    pub recovery: Recovery,
}

fn named(kind: &TypeName) -> String {
    if kind.is_empty() {
        "a message".to_owned()
    } else {
        kind.to_string()
    }
}

impl Malformed {
    /// All of it, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        fields.add("error", self.fault.to_string());
        fields.add("type", &self.kind);
        fields.add("device", &self.device);
        fields.add("byte", self.at);
        let goes_on = self.recovery == Recovery::NextMessage;
        fields.add("stream", if goes_on { "goes on" } else { "closed" });
        if let Some(advice) = self.advice() {
            fields.add("advice", advice);
        }
        fields
    }

    /// What a person can do about it, where there is something.
    pub const fn advice(&self) -> Option<&'static str> {
        match self.fault {
            Fault::Protocol(_) => Some("check the port: another program dials it"),
            Fault::Version { .. } => {
                Some("check that the peer speaks OpenIGTLink; a stream that lost a byte looks the same")
            }
            Fault::BodyLimit { .. } => Some("raise the limit of the body if such messages are wanted"),
            Fault::Crc { .. } => Some("switch on the CRC at the sender"),
            Fault::Twice { .. } => Some("give the tools names that differ in their first 20 bytes"),
            Fault::NotFinite { .. } => Some("look at what the sender does with a tool that it does not see"),
            _ => None,
        }
    }
}

/// A fault, and the byte of what was being read at which it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Refusal {
    pub(crate) fault: Fault,
    pub(crate) at: u64,
}
