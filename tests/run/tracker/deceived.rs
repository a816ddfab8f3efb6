//! A peer of OpenIGTLink that sends what no peer should, to a real run: what it is told, what is counted, and no wrong pose.

#![allow(clippy::disallowed_methods, reason = "how long a test waits is its own time")]

mod cases;
mod successor;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use bus::message::{Lost, MarkerFrame};
use igtl::{Body, DeviceName, Message, Status};

use crate::support::frames::{Watch, is_disconnected, note, status_says, tool};
use crate::support::{Pilot, SMALL, World, wait_for};
use cases::{BAD, DAY_NS, GOOD, Then, at, bad, contents, header, headers, transform};

/// For one thing of a case.
const PATIENCE: Duration = Duration::from_secs(30);

/// A run that dials this test.
struct Dialled<'a> {
    pilot: Pilot<'a>,
    watch: Watch,
    listener: TcpListener,
    sent: u64,
}

impl<'a> Dialled<'a> {
    fn start(world: &'a World) -> Self {
        Self::under(world, "")
    }

    /// The same under more limits of the scene.
    fn under(world: &'a World, limits: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let scene = SMALL
            .replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
            .replace("[limits]\n", &format!("[limits]\n{limits}"))
            + &format!(
                "[tracker.markers]\nmarker = \"T\"\n\
                 [localizer]\nkind = \"openigtlink\"\npeer = \"plus\"\nsilent_s = 2\naddress = \"127.0.0.1:{port}\"\n"
            );
        let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
        Self {
            pilot,
            watch: Watch::open(world),
            listener,
            sent: 0,
        }
    }

    /// A connection on which a good pose was shown.
    fn connected(&mut self) -> Result<TcpStream, String> {
        let (mut stream, _) = self.listener.accept().unwrap();
        stream.set_nodelay(true).unwrap();
        self.good(&mut stream)?;
        Ok(stream)
    }

    /// A good pose of another time than every one before; waits until it is shown.
    fn good(&mut self, stream: &mut TcpStream) -> Result<(), String> {
        self.sent += 1;
        let x = GOOD + self.sent as f32 / 8.0;
        let stamp_ns = DAY_NS + self.sent * 20_000_000;
        // An error is a connection that is over, and nothing comes.
        let _ = stream.write_all(&transform("T", at(x), stamp_ns, "OK").to_vec().unwrap());
        let is_it = |frame: &MarkerFrame| tool(frame).is_ok_and(|pose| pose.translation_mm()[0] == f64::from(x));
        self.until("a good pose", is_it)
    }

    /// Waits for a frame of which this holds. No other has a pose that must not be shown.
    fn until(&self, what: &str, wanted: impl Fn(&MarkerFrame) -> bool) -> Result<(), String> {
        soon(what, || {
            let frames = self.watch.come();
            for frame in &frames {
                let is_bad = tool(frame).is_ok_and(|pose| pose.translation_mm()[0] == f64::from(BAD));
                assert!(!is_bad || wanted(frame), "{what}: {frame:?}");
                assert!(frame.t_capture_ns <= frame.t_arrival_ns + 1000, "{what}: {frame:?}");
            }
            frames.iter().any(&wanted)
        })
    }

    /// Waits for words.
    fn hears(&self, words: &str) -> Result<(), String> {
        let mut all = Vec::new();
        let heard = soon(words, || {
            all.extend(self.watch.told());
            all.iter().any(|told| told.contains(words))
        });
        heard.map_err(|why| format!("{why}: {all:?}"))
    }

