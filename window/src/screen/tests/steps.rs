//! The screen of steps: what it says and where, what can be done, and that what cannot is not done.

use std::collections::BTreeSet;

use bus::message::{
    StepFigure, StepGate, StepMotion, StepMotionKind, StepPhase, StepPoint, StepTask, StepWish, Steps, Workflow,
};
use egui::{Key, Role};
use egui_kittest::kittest::Queryable as _;
use guidance::workflow::Stage;

use super::stage::{stage, told};
use super::{SCREENS, assert_in_their_rooms, monitor, sample, shown};
use crate::model::sample::{CAPTURED_NS, Sample, workflow};
use crate::screen::{Look, Wish};
use crate::sizes::SMALLEST;

const SCENE: &str = "[tracker]\nsource = \"operating-room\"\n[tracker.calibration]\nfile = \"t\"\n[tracker.registration]\nfile = \"r\"\n\
    [steps]\ncalibrate = \"pivot\"\nbeads = \"b\"\n[[targets]]\nname = \"para-aortic-left\"\nct_mm = [0, 0, 0]";

fn look() -> Look {
    Look {
        steps: true,
        ..Look::default()
    }
}

/// A run whose calibrator says this.
fn run(steps: Steps) -> Sample {
    let base = sample(37.4, 1.3);
    let scene = scene::Scene::parse(SCENE, std::path::Path::new("")).unwrap();
    let views = base.scene.views.clone();
    Sample {
        scene: scene::Scene { views, ..scene },
        workflow: Some(workflow(Stage::Calibrated, 0)),
        steps: Some(steps),
        ..base
    }
}

fn point(name: &str, residual_mm: f64, flags: u32) -> StepPoint {
    let mut point = StepPoint::named(name);
    (point.residual_mm, point.left_out_mm, point.expected_mm) = (residual_mm, 2.0 * residual_mm, 0.9);
    point.flags = StepPoint::TOUCHED | flags;
    point
}

/// A registration of so many points.
fn registration(count: usize) -> Steps {
    let mut points: Vec<StepPoint> = (0..count)
        .map(|i| {
            point(
                &format!("point number {i} of the longest name"),
                0.1 * i as f64,
                if i == 1 { StepPoint::OFF } else { 0 },
            )
        })
        .collect();
    points[count - 1] = StepPoint::named("the last, which was not touched");
    let mut steps = Steps::none(&StepTask::ALL).with(
        &points,
        &[
            StepGate::new("max_fre_mm", 1.5, 0.41, true),
            StepGate::new("max_tre_mm", 0.5, 0.63, false),
            StepGate::new("min_cone_deg", 20.0, f64::NAN, false),
        ],
        &[StepFigure::new(
            "residuals 0.41 mm (root mean square), the largest 0.62 mm",
        )],
    );
    (steps.task, steps.phase) = (StepTask::Register.code(), StepPhase::Waiting.code());
    (steps.step, steps.steps, steps.next) = (count as u32 - 1, count as u32, count as u32 - 1);
    steps.flags = Steps::CAN_BEGIN | Steps::CAN_GO_BACK;
    steps.title = Steps::field("Patient: touch the points");
    steps.what = Steps::field("Put the tip on the last, which was not touched, and hold it still.");
    steps.why_not = Steps::field("the result is not accepted: max_tre_mm 0.5: found 0.6300");
    steps.command = Steps::field("pilot calibrate touch p5 --run default --to /tmp/steps/touch.csv --seconds 1");
    steps.target = Steps::field("para-aortic-left");
    (steps.covariance, steps.target_95_mm) = ([0.04, 0.01, 0.0, 0.05, 0.0, 0.03], 0.63);
    steps
}

/// A pivoting that is listened to.
fn listening() -> Steps {
    let mut steps = Steps::none(&StepTask::ALL);
    (steps.task, steps.phase) = (StepTask::Calibrate.code(), StepPhase::Listening.code());
    (steps.steps, steps.passed_s, steps.asked_s, steps.frames, steps.poses) = (1, 3.4, 12.0, 204, 201);
    steps.title = Steps::field("Tip: pivot");
    steps.what = Steps::field(
        "Put the tip into the divot and turn the instrument about it, to all sides. The tip must not slip.",
    );
    steps.advice = Steps::field("rotate more about the marker's x axis; 12.3 degrees so far, 20 are needed");
    steps
}

