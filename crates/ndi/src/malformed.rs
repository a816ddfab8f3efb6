//! A refused reply: what is wrong with it, where, and how the next one can be found.

use crate::fault::Fault;
use crate::fields::Fields;

/// What may be done with a stream after a reply of it was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recovery {
    /// Its end was found: the next reply begins behind it.
    NextReply,
    /// Nothing says where the next reply begins: wait until the device is silent, then ask anew.
    Silence,
}

/// A reply or a command that was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("byte {at} of {what}: {fault}")]
pub struct Malformed {
    /// What is wrong.
    pub fault: Fault,
    /// The byte at which it was found, from 0 at the start of the reply (of its body, for a binary one that is whole).
    pub at: u64,
    /// Of what.
    pub what: &'static str,
    /// How the stream goes on.
    pub recovery: Recovery,
}

impl Malformed {
    /// All of it, by name.
    pub fn fields(&self) -> Fields {
        let mut fields = Fields::default();
        fields.add("error", self.fault.to_string());
        fields.add("of", self.what);
        fields.add("byte", self.at);
        let goes_on = self.recovery == Recovery::NextReply;
        fields.add("stream", if goes_on { "goes on" } else { "needs silence" });
        if let Some(advice) = self.advice() {
            fields.add("advice", advice);
        }
        fields
    }

    /// What a person can do about it, where there is something.
    pub const fn advice(&self) -> Option<&'static str> {
        match self.fault {
            Fault::Byte { .. } => {
                Some("check that a localizer of NDI listens at this port; a lost byte looks the same")
            }
            Fault::TextCrc { .. } | Fault::BodyCrc { .. } | Fault::HeaderCrc { .. } => {
                Some("check the cable; on a serial line, that both ends have the same speed")
            }
            Fault::BodyLimit { .. } => Some("raise the limit of the body if so many markers are wanted"),
            _ => None,
        }
    }
}

/// A fault and the byte at which it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Refusal {
    pub(crate) fault: Fault,
    pub(crate) at: u64,
}

impl Refusal {
    /// In a reply whose end is known.
    pub(crate) fn of(self, what: &'static str) -> Malformed {
        Malformed {
            fault: self.fault,
            at: self.at,
            what,
            recovery: Recovery::NextReply,
        }
    }
}
