use super::*;
use crate::testing;

const NAVIGATES: Workflow = Workflow {
    flags: Workflow::IMAGES,
    t_ns: 0,
    stage: 0,
    check_t_ns: 0,
    check_worst_mm: 0.0,
    check_points: 0,
    bumps: 0,
};

fn claim(of: &ToolPose, state: FrameState) -> Claim {
    Claim {
        seq: of.seq,
        t_capture_ns: of.t_capture_ns,
        state: Some(state),
    }
}

/// What is said of an image of `shown` that may claim `state`, after `newest` has come, at the time of that.
fn said(workflow: Option<Workflow>, newest: &ToolPose, shown: &ToolPose, state: FrameState) -> Standing {
    let now_ns = newest.t_publish_ns;
    Standing::of(
        workflow.as_ref(),
        Some(newest),
        Some(&claim(shown, state)),
        Some(shown),
        now_ns,
    )
}

#[test]
fn the_pose_is_the_one_that_the_newest_image_shows() {
    let (shown, newest) = (testing::pose(100), testing::pose(102));
    let Ok(Tracked::Valid(place)) = shown.tracked() else {
        panic!()
    };
    assert_eq!(
        said(Some(NAVIGATES), &newest, &shown, FrameState::Live),
        Standing::Live(100, place)
    );
    assert_eq!(
        said(Some(NAVIGATES), &newest, &shown, FrameState::Stale),
        Standing::Old(100, place)
    );
    let lost = said(Some(NAVIGATES), &newest, &shown, FrameState::Lost(Lost::Silent));
    assert_eq!(lost, Standing::Lost(Lost::Silent.words().to_owned()));
    let unknown = Standing::of(
        Some(&NAVIGATES),
        Some(&newest),
        Some(&claim(&shown, FrameState::Live)),
        None,
        0,
    );
    assert!(
        !unknown.has_pose() && unknown.words().starts_with("NO POSE"),
        "{unknown:?}"
    );
    let none = Standing::of(Some(&NAVIGATES), Some(&newest), None, None, 0);
    assert_eq!(none, Standing::NoImage);
}

/// Images know nothing of the workflow: they go on behind a marker that was pushed, and the tool was drawn by them.
#[test]
fn nothing_is_drawn_of_the_tool_as_long_as_the_workflow_withholds_it() {
    let pose = testing::pose(100);
    for (flags, why) in [
        (Workflow::REJECTED, "not to be the patient's"),
        (Workflow::BUMPED, "was pushed"),
        (Workflow::CHECK_FAILED, "check of the registration failed"),
        (0, "not ready"),
    ] {
        let standing = said(Some(Workflow { flags, ..NAVIGATES }), &pose, &pose, FrameState::Live);
        assert!(!standing.has_pose() && standing.words().contains(why), "{standing:?}");
    }
    assert!(!said(None, &pose, &pose, FrameState::Live).has_pose());
    assert!(said(Some(NAVIGATES), &pose, &pose, FrameState::Live).has_pose());
}

/// A view that is slow hands over an image of a pose of before the loss, behind the other views' images that say so.
#[test]
fn a_sample_that_is_lost_takes_away_what_a_slow_image_claims() {
    let shown = testing::pose(100);
    for reason in Lost::ALL {
        let mut newest = testing::pose(101);
        newest.set(Tracked::Lost(reason));
        let standing = said(Some(NAVIGATES), &newest, &shown, FrameState::Live);
        assert_eq!(standing, Standing::Lost(reason.words().to_owned()));
    }
}

#[test]
fn numbers_that_are_no_pose_and_a_pose_of_the_future_draw_nothing() {
    let shown = testing::pose(100);
    let mut nan = testing::pose(101);
    nan.t_mm[1] = f64::NAN;
    let mut bent = testing::pose(101);
    bent.q[0] *= 1.1;
    let mut future = testing::pose(101);
    future.t_capture_ns += 60_000_000_000;
    for bad in [nan, bent, future] {
        assert!(
            !said(Some(NAVIGATES), &bad, &shown, FrameState::Live).has_pose(),
            "{bad:?}"
        );
        assert!(
            !said(Some(NAVIGATES), &shown, &bad, FrameState::Live).has_pose(),
            "{bad:?}"
        );
    }
}
