//! A model that lives and is too slow: images say so, and it comes back by itself.

use std::time::Duration;

use bus::message::TissueShown;
use rustix::process::{Pid, Signal, kill_process};

use super::watch::Watch;
use super::{alone, pushed, scene};
use crate::support::{World, pid_in, report};

#[test]
#[ignore = "a development build beside other tests is late without being stopped: run it alone"]
fn a_model_that_stands_still_for_a_second_is_late_on_images_and_goes_on_without_a_restart() {
    let _alone = alone();
    let world = World::new();
    let pilot = world.start(&scene(&world), &world.path("out"), "default");
    let status = pilot.wait_live();
    let mut watch = Watch::open(&world);
    watch.until("an image of a pushed organ", pushed);
    let tissue = pid_in(&status, "tissue").unwrap();
    let pid = Pid::from_raw(i32::try_from(tissue).unwrap()).unwrap();
    let before = watch.came.len();
    kill_process(pid, Signal::STOP).unwrap();
    let stood = watch.during(Duration::from_secs(1));
    kill_process(pid, Signal::CONT).unwrap();
    // Poses come each 50 ms, and a state is late after 150: three views and at least ten poses, on a busy machine some of them.
    let late: Vec<_> = stood
        .iter()
        .filter(|stamp| stamp.tissue == TissueShown::Late.code())
        .collect();
    assert!(late.len() >= 6, "{} of {} images", late.len(), stood.len());
    // None but those that were under way when it stopped had a state.
    let states = watch.came.len() - before;
    assert!(states <= 3, "{states} states of a process that stands still");

    let last = late.iter().map(|stamp| stamp.t_capture_ns).max().unwrap();
    watch.until("an image of the organ, pushed still", |stamp, state| {
        stamp.t_capture_ns > last && pushed(stamp, state)
    });
    // And so it stays: what was late is not late for ever. A busy machine has late images among them.
    let mut settled = 0;
    while settled < 20 {
        let stamp = watch.until("an image", |_, _| true);
        settled += usize::from(stamp.tissue == TissueShown::Settled.code());
    }
    assert_eq!(pilot.pid("tissue"), Some(tissue));
    pilot.stop();
    let report = report(&world.path("out"));
    assert_eq!(report["restarts"], serde_json::json!([]));
    assert_eq!(report["tissue"]["unmarked"], 0);
    println!(
        "{} images stood, {} late; all images by what they show: {:?}",
        stood.len(),
        late.len(),
        watch.shown
    );
}
