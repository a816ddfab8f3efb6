//! The contents of messages, a type each.

pub(crate) mod attribute;
pub(crate) mod cells;
pub(crate) mod image;
pub(crate) mod lists;
mod other;
pub(crate) mod polydata;
pub(crate) mod pose;
pub(crate) mod query;
pub(crate) mod scalar;
pub(crate) mod tracking;
pub(crate) mod words;

use std::borrow::Cow;

use crate::fault::{Fault, SizeRule};
use crate::fields::Fields;
use crate::limits::Limits;
use crate::malformed::Refusal;
use crate::name::TypeName;
use crate::text::Text;
use crate::wire::Reader;
use image::Image;
use lists::{ImageEntry, Landmark};
use polydata::PolyData;
use pose::{Matrix, Position};
use query::Query;
use tracking::{Placed, Tool};
use words::{Command, Status};

/// What a message says. The voxels of an image, and the content of a message that is passed on unread, are borrowed
/// from where they lie.
#[derive(Debug, Clone, PartialEq)]
pub enum Body<'a> {
    /// TRANSFORM: one pose; the device is its name.
    Transform(Matrix),
    /// TDATA: the tools of one instant.
    Tdata(Vec<Tool<Matrix>>),
    /// QTDATA: the same, with quaternions.
    Qtdata(Vec<Tool<Placed>>),
    /// POSITION: one pose as place and quaternion.
    Position(Position),
    /// QTRANS: POSITION by its other name.
    Qtrans(Position),
    /// STATUS: how the sender is.
    Status(Status),
    /// STRING: words.
    String(Text),
    /// POINT: places.
    Points(Vec<Landmark>),
    /// IMAGE: voxels.
    Image(Image<'a>),
    /// IMGMETA: images that can be asked for.
    ImageList(Vec<ImageEntry>),
    /// POLYDATA: a surface.
    PolyData(PolyData),
    /// CAPABILITY: types that a peer reads.
    Capability(Vec<TypeName>),
    /// COMMAND: something is to be done.
    Command(Command),
    /// RTS_COMMAND: what became of it.
    CommandAnswer(Command),
    /// GET_, STT_, STP_ or RTS_ of the above.
    Query(Query),
    /// A message of another type, as it came.
    Other {
        /// Its type.
        kind: TypeName,
        /// Its content.
        content: Cow<'a, [u8]>,
    },
}

impl<'a> Body<'a> {
    /// The type that stands in the header.
    pub fn kind(&self) -> TypeName {
        let name = match self {
            Self::Transform(_) => "TRANSFORM",
            Self::Tdata(_) => "TDATA",
            Self::Qtdata(_) => "QTDATA",
            Self::Position(_) => "POSITION",
            Self::Qtrans(_) => "QTRANS",
            Self::Status(_) => "STATUS",
            Self::String(_) => "STRING",
            Self::Points(_) => "POINT",
            Self::Image(_) => "IMAGE",
            Self::ImageList(_) => "IMGMETA",
            Self::PolyData(_) => "POLYDATA",
            Self::Capability(_) => "CAPABILITY",
            Self::Command(_) => "COMMAND",
            Self::CommandAnswer(_) => "RTS_COMMAND",
            Self::Query(query) => return TypeName::new(&query.kind().query(query.verb())).unwrap_or_default(),
            Self::Other { kind, .. } => return *kind,
        };
        TypeName::new(name).unwrap_or_default()
    }