/// What a pivoting covers that went about one axis far and about the other a little.
fn pivoting(is_wide: bool) -> Steps {
    let needed_rad = 20_f64.to_radians();
    let reach = |k: usize| match is_wide {
        true => 1.2 * needed_rad,
        false => needed_rad * (0.3 + 1.2 * (std::f64::consts::TAU * k as f64 / 24.0).cos().abs()),
    };
    let mut steps = listening();
    steps.motion = StepMotion {
        kind: StepMotionKind::Pivot.code(),
        reach_rad: std::array::from_fn(reach),
        needed_rad,
        reached_rad: if is_wide { 0.42 } else { 0.215 },
        now_rad: [0.31, 0.08],
        // The two inner rings whole, of the next two some.
        cells: [0xc07e_0fff_ffff_ffff, if is_wide { 0xff_ffff } else { 0x60 }],
        up: 1,
    };
    steps
}

fn spinning() -> Steps {
    let mut steps = listening();
    (steps.step, steps.steps) = (1, 2);
    steps.title = Steps::field("Shaft: spin");
    steps.advice =
        Steps::field("turned by 71.0 degrees about one axis and 1.2 across it; turn it further about its shaft");
    steps.motion = StepMotion {
        kind: StepMotionKind::Spin.code(),
        reach_rad: [71_f64.to_radians(); StepMotion::SECTORS],
        needed_rad: 100_f64.to_radians(),
        reached_rad: 71_f64.to_radians(),
        now_rad: [-0.6, 0.0],
        cells: [0x0001_ffff_fffc_0000, 0],
        up: 1,
    };
    steps
}

