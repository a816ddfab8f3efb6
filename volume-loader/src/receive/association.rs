//! One association, from its request to its end.

mod agree;
mod incoming;
mod spoken;
mod tally;

use std::io::{Read, Write};

use bus::clock::monotonic_ns;
use dicom_ul::pdu::{AbortRQServiceProviderReason as Reason, PDataValue, Pdu};
use scene::PacsSpec;

use self::incoming::{Arrived, Incoming};
use self::tally::Tally;
use super::command::{Asked, Command, Status};
use super::contexts::{Agreed, Class};
use super::limits::Limits;
use super::message::{Messages, Step};
use super::outcome::{Ended, Outcome};
use super::store::Store;
use super::wire::{CLOSING_NS, Wire, WireError};

pub(crate) use self::agree::{Unanswered, agree};
pub use self::spoken::serve_bytes;

/// Refusals of an association that are told each; more of them are counted.
const TOLD: u64 = 5;

/// Who may send, and how much.
#[derive(Debug, Clone)]
pub struct Rules {
    /// Titles.
    pub pacs: PacsSpec,
    /// Bounds.
    pub limits: Limits,
}

/// How far an association is: asked of it now and then.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Count {
    /// Instances that are new or were there.
    pub kept: u64,
    /// Bytes of data sets.
    pub bytes: u64,
}

/// Why an association goes no further.
enum Over {
    Released,
    Aborted,
    Wire(WireError),
    /// The peer does what DICOM has not, or too much of it; with the reason that it is told.
    Violation(Reason, String),
}

impl From<WireError> for Over {
    fn from(error: WireError) -> Self {
        Self::Wire(error)
    }
}

/// Where an association takes what it needs.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    pub rules: &'a Rules,
    pub store: &'a Store,
    /// Says something to a person.
    pub tell: &'a dyn Fn(&str),
}

/// An association that goes on.
pub(crate) struct Association<'a, 'w, S> {
    wire: &'a mut Wire<'w, S>,
    place: Place<'a>,
    agreed: Agreed,
    messages: Messages,
    incoming: Option<Incoming>,
    tally: Tally,
    count: Count,
    /// Commands in all.
    commands: u64,
    /// How long was waited for this message, ns, and bytes of it.
    waited_ns: i64,
    came: u64,
    /// When the last instance came that is kept, or the association began.
    kept_ns: i64,
}

impl<'a, 'w, S: Read + Write> Association<'a, 'w, S> {
    pub(crate) fn new(wire: &'a mut Wire<'w, S>, place: Place<'a>, agreed: Agreed) -> Self {
        Self {
            wire,
            place,
            agreed,
            messages: Messages::default(),
            incoming: None,
            tally: Tally::default(),
            count: Count::default(),
            commands: 0,
            waited_ns: 0,
            came: 0,
            kept_ns: monotonic_ns(),
        }
    }

    /// Receives until it is over.
    pub(crate) fn run(mut self, progress: &mut dyn FnMut(Count)) -> Outcome {
        let over = loop {
            if let Err(over) = self.step() {
                break over;
            }
            progress(self.count);
        };
        // What is not at its end is no instance.
        self.tally.refused += u64::from(self.incoming.take().is_some_and(|incoming| incoming.is_instance));
        let ended = match &over {
            Over::Released => Ended::Released,
            Over::Wire(WireError::Stopped) => Ended::Stopped,
            Over::Aborted => Ended::BrokenOff("the sender broke it off (A-ABORT)".to_owned()),
            Over::Wire(error) => Ended::BrokenOff(error.to_string()),
            Over::Violation(_, why) => Ended::BrokenOff(why.clone()),
        };
        let (bytes, store) = (self.count.bytes, self.place.store);
        let outcome = std::mem::take(&mut self.tally).outcome(ended, bytes, store);
        match over {
            // After the series have their names: who is told that it is released may look for them.
            Over::Released => drop(self.wire.send(&Pdu::ReleaseRP)),
            Over::Aborted | Over::Wire(WireError::Closed | WireError::Io(_)) => return outcome,
            Over::Wire(WireError::Malformed(_) | WireError::TooLong(_)) => self.wire.abort(Reason::InvalidPduParameter),
            Over::Wire(_) => self.wire.abort(Reason::ReasonNotSpecified),
            Over::Violation(reason, _) => self.wire.abort(reason),
        }
        self.wire.drain(monotonic_ns() + CLOSING_NS);
        outcome
    }

    /// Until when the next PDU must be there, ns. What this program itself takes is not the peer's time.
    fn until_ns(&self, now_ns: i64) -> Result<i64, Over> {
        let silence_ns = self.place.rules.limits.silence_ns();
        let mut patience_ns = silence_ns;
        if self.messages.is_within() {
            let slow_ns = self.came.saturating_mul(1_000_000_000 / Limits::SLOWEST);
            let allowed_ns = silence_ns.saturating_add(i64::try_from(slow_ns).unwrap_or(i64::MAX));
            patience_ns = patience_ns.min(allowed_ns.saturating_sub(self.waited_ns));
        } else if now_ns.saturating_sub(self.kept_ns) > silence_ns.saturating_mul(i64::from(Limits::IDLE)) {
            let why = "no instance came for a long time".to_owned();
            return Err(Over::Violation(Reason::ReasonNotSpecified, why));
        }
        Ok(now_ns.saturating_add(patience_ns))
    }

