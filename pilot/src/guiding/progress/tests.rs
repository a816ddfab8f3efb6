use super::*;
use geometry::Rigid;
use guidance::workflow::{Check, Identity};

const HASH: VolumeHash = VolumeHash([7; 32]);
const LOST_NS: i64 = 1_000_000_000;

fn progress(strict: bool) -> Progress {
    Progress::new(Rules::new(strict, 2.0, 1_000_000_000).unwrap(), LOST_NS)
}

fn sample(registration_id: u64, t_capture_ns: i64) -> ToolPose {
    ToolPose {
        registration_id,
        t_capture_ns,
        ..ToolPose::EMPTY
    }
}

fn valid(progress: &mut Progress, registration_id: u64, t_ns: i64) {
    progress.pose(&sample(registration_id, t_ns), &Tracked::Valid(Rigid::identity()));
}

fn lost(progress: &mut Progress, reason: Lost) {
    progress.pose(&sample(0, 0), &Tracked::Lost(reason));
}

#[test]
fn a_research_run_navigates_with_its_first_pose() {
    let mut progress = progress(false);
    // Before the examination is there a pose means nothing.
    valid(&mut progress, 1, 0);
    assert_eq!(progress.state().stage(), Stage::Empty);
    progress.volume(HASH);
    lost(&mut progress, Lost::NotSeen);
    assert_eq!(progress.state().stage(), Stage::Loaded);
    valid(&mut progress, 1, 0);
    assert_eq!(progress.state().stage(), Stage::Navigating);
    assert!(progress.state().is_research() && progress.state().shows_sight());
    let stages = [
        "stage LOADED",
        "stage CALIBRATED",
        "stage REGISTERED",
        "stage NAVIGATING",
    ];
    assert_eq!(progress.take_said(), stages);
    // The same again says nothing.
    valid(&mut progress, 1, 1);
    progress.turn(2);
    assert!(progress.take_said().is_empty());
}

#[test]
fn what_the_tracker_lacks_takes_the_run_back() {
    let mut progress = progress(false);
    progress.volume(HASH);
    lost(&mut progress, Lost::NotCalibrated);
    assert_eq!(progress.state().stage(), Stage::Loaded);
    lost(&mut progress, Lost::NotRegistered);
    assert_eq!(progress.state().stage(), Stage::Calibrated);
    valid(&mut progress, 1, 0);
    assert_eq!(progress.state().stage(), Stage::Navigating);
    lost(&mut progress, Lost::NotRegistered);
    assert_eq!(progress.state().stage(), Stage::Calibrated);
    valid(&mut progress, 1, 0);
    lost(&mut progress, Lost::NotCalibrated);
    assert_eq!(progress.state().stage(), Stage::Loaded);
    assert!(!progress.state().tool_is_seen());
}

#[test]
fn a_tool_is_lost_at_once_by_its_sample_and_by_age_after_the_scenes_limit() {
    let mut progress = progress(false);
    progress.volume(HASH);
    for reason in [Lost::NotSeen, Lost::Refused, Lost::Frozen, Lost::Reference] {
        valid(&mut progress, 1, 0);
        assert!(progress.state().shows_sight());
        lost(&mut progress, reason);
        assert!(!progress.state().shows_sight(), "{reason:?}");
        assert_eq!(progress.state().stage(), Stage::Navigating);
    }
    valid(&mut progress, 1, 5);
    progress.turn(5 + LOST_NS);
    assert!(progress.state().tool_is_seen());
    progress.turn(6 + LOST_NS);
    assert!(!progress.state().tool_is_seen());
    valid(&mut progress, 1, i64::MAX);
    progress.turn(i64::MIN);
    assert!(progress.state().tool_is_seen());
}

#[test]
fn a_navigation_that_a_person_ended_does_not_start_by_itself() {
    let mut progress = progress(false);
    assert!(progress.rest().is_err());
    progress.volume(HASH);
    valid(&mut progress, 1, 0);
    progress.rest().unwrap();
    valid(&mut progress, 1, 1);
    progress.turn(2);
    assert_eq!(progress.state().stage(), Stage::Registered);
    // Nor with another registration.
    valid(&mut progress, 2, 3);
    assert_eq!(progress.state().stage(), Stage::Registered);
    progress.navigate(0).unwrap();
    assert_eq!(progress.state().stage(), Stage::Navigating);
    lost(&mut progress, Lost::NotRegistered);
    valid(&mut progress, 2, 4);
    assert_eq!(progress.state().stage(), Stage::Navigating);
}

#[test]
fn a_strict_run_waits_for_a_person() {
    let mut progress = progress(true);
    assert!(progress.confirm(&HASH.to_string()).is_err());
    assert!(progress.reject().is_err());
    progress.volume(HASH);
    valid(&mut progress, 1, 0);
    assert_eq!(progress.state().stage(), Stage::Loaded);
    let said = progress.navigate(0).unwrap_err();
    assert_eq!(said, "the run is LOADED: nobody has confirmed whose the examination is");
    for bad in ["", "07", "yes"] {
        assert!(progress.confirm(bad).unwrap_err().contains("64 hexadecimal digits"));
    }
    progress.confirm(&HASH.to_string()).unwrap();
    valid(&mut progress, 1, 1);
    assert_eq!(progress.state().stage(), Stage::Registered);
    // Nothing was touched to check the registration.
    assert!(progress.navigate(0).is_err());
    valid(&mut progress, 1, 2);
    assert_eq!(
        (progress.state().stage(), progress.state().check()),
        (Stage::Registered, Check::NotMade)
    );
}

