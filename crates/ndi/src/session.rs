//! What a client and a device do, as step functions: an event and the time go in, what is to be done comes out.
//!
//! A session knows no socket. Its driver hands over what happens as an [`Event`], carries out the [`Action`]s, and
//! hands over [`Event::Tick`] at least as often as a time limit is to be kept, and as frames are wanted. Times are ns
//! of any clock that does not go back.
//!
//! # Late replies
//!
//! A reply does not say which command it answers. One that comes after its time limit would be taken for the answer to
//! the next command, and so on for ever. So whenever a reply is late, refused or none that was asked for, the client
//! says nothing until the device has been silent for a while, drops what comes, and then asks VER: only when the text
//! comes that VER gave before does it go on.

mod client;
mod device;
mod rules;
mod setup;

pub use client::Client;
pub use device::{Device, DeviceRules, DeviceTool};
pub use rules::{ClientRules, Poll, Tool};

use crate::answer::ErrorCode;
use crate::bx2::Alert;
use crate::frame::Frame;
use crate::handle::Handle;
use crate::malformed::Malformed;
use crate::status::SystemStatus;
use crate::watch::FrameStep;

/// What happened on a connection.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// It was made.
    Connected,
    /// Bytes came.
    Bytes(&'a [u8]),
    /// Time went by.
    Tick,
    /// The connection is gone, whoever closed it.
    Closed,
}

/// What is to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// Send this, in one call.
    Send(Vec<u8>),
    /// Change the speed of the serial line to these five digits of COMM, now.
    Speed(String),
    /// Say this, or count it.
    Tell(Notice),
    /// A frame that was not seen before, and is not one of before: never [`FrameStep::Same`], [`FrameStep::Back`] or
    /// [`FrameStep::Anew`]. Of [`FrameStep::Stands`] nothing in it has a pose or a place.
    Publish(Frame, FrameStep),
    /// Close the connection. Nothing else is to be done any more.
    Close(Reason),
}

/// What a person may want to know. None of it ends the session.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Notice {
    /// The device has said which it is.
    #[error("the device is {0:?}")]
    Version(String),
    /// A tool of the session has its handle.
    #[error("tool {name:?} is handle {handle}")]
    Loaded {
        /// The tool.
        name: String,
        /// Its handle.
        handle: Handle,
    },
    /// The device gave one handle to two tools: the definition of the second would take the place of the first.
    #[error("handle {0} was given twice")]
    HandleTwice(Handle),
    /// Set up; from now on it is polled so.
    #[error("tracking; polled by {0}")]
    Tracking(Poll),
    /// The device does not know this way of polling.
    #[error("the device does not know {poll} ({error})")]
    NotKnown {
        /// The way.
        poll: Poll,
        /// What it said.
        error: ErrorCode,
    },
    /// A command was done with a doubt.
    #[error("{command} was answered WARNING{}", .code.map_or(String::new(), |code| format!("{code:02X}")))]
    Warning {
        /// Which.
        command: String,
        /// The device's number of it.
        code: Option<u8>,
    },
    /// The device refused a poll.
    #[error("{command} was answered {error}")]
    Refused {
        /// Which.
        command: String,
        /// What it said.
        error: ErrorCode,
    },
    /// No answer came in time; it may still come, and is not waited for.
    #[error("{command} was not answered within {limit_ns} ns")]
    Unanswered {
        /// Which.
        command: String,
        /// The time limit.
        limit_ns: i64,
    },
    /// Something came that was not asked for, or is no answer to what was.
    #[error("what came is no answer to {command}")]
    NotAnAnswer {
        /// What was asked last; empty for nothing.
        command: String,
    },
    /// A reply was refused.
    #[error("{0}")]
    Malformed(Malformed),
    /// The device began anew, unasked: it is set up again.
    #[error("the device was reset: it is set up again")]
    Reset,
    /// Client and device agree again on what answers what.
    #[error("in step again after {tries} tries")]
    InStep {
        /// How often VER was asked.
        tries: u32,
    },
    /// The device has taken no frame since the last poll: this one was there before, and is not given again.
    #[error("frame {number} was polled before")]
    SameFrame {
        /// Its number.
        number: u32,
    },
    /// The device has taken no frame since the last poll, and sent none.
    #[error("no new frame")]
    NoFrame,
    /// The device's numbers of frames are no longer those of before.
    #[error("frame {to} after frame {from}")]
    Jump {
        /// The last number.
        from: u32,
        /// The new one.
        to: u32,
    },
    /// The number stands still, and the device's time goes on: frames are given without a pose in them.
    #[error("the number of the device's frames stands still while their time goes on: they are not used")]
    Stands {
        /// The number.
        number: u32,
    },
    /// The device was switched on since its last frame: it is given.
    #[error("frame {to} after frame {from}: the device was started anew")]
    Restarted {
        /// The last number.
        from: u32,
        /// The new one.
        to: u32,
    },
    /// The frame may be one of before: it is not given.
    #[error("frame {to} after frame {from}: a reply of before, which is not used")]
    Back {
        /// The last number.
        from: u32,
        /// Its own.
        to: u32,
    },
    /// Frames went back and on from there: the device is set up again.
    #[error(
        "{frames} frames one after the other went on from an earlier number: the device counts anew, and is set up again"
    )]
    CountsAnew {
        /// How many.
        frames: u32,
    },
    /// A tool of the session is there no longer.
    #[error("the tool of handle {0} was unplugged")]
    Unplugged(Handle),
    /// The device says this of itself.
    #[error("{}", .0.words())]
    Alert(Alert),
    /// The device's own status has changed.
    #[error("the device's status is {:#06x}: {}", .0.0, .0.words().join(", "))]
    System(SystemStatus),
}

/// Why a connection is closed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// More tools than a device tracks.
    #[error("{found} tools; allowed are {most}")]
    TooManyTools {
        /// How many.
        found: usize,
        /// The bound.
        most: usize,
    },
    /// The device refuses a step of its set-up.
    #[error("{command} was answered {error}")]
    Refused {
        /// Which.
        command: String,
        /// What it said.
        error: ErrorCode,
    },
    /// Nothing answers.
    #[error("no answer that fits, after {tries} tries")]
    NoAnswer {
        /// How often it was asked.
        tries: u32,
    },
    /// The device does not stop sending.
    #[error("the device was not silent within {ns} ns, and what it sends was not asked for")]
    NeverQuiet {
        /// How long it was waited for.
        ns: i64,
    },
    /// It was set up again and again without a frame.
    #[error("set up {count} times without a frame")]
    TooManySetups {
        /// How often.
        count: u32,
    },
    /// Poll after poll was refused, by the device or here.
    #[error("{count} polls one after the other were refused; the last: {last}")]
    TooManyRefused {
        /// How many.
        count: u32,
        /// The last of them.
        last: Box<Notice>,
    },
}
