//! The text of a plan: comes back as it was, and refuses what was changed, cut off, or written by others.

#![allow(clippy::unwrap_used, reason = "a test stops where it cannot go on")]

use geometry::Point;
use guidance::plan::file::{Changed, FileError, PlanFile};
use guidance::plan::{Confirmed, Measure, Plan, Target};
use guidance::workflow::VolumeId;
use proptest::prelude::*;

fn file() -> PlanFile {
    let target = Target {
        name: "para-aortic-left".to_owned(),
        centre: Point::new(33.1, -4.25, 50.123_456_789_012_3),
        diameter_mm: 5.0,
        entry: Some(Point::new(120.0, 60.0, 40.0)),
        stop_mm: 3.0,
    };
    let plan = Plan {
        targets: vec![target],
        measures: vec![
            Measure::Distance([Point::new(0.0, 0.0, 0.0), Point::new(1.0, 2.0, 3.0)]),
            Measure::Angle([
                Point::new(0.0, 0.0, 1.0),
                Point::new(0.0, 0.0, 0.0),
                Point::new(0.0, 1.0, 0.0),
            ]),
        ],
        notes: "left \"flank\"\nsecond line".to_owned(),
        confirmed: Some(Confirmed {
            by: "Dr. A".to_owned(),
            at: "2026-11-25T12:00:00Z".to_owned(),
        }),
        ..Plan::new(VolumeId([0xab; 32]))
    };
    PlanFile {
        plan,
        written_by: "trocar 0.2.0".to_owned(),
        made_at: "2026-11-25T11:00:00Z".to_owned(),
        changed_at: "2026-11-25T12:00:00Z".to_owned(),
    }
}

fn refused(text: &str) -> FileError {
    PlanFile::parse(text, Changed::Refused).unwrap_err()
}

proptest! {
    #[test]
    fn a_plan_comes_back_bit_by_bit(x in prop::array::uniform3(-1e4..1e4_f64), d in 0.1..200.0_f64, hash in any::<[u8; 32]>()) {
        let mut file = file();
        file.plan.volume = VolumeId(hash);
        file.plan.targets[0].centre = Point::new(x[0], x[1], x[2]);
        file.plan.targets[0].entry = None;
        file.plan.targets[0].diameter_mm = d;
        prop_assert_eq!(&PlanFile::parse(&file.text(), Changed::Refused).unwrap(), &file);
        // Blanks and line ends say nothing.
        let packed: serde_json::Value = serde_json::from_str(&file.text()).unwrap();
        prop_assert_eq!(PlanFile::parse(&packed.to_string(), Changed::Refused).unwrap(), file);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..200), at in 0_usize..1000) {
        let mut text = file().text().into_bytes();
        let at = at % text.len();
        let end = (at + bytes.len()).min(text.len());
        text.splice(at..end, bytes);
        let _ = PlanFile::parse(&String::from_utf8_lossy(&text), Changed::Taken);
    }
}

/// Every value of the file, one after the other.
#[test]
fn what_was_changed_by_hand_is_refused_and_taken_only_as_not_confirmed() {
    let text = file().text();
    for (was, is) in [
        ("33.1", "33.2"),
        ("-4.25", "4.25"),
        ("5.0", "5.5"),
        ("120.0", "121.0"),
        ("\"stop_mm\": 3.0", "\"stop_mm\": 2.0"),
        ("abababab", "abababac"),
        ("para-aortic-left", "para-aortic-right"),
        ("Dr. A", "Dr. B"),
        ("\"angle\"", "\"angle\" "),
        ("2026-11-25T11", "2026-11-25T10"),
        ("left \\\"flank", "right \\\"flank"),
    ] {
        let changed = text.replacen(was, is, 1);
        assert_ne!(changed, text);
        if was == "\"angle\"" {
            assert!(PlanFile::parse(&changed, Changed::Refused).is_ok());
            continue;
        }
        let said = refused(&changed).to_string();
        assert!(
            said.contains(&format!("it states the id {}", file().id())),
            "{was}: {said}"
        );
        let taken = PlanFile::parse(&changed, Changed::Taken).unwrap();
        assert_eq!(taken.plan.confirmed, None);
    }
    // A confirmation that somebody wrote into it.
    let mut open = file();
    open.plan.confirmed = None;
    let text = open.text();
    let forged = text.trim_end().trim_end_matches('}').trim_end().to_owned();
    let forged = forged + ",\n\"confirmed\": {\"by\": \"X\", \"at\": \"2026-11-25T12:00:00Z\"}}";
    assert!(matches!(refused(&forged), FileError::OtherContent { .. }));
    assert_eq!(PlanFile::parse(&forged, Changed::Taken).unwrap().plan, open.plan);
}

#[test]
fn what_is_no_plan_is_refused_by_name() {
    let text = file().text();
    for (was, is, said) in [
        ("\"version\": 1", "\"version\": 2", "written by a later Trocar"),
        (
            "\"version\": 1",
            "\"version\": -1",
            "Give a plan that `pilot plan` wrote",
        ),
        (
            "trocar-plan",
            "trocar-registration",
            "found format \"trocar-registration\"",
        ),
        ("LPS, mm", "RAS, mm", "found frame \"ct, RAS, mm\""),
        ("\"stop_mm\"", "\"stopp_mm\"", "unknown field `stopp_mm`"),
        ("abababab", "xyxyxyxy", "key volume.hash"),
        (
            "\"diameter_mm\": 5.0",
            "\"diameter_mm\": 0.0",
            "diameter of para-aortic-left: found 0",
        ),
        ("\"diameter_mm\": 5.0", "\"diameter_mm\": \"5\"", "expected f64 at line"),
        (
            "\"distance\"",
            "\"angle\"",
            "measures.0.ct_mm: found 2 points; expected 3",
        ),
        ("\"distance\"", "\"area\"", "unknown variant `area`"),
    ] {
        let changed = text.replacen(was, is, 1);
        assert_ne!(changed, text, "{was}");
        let found = refused(&changed).to_string();
        assert!(found.contains(said), "{said:?}: {found}");
    }
    assert!(matches!(refused(""), FileError::Json(_)));
    assert!(matches!(refused("{}"), FileError::OtherVersion { is_newer: false, .. }));
    assert!(matches!(refused(&" ".repeat((1 << 20) + 1)), FileError::TooLong { .. }));
    for end in 0..text.len() - 2 {
        assert!(text.is_char_boundary(end));
        assert!(PlanFile::parse(&text[..end], Changed::Taken).is_err(), "{end}");
    }
}
