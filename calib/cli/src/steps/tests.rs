//! The desk without a run: what commands say is written here.

use std::path::Path;

use bus::message::{Practice, StepPhase, StepTask, StepWish, Steps};
use geometry::Point;
use scene::Scene;

use super::course::{Around, Moment, Said};
use super::desk::{Desk, Todo};
use crate::commands::Outcome;

const SCENE: &str = "[tracker]\nsource = \"operating-room\"\n[tracker.room.practice]\n[tracker.calibration]\nfile = \"t.json\"\n\
    [tracker.registration]\nfile = \"r.json\"\n[steps]\ncalibrate = \"pivot-and-spin\"\n\
    points = [{ name = \"a b\", ct_mm = [0, 0, 0] }, { name = \"b\", ct_mm = [90, 0, 0] }, { name = \"c\", ct_mm = [0, 90, 0] }]\n\
    check_points = [{ name = \"x\", ct_mm = [0, 0, 50] }, { name = \"y\", ct_mm = [9, 0, 50] }, { name = \"z\", ct_mm = [0, 9, 50] }]";

fn desk(work: &Path, is_practice: bool) -> Desk {
    let scene = Scene::parse(SCENE, Path::new("s.toml")).unwrap();
    let scene::TrackerSource::OperatingRoom(room) = &scene.tracker.source else {
        panic!("{SCENE}")
    };
    Desk::new(Around {
        run: "or".to_owned(),
        work: work.to_owned(),
        files: [Some("t.json".into()), Some("r.json".into())],
        spec: scene.steps.clone().unwrap(),
        target: Some(("node".to_owned(), Point::new(10.0, 20.0, 30.0))),
        check_mm: 2.0,
        room: room.practice.filter(|_| is_practice),
    })
}

fn moment(t_ns: i64, id: u64) -> Moment {
    Moment {
        t_ns,
        registration_id: Some(id),
    }
}

fn said(text: &str) -> Said {
    Ok(Outcome {
        text: text.to_owned(),
        refused: None,
    })
}

/// What `calib check --json` says.
fn checked(distance_mm: f64, radius_mm: f64, verdict: &str) -> Said {
    said(&format!(
        "{{\"verdict\": {verdict:?}, \"distance_mm\": {distance_mm}, \"predicted_radius_95_mm\": {radius_mm}, \"gates\": []}}"
    ))
}

fn words(todo: &[Todo]) -> String {
    let started = todo.iter().find_map(|todo| match todo {
        Todo::Start(words) => Some(words.join(" ")),
        _ => None,
    });
    started.unwrap_or_default()
}

#[test]
fn a_task_is_begun_before_anything_is_done_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    for wish in [StepWish::Begin, StepWish::Back, StepWish::Accept, StepWish::Point(0)] {
        assert_eq!(desk.wish(wish).unwrap_err(), "no task was begun", "{wish:?}");
    }
    assert!(desk.wish(StepWish::Cancel).unwrap_err().contains("nothing goes on"));
    let shown = desk.show(7);
    assert_eq!((shown.task(), shown.t_ns, shown.is(Steps::CAN_BEGIN)), (None, 7, false));
    assert!(StepTask::ALL.into_iter().all(|task| shown.has(task)));
}

#[test]
fn a_step_is_the_command_of_a_terminal_and_can_be_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    desk.wish(StepWish::Open(StepTask::Calibrate)).unwrap();
    assert_eq!(
        Steps::text(&desk.show(0).command),
        "pilot calibrate pivot --run or --seconds 20"
    );
    let (_, todo) = desk.wish(StepWish::Begin).unwrap();
    assert_eq!(words(&todo), "calib pivot --live or --seconds 20 --json");
    assert_eq!(desk.show(0).phase(), Some(StepPhase::Listening));
    assert!(desk.wish(StepWish::Begin).unwrap_err().contains("a step goes on"));
    assert_eq!(desk.wish(StepWish::Cancel).unwrap().1, [Todo::Cancel]);
    // What the command says after that is nobody's.
    assert!(desk.said(Err("given up".to_owned()), moment(0, 1)).is_empty());
    let shown = desk.show(0);
    assert_eq!(
        (shown.phase(), Steps::text(&shown.refused)),
        (Some(StepPhase::Waiting), String::new())
    );
    // What a command refuses stands on the screen, and nothing is proposed.
    desk.wish(StepWish::Begin).unwrap();
    desk.said(Err("no frame came".to_owned()), moment(0, 1));
    let shown = desk.show(0);
    assert_eq!(Steps::text(&shown.refused), "no frame came");
    assert!(!shown.is(Steps::CAN_ACCEPT) && desk.wish(StepWish::Accept).is_err());
}

