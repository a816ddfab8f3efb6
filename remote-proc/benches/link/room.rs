//! What a second machine costs the room that navigates, `TROCAR_PROGRAMS=../target/release cargo bench --bench link -- room`.
//!
//! One navigation of the shipped demonstration. Its images are timed from a pose's capture to the finished image, for some seconds alone
//! and for some with guests, in turns, so that a busy machine treats both alike. Guests and their receivers have this machine's
//! processors too, which they would not have from another one: what is found is the most that the room can notice.

use std::path::Path;
use std::time::Duration;

use bus::clock::ms;
use bus::message::FrameStamp;
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::FRAME_STAMP;
use rustix::process::Signal;

use crate::both::{Looking, pilot, programs};
use crate::rig::{Program, Second, free_endpoint, keys, remote_proc, until, world};
use crate::{at, say, sorted};

/// How often alone and with guests.
const TURNS: usize = 4;
const SETTLES: Duration = Duration::from_secs(1);
const MEASURED: Duration = Duration::from_secs(10);
/// What the 99th percentile with guests is to keep within, times that alone.
const MUST: f64 = 1.1;

/// Who is there beside the run.
#[derive(Clone, Copy)]
struct Guests {
    name: &'static str,
    receivers: usize,
    /// They are stopped as soon as they have the examination, and read no more.
    stop: bool,
    /// Tracker and renderers go before all else: `[priorities] real_time` of the scene.
    real_time: bool,
}

const GUESTS: [Guests; 6] = [
    Guests {
        name: "a sender alone",
        receivers: 0,
        stop: false,
        real_time: false,
    },
    Guests {
        name: "1 receiver",
        receivers: 1,
        stop: false,
        real_time: false,
    },
    Guests {
        name: "1 receiver that stops",
        receivers: 1,
        stop: true,
        real_time: false,
    },
    Guests {
        name: "8 receivers",
        receivers: 8,
        stop: false,
        real_time: false,
    },
    Guests {
        name: "1 receiver, real_time",
        receivers: 1,
        stop: false,
        real_time: true,
    },
    Guests {
        name: "8 receivers, real_time",
        receivers: 8,
        stop: false,
        real_time: true,
    },
];

/// The table of all guests whose names hold all of `words`.
pub(crate) fn room(words: &[String]) {
    let Some(programs) = programs() else { return };
    say(&format!(
        "| beside the room | images | alone p50 / p99, ms | with it p50 / p99, ms | p99, times | must {MUST} |\n|---|---|---|---|---|---|"
    ));
    for guests in GUESTS {
        if words.iter().all(|word| guests.name.contains(word.as_str())) {
            measure(guests, &programs);
        }
    }
}

fn measure(guests: Guests, programs: &Path) {
    let world = world();
    let demo = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/demo.toml")).unwrap();
    let priorities = if guests.real_time {
        "\n[priorities]\nreal_time = true\n"
    } else {
        ""
    };
    let scene = world.path().join("s.toml");
    std::fs::write(&scene, demo + priorities).unwrap();
    let run = [
        "run",
        scene.to_str().unwrap(),
        "--run",
        "or",
        "--headless",
        "--out",
        "o",
    ];
    let _room = Program::start(world.path(), "room", pilot(world.path(), programs, &run));
    let near = Looking::at(world.path(), "or");
    near.valid_poses(2, false);
    let keys = keys(world.path(), "127.0.0.1");
    let stamps = Stamps::of(&near);
    let (mut alone, mut beside) = (Vec::new(), Vec::new());
    for turn in 0..TURNS {
        stamps.latencies(&mut alone);
        let company = Company::start((world.path(), &keys, turn), &near, guests);
        stamps.latencies(&mut beside);
        drop(company);
    }
    let (alone, beside) = (sorted(alone), sorted(beside));
    let times = at(&beside, 0.99) / at(&alone, 0.99);
    say(&format!(
        "| {} | {} | {:.2} / {:.2} | {:.2} / {:.2} | {times:.2} | {} |",
        guests.name,
        alone.len() + beside.len(),
        at(&alone, 0.5),
        at(&alone, 0.99),
        at(&beside, 0.5),
        at(&beside, 0.99),
        if times <= MUST { "reached" } else { "NOT REACHED" }
    ));
}

/// The stamps of all images of a run.
struct Stamps(Vec<Subscriber<FrameStamp>>);

impl Stamps {
    fn of(near: &Looking) -> Self {
        let open = |process: String| Subscriber::open(&near.bus, &FRAME_STAMP, &process, FRAME_STAMP.buffer).unwrap();
        Self(
            near.scene
                .renderers()
                .into_iter()
                .map(|(plane, _)| open(plane.process()))
                .collect(),
        )
    }

    /// Adds how long each image of the next seconds took that shows a pose for the first time, ms.
    fn latencies(&self, found: &mut Vec<f64>) {
        std::thread::sleep(SETTLES);
        self.each(|_| {});
        let mut newest = std::collections::HashMap::new();
        let ends = std::time::Instant::now() + MEASURED;
        while std::time::Instant::now() < ends {
            // A second of all views is far from filling a subscriber's buffer.
            std::thread::sleep(Duration::from_millis(200));
            self.each(|stamp| {
                if newest.insert(stamp.view, stamp.seq) != Some(stamp.seq) && stamp.on_request == 0 {
                    found.push(ms(stamp.t_framed_ns - stamp.t_capture_ns));
                }
            });
        }
    }

    fn each(&self, mut with: impl FnMut(FrameStamp)) {
        for stamps in &self.0 {
            while let Some(stamp) = stamps.next().unwrap() {
                with(stamp);
            }
        }
    }
}

/// A sender and its receivers; gone when it is dropped.
struct Company {
    _receivers: Vec<(Program, Second)>,
    _sender: Program,
}

impl Company {
    fn start((world, keys, turn): (&Path, &str, usize), near: &Looking, guests: Guests) -> Self {
        let endpoint = free_endpoint().replace("tcp/", "tls/");
        let mut send = remote_proc();
        send.args(["send", "--run", "or", "--listen", &endpoint, "--keys", keys]);
        let sender = Program::start(world, &format!("send{turn}"), send);
        let (run, scene) = RunContext::load_with_scene(&near.run.dir, None).unwrap();
        let id = format!("{:016x}", remote_proc::send::run_id(&run, &scene));
        let receivers = (0..guests.receivers).map(|number| {
            let second = Second::open(world, &format!("t{turn}s{number}"), &endpoint);
            let mut command = remote_proc();
            command.args(["receive", &endpoint, "--session", &id, "--keys", keys, "--run-dir"]);
            command.arg(&second.run.dir);
            (Program::start(world, &second.run.name, command), second)
        });
        let receivers: Vec<(Program, Second)> = receivers.collect();
        for (receiver, second) in &receivers {
            until("the examination", || second.volumes.poll().unwrap());
            if guests.stop {
                receiver.signal(Signal::STOP);
            }
        }
        Self {
            _receivers: receivers,
            _sender: sender,
        }
    }
}
