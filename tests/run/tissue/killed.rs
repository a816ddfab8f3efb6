//! kill -9 of the model, many times: no image of any view has tissue that is not of its pose.
//!
//! Takes a quarter of a minute a kill: `TROCAR_KILLS=100 cargo test --release --test run -- --ignored --nocapture a_model_that_is_killed_many_times`.

use std::time::Duration;

use bus::clock::monotonic_ns;
use bus::message::TissueShown;

use super::watch::Watch;
use super::{alone, pushed, scene};
use crate::support::{World, kill_9, pid_in, report};

fn kills() -> usize {
    std::env::var("TROCAR_KILLS").map_or(20, |count| count.parse().unwrap())
}

#[test]
#[ignore = "a quarter of a minute a kill"]
fn a_model_that_is_killed_many_times_leaves_no_image_unmarked() {
    let _alone = alone();
    let world = World::new();
    let file = scene(&world);
    let text = std::fs::read_to_string(&file).unwrap();
    // In and out again and again: whoever was killed in tissue is refused until the tube has been drawn back.
    let text = text
        .replace("pause_s = 600.0", "pause_s = 0.5")
        .replace("insert_s = 40.0", "insert_s = 6.0")
        .replace(
            "silent_s = 10.0",
            "silent_s = 10.0\nrestarts = 100\nrestart_window_s = 1.0",
        );
    std::fs::write(&file, text).unwrap();
    let pilot = world.start(&file, &world.path("out"), "default");
    let mut status = pilot.wait_live();
    let mut watch = Watch::open(&world);
    let (count, began_ns) = (kills(), monotonic_ns());
    for kill in 0..count {
        // Half of them while the organ presses, the others wherever the tube is.
        match kill % 2 {
            0 => watch.until("an image of a pushed organ", pushed),
            _ => watch.until("an image of a settled state", |stamp, _| {
                stamp.tissue == TissueShown::Settled.code()
            }),
        };
        let victim = pid_in(&status, "tissue").unwrap();
        // At another moment of a frame each time.
        watch.during(Duration::from_millis(7 * (kill as u64 % 9)));
        kill_9(victim);
        let late = watch.until("an image that says that the tissue is late", |stamp, _| {
            stamp.tissue == TissueShown::Late.code()
        });
        assert_eq!(late.tissue_seq, 0);
        status = loop {
            watch.images();
            let Some(status) = pilot.status() else { continue };
            let another = pid_in(&status, "tissue").is_some_and(|pid| pid != victim);
            if another {
                break status;
            }
            assert!(
                monotonic_ns() - began_ns < bus::clock::ns(Duration::from_secs(120 * count as u64)),
                "it does not come back"
            );
        };
    }
    watch.until("an image of a settled state", |stamp, _| {
        stamp.tissue == TissueShown::Settled.code()
    });
    assert!(pilot.stop().code().is_some());
    let report = report(&world.path("out"));
    let restarts = report["restarts"].as_array().unwrap();
    let killed = restarts.iter().filter(|restart| restart["process"] == "tissue").count();
    assert_eq!((killed, restarts.len()), (count, count), "{restarts:?}");
    assert_eq!(report["tissue"]["unmarked"], 0);
    let images: u64 = watch.shown.values().sum();
    println!(
        "{count} kills in {:.0} s, {images} images, none unmarked: {:?}",
        (monotonic_ns() - began_ns) as f64 / 1e9,
        watch.shown
    );
}