    /// Reads the content of a message of this type.
    pub(crate) fn read(kind: &TypeName, reader: &mut Reader<'a>, limits: &Limits) -> Result<Self, Refusal> {
        Ok(match kind.as_bytes() {
            b"TRANSFORM" => {
                reader.sized(SizeRule::Exactly(48))?;
                Self::Transform(Matrix::read(reader)?)
            }
            b"TDATA" => Self::Tdata(tracking::read(reader, limits)?),
            b"QTDATA" => Self::Qtdata(tracking::read(reader, limits)?),
            b"POSITION" => Self::Position(Position::read(reader)?),
            b"QTRANS" => Self::Qtrans(Position::read(reader)?),
            b"STATUS" => Self::Status(Status::read(reader)?),
            b"STRING" => Self::String(words::read_string(reader)?),
            b"POINT" => Self::Points(lists::read_points(reader, limits)?),
            b"IMAGE" => Self::Image(Image::read(reader)?),
            b"IMGMETA" => Self::ImageList(lists::read_images(reader, limits)?),
            b"POLYDATA" => Self::PolyData(PolyData::read(reader, limits)?),
            b"CAPABILITY" => Self::Capability(lists::read_types(reader, limits)?),
            b"COMMAND" => Self::Command(Command::read(reader)?),
            b"RTS_COMMAND" => Self::CommandAnswer(Command::read(reader)?),
            _ => match Query::of(kind) {
                Some((verb, what)) => Self::Query(Query::read(verb, what, reader)?),
                None => Self::Other {
                    kind: *kind,
                    content: Cow::Borrowed(other::read(kind, reader)?),
                },
            },
        })
    }

    /// Appends the content, but for what [`Body::borrowed`] gives.
    pub(crate) fn write(&self, out: &mut Vec<u8>) -> Result<(), Fault> {
        match self {
            Self::Transform(matrix) => matrix.write(out),
            Self::Tdata(tools) => tracking::write(tools, out),
            Self::Qtdata(tools) => tracking::write(tools, out),
            Self::Position(position) | Self::Qtrans(position) => position.write(out),
            Self::Status(status) => status.write(out),
            Self::String(text) => words::write_string(text, out),
            Self::Points(points) => lists::write_points(points, out),
            Self::Image(image) => image.write_header(out),
            Self::ImageList(images) => {
                lists::write_images(images, out);
                Ok(())
            }
            Self::PolyData(surface) => surface.write(out),
            Self::Capability(types) => {
                lists::write_types(types, out);
                Ok(())
            }
            Self::Command(command) | Self::CommandAnswer(command) => command.write(out),
            Self::Query(query) => query.write(out),
            Self::Other { .. } => Ok(()),
        }
    }

    /// The last bytes of the content, where they are sent from where they lie.
    pub(crate) fn borrowed(&self) -> &[u8] {
        match self {
            Self::Image(image) => &image.voxels,
            Self::Other { content, .. } => content,
            _ => &[],
        }
    }

    pub(crate) fn fields(&self, fields: &mut Fields) {
        match self {
            Self::Transform(matrix) => matrix.fields("", fields),
            Self::Tdata(tools) => tracking::fields(tools, fields),
            Self::Qtdata(tools) => tracking::fields(tools, fields),
            Self::Position(position) | Self::Qtrans(position) => position.fields(fields),
            Self::Status(status) => status.fields(fields),
            Self::String(text) => words::text_fields(text, fields),
            Self::Points(points) => lists::point_fields(points, fields),
            Self::Image(image) => image.fields(fields),
            Self::ImageList(images) => lists::image_fields(images, fields),
            Self::PolyData(surface) => surface.fields(fields),
            Self::Capability(types) => lists::type_fields(types, fields),
            Self::Command(command) | Self::CommandAnswer(command) => command.fields(fields),
            Self::Query(query) => query.fields(fields),
            Self::Other { content, .. } => fields.add("content_bytes", content.len()),
        }
    }

    /// With voxels and contents of its own.
    pub fn into_owned(self) -> Body<'static> {
        match self {
            Self::Transform(matrix) => Body::Transform(matrix),
            Self::Tdata(tools) => Body::Tdata(tools),
            Self::Qtdata(tools) => Body::Qtdata(tools),
            Self::Position(position) => Body::Position(position),
            Self::Qtrans(position) => Body::Qtrans(position),
            Self::Status(status) => Body::Status(status),
            Self::String(text) => Body::String(text),
            Self::Points(points) => Body::Points(points),
            Self::Image(image) => Body::Image(image.into_owned()),
            Self::ImageList(images) => Body::ImageList(images),
            Self::PolyData(surface) => Body::PolyData(surface),
            Self::Capability(types) => Body::Capability(types),
            Self::Command(command) => Body::Command(command),
            Self::CommandAnswer(command) => Body::CommandAnswer(command),
            Self::Query(query) => Body::Query(query),
            Self::Other { kind, content } => Body::Other {
                kind,
                content: Cow::Owned(content.into_owned()),
            },
        }
    }
}
