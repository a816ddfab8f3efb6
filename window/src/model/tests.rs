//! What the screen may claim, state by state, and the inputs that would make it claim more.

mod facts;

use super::sample::{CAPTURED_NS, Sample, VOLUME, pose, workflow};
use super::*;
use bus::gather::PoseId;
use bus::message::{Chosen, FrameState, Guide, Lost, TargetShown, TissueShown, Tracked, VolumeHash};
use geometry::{Direction, Point, Tool};
use guidance::sight::Verdict;
use guidance::workflow::Stage;
use proptest::prelude::*;

/// A tube from the patient's left towards a target 30 mm before its tip.
fn sample() -> Sample {
    let pose = pose([0.3, 0.9, 0.1], [10.0, -5.0, 70.0]);
    let target = pose * Point::<Tool>::new(0.5, 0.0, 30.0);
    Sample::new(pose, target)
}

#[test]
fn a_live_pose_navigates_with_a_sight() {
    let model = sample().model();
    assert_eq!(
        (model.state.word.as_str(), model.state.tone),
        ("NAVIGATING", Tone::Live)
    );
    assert_eq!(model.state.age_ms, Some(20.0));
    assert_eq!(model.state.marks, ["RESEARCH", "NOT CHECKED"]);
    let aimed = model.sight.unwrap();
    assert!((aimed.sight.to_go_mm - 30.0).abs() < 1e-9 && (aimed.sight.miss_length_mm - 0.5).abs() < 1e-9);
    assert_eq!(aimed.sight.verdict, Verdict::OnCourse);
    assert!(model.cells.iter().all(|cell| cell.over.is_none()));
}

#[test]
fn whatever_is_not_live_has_no_sight_and_no_age() {
    let far = i64::MAX / 2;
    let lost: Vec<(&str, Sample)> = vec![
        ("NO POSE", sample().in_state(FrameState::Lost(Lost::NotSeen))),
        ("OLD", sample().in_state(FrameState::Stale)),
        // Nobody draws any more: the image itself still says LIVE.
        (
            "OLD",
            Sample {
                now_ns: CAPTURED_NS + 150_000_000,
                ..sample()
            },
        ),
        (
            "NO POSE",
            Sample {
                now_ns: far,
                ..sample()
            },
        ),
        (
            "NO IMAGES",
            Sample {
                headers: vec![None; 7],
                set: None,
                ..sample()
            },
        ),
        (
            "WRONG IMAGES",
            Sample {
                volume: Some(VolumeHash([1; 32])),
                ..sample()
            },
        ),
    ];
    for (word, sample) in lost {
        let model = sample.model();
        assert_eq!(model.state.word, word);
        assert!(!model.state.follows && model.state.age_ms.is_none(), "{word}");
        assert!(model.sight.is_err(), "{word}");
        assert!(model.cells.iter().all(|cell| cell.over.is_some()), "{word}");
    }
}

#[test]
fn one_view_that_is_lost_or_foreign_takes_the_sight_from_all() {
    for view in 0..7 {
        let mut lost = sample();
        lost.headers[view].as_mut().unwrap().stamp.state = Lost::Reference.code();
        assert_eq!(lost.model().state.word, "NO POSE");
        assert!(lost.model().sight.is_err());
        let mut foreign = sample();
        foreign.headers[view].as_mut().unwrap().stamp.volume_hash = [9; 32];
        assert_eq!(foreign.model().state.word, "WRONG IMAGES");
        let mut unknown = sample();
        unknown.headers[view].as_mut().unwrap().stamp.state = 55;
        assert_eq!(unknown.model().state.tone, Tone::Alarm);
        let mut missing = sample();
        missing.headers[view] = None;
        assert_eq!(missing.model().state.word, "NO IMAGES");
    }
}

/// A renderer died, and the screen said NO POSE, tracker silent, while the tracker was well.
#[test]
fn a_view_that_nobody_draws_is_not_the_trackers_fault() {
    let mut still = sample();
    still.headers[2].as_mut().unwrap().stamp.t_capture_ns -= 60_000_000_000;
    let model = still.model();
    assert_eq!(
        (model.state.word.as_str(), model.state.detail.as_str()),
        ("NO IMAGES", "1 of 7 views stand still")
    );
    assert!(model.sight.is_err());
    let over = |view| model.cells.iter().find(|cell| cell.view == view).unwrap().over.clone();
    assert_eq!(over(2), Some((Tone::Alarm, "STANDS STILL, 60.0 s OLD".to_owned())));
    assert_eq!(over(0), Some((Tone::Alarm, "NO IMAGES".to_owned())));
    // Where the tracker is silent, renderers that live say so.
    still.headers[1].as_mut().unwrap().stamp.state = Lost::Silent.code();
    assert_eq!(still.model().state.word, "NO POSE");
}

