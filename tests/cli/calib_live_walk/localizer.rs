//! A localizer that sees an instrument as the test holds it.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering::Relaxed};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use bus::Bus;
use bus::message::{EmitterFrame, EmitterSight, MarkerFrame, MarkerSight};
use bus::port::Publisher;
use bus::run::RunContext;
use bus::topic::{EMITTERS, MARKERS};
use geometry::{Marker, Point, Rigid, Tool, Tracker, Vector};

use crate::support::links::MARKER_FROM_TOOL_MM;

/// The instrument's marker, mm: no two of its distances are alike.
pub(crate) const EMITTERS_MM: [[f64; 3]; 6] = [
    [50.0, 0.0, 0.0],
    [-45.0, 8.0, 3.0],
    [0.0, 52.0, -6.0],
    [6.0, -48.0, 10.0],
    [-10.0, 5.0, 47.0],
    [20.0, -25.0, -40.0],
];
/// What the localizer errs by along each axis, mm, evenly on both sides.
pub(crate) const NOISE_MM: f64 = 0.1;

/// How the instrument is held.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Held {
    /// Still.
    Still(Rigid<Tracker, Tool>),
    /// Turned about its tip, to all sides.
    Pivoting(Point<Tracker>),
    /// Still but for a slow walk along x of so many mm a second.
    Walking(Rigid<Tracker, Tool>, f64),
}

impl Held {
    fn at(self, t_s: f64) -> Rigid<Tracker, Tool> {
        match self {
            Self::Still(at) => at,
            Self::Pivoting(tip) => {
                let turn = Vector::new(0.5 * (1.1 * TAU * t_s).sin(), 0.5 * (0.7 * TAU * t_s).cos(), 0.0);
                tool(turn, tip)
            }
            Self::Walking(at, speed) => {
                let [x, y, z] = at.translation_mm();
                Rigid::from_parts(at.rotation(), Vector::new(x + speed * t_s, y, z))
            }
        }
    }
}

/// The tool turned like this, with its tip there.
pub(crate) fn tool(turn: Vector<Tracker>, tip: Point<Tracker>) -> Rigid<Tracker, Tool> {
    let [x, y, z] = tip.mm();
    Rigid::from_rotation_vector(turn, Vector::new(x, y, z)).unwrap()
}

/// Even between -1 and 1, by number.
fn noise(i: u64) -> f64 {
    let x = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x >> 11) as f64 / (1_u64 << 53) as f64).mul_add(2.0, -1.0)
}

/// Sends the frame of this number, captured then, of a tool that is held so.
type Send = Box<dyn Fn(u64, i64, Rigid<Tracker, Tool>)>;

