//! What is well-formed and yet not to be believed: stamps, rotations, grids, the words about a tool.

use std::borrow::Cow;

use igtl::rotation::{RotationError, check, check_quaternion};
use igtl::{
    ByteOrder, GridError, Image, Matrix, Metadata, Scalar, Space, Stamp, StampError, StampWatch, Text, ToolStatus,
    check_grid, frame,
};

const SECOND: u64 = 1_000_000_000;
const NOW: u64 = 1_790_000_000 * SECOND;
/// What recorded trackers keep.
const ALLOWED: f64 = 2e-3;

fn stamp(ns: u64) -> Stamp {
    Stamp::of_ns(ns).unwrap()
}

#[test]
fn a_stamp_gives_its_nanoseconds_back() {
    for ns in [
        0,
        1,
        999_999_999,
        NOW + 123_456_789,
        u64::from(u32::MAX) * SECOND + 999_999_999,
    ] {
        assert_eq!(stamp(ns).ns(), ns);
    }
    assert_eq!(Stamp::of_ns((1 << 32) * SECOND), None);
}

#[test]
fn stamps_are_judged_by_those_before() {
    let mut watch = StampWatch::default();
    assert_eq!(watch.judge(Stamp::NONE), Err(StampError::None));
    assert_eq!(watch.judge(stamp(5)), Err(StampError::FractionOnly { fraction_ns: 5 }));
    assert_eq!(watch.judge(stamp(NOW)), Ok(()));
    assert_eq!(watch.judge(stamp(NOW)), Err(StampError::Repeated { ns: NOW }));
    assert_eq!(watch.judge(stamp(NOW - 7)), Err(StampError::Back { by_ns: 7 }));
    // After an NTP step the new time is as good as the old one was.
    assert_eq!(watch.judge(stamp(NOW - 6)), Ok(()));
}

#[test]
fn stamps_are_judged_by_a_clock() {
    let judge = |raw: Stamp| StampWatch::default().judge_at(raw, NOW, SECOND);
    assert_eq!(judge(stamp(NOW - SECOND)), Ok(()));
    let hour = 3600 * SECOND;
    assert!(matches!(judge(stamp(NOW + hour)), Err(StampError::Ahead { by_ns, .. }) if by_ns == hour));
    // The last second that can be said, in 2106.
    assert!(matches!(judge(Stamp(u64::MAX)), Err(StampError::Ahead { .. })));
    // Milliseconds in the place of seconds, as far as 32 bits hold them.
    let milliseconds = (NOW / 1_000_000) & 0xffff_ffff;
    assert!(judge(Stamp(milliseconds << 32)).is_err());
    assert!(matches!(judge(stamp(NOW - hour)), Err(StampError::Old { .. })));
}

/// A turn about an axis that is none of the frame's.
fn rotation() -> [[f32; 3]; 3] {
    let (third, two) = (1.0 / 3.0, 2.0 / 3.0);
    [[two, two, third], [-two, third, two], [third, -two, two]]
}

#[test]
fn what_is_no_rotation_is_named_with_its_deviation() {
    assert!(check(&rotation(), 1e-6).unwrap().orthonormal < 1e-6);
    assert_eq!(check(&[[0.0; 3]; 3], ALLOWED), Err(RotationError::Zero));
    let metres = rotation().map(|column| column.map(|n| n * 1000.0));
    assert!(matches!(check(&metres, ALLOWED), Err(RotationError::Scales { scale }) if (scale - 1000.0).abs() < 0.01));
    let millionths = rotation().map(|column| column.map(|n| n * 0.001));
    assert!(matches!(check(&millionths, ALLOWED), Err(RotationError::Scales { .. })));
    let [x, y, z] = rotation();
    let mirrored = [x, y, z.map(|n| -n)];
    assert!(matches!(check(&mirrored, ALLOWED), Err(RotationError::Mirrors { determinant }) if determinant < -0.99));
    let mut skew = rotation();
    skew[0][0] += 0.01;
    let Err(RotationError::Off { deviation, .. }) = check(&skew, ALLOWED) else {
        panic!()
    };
    assert!((0.006..0.03).contains(&deviation), "{deviation}");
}

#[test]
fn rows_taken_for_columns_are_seen_where_the_place_comes_among_them() {
    // The first twelve numbers of a 4 x 4 matrix row by row.
    let [x, y, z] = rotation();
    let place = [40.0, -20.0, 900.0];
    let rows: Vec<f32> = (0..3).flat_map(|row| [x[row], y[row], z[row], place[row]]).collect();
    let columns = [
        [rows[0], rows[1], rows[2]],
        [rows[3], rows[4], rows[5]],
        [rows[6], rows[7], rows[8]],
    ];
    assert!(check(&columns, ALLOWED).is_err());
    // A rotation that was transposed alone is one.
    let transposed = [0, 1, 2].map(|row| [x[row], y[row], z[row]]);
    assert!(check(&transposed, 1e-6).is_ok());
}