#[test]
fn images_of_different_poses_are_marked_and_the_sight_is_of_the_one_beside_it() {
    let mut mixed = sample();
    mixed.set = Some(Set::Mixed { poses: 3, missing: 0 });
    let older = mixed.headers[0].as_mut().unwrap();
    older.stamp.seq = 297;
    older.stamp.t_capture_ns -= 50_000_000;
    let model = mixed.model();
    assert!(model.state.is_mixed && model.state.set == "VIEWS DIFFER 3 POSES");
    // The age is that of the oldest.
    assert_eq!(model.state.age_ms, Some(70.0));
    assert_eq!(model.sight.unwrap().pose.seq, 300);
}

#[test]
fn a_pose_that_is_not_that_of_the_images_gives_no_sight() {
    let mut other = sample();
    other.poses[0].seq = 299;
    assert_eq!(other.model().sight.unwrap_err(), "the pose of the images has not come");
    // The same number from a source that was started again is another pose.
    let mut again = sample();
    again.poses[0].t_capture_ns -= 1;
    assert!(again.model().sight.is_err());
    let mut lost = sample();
    lost.poses[0].set(Tracked::Lost(Lost::NotSeen));
    assert!(lost.model().sight.is_err());
}

#[test]
fn no_target_no_stage_and_no_navigation_are_told() {
    let none = Sample {
        guide: None,
        ..sample()
    };
    assert!(none.model().sight.unwrap_err().contains("no target chosen"));
    let cleared = Sample {
        guide: Some(Guide::default()),
        ..sample()
    };
    assert!(cleared.model().sight.unwrap_err().contains("no target chosen"));
    let unknown = Sample {
        workflow: None,
        ..sample()
    };
    assert!(unknown.model().sight.is_err());
    assert_eq!(unknown.model().state.word, "LIVE");
    for stage in Stage::ALL {
        let at = Sample {
            workflow: Some(workflow(stage, 0)),
            ..sample()
        };
        assert!(at.model().sight.is_err(), "{stage:?}");
    }
    for (flag, word) in [
        (Workflow::BUMPED, "REFERENCE MOVED"),
        (Workflow::CHECK_FAILED, "CHECK FAILED"),
    ] {
        let doubted = workflow(Stage::Registered, flag);
        let model = Sample {
            workflow: Some(doubted),
            ..sample()
        }
        .model();
        assert_eq!((model.state.word.as_str(), model.state.tone), (word, Tone::Alarm));
    }
}

#[test]
fn a_replay_is_never_called_navigating() {
    let marked = |mut sample: Sample, replay: u32| {
        sample
            .headers
            .iter_mut()
            .flatten()
            .for_each(|header| header.stamp.replay = replay);
        sample
    };
    for (sample, word) in [
        (
            Sample {
                is_replay: true,
                ..sample()
            },
            "REPLAY",
        ),
        (
            Sample {
                is_simulated: true,
                ..sample()
            },
            "SIMULATED TIME",
        ),
        (marked(sample(), 1), "REPLAY"),
    ] {
        let model = sample.model();
        assert_eq!((model.state.word.as_str(), model.state.tone), (word, Tone::Replay));
    }
}

#[test]
fn what_is_held_says_so() {
    let mut held = sample();
    let id = PoseId {
        seq: 300,
        t_capture_ns: CAPTURED_NS,
    };
    held.guide = held.guide.map(|guide| guide.holding(Some(id)));
    let held = held.in_state(FrameState::Requested);
    let model = held.model();
    assert_eq!((model.state.word.as_str(), model.state.is_held), ("HELD", true));
    assert!(model.sight.is_err() && !model.state.follows);
    assert_eq!(model.state.detail, "pose 20 ms old");
    assert!(model.cells.iter().all(|cell| cell.over.is_none()));
    let replay = Sample {
        is_replay: true,
        ..held.clone()
    };
    assert_eq!(replay.model().state.detail, "pose 20 ms old, not the present");
    let undrawn = Sample {
        headers: vec![None; 7],
        ..held
    };
    let state = undrawn.model().state;
    assert_eq!(
        (state.word.as_str(), state.detail.as_str()),
        ("NO IMAGES", "no view has sent an image of the pose that is held")
    );
}