/// A localizer that sees the instrument as the test holds it.
pub(crate) struct Localizer {
    held: Arc<Mutex<Held>>,
    late_ns: Arc<AtomicI64>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Localizer {
    /// One that delivers places of emitters.
    pub(crate) fn start(context: &RunContext) -> Self {
        Self::of(context, |bus| {
            let frames: Publisher<EmitterFrame> = Publisher::open(bus, &EMITTERS, "").unwrap();
            Box::new(move |seq, now_ns, at| frames.send(frame(seq, now_ns, at)).unwrap())
        })
    }

    /// One that makes the pose of its marker itself.
    pub(crate) fn start_with_poses(context: &RunContext) -> Self {
        Self::of(context, |bus| {
            let frames: Publisher<MarkerFrame> = Publisher::open(bus, &MARKERS, "").unwrap();
            Box::new(move |seq, now_ns, at| frames.send(posed(seq, now_ns, at)).unwrap())
        })
    }

    fn of(context: &RunContext, sender: fn(&Bus) -> Send) -> Self {
        let held = Arc::new(Mutex::new(Held::Pivoting(divot())));
        let stop = Arc::new(AtomicBool::new(false));
        let late_ns = Arc::new(AtomicI64::new(0));
        let (shown, late, ended) = (Arc::clone(&held), Arc::clone(&late_ns), Arc::clone(&stop));
        let context = context.clone();
        let thread = thread::spawn(move || {
            let bus = Bus::join(&context).unwrap();
            let send = sender(&bus);
            let clock = bus.clock().clone();
            let mut seen = VecDeque::new();
            for seq in 0.. {
                let now = clock.now_ns();
                let at = shown.lock().unwrap().at(now as f64 * 1e-9);
                seen.push_back((seq, now, at));
                let until = now - late.load(Relaxed);
                while let Some((seq, now, at)) = seen.pop_front_if(|(_, captured_ns, _)| *captured_ns <= until) {
                    send(seq, now, at);
                }
                if ended.load(Relaxed) {
                    break;
                }
                thread::sleep(Duration::from_millis(5));
            }
        });
        Self {
            held,
            late_ns,
            stop,
            thread: Some(thread),
        }
    }

    pub(crate) fn hold(&self, held: Held) {
        *self.held.lock().unwrap() = held;
    }

    /// From now on frames come so long after they were captured.
    pub(crate) fn is_late_by_ms(&self, late: i64) {
        self.late_ns.store(late * 1_000_000, Relaxed);
    }
}

impl Drop for Localizer {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn frame(seq: u64, now_ns: i64, at: Rigid<Tracker, Tool>) -> EmitterFrame {
    let mut frame = EmitterFrame {
        seq,
        t_device_ns: now_ns,
        t_capture_ns: now_ns,
        t_publish_ns: now_ns,
        ..EmitterFrame::EMPTY
    };
    let tracker_from_marker = at * marker_from_tool().inverse();
    let sights = EMITTERS_MM.iter().zip(0_u32..6).map(|([x, y, z], emitter)| {
        let [a, b, c] = (tracker_from_marker * Point::new(*x, *y, *z)).mm();
        // The variance of even noise is a third of its bound's square.
        let off = |k: u64| NOISE_MM * 3.0_f64.sqrt() * noise(18 * seq + 3 * u64::from(emitter) + k);
        EmitterSight {
            place_mm: [a + off(0), b + off(1), c + off(2)],
            emitter,
            reserved: 0,
        }
    });
    frame.set(sights, std::iter::empty()).unwrap();
    frame
}

/// What the localizer errs by about each axis, radians, evenly on both sides.
pub(crate) const NOISE_RAD: f64 = 1e-3;

fn posed(seq: u64, now_ns: i64, at: Rigid<Tracker, Tool>) -> MarkerFrame {
    let mut frame = MarkerFrame {
        seq,
        t_device_ns: now_ns,
        t_capture_ns: now_ns,
        t_arrival_ns: now_ns,
        t_publish_ns: now_ns,
        ..MarkerFrame::EMPTY
    };
    let off = |size: f64, k: u64| size * 3.0_f64.sqrt() * noise(6 * seq + k);
    let turn = Vector::new(off(NOISE_RAD, 0), off(NOISE_RAD, 1), off(NOISE_RAD, 2));
    let shift = Vector::new(off(NOISE_MM, 3), off(NOISE_MM, 4), off(NOISE_MM, 5));
    // On the marker's side, so that it turns about the marker's origin.
    let errs: Rigid<Marker, Marker> = Rigid::from_rotation_vector(turn, shift).unwrap();
    let tracker_from_marker = at * marker_from_tool().inverse() * errs;
    let sight = MarkerSight::seen(MarkerFrame::TOOL, tracker_from_marker, 0.0);
    frame.set(&[sight]).unwrap();
    frame
}

/// As the instrument was built.
pub(crate) fn marker_from_tool() -> Rigid<Marker, Tool> {
    let [x, y, z] = MARKER_FROM_TOOL_MM;
    Rigid::from_rotation_vector(Vector::new(0.2, -0.1, 0.4), Vector::new(x, y, z)).unwrap()
}

pub(crate) fn divot() -> Point<Tracker> {
    Point::new(80.0, -40.0, 1850.0)
}
