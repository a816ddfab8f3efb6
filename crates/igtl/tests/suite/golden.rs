//! The 24 messages that the C++ library is tested by.

use igtl::{Body, Limits, Orientation, Scalar, Space, Version, decode, fields::Value};

use crate::support::golden;

/// How many there are.
const ALL: usize = 24;

#[test]
fn each_is_read_and_written_again_byte_by_byte() {
    let messages = golden();
    assert!(messages.is_empty() || messages.len() == ALL);
    for (name, bytes) in messages {
        let (message, taken) = decode(&bytes, &Limits::default()).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(taken, bytes.len(), "{name}");
        assert_eq!(message.to_vec().unwrap(), bytes, "{name}");
        assert_eq!(message.encode().unwrap().len(), bytes.len(), "{name}");
        assert_eq!(message.clone().into_owned(), message, "{name}");
    }
}

/// The bytes of one, empty where there are none.
fn one(name: &str) -> Vec<u8> {
    let found = golden().into_iter().find(|(other, _)| other == name);
    found.map(|(_, bytes)| bytes).unwrap_or_default()
}

fn checked(name: &str, check: impl Fn(&igtl::Message<'_>)) {
    let bytes = one(name);
    if !bytes.is_empty() {
        check(&decode(&bytes, &Limits::default()).unwrap().0);
    }
}

#[test]
fn headers_say_who_and_when() {
    checked("transform", |message| {
        assert_eq!((message.version, message.number), (Version::One, 0));
        assert_eq!(message.device, "DeviceName");
        // The library's tests fill in the fraction alone.
        assert_eq!((message.stamp.seconds(), message.stamp.fraction()), (0, 1_234_567_892));
        assert!(igtl::StampWatch::default().judge(message.stamp).is_err());
    });
    checked("transformFormat2", |message| {
        assert_eq!((message.version, message.number), (Version::Two, 1));
        let value = |key| message.metadata.get(key).and_then(igtl::Text::as_str);
        assert_eq!(value("First patient age"), Some("22"));
        assert_eq!(value("Second patient age"), Some("25"));
    });
}

#[test]
fn poses_have_their_numbers_in_place() {
    checked("transform", |message| {
        let Body::Transform(matrix) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!(matrix.translation, [46.0531, 19.4709, 46.0531]);
        assert_eq!(matrix.columns[0][0], -0.954_892);
        assert_eq!(matrix.rows()[1][3], 19.4709);
    });
    checked("position", |message| {
        let Body::Position(position) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!(position.place, [46.0531, 19.4709, 46.0531]);
        assert!(matches!(position.orientation, Orientation::Full([x, .., w]) if x == 0.0 && w == 0.333_333_34));
    });
    checked("tdataFormat2", |message| {
        let Body::Tdata(tools) = &message.body else {
            panic!("{message:?}")
        };
        let names: Vec<String> = tools.iter().map(|tool| tool.name.to_string()).collect();
        assert_eq!(names, ["Tracker0", "Tracker1", "Tracker2"]);
        assert_eq!(tools[2].kind, igtl::ToolKind::Six);
    });
}

#[test]
fn images_and_surfaces_have_their_shape() {
    checked("image", |message| {
        let Body::Image(image) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!(
            (image.dimensions, image.size, image.offset),
            ([50, 50, 1], [50, 50, 1], [0; 3])
        );
        assert_eq!((image.scalar, image.space), (Scalar::Uint8, Space::Ras));
        assert_eq!(image.voxels.len(), 2500);
        assert!(matches!(image.voxels, std::borrow::Cow::Borrowed(_)));
    });
    checked("polydata", |message| {
        let Body::PolyData(surface) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!((surface.points.len(), surface.polygons.count()), (8, 6));
        assert_eq!(surface.polygons.iter().next(), Some(&[0, 1, 2, 3][..]));
        assert_eq!(surface.attributes[0].name, b"attr");
        assert_eq!(surface.attributes[0].values, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    });
}

#[test]
fn words_and_lists_are_read() {
    checked("status", |message| {
        let Body::Status(status) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!((status.code, status.subcode), (15, 10));
        assert_eq!(status.name, "ACTUATOR_DISABLED");
        assert_eq!(status.words, b"Actuator A is disabled.");
    });
    checked("string", |message| {
        let Body::String(text) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!(text.as_str(), Some("Welcome to OpenIGTLink"));
    });
    checked("command", |message| {
        let Body::Command(command) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!(command.number, 5);
        assert_eq!(command.content.as_str(), Some("Start the tracking machine"));
    });
    checked("point", |message| {
        let Body::Points(points) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!((points[0].place, points[0].diameter), ([10.0, 15.0, 20.0], 5.0));
        assert_eq!(points[0].colour, [255, 0, 0, 255]);
        assert_eq!(points[2].owner, "IMAGE_0");
    });
    checked("imgmeta", |message| {
        let Body::ImageList(images) = &message.body else {
            panic!("{message:?}")
        };
        assert_eq!(images[0].modality, "CT");
        assert_eq!(
            (images[0].dimensions, images[0].scalar),
            ([512, 512, 64], Scalar::Uint16)
        );
    });
    checked("capability", |message| {
        let types = message.fields().get("types").cloned();
        assert_eq!(
            types,
            Some(Value::Text("IMAGE GET_IMAGE TRANSFORM GET_TRANS".to_owned()))
        );
    });
}

#[test]
fn all_can_be_shown_and_their_fields_have_names_of_their_own() {
    for (name, bytes) in golden() {
        let (message, _) = decode(&bytes, &Limits::default()).unwrap();
        let fields = message.fields();
        let json: serde_json::Value = serde_json::from_str(&fields.json()).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(json.as_object().unwrap().len(), fields.all().len(), "{name}");
        assert_eq!(json["type"], message.body.kind().to_string(), "{name}");
        assert_eq!(fields.to_string().lines().count(), fields.all().len(), "{name}");
    }
}
