//! What happens when parts of a run break: each hazard provoked on real processes, timed until every view is live again.
//!
//! `cargo bench --bench faults -- [COUNT] [load N] [only WORD]`: COUNT times each (20) beside N busy loops (0), as the rows of a
//! table. A time is that from the signal until `pilot status`, asked every 20 ms, says that every view is live and every process ready.

#![allow(clippy::print_stdout, reason = "the table is what this program is for")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]
#![allow(clippy::disallowed_methods, reason = "durations for people, which never reach a bus")]

#[path = "../tests/support/load.rs"]
mod load;
#[path = "../tests/support/mod.rs"]
mod support;

use std::time::{Duration, Instant};

use load::Load;
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use support::{Pilot, SMALL, World, all_live, is_alive, pid_in};

/// Who is hit, by the names of processes; views by their kind.
enum Hit {
    /// Each with its signal.
    Named(&'static [&'static str], Signal),
    /// So many at random, from the first number to the second.
    Any(usize, usize),
    /// Every child of the pilot.
    All,
    /// The loader of a CT of 250 MB, and this one while the next loader reads it.
    WhileLoading(&'static str),
    /// The pilot; another one is started.
    Pilot,
}

/// A hazard, and what a person sees of it.
struct Hazard {
    name: &'static str,
    hit: Hit,
    seen: &'static str,
}

const VIEW: &str = "view-perpendicular";

const HAZARDS: [Hazard; 11] = [
    Hazard {
        name: "a renderer dies",
        hit: Hit::Named(&[VIEW], Signal::KILL),
        seen: "its image ages, then has no pose; the other views go on",
    },
    Hazard {
        name: "a renderer stands still (SIGSTOP)",
        hit: Hit::Named(&[VIEW], Signal::STOP),
        seen: "the same; it is shot after `silent_s` (2 s here)",
    },
    Hazard {
        name: "the tracker dies",
        hit: Hit::Named(&["tracker"], Signal::KILL),
        seen: "every image ages; NO POSE: tracker silent after `lost_ms`",
    },
    Hazard {
        name: "the loader dies",
        hit: Hit::Named(&["volume-loader"], Signal::KILL),
        seen: "nothing: voxels stay mapped",
    },
    Hazard {
        name: "the recorder dies",
        hit: Hit::Named(&["recorder"], Signal::KILL),
        seen: "nothing on images; the file goes on as another part, what is lost is in `problems`",
    },
    Hazard {
        name: "loader and renderer die",
        hit: Hit::Named(&["volume-loader", VIEW], Signal::KILL),
        seen: "its image ages, then has no pose; the other views go on",
    },
    Hazard {
        name: "a renderer dies while a killed loader reads 250 MB again (until its view is live)",
        hit: Hit::WhileLoading(VIEW),
        seen: "its image ages, then has no pose; it goes on with the voxels that others hold",
    },
    Hazard {
        name: "the tracker dies while a killed loader reads 250 MB again (until every view is live)",
        hit: Hit::WhileLoading("tracker"),
        seen: "every image ages",
    },
    Hazard {
        name: "two to five processes die at once",
        hit: Hit::Any(2, 5),
        seen: "as for each of them",
    },
    Hazard {
        name: "all processes but the pilot die at once",
        hit: Hit::All,
        seen: "every image ages, then has no pose",
    },
    Hazard {
        name: "the pilot dies, and the run is started again",
        hit: Hit::Pilot,
        seen: "images stand and name their age; every process ends by itself; the next start cleans up",
    },
];

