//! The examination and the images of the views, read back by pyigtl and placed by SimpleITK: the patient's left stays left.

use std::time::Duration;

use bus::message::{FrameHeader, FrameStamp, ImagePlane};
use geometry::{Affine, Direction, Point, SlicePlane, VolumeGrid};
use igtl::{Body, DeviceName, Kind, Message, Query, Status, Text, Version};
use scene::WindowLevel;
use serde_json::{Value, json};

use crate::peers;
use crate::rig::{Rig, SCENE};
use crate::support::proxy::{Fault, through};

/// Images that do not grow old while an interpreter starts.
const PATIENT: &str = "[gateway]\naddress = \"127.0.0.1:0\"\nimages_hz = 60.0\n[limits]\nstale_ms = 10000.0\n";
const DIMS: [i64; 3] = [9, 11, 7];

/// Rows of a grid whose axes are those of a right-handed system, turned, with steps of three lengths; `sign` -1 mirrors the third.
fn rows(sign: f64) -> [[f64; 4]; 3] {
    let (c, s) = (0.8, 0.6);
    [
        [0.9 * c, -1.1 * s, 0.0, 20.0],
        [0.9 * s, 1.1 * c, 0.0, -35.0],
        [0.0, 0.0, 2.5 * sign, 110.0],
    ]
}

/// No two voxels have the same.
fn value([x, y, z]: [u32; 3]) -> i16 {
    (x + 20 * y + 400 * z) as i16 - 1000
}

fn file_of(places: &[[f64; 3]]) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), json!(places).to_string()).unwrap();
    file
}

/// Through a network that has all of it a little later.
fn seen(rig: &Rig, device: &str, places: &[[f64; 3]], meanwhile: impl FnMut()) -> Option<Value> {
    seen_through(
        Fault::Delay(Duration::from_millis(40)),
        rig,
        (device, places),
        meanwhile,
    )
}

fn seen_through(
    fault: Fault,
    rig: &Rig,
    (device, places): (&str, &[[f64; 3]]),
    mut meanwhile: impl FnMut(),
) -> Option<Value> {
    let file = file_of(places);
    let network = through(fault, rig.address);
    let mut child = peers::python(network, &["image", device, file.path().to_str().unwrap()])?;
    while child.try_wait().unwrap().is_none() {
        meanwhile();
        std::thread::sleep(Duration::from_millis(10));
    }
    Some(peers::printed(child))
}

#[test]
fn each_voxel_of_the_examination_is_where_it_was_in_the_patient_whatever_the_hand_of_its_axes() {
    for sign in [1.0, -1.0] {
        let rig = Rig::new();
        let grid = VolumeGrid::checked(DIMS, Affine::from_rows(rows(sign))).unwrap();
        let loader = rig.volume(&grid, value);
        let dims = grid.dims();
        let all = (0..dims[2]).flat_map(|z| (0..dims[1]).flat_map(move |y| (0..dims[0]).map(move |x| [x, y, z])));
        let voxels: Vec<[u32; 3]> = all.collect();
        let places: Vec<[f64; 3]> = voxels
            .iter()
            .map(|voxel| rows(sign).map(|row| (0..3).map(|a| row[a] * f64::from(voxel[a])).sum::<f64>() + row[3]))
            .collect();
        // Byte by byte, and after a stall in the voxels.
        let fault = match sign > 0.0 {
            true => Fault::BytesOfBoth,
            false => Fault::StallBehind(1500, Duration::from_millis(300)),
        };
        let Some(found) = seen_through(fault, &rig, ("Volume", &places), || loader.serve_late_joiners()) else {
            return;
        };
        let values: Vec<i64> = found["values"]
            .as_array()
            .unwrap()
            .iter()
            .map(|v| v.as_i64().unwrap())
            .collect();
        let expected: Vec<i64> = voxels.iter().map(|voxel| value(*voxel).into()).collect();
        assert_eq!(values, expected, "hand {sign}");
        assert_eq!(found["size"], json!(dims));
        assert!(found["determinant"].as_f64().unwrap() > 0.999);
    }
}

