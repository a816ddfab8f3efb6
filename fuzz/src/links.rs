//! Streams of localizers and of whoever dials us.

use igtl::session::{Client, ClientRules, Event, Server, ServerRules};
use igtl::{
    Attribute, AttributeKind, Body, ByteOrder, Cells, Command, Decoder, HEADER_BYTES, Image, Kind, Landmark, Limits,
    Malformed, Matrix, Message, Metadata, Name, Orientation, Pace, PolyData, Position, Query, Recovery, Scalar, Space,
    StampWatch, Status, Text, Tool, ToolKind, ToolStatus, Version, check_grid, crc, rotation,
};

use crate::Failure;

/// The same bytes, with the CRC of each body that is whole: else nearly all that is changed would end at the CRC.
pub(crate) fn mended(bytes: &[u8]) -> Vec<u8> {
    let mut mended = bytes.to_vec();
    let mut at = 0;
    while let Some(length) = mended.get(at + 42..at + 50).and_then(|b| b.try_into().ok()) {
        let start = at + HEADER_BYTES;
        let end = usize::try_from(u64::from_be_bytes(length)).ok();
        let end = end.and_then(|length| start.checked_add(length));
        let Some(body) = end.and_then(|end| mended.get(start..end)) else {
            break;
        };
        let crc = crc::crc64(body).to_be_bytes();
        if let Some(place) = mended.get_mut(at + 50..start) {
            place.copy_from_slice(&crc);
        }
        at = end.unwrap_or(usize::MAX);
    }
    mended
}

/// As it is, and mended; in pieces of a length that the first byte tells.
pub(crate) fn igtl(bytes: &[u8]) {
    let Some((piece, bytes)) = bytes.split_first() else {
        return;
    };
    let piece = usize::from(*piece) + 1;
    stream(bytes, piece);
    stream(&mended(bytes), piece);
}

fn stream(bytes: &[u8], piece: usize) {
    let mut decoder = Decoder::new(Limits::VOLUMES);
    let mut watch = StampWatch::default();
    let mut client = Client::new(ClientRules::default());
    let mut server = Server::new(ServerRules::default(), 0);
    client.step(Event::Connected, 0);
    for (now, mut bytes) in (0..).zip(bytes.chunks(piece)) {
        while let Some(result) = decoder.feed(&mut bytes) {
            let event = match &result {
                Ok(message) => {
                    judged(message, &mut watch);
                    Event::Received(message)
                }
                Err(malformed) => Event::Refused(malformed),
            };
            drop((client.step(event, now), server.step(event, now)));
            if result.as_ref().err().is_some_and(closes) {
                return;
            }
        }
        let come = decoder.come();
        drop((
            client.step(Event::Tick { come }, now),
            server.take_due(Kind::Tdata, now),
        ));
    }
    drop(decoder.end().map(|malformed| malformed.fields().json()));
}

fn closes(malformed: &Malformed) -> bool {
    drop((malformed.to_string(), malformed.advice()));
    malformed.recovery == Recovery::Close
}

/// All that is asked of a message; what was read can be written, and read again.
fn judged(message: &Message<'_>, watch: &mut StampWatch) {
    drop((message.fields().json(), message.fields().to_string()));
    let _ = watch.judge(message.stamp);
    let _ = ToolStatus::of_transform(&message.metadata);
    match &message.body {
        Body::Transform(matrix) => drop(rotation::check(&matrix.columns, 1e-3)),
        Body::Image(image) => drop((image.origin(), check_grid(image, 0.1))),
        Body::PolyData(surface) => drop((
            surface.bounds(),
            surface.polygons.iter().map(<[u32]>::len).sum::<usize>(),
        )),
        _ => {}
    }
    let bytes = message.to_vec().unwrap_or_default();
    let again = igtl::decode(&bytes, &Limits::VOLUMES).map(|(message, _)| message);
    assert_eq!(
        again.as_ref(),
        Ok(message),
        "what was read is not what is written of it"
    );
}

