//! When frames come.

use super::*;

const LINE: &str =
    "latency_ms = 25\njitter_ms = 50\ndropped = 0.1\nlate = 0.05\nlate_ms = 200\ndrift_ppm = 100\noffset_s = -3";

fn line() -> OperatingRoom {
    approached(&scene(LINE, ""), 5)
}

/// Every frame that comes, straight from the frames.
fn all(room: &OperatingRoom, count: u64) -> Vec<Arrival> {
    let mut all: Vec<Arrival> = (0..count)
        .map(|seq| room.frame(seq))
        .filter(|frame| !frame.dropped)
        .map(|frame| Arrival {
            t_arrival_ns: frame.t_arrival_ns,
            seq: frame.seq,
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn every_frame_that_comes_is_delivered_once_and_in_order() {
    let (room, mut now, mut one, mut got) = (line(), -40_000_000, Vec::new(), Vec::new());
    let end = 20_000_000_000;
    // Windows of 1 to 40 ms, as a process wakes.
    for wake in 0.. {
        let then = (now + 1_000_000 + (wake * 7_919 % 39) * 1_000_000).min(end);
        room.arrivals(now, then, &mut one);
        got.extend_from_slice(&one);
        now = then;
        if now == end {
            break;
        }
    }
    let mut expected = all(&room, 1300);
    expected.retain(|arrival| arrival.t_arrival_ns <= end);
    assert_eq!(got, expected);
    let backwards = got.windows(2).filter(|pair| pair[1].seq < pair[0].seq).count();
    println!("{} frames came, {backwards} of them after a younger one", got.len());
    // Jitter of three frames' length puts many in the wrong order.
    assert!(backwards > got.len() / 10);
}

#[test]
fn the_next_arrival_is_the_first_of_them() {
    let (room, mut all) = (line(), Vec::new());
    room.arrivals(i64::MIN, 3_000_000_000, &mut all);
    let mut after = i64::MIN;
    for arrival in &all {
        assert_eq!(room.next_arrival(after, 3_000_000_000), Some(*arrival));
        after = arrival.t_arrival_ns;
    }
    assert_eq!(room.next_arrival(after, 3_000_000_000), None);
    let nothing = approached(&scene("dropped = 1", ""), 5);
    assert_eq!(nothing.next_arrival(0, 1_000_000_000), None);
}

#[test]
fn delays_drops_and_late_frames_are_as_many_as_stated() {
    let (room, n) = (line(), 20_000_u32);
    let frames: Vec<(i64, bool)> = (0..u64::from(n))
        .map(|seq| {
            let frame = room.frame(seq);
            (frame.t_arrival_ns - frame.t_capture_ns, frame.dropped)
        })
        .collect();
    let share = |count: usize| count as f64 / f64::from(n);
    let dropped = share(frames.iter().filter(|f| f.1).count());
    // A share p of n draws deviates by sqrt(p (1 - p) / n); five of those.
    let five = |p: f64| 5.0 * (p * (1.0 - p) / f64::from(n)).sqrt();
    assert!((dropped - 0.1).abs() < five(0.1), "{dropped}");
    let late: Vec<i64> = frames.iter().map(|f| f.0).filter(|d| *d > 75_000_001).collect();
    assert!((share(late.len()) - 0.05).abs() < five(0.05), "{}", late.len());
    assert!(late.iter().all(|d| (225_000_000..=275_000_001).contains(d)));
    let usual: Vec<f64> = frames.iter().map(|f| f.0 as f64 / 1e6).filter(|d| *d < 76.0).collect();
    assert!(usual.iter().all(|d| (25.0..=75.000_001).contains(d)));
    let mean = usual.iter().sum::<f64>() / usual.len() as f64;
    // Uniform over 50 ms: deviation 50 / sqrt(12).
    assert!(
        (mean - 50.0).abs() < 5.0 * 50.0 / (12.0 * usual.len() as f64).sqrt(),
        "{mean}"
    );
    println!(
        "dropped {dropped:.4}, late {:.4}, mean delay {mean:.2} ms",
        share(late.len())
    );
}

#[test]
fn the_localizers_clock_drifts_from_its_offset() {
    let room = line();
    for seq in [0, 600, 60_000] {
        let frame = room.frame(seq);
        // 100 ppm, 3 s behind; rounded to ns.
        let expected = -3_000_000_000 + frame.t_capture_ns + frame.t_capture_ns / 10_000;
        assert!((frame.t_device_ns - expected).abs() <= 1, "{seq}");
        assert_eq!(frame.t_capture_ns, room.t_capture_ns(seq));
    }
    let plain = approached(&scene("", ""), 5).frame(77);
    assert_eq!(
        (plain.t_device_ns, plain.t_arrival_ns),
        (plain.t_capture_ns, plain.t_capture_ns)
    );
}
