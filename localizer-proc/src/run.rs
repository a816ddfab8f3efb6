//! The process: one connection, whose frames go out as they come.

use std::time::Duration;

use bus::BusError;
use bus::clock;
use bus::message::{Event, Level, Lost, ProcessState};
use bus::port::Publisher;
use bus::process::{JoinError, Membership, Process};
use bus::topic::EVENT;
use scene::TrackerSource;
use scene::localizer::{LinkSpec, LocalizerSpec, OpenIgtLinkSpec};

use crate::again::Again;
use crate::attention::Attention;
use crate::clocks::DeviceClock;
use crate::driver::{Act, Driver, Follows, Frame, Places};
use crate::image_clock::Untimed;
use crate::image_output::ImageOutput;
use crate::link::{CHUNK, Link, News};
use crate::memory::Memory;
use crate::ndi::{Ndi, SetUpError};
use crate::openigtlink::{NamesError, OpenIgtLink, Picture};
use crate::output::Output;
use crate::waiting::{Told, Waiting};

/// Its name in the run.
pub(crate) const NAME: &str = "localizer";
/// It looks up at least this often, to be stopped and to give signs of life.
const LOOK_UP: Duration = Duration::from_millis(20);
/// Over which time frames are counted for the status.
const RATE_NS: i64 = 1_000_000_000;

