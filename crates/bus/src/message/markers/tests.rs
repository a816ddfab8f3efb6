use geometry::{Marker, Reference, Vector};

use super::*;

fn pose() -> Rigid<Tracker, Marker> {
    Rigid::from_rotation_vector(Vector::new(0.3, -1.2, 0.7), Vector::new(12.5, -40.0, -2100.0)).unwrap()
}

fn frame(sights: &[MarkerSight]) -> MarkerFrame {
    let mut frame = MarkerFrame {
        seq: 7,
        ..MarkerFrame::EMPTY
    };
    frame.set(sights).unwrap();
    frame
}

#[test]
fn poses_come_back_bit_for_bit_and_reasons_by_name() {
    let frame = frame(&[
        MarkerSight::lost(MarkerFrame::REFERENCE, Lost::OutOfVolume, 12),
        MarkerSight::seen(MarkerFrame::TOOL, pose(), 0.21),
    ])
    .of_device("Polaris Vega");
    let tool = frame.sight::<Marker>(MarkerFrame::TOOL).unwrap();
    assert_eq!((tool.tracker_from_marker, tool.error_mm), (Ok(pose()), 0.21));
    let reference = frame.sight::<Reference>(MarkerFrame::REFERENCE).unwrap();
    assert_eq!(reference.tracker_from_marker, Err(Lost::OutOfVolume));
    // What does not stand in the frame was not seen, and an empty frame has nothing.
    assert_eq!(
        frame.sight::<Marker>(2).unwrap().tracker_from_marker,
        Err(Lost::NotSeen)
    );
    let none = MarkerFrame::EMPTY.sight::<Marker>(MarkerFrame::TOOL).unwrap();
    assert_eq!(none.tracker_from_marker, Err(Lost::NotSeen));
    assert_eq!(frame.device_name(), "Polaris Vega");
    for clock in CaptureClock::ALL {
        assert_eq!(CaptureClock::from_code(clock.code()), Some(clock));
    }
    assert_eq!(
        MarkerFrame { clock: 99, ..frame }.capture_clock(),
        CaptureClock::Arrival
    );
}

/// Zeros are no pose, whatever the status says.
#[test]
fn numbers_that_are_no_pose_are_refused_by_name() {
    let seen = MarkerSight::seen(0, pose(), 0.0);
    for (sight, words) in [
        (
            MarkerSight { q: [0.0; 4], ..seen },
            "frame 7 of the localizer, marker 0: quaternion of Tracker from Marker",
        ),
        (
            MarkerSight {
                q: [1.0, 0.01, 0.0, 0.0],
                ..seen
            },
            "quaternion of norm 1",
        ),
        (
            MarkerSight {
                t_mm: [0.0, f64::NAN, 0.0],
                ..seen
            },
            "finite",
        ),
        (
            MarkerSight {
                t_mm: [0.0, 2e5, 0.0],
                ..seen
            },
            "2e5 mm away; at most 1e5",
        ),
        (
            MarkerSight { age_ns: 1, ..seen },
            "before the frame; a frame is of one instant",
        ),
        (
            MarkerSight {
                age_ns: MarkerSight::NEVER,
                ..seen
            },
            "a frame is of one instant",
        ),
        (MarkerSight { error_mm: -0.1, ..seen }, "an error of -0.1 mm is stated"),
        (
            MarkerSight {
                error_mm: f64::NAN,
                ..seen
            },
            "an error of NaN mm is stated",
        ),
        (
            MarkerSight {
                error_mm: f64::INFINITY,
                ..seen
            },
            "an error of inf mm is stated",
        ),
        (
            MarkerSight { status: 14, ..seen },
            "status 14 is unknown; allowed are 0 (a pose) and 1 to 13",
        ),
    ] {
        let error = frame(&[sight]).sight::<Marker>(0).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // A reason needs no numbers.
    let lost = MarkerSight {
        t_mm: [f64::NAN; 3],
        status: 1,
        ..seen
    };
    assert_eq!(
        frame(&[lost]).sight::<Marker>(0).unwrap().tracker_from_marker,
        Err(Lost::NotSeen)
    );
}

#[test]
fn too_many_markers_and_one_that_stands_twice_are_refused() {
    let sights = [MarkerSight::lost(3, Lost::NotSeen, 0); 17];
    let mut frame = MarkerFrame {
        seq: 9,
        ..MarkerFrame::EMPTY
    };
    let error = frame.set(&sights).unwrap_err();
    assert_eq!(
        error.to_string(),
        "frame 9 of the localizer: 17 markers; at most 16 are allowed"
    );
    assert_eq!(
        frame,
        MarkerFrame {
            seq: 9,
            ..MarkerFrame::EMPTY
        }
    );
    frame.set(&sights[..2]).unwrap();
    // Also where it is another marker that is asked for.
    assert_eq!(
        frame.sight::<Marker>(0).unwrap_err().to_string(),
        "frame 9 of the localizer: marker 3 stands in it twice"
    );
    frame.count = u32::MAX;
    assert!(matches!(frame.sights(), Err(MarkersError::TooMany { found, .. }) if found == u32::MAX as usize));
}
