//! Floor 1: OpenIGTLink, as bytes, as types and as sessions. No input or output, no clock.
//!
//! * [`Decoder`] takes a stream in pieces and gives [`Message`]s, or what is wrong by name ([`Malformed`], [`Fault`]):
//!   a header is checked and its body bounded ([`Limits`]) before anything is held for it. [`decode`](fn@decode) does
//!   the same with a whole message.
//! * [`Message::encode`] writes one, the voxels of an image from where they lie.
//! * [`Message::fields`] says all of a message as lines or as JSON.
//! * [`rotation`], [`check_grid`], [`StampWatch`] and [`ToolStatus`] judge what is well-formed and yet not to be
//!   believed: numbers stay as they came, and are measured.
//! * [`session`]: what a client and a server do, as step functions.
//!
//! The facts of the wire are those of the protocol's documents (version 3) and of the C++ library OpenIGTLink 3.
//! Lengths are mm, places in frames that the peers agree on; patients are RAS on the wire ([`frame`]). Times are ns.
//!
//! ```
//! use igtl::{Body, DeviceName, Decoder, Limits, Matrix, Message};
//!
//! let sent = Message::new(DeviceName::new("ToolToRas")?, Body::Transform(Matrix::IDENTITY));
//! let bytes = sent.to_vec()?;
//! let mut decoder = Decoder::new(Limits::POSES);
//! let (first, mut rest) = (&bytes[..70], &bytes[70..]);
//! assert!(decoder.feed(&mut &first[..]).is_none());
//! assert_eq!(decoder.wants(), 36);
//! assert_eq!(decoder.feed(&mut rest), Some(Ok(sent)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![forbid(unsafe_code)]

mod body;
pub mod crc;
mod decode;
mod encode;
mod fault;
pub mod fields;
pub mod frame;
mod grid;
mod header;
mod limits;
mod malformed;
mod message;
mod metadata;
mod name;
pub mod rotation;
pub mod session;
mod stamp;
mod text;
mod tool_status;
mod wire;

pub use body::Body;
pub use body::attribute::{Attribute, AttributeKind};
pub use body::cells::Cells;
pub use body::image::{ByteOrder, Image, Space};
pub use body::lists::{ImageEntry, Landmark};
pub use body::polydata::PolyData;
pub use body::pose::{Matrix, Orientation, Position, Quaternion};
pub use body::query::{Kind, Pace, Query, Verb};
pub use body::scalar::Scalar;
pub use body::tracking::{Placed, Tool, ToolKind};
pub use body::words::{Command, Status};
pub use decode::{Decoder, decode};
pub use encode::Encoded;
pub use fault::{Fault, SizeRule};
pub use grid::{GridError, check_grid};
pub use header::{HEADER_BYTES, Header, Version};
pub use limits::{Limits, MOST_BODY};
pub use malformed::{Malformed, Recovery};
pub use message::Message;
pub use metadata::{Entry, Metadata};
pub use name::{DeviceName, Name, NameError, TypeName};
pub use stamp::{Stamp, StampError, StampWatch};
pub use text::{Text, US_ASCII, UTF_8};
pub use tool_status::{TRANSFORM_STATUS, ToolStatus};
