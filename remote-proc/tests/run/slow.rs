//! A link of 1 Mbit/s that loses a fifth of its packets: all of the examination comes, and what comes late says so.

use std::process::Command;
use std::time::{Duration, Instant};

use bus::clock::{monotonic_ns, ms};
use bus::message::{Ages, FrameState};

use crate::cable::Cable;
use crate::far::Far;
use crate::rig::{alone, until};

/// Of a scene that says nothing else.
const AGES: Ages = Ages {
    stale_ns: 100_000_000,
    lost_ns: 1_000_000_000,
};

/// 1 Mbit/s towards the receiver, and a fifth of what comes there is dropped. Whether `tc` and `nft` could do so.
fn bad(_: &Cable) -> bool {
    let number = std::process::id();
    let steps = [
        format!("tc qdisc add dev tn{number} root tbf rate 1mbit burst 16kbit latency 200ms"),
        format!("ip netns exec tr{number} nft add table inet t"),
        format!("ip netns exec tr{number} nft add chain inet t i {{ type filter hook input priority 0 ; }}"),
        format!("ip netns exec tr{number} nft add rule inet t i numgen random mod 100 < 20 drop"),
    ];
    let run = |step: &String| {
        let (program, words) = step.split_once(' ').unwrap();
        let status = Command::new(program).args(words.split(' ')).status();
        status.is_ok_and(|status| status.success())
    };
    let done = steps.iter().all(run);
    if !done {
        println!("skipped: no bad links here (tc of iproute2 and nft of nftables, as root)");
    }
    done
}

/// What comes in `seconds` after the examination, of `dims`, is whole; each pose is in its order, and stale where it is.
fn shows_what_comes_with_its_age(dims: [u32; 3], seconds: f64) {
    let _alone = alone();
    let began = Instant::now();
    let Some(far) = Far::open_by(dims, 18_000, bad) else {
        return;
    };
    let Far {
        mut room,
        second,
        receiver,
        ..
    } = far;
    let volume = until("the examination", || {
        room.serve_late_joiners();
        room.pose();
        std::thread::sleep(Duration::from_millis(16));
        second.volumes.poll().unwrap()
    });
    assert_eq!(volume.hash(), room.hash, "{}", receiver.said());
    let volume_s = began.elapsed().as_secs_f64();
    let first = until("a pose", || {
        room.pose();
        std::thread::sleep(Duration::from_millis(16));
        second.poses.newest().unwrap()
    });
    let mut law = until("the law", || second.laws.newest().unwrap());
    let (shown, mut newest) = (Instant::now(), first.seq);
    let (mut ages_ms, mut stale) = (Vec::new(), 0);
    while shown.elapsed().as_secs_f64() < seconds {
        room.pose();
        std::thread::sleep(Duration::from_millis(16));
        while let Some(pose) = second.poses.next().unwrap() {
            assert!(pose.seq > newest, "pose {} came after {newest}", pose.seq);
            newest = pose.seq;
            law = second.laws.newest().unwrap().unwrap_or(law);
            // The truth first: whatever passes between the two looks makes the age shown larger.
            let age_ns = room.bus.clock().now_ns() - pose.t_capture_ns;
            let shown_ns = law.law().unwrap().at(monotonic_ns()) - pose.t_capture_ns;
            assert!(shown_ns >= age_ns, "{age_ns} ns old, and shown as {shown_ns}");
            if age_ns > AGES.stale_ns {
                assert_ne!(AGES.state(shown_ns), FrameState::Live);
                stale += 1;
            }
            ages_ms.push(ms(age_ns));
        }
    }
    assert!(!ages_ms.is_empty(), "{}", receiver.said());
    ages_ms.sort_by(f64::total_cmp);
    let at = |share: f64| ages_ms[(share * (ages_ms.len() - 1) as f64) as usize];
    println!(
        "{} KiB of voxels after {volume_s:.1} s; {} of {} poses came, {:.0} ms old (p50), {:.0} (p90), {:.0} (p99), {stale} stale\n{:?}\n{}",
        dims.iter().product::<u32>() / (1 << 9),
        ages_ms.len(),
        newest - first.seq,
        at(0.5),
        at(0.9),
        at(0.99),
        second.note(),
        receiver.said()
    );
}

#[test]
fn a_slow_and_lossy_link_shows_what_comes_with_its_age() {
    shows_what_comes_with_its_age([32, 32, 32], 6.0);
}

/// `cargo test --test run -- --ignored --nocapture slow`, as root, with `tc` and `nft`.
#[test]
#[ignore = "the same with a MiB of voxels; takes two minutes"]
fn a_slow_and_lossy_link_brings_a_mib_and_shows_what_comes_with_its_age() {
    shows_what_comes_with_its_age([80, 80, 80], 60.0);
}