#[test]
fn a_simulated_hand_goes_there_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), true);
    desk.wish(StepWish::Open(StepTask::Register)).unwrap();
    let (_, todo) = desk.wish(StepWish::Begin).unwrap();
    assert!(matches!(todo[..], [Todo::Send(Practice { .. })]), "{todo:?}");
    assert_eq!(desk.show(0).phase(), Some(StepPhase::Going));
    let todo = desk.arrived().unwrap();
    assert!(words(&[todo]).starts_with("calib touch p1 --live or --to "));
    assert!(desk.arrived().is_none());
}

#[test]
fn a_check_is_told_when_every_point_was_touched_and_is_as_old_as_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    desk.wish(StepWish::Open(StepTask::Check)).unwrap();
    let mut touch = |said: Said, moment: Moment| {
        desk.wish(StepWish::Begin).unwrap();
        desk.said(said, moment)
    };
    assert!(touch(checked(0.5, 1.0, "pass"), moment(100, 7)).is_empty());
    assert!(touch(checked(1.2, 1.0, "warn"), moment(200, 7)).is_empty());
    let [Todo::Report(report)] = &touch(checked(0.1, 1.0, "pass"), moment(300, 7))[..] else {
        panic!("no report")
    };
    assert_eq!(
        (report.worst_mm, report.points, report.moment),
        (1.2, 3, moment(100, 7))
    );
    assert_eq!(report.fails, "");
    assert!(
        desk.wish(StepWish::Begin)
            .unwrap_err()
            .contains("every point was touched")
    );
    // One touched again: told again, with the older touches of the others.
    desk.wish(StepWish::Point(0)).unwrap();
    desk.wish(StepWish::Begin).unwrap();
    let todo = desk.said(checked(0.4, 1.0, "pass"), moment(400, 7));
    assert!(matches!(&todo[..], [Todo::Report(report)] if report.moment == moment(200, 7)));
    assert!(desk.wish(StepWish::Point(3)).unwrap_err().contains("no point 3"));
}

#[test]
fn a_point_that_is_off_is_told_at_once_and_cannot_be_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    for (said, fails) in [
        (checked(2.1, 9.0, "pass"), ""),
        (checked(1.6, 1.0, "fail"), "x: 1.60 mm off, 1.00 mm hold 95 % of errors"),
    ] {
        let mut desk = desk(folder.path(), false);
        desk.wish(StepWish::Open(StepTask::Check)).unwrap();
        desk.wish(StepWish::Begin).unwrap();
        let todo = desk.said(said, moment(100, 7));
        assert!(
            matches!(&todo[..], [Todo::Report(report)] if report.points == 1 && report.fails == fails),
            "{todo:?}"
        );
        assert!(desk.show(0).points()[0].is_off());
        assert!(desk.wish(StepWish::Back).unwrap_err().contains("nothing to take back"));
    }
}