/// HELD and OLD stood there alone while the marker on the patient was pushed.
#[test]
fn a_pushed_marker_is_said_whatever_is_held_or_old() {
    let mut pushed = sample();
    pushed.workflow = Some(workflow(Stage::Registered, Workflow::BUMPED));
    let old = Sample {
        now_ns: CAPTURED_NS + 150_000_000,
        ..pushed.clone()
    };
    let id = PoseId {
        seq: 300,
        t_capture_ns: CAPTURED_NS,
    };
    let mut held = pushed.clone().in_state(FrameState::Requested);
    held.guide = held.guide.map(|guide| guide.holding(Some(id)));
    for sample in [pushed, old, held] {
        let state = sample.model().state;
        assert_eq!((state.word.as_str(), state.tone), ("REFERENCE MOVED", Tone::Alarm));
    }
}

/// Images that were asked for claim nothing of the present; on the topic of live ones they would be followed.
#[test]
fn an_image_that_was_asked_for_is_never_followed_as_live() {
    for state in [FrameState::Requested, FrameState::Look] {
        for view in 0..7 {
            let mut other = sample();
            other.headers[view].as_mut().unwrap().stamp.state = state.code();
            let model = other.model();
            assert_eq!(model.state.word, "WRONG IMAGES", "{state:?}");
            assert!(model.sight.is_err());
        }
    }
}

/// A tip in the middle of a target, so that only the error speaks against ON TARGET.
fn arrived() -> Sample {
    let pose = pose([0.3, 0.9, 0.1], [10.0, -5.0, 70.0]);
    let mut sample = Sample::new(pose, pose * Point::<Tool>::new(0.0, 0.0, 0.0));
    sample.poses[0].covariance = [0.0; 21];
    sample
}

#[test]
fn an_error_that_is_not_known_is_never_on_target() {
    let verdict = |change: &dyn Fn(&mut ToolPose)| {
        let mut sample = arrived();
        change(&mut sample.poses[0]);
        sample.model().sight.unwrap().sight.verdict
    };
    let small = |pose: &mut ToolPose| [15, 18, 20].into_iter().for_each(|place| pose.covariance[place] = 0.01);
    assert_eq!(verdict(&small), Verdict::OnTarget);
    // Nobody predicted it, whatever stands in the covariance.
    assert_eq!(
        verdict(&|pose| {
            small(pose);
            pose.flags = 0;
        }),
        Verdict::ErrorUnknown
    );
    // All zero: exact only from a source without noise that says that its tip has no error.
    assert_eq!(verdict(&|_| {}), Verdict::ErrorUnknown);
    assert_eq!(
        verdict(&|pose| pose.flags |= ToolPose::NOISELESS),
        Verdict::ErrorUnknown
    );
    let exact = |pose: &mut ToolPose| {
        pose.flags |= ToolPose::NOISELESS;
        pose.tip_mm = 0.0;
    };
    assert_eq!(verdict(&exact), Verdict::OnTarget);
    // Without noise, on a registration with an error of centimetres.
    assert_ne!(
        verdict(&|pose| {
            exact(pose);
            [15, 18, 20]
                .into_iter()
                .for_each(|place| pose.covariance[place] = 400.0);
        }),
        Verdict::OnTarget
    );
}

#[test]
fn a_recording_of_another_examination_has_no_sight() {
    let replay = |recorded_in| Sample {
        is_replay: true,
        recorded_in: Some(recorded_in),
        ..sample()
    };
    assert!(replay(Some(VOLUME.to_string())).model().sight.is_ok());
    for (recorded, words) in [
        (
            Some(VolumeHash([1; 32]).to_string()),
            "not the examination of the recording",
        ),
        (None, "does not say"),
    ] {
        let model = replay(recorded).model();
        assert!(model.state.detail.contains(words), "{}", model.state.detail);
        assert!(model.sight.unwrap_err().contains(words));
    }
}