#[test]
fn a_sheared_examination_is_refused_with_its_angle_and_one_that_is_not_there_with_words() {
    let rig = Rig::new();
    let mut client = rig.client();
    let get = Message::new(DeviceName::new("Volume").unwrap(), Body::Query(Query::Get(Kind::Image)));
    let mut refused = |code: u16| {
        client.send(&get);
        client.wait_for("the refusal", |message| match &message.body {
            Body::Status(status) if status.code == code => {
                let words = String::from_utf8_lossy(&status.words).into_owned();
                // The heart-beat may have the same code.
                (!words.starts_with("WAITING")).then_some(words)
            }
            Body::Image(_) => panic!("an image"),
            _ => None,
        })
    };
    assert_eq!(refused(13), "the examination is not loaded yet");
    let mut tilted = rows(1.0);
    tilted[1][2] = 2.5 * 15_f64.to_radians().tan();
    let loader = rig.volume(&VolumeGrid::checked(DIMS, Affine::from_rows(tilted)).unwrap(), value);
    loader.serve_late_joiners();
    std::thread::sleep(Duration::from_millis(200));
    let words = refused(10);
    assert!(
        words.contains("off a right angle by") && words.contains("IMAGE cannot say"),
        "{words}"
    );
}

const SIZE: [u32; 2] = [40, 30];

fn plane() -> SlicePlane {
    SlicePlane::centred(Point::new(60.0, -20.0, 35.0), [Direction::X, Direction::Y], 0.75, SIZE).unwrap()
}

fn colour(x: u32, y: u32) -> [u8; 3] {
    [x as u8 * 5, y as u8 * 7, 200]
}

/// Those of a view of these tests.
pub(crate) fn pixels() -> Vec<u8> {
    let all = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| colour(x, y)));
    all.flat_map(|[r, g, b]| [r, g, b, 255]).collect()
}

/// Of an image that follows a pose of now.
pub(crate) fn header(rig: &Rig, placed: bool) -> FrameHeader {
    let window = WindowLevel {
        centre_hu: 40.0,
        width_hu: 400.0,
    };
    let now = rig.now_ns();
    FrameHeader {
        stamp: FrameStamp {
            seq: 12,
            t_capture_ns: now,
            t_framed_ns: now,
            ..FrameStamp::default()
        },
        plane: ImagePlane::of(placed.then(plane).as_ref(), window),
        width: SIZE[0],
        height: SIZE[1],
    }
}

#[test]
fn each_pixel_of_a_view_is_where_it_was_in_the_patient() {
    let rig = Rig::of(PATIENT, |_| ());
    let view = rig.view("axial-local", pixels().len());
    let at = [(0, 0), (39, 0), (0, 29), (12, 7), (39, 29)];
    let places = at.map(|(x, y)| plane().point(f64::from(x), f64::from(y)).mm());
    let found = seen(&rig, "axial-local", &places, || {
        rig.frame(&view, header(&rig, true), &pixels());
        view.serve_late_joiners();
    });
    let Some(found) = found else { return };
    assert_eq!(found["values"], json!(at.map(|(x, y)| colour(x, y))));
    assert_eq!(found["size"], json!([40, 30, 1]));
    for (spacing, expected) in found["spacing"].as_array().unwrap().iter().zip([0.75, 0.75, 1.0]) {
        assert!((spacing.as_f64().unwrap() - expected).abs() < 1e-6, "{found}");
    }
}

fn image(message: &Message<'_>) -> Option<(String, bool)> {
    let Body::Image(image) = &message.body else { return None };
    let status = message.metadata.get("ImageStatus").map(Text::to_string);
    Some((status.unwrap_or_default(), image.voxels.iter().all(|byte| *byte == 0)))
}

