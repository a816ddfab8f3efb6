//! A peer that stands still, dies, or is cut off: how soon the images say so, and how soon they are live again.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use bus::Bus;
use bus::clock::{Clock, monotonic_ns};
use bus::message::{FrameStamp, FrameState, Lost};
use bus::port::Subscriber;
use bus::run::RunContext;
use bus::topic::FRAME_STAMP;
use rustix::process::{Pid, Signal, kill_process};
use scene::Plane;

use crate::support::cable::Cable;
use crate::support::{Pilot, SMALL, World, wait_for};
use crate::{STAMP_NS, message, spread};

/// The limits of the scene, ms.
const STALE_MS: f64 = 100.0;
const LOST_MS: f64 = 1000.0;
/// How long the peer is away and there again in turn: away for longer than the connection lasts.
#[derive(Clone, Copy)]
pub(crate) struct Turns {
    pub(crate) away: Duration,
    /// Poses flow for so long before it goes again.
    pub(crate) flow: Duration,
    /// When a connection is given up on which nothing comes.
    pub(crate) silent_s: f64,
    /// Each image that is only old is waited for, of which a machine that stands still for a second shows none.
    pub(crate) counts_stale: bool,
}

const TURNS: Turns = Turns {
    away: Duration::from_millis(3500),
    flow: Duration::from_millis(1500),
    silent_s: 2.0,
    counts_stale: true,
};

/// The peer: sends a tool with a status at 60 Hz to one client after the other. Prints its port.
pub(crate) fn peer(host: &str, port: u16) {
    let listener = wait_for("the address", || TcpListener::bind((host, port)).ok());
    println!("{}", listener.local_addr().unwrap().port());
    let mut i = 0;
    for mut client in listener.incoming().flatten() {
        let _ = client.set_nodelay(true);
        // One that has taken nothing for so long is gone.
        let _ = client.set_write_timeout(Some(Duration::from_secs(1)));
        while client.write_all(&message(i, STAMP_NS + monotonic_ns())).is_ok() {
            i += 1;
            thread::sleep(Duration::from_micros(16_667));
        }
    }
}

/// How the peer goes away.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Way {
    Stopped,
    Killed,
    Pulled,
}

/// Prints a line for each way.
pub(crate) fn measure(cycles: u64) {
    let cable = Cable::new();
    for (way, words) in [
        (Way::Stopped, "stopped (SIGSTOP)"),
        (Way::Killed, "killed (SIGKILL)"),
        (Way::Pulled, "cable pulled"),
    ] {
        let there = cable.as_ref().filter(|_| way == Way::Pulled);
        if way == Way::Pulled && there.is_none() {
            continue;
        }
        let mut run = Run::start(there, TURNS);
        let cycles: Vec<Cycle> = (0..cycles).map(|_| run.cycle(way)).collect();
        let of = |part: fn(&Cycle) -> Option<i64>| spread(cycles.iter().filter_map(part).collect());
        println!("peer {words}, {} times; from then to the last view's", cycles.len());
        println!("  (what made it go took {})", of(|c| Some(c.going_ns)));
        println!("  age on the image {} (limit {STALE_MS} ms)", of(|c| c.stale_ns));
        println!("  NO POSE {} (limit {LOST_MS} ms)", of(|c| c.lost_ns));
        println!("  from its return to a live image {}", of(|c| Some(c.back_ns)));
    }
}

/// When what was seen of it, ns behind its beginning; of the last of the views.
pub(crate) struct Cycle {
    stale_ns: Option<i64>,
    lost_ns: Option<i64>,
    pub(crate) back_ns: i64,
    /// What it took to make it go: a cable is pulled by a program, and the times are from its start.
    going_ns: i64,
}

/// A run that follows a peer.
pub(crate) struct Run<'a> {
    // The pilot goes before its world.
    pub(crate) pilot: Pilot<'static>,
    turns: Turns,
    cable: Option<&'a Cable>,
    clock: Clock,
    stamps: Vec<Subscriber<FrameStamp>>,
    peer: Child,
    host: String,
    port: u16,
    _bus: Bus,
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        let _ = self.peer.kill();
        let _ = self.peer.wait();
    }
}