#[test]
fn images_are_not_followed_before_the_workflow_allows_it() {
    for stage in [Stage::Loaded, Stage::Confirmed, Stage::Calibrated] {
        let early = Sample {
            workflow: Some(workflow(stage, 0)),
            ..sample()
        };
        let model = early.model();
        assert_eq!(
            (model.state.word.as_str(), model.state.tone),
            (stage.word(), Tone::Warning)
        );
        assert!(!model.state.follows);
        // They stood there bright, with the distances that are drawn on them.
        let over = Some((Tone::Warning, stage.word().to_owned()));
        assert!(model.cells.iter().all(|cell| cell.over == over), "{:?}", model.cells);
    }
}

proptest! {
    /// H8: letters come from the plane; and the sight's right is the right of the image across the tube.
    #[test]
    fn a_target_on_the_patients_left_is_on_the_side_of_the_letter_l(
        turn in prop::array::uniform3(-3.0..3.0), depth in 1.0..80.0, off in 1.0..20.0
    ) {
        let ct_from_tool = pose(turn, [10.0, -5.0, 70.0]);
        let along = ct_from_tool * Direction::<Tool>::Z;
        let left = Direction::X.vector() - along * Direction::X.dot(along);
        prop_assume!(left.norm() > 0.3);
        let tip = ct_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
        let target = tip + along * depth + left.direction().unwrap() * off;
        let model = Sample::new(ct_from_tool, target).model();
        let sight = model.sight.unwrap().sight;
        let cell = model.cells.last().unwrap();
        let [at_left, at_right, at_top, at_bottom] = cell.letters.clone().unwrap();
        let [right, up] = sight.miss_mm;
        // The side on which the target is drawn most bears an L, in whatever place among its letters.
        let side = match (right.abs() > up.abs(), right > 0.0, up > 0.0) {
            (true, true, _) => at_right,
            (true, false, _) => at_left,
            (false, _, true) => at_top,
            (false, _, false) => at_bottom,
        };
        prop_assert!(side.contains('L') && !side.contains('R'), "{side} {right} {up}");
    }

    /// NaN and worse in every number of every message: a word and never a panic, and no sight of numbers that are none.
    #[test]
    fn no_number_brings_the_screen_down(
        bad in prop::sample::select(vec![f64::NAN, f64::INFINITY, -1e300, 0.0, 1e9]), place in 0_usize..9, view in 0_usize..7
    ) {
        let mut sample = sample();
        let header = sample.headers[view].as_mut().unwrap();
        match place {
            0 => header.plane.origin_mm[1] = bad,
            1 => header.plane.right[0] = bad,
            2 => header.plane.pixel_mm = bad,
            3 => sample.poses[0].t_mm[2] = bad,
            4 => sample.poses[0].q[0] = bad,
            5 => sample.poses[0].covariance.fill(bad),
            6 => sample.poses[0].tip_mm = bad,
            7 => sample.guide.as_mut().unwrap().target_mm[0] = bad,
            _ => sample.guide.as_mut().unwrap().radius_mm = bad,
        }
        let model = sample.model();
        if let Ok(aimed) = &model.sight {
            let numbers = [aimed.sight.to_go_mm, aimed.sight.miss_length_mm];
            prop_assert!(numbers.iter().all(|n| n.is_finite()), "{numbers:?}");
            prop_assert!(aimed.sight.verdict != Verdict::OnTarget);
        }
    }

    /// Clocks that stand still, go back or jump: nothing is live that is older than the limit.
    #[test]
    fn nothing_older_than_the_limit_is_live(now in any::<i64>()) {
        let model = Sample { now_ns: now, ..sample() }.model();
        let age = now.saturating_sub(CAPTURED_NS);
        if model.state.tone == Tone::Live {
            prop_assert!((-100_000_000..=100_000_000).contains(&age), "{age}");
        }
    }
}

/// The sample in a run that moves organs, whose images have the target there.
fn moved(target: TargetShown, by: [f64; 3]) -> Result<Aimed, String> {
    let mut sample = sample();
    sample.scene = organs_move();
    let chosen = sample.guide.as_ref().unwrap().chosen().unwrap().unwrap();
    let chosen = Chosen {
        entry: Some(Point::new(10.0, -5.0, 0.0)),
        ..chosen
    };
    sample.guide = Some(Guide::default().choosing(Some(&chosen), 1));
    let planned = chosen.centre.mm();
    for header in sample.headers.iter_mut().flatten() {
        header.stamp.target = target.code();
        header.stamp.target_mm = planned;
        header.stamp.target_shown_mm = std::array::from_fn(|a| planned[a] + by[a]);
    }
    sample.model().sight
}

