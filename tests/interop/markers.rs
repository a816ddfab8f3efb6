//! Poses of markers in the localizer's frame, streams of tools, and the targets.

use std::time::Duration;

use bus::message::{Chosen, Guide, Lost, MarkerFrame, MarkerSight};
use geometry::{Marker, Point, Reference, Rigid, Vector};

use crate::peers;
use crate::rig::Rig;
use crate::support::proxy::{Fault, through};

const SCENE: &str = "[gateway]\naddress = \"127.0.0.1:0\"\n\
    [[targets]]\nname = \"node\"\nct_mm = [33.0, 4.0, -50.5]\n\
    [tracker]\nsource = \"markers\"\n[tracker.markers]\n";

fn frame(rig: &Rig, seq: u64, is_seen: bool) -> MarkerFrame {
    let reference = MarkerSight::lost(MarkerFrame::REFERENCE, Lost::NotSeen, 0);
    frame_with(rig, seq, is_seen, reference)
}

fn frame_with(rig: &Rig, seq: u64, is_seen: bool, reference: MarkerSight) -> MarkerFrame {
    let pose = Rigid::<_, Marker>::from_rotation_vector(
        Vector::new(0.0, 0.1, 0.0),
        Vector::new(100.0 + seq as f64, -200.0, -1500.0),
    );
    let mut frame = MarkerFrame {
        seq,
        t_capture_ns: rig.now_ns(),
        ..MarkerFrame::EMPTY
    };
    let tool = match is_seen {
        true => MarkerSight::seen(MarkerFrame::TOOL, pose.unwrap(), 0.1),
        false => MarkerSight::lost(MarkerFrame::TOOL, Lost::Interference, 0),
    };
    frame.set(&[tool, reference]).unwrap();
    frame
}

#[test]
fn a_cxx_client_reads_markers_a_stream_of_tools_at_its_pace_and_the_targets() {
    let Some(peer) = peers::cxx() else { return };
    let rig = Rig::of(SCENE, |_| ());
    let chosen = Chosen {
        name: "chosen-one".to_owned(),
        centre: Point::new(1.0, 2.0, 3.0),
        radius_mm: 2.5,
        entry: None,
        stop_mm: 0.0,
    };
    let queries = [
        "listen",
        "300",
        "STT_TDATA:200",
        "GET_POINT",
        "GET_CAPABIL",
        "GET_STATUS",
    ];
    let network = through(Fault::BytesOfBoth, rig.address);
    let mut child = peers::start(peer, network, &queries);
    let began_ns = rig.now_ns();
    let mut seq = 0;
    while child.try_wait().unwrap().is_none() {
        let of_it = frame(&rig, seq, true);
        rig.markers.send(of_it).unwrap();
        rig.pose_of(seq, of_it.t_capture_ns);
        if seq == 10 {
            rig.guide.send(Guide::default().choosing(Some(&chosen), 1)).unwrap();
        }
        seq += 1;
        std::thread::sleep(Duration::from_millis(10));
    }
    let took_s = (rig.now_ns() - began_ns) as f64 / 1e9;
    let lines = peers::lines(child);
    let of = |start: &str| -> Vec<&String> { lines.iter().filter(|line| line.starts_with(start)).collect() };
    let markers = of("TRANSFORM ToolToTracker");
    assert!(markers.len() > 30, "{lines:#?}");
    for line in &markers {
        let rows = peers::numbers(line, 4);
        // In the localizer's frame as it came: nothing is turned.
        assert!(rows[3] >= 100.0 && (rows[7], rows[11]) == (-200.0, -1500.0), "{line}");
        assert!(
            (rows[0] - 0.1_f64.cos()).abs() < 1e-7 && (rows[2] - 0.1_f64.sin()).abs() < 1e-7,
            "{line}"
        );
    }
    // A marker that is not seen is no transform to a client of version 1.
    assert!(of("TRANSFORM ReferenceToTracker").is_empty());
    assert_eq!(of("RTS_TDATA").len(), 1);
    let streamed = of("TDATA");
    let most = (took_s / 0.2) as usize + 2;
    assert!((2..=most).contains(&streamed.len()), "{} in {took_s} s", streamed.len());
    assert!(
        streamed
            .iter()
            .any(|line| line.contains(" ToolToRas ") && line.contains(" ToolToTracker "))
    );
    assert!(streamed.iter().all(|line| !line.contains("ReferenceToTracker")));
    let points = of("POINT Targets");
    assert!(points[0].contains(" node/Target -33 -4 -50.5"), "{points:?}");
    assert!(
        points.last().unwrap().contains(" chosen-one/Chosen -1 -2 3"),
        "{points:?}"
    );
    assert!(!of("CAPABILITY").is_empty() && !of("STATUS").is_empty());
}

