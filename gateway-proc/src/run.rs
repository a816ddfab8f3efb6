//! The process: signs of life and the examination on its main thread, everything else on threads of their own.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::ProcessState;
use bus::port::{SharedVolume, VolumeSubscriber};
use bus::process::{JoinError, Membership, Process, take_leave};
use scene::{Plane, TrackerSource};

use crate::client::Known;
use crate::feed::{Needs, follow};
use crate::hall::{Counted, Hall};
use crate::listen::{Door, SharedDoor, listen};
use crate::mailbox::Slot;
use crate::origin::Origin;
use crate::picture::devices;
use crate::tell::{CONFIGURATION, DISABLED, NOT_READY, SERVER, named, reference_marker, refusal, tool_marker};
use crate::volume::{Copied, VOLUME};

/// Between two looks at what is wanted.
const TICK: Duration = Duration::from_millis(10);

/// How long clients may take to be told that the run has ended.
const FAREWELL: Duration = Duration::from_millis(500);
/// So long after the pilot's death this process is gone, whatever it does.
const LEAVE: Duration = Duration::from_secs(2);

/// Why nobody is served, or not any longer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunError {
    /// The run could not be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The scene opens no port.
    #[error("the scene has no [gateway] table: nothing is to be served")]
    NoGateway,
    /// A thread could not be started.
    #[error("starting a thread: {0}")]
    Thread(#[source] std::io::Error),
    /// The thread that follows the run has ended without a reason.
    #[error("the thread that follows the run has ended")]
    Ended,
}

/// The examination, and who wants it.
struct Desk {
    volumes: VolumeSubscriber,
    volume: Option<SharedVolume>,
    copied: Copied,
    origin: Origin,
}

impl Desk {
    /// `alive` is called again and again where this takes longer.
    fn step(&mut self, hall: &Hall, alive: &mut dyn FnMut()) -> Result<(), BusError> {
        if let Some(new) = self.volumes.poll()? {
            match &self.volume {
                Some(old) if old.hash() != new.hash() => bus::stderr_line!(
                    "gateway-proc: warning: the loader published another examination ({}); clients are sent {}",
                    new.hash(),
                    old.hash()
                ),
                _ => self.volume = Some(new),
            }
        }
        for client in hall.all() {
            let Some(version) = client.take_volume_wish() else {
                continue;
            };
            if let Some(why) = hall.withheld() {
                client.say(&Arc::new(refusal(DISABLED, why)));
                client.ring();
                continue;
            }
            let (copied, volume) = (&mut self.copied, self.volume.as_ref());
            match volume.map(|volume| copied.letter(volume, self.origin, version, alive)) {
                Some(Ok(letter)) => client.put(Slot::Volume, &letter),
                Some(Err(error)) => client.say(&Arc::new(refusal(CONFIGURATION, &error.to_string()))),
                None => client.say(&Arc::new(refusal(NOT_READY, "the examination is not loaded yet"))),
            }
            client.ring();
        }
        Ok(())
    }
}

