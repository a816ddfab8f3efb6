//! Messages of every type with anything in them that may stand there.

use std::borrow::Cow;

use igtl::{
    Attribute, AttributeKind, Body, ByteOrder, Cells, Command, Image, ImageEntry, Kind, Landmark, Matrix, Message,
    Metadata, Name, Orientation, Pace, Placed, PolyData, Position, Query, Scalar, Space, Stamp, Status, Text, Tool,
    ToolKind, Version,
};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        -1e4_f32..1e4,
        Just(0.0),
        Just(-0.0),
        Just(f32::MAX),
        Just(f32::MIN_POSITIVE / 2.0)
    ]
}

fn ascii<const N: usize>() -> impl Strategy<Value = Name<N>> {
    vec(0x20_u8..0x7f, 0..=N).prop_map(|bytes| Name::new(&String::from_utf8(bytes).unwrap()).unwrap())
}

fn label<const N: usize>() -> impl Strategy<Value = Name<N>> {
    "[a-zäöü字 ]{0,6}".prop_map(|text| Name::label(&text).unwrap())
}

fn text() -> impl Strategy<Value = Text> {
    (any::<u16>(), vec(any::<u8>(), 0..40)).prop_map(|(encoding, bytes)| Text { encoding, bytes })
}

fn matrix() -> impl Strategy<Value = Matrix> {
    let column = || [number(), number(), number()];
    ([column(), column(), column()], column()).prop_map(|(columns, translation)| Matrix { columns, translation })
}

fn position() -> impl Strategy<Value = Position> {
    let orientation = prop_oneof![
        Just(Orientation::None),
        [number(), number(), number()].prop_map(Orientation::Short),
        [number(), number(), number(), number()].prop_map(Orientation::Full),
    ];
    ([number(), number(), number()], orientation).prop_map(|(place, orientation)| Position { place, orientation })
}

fn tools<P: std::fmt::Debug>(pose: impl Strategy<Value = P>) -> impl Strategy<Value = Vec<Tool<P>>> {
    let kinds = [ToolKind::Tracker, ToolKind::Six, ToolKind::Three, ToolKind::Five];
    vec((prop::sample::select(kinds.to_vec()), pose), 0..5).prop_map(|poses| {
        let named = poses.into_iter().enumerate();
        named
            .map(|(at, (kind, pose))| Tool {
                name: Name::new(&format!("tool {at}")).unwrap(),
                kind,
                pose,
            })
            .collect()
    })
}

fn placed() -> impl Strategy<Value = Placed> {
    let numbers = ([number(), number(), number()], [number(), number(), number(), number()]);
    numbers.prop_map(|(place, quaternion)| Placed { place, quaternion })
}

fn status() -> impl Strategy<Value = Status> {
    (any::<u16>(), any::<i64>(), label(), vec(1_u8.., 0..30)).prop_map(|(code, subcode, name, words)| Status {
        code,
        subcode,
        name,
        words,
    })
}

fn command() -> impl Strategy<Value = Command> {
    (any::<u32>(), label(), text()).prop_map(|(number, name, content)| Command { number, name, content })
}

fn landmark() -> impl Strategy<Value = Landmark> {
    let place = [number(), number(), number()];
    (label(), label(), any::<[u8; 4]>(), place, number(), label()).prop_map(
        |(name, group, colour, place, diameter, owner)| Landmark {
            name,
            group,
            colour,
            place,
            diameter,
            owner,
        },
    )
}

fn scalar() -> impl Strategy<Value = Scalar> {
    prop::sample::select(&Scalar::ALL[..])
}

fn image_entry() -> impl Strategy<Value = ImageEntry> {
    let names = (label(), label(), label(), label(), label());
    (names, any::<u64>(), any::<[u16; 3]>(), scalar()).prop_map(|(names, stamp, dimensions, scalar)| ImageEntry {
        name: names.0,
        device: names.1,
        modality: names.2,
        patient_name: names.3,
        patient_id: names.4,
        stamp: Stamp(stamp),
        dimensions,
        scalar,
    })
}

