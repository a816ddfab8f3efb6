//! Gestures from a file.

use super::*;
use scene::operating_room::{AtEnd, PlayedGesture};

const GESTURE: &str = "# by hand\nt_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n\
    1, 1,0,0,0, 0,0,0\n\n3, 0.7071068,0,0,0.7071068, 10,20,-40\r\n4,0,0,0,1, 10,20,0\n";

fn parse(text: &str, at_end: AtEnd) -> Result<Played, PlayedError> {
    Played::parse(text, Path::new("g.csv"), at_end)
}

#[test]
fn poses_are_joined_at_constant_speed() {
    let played = parse(GESTURE, AtEnd::Hold).unwrap();
    for (t_s, angle_deg, tip_mm) in [
        (0.0, 0.0, [0.0, 0.0, 0.0]),
        (1.5, 22.5, [2.5, 5.0, -10.0]),
        (2.0, 45.0, [5.0, 10.0, -20.0]),
        (3.0, 90.0, [10.0, 20.0, -40.0]),
        (3.5, 135.0, [10.0, 20.0, -20.0]),
        (99.0, 180.0, [10.0, 20.0, 0.0]),
    ] {
        let pose = played.ct_from_tool(t_s);
        // The file's quaternions have seven digits.
        assert!(
            (pose.angle().to_degrees() - angle_deg).abs() < 1e-5,
            "{t_s}: {}",
            pose.angle()
        );
        for (found, expected) in pose.translation_mm().into_iter().zip(tip_mm) {
            assert!((found - expected).abs() < 1e-12, "{t_s}: {found}");
        }
    }
}

#[test]
fn the_end_is_held_repeated_or_the_end() {
    let tip = |played: &Played, t_s: f64| played.ct_from_tool(t_s).translation_mm()[2];
    let again = parse(GESTURE, AtEnd::Loop).unwrap();
    assert_eq!((again.end_s(), tip(&again, 4.0)), (None, 0.0));
    assert!(
        (tip(&again, 6.5) + 20.0).abs() < 1e-12,
        "rounds are of 3 s and begin at 1 s"
    );
    assert!((tip(&again, 5.0) + 20.0).abs() < 1e-12 && (tip(&again, 302.0) - tip(&again, 2.0)).abs() < 1e-10);
    let once = parse(GESTURE, AtEnd::Once).unwrap();
    assert_eq!(once.end_s(), Some(4.0));
    let room = played(&scene(QUIET, ""), once, 1);
    let mut arrivals = Vec::new();
    room.arrivals(-1, 10_000_000_000, &mut arrivals);
    assert_eq!(arrivals.last().map(|a| a.seq), Some(240));
    assert!(room.frame(241).dropped && room.next_arrival(4_000_000_000, i64::MAX).is_none());
    assert_eq!(parse(GESTURE, AtEnd::Hold).unwrap().end_s(), None);
}

#[test]
fn what_is_no_gesture_is_refused_with_its_place() {
    let row = |row: &str| format!("t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n0,1,0,0,0,0,0,0\n{row}");
    for (text, expected) in [
        (String::new(), "no pose in it"),
        ("# nothing\n".to_owned(), "no pose in it"),
        ("t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned(), "no pose in it"),
        (
            "t,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n".to_owned(),
            "line 1, column 1: found t,qw",
        ),
        (
            row("1,1,0,0,0,0,0"),
            "line 3, column 14: found 7 fields; allowed: 8 fields",
        ),
        (
            row("1,1,0,0,0,0,0,0,9"),
            "line 3, column 17: found 9; allowed: 8 fields",
        ),
        (row("1,1,0,0, é,0,0,0"), "line 3, column 10: found \"é\""),
        (row("1,1,0,0,nan,0,0,0"), "line 3, column 9: found \"nan\""),
        (row("1,1,0,0,0,0,inf,0"), "line 3, column 13: found \"inf\""),
        (row("1,1,0,0,0,0,0,1e6"), "allowed: a number from -100000 to 100000"),
        (row("1,1,0.1,0,0,0,0,0"), "line 3, column 3: found 1, 0.1, 0, 0"),
        (row("1,0,0,0,0,0,0,0"), "norm 0"),
        (row("0,1,0,0,0,0,0,0"), "allowed: a time after the one before it, 0 s"),
        (row("-1,1,0,0,0,0,0,0"), "allowed: a time after the one before it"),
        (
            "t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n-1,1,0,0,0,0,0,0".to_owned(),
            "0 s or later",
        ),
    ] {
        let error = parse(&text, AtEnd::Hold).unwrap_err().to_string();
        assert!(error.starts_with("reading the gesture g.csv"), "{error}");
        assert!(error.contains(expected), "{text:?}\n  gave {error}\n  not {expected}");
    }
}

#[test]
fn absent_and_endless_files_are_refused() {
    let absent = PlayedGesture {
        file: "/nowhere/g.csv".into(),
        at_end: AtEnd::Hold,
    };
    assert!(matches!(Played::load(&absent), Err(PlayedError::Io { .. })));
    let row = |i: u32| format!("{},1,0,0,0,0,0,0\n", f64::from(i) / 2.0);
    let text: String = (0..1_000_001).map(row).collect();
    let text = format!("t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm\n{text}");
    let error = parse(&text, AtEnd::Hold).unwrap_err();
    assert!(
        matches!(
            error,
            PlayedError::TooLong {
                most: 1_000_000,
                what: "poses",
                ..
            }
        ),
        "{error}"
    );
    let most = text.trim_end().rsplit_once('\n').unwrap().0;
    assert!(parse(most, AtEnd::Hold).is_ok());
}

#[test]
fn a_file_is_played_in_the_room() {
    let folder = std::env::temp_dir().join(format!("trocar-gesture-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("g.csv");
    std::fs::write(&file, GESTURE).unwrap();
    let scene = scene(QUIET, &format!("[tracker.room.gesture]\nfile = {file:?}\n"));
    let room = approached(&scene, 1);
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(
        room.frame(120).ct_from_tool,
        parse(GESTURE, AtEnd::Hold).unwrap().ct_from_tool(2.0)
    );
}