/// Its renderer may have died: whatever stood on the image last would stand there for ever.
#[test]
fn an_image_whose_words_are_no_longer_true_is_covered() {
    let short = PATIENT.replace("10000.0", "500.0");
    let rig = Rig::of(&short, |_| ());
    let view = rig.view("axial-local", pixels().len());
    let mut client = rig.client();
    let start = Body::Query(Query::Start(Kind::Image, Default::default()));
    client.send(&Message::new(DeviceName::new("axial-local").unwrap(), start).in_version(Version::Two));
    client.wait_for("RTS_IMAGE", |message| {
        matches!(message.body, Body::Query(Query::Answer(Kind::Image, 0))).then_some(())
    });
    let live = loop {
        rig.frame(&view, header(&rig, true), &pixels());
        let found = client.wait_for("an image", image);
        // A machine that is busy may have let it grow old already.
        if found.0 == "LIVE" {
            break found;
        }
    };
    assert!(!live.1);
    let covered = client.wait_for("the cover", |message| {
        image(message).filter(|(status, _)| status.starts_with("COVERED"))
    });
    assert_eq!(covered, ("COVERED: the image has grown old".to_owned(), true));
}

/// A client that came back while the view stood still was sent nothing, and kept the picture of before, LIVE.
#[test]
fn a_stream_that_begins_is_sent_what_there_is_and_a_cover_where_nobody_draws_any_more() {
    let rig = Rig::of(&PATIENT.replace("10000.0", "500.0"), |_| ());
    let view = rig.view("axial-local", pixels().len());
    let begun = || {
        let mut client = rig.client();
        let start = Body::Query(Query::Start(Kind::Image, Default::default()));
        client.send(&Message::new(DeviceName::new("axial-local").unwrap(), start).in_version(Version::Two));
        client
    };
    let covered = |client: &mut crate::rig::Raw| {
        client.wait_for("the cover", |message| {
            image(message).filter(|(status, _)| status.starts_with("COVERED"))
        })
    };
    let mut first = begun();
    rig.frame(&view, header(&rig, true), &pixels());
    let black = ("COVERED: the image has grown old".to_owned(), true);
    assert_eq!(covered(&mut first), black);
    // It was told already, to another.
    let mut second = begun();
    assert_eq!(covered(&mut second), black);
    // Nobody wants it, and its place is given back to a renderer that draws no more.
    drop((first, second));
    std::thread::sleep(Duration::from_millis(300));
    drop(view);
    assert_eq!(covered(&mut begun()), black);
}

#[test]
fn an_image_without_a_place_and_one_that_the_workflow_hides_are_not_sent() {
    let rig = Rig::of(PATIENT, |_| ());
    let view = rig.view("axial-local", pixels().len());
    let mut client = rig.client();
    let get = Message::new(
        DeviceName::new("axial-local").unwrap(),
        Body::Query(Query::Get(Kind::Image)),
    );
    let get = get.in_version(Version::Two);
    rig.frame(&view, header(&rig, false), &pixels());
    client.send(&get);
    let words = client.wait_for("why not", |message| match &message.body {
        Body::Status(status) if status.code == 13 && message.metadata.is_empty() => {
            Some(String::from_utf8_lossy(&status.words).into_owned()).filter(|words| words.contains("axial-local"))
        }
        Body::Image(_) => panic!("an image"),
        _ => None,
    });
    assert!(
        words.contains("no place in the patient") || words.contains("no image of this view"),
        "{words}"
    );
    rig.may(0);
    client.wait_for("the state", |message| match &message.body {
        Body::Status(Status { words, .. }) => words.starts_with(b"WITHHELD").then_some(()),
        _ => None,
    });
    rig.frame(&view, header(&rig, true), &pixels());
    std::thread::sleep(Duration::from_millis(100));
    client.send(&get);
    let (status, is_black) = client.wait_for("a cover", image);
    assert!(
        status.starts_with("COVERED: the run is not ready") && is_black,
        "{status}"
    );
}

#[test]
fn a_surface_is_no_device() {
    let surface = "[[views]]\nname = \"over\"\nplane = \"surface\"\nextent = \"global\"\n";
    let rig = Rig::of(&format!("{SCENE}{surface}"), |_| ());
    let mut client = rig.client();
    client.send(&Message::new(
        DeviceName::new("over").unwrap(),
        Body::Query(Query::Get(Kind::Image)),
    ));
    let words = client.wait_for("why not", |message| match &message.body {
        Body::Status(status) if status.code == 4 => Some(String::from_utf8_lossy(&status.words).into_owned()),
        _ => None,
    });
    assert_eq!(words.split_once(" \"over\"; ").unwrap().1, "there are Volume");
}