#[test]
fn a_quaternion_has_length_one() {
    assert_eq!(check_quaternion(&[0.0; 4], ALLOWED), Err(RotationError::ZeroQuaternion));
    assert!(matches!(
        check_quaternion(&[0.0, 0.577, 0.577, 0.333], ALLOWED),
        Err(RotationError::Length { length, .. }) if length < 0.9
    ));
    assert!(check_quaternion(&[0.5, -0.5, 0.5, 0.5], 1e-6).is_ok());
}

fn image(columns: [[f32; 3]; 3], space: Space) -> Image<'static> {
    Image {
        components: 1,
        scalar: Scalar::Uint8,
        order: ByteOrder::Little,
        space,
        dimensions: [3, 1, 1],
        placed: Matrix {
            columns,
            translation: [10.0, 20.0, 30.0],
        },
        offset: [0; 3],
        size: [3, 1, 1],
        voxels: Cow::Borrowed(&[1, 2, 3]),
    }
}

#[test]
fn a_grid_is_right_handed_and_at_right_angles() {
    let steps = [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 2.0]];
    assert_eq!(check_grid(&image(steps, Space::Ras), 0.01), Ok([0.5, 0.5, 2.0]));
    let left = [steps[1], steps[0], steps[2]];
    assert_eq!(check_grid(&image(left, Space::Ras), 0.01), Err(GridError::LeftHanded));
    let tilted = [steps[0], [0.0, 0.5, 0.1], steps[2]];
    assert!(matches!(
        check_grid(&image(tilted, Space::Ras), 0.01),
        Err(GridError::Sheared { axes: "j and k", degrees, .. }) if (degrees - 11.31).abs() < 0.01
    ));
    let flat = [steps[0], steps[1], [0.0; 3]];
    assert_eq!(
        check_grid(&image(flat, Space::Ras), 0.01),
        Err(GridError::Flat { axis: 'k' })
    );
}

#[test]
fn an_image_says_where_its_first_voxel_is_and_in_which_axes() {
    let ras = image([[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], Space::Ras);
    assert_eq!(ras.origin(), [8.0, 20.0, 30.0]);
    let lps = Image {
        space: Space::Lps,
        ..ras.clone()
    };
    assert_eq!(frame::placed_in(&ras, Space::Ras), ras.placed);
    // The same numbers under the other flag are another place.
    let turned = frame::placed_in(&lps, Space::Ras);
    assert_eq!(
        (turned.columns[0], turned.translation),
        ([-2.0, 0.0, 0.0], [-10.0, -20.0, 30.0])
    );
    assert_eq!(check_grid(&Image { placed: turned, ..lps }, 0.01), Ok([2.0; 3]));
}

#[test]
fn frames_are_turned_on_one_side_or_on_both() {
    let [x, y, z] = rotation();
    let one = Matrix {
        columns: [x, y, z],
        translation: [1.0, 2.0, 3.0],
    };
    assert_eq!(frame::turned_target(&one).columns[0], [-x[0], -x[1], x[2]]);
    assert_eq!(frame::turned_target(&frame::turned_target(&one)), one);
    let both = frame::turned_both(&one);
    assert_eq!(
        (both.columns[0], both.columns[2]),
        ([x[0], x[1], -x[2]], [-z[0], -z[1], z[2]])
    );
    assert_eq!(both.translation, [-1.0, -2.0, 3.0]);
    assert!(check(&both.columns, 1e-6).is_ok());
    assert_eq!(Matrix::from_rows(one.rows()), one);
}

#[test]
fn a_status_is_ok_letter_by_letter_or_it_is_not() {
    let status = |text: &str| ToolStatus::of_transform(&Metadata::EMPTY.with("TransformStatus", Text::new(text)));
    assert_eq!(ToolStatus::of_transform(&Metadata::EMPTY), ToolStatus::Absent);
    assert!(status("OK").is_ok());
    for text in ["ok", "Ok ", "", "OK\0", " OK", "okay", "TOOL_OK"] {
        let found = status(text);
        assert!(!found.is_ok() && matches!(found, ToolStatus::Foreign(_)), "{text:?}");
    }
    assert_eq!(status(&"O".repeat(1 << 20)), ToolStatus::Foreign("O".repeat(64)));
    for (text, expected) in [
        ("MISSING", ToolStatus::Missing),
        ("OUT_OF_VIEW", ToolStatus::OutOfView),
        ("OUT_OF_VOLUME", ToolStatus::OutOfVolume),
        ("SWITCH2_IS_ON", ToolStatus::SwitchOn(2)),
        ("REQ_TIMEOUT", ToolStatus::TimedOut),
        ("INVALID", ToolStatus::Invalid),
        ("PATH_NOT_FOUND", ToolStatus::PathNotFound),
        ("UNKNOWN", ToolStatus::Unknown),
    ] {
        assert_eq!((status(text).word(), &status(text)), (Some(text), &expected));
    }
    // The key holds the whole name; that of a tool that was cut is another.
    let metadata = Metadata::EMPTY.with("StylusTipToReferenceFrameStatus", Text::new("OK"));
    assert_eq!(
        ToolStatus::of_tool(&metadata, "StylusTipToReference"),
        ToolStatus::Absent
    );
    assert!(ToolStatus::of_tool(&metadata, "StylusTipToReferenceFrame").is_ok());
}