/// Serves clients until the process is asked to stop.
///
/// # Errors
/// Each variant of [`RunError`].
pub(crate) fn run(membership: &Membership) -> Result<(), RunError> {
    let mut process = Process::join("gateway", membership)?;
    // Killed with the pilot, it would leave its clients a valid pose as the last word.
    take_leave(membership, &process.stop, LEAVE)?;
    let spec = process.scene.gateway.ok_or(RunError::NoGateway)?;
    let origin = Origin::of(&process.run, &process.scene);
    let known = Arc::new(known(&process, origin));
    let hall = Arc::new(Hall::new(known.views.len(), spec.images));
    let mut desk = Desk {
        volumes: process.volumes()?,
        volume: None,
        copied: Copied::default(),
        origin,
    };
    let needs = Needs {
        run: process.run.clone(),
        scene: process.scene.clone(),
        life: process.bus.life_line(),
        hall: Arc::clone(&hall),
        known: Arc::clone(&known),
    };
    let (opened, open) = mpsc::channel();
    let mut feed = Some(spawn("feed", move || follow(needs, &opened))?);
    while let Err(RecvTimeoutError::Timeout) = open.recv_timeout(TICK) {
        process.beat(ProcessState::Starting, "opening the topics")?;
    }
    let door: SharedDoor = Arc::new(Mutex::new(Door::Closed));
    let (theirs, halls, seen) = (Arc::clone(&door), Arc::clone(&hall), Arc::clone(&known));
    let address = reachable(spec.address, origin);
    let listener = spawn("listen", move || listen(address, &halls, &seen, &theirs))?;
    while !process.stop.is_set() {
        if feed.as_ref().is_some_and(thread::JoinHandle::is_finished) {
            return match feed.take().map(thread::JoinHandle::join) {
                Some(Ok(result)) if process.stop.is_set() => Ok(result?),
                Some(Ok(Err(error))) => Err(error.into()),
                _ => Err(RunError::Ended),
            };
        }
        let mut alive = || {
            // Where the bus has failed, the next one says so.
            let _ = process.beat_with(ProcessState::Ready, || note(&door, &hall));
        };
        desk.step(&hall, &mut alive)?;
        process.counters.published = hall.counted.sent.load(Ordering::Relaxed);
        process.counters.dropped = hall.overtaken();
        process.beat_with(ProcessState::Ready, || note(&door, &hall))?;
        let next_ns = process.clock().now_ns() + clock::ns(TICK);
        process.clock().sleep_until(next_ns);
    }
    // Where the bus has failed, clients are told all the same.
    let stopping = process.beat(ProcessState::Stopping, "asked to stop");
    let _ = listener.join();
    let followed = feed.map_or(Ok(()), |feed| {
        feed.join().map_or(Err(RunError::Ended), |result| Ok(result?))
    });
    // Clients are being told that the run has ended.
    let deadline_ns = clock::monotonic_ns() + clock::ns(FAREWELL);
    while hall.present() > 0 && clock::monotonic_ns() < deadline_ns {
        thread::sleep(TICK);
    }
    followed.and(stopping.map_err(RunError::from))
}

/// A recording is somebody else's scene: what it opens is open to this machine alone.
fn reachable(address: SocketAddr, origin: Origin) -> SocketAddr {
    match origin {
        Origin::Replay if !address.ip().is_loopback() => SocketAddr::from((Ipv4Addr::LOCALHOST, address.port())),
        _ => address,
    }
}

fn known(process: &Process, origin: Origin) -> Known {
    let taken = [
        origin.tool(),
        tool_marker(),
        reference_marker(),
        named(VOLUME),
        named(SERVER),
    ];
    let views = &process.scene.views;
    let names = devices(views.iter().map(|view| view.name.as_str()), &taken);
    Known {
        views: names
            .into_iter()
            .zip(views)
            .map(|(name, view)| (view.plane != Plane::Surface).then_some(name))
            .collect(),
        origin,
        has_markers: origin.is_present() && matches!(process.scene.tracker.source, TrackerSource::Markers(_)),
        stop: process.stop.clone(),
    }
}

fn spawn<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<thread::JoinHandle<T>, RunError> {
    let thread = thread::Builder::new().name(name.to_owned());
    thread.spawn(work).map_err(RunError::Thread)
}

/// For `pilot status`: where it listens, who is there, who was closed.
fn note(door: &SharedDoor, hall: &Hall) -> String {
    let address = match &*door.lock().unwrap_or_else(PoisonError::into_inner) {
        Door::Closed => return "opening the port".to_owned(),
        // It is tried again every second.
        Door::Refused(why) => return format!("NOT SERVING, {why}"),
        Door::Open(address) => *address,
    };
    let Counted {
        slow, hostile, crowded, ..
    } = &hall.counted;
    let mut words = format!("{address}: {} clients", hall.present());
    for (count, what) in [(slow, "dropped"), (hostile, "refused"), (crowded, "turned away")] {
        let count = count.load(Ordering::Relaxed);
        if count > 0 {
            words += &format!(", {count} {what}");
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_opens_no_port_to_other_machines_whatever_its_scene_says() {
        let everywhere: SocketAddr = "0.0.0.0:18944".parse().unwrap();
        let here: SocketAddr = "127.0.0.1:18944".parse().unwrap();
        assert_eq!(reachable(everywhere, Origin::Replay), here);
        assert_eq!(reachable(everywhere, Origin::Localizer), everywhere);
        for origin in [Origin::Replay, Origin::SimulatedTracker] {
            let six: SocketAddr = "[::1]:7".parse().unwrap();
            assert_eq!((reachable(here, origin), reachable(six, origin)), (here, six));
        }
    }
}
