//! GET_, STT_, STP_ and RTS_: asking once, asking for a stream, ending it, and the answer to the last two.
//!
//! All are empty but STT_TDATA and STT_QTDATA (36 bytes: `u32` ms between two messages at least, name of a frame (32))
//! and RTS_ (one byte: 0 is success). A GET_ is answered by the message itself.

use crate::fault::{Fault, SizeRule};
use crate::fields::Fields;
use crate::malformed::Refusal;
use crate::name::{Name, TypeName};
use crate::wire::Reader;

/// What can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// TRANSFORM.
    Transform,
    /// TDATA.
    Tdata,
    /// QTDATA.
    Qtdata,
    /// POSITION.
    Position,
    /// QTRANS, which is POSITION by its other name.
    Qtrans,
    /// STATUS.
    Status,
    /// STRING.
    String,
    /// POINT.
    Point,
    /// IMAGE.
    Image,
    /// IMGMETA.
    ImageList,
    /// POLYDATA.
    PolyData,
    /// CAPABILITY.
    Capability,
}

/// How it is asked for. COMMAND has answers of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verb {
    /// GET_: once.
    Get,
    /// STT_: from now on.
    Start,
    /// STP_: no longer.
    Stop,
    /// RTS_: what became of the last two.
    Answer,
}

impl Kind {
    /// All of them with the name of their message and the one that stands behind GET_, STT_, STP_ and RTS_.
    const ALL: [(Self, &'static str, &'static str); 12] = [
        (Self::Transform, "TRANSFORM", "TRANS"),
        (Self::Tdata, "TDATA", "TDATA"),
        (Self::Qtdata, "QTDATA", "QTDATA"),
        (Self::Position, "POSITION", "POSITION"),
        (Self::Qtrans, "QTRANS", "QTRANS"),
        (Self::Status, "STATUS", "STATUS"),
        (Self::String, "STRING", "STRING"),
        (Self::Point, "POINT", "POINT"),
        (Self::Image, "IMAGE", "IMAGE"),
        (Self::ImageList, "IMGMETA", "IMGMETA"),
        (Self::PolyData, "POLYDATA", "POLYDATA"),
        (Self::Capability, "CAPABILITY", "CAPABIL"),
    ];

    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().map(|(kind, ..)| kind)
    }

    fn row(self) -> (&'static str, &'static str) {
        let row = Self::ALL.into_iter().find(|(kind, ..)| *kind == self);
        row.map_or(("", ""), |(_, message, short)| (message, short))
    }

    /// The type of the message.
    pub fn message(self) -> &'static str {
        self.row().0
    }

    /// The type of a query, at most 12 bytes.
    pub fn query(self, verb: Verb) -> String {
        format!("{}{}", verb.prefix(), self.row().1)
    }
}

impl Verb {
    const ALL: [Self; 4] = [Self::Get, Self::Start, Self::Stop, Self::Answer];

    const fn prefix(self) -> &'static str {
        match self {
            Self::Get => "GET_",
            Self::Start => "STT_",
            Self::Stop => "STP_",
            Self::Answer => "RTS_",
        }
    }
}

/// How often, and in which frame, tools are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Pace {
    /// Milliseconds between two messages at least; 0 for as many as there are.
    pub resolution_ms: u32,
    /// The frame; empty for the sender's own.
    pub frame: Name<32>,
}

/// A query or its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Query {
    /// Send one.
    Get(Kind),
    /// Send a stream.
    Start(Kind, Pace),
    /// End it.
    Stop(Kind),
    /// What became of it: 0 is success, 1 an error.
    Answer(Kind, u8),
}

impl Query {
    /// Which message asks so, of this type; `None` for types that are none of these.
    pub(crate) fn of(name: &TypeName) -> Option<(Verb, Kind)> {
        let text = name.as_str()?;
        let verb = Verb::ALL.into_iter().find(|verb| text.starts_with(verb.prefix()))?;
        let rest = text.strip_prefix(verb.prefix())?;
        let row = Kind::ALL.into_iter().find(|(_, _, short)| *short == rest)?;
        Some((verb, row.0))
    }

    /// What it asks for.
    pub const fn kind(&self) -> Kind {
        match *self {
            Self::Get(kind) | Self::Start(kind, _) | Self::Stop(kind) | Self::Answer(kind, _) => kind,
        }
    }

    /// How.
    pub const fn verb(&self) -> Verb {
        match self {
            Self::Get(_) => Verb::Get,
            Self::Start(..) => Verb::Start,
            Self::Stop(_) => Verb::Stop,
            Self::Answer(..) => Verb::Answer,
        }
    }

    const fn is_paced(kind: Kind) -> bool {
        matches!(kind, Kind::Tdata | Kind::Qtdata)
    }

    pub(crate) fn read(verb: Verb, kind: Kind, reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        let paced = verb == Verb::Start && Self::is_paced(kind);
        let size = match verb {
            Verb::Answer => 1,
            _ if paced => 36,
            _ => 0,
        };
        reader.sized(SizeRule::Exactly(size))?;
        Ok(match verb {
            Verb::Get => Self::Get(kind),
            Verb::Start if paced => Self::Start(
                kind,
                Pace {
                    resolution_ms: reader.u32()?,
                    frame: reader.name("the name of a frame")?,
                },
            ),
            Verb::Start => Self::Start(kind, Pace::default()),
            Verb::Stop => Self::Stop(kind),
            Verb::Answer => Self::Answer(kind, reader.u8()?),
        })
    }

    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        match *self {
            Self::Start(kind, pace) if Self::is_paced(kind) => {
                out.extend(pace.resolution_ms.to_be_bytes());
                out.extend(pace.frame.field());
            }
            Self::Start(_, pace) if pace != Pace::default() => {
                return Err(Fault::Value {
                    field: "the time between two messages",
                    found: pace.resolution_ms.into(),
                    allowed: "0 without a frame, where neither TDATA nor QTDATA is asked for",
                });
            }
            Self::Answer(_, status) => out.push(status),
            _ => {}
        }
        Ok(())
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        fields.add("of", self.kind().message());
        match self {
            Self::Start(kind, pace) if Self::is_paced(*kind) => {
                fields.add("resolution_ms", pace.resolution_ms);
                fields.add("frame", &pace.frame);
            }
            Self::Answer(_, status) => fields.add("status", *status),
            _ => {}
        }
    }
}
