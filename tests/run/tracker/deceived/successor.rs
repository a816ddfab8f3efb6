//! A localizer process that dies: the one that follows knows what it knew of the peer.

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use bus::message::{Lost, MarkerFrame};

use super::cases::{DAY_NS, GOOD, at, transform};
use super::note;
use crate::support::frames::{Watch, tool};
use crate::support::{Pilot, SMALL, World, kill_9, wait_for};

/// Between two poses.
const EVERY: Duration = Duration::from_millis(10);

/// A peer that sends poses of one tool.
struct Peer {
    listener: TcpListener,
    stream: Option<TcpStream>,
    began: Instant,
    sent: u64,
}

impl Peer {
    fn start<'a>(world: &'a World, markers: &str) -> (Self, Pilot<'a>, Watch) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let scene = SMALL
            .replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
            .replace("[limits]\n", "[limits]\nlost_ms = 1000\n")
            + &format!(
                "[tracker.markers]\n{markers}\n\
                 [localizer]\nkind = \"openigtlink\"\npeer = \"plus\"\nsilent_s = 2\naddress = \"127.0.0.1:{port}\"\n"
            );
        let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
        let peer = Self {
            listener,
            stream: None,
            began: Instant::now(),
            sent: 0,
        };
        (peer, pilot, Watch::open(world))
    }

    fn accept(&mut self) {
        let (stream, _) = self.listener.accept().unwrap();
        stream.set_nodelay(true).unwrap();
        self.stream = Some(stream);
    }

    /// A pose that was captured so long ago.
    fn send(&mut self, name: &str, waited: Duration) {
        self.sent += 1;
        let stamp_ns = DAY_NS + (self.began.elapsed() - waited).as_nanos() as u64;
        let x = GOOD + (self.sent % 1000) as f32 / 8.0;
        // An error is a connection that is over.
        let message = transform(name, at(x), stamp_ns, "OK").to_vec().unwrap();
        let _ = self.stream.as_mut().map(|stream| stream.write_all(&message));
        std::thread::sleep(EVERY);
    }
}

fn valid(frames: &[MarkerFrame]) -> usize {
    frames.iter().filter(|frame| tool(frame).is_ok()).count()
}

/// The law had not followed the queue yet when the process died, and the next one took the queue for its least delay: poses of 1.2 s before were
/// of the present, without a word.
#[test]
fn a_queue_that_had_just_come_is_known_to_the_process_that_follows() {
    let queue = Duration::from_millis(1200);
    let world = World::new();
    let (mut peer, pilot, watch) = Peer::start(&world, "marker = \"T\"");
    peer.accept();
    (0..250).for_each(|_| peer.send("T", Duration::ZERO));
    assert!(valid(&watch.come()) > 100);
    std::thread::sleep(queue);
    // Fewer than a law takes to follow.
    (0..8).for_each(|_| peer.send("T", queue));
    kill_9(pilot.pid("localizer").unwrap());
    peer.accept();
    drop(watch.come());
    let mut refused = 0;
    wait_for("poses of the next process, which are refused", || {
        peer.send("T", queue);
        let frames = watch.come();
        assert_eq!(valid(&frames), 0, "{frames:?}");
        refused += frames.iter().filter(|frame| tool(frame) == Err(Lost::Refused)).count();
        // Many times what a law needs to settle.
        (refused > 300).then_some(())
    });
    // The queue has ended.
    let mut fresh = 0;
    wait_for("poses of the present", || {
        peer.send("T", Duration::ZERO);
        fresh += valid(&watch.come());
        (fresh > 20).then_some(())
    });
    let _ = pilot.stop();
}

/// `Drill is not Pointer` held until the process died: then the drill was the tool.
#[test]
fn another_instrument_is_none_to_the_process_that_follows_until_a_person_says_so() {
    let world = World::new();
    let (mut peer, pilot, watch) = Peer::start(&world, "");
    let until_valid = |peer: &mut Peer, name: &str| {
        let mut found = 0;
        wait_for("poses", || {
            peer.send(name, Duration::ZERO);
            found += valid(&watch.come());
            (found > 20).then_some(())
        });
    };
    peer.accept();
    until_valid(&mut peer, "Pointer");
    // What is known is kept twice a second.
    (0..80).for_each(|_| peer.send("Pointer", Duration::ZERO));
    kill_9(pilot.pid("localizer").unwrap());
    peer.accept();
    drop(watch.come());
    for _ in 0..150 {
        peer.send("Drill", Duration::ZERO);
        assert_eq!(valid(&watch.come()), 0);
    }
    pilot.wait_for("why", |status| note(status).contains("Drill is not Pointer"));
    let asked = world.output("pilot", &["restart", "localizer"]);
    assert!(asked.status.success(), "{asked:?}");
    peer.accept();
    until_valid(&mut peer, "Drill");
    let _ = pilot.stop();
}
