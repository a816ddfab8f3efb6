//! A run that is going: its processes, its ports, its books.

use std::cell::Cell;
use std::path::PathBuf;
use std::time::Duration;

use bus::clock::Clock;
use bus::message::{Event, GPU_GIVEN_UP, Heartbeat, Level, ProcessState};
use bus::port::Crowded;
use bus::process::StopFlag;
use bus::run::RunContext;
use bus::session::Session;
use bus::{Bus, BusError};
use scene::Scene;
use scene::raw::Source;

use crate::books::Books;
use crate::kept::KeptVolume;
use crate::output::{RECOMPUTED, SESSION};
use crate::plan::{Planned, Poses, plan};
use crate::ports::Ports;
use crate::replay::{Recompute, Recomputed, Replay};
use crate::report::Pictures;
use crate::spawn::Running;
use crate::supervise::{KillReason, Supervisor};

/// What the user asked for.
#[derive(Debug, Clone)]
pub(crate) struct Options {
    pub(crate) run: String,
    pub(crate) out: PathBuf,
    pub(crate) overwrite: bool,
    /// `None`: until stopped.
    pub(crate) duration: Option<Duration>,
    /// As fast as every view draws every pose, in simulated time.
    pub(crate) simulated_time: bool,
    /// What is replayed; `None`: the run navigates.
    pub(crate) replay: Option<Replay>,
}

impl Options {
    /// The file name of what this run records.
    pub(crate) fn recording(&self) -> &'static str {
        match self.recompute() {
            Some(_) => RECOMPUTED,
            None => SESSION,
        }
    }

    /// The recording whose poses are made again, and with what.
    pub(crate) fn recompute(&self) -> Option<(&Replay, &Recompute)> {
        let replay = self.replay.as_ref()?;
        Some((replay, replay.recompute.as_ref()?))
    }
}

/// How a recorder's words begin while it cannot write.
pub(crate) const NOT_RECORDING: &str = "NOT RECORDING";

/// What the recorder, and those that it followed on, counted as not recorded.
#[derive(Debug, Clone, Default)]
pub(crate) struct Unrecorded {
    pub(crate) before: u64,
    pub(crate) now: u64,
    /// What the first of them said when it first could not write.
    pub(crate) why: Option<String>,
}

impl Unrecorded {
    /// Takes in what the recorder says.
    pub(crate) fn heard(&mut self, beat: &Heartbeat) {
        self.now = beat.counters.lost;
        let words = beat.note_text();
        if self.why.is_none() && words.starts_with(NOT_RECORDING) {
            self.why = Some(words);
        }
    }

    /// What that is as a problem.
    pub(crate) fn words(&self) -> Option<String> {
        let lost = self.before + self.now;
        let first = self
            .why
            .as_ref()
            .map_or(String::new(), |why| format!("; it first said: {why}"));
        (lost > 0 || self.why.is_some()).then(|| {
            format!(
                "the recorder counts {lost} messages (poses, true poses, frames of emitters) that are in none of its files{first}"
            )
        })
    }
}

/// For how long the work of a process has said nothing, while another thread of it may have given signs of life.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Standstill {
    /// When it spoke last; `None`: it has not yet, or is ending.
    last_ns: Option<i64>,
    pub(crate) longest_ns: i64,
}

impl Standstill {
    /// Its work has spoken. One that is ending may take its time.
    pub(crate) fn heard(&mut self, beat: &Heartbeat) {
        self.ended(beat.t_ns);
        self.last_ns = (beat.process_state() != ProcessState::Stopping).then_some(beat.t_ns);
    }

    /// It says nothing more: a standstill that nobody saw the end of counts too.
    pub(crate) fn ended(&mut self, now_ns: i64) {
        self.longest_ns = self.longest_ns.max(self.so_far_ns(now_ns));
        self.last_ns = None;
    }

    /// For how long it has said nothing by now.
    pub(crate) fn so_far_ns(&self, now_ns: i64) -> i64 {
        self.last_ns.map_or(0, |last_ns| now_ns.saturating_sub(last_ns))
    }
}

/// A run that is going.
pub(crate) struct Run {
    pub(crate) options: Options,
    pub(crate) source: Source,
    pub(crate) scene: Scene,
    pub(crate) context: RunContext,
    /// The hash of its files, once they are written.
    pub(crate) facts: String,
    pub(crate) bus: Bus,
    /// Poses and images are as old as its clock says.
    pub(crate) session: Session,
    pub(crate) planned: Vec<Planned>,
    pub(crate) supervisor: Supervisor,
    pub(crate) running: Vec<Option<Running>>,
    /// What each process said of itself last.
    pub(crate) notes: Vec<String>,
    /// For how long the work of each has said nothing: a disk may make a recorder wait.
    pub(crate) standstills: Vec<Standstill>,
    /// Messages that came while the recorder could not write, or that were in files that somebody removed.
    pub(crate) unrecorded: Unrecorded,
    pub(crate) ports: Ports,
    pub(crate) books: Books,
    /// For renderers and trackers that start while no loader serves the run.
    pub(crate) kept: KeptVolume,
    /// Causes of kills, so that a restart can say why.
    pub(crate) kill_causes: Vec<Option<KillReason>>,
    pub(crate) held: Vec<String>,
    /// The moment of sample 0, once everybody is ready.
    pub(crate) began_ns: Option<i64>,
    pub(crate) pictures: Option<Pictures>,
    /// What came of poses that were made again, once everybody has ended.
    pub(crate) recomputed: Option<Recomputed>,
    pub(crate) stop: StopFlag,
    /// How many events were told.
    pub(crate) events: Cell<u64>,
    pub(crate) next_progress_ns: i64,
    pub(crate) next_cleaning_ns: i64,
    /// Dead processes whose places could not be freed at the last cleaning.
    pub(crate) dead_processes_left: u64,
    /// Services with hardly a place left at the last look, and the first crowd that each service has seen.
    pub(crate) crowded: Vec<Crowded>,
    pub(crate) crowds: Vec<Crowded>,
    /// Graphics cards that are used no more, with the renderer and why.
    pub(crate) cards_given_up: Vec<String>,
    /// The tracker has said that the time is over, and all its poses have come.
    pub(crate) tracker_is_done: bool,
    /// `pilot stop` came.
    pub(crate) asked_to_stop: bool,
    /// In simulated time: the newest sample, and when it was first seen.
    pub(crate) newest_came: (Option<u64>, i64),
}