impl<'a> Run<'a> {
    pub(crate) fn start(cable: Option<&'a Cable>, turns: Turns) -> Self {
        let host = cable.map_or("127.0.0.1".to_owned(), |cable| cable.address.clone());
        let (peer, port) = spawn(cable, &host, 0);
        let limits = format!("stale_ms = {STALE_MS:.1}\nlost_ms = {LOST_MS:.1}");
        let scene = SMALL
            .replace("[tracker]\n", "[tracker]\nsource = \"markers\"\n")
            .replace("[recording]\n", "")
            .replace("stale_ms = 1000.0", &limits)
            + &format!(
                "[tracker.markers]\nmarker = \"T\"\n[localizer]\nkind = \"openigtlink\"\npeer = \"plus\"\nsilent_s = {:?}\n\
                 address = \"{host}:{port}\"\n",
                turns.silent_s
            );
        let world: &'static World = Box::leak(Box::new(World::new()));
        let pilot = world.start(&world.file("s.toml", &scene), &world.path("out"), "default");
        let context = wait_for("the run", || RunContext::load(&world.run_dir("default")).ok());
        pilot.wait_live();
        let bus = Bus::join(&context).unwrap();
        let planes = [Plane::Axial, Plane::Frontal, Plane::Perpendicular];
        let stamps = planes.map(|plane| Subscriber::open(&bus, &FRAME_STAMP, &plane.process(), 1024).unwrap());
        Self {
            clock: bus.clock().clone(),
            stamps: stamps.into(),
            _bus: bus,
            pilot,
            turns,
            cable,
            peer,
            host,
            port,
        }
    }

    fn signal(&self, signal: Signal) {
        let pid = Pid::from_raw(i32::try_from(self.peer.id()).unwrap()).unwrap();
        kill_process(pid, signal).unwrap();
    }

    /// Once away and back.
    pub(crate) fn cycle(&mut self, way: Way) -> Cycle {
        self.until("live images", is_live);
        thread::sleep(self.turns.flow);
        self.forget();
        let away_ns = self.clock.now_ns();
        match way {
            Way::Stopped => self.signal(Signal::STOP),
            Way::Killed => self.signal(Signal::KILL),
            Way::Pulled => self.cable.unwrap().set("down"),
        }
        let going_ns = self.clock.now_ns() - away_ns;
        // A peer that dies says so: there is no time in which the pose is only old.
        let stale_ns = (way != Way::Killed && self.turns.counts_stale)
            .then(|| self.until("old images", |state| state == FrameState::Stale) - away_ns);
        let is_lost = |state| match way {
            Way::Killed => state == FrameState::Lost(Lost::Disconnected),
            _ => matches!(state, FrameState::Lost(_)),
        };
        let lost_ns = self.until("images without a pose", is_lost) - away_ns;
        self.clock.sleep_until(away_ns + self.turns.away.as_nanos() as i64);
        self.forget();
        let back_ns = match way {
            Way::Stopped => {
                self.signal(Signal::CONT);
                self.clock.now_ns()
            }
            Way::Killed => {
                let _ = self.peer.wait();
                (self.peer, _) = spawn(self.cable, &self.host, self.port);
                self.clock.now_ns()
            }
            Way::Pulled => {
                self.cable.unwrap().set("up");
                self.clock.now_ns()
            }
        };
        let back_ns = self.until("live images", is_live) - back_ns;
        Cycle {
            stale_ns,
            lost_ns: Some(lost_ns),
            back_ns,
            going_ns,
        }
    }

    fn forget(&self) {
        for stamps in &self.stamps {
            while stamps.next().unwrap().is_some() {}
        }
    }

    /// When the last of the views had handed out its first image of this state.
    fn until(&self, what: &str, wanted: impl Fn(FrameState) -> bool) -> i64 {
        let mut found = vec![None; self.stamps.len()];
        wait_for(what, || {
            for (stamps, found) in self.stamps.iter().zip(&mut found) {
                while found.is_none()
                    && let Some(stamp) = stamps.next().unwrap()
                {
                    *found = stamp
                        .frame_state()
                        .filter(|state| wanted(*state))
                        .map(|_| stamp.t_framed_ns);
                }
            }
            found.iter().copied().collect::<Option<Vec<i64>>>()?.into_iter().max()
        })
    }
}

fn is_live(state: FrameState) -> bool {
    state == FrameState::Live
}

/// The peer as a process, and its port.
fn spawn(cable: Option<&Cable>, host: &str, port: u16) -> (Child, u16) {
    let program: PathBuf = std::env::current_exe().unwrap();
    let mut command = cable.map_or_else(|| Command::new(&program), |cable| cable.command(&program));
    let mut child = command
        .args(["peer", &port.to_string(), host])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut out = BufReader::new(child.stdout.take().unwrap());
    out.read_line(&mut line).unwrap();
    (child, line.trim().parse().unwrap_or_else(|_| panic!("{line:?}")))
}