/// `calib check` warned that a mirrored registration would pass too, and the step called the registration checked.
#[test]
fn a_registration_by_points_in_a_plane_is_checked_at_a_point_off_it_alone() {
    let folder = tempfile::tempdir().unwrap();
    let of = |off_mm: [f64; 3]| {
        let mut desk = desk(folder.path(), false);
        desk.wish(StepWish::Open(StepTask::Check)).unwrap();
        let mut todo = Vec::new();
        for (t_ns, off_mm) in off_mm.into_iter().enumerate() {
            desk.wish(StepWish::Begin).unwrap();
            let verdict = if off_mm > 1.0 { "pass" } else { "warn" };
            let text = format!(
                "{{\"verdict\": {verdict:?}, \"distance_mm\": 0.4, \"predicted_radius_95_mm\": 1.0, \"off_plane_mm\": {off_mm}}}"
            );
            todo = desk.said(said(&text), moment(t_ns as i64, 7));
        }
        let report = todo.into_iter().find_map(|todo| match todo {
            Todo::Report(report) => Some(report.fails),
            _ => None,
        });
        let figures: Vec<String> = desk.show(0).figures().iter().map(|figure| figure.words()).collect();
        (report.unwrap(), figures.join("\n"))
    };
    let (fails, figures) = of([0.1, 0.2, 0.9]);
    assert!(
        fails.contains("points in a plane") && fails.contains("may be mirrored"),
        "{fails}"
    );
    assert!(figures.contains("MAY BE MIRRORED"), "{figures}");
    let (fails, figures) = of([0.1, 0.2, 1.5]);
    assert!(fails.is_empty() && !figures.contains("MIRRORED"), "{fails} {figures}");
}

#[test]
fn touches_under_another_registration_say_nothing_of_this_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    desk.wish(StepWish::Open(StepTask::Check)).unwrap();
    for (t_ns, id) in [(100, 7), (200, 7), (300, 8)] {
        desk.wish(StepWish::Begin).unwrap();
        assert!(desk.said(checked(0.5, 1.0, "pass"), moment(t_ns, id)).is_empty());
    }
    let touched: Vec<bool> = desk.show(0).points().iter().map(|point| point.is_touched()).collect();
    assert_eq!(touched, [false, false, true]);
    // One that changed while the point was touched: neither of both.
    desk.wish(StepWish::Begin).unwrap();
    let changed = Moment {
        t_ns: 400,
        registration_id: None,
    };
    assert!(desk.said(checked(0.5, 1.0, "pass"), changed).is_empty());
    let shown = desk.show(0);
    assert!(Steps::text(&shown.refused).contains("the registration changed"));
    assert!(!shown.points()[0].is_touched());
}

/// Two points touched before the patient was moved and one after it passed for a check.
#[test]
fn a_marker_that_is_moved_in_the_middle_leaves_no_touch() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    assert!(desk.moved().is_empty());
    desk.wish(StepWish::Open(StepTask::Check)).unwrap();
    for t_ns in [100, 200] {
        desk.wish(StepWish::Begin).unwrap();
        assert!(desk.said(checked(0.5, 1.0, "pass"), moment(t_ns, 7)).is_empty());
    }
    // While the third one is touched.
    desk.wish(StepWish::Begin).unwrap();
    assert_eq!(desk.moved(), [Todo::Cancel]);
    let shown = desk.show(0);
    assert!(shown.points().iter().all(|point| !point.is_touched()) && shown.next == 0);
    assert!(Steps::text(&shown.refused).contains("touch all points again"));
    // What the command that was given up still says counts for nothing.
    assert!(desk.said(checked(0.5, 1.0, "pass"), moment(300, 7)).is_empty());
    assert!(!desk.show(0).points()[0].is_touched());
    for t_ns in [400, 500] {
        desk.wish(StepWish::Begin).unwrap();
        assert!(desk.said(checked(0.5, 1.0, "pass"), moment(t_ns, 7)).is_empty());
    }
    // A registration as well; the tool's calibration has nothing to do with the patient.
    desk.wish(StepWish::Open(StepTask::Register)).unwrap();
    desk.moved();
    assert!(Steps::text(&desk.show(0).refused).contains("touch all points again"));
    desk.wish(StepWish::Open(StepTask::Calibrate)).unwrap();
    assert!(desk.moved().is_empty() && Steps::text(&desk.show(0).refused).is_empty());
}