impl Run {
    /// Plans the processes of `scene` and opens the ports; nothing is started yet.
    pub(crate) fn new(
        options: Options,
        source: Source,
        scene: Scene,
        context: RunContext,
        bus: Bus,
        stop: StopFlag,
    ) -> Result<Self, BusError> {
        let recording = options.out.join(options.recording());
        let recording = std::path::absolute(&recording).unwrap_or(recording);
        let replayer = options.replay.as_ref().map(|replay| replay.arguments(&options.out));
        let poses = match (&options.replay, &replayer) {
            (Some(Replay { recompute: Some(_), .. }), Some(arguments)) => Poses::MadeAgain(arguments),
            (_, Some(arguments)) => Poses::Replayed(arguments),
            _ => Poses::Tracked,
        };
        let planned = plan(&scene, &recording.to_string_lossy(), poses);
        let roles = planned.iter().map(|p| p.role.clone()).collect();
        Ok(Self {
            ports: Ports::open(&bus, &context, &scene, &planned)?,
            supervisor: Supervisor::new(roles, scene.limits.clone()),
            running: planned.iter().map(|_| None).collect(),
            notes: vec![String::new(); planned.len()],
            standstills: vec![Standstill::default(); planned.len()],
            unrecorded: Unrecorded::default(),
            kill_causes: vec![None; planned.len()],
            books: Books::new(scene.views.len()),
            kept: KeptVolume::default(),
            held: Vec::new(),
            began_ns: None,
            next_progress_ns: 0,
            next_cleaning_ns: 0,
            facts: String::new(),
            dead_processes_left: 0,
            crowded: Vec::new(),
            crowds: Vec::new(),
            cards_given_up: Vec::new(),
            tracker_is_done: false,
            asked_to_stop: false,
            newest_came: (None, 0),
            session: Session::open(&bus, &context)?,
            pictures: None,
            recomputed: None,
            options,
            source,
            scene,
            context,
            bus,
            planned,
            stop,
            events: Cell::new(0),
        })
    }

    /// Tells what happened, for the recording. A navigation goes on where nobody can be told.
    pub(crate) fn tell(&self, level: Level, words: &str) {
        let seq = self.events.replace(self.events.get() + 1);
        let event = Event::new(seq, self.clock().now_ns(), level, words);
        let _ = self.ports.events.send(event);
    }

    /// Process `i` says this of itself.
    pub(crate) fn noted(&mut self, i: usize, note: String) {
        if note.contains(GPU_GIVEN_UP) && !self.notes[i].contains(GPU_GIVEN_UP) {
            let words = format!("{}: {note}", self.planned[i].name);
            self.tell(Level::Warning, &words);
            self.cards_given_up.push(words);
        }
        self.notes[i] = note;
    }

    /// Asks who takes the places of the run's topics, and tells of each topic once.
    pub(crate) fn look_for_crowds(&mut self) {
        self.crowded = self.ports.services.crowded();
        for crowded in self.crowded.clone() {
            if self.crowds.iter().all(|known| known.service != crowded.service) {
                bus::say!("pilot: warning: {crowded}: a process that is started again may find none");
                self.tell(Level::Warning, &crowded.to_string());
                self.crowds.push(crowded);
            }
        }
    }

    /// The run's clock.
    pub(crate) fn clock(&self) -> &Clock {
        self.bus.clock()
    }

    /// The sample that the pictures show, if it is valid: the newest. In a timed run the tracker publishes none beyond its time.
    pub(crate) fn last_seq(&self) -> u64 {
        self.books.newest_pose().map_or(0, |p| p.seq)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::message::Counters;

    #[test]
    fn a_standstill_that_nobody_saw_the_end_of_counts_and_an_ending_is_none() {
        let beat = |state, t_ns| Heartbeat::new(state, t_ns, Counters::default(), "");
        let mut work = Standstill::default();
        assert_eq!(work.so_far_ns(1_000), 0, "it has not spoken yet");
        work.heard(&beat(ProcessState::Ready, 100));
        work.heard(&beat(ProcessState::Ready, 350));
        assert_eq!((work.longest_ns, work.so_far_ns(400)), (250, 50));
        work.ended(5_350);
        assert_eq!((work.longest_ns, work.so_far_ns(9_000)), (5_000, 0));
        work.heard(&beat(ProcessState::Stopping, 10_000));
        work.ended(90_000);
        assert_eq!(work.longest_ns, 5_000);
    }
}