/// Why it ended.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The run could not be joined.
    #[error(transparent)]
    Join(#[from] JoinError),
    /// A message could not be sent or taken.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Nothing is to be dialled.
    #[error("the scene has no table [localizer], which says what is to be dialled")]
    NoLocalizer,
    /// Names of OpenIGTLink's tools cannot be told apart.
    #[error(transparent)]
    Names(#[from] NamesError),
    /// The tools of a device of NDI cannot be set up.
    #[error(transparent)]
    Ndi(#[from] SetUpError),
    /// What the process before kept cannot be used.
    #[error("{0}; `pilot restart localizer` begins without it")]
    Memory(String),
    /// The tracker follows emitters.
    #[error("OpenIGTLink has no single markers; tracker.source = \"markers\" follows its poses")]
    NoEmitters,
}

/// Dials, and publishes what comes until asked to stop. It goes on from what the process before knew of the peer, unless `is_anew`.
///
/// # Errors
/// [`RunError`]. A peer that is not there is none: it is waited for.
pub(crate) fn run(membership: &Membership, is_anew: bool) -> Result<(), RunError> {
    let mut process = Process::join(NAME, membership)?;
    let follows = match &process.scene.tracker.source {
        TrackerSource::Markers(source) => Some(Follows::Markers(&source.markers)),
        TrackerSource::Emitters(source) => Some(Follows::Emitters(source)),
        _ => None,
    };
    let (Some(spec), Some(follows)) = (process.scene.localizer.clone(), follows) else {
        return Err(RunError::NoLocalizer);
    };
    let mut driver = driver(&spec.link, follows)?;
    let (memory, handed, known) = Memory::open(&process.run, is_anew).map_err(RunError::Memory)?;
    driver.go_on(known);
    let output = match follows {
        Follows::Markers(_) => Output::of_markers(&process, &spec.name, driver.markers())?,
        Follows::Emitters(_) => Output::of_emitters(&process)?,
    };
    let events = Publisher::open(&process.bus, &EVENT, NAME)?;
    let mut localizer = Localizer {
        link: Link::new(&spec.address),
        clock: clock_of(&spec).going_on(handed),
        memory,
        again: Again::default(),
        every_ns: clock::ns(process.scene.limits.stale) / 2,
        images: ImageOutput::new(matches!(&spec.link, LinkSpec::OpenIgtLink(link) if link.images.is_some())),
        attention: Attention::default(),
        spec,
        driver,
        output,
        events,
        told: 0,
        told_of_images: Vec::new(),
        waiting: Waiting::default(),
        next_lost_ns: i64::MIN,
        rate: Rate::default(),
    };
    while !process.stop.is_set() {
        localizer.turn(&mut process)?;
    }
    process.beat(ProcessState::Stopping, "asked to stop")?;
    Ok(())
}

/// What speaks the scene's protocol; not connected yet.
///
/// # Errors
/// [`RunError`] where names or tools of the scene cannot be used.
pub fn driver(link: &LinkSpec, follows: Follows<'_>) -> Result<Box<dyn Driver>, RunError> {
    Ok(match (link, follows) {
        (LinkSpec::OpenIgtLink(link), Follows::Markers(markers)) => Box::new(OpenIgtLink::new(link, markers)?),
        (LinkSpec::OpenIgtLink(_), Follows::Emitters(_)) => return Err(RunError::NoEmitters),
        (LinkSpec::Ndi(link), follows) => Box::new(Ndi::new(link, follows)?),
    })
}

fn clock_of(spec: &LocalizerSpec) -> DeviceClock {
    let latest = match &spec.link {
        LinkSpec::OpenIgtLink(OpenIgtLinkSpec {
            images: Some(images), ..
        }) => images.latest,
        _ => Duration::ZERO,
    };
    let clock = DeviceClock::new(spec.clock, clock::ns(spec.least_delay), clock::ns(latest));
    match &spec.link {
        LinkSpec::OpenIgtLink(_) => clock,
        LinkSpec::Ndi(_) => clock.polled(),
    }
}

/// The state between two looks.
struct Localizer {
    spec: LocalizerSpec,
    link: Link,
    driver: Box<dyn Driver>,
    clock: DeviceClock,
    memory: Memory,
    again: Again,
    attention: Attention,
    output: Output,
    images: ImageOutput,
    events: Publisher<Event>,
    /// Events that were told.
    told: u64,
    /// Why images have no time of their own, as far as it was told on this connection.
    told_of_images: Vec<Untimed>,
    waiting: Waiting,
    /// While there is no connection, that is said so often, as a pose that is lost grows old too.
    every_ns: i64,
    next_lost_ns: i64,
    rate: Rate,
}

impl Localizer {
    /// Once round.
    fn turn(&mut self, process: &mut Process) -> Result<(), RunError> {
        let now_ns = process.clock().now_ns();
        let look_ns = now_ns.saturating_add(clock::ns(LOOK_UP));
        let due_ns = self.driver.due_ns().filter(|_| self.link.is_up());
        let until_ns = due_ns.map_or(look_ns, |due_ns| due_ns.min(look_ns));
        let news = self.link.wait(process.clock(), until_ns);
        let came_ns = process.clock().now_ns();
        let is_full = matches!(&news, News::Bytes(bytes) if bytes.len() == CHUNK);
        self.attention.looked(came_ns, is_full);
        let acts = match news {
            News::Nothing => Vec::new(),
            News::Connected => {
                self.clock.reconnected();
                self.told_of_images.clear();
                self.tell(format!("connected with {}", self.spec.address), Level::Info, process)?;
                self.driver.connected(process.clock().now_ns())
            }
            News::Bytes(bytes) => self.driver.bytes(bytes, came_ns),
            News::Closed(why) => vec![Act::Close(why)],
        };
        self.carry_out(acts, process)?;
        self.images.serve_late_joiners();
        let now_ns = process.clock().now_ns();
        let (handed, known) = (self.clock.hand_over(), self.driver.known());
        if let Some(words) = self.memory.keep(&process.run, now_ns, handed, known) {
            self.tell(words, Level::Warning, process)?;
        }
        if self.link.is_up() {
            let acts = self.driver.tick(now_ns);
            self.carry_out(acts, process)?;
        } else if now_ns >= self.next_lost_ns {
            self.next_lost_ns = now_ns.saturating_add(self.every_ns);
            self.output.disconnected(now_ns, process)?;
        }
        Ok(process.beat_with(ProcessState::Ready, || self.words(now_ns))?)
    }

    fn carry_out(&mut self, acts: Vec<Act>, process: &mut Process) -> Result<(), RunError> {
        for act in acts {
            match act {
                Act::Send(bytes) => {
                    if let Err(why) = self.link.send(&bytes) {
                        return self.close(why, process);
                    }
                }
                Act::Frame(frame) => self.publish(&frame, None, process)?,
                Act::Emitters(frame, places) => self.publish(&frame, Some(&places), process)?,
                Act::Image(picture) => self.show(&picture, process)?,
                Act::Tell(words) => self.tell(words, Level::Warning, process)?,
                Act::Refused => process.counters.refused += 1,
                Act::Close(why) => return self.close(why, process),
            }
        }
        Ok(())
    }

    fn publish(&mut self, frame: &Frame, places: Option<&Places>, process: &mut Process) -> Result<(), RunError> {
        let (captured, event) = self.clock.capture(frame);
        let captured = self.attention.judged(captured);
        let lost_ns = clock::ns(process.scene.limits.lost);
        if self.clock.is_again() {
            // No news of a tool: it grows old on the other side.
            return match self.again.came(frame.arrival_ns, lost_ns) {
                Some(words) => self.tell(words, Level::Error, process),
                None => Ok(()),
            };
        }
        self.again.news(frame.arrival_ns);
        match places {
            None if captured.waited_ns > lost_ns => self.output.send(&refused(frame), captured, process)?,
            None => self.output.send(frame, captured, process)?,
            Some(places) => self.output.send_places(frame.device_ns, captured, places, process)?,
        }
        self.link.is_of_use();
        self.rate.count(frame.arrival_ns);
        if let Some(words) = event {
            self.tell(words, Level::Warning, process)?;
        }
        self.tell_of_waiting(frame.arrival_ns, process)
    }

    fn tell_of_waiting(&mut self, now_ns: i64, process: &Process) -> Result<(), RunError> {
        let words = self.clock.waited_words();
        let waited_ns = if words.is_empty() { 0 } else { self.clock.waited_ns() };
        match self.waiting.of(waited_ns, now_ns) {
            None => Ok(()),
            Some(Told::Over) => self.tell("poses wait no longer".to_owned(), Level::Info, process),
            Some(Told::Longer) => {
                let told = format!(
                    "{words} (a queue, or its clock was set): they are counted as that old, and none is shown beyond limits.lost_ms, until the \
                     clock steps forward by as much or somebody who looked at the peer says `pilot restart localizer`"
                );
                self.tell(told, Level::Error, process)
            }
        }
    }

    fn show(&mut self, picture: &Picture, process: &mut Process) -> Result<(), RunError> {
        let time = self.clock.capture_of_image(picture.device_ns, picture.arrival_ns);
        if let Some(by_ns) = time.set_by_ns {
            let by_ms = clock::ms(by_ns);
            let words = format!(
                "the clock of the images was set by {by_ms:.0} ms against that of the poses: a probe's lag that was found before does not hold"
            );
            self.tell(words, Level::Warning, process)?;
        }
        // What is so at the beginning, or as the scene wants it, is in the status alone.
        let is_fault = |why: &Untimed| !matches!(why, Untimed::Wanted | Untimed::NoPoses | Untimed::JustBegun);
        if let Some(why) = time.untimed.filter(is_fault)
            && !self.told_of_images.contains(&why)
        {
            self.told_of_images.push(why);
            self.tell(format!("images timed by arrival: {why}"), Level::Warning, process)?;
        }
        match self.images.show(picture, time, process) {
            Some(words) => self.tell(words, Level::Error, process),
            None => Ok(()),
        }
    }

    /// At once, and not only once the last pose has grown old, it is said that nothing is measured any more.
    fn close(&mut self, why: String, process: &mut Process) -> Result<(), RunError> {
        let now_ns = process.clock().now_ns();
        for act in self.driver.closed(now_ns) {
            match act {
                Act::Tell(words) => self.tell(words, Level::Warning, process)?,
                // Of a connection that is over nothing else is wanted.
                Act::Send(_) | Act::Frame(_) | Act::Emitters(..) | Act::Image(_) | Act::Refused | Act::Close(_) => {}
            }
        }
        self.output.disconnected(now_ns, process)?;
        self.next_lost_ns = now_ns.saturating_add(self.every_ns);
        self.tell(
            format!("the connection with {} is over: {why}", self.spec.address),
            Level::Error,
            process,
        )?;
        self.link.close(why, self.driver.reconnects(), now_ns);
        self.rate = Rate::default();
        Ok(())
    }

    fn tell(&mut self, words: String, level: Level, process: &Process) -> Result<(), RunError> {
        bus::stderr_line!("localizer: {words}");
        let event = Event::new(self.told, process.clock().now_ns(), level, &words);
        self.told += 1;
        Ok(self.events.send(event)?)
    }

    /// What the operator reads of it: what is wrong first, as there is room for little.
    fn words(&self, now_ns: i64) -> String {
        // What a queue was stands there while nobody is connected too: the process that comes next is told by it.
        let waited = self.clock.waited_words();
        if !self.link.is_up() {
            return join([waited, self.link.words(now_ns)]);
        }
        join([
            waited,
            self.driver.wrong(),
            self.again.words(),
            self.rate.words(now_ns),
            self.images.words(now_ns),
            self.clock.words(),
            self.driver.words(),
        ])
    }
}

fn join<const N: usize>(parts: [String; N]) -> String {
    let parts: Vec<String> = parts.into_iter().filter(|words| !words.is_empty()).collect();
    parts.join("; ")
}

/// A frame whose markers may have moved since for longer than a pose is shown.
fn refused(frame: &Frame) -> Frame {
    let mut frame = frame.clone();
    for seen in &mut frame.seen {
        seen.outcome = seen.outcome.and(Err(Lost::Refused));
    }
    frame
}

/// Frames a second.
#[derive(Debug, Default)]
struct Rate {
    began_ns: i64,
    count: u32,
    last: Option<f64>,
}

impl Rate {
    fn count(&mut self, at_ns: i64) {
        let since_ns = at_ns.saturating_sub(self.began_ns);
        if since_ns >= RATE_NS {
            // What came in two seconds or more says nothing of one.
            self.last = (since_ns < 2 * RATE_NS).then(|| f64::from(self.count) * 1e9 / since_ns as f64);
            (self.began_ns, self.count) = (at_ns, 0);
        }
        self.count += 1;
    }

    fn words(&self, now_ns: i64) -> String {
        match self.last {
            _ if now_ns.saturating_sub(self.began_ns) >= 2 * RATE_NS => "nothing comes".to_owned(),
            Some(hz) if hz < 9.5 => format!("{hz:.1} frames/s"),
            Some(hz) => format!("{hz:.0} frames/s"),
            None => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_counted_by_the_second_and_their_absence_is_said() {
        let mut rate = Rate::default();
        (0..300).for_each(|i| rate.count(5 * RATE_NS + i * 16_666_667));
        let now_ns = 10 * RATE_NS;
        assert_eq!(rate.words(now_ns), "60 frames/s");
        assert_eq!(rate.words(now_ns + 3 * RATE_NS), "nothing comes");
    }

    /// A frame each 1.6 s was "1 frames/s".
    #[test]
    fn slow_frames_are_not_rounded_up() {
        let mut rate = Rate::default();
        (0..4).for_each(|i| rate.count(5 * RATE_NS + i * 1_600_000_000));
        assert_eq!(rate.words(10 * RATE_NS), "0.6 frames/s");
    }
}