/// The small scene with the limits of a real one.
fn scene() -> String {
    let changed = [
        ("silent_s = 30.0", "silent_s = 2.0"),
        ("stale_ms = 1000.0", "stale_ms = 200.0"),
        ("restart_window_s = 3600.0", "restart_window_s = 1.0\nrestarts = 100"),
    ];
    changed.iter().fold(SMALL.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// A generator of its own, so that a table can be made again.
struct Random(u64);

impl Random {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % most
    }
}

fn signal(pid: u64, signal: Signal) {
    // One that has ended by itself meanwhile is no failure.
    let _ = kill_process(Pid::from_raw(i32::try_from(pid).unwrap()).unwrap(), signal);
}

fn names(status: &Value) -> Vec<String> {
    let processes = status["processes"].as_array().unwrap();
    processes
        .iter()
        .filter_map(|p| Some(p["name"].as_str()?.to_owned()))
        .collect()
}

fn victims(hit: &Hit, status: &Value, random: &mut Random) -> Vec<(u64, Signal)> {
    let mut names = names(status);
    let with = match hit {
        Hit::Named(asked, with) => {
            names.retain(|name| asked.contains(&name.as_str()));
            assert_eq!(names.len(), asked.len(), "{asked:?}");
            *with
        }
        Hit::Any(least, most) => {
            let count = (least + random.below(most - least + 1)).min(names.len());
            while names.len() > count {
                names.swap_remove(random.below(names.len()));
            }
            Signal::KILL
        }
        Hit::All => Signal::KILL,
        Hit::WhileLoading(_) | Hit::Pilot => return Vec::new(),
    };
    names
        .iter()
        .filter_map(|name| Some((pid_in(status, name)?, with)))
        .collect()
}

fn is_back(status: &Value, before: &[u64]) -> bool {
    let ready = |p: &Value| p["stage"] == "ready" && p["pid"].as_u64().is_some_and(|pid| !before.contains(&pid));
    all_live(status) && status["processes"].as_array().unwrap().iter().all(ready)
}

/// Hits once; seconds until the run is back.
fn hit(pilot: &Pilot<'_>, hit: &Hit, random: &mut Random) -> f64 {
    let status = pilot.wait_for("every process ready", |status| is_back(status, &[]));
    let victims = victims(hit, &status, random);
    let began = Instant::now();
    for (pid, with) in &victims {
        signal(*pid, *with);
    }
    let pids: Vec<u64> = victims.iter().map(|v| v.0).collect();
    pilot.wait_for("the run to be back", |status| is_back(status, &pids));
    began.elapsed().as_secs_f64()
}

/// Kills the loader, and `process` as soon as another loader reads; seconds until that is back and every view live.
fn hit_while_loading(pilot: &Pilot<'_>, process: &str) -> f64 {
    const LOADER: &str = "volume-loader";
    let status = pilot.wait_for("every process ready", |status| is_back(status, &[]));
    let victims = [LOADER, process].map(|name| pid_in(&status, name).unwrap());
    let reads = |status: &Value| {
        let is_it =
            |p: &Value| p["name"] == LOADER && p["note"].as_str().is_some_and(|note| note.starts_with("reading"));
        status["processes"].as_array().unwrap().iter().any(is_it)
    };
    signal(victims[0], Signal::KILL);
    pilot.wait_for("another loader to read", reads);
    let began = Instant::now();
    signal(victims[1], Signal::KILL);
    // What the dead one drew may still be young.
    let status = pilot.wait_for("the views", |status| {
        let is_another = |p: &Value| p["name"] == process && p["stage"] == "ready" && p["pid"] != victims[1];
        status["processes"].as_array().unwrap().iter().any(is_another) && all_live(status)
    });
    assert!(reads(&status), "the loader was done before the views were back");
    began.elapsed().as_secs_f64()
}

/// Kills the pilot; seconds until every child has ended and a new pilot has every view live.
fn pilot_killed(world: &World, name: &str) -> f64 {
    let (scene, out) = (world.file("s.toml", &scene()), world.path(name));
    let pilot = world.start(&scene, &out, "faults");
    let status = pilot.wait_live();
    let children: Vec<u64> = names(&status).iter().filter_map(|name| pid_in(&status, name)).collect();
    let began = Instant::now();
    drop(pilot);
    while children.iter().any(|pid| is_alive(*pid)) {
        assert!(
            began.elapsed() < Duration::from_secs(60),
            "a process outlives its pilot"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    let next = world.start(&scene, &world.path(&format!("{name}-next")), "faults");
    next.wait_live();
    let took = began.elapsed().as_secs_f64();
    next.stop();
    took
}

/// Provokes a hazard some times; the times, and what the report says of it.
fn provoked(hazard: &Hazard, count: usize) -> (Vec<f64>, String) {
    let (world, mut random) = (World::new(), Random(12_345));
    if matches!(hazard.hit, Hit::Pilot) {
        let took = (0..count).map(|i| pilot_killed(&world, &format!("out{i}"))).collect();
        return (took, "no process outlives it".to_owned());
    }
    let scene = match hazard.hit {
        // 125 million voxels.
        Hit::WhileLoading(_) => scene().replace("spacing_mm = 6.0", "spacing_mm = 0.63"),
        _ => scene(),
    };
    let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "faults");
    pilot.wait_live();
    let once = |_| match hazard.hit {
        Hit::WhileLoading(process) => hit_while_loading(&pilot, process),
        _ => hit(&pilot, &hazard.hit, &mut random),
    };
    let took = (0..count).map(once).collect();
    let code = pilot.stop().code();
    let report = support::report(&world.path("out"));
    let unmarked: u64 = report["views"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|v| v["unflagged_old"].as_u64())
        .sum();
    let told = report["problems"].as_array().map_or(0, Vec::len);
    let code = code.map_or("none".to_owned(), |code| code.to_string());
    (
        took,
        format!("{unmarked} unmarked old images, exit code {code}, {told} problems"),
    )
}

fn main() {
    let (words, count, load) = load::asked();
    let after = |name: &str| words.iter().position(|w| w == name).and_then(|i| words.get(i + 1));
    let (count, load) = (count.unwrap_or(20.0) as usize, load.unwrap_or(0));
    let _load = Load::new(load);
    println!(
        "| hazard, {count} times, beside {load} busy loops | median | 95 of 100 | most | report | what a person sees |"
    );
    println!("|---|---|---|---|---|---|");
    for hazard in HAZARDS
        .iter()
        .filter(|h| after("only").is_none_or(|word| h.name.contains(word)))
    {
        let (mut took, report) = provoked(hazard, count);
        took.sort_by(f64::total_cmp);
        let at = |share: f64| took[((took.len() as f64 * share).ceil() as usize).clamp(1, took.len()) - 1];
        println!(
            "| {} | {:.2} s | {:.2} s | {:.2} s | {report} | {} |",
            hazard.name,
            at(0.5),
            at(0.95),
            took[took.len() - 1],
            hazard.seen
        );
    }
}