fn image() -> impl Strategy<Value = Image<'static>> {
    let axis = || (0_u16..3, 1_u16..5, 0_u16..3);
    let parts = [axis(), axis(), axis()];
    (parts, 1_u8..4, scalar(), any::<[bool; 2]>(), matrix(), any::<u8>()).prop_map(
        |(parts, components, scalar, [big, ras], placed, fill)| {
            let size = parts.map(|(_, size, _)| size);
            let voxels: usize = size.iter().map(|n| usize::from(*n)).product();
            let bytes = voxels * usize::from(components) * usize::from(scalar.bytes());
            Image {
                components,
                scalar,
                order: if big { ByteOrder::Big } else { ByteOrder::Little },
                space: if ras { Space::Ras } else { Space::Lps },
                dimensions: parts.map(|(offset, size, behind)| offset + size + behind),
                placed,
                offset: parts.map(|(offset, ..)| offset),
                size,
                voxels: Cow::Owned(vec![fill; bytes]),
            }
        },
    )
}

fn cells(points: u32) -> impl Strategy<Value = Cells> {
    vec(vec(0..points, 0..5), 0..4).prop_map(|cells| Cells::new(cells.iter().map(Vec::as_slice)).unwrap())
}

fn attribute() -> impl Strategy<Value = Attribute> {
    let kinds = [
        (AttributeKind::Scalars, 2),
        (AttributeKind::Vectors, 3),
        (AttributeKind::Normals, 3),
        (AttributeKind::Tensors, 9),
        (AttributeKind::Rgba, 4),
        (AttributeKind::Texture, 2),
    ];
    (
        prop::sample::select(kinds.to_vec()),
        any::<bool>(),
        "[a-z]{0,5}",
        0_usize..4,
        number(),
    )
        .prop_map(|((kind, components), of_cells, name, count, value)| Attribute {
            kind,
            of_cells,
            components,
            name: name.into_bytes(),
            values: vec![value; count * usize::from(components)],
        })
}

fn surface() -> impl Strategy<Value = PolyData> {
    let points = vec([number(), number(), number()], 4..8);
    let lists = [cells(4), cells(4), cells(4), cells(4)];
    (points, lists, vec(attribute(), 0..4)).prop_map(|(points, lists, attributes)| {
        let [vertices, lines, polygons, strips] = lists;
        PolyData {
            points,
            vertices,
            lines,
            polygons,
            strips,
            attributes,
        }
    })
}

fn query() -> impl Strategy<Value = Query> {
    let kinds: Vec<Kind> = Kind::all().collect();
    let paced = prop::sample::select(vec![Kind::Tdata, Kind::Qtdata]);
    let pace = (any::<u32>(), ascii()).prop_map(|(resolution_ms, frame)| Pace { resolution_ms, frame });
    prop_oneof![
        prop::sample::select(kinds.clone()).prop_map(Query::Get),
        prop::sample::select(kinds.clone()).prop_map(Query::Stop),
        prop::sample::select(vec![Kind::Image, Kind::PolyData]).prop_map(|kind| Query::Start(kind, Pace::default())),
        (paced, pace).prop_map(|(kind, pace)| Query::Start(kind, pace)),
        (prop::sample::select(kinds), any::<u8>()).prop_map(|(kind, status)| Query::Answer(kind, status)),
    ]
}

fn body() -> impl Strategy<Value = Body<'static>> {
    let other = vec(any::<u8>(), 0..50).prop_map(|content| Body::Other {
        kind: Name::new("VIDEO").unwrap(),
        content: content.into(),
    });
    prop_oneof![
        matrix().prop_map(Body::Transform),
        tools(matrix()).prop_map(Body::Tdata),
        tools(placed()).prop_map(Body::Qtdata),
        position().prop_map(Body::Position),
        position().prop_map(Body::Qtrans),
        status().prop_map(Body::Status),
        text().prop_map(Body::String),
        vec(landmark(), 0..4).prop_map(Body::Points),
        image().prop_map(Body::Image),
        vec(image_entry(), 0..4).prop_map(Body::ImageList),
        surface().prop_map(Body::PolyData),
        vec(ascii(), 0..5).prop_map(Body::Capability),
        command().prop_map(Body::Command),
        command().prop_map(Body::CommandAnswer),
        query().prop_map(Body::Query),
        other,
    ]
}

pub(crate) fn message() -> impl Strategy<Value = Message<'static>> {
    let two = option::of((any::<u32>(), vec(text(), 0..4)));
    (ascii(), any::<u64>(), two, body()).prop_map(|(device, stamp, two, body)| {
        let mut message = Message::new(device, body);
        message.stamp = Stamp(stamp);
        if let Some((number, values)) = two {
            (message.version, message.number) = (Version::Two, number);
            let keyed = values.into_iter().enumerate();
            message.metadata = keyed.fold(Metadata::EMPTY, |all, (at, value)| {
                all.with(&format!("key {at}"), value)
            });
        }
        message
    })
}