#[test]
fn another_examination_is_not_confirmed_and_the_runs_counts_as_not_confirmed() {
    let mut progress = progress(true);
    progress.volume(HASH);
    progress.confirm(&HASH.to_string()).unwrap();
    let other = VolumeHash([8; 32]).to_string();
    let said = progress.confirm(&other).unwrap_err();
    assert!(said.contains(&other) && said.contains(&HASH.to_string()), "{said}");
    assert_eq!(
        (progress.state().stage(), progress.state().identity()),
        (Stage::Loaded, Identity::NotAsked)
    );
}

#[test]
fn a_rejected_examination_needs_a_person_also_in_research() {
    let mut progress = progress(false);
    progress.volume(HASH);
    valid(&mut progress, 1, 0);
    progress.reject().unwrap();
    valid(&mut progress, 1, 1);
    progress.turn(2);
    assert_eq!(progress.state().stage(), Stage::Loaded);
    assert!(progress.navigate(0).is_err());
    progress.confirm(&HASH.to_string()).unwrap();
    valid(&mut progress, 1, 3);
    assert_eq!(progress.state().stage(), Stage::Navigating);
}

/// A strict run that is registered under registration 1, as of `t_ns`.
fn registered(t_ns: i64) -> Progress {
    let mut progress = progress(true);
    progress.volume(HASH);
    progress.confirm(&HASH.to_string()).unwrap();
    valid(&mut progress, 1, t_ns);
    assert_eq!(progress.state().stage(), Stage::Registered);
    progress
}

#[test]
fn a_check_leads_on_and_holds_for_its_time() {
    let mut progress = registered(0);
    let said = progress
        .check(&Command::checked(1.5, 3, 400_000_000, 1), 500_000_000)
        .unwrap();
    assert_eq!(said, "check passed: 3 points, the worst 1.50 mm off");
    assert_eq!(progress.state().stage(), Stage::Checked);
    assert!(progress.navigate(600_000_000).is_ok());
    let checked = progress.checked().unwrap();
    assert_eq!((checked.worst_mm, checked.points, checked.t_ns), (1.5, 3, 400_000_000));
    // A second after the first point was touched it is too old.
    valid(&mut progress, 1, 1_300_000_000);
    progress.turn(1_400_000_000);
    assert_eq!(progress.state().stage(), Stage::Navigating);
    progress.turn(1_400_000_001);
    assert_eq!(progress.state().stage(), Stage::Registered);
    assert!(progress.navigate(1_500_000_000).unwrap_err().contains("not checked"));
}

#[test]
fn a_check_that_fails_by_its_distance_or_by_its_words_keeps_from_navigating() {
    for (worst_mm, fails) in [(2.1, ""), (0.9, "five: 0.90 mm off, 0.40 mm hold 95 % of errors")] {
        let mut progress = registered(0);
        let command = Command::checked(worst_mm, 1, 100, 1).because(fails);
        let said = progress.check(&command, 200).unwrap();
        assert!(
            said.starts_with("check FAILED: 1 points") && said.contains(fails),
            "{said}"
        );
        assert!(
            progress
                .navigate(300)
                .unwrap_err()
                .contains("the check of the registration failed")
        );
        let report = progress.report().unwrap();
        assert_eq!((report.passed, report.warning.as_deref().unwrap_or("")), (false, fails));
        // Another registration has no check, good or bad.
        valid(&mut progress, 2, 400);
        assert_eq!(progress.checked(), None);
        assert!(
            progress
                .navigate(500)
                .unwrap_err()
                .contains("the registration was not checked")
        );
    }
}

#[test]
fn a_check_of_another_registration_or_of_no_distance_is_refused() {
    let mut progress = registered(0);
    let other = progress.check(&Command::checked(0.5, 3, 100, 2), 200).unwrap_err();
    assert!(other.contains("not the one in use"), "{other}");
    for worst_mm in [f64::NAN, -0.1, f64::INFINITY] {
        assert!(progress.check(&Command::checked(worst_mm, 3, 100, 1), 200).is_err());
    }
    let future = Command::checked(0.5, 3, 100_000_000, 1);
    assert!(progress.check(&future, 200).unwrap_err().contains("from the future"));
    assert_eq!(
        (progress.state().stage(), progress.checked()),
        (Stage::Registered, None)
    );
}

#[test]
fn a_marker_that_was_moved_has_to_be_checked() {
    let mut progress = registered(0);
    progress.check(&Command::checked(0.5, 3, 100, 1), 200).unwrap();
    progress.navigate(300).unwrap();
    progress.bumped(350).unwrap();
    assert_eq!(
        (progress.state().stage(), progress.checked()),
        (Stage::Registered, None)
    );
    assert!(
        progress
            .navigate(400)
            .unwrap_err()
            .contains("the marker on the patient was pushed")
    );
    // The same registration again clears no doubt.
    valid(&mut progress, 1, 500);
    assert!(progress.navigate(600).is_err());
    // Nor does a check with a point that was touched before: two such points and one touched since let a run navigate 27 mm off.
    let old = progress.check(&Command::checked(0.5, 3, 349, 1), 800).unwrap_err();
    assert!(old.contains("touch all of them again"), "{old}");
    assert!(progress.navigate(600).is_err());
    progress.check(&Command::checked(0.5, 3, 700, 1), 800).unwrap();
    assert!(progress.navigate(900).is_ok());
    assert_eq!(progress.bumps(), 1);
}