/// The patient's marker where it is, and the tool's where that is: neither in the place of the other.
#[test]
fn a_cxx_client_reads_the_marker_on_the_patient() {
    let Some(peer) = peers::cxx() else { return };
    let rig = Rig::of(SCENE, |_| ());
    let mut child = peers::start(peer, rig.address, &["listen", "100"]);
    let turned =
        Rigid::<_, Reference>::from_rotation_vector(Vector::new(0.0, 0.0, -0.2), Vector::new(7.0, 8.0, -1900.0));
    let reference = MarkerSight::seen(MarkerFrame::REFERENCE, turned.unwrap(), 0.1);
    let mut seq = 0;
    while child.try_wait().unwrap().is_none() {
        rig.markers.send(frame_with(&rig, seq, true, reference)).unwrap();
        rig.pose(seq);
        seq += 1;
        std::thread::sleep(Duration::from_millis(10));
    }
    let lines = peers::lines(child);
    let of = |start: &str| -> Vec<Vec<f64>> {
        let lines = lines.iter().filter(|line| line.starts_with(start));
        lines.map(|line| peers::numbers(line, 4)).collect()
    };
    let (patient, tool) = (of("TRANSFORM ReferenceToTracker"), of("TRANSFORM ToolToTracker"));
    assert!(patient.len() > 10 && tool.len() > 10, "{lines:#?}");
    // Rows of a turn about z by -0.2; single precision.
    let (sin, cos) = (-0.2_f64).sin_cos();
    let rows = [cos, -sin, 0.0, 7.0, sin, cos, 0.0, 8.0, 0.0, 0.0, 1.0, -1900.0];
    for found in &patient {
        assert!(found.iter().zip(rows).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
    assert!(
        tool.iter().all(|rows| (rows[7], rows[11]) == (-200.0, -1500.0)),
        "{tool:?}"
    );
}

#[test]
fn a_marker_that_the_localizer_loses_is_missing_with_its_reason() {
    use igtl::{Body, DeviceName, Kind, Message, Query, ToolStatus, Version};
    let rig = Rig::of(SCENE, |_| ());
    let mut two = rig.client();
    let get = Body::Query(Query::Get(Kind::Status));
    two.send(&Message::new(DeviceName::EMPTY, get).in_version(Version::Two));
    rig.markers.send(frame(&rig, 0, true)).unwrap();
    let mut status = |wanted: ToolStatus| {
        two.wait_for("the marker", |message| {
            let status = ToolStatus::of_transform(&message.metadata);
            let is_it = message.device == "ToolToTracker" && status == wanted;
            is_it.then(|| message.metadata.get("TransformStatusReason").map(ToString::to_string))
        })
    };
    assert_eq!(status(ToolStatus::Ok), None);
    rig.markers.send(frame(&rig, 1, false)).unwrap();
    assert_eq!(
        status(ToolStatus::Missing),
        Some("LOST: localizer disturbed".to_owned())
    );
    // Silence is no validity either.
    rig.markers.send(frame(&rig, 2, true)).unwrap();
    assert_eq!(status(ToolStatus::Ok), None);
    let why = status(ToolStatus::Missing).unwrap();
    assert!(why.starts_with("STALE"), "{why}");
}