fn organs_move() -> Scene {
    Scene::parse(
        "[tissue]\norgans = \"kidney.toml\"\nlate_ms = 30",
        std::path::Path::new(""),
    )
    .unwrap()
}

#[test]
fn the_sight_aims_where_the_image_beside_it_has_the_target_and_says_whose_place_that_is() {
    let planned = sample().model().sight.unwrap();
    assert_eq!(planned.whereabouts, TargetShown::Planned);
    let axis = (pose([0.3, 0.9, 0.1], [10.0, -5.0, 70.0]) * Direction::<Tool>::Z).vector();
    let back = |mm: f64| axis.mm().map(|x| -mm * x);
    let aimed = moved(TargetShown::Model, back(12.0)).unwrap();
    assert!((aimed.sight.to_go_mm - 18.0).abs() < 1e-9, "{aimed:?}");
    // The planned way does not lead there, and nothing is said of it.
    assert!(aimed.sight.line.is_none());
    assert!(moved(TargetShown::Beside, [0.0; 3]).unwrap().sight.line.is_some());
    // Arrived by the pose's own error: only where the target's place is as well known as the plan's.
    for (target, verdict) in [
        (TargetShown::Model, Verdict::ErrorUnknown),
        (TargetShown::NotSettled, Verdict::ErrorUnknown),
        (TargetShown::AtRest, Verdict::ErrorUnknown),
        (TargetShown::Beside, Verdict::OnTarget),
    ] {
        let aimed = moved(target, back(30.0)).unwrap();
        assert_eq!((aimed.whereabouts, aimed.sight.verdict), (target, verdict));
    }
    assert!(moved(TargetShown::Model, [f64::NAN, 0.0, 0.0]).is_err());
    // Images that say nothing of it, in a run that moves organs.
    for silent in [TargetShown::None, TargetShown::Planned] {
        assert!(moved(silent, [0.0; 3]).is_err(), "{silent:?}");
    }
    // A target that was chosen after the image was drawn.
    let mut other = sample();
    other.scene = organs_move();
    for header in other.headers.iter_mut().flatten() {
        header.stamp.target = TargetShown::Model.code();
        header.stamp.target_mm = [1.0; 3];
    }
    assert!(other.model().sight.unwrap_err().contains("this target yet"));
}

#[test]
fn the_force_on_the_tube_is_that_of_the_image_shown_and_a_state_that_is_not_settled_has_none() {
    let said = |shown: TissueShown, force_n: f64, force_95_n: f64| {
        let mut sample = sample();
        sample.scene = organs_move();
        for header in sample.headers.iter_mut().flatten() {
            header.stamp.tissue = shown.code();
            (header.stamp.force_n, header.stamp.force_95_n) = (force_n, force_95_n);
        }
        let organs = sample.model().organs.unwrap();
        (organs.word, organs.tone, organs.force)
    };
    let quiet = |force: &str| ("MODEL", Tone::Quiet, force.to_owned());
    assert_eq!(
        said(TissueShown::Settled, 0.524, 0.301),
        quiet("0.52 N \u{b1}0.30 (95 %)")
    );
    assert_eq!(
        said(TissueShown::Settled, 0.524, -1.0),
        quiet("0.52 N \u{b1}UNKNOWN (95 %)")
    );
    for none in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(said(TissueShown::Settled, none, 0.3), quiet(""));
    }
    for (shown, word) in [
        (TissueShown::Approximate, "MODEL NOT SETTLED"),
        (TissueShown::Late, "TISSUE LATE"),
        (TissueShown::Refused, "TISSUE REFUSED"),
        (TissueShown::Rigid, "ORGANS AT REST"),
        (TissueShown::None, "ORGANS NOT KNOWN"),
    ] {
        assert_eq!(said(shown, 0.524, 0.301), (word, Tone::Warning, String::new()));
    }
    assert_eq!(sample().model().organs, None);
    // The image of a pose that has grown old says nothing of the force now.
    let mut old = sample();
    old.scene = organs_move();
    for header in old.headers.iter_mut().flatten() {
        header.stamp.tissue = TissueShown::Settled.code();
        (header.stamp.force_n, header.stamp.force_95_n) = (0.5, 0.3);
        header.stamp.t_capture_ns -= 60_000_000_000;
    }
    let old = old.model().organs.unwrap();
    assert_eq!(
        (old.word, old.tone, &*old.force),
        ("ORGANS NOT KNOWN", Tone::Warning, "")
    );
}