/// A tool and a marker on the patient, in TRANSFORMs and in a TDATA, each with its status.
pub(crate) fn tools() -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let ok = || Text::new("OK");
    for number in 0..6_u64 {
        let stamp = igtl::Stamp::of_ns(1_790_000_000_000_000_000 + number * 20_000_000).unwrap_or_default();
        for name in ["Reference", "Stylus"] {
            let mut message =
                Message::new(Name::new(name)?, Body::Transform(Matrix::IDENTITY)).in_version(Version::Two);
            message.stamp = stamp;
            message.metadata = Metadata::EMPTY.with("TransformStatus", ok());
            bytes.extend(message.to_vec()?);
        }
    }
    let tool = |name: &str| -> Result<Tool<Matrix>, Failure> {
        let (name, kind, pose) = (Name::new(name)?, ToolKind::Six, Matrix::IDENTITY);
        Ok(Tool { name, kind, pose })
    };
    let list = Body::Tdata(vec![tool("Reference")?, tool("Stylus")?]);
    let mut message = Message::new(Name::EMPTY, list).in_version(Version::Two);
    message.metadata = Metadata::EMPTY.with("StylusStatus", ok()).with("ReferenceStatus", ok());
    bytes.extend(message.to_vec()?);
    Ok(bytes)
}

/// A message of each type, and several in a row; before each the length of its pieces.
pub(crate) fn igtl_seeds() -> Result<Vec<Vec<u8>>, Failure> {
    let mut seeds = Vec::new();
    let mut all = vec![6];
    for (at, body) in bodies()?.into_iter().enumerate() {
        let mut message = Message::new(Name::new("Device")?, body);
        if at % 2 == 1 {
            message.version = Version::Two;
            message.metadata = Metadata::EMPTY.with("TransformStatus", Text::new("OK"));
        }
        let bytes = message.to_vec()?;
        all.extend(&bytes);
        seeds.push([&[255][..], &bytes].concat());
    }
    seeds.push(all);
    Ok(seeds)
}

fn bodies() -> Result<Vec<Body<'static>>, Failure> {
    let tool = |pose| -> Result<_, Failure> {
        let (name, kind) = (Name::new("Stylus")?, ToolKind::Six);
        Ok(Tool { name, kind, pose })
    };
    let pace = Pace {
        resolution_ms: 20,
        frame: Name::new("Patient")?,
    };
    let position = Position {
        place: [1.0, 2.0, 3.0],
        orientation: Orientation::Full([0.0, 0.0, 0.0, 1.0]),
    };
    let command = Command {
        number: 3,
        name: Name::new("Version")?,
        content: Text::new("<Command/>"),
    };
    Ok(vec![
        Body::Transform(Matrix::IDENTITY),
        Body::Transform(Matrix::IDENTITY),
        Body::Tdata(vec![tool(Matrix::IDENTITY)?]),
        Body::Position(position),
        Body::Status(Status::new(Status::OK, "well")),
        Body::String(Text::new("words")),
        Body::Points(vec![point()?]),
        Body::Image(image()),
        Body::PolyData(surface()),
        Body::Capability(vec![Name::new("TDATA")?]),
        Body::Command(command.clone()),
        Body::CommandAnswer(command),
        Body::Query(Query::Start(Kind::Tdata, pace)),
        Body::Query(Query::Answer(Kind::Tdata, 0)),
        Body::Query(Query::Get(Kind::Status)),
    ])
}

fn point() -> Result<Landmark, Failure> {
    Ok(Landmark {
        name: Name::label("node")?,
        group: Name::label("Target")?,
        colour: [255, 0, 0, 255],
        place: [1.0, 2.0, 3.0],
        diameter: 4.0,
        owner: Name::EMPTY,
    })
}

fn image() -> Image<'static> {
    Image {
        components: 1,
        scalar: Scalar::Int16,
        order: ByteOrder::Little,
        space: Space::Ras,
        dimensions: [3, 2, 2],
        placed: Matrix::IDENTITY,
        offset: [1, 0, 0],
        size: [2, 2, 1],
        voxels: vec![7; 8].into(),
    }
}

fn surface() -> PolyData {
    let triangle = [0, 1, 2];
    PolyData {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        polygons: Cells::new([&triangle[..]]).unwrap_or_default(),
        attributes: vec![Attribute {
            kind: AttributeKind::Scalars,
            of_cells: false,
            components: 1,
            name: b"heat".to_vec(),
            values: vec![1.0, 2.0, 3.0],
        }],
        ..PolyData::default()
    }
}
