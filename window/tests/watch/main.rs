//! The watcher on a real X server, beside a window that hangs, dies, lies or is covered.
//!
//! This program plays all parts: it starts itself again as the window and as the watcher. Where there is no Xvfb the tests say so and
//! are skipped.

#![allow(
    clippy::disallowed_methods,
    reason = "tests start real processes and time their own patience"
)]
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "part of the tests, where both are allowed"
)]

mod figures;
mod painter;
mod stage;

use rustix::process::Signal;
use stage::{Stage, stage};

/// What this process is when a stage has started it; as one of the tests it is nothing and ends at once.
#[test]
fn a_part_on_the_stage() {
    match std::env::var(stage::PART).as_deref() {
        Ok("window") => painter::paint(),
        Ok("watcher") => stage::watch(),
        _ => {}
    }
}

/// Good, then covered for that reason, then, where it can live again, good.
fn is_covered_and_uncovered(stage: &mut Stage, harm: impl Fn(&mut Stage), fault: &str, mend: impl Fn(&mut Stage)) {
    stage.wait_for_note("is what it says");
    stage.wait_red(false);
    harm(stage);
    stage.wait_for_note(fault);
    stage.wait_red(true);
    mend(stage);
    stage.wait_for_note("is what it says");
    stage.wait_red(false);
}

#[test]
fn a_window_that_stops_painting_is_covered() {
    let Some(mut stage) = stage() else { return };
    let (harm, mend) = (
        |stage: &mut Stage| stage.order("freeze"),
        |stage: &mut Stage| stage.order("paint"),
    );
    is_covered_and_uncovered(&mut stage, harm, "standing", mend);
}

#[test]
fn a_window_that_is_stopped_is_covered_and_a_cover_is_raised_again() {
    let Some(mut stage) = stage() else { return };
    let harm = |stage: &mut Stage| {
        stage.signal(Signal::STOP);
        stage.wait_red(true);
        // Somebody puts something over the cover and away again: the cover comes up above it.
        let _others = stage.overlap([400, 300, 200, 100]);
        stage.wait_no_blue_at([450, 350]);
    };
    is_covered_and_uncovered(&mut stage, harm, "standing", |stage| stage.signal(Signal::CONT));
}

#[test]
fn a_window_that_is_killed_stays_covered_until_there_is_another() {
    let Some(mut stage) = stage() else { return };
    let harm = |stage: &mut Stage| stage.signal(Signal::KILL);
    is_covered_and_uncovered(&mut stage, harm, "no-window", Stage::start_window);
}

#[test]
fn a_lively_window_with_an_old_pose_is_covered() {
    let Some(mut stage) = stage() else { return };
    let (harm, mend) = (
        |stage: &mut Stage| stage.order("age"),
        |stage: &mut Stage| stage.order("paint"),
    );
    is_covered_and_uncovered(&mut stage, harm, "old", mend);
}

#[test]
fn another_window_over_the_cell_is_told_and_red_all_round_it() {
    let Some(mut stage) = stage() else { return };
    stage.wait_for_note("is what it says");
    let other = stage.overlap([0, 0, 200, 150]);
    stage.wait_for_note("unread");
    stage.wait_red(true);
    stage.remove(other);
    stage.wait_for_note("is what it says");
    stage.wait_red(false);
}

#[test]
fn two_pictures_shown_in_turn_and_another_runs_cell_do_not_pass() {
    let Some(mut stage) = stage() else { return };
    let mend = |stage: &mut Stage| stage.order("paint");
    is_covered_and_uncovered(&mut stage, |stage| stage.order("alternate"), "standing", mend);
    is_covered_and_uncovered(&mut stage, |stage| stage.order("foreign"), "unread", mend);
    is_covered_and_uncovered(&mut stage, |stage| stage.order("hide"), "no-window", mend);
}

/// What the window hears of its watcher: the time of a reading stands still while the cell cannot be read.
#[test]
fn the_watcher_says_when_it_read_a_picture_last() {
    let Some(mut stage) = stage() else { return };
    stage.wait_for_note("is what it says");
    let first = stage.wait_for_reading(0);
    let second = stage.wait_for_reading(first);
    stage.order("foreign");
    stage.wait_for_note("unread");
    let last = stage.heard().unwrap().t_painted_ns;
    assert!(last >= second);
    // Ten looks later it is the same.
    std::thread::sleep(std::time::Duration::from_millis(500));
    assert_eq!(stage.heard().unwrap().t_painted_ns, last);
    stage.order("paint");
    stage.wait_for_reading(last);
}

#[test]
fn a_window_that_ends_as_it_was_asked_is_not_missed() {
    let Some(mut stage) = stage() else { return };
    stage.wait_for_note("is what it says");
    stage.order("end");
    stage.wait_for_note("closed");
    stage.wait_red(false);
}

#[test]
fn a_display_that_goes_ends_nothing() {
    let Some(mut stage) = stage() else { return };
    stage.wait_for_note("is what it says");
    stage.kill_server();
    stage.wait_for_note("cannot be seen");
    stage.start_server();
    stage.start_window();
    stage.wait_for_note("is what it says");
}

#[test]
fn a_server_that_hangs_does_not_hang_its_watcher() {
    let Some(mut stage) = stage() else { return };
    stage.wait_for_note("is what it says");
    stage.signal_server(Signal::STOP);
    stage.wait_for_note("does not answer");
    stage.signal_server(Signal::CONT);
    stage.wait_for_note("is what it says");
}

/// A monitor that was unplugged when the watcher started: what lay beyond the first one was DISPLAY NOT READABLE ever after.
#[test]
fn a_screen_that_grows_is_read_as_far_as_it_goes() {
    let Some(mut stage) = stage() else { return };
    stage.wait_for_note("is what it says");
    stage.kill_watcher();
    stage.resize_screen([120, 100]);
    stage.start_watcher();
    stage.wait_for_note("unread");
    stage.resize_screen([1280, 800]);
    stage.wait_for_note("is what it says");
    stage.wait_red(false);
}