    fn step(&mut self) -> Result<(), Over> {
        let now_ns = monotonic_ns();
        let until_ns = self.until_ns(now_ns)?;
        let pdu = self.wire.read(until_ns)?;
        self.waited_ns += monotonic_ns() - now_ns;
        match pdu {
            Pdu::PData { data } => data.iter().try_for_each(|value| self.fragment(value)),
            Pdu::ReleaseRQ if !self.messages.is_within() => Err(Over::Released),
            Pdu::AbortRQ { .. } => Err(Over::Aborted),
            Pdu::Unknown { pdu_type, .. } => {
                let why = format!("a PDU of the unknown type {pdu_type:#04x}");
                Err(Over::Violation(Reason::UnrecognizedPdu, why))
            }
            Pdu::ReleaseRQ => {
                let why = "its release in the middle of a message".to_owned();
                Err(Over::Violation(Reason::UnexpectedPdu, why))
            }
            _ => Err(Over::Violation(Reason::UnexpectedPdu, "a PDU out of turn".to_owned())),
        }
    }

    fn fragment(&mut self, value: &PDataValue) -> Result<(), Over> {
        if !self.messages.is_within() {
            (self.waited_ns, self.came) = (0, 0);
        }
        self.came += value.data.len() as u64;
        let step = self.messages.take(value, &self.agreed.contexts);
        let step = step.map_err(|error| Over::Violation(Reason::InvalidPduParameter, error.to_string()))?;
        match step {
            Step::Begun => Ok(()),
            Step::Command(id, command) => self.command(id, command),
            Step::Data { bytes, is_last } => {
                let Place { rules, store, .. } = self.place;
                let limits = &rules.limits;
                if let Some(incoming) = &mut self.incoming {
                    incoming.data(bytes, store, limits, self.count.bytes);
                }
                self.count.bytes += bytes.len() as u64;
                // What is passed over is bounded, too.
                if self.count.bytes > limits.association_bytes.saturating_add(limits.instance_bytes) {
                    let why = format!("it goes on sending beyond {} bytes", limits.association_bytes);
                    return Err(Over::Violation(Reason::ReasonNotSpecified, why));
                }
                if is_last { self.end() } else { Ok(()) }
            }
        }
    }

    fn command(&mut self, id: u8, command: Command) -> Result<(), Over> {
        let Place { rules, store, .. } = self.place;
        let limits = &rules.limits;
        self.commands += 1;
        if self.commands > limits.instances.saturating_mul(2).saturating_add(1000) {
            let why = format!("it goes on asking beyond {} instances", limits.instances);
            return Err(Over::Violation(Reason::ReasonNotSpecified, why));
        }
        let Some(context) = self.agreed.contexts.get(&id) else {
            return Ok(());
        };
        let unrecognized = (Status::Unrecognized, "nothing but storage and verification".to_owned());
        match (&command.asked, command.has_data_set) {
            (Asked::Answer, _) => {
                let why = "an answer to nothing that was asked".to_owned();
                Err(Over::Violation(Reason::UnexpectedPduParameter, why))
            }
            (Asked::Store { class, instance }, true) => {
                self.tally.instances += 1;
                let (class, instance) = (class.clone(), instance.clone());
                let announced = [class.as_ref(), instance.as_ref()];
                let about = (store, limits, self.tally.instances);
                self.incoming = Some(Incoming::instance(id, command, context, announced, about));
                Ok(())
            }
            (Asked::Store { .. }, false) => {
                self.tally.instances += 1;
                self.refuse(&command, "it has no data set");
                self.answer(id, &command, Status::NotUnderstood, "it has no data set")
            }
            (Asked::Echo, false) if context.class == Class::Verification => {
                self.tally.echoes += 1;
                self.answer(id, &command, Status::Success, "")
            }
            (Asked::Cancel, false) => Ok(()),
            (_, true) => {
                self.incoming = Some(Incoming::unwanted(id, command, unrecognized));
                Ok(())
            }
            (_, false) => self.answer(id, &command, unrecognized.0, &unrecognized.1),
        }
    }

    fn answer(&mut self, id: u8, command: &Command, status: Status, comment: &str) -> Result<(), Over> {
        let answer = command.answer(status, comment);
        Ok(self.wire.send_command(id, &answer, self.agreed.peer_pdu)?)
    }

    fn refuse(&mut self, command: &Command, why: &str) {
        self.tally.refused += 1;
        let name = match &command.asked {
            Asked::Store {
                instance: Some(uid), ..
            } => format!("instance {uid}"),
            _ => "an instance".to_owned(),
        };
        match self.tally.refused {
            ..=TOLD => (self.place.tell)(&format!("refused {name}: {why}")),
            _ if self.tally.refused == TOLD + 1 => (self.place.tell)("refused more of them, which are counted"),
            _ => {}
        }
    }

    /// A data set is at its end.
    fn end(&mut self) -> Result<(), Over> {
        let Some(incoming) = self.incoming.take() else {
            return Ok(());
        };
        let Some(context) = self.agreed.contexts.get(&incoming.context) else {
            return Ok(());
        };
        let is_slices = context.class == Class::Slices;
        let Arrived {
            context: id,
            command,
            is_instance,
            ids,
            fate,
        } = incoming.end(context, self.place.store);
        if let Some((ids, was_hidden)) = ids {
            let placed = fate.as_ref().ok().copied();
            self.tally.arrived(ids, was_hidden, is_slices, placed);
        }
        match fate {
            Ok(_) => {
                self.count.kept += 1;
                self.kept_ns = monotonic_ns();
                self.answer(id, &command, Status::Success, "")
            }
            Err((status, why)) => {
                if is_instance {
                    self.refuse(&command, &why);
                }
                self.answer(id, &command, status, &why)
            }
        }
    }
}
