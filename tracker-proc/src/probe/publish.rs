//! The images of a simulated probe on the bus, made by a thread of its own: an image takes longer than a frame of the localizer.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use bus::clock::{self, Clock};
use bus::life::LifeLine;
use bus::message::{CaptureClock, UsImageHeader};
use bus::port::{UsImagePublisher, VolumeSubscriber};
use bus::run::RunContext;
use bus::{Bus, BusError};
use scene::Scene;

use super::{ProbeError, SimulatedProbe, Tank, Tissue};
use crate::operating_room::OperatingRoom;

/// The name under which images come.
const DEVICE: &str = "simulated";
/// Its marked side is the one of the tool's x; rows run there, columns away from the face.
const ORIENTATION: &str = "MF";
/// Sleeps no longer than this, so that it ends with its process.
const LOOK_UP: Duration = Duration::from_millis(50);

/// The thread.
#[derive(Debug)]
pub(crate) struct Publishing {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<Result<(), String>>>,
}

/// What the thread works with.
struct Work {
    run: RunContext,
    scene: Scene,
    room: OperatingRoom,
    probe: SimulatedProbe,
    tank: Option<Tank>,
    start_ns: i64,
    ended: Arc<AtomicBool>,
}

/// What is imaged.
enum Sounded {
    Patient(Tissue),
    Tank(Tank),
}

impl Publishing {
    /// Begins to publish the images of `probe`, held as the tool of `room` is, of the patient or of a tank; `start_ns` is the script's begin
    /// on the run's clock.
    ///
    /// # Errors
    /// [`ProbeError::Thread`].
    pub(crate) fn start(
        (run, scene): (&RunContext, &Scene),
        room: &OperatingRoom,
        (probe, tank): (SimulatedProbe, Option<Tank>),
        start_ns: i64,
    ) -> Result<Self, ProbeError> {
        let ended = Arc::new(AtomicBool::new(false));
        let work = Work {
            run: run.clone(),
            scene: scene.clone(),
            room: room.clone(),
            probe,
            tank,
            start_ns,
            ended: Arc::clone(&ended),
        };
        let thread = thread::Builder::new().name("probe".to_owned()).spawn(|| work.run())?;
        let thread = Some(thread);
        Ok(Self { ended, thread })
    }

    /// Says whether the thread has failed.
    ///
    /// # Errors
    /// [`ProbeError::Ended`].
    pub(crate) fn look(&mut self) -> Result<(), ProbeError> {
        if !self.thread.as_ref().is_some_and(JoinHandle::is_finished) {
            return Ok(());
        }
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(Err(why))) => Err(ProbeError::Ended(why)),
            Some(Err(_)) => Err(ProbeError::Ended("their thread has broken off".to_owned())),
            Some(Ok(Ok(()))) | None => Ok(()),
        }
    }
}

impl Drop for Publishing {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // What it has to say was asked for before.
            let _ = thread.join();
        }
    }
}

impl Work {
    fn run(mut self) -> Result<(), String> {
        self.publish().map_err(|error| error.to_string())
    }

    fn publish(&mut self) -> Result<(), BusError> {
        // Ports stay on the thread that made them.
        let bus = Bus::join_with(&self.run, LifeLine::none())?;
        let clock = bus.clock().clone();
        let sounded = match self.tank.take() {
            Some(tank) => Sounded::Tank(tank),
            None => match self.tissue(&bus, &clock)? {
                Some(tissue) => Sounded::Patient(tissue),
                None => return Ok(()),
            },
        };
        let shape = *self.probe.shape();
        let images = UsImagePublisher::open(&bus, shape.columns() * shape.rows())?;
        let mut number = self.due(&clock);
        // A process that takes up another's work goes on behind its numbers; what is left out makes no gap.
        let mut seq = number;
        while !self.ended.load(Ordering::Relaxed) {
            let t_ns = self.probe.t_capture_ns(number);
            if self.run.is_beyond(t_ns) {
                return Ok(());
            }
            if !self.sleep_until(t_ns, &clock, &images) {
                continue;
            }
            let stamped_ns = t_ns + clock::seconds(self.probe.spec.lag_s);
            let Some(grey) = self.image(number, &sounded) else {
                // A gesture that goes so far away that nothing is to be seen there.
                number += 1;
                continue;
            };
            self.send((seq, &grey), (stamped_ns, &clock, &images))?;
            seq += 1;
            // What would be late anyhow is left out.
            number = (number + 1).max(self.due(&clock));
        }
        Ok(())
    }

    /// The patient, as soon as the loader has him; `None` where the process ended meanwhile.
    fn tissue(&self, bus: &Bus, clock: &Clock) -> Result<Option<Tissue>, BusError> {
        let volumes = VolumeSubscriber::open(bus)?;
        while !self.ended.load(Ordering::Relaxed) {
            if let Some(volume) = volumes.poll()? {
                return Ok(Some(Tissue::of(&self.scene, volume)));
            }
            clock.sleep_until(clock.now_ns() + clock::ns(LOOK_UP));
        }
        Ok(None)
    }

    /// The image whose time it is.
    fn due(&self, clock: &Clock) -> u64 {
        let passed_s = clock::ms(clock.now_ns() - self.start_ns) / 1e3;
        // Negative before the script begins: image 0.
        (passed_s * self.probe.spec.rate_hz).floor() as u64
    }

    /// Whether it is script time `t_ns`, or else sleeps towards it.
    fn sleep_until(&self, t_ns: i64, clock: &Clock, images: &UsImagePublisher) -> bool {
        images.serve_late_joiners();
        let (at_ns, now) = (self.start_ns + t_ns, clock.now_ns());
        if now >= at_ns {
            return true;
        }
        clock.sleep_until(at_ns.min(now + clock::ns(LOOK_UP)));
        false
    }

    fn image(&mut self, number: u64, sounded: &Sounded) -> Option<Vec<u8>> {
        let pose = self.room.ct_from_tool(self.probe.t_capture_ns(number) as f64 / 1e9);
        let image = match sounded {
            Sounded::Patient(tissue) => self.probe.image(tissue, pose, number),
            Sounded::Tank(tank) => self.probe.image_in_tank(tank, pose, number),
        };
        image.ok()
    }

    /// Publishes an image, not before the time of its stamp.
    fn send(
        &self,
        (seq, grey): (u64, &[u8]),
        (stamped_ns, clock, images): (i64, &Clock, &UsImagePublisher),
    ) -> Result<(), BusError> {
        let at_ns = self.start_ns + stamped_ns;
        while clock.now_ns() < at_ns && !self.ended.load(Ordering::Relaxed) {
            clock.sleep_until(at_ns.min(clock.now_ns() + clock::ns(LOOK_UP)));
        }
        let header = UsImageHeader {
            seq,
            t_device_ns: stamped_ns,
            t_capture_ns: at_ns,
            // Of the simulated scanner; how long the simulation takes is none of its times.
            t_arrival_ns: at_ns,
            t_publish_ns: clock.now_ns(),
            clock: CaptureClock::Mapped.code(),
            ..UsImageHeader::of(self.probe.shape())
        };
        images.send(header.with_device(DEVICE).turned(ORIENTATION), grey)
    }
}