/// The steps as the sheets of pictures have them.
pub(super) fn pictured() -> Vec<(&'static str, Sample, Look)> {
    let looked = |(name, steps): (&'static str, Steps)| (name, run(steps), look());
    let all = [
        ("steps: pivoting", pivoting(false)),
        ("steps: a wide pivoting", pivoting(true)),
        ("steps: spinning", spinning()),
        ("steps: five points", registration(5)),
    ];
    all.into_iter().map(looked).collect()
}

fn refused() -> Steps {
    let mut steps = registration(4);
    steps.refused = Steps::field(
        "touch of left side: the tip moved by 1.90 mm, 0.62 mm are allowed (--max-motion-mm); hold it still, and begin again",
    );
    steps
}

fn all() -> Vec<(&'static str, Sample)> {
    let mut failed = run(registration(5));
    failed.workflow = Some(
        workflow(
            Stage::Registered,
            Workflow::CHECK_FAILED | Workflow::IMAGES | Workflow::NOT_CHECKED,
        )
        .checked(3.2, 3, CAPTURED_NS - 600_000_000_000),
    );
    let mut checked = run(Steps::none(&StepTask::ALL));
    checked.workflow = Some(
        workflow(
            Stage::Navigating,
            Workflow::SIGHT | Workflow::IMAGES | Workflow::CONFIRMED,
        )
        .checked(0.8, 3, CAPTURED_NS - 5_000_000_000),
    );
    let mut silent = run(listening());
    silent.steps = None;
    vec![
        ("nothing begun", run(Steps::none(&StepTask::ALL))),
        ("listening", run(listening())),
        ("pivoting", run(pivoting(false))),
        ("a wide pivoting", run(pivoting(true))),
        ("spinning", run(spinning())),
        ("five points", run(registration(5))),
        ("32 points", run(registration(32))),
        ("refused", run(refused())),
        ("a check that failed", failed),
        ("navigating", checked),
        ("no calibrator", silent),
    ]
}

#[test]
fn every_word_of_the_steps_is_whole_and_in_its_room_on_every_screen() {
    for pixels in SCREENS.into_iter().chain([SMALLEST]) {
        for (name, sample) in all() {
            let outcome = shown(&sample.model(), monitor(pixels), &look(), Vec::new());
            // Names of points may be cut; nothing else.
            let found = assert_in_their_rooms(&outcome.words, Some("the longest name"));
            assert!(found.is_ok(), "{name}, {pixels:?}: {found:?}");
            assert!(outcome.code.is_some());
        }
    }
}

#[test]
fn the_ladder_says_what_is_done_and_what_a_check_came_to() {
    let says = |sample: &Sample, text: &str| {
        let outcome = shown(&sample.model(), monitor([1920, 1080]), &look(), Vec::new());
        // What is longer than a line goes on in the next.
        let all: Vec<&str> = outcome.words.0.iter().map(|placed| placed.text.as_str()).collect();
        assert!(all.join(" ").contains(text), "{text:?} in {all:?}");
    };
    for (name, sample) in all() {
        match name {
            "a check that failed" => says(&sample, "CHECK FAILED: 3 points, the worst 3.2 mm, 10 min ago"),
            "navigating" => {
                says(&sample, "[x] checked: 3 points, the worst 0.8 mm, 5 s ago");
                says(&sample, "[x] navigating");
            }
            "no calibrator" => says(&sample, "nothing came from the process `calib`"),
            "listening" => says(&sample, "3.4 of 12.0 s, the marker seen in 201 of 204 frames"),
            "pivoting" => {
                says(&sample, "cone 12.3 of 20.0 degrees");
                says(&sample, "of 24 sides reached");
            }
            "a wide pivoting" => says(&sample, "WIDE ENOUGH to every side"),
            "spinning" => says(&sample, "turn 71.0 of 100.0 degrees"),
            "refused" => says(&sample, "the tip moved by 1.90 mm"),
            "five points" => {
                says(&sample, "[x] tool calibrated");
                says(&sample, "[ ] patient registered");
                says(&sample, "error at the target (95 %) 0.63 mm, at most 0.5: NOT KEPT");
                says(&sample, "cone not measured, at least 20: NOT KEPT");
                says(&sample, "NOT YET: the result is not accepted");
                says(&sample, "registration at para-aortic-left: 95 % within 0.63 mm");
            }
            _ => {}
        }
    }
}

/// What stands on the images beside the registration: a check that is not young is seen to be so.
#[test]
fn the_age_and_the_worst_of_the_check_stay_on_the_screen() {
    let (_, navigating) = all().into_iter().find(|(name, _)| *name == "navigating").unwrap();
    let outcome = shown(&navigating.model(), monitor([1920, 1080]), &Look::default(), Vec::new());
    assert!(outcome.words.say("check 0.8 mm 0 min"), "{:?}", outcome.words);
    let (_, failed) = all()
        .into_iter()
        .find(|(name, _)| *name == "a check that failed")
        .unwrap();
    let outcome = shown(&failed.model(), monitor([1920, 1080]), &Look::default(), Vec::new());
    assert!(outcome.words.say("CHECK FAILED 3.2 mm 10 min"), "{:?}", outcome.words);
}

#[test]
fn what_can_be_done_is_done_by_its_key_and_what_cannot_is_not() {
    let waiting = run(registration(5)).model();
    let busy = run(listening()).model();
    let mut ready = registration(5);
    ready.flags |= Steps::CAN_ACCEPT;
    let ready = run(ready).model();
    let begin = Wish::Step(StepWish::Begin);
    let accept = Wish::Step(StepWish::Accept);
    for (model, key, wished) in [
        (&waiting, Key::Space, vec![begin.clone()]),
        (&waiting, Key::A, vec![]),
        (&ready, Key::A, vec![accept]),
        (&waiting, Key::Backspace, vec![Wish::Step(StepWish::Back)]),
        (&waiting, Key::ArrowDown, vec![Wish::NextPoint { is_forward: true }]),
        (&waiting, Key::F4, vec![Wish::Step(StepWish::Open(StepTask::Check))]),
        (&waiting, Key::C, vec![Wish::Confirm]),
        (&waiting, Key::F5, vec![Wish::Steps(false)]),
        // A navigation is not begun from here, nor is anything marked.
        (&waiting, Key::N, vec![]),
        (&busy, Key::Space, vec![]),
        (&busy, Key::A, vec![]),
        (&busy, Key::Backspace, vec![]),
        (&busy, Key::Escape, vec![Wish::Step(StepWish::Cancel)]),
    ] {
        let mut harness = stage(model.clone(), monitor([1920, 1080]), look());
        harness.key_press(key);
        harness.run();
        assert_eq!(harness.state().wishes, wished, "{key:?}");
    }
    // A touch on what cannot be done does nothing either, and the tree says that it cannot.
    let mut harness = stage(waiting, monitor([1920, 1080]), look());
    let accept = harness.get_by_role_and_label(Role::Button, "Accept");
    accept.click();
    harness.run();
    assert_eq!(harness.state().wishes, []);
}

/// Each key of the guide is a button's, and each button's key is in the guide.
#[test]
fn the_guide_of_the_steps_names_every_key_and_no_other() {
    let guide = include_str!("../../../../docs/steps.md");
    let keys = guide.split("## Keys").nth(1).unwrap().split("\n## ").next().unwrap();
    let first_column = keys
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" |").next());
    let named: BTreeSet<&str> = first_column
        .filter(|cell| *cell != "key")
        .flat_map(|cell| cell.split(", "))
        .collect();
    let mut found = BTreeSet::new();
    let mut registered = run(registration(5));
    registered.workflow = Some(workflow(Stage::Checked, Workflow::IMAGES));
    for sample in [registered, run(listening()), run(registration(5))] {
        let nodes = told(&stage(sample.model(), monitor([1920, 1080]), look()));
        found.extend(nodes.into_iter().filter_map(|node| node.key));
    }
    assert_eq!(named, found.iter().map(String::as_str).collect());
}
