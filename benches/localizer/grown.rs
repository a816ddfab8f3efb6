//! A peer that goes away over and over: what the processes of the run hold after it.

use std::time::Duration;

use crate::pulled::{Run, Turns, Way};
use crate::support::cable::Cable;
use crate::{resources, spread};

/// As short as a connection may last, and some more.
const TURNS: Turns = Turns {
    away: Duration::from_millis(1700),
    flow: Duration::from_millis(100),
    silent_s: 1.5,
    counts_stale: false,
};
/// What is counted from on: what is set up once has been by then.
const FIRST: u64 = 20;
const SECOND: u64 = 200;
/// Memory that may come on top, KiB: a heap is handed out in steps of 128, and a log line of each cycle is not kept.
const MOST_GROWN_KIB: u64 = 1024;

/// Stops the peer and pulls its cable (where that may be done) in turn, and prints what each process holds.
pub(crate) fn measure(cycles: u64) {
    let cable = Cable::new();
    let mut run = Run::start(cable.as_ref(), TURNS);
    let (mut counts, mut back) = (Vec::new(), Vec::new());
    for cycle in 1..=cycles {
        let way = match cable.is_some() && cycle % 2 == 0 {
            true => Way::Pulled,
            false => Way::Stopped,
        };
        back.push(run.cycle(way).back_ns);
        if [FIRST, SECOND, cycles].contains(&cycle) {
            let held = held(&run);
            println!("after {cycle} cycles: live again {}; {held:?}", spread(back.clone()));
            counts.push((cycle, held));
        }
    }
    let Some((_, names)) = counts.first().cloned() else {
        return;
    };
    for (process, (name, _)) in names.iter().enumerate() {
        let of: Vec<String> = counts
            .iter()
            .map(|(cycle, held)| format!("{cycle}: {} descriptors, {} KiB", held[process].1.0, held[process].1.1))
            .collect();
        println!("{name}: {}", of.join("; "));
        let [first, last] = [&counts[0], &counts[counts.len() - 1]].map(|(_, held)| held[process].1);
        assert_eq!(first.0, last.0, "{name}: descriptors");
        assert!(
            last.1 <= first.1 + MOST_GROWN_KIB,
            "{name}: {} KiB, then {}",
            first.1,
            last.1
        );
    }
}

/// Each process with its descriptors and KiB.
fn held(run: &Run<'_>) -> Vec<(String, (usize, u64))> {
    let status = run.pilot.status().unwrap();
    let processes = status["processes"].as_array().unwrap();
    processes
        .iter()
        .filter_map(|process| {
            let name = process["name"].as_str()?.to_owned();
            Some((name, resources(process["pid"].as_u64()?)))
        })
        .collect()
}
