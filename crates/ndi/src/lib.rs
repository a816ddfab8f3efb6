//! Floor 1: the combined API of NDI's localizers, as bytes, as types and as sessions. No input or output, no clock.
//!
//! * [`Command`] is what a device is sent; [`Decoder`] takes what it answers in pieces and gives [`Reply`]s whose CRCs
//!   are right, or what is wrong by name ([`Malformed`], [`Fault`]). [`Answer`] says what a text means; [`parse_tx`],
//!   [`parse_bx`], [`parse_bx2`], [`parse_phsr`], [`parse_phinf`] read the rest. All have [`Fields`] for text and JSON.
//! * [`Why`] is the one word for every status that a device states ([`status`]). A [`Frame`] has for each tool a pose
//!   or a reason: what is unknown, lost or not a number never comes out as a pose. [`FrameWatch`] tells a new frame from
//!   one that was polled before.
//! * [`Rom`] is a tool definition that was checked before it is written to a device.
//! * [`session`]: what a client and a device do, as step functions.
//!
//! The facts of the wire are those of NDI's programmer's guides (Polaris IL-1070101, Polaris Vega IL-1070259). Lengths
//! are mm in the device's own frame, quaternions w x y z, times ns of the device's own clock.
//!
//! ```
//! use ndi::{Command, Decoder, Limits, Reply};
//!
//! assert_eq!(Command::Init.to_bytes(true), b"INIT:E3A5\r");
//! let mut decoder = Decoder::new(Limits::DEFAULT);
//! assert_eq!(decoder.feed(&mut &b"OKAYA8"[..]), None);
//! assert_eq!(decoder.feed(&mut &b"96\r"[..]), Some(Ok(Reply::Text("OKAY"))));
//! ```

#![forbid(unsafe_code)]

mod answer;
mod bx2;
mod command;
pub mod crc;
mod decode;
mod fault;
mod fields;
mod frame;
mod handle;
mod limits;
mod malformed;
mod options;
mod polled;
mod ports;
mod pose;
mod rom;
pub mod session;
pub mod status;
mod text;
mod watch;
mod why;
mod wire;

pub use answer::{Answer, ErrorCode};
pub use bx2::{Alert, Bx2, Bx2Frame, Bx2Marker, Bx2Markers, Bx2Tool, FrameKind, bx2_body, parse_bx2};
pub use command::{Command, WIRELESS};
pub use decode::{Decoder, Reply, binary_reply, text_reply};
pub use fault::Fault;
pub use fields::{Field, Fields, Value};
pub use frame::{Frame, Marker, Sight};
pub use handle::Handle;
pub use limits::{Limits, MOST_LOADED, MOST_TOOLS};
pub use malformed::{Malformed, Recovery};
pub use options::{Bx2Options, Markers, ReplyOption};
pub use polled::bx::{bx_body, parse_bx};
pub use polled::tx::{parse_tx, tx_text};
pub use polled::{Information, Polled, PolledTool, Single, Spot, Spots};
pub use ports::{Port, PortInfo, ToolInfo, parse_phinf, parse_phrq, parse_phsr, phsr_fields, phsr_text};
pub use pose::{MOST_MM, Pose, PoseError, Transform, UNIT_TOLERANCE, check_place};
pub use rom::{MOST_MARKERS, Rom, RomError, Shape, checksum};
pub use watch::{FrameStep, FrameWatch};
pub use why::Why;