    fn case(&mut self, name: &str, bytes: &[u8], then: &Then) -> Result<(), String> {
        let mut stream = self.connected()?;
        drop((self.watch.told(), self.watch.come()));
        // A message that is refused before its end may be answered by a closed connection.
        let _ = stream.write_all(bytes);
        match then {
            Then::Closes(words) => {
                self.hears(words)?;
                self.until(name, is_disconnected)
            }
            Then::GoesOn(words) => {
                self.hears(words)?;
                self.good(&mut stream)
            }
            Then::Lost(reason, words) => {
                self.until(name, |frame| tool(frame) == Err(*reason))?;
                if *words == "none" { Ok(()) } else { self.hears(words) }
            }
            Then::Unseen => self.until(name, |frame| tool(frame).is_ok()),
        }
    }
}

/// Waits for it, for less long than a whole test: all cases that fail are to be told.
fn soon(what: &str, mut is_there: impl FnMut() -> bool) -> Result<(), String> {
    let began = Instant::now();
    while !is_there() {
        if began.elapsed() > PATIENCE {
            return Err(format!("waited for {what}"));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(())
}

#[test]
fn what_no_peer_should_send_is_named_and_shows_no_pose() {
    let world = World::new();
    let mut run = Dialled::start(&world);
    let mut failed = Vec::new();
    for (name, bytes, then) in headers().into_iter().chain(contents()) {
        if let Err(why) = run.case(name, &bytes, &then) {
            failed.push(format!("{name}: {why}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
    // What was refused is counted where people look.
    status_says(&run.pilot, " messages refused");
    let _ = run.pilot.stop();
}

/// Bytes that never become a message, and messages that hold no pose.
#[test]
fn a_peer_that_says_nothing_of_use_is_named() {
    let world = World::new();
    let mut run = Dialled::start(&world);
    let mut slow = run.connected().unwrap();
    let bytes = bad();
    let mut sent = bytes.iter().take(57).cycle();
    wait_for("the end of a slow connection", || {
        std::thread::sleep(Duration::from_millis(100));
        let _ = slow.write_all(&[*sent.next().unwrap()]);
        run.watch
            .told()
            .iter()
            .any(|told| told.contains("bytes of a message in"))
            .then_some(())
    });
    drop(slow);
    // It answers whatever it is asked, and sends no pose.
    let mut idle = run.connected().unwrap();
    let answering = std::thread::spawn(move || {
        let (answer, mut room) = (status_ok(), [0; 4096]);
        while idle.read(&mut room).is_ok_and(|count| count > 0) && idle.write_all(&answer).is_ok() {}
    });
    run.pilot.wait_for("a peer without poses", |status| {
        note(status).starts_with("nothing comes") && status["pose"]["state"] != "valid"
    });
    let _ = run.pilot.stop();
    answering.join().unwrap();
}

fn status_ok() -> Vec<u8> {
    Message::new(DeviceName::EMPTY, Body::Status(Status::new(1, "")))
        .to_vec()
        .unwrap()
}

/// Stamps that no clock has: the arrival counts, and it is said why.
#[test]
fn stamps_that_no_clock_has_put_no_pose_into_another_time() {
    const S: u64 = 1_000_000_000;
    let world = World::new();
    let run = Dialled::start(&world);
    // Of a real clock, ns, what the peer makes.
    for (name, stamp, words) in [
        ("none", (|_| 0) as fn(u64) -> u64, "the device states no time"),
        (
            "ms for s",
            |t| (1_790_000_000_000 % (1 << 32)) * S + 1000 * t,
            "is their unit right?",
        ),
        ("s for ms", |t| (DAY_NS + t) / 1000, "is their unit right?"),
        // Seconds that stay 0: stamps go back with each.
        ("a fraction alone", |t| t % S, "frames have the time of their arrival"),
        // 32 bits of seconds end, and begin again.
        (
            "2106",
            |t| (u64::from(u32::MAX) * S + t) % ((1 << 32) * S),
            "clock was set by -4",
        ),
        ("frozen", |_| DAY_NS, "frames have the time of their arrival"),
        (
            "an hour later",
            |t| DAY_NS + t + u64::from(t > S) * 3600 * S,
            "clock was set by +3",
        ),
        (
            "an hour earlier",
            |t| DAY_NS + t - u64::from(t > S) * 3600 * S,
            "clock was set by -3",
        ),
    ] {
        let (mut stream, _) = run.listener.accept().unwrap();
        stream.set_nodelay(true).unwrap();
        drop((run.watch.told(), run.watch.come()));
        let (mut told, mut frames) = (Vec::new(), Vec::new());
        let (mut i, began) = (0, Instant::now());
        wait_for(&format!("{words:?} of {name}"), || {
            for _ in 0..10 {
                i += 1;
                let x = GOOD + (i % 1000) as f32 / 8.0;
                let stamp_ns = stamp(began.elapsed().as_nanos() as u64);
                let bytes = transform("T", at(x), DAY_NS, "OK").to_vec().unwrap();
                // 32 bits of seconds, 32 of the fraction.
                let field = (stamp_ns / S) << 32 | ((u128::from(stamp_ns % S) << 32) / u128::from(S)) as u64;
                let _ = stream.write_all(&header(bytes, 34, &field.to_be_bytes()));
                std::thread::sleep(Duration::from_millis(10));
            }
            told.extend(run.watch.told());
            frames.extend(run.watch.come());
            told.iter().any(|told: &String| told.contains(words)).then_some(())
        });
        for frame in frames.iter().filter(|frame| tool(frame).is_ok()) {
            let late_ns = frame.t_arrival_ns - frame.t_capture_ns;
            // Never from the future, and not older than what a busy machine makes of it.
            assert!((-1000..10 * S as i64).contains(&late_ns), "{name}: {frame:?}");
        }
    }
    let _ = run.pilot.stop();
}

/// Frames that all come 1.2 s late from one moment on, with true stamps, were a clock that was set back: valid, and new.
#[test]
fn poses_of_a_queue_that_grew_are_refused_as_old_and_are_a_problem_of_the_report() {
    const WAITED_NS: u64 = 1_200_000_000;
    let world = World::new();
    let mut run = Dialled::under(&world, "lost_ms = 1000\n");
    let (mut stream, _) = run.listener.accept().unwrap();
    stream.set_nodelay(true).unwrap();
    let began = Instant::now();
    let mut send = |waited_ns: u64| {
        run.sent += 1;
        let stamp_ns = DAY_NS + began.elapsed().as_nanos() as u64 - waited_ns;
        let x = GOOD + (run.sent % 1000) as f32 / 8.0;
        let _ = stream.write_all(&transform("T", at(x), stamp_ns, "OK").to_vec().unwrap());
        std::thread::sleep(Duration::from_millis(10));
    };
    (0..150).for_each(|_| send(0));
    assert!(run.watch.come().iter().any(|frame| tool(frame).is_ok()));
    std::thread::sleep(Duration::from_nanos(WAITED_NS));
    let mut refused = Vec::new();
    wait_for("a pose that is refused", || {
        send(WAITED_NS);
        refused.extend(
            run.watch
                .come()
                .into_iter()
                .filter(|frame| tool(frame) == Err(Lost::Refused)),
        );
        (refused.len() > 20).then_some(())
    });
    // The queue's length, to what a busy machine makes of it.
    let old_ns = refused
        .iter()
        .map(|frame| frame.t_arrival_ns - frame.t_capture_ns)
        .min()
        .unwrap();
    assert!((1_100_000_000..3_000_000_000).contains(&old_ns), "{old_ns}");
    status_says(&run.pilot, bus::message::MAY_BE_OLDER);
    // While nobody is connected too: the next process is told of the queue by what stands there.
    drop((stream, run.listener));
    run.pilot.wait_for("a queue, and nobody who is connected", |status| {
        let note = note(status);
        note.starts_with(bus::message::MAY_BE_OLDER) && note.contains("waiting for")
    });
    let _ = run.pilot.stop();
    let problems = crate::support::report(&world.path("out"))["problems"].to_string();
    assert!(problems.contains("poses may have been up to 1"), "{problems}");
}
