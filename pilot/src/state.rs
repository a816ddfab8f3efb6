//! A run that is going: its processes, its ports, its metrics.

use std::cell::Cell;
use std::path::PathBuf;
use std::time::Duration;

use bus::clock::Clock;
use bus::message::{Event, Heartbeat, Level, NOT_RECORDING};
use bus::port::Crowded;
use bus::process::StopFlag;
use bus::run::RunContext;
use bus::session::Session;
use bus::{Bus, BusError};
use guidance::workflow::Rules;
use scene::Scene;
use scene::raw::Source;

use crate::child::Child;
use crate::guiding::{Guiding, Kept};
use crate::kept::KeptVolume;
use crate::metrics::Metrics;
use crate::metrics::presence::Presence;
use crate::output::{RECOMPUTED, SESSION};
use crate::plan::{Poses, add_gateway, add_steps, add_window, plan};
use crate::planning::{Desk, PlanStore};
use crate::ports::Ports;
use crate::remote::Remote;
use crate::replay::{Recompute, Recomputed, Replay};
use crate::report::Pictures;
use crate::supervise::Supervisor;

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
    /// The operator's window is a process of the run.
    pub(crate) has_window: bool,
    /// What is replayed; `None`: the run navigates.
    pub(crate) replay: Option<Replay>,
    /// The run of another machine that is shown; `None`: this machine's own.
    pub(crate) remote: Option<Remote>,
    /// The plan that is made; `None`: the run navigates.
    pub(crate) planning: Option<PlanStore>,
}

impl Options {
    /// Who says what is aimed at and how far the run has come.
    pub(crate) fn kept(&self) -> Kept {
        match (&self.replay, &self.remote) {
            (Some(_), _) => Kept::Recorded,
            (None, Some(_)) => Kept::Elsewhere,
            (None, None) => Kept::Here,
        }
    }

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
                "the recorder counts {lost} messages (poses, true poses, frames of the localizer, images of a probe, states of tissue) that are in none of its files{first}"
            )
        })
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
    /// In the order of the plan, in which the supervisor counts them too.
    pub(crate) children: Vec<Child>,
    pub(crate) supervisor: Supervisor,
    /// Whether the pilot itself stood still.
    pub(crate) presence: Presence,
    /// Messages that came while the recorder could not write, or that were in files that somebody removed.
    pub(crate) unrecorded: Unrecorded,
    pub(crate) ports: Ports,
    pub(crate) metrics: Metrics,
    /// What a person chose, and how far the run has come.
    pub(crate) guiding: Guiding,
    /// The plan that is made, in a run for that.
    pub(crate) desk: Option<Desk>,
    /// For renderers and trackers that start while no loader serves the run.
    pub(crate) kept: KeptVolume,
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
    /// A person has looked at the localizer's peer: the next process is to forget what the one before knew of it.
    pub(crate) localizer_anew: bool,
    /// In simulated time: the newest sample, and when it was first seen.
    pub(crate) newest_came: (Option<u64>, i64),
}

impl Run {
    /// Plans the processes of `scene` and opens the ports; nothing is started yet. `rules` are those of the workflow.
    pub(crate) fn new(
        options: Options,
        source: Source,
        scene: Scene,
        context: RunContext,
        bus: Bus,
        stop: StopFlag,
        rules: Rules,
    ) -> Result<Self, BusError> {
        let recording = options.out.join(options.recording());
        let recording = std::path::absolute(&recording).unwrap_or(recording);
        let replayer = options
            .replay
            .as_ref()
            .map(|replay| replay.arguments(&options.out, options.has_window));
        let receiver = options.remote.as_ref().map(Remote::arguments);
        let poses = match (&options.replay, &replayer, &receiver) {
            (
                Some(Replay {
                    recompute: Some(again), ..
                }),
                Some(arguments),
                _,
            ) => match again.frames {
                Some(_) => Poses::MadeAgain(arguments),
                None => Poses::Answered(arguments),
            },
            (_, Some(arguments), _) => Poses::Replayed(arguments),
            (_, _, Some(arguments)) => Poses::Remote(arguments),
            _ => Poses::Tracked,
        };
        let out = std::path::absolute(&options.out).unwrap_or_else(|_| options.out.clone());
        let mut planned = plan(&scene, &recording.to_string_lossy(), poses);
        // In a recording and on another machine all that has been done, and simulated time waits for nobody's hand.
        if options.replay.is_none() && options.remote.is_none() && options.planning.is_none() && !context.simulated_time
        {
            add_steps(&mut planned, &scene, &out);
        }
        // Also in a replay, which says so to every client; a plan has no tool to be looked at.
        if options.planning.is_none() {
            add_gateway(&mut planned, &scene);
        }
        if options.has_window {
            add_window(&mut planned, &out);
        }
        let roles = planned.iter().map(|p| p.role.clone()).collect();
        Ok(Self {
            ports: Ports::open(&bus, &context, &scene, &planned)?,
            guiding: Guiding::open(&bus, &scene, rules, options.kept())?,
            desk: options
                .planning
                .clone()
                .map(|store| Desk::open(&bus, store))
                .transpose()?,
            supervisor: Supervisor::new(roles, scene.limits.clone()),
            presence: Presence::default(),
            unrecorded: Unrecorded::default(),
            metrics: Metrics::new(scene.views.len()),
            kept: KeptVolume::default(),
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
            localizer_anew: false,
            newest_came: (None, 0),
            session: Session::open(&bus, &context)?,
            pictures: None,
            recomputed: None,
            options,
            source,
            scene,
            context,
            bus,
            children: planned.into_iter().map(Child::new).collect(),
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

    /// The place of a process in the plan.
    pub(crate) fn place_of(&self, name: &str) -> Option<usize> {
        self.children.iter().position(|child| child.name() == name)
    }

    /// The names of processes that ended too often and are left alone.
    pub(crate) fn held(&self) -> impl Iterator<Item = &str> {
        self.children.iter().filter(|child| child.is_held).map(Child::name)
    }

    /// Process `i` says this of itself.
    pub(crate) fn noted(&mut self, i: usize, note: String) {
        let child = &self.children[i];
        if child.has_given_up_a_card(&note) && !child.has_given_up_a_card(&child.note) {
            let words = format!("{}: {note}", self.children[i].name());
            self.tell(Level::Warning, &words);
            self.cards_given_up.push(words);
        }
        let older_ms = self.children[i].older_ms(&note).unwrap_or(0);
        self.metrics.older_ms = self.metrics.older_ms.max(older_ms);
        self.children[i].note = note;
    }

    /// Asks who takes the places of the run's topics, and tells of each topic once.
    pub(crate) fn look_for_crowds(&mut self) {
        self.crowded = self.ports.services.crowded();
        for crowded in self.crowded.clone() {
            if self.crowds.iter().all(|known| known.service != crowded.service) {
                bus::stderr_line!("pilot: warning: {crowded}: a process that is started again may find none");
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
        self.metrics.newest_pose().map_or(0, |p| p.seq)
    }
}
