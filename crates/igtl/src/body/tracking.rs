//! TDATA and QTDATA: the tools of one instant. A tool that is not seen is left out by the protocol; PLUS sends it with
//! its last matrix and says so in the metadata ([`crate::tool_status`]).
//!
//! Each tool of a TDATA has 70 bytes: name (20), kind (1), nothing (1), matrix (48). Of a QTDATA 50: name, kind,
//! nothing, place (12), quaternion `x y z w` (16).

use std::collections::BTreeSet;

use super::pose::{Matrix, Quaternion};
use crate::fault::Fault;
use crate::fields::Fields;
use crate::limits::Limits;
use crate::malformed::Refusal;
use crate::name::DeviceName;
use crate::wire::{Reader, put_reals};

const TDATA_BYTES: u64 = 70;
const QTDATA_BYTES: u64 = 50;

/// What a tool's pose means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToolKind {
    /// The tracker itself.
    Tracker,
    /// All six degrees of freedom.
    Six,
    /// The tip alone: the orientation means nothing.
    Three,
    /// Tip and axis: the turn about the axis means nothing.
    Five,
}

impl ToolKind {
    fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        let before = reader.clone();
        match reader.u8()? {
            1 => Ok(Self::Tracker),
            2 => Ok(Self::Six),
            3 => Ok(Self::Three),
            4 => Ok(Self::Five),
            found => Err(before.refuse(Fault::Value {
                field: "the kind of a tool",
                found: found.into(),
                allowed: "1 to 4",
            })),
        }
    }

    /// The number on the wire.
    pub const fn number(self) -> u8 {
        match self {
            Self::Tracker => 1,
            Self::Six => 2,
            Self::Three => 3,
            Self::Five => 4,
        }
    }

    /// In a word.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Tracker => "tracker",
            Self::Six => "6D",
            Self::Three => "3D",
            Self::Five => "5D",
        }
    }
}

/// A pose in a list of tools.
pub(crate) trait Pose: Copy {
    const BYTES: u64;
    fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal>;
    fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault>;
    fn fields(&self, prefix: &str, fields: &mut Fields);
}

impl Pose for Matrix {
    const BYTES: u64 = TDATA_BYTES;
    fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        Self::read(reader)
    }
    fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        self.write(out)
    }
    fn fields(&self, prefix: &str, fields: &mut Fields) {
        self.fields(prefix, fields);
    }
}

/// The pose of a tool of a QTDATA.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placed {
    /// Millimetres.
    pub place: [f32; 3],
    /// The orientation.
    pub quaternion: Quaternion,
}

impl Pose for Placed {
    const BYTES: u64 = QTDATA_BYTES;
    fn read(reader: &mut Reader<'_>) -> Result<Self, Refusal> {
        Ok(Self {
            place: reader.reals("a place")?,
            quaternion: reader.reals("a quaternion")?,
        })
    }
    fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        put_reals(out, &self.place, "a place")?;
        put_reals(out, &self.quaternion, "a quaternion")
    }
    fn fields(&self, prefix: &str, fields: &mut Fields) {
        fields.add(format!("{prefix}place_mm"), &self.place[..]);
        fields.add(format!("{prefix}quaternion_xyzw"), &self.quaternion[..]);
    }
}

/// A tool with its pose: [`Matrix`] in a TDATA, [`Placed`] in a QTDATA.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tool<P> {
    /// Its name; no other tool of the message has it.
    pub name: DeviceName,
    /// What its pose means.
    pub kind: ToolKind,
    /// The pose.
    pub pose: P,
}

pub(crate) fn read<P: Pose>(reader: &mut Reader<'_>, limits: &Limits) -> Result<Vec<Tool<P>>, Refusal> {
    let count = reader.elements(P::BYTES, "tools", limits.elements)?;
    let mut tools = Vec::with_capacity(count);
    let mut seen = BTreeSet::new();
    for _ in 0..count {
        let at = reader.at();
        let name = reader.name("the name of a tool")?;
        unique(&mut seen, name).map_err(|fault| Refusal { fault, at })?;
        let kind = ToolKind::read(reader)?;
        reader.u8()?;
        let pose = P::read(reader)?;
        tools.push(Tool { name, kind, pose });
    }
    Ok(tools)
}

fn unique(seen: &mut BTreeSet<DeviceName>, name: DeviceName) -> Result<(), Fault> {
    if seen.insert(name) {
        return Ok(());
    }
    Err(Fault::Twice {
        what: "the tool",
        shown: name.to_string(),
    })
}

pub(crate) fn write<P: Pose>(tools: &[Tool<P>], out: &mut Vec<u8>) -> Result<(), Fault> {
    let mut seen = BTreeSet::new();
    for tool in tools {
        unique(&mut seen, tool.name)?;
        out.extend(tool.name.field());
        out.extend([tool.kind.number(), 0]);
        tool.pose.write(out)?;
    }
    Ok(())
}

pub(crate) fn fields<P: Pose>(tools: &[Tool<P>], fields: &mut Fields) {
    fields.add("tools", tools.len());
    for (number, tool) in tools.iter().enumerate() {
        let prefix = format!("tools[{number}].");
        fields.add(format!("{prefix}name"), &tool.name);
        fields.add(format!("{prefix}kind"), tool.kind.word());
        tool.pose.fields(&prefix, fields);
    }
}