/// Three points touched with one calibration of the tool and two with another were a registration that could be accepted.
#[test]
fn touches_with_another_calibration_are_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    desk.wish(StepWish::Open(StepTask::Register)).unwrap();
    let mut touch = |name: &str, calibration: &str| {
        desk.wish(StepWish::Begin).unwrap();
        let head = format!("# places of the tip of scope in the reference, mm; calibration {calibration}");
        let text = format!("{head}\non,x,y,z,cxx,cxy,cxz,cyy,cyz,czz\n{name},1,2,3,0.01,0,0,0.01,0,0.01\n");
        std::fs::write(folder.path().join("touch.csv"), text).unwrap();
        let todo = desk.said(said("touched"), moment(0, 1));
        let shown = desk.show(0);
        let touched: Vec<bool> = shown.points().iter().map(|point| point.is_touched()).collect();
        (todo.is_empty(), touched, Steps::text(&shown.refused))
    };
    assert_eq!(touch("p1", "aa"), (true, vec![true, false, false], String::new()));
    assert_eq!(touch("p2", "aa"), (true, vec![true, true, false], String::new()));
    let (computes_nothing, touched, refused) = touch("p3", "bb");
    assert_eq!((computes_nothing, touched), (true, vec![false, false, true]));
    assert!(refused.contains("2 points were touched before"), "{refused}");
    touch("p1", "bb");
    // With all three of one calibration it is computed.
    assert!(!touch("p2", "bb").0);
}

#[test]
fn touches_are_kept_in_a_file_and_the_last_of_a_point_counts() {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = desk(folder.path(), false);
    desk.wish(StepWish::Open(StepTask::Register)).unwrap();
    let head = "# places of the tip of scope in the reference, mm\non,x,y,z,cxx,cxy,cxz,cyy,cyz,czz\n";
    let mut touch = |name: &str, x: f64| {
        desk.wish(StepWish::Begin).unwrap();
        // As `calib touch` writes it, with the gates that it kept.
        let text = format!("{head}# max_rms_mm 2: found 1\n{name},{x},2,3,0.01,0,0,0.01,0,0.01\n");
        std::fs::write(folder.path().join("touch.csv"), text).unwrap();
        desk.said(said("touched"), moment(0, 1))
    };
    assert!(touch("p1", 1.0).is_empty() && touch("p2", 91.0).is_empty());
    let todo = touch("p3", 2.0);
    let command = words(&todo);
    assert!(command.starts_with("calib register --live or --pairs "), "{command}");
    assert!(
        command.ends_with("--json --target=10,20,30") && command.contains(" --least-noise-mm 0.316"),
        "{command}"
    );
    // With all that the touches state: the registration then counts it as `calib match` does.
    let pairs = std::fs::read_to_string(folder.path().join("pairs.csv")).unwrap();
    let lines: Vec<&str> = pairs.lines().collect();
    assert_eq!(
        [lines[0], lines[1], lines[3]],
        [
            "# places of the tip of scope in the reference, mm",
            "to_x,to_y,to_z,label,from_x,from_y,from_z,cxx,cxy,cxz,cyy,cyz,czz",
            "90,0,0,p2,91,2,3,0.01,0,0,0.01,0,0.01",
        ]
    );
    // Computed, then the first point again.
    desk.said(Err("points on a line".to_owned()), moment(0, 1));
    let shown = desk.show(0);
    assert_eq!(Steps::text(&shown.refused), "points on a line");
    assert!(Steps::text(&shown.why_not).contains("give no registration"));
    desk.wish(StepWish::Point(0)).unwrap();
    desk.wish(StepWish::Begin).unwrap();
    std::fs::write(
        folder.path().join("touch.csv"),
        format!("{head}p1,5,2,3,0.01,0,0,0.01,0,0.01\n"),
    )
    .unwrap();
    desk.said(said("touched"), moment(0, 1));
    let touched = std::fs::read_to_string(folder.path().join("touched.csv")).unwrap();
    let names: Vec<&str> = touched.lines().skip(2).map(|line| &line[..4]).collect();
    assert_eq!(names, ["p2,9", "p3,2", "p1,5"]);
    desk.said(Err("points on a line".to_owned()), moment(0, 1));
    // Taken back: two are left, and nothing is computed of them.
    let (_, todo) = desk.wish(StepWish::Back).unwrap();
    assert!(todo.is_empty());
    assert!(Steps::text(&desk.show(0).why_not).starts_with("2 of 3 points were touched"));
    // A touch that is refused is called by its point's own name.
    desk.wish(StepWish::Begin).unwrap();
    desk.said(Err("touch of p1: the tip moved".to_owned()), moment(0, 1));
    assert_eq!(Steps::text(&desk.show(0).refused), "touch of a b: the tip moved");
}
