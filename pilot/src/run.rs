//! One run, from the first process to the last.

use std::ops::ControlFlow;
use std::time::Duration;

use bus::clock::{self, monotonic_ns};
use bus::message::{Command, CommandKind, FrameState, Level, ProcessState};
use bus::port::CommandServer;
use bus::process::{JoinError, StopFlag};
use bus::run::{RunContext, RunError as FolderError, RunLock, run_dir};
use bus::session::SIMULATED_START_NS;
use bus::wake::Waits;
use bus::{Bus, BusError};
use guidance::workflow::RulesError;
use scene::Scene;
use scene::raw::Source;

use crate::guiding;
use crate::metrics::{Judging, Place, Restart};
use crate::output::{self, OutputError};
use crate::plan::{LOCALIZER, REPLAYER};
use crate::ports;
use crate::remote::Remote;
use crate::replay::{RecomputeError, Replay};
use crate::report::Report;
use crate::shutdown;
use crate::spawn::{self, RunOfProcess, Running, SpawnError};
use crate::state::{Options, Run};
use crate::supervise::{Action, Ending, Event, KillReason, Outcome};

const TICK: Duration = Duration::from_millis(10);
/// From when everybody is ready to the tracker's first sample: time for it to hear of that.
const LEAD: Duration = Duration::from_millis(250);
/// How long a renderer may take to show that there is no pose.
const SHOWING: Duration = Duration::from_millis(250);
/// How often the places of clients that died are freed; those of the run's own processes are as soon as they end.
const CLEANING: Duration = Duration::from_secs(1);
/// Requests answered in one turn; more of them wait for the next, so that no client can keep the pilot from its watch.
const REQUESTS: usize = 4;

/// Why a run failed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunError {
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error(transparent)]
    Output(#[from] OutputError),
    #[error(transparent)]
    Join(#[from] JoinError),
    #[error(transparent)]
    Bus(#[from] BusError),
    #[error(transparent)]
    Spawn(#[from] SpawnError),
    #[error(transparent)]
    Recompute(#[from] RecomputeError),
    #[error(transparent)]
    Rules(#[from] RulesError),
    #[error("{0} could not be started, for the reason given above; nothing was navigated and no picture written")]
    Refused(String),
}

/// Runs a scene to its end.
pub(crate) fn run(options: Options, source: Source, scene: Scene) -> Result<Report, RunError> {
    let dir = run_dir(&options.run)?;
    let _lock = RunLock::acquire(&dir)?;
    let epoch_ns = options.remote.as_ref().map_or_else(monotonic_ns, Remote::epoch_ns);
    let mut context = RunContext::new(&dir, epoch_ns)?;
    context.remote = options.remote.as_ref().map(Remote::of);
    context.replay = options.replay.as_ref().map(Replay::of);
    context.duration_ns = options.duration.map(clock::ns);
    context.simulated_time = options.simulated_time;
    context.planning = options.planning.is_some();
    // Who plans writes a plan and no pictures of a session.
    let replaced = match &options.planning {
        None => output::prepare(&options.out, &shutdown::picture_names(&scene), options.overwrite)?,
        Some(_) => output::Replaced::default(),
    };
    // With the lock held, facts and whatever bears this run's prefix are left over from a pilot that was killed.
    context.remove_facts();
    context.sweep();
    let result = run_locked(options, source, scene, &context);
    context.sweep();
    context.remove_facts();
    match &result {
        Ok(_) => replaced.discard(),
        Err(_) => replaced.restore(),
    }
    result
}

fn run_locked(options: Options, source: Source, scene: Scene, context: &RunContext) -> Result<Report, RunError> {
    if let Some((_, recompute)) = options.recompute() {
        recompute.write_files()?;
    }
    let scene_text = source.to_toml();
    context.store_scene(&scene_text)?;
    let rules = guiding::rules(&scene, options.kept())?;
    let stop = StopFlag::install(false)?;
    let bus = Bus::keep(context)?;
    let server = ports::server(&bus)?;
    let mut run = Run::new(options, source, scene, context.clone(), bus, stop, rules)?;
    // Last, so that whoever finds this file finds the run on the bus.
    context.store()?;
    run.facts = context.facts_hash(&scene_text);
    let waits = Waits::every(TICK).request(&server);
    let outcome = waits.run(|| match run.turn(&server) {
        Ok(None) => ControlFlow::Continue(()),
        Ok(Some(outcome)) => ControlFlow::Break(Ok(outcome)),
        Err(error) => ControlFlow::Break(Err(error)),
    })??;
    drop(server);
    if let Outcome::Refused(i) = outcome {
        shutdown::remove_recordings(&run.options);
        return Err(RunError::Refused(run.children[i].name().to_owned()));
    }
    run.recomputed = shutdown::compare_recomputed(&run.options);
    let mut report = shutdown::report(&run);
    if run.options.planning.is_some() {
        return Ok(report);
    }
    match report.write(&run.options.out) {
        Ok(()) => shutdown::attach_report(&run.options),
        // The terminal still says how the run went.
        Err(error) => report.problems.push(error.to_string()),
    }
    Ok(report)
}

impl Run {
    /// Once round: take in what happened, decide, act.
    fn turn(&mut self, server: &CommandServer) -> Result<Option<Outcome>, RunError> {
        self.look_at_oneself();
        // The tick comes last: whoever gave a sign of life meanwhile is not silent.
        let mut events = self.beats()?;
        events.extend(self.endings());
        let now = self.clock().now_ns();
        if now >= self.next_cleaning_ns {
            self.clean(now);
        }
        events.push(Event::Tick);
        self.listen()?;
        self.ports.events.serve_late_joiners();
        self.guide()?;
        for event in events {
            if let Some(outcome) = self.step(event)? {
                return Ok(Some(outcome));
            }
        }
        // Answered after the events are taken in, so that a status never shows a dead process as ready.
        self.tell_taken()?;
        let mut stop = self.stop.is_set() || self.time_is_up() || self.replay_has_ended() || self.replay_is_stuck();
        self.tell_progress();
        for _ in 0..REQUESTS {
            let Some(request) = server.next()? else { break };
            if let Some(event) = self.answer(request)? {
                self.step(event)?;
            }
        }
        stop |= self.asked_to_stop;
        if stop {
            // What has gone out by now counts.
            self.listen()?;
            self.take_pictures();
            return self.step(Event::Stop);
        }
        Ok(None)
    }

    /// A pilot that stood still says so, and blames nobody else for it.
    fn look_at_oneself(&mut self) {
        let silent_ns = clock::ns(self.scene.limits.silent);
        // As the supervisor does.
        let Some(away_ns) = self.presence.turn(self.clock().now_ns(), silent_ns / 4) else {
            return;
        };
        for child in &mut self.children {
            child.standstill.forgive(away_ns);
        }
        if away_ns > silent_ns {
            let words = self.presence.stood_still(away_ns);
            bus::stderr_line!("pilot: {words}");
            self.tell(Level::Error, &words);
        }
    }

    /// Tells the supervisor and does what it decides.
    fn step(&mut self, event: Event) -> Result<Option<Outcome>, RunError> {
        let now = self.clock().now_ns();
        for action in self.supervisor.step(event, now) {
            if let Some(outcome) = self.act(action)? {
                return Ok(Some(outcome));
            }
        }
        Ok(None)
    }

    /// Signs of life of the processes that were started last; those of their predecessors do not count.
    fn beats(&mut self) -> Result<Vec<Event>, RunError> {
        let mut events = Vec::new();
        for i in 0..self.children.len() {
            if self.children[i].running.as_mut().is_some_and(Running::gave_sign) {
                events.push(Event::Beat(i, ProcessState::Starting));
            }
            let Some(beat) = self.ports.beats[i].newest()? else {
                continue;
            };
            if self.children[i].running.as_ref().map(Running::pid) != Some(beat.pid) {
                continue;
            }
            self.noted(i, beat.note_text());
            if self.children[i].name() == LOCALIZER && beat.process_state() == ProcessState::Ready {
                self.localizer_anew = false;
            }
            if self.children[i].name() == "recorder" {
                self.unrecorded.heard(&beat);
            }
            self.children[i].standstill.heard(&beat);
            if self.children[i].name() == "tracker" {
                // Its poses have gone out before, and are taken in before this is looked at.
                self.tracker_is_done = beat.process_state() == ProcessState::Stopping;
            }
            let state = beat.process_state();
            if state == ProcessState::Ready
                && self.children[i].planned.views.is_empty()
                && self.children[i].name() != "tracker"
            {
                self.metrics.live_again(self.children[i].name(), beat.t_ns);
            }
            events.push(Event::Beat(i, state));
        }
        Ok(events)
    }

    /// Frees the places of processes that died: the run's own, and clients.
    fn clean(&mut self, now: i64) {
        self.next_cleaning_ns = now + clock::ns(CLEANING);
        self.dead_processes_left = self.bus.remove_dead_processes();
        self.look_for_crowds();
    }

    fn endings(&mut self) -> Vec<Event> {
        let now = self.clock().now_ns();
        let mut events = Vec::new();
        for i in 0..self.children.len() {
            let Some(ending) = self.children[i].running.as_mut().and_then(Running::ending) else {
                continue;
            };
            self.children[i].running = None;
            self.children[i].standstill.ended(now);
            // Before it is started again, so that its places are free at once.
            self.clean(now);
            self.note_ending(i, ending, now);
            events.push(Event::Ended(i, ending));
        }
        events
    }

    /// Writes an unexpected ending into the metrics.
    fn note_ending(&mut self, i: usize, ending: Ending, now: i64) {
        let cause = match (self.children[i].kill_cause.take(), ending) {
            (Some(KillReason::Silent), _) => "gave no sign of life".to_owned(),
            (Some(KillReason::SlowStart), _) => "was not ready in time".to_owned(),
            (Some(KillReason::SlowStop), _) => "did not stop in time".to_owned(),
            (Some(KillReason::Asked), _) => Restart::ASKED.to_owned(),
            (None, Ending::Signal(signal)) => format!("killed by signal {signal}"),
            (None, Ending::Code(code)) => format!("exit code {code}"),
        };
        if !matches!(self.supervisor.stage_word(i), "ready" | "starting") {
            return;
        }
        // Whoever asks for it has looked at the peer.
        if self.children[i].name() == LOCALIZER && cause == Restart::ASKED {
            self.localizer_anew = true;
        }
        let name = self.children[i].name().to_owned();
        bus::stderr_line!("pilot: {name} ended ({cause})");
        self.tell(Level::Error, &format!("{name} ended ({cause})"));
        self.metrics.restarts.push(Restart {
            process: name,
            cause,
            at_s: clock::ms(now - self.began_ns.unwrap_or(now)) / 1e3,
            live_again_s: None,
            at_ns: now,
        });
    }

    /// Says what has become of the workflow and of what a person chose.
    fn guide(&mut self) -> Result<(), BusError> {
        if let Some(desk) = &mut self.desk {
            desk.serve_late_joiners();
            desk.look(self.session.clock().now_ns())?;
        }
        for words in self.guiding.turn(self.session.clock().now_ns())? {
            self.tell(Level::Info, &words);
        }
        Ok(())
    }

    /// Takes in volumes, poses and stamps.
    fn listen(&mut self) -> Result<(), RunError> {
        if let Some(volume) = self.ports.volume.poll()? {
            self.metrics.volume(*volume.header());
            // The first is the run's: who shows images shows no other.
            if let Some(hash) = self.metrics.volume_hash() {
                self.guiding.volume(hash);
                let now_ns = self.session.clock().now_ns();
                self.desk.iter_mut().try_for_each(|desk| desk.volume(hash, now_ns))?;
            }
            self.kept.published(&volume);
        }
        // Before the poses: one that goes out behind a jump comes after it here too, and that of an end has come.
        if self.session.follow()? {
            self.metrics.jumped();
        }
        while let Some(pose) = self.ports.poses.next()? {
            // It may have come behind a jump that was not there yet.
            if self.session.follow()? {
                self.metrics.jumped();
                if self.session.is_yet_to_come(pose.t_publish_ns) {
                    continue;
                }
            }
            if self.is_beyond(&pose) {
                continue;
            }
            // Stamps of a replay or of another machine are those of another run, and those of simulated time no clock's.
            let published_ns = match self.session.is_ruled() || self.session.is_remote() {
                true => self.bus.clock().now_ns(),
                false => pose.t_publish_ns,
            };
            self.metrics.live_again("tracker", published_ns);
            // Poses that came just before a replay went back are ahead of its clock by now; who draws them judges that.
            let now_ns = match self.session.is_ruled() {
                true => i64::MAX,
                false => self.session.clock().now_ns(),
            };
            let place = self.session.replay().filter(|_| self.session.is_replay());
            let by = Judging {
                now_ns,
                frozen_ns: self.scene.frozen().map(clock::ns),
                replay: place.map(|law| Place {
                    first_ns: law.first_ns,
                    set_ns: law.anchor_ns,
                }),
            };
            self.metrics.pose(pose, by);
            if let Some((pose, tracked)) = self.metrics.newest() {
                self.guiding.pose(pose, tracked);
            }
        }
        let stale_ns = clock::ns(self.scene.limits.stale);
        for (process, stamps) in &self.ports.stamps {
            while let Some(stamp) = stamps.next()? {
                self.metrics.frame(&stamp, stale_ns);
                // What a process that died had drawn says nothing of the one that follows on it.
                let runs = self.children[*process].running.is_some();
                if runs && stamp.frame_state() == Some(FrameState::Live) {
                    let at_ns = match self.session.is_ruled() || self.session.is_remote() {
                        true => self.bus.clock().now_ns(),
                        false => stamp.t_framed_ns,
                    };
                    self.metrics.live_again(self.children[*process].name(), at_ns);
                }
            }
        }
        Ok(())
    }

    /// Once, before anything is stopped.
    fn take_pictures(&mut self) {
        if self.pictures.is_none() && self.began_ns.is_some() && self.desk.is_none() {
            self.tell(
                Level::Info,
                &format!("ending: the pictures show pose {}", self.last_seq()),
            );
            self.pictures = Some(shutdown::take_pictures(self));
            // Renderers take their time.
            self.presence.was_at_work(self.bus.clock().now_ns());
        }
    }

    fn act(&mut self, action: Action) -> Result<Option<Outcome>, RunError> {
        match action {
            Action::Start(i) => self.start(i)?,
            Action::Terminate(i) => {
                if let Some(running) = &self.children[i].running {
                    running.terminate();
                }
            }
            Action::Kill(i, reason) => {
                self.children[i].kill_cause = Some(reason);
                if let Some(running) = &mut self.children[i].running {
                    running.kill();
                }
            }
            Action::GaveUp(i) => {
                let name = self.children[i].name().to_owned();
                let words = format!("{name} ended too often and is not started again");
                bus::stderr_line!("pilot: {words}");
                self.tell(Level::Error, &words);
                self.children[i].is_held = true;
                if name == "tracker" {
                    self.show_no_pose();
                }
            }
            Action::AllReady => self.all_ready()?,
            Action::Finished(outcome) => return Ok(Some(outcome)),
        }
        Ok(None)
    }

    /// Nobody publishes poses any more: the images are not left to grow old. Who does not answer shows none in a moment anyway.
    fn show_no_pose(&self) {
        for (_, renderer) in &self.ports.renderers {
            let _ = renderer.ask(Command::new(CommandKind::NoPoses), SHOWING);
        }
    }

    fn start(&mut self, i: usize) -> Result<(), RunError> {
        let mut more = Vec::new();
        // The first one is told when everybody, itself included, is ready; one that follows on it goes on with its samples.
        if let ("tracker", Some(began)) = (self.children[i].name(), self.began_ns) {
            more = match self.options.simulated_time {
                true => vec!["--start-ns".to_owned(), SIMULATED_START_NS.to_string()],
                false => vec!["--start-ns".to_owned(), began.to_string()],
            };
            if let (true, Some(pose)) = (self.options.simulated_time, self.metrics.newest_pose()) {
                more.extend(["--after-ns".to_owned(), pose.t_publish_ns.to_string()]);
            }
        }
        // What one that died knew of the peer is not forgotten with it, unless a person says so.
        if self.children[i].name() == LOCALIZER && self.localizer_anew {
            more = vec!["--anew".to_owned()];
        }
        // A replayer that died is followed by one that goes on where it was.
        if self.children[i].name() == REPLAYER
            && let Some(pose) = self.metrics.newest_pose()
        {
            more = vec!["--begin-ns".to_owned(), pose.t_publish_ns.to_string()];
        }
        let told = RunOfProcess {
            run_dir: &self.context.dir,
            facts: &self.facts,
            volume: self.kept.for_process(&self.children[i].planned),
        };
        let running = spawn::start(&self.children[i].planned, told, &more)?;
        self.tell(
            Level::Info,
            &format!("started {} (process {})", self.children[i].name(), running.pid()),
        );
        self.children[i].running = Some(running);
        if self.children[i].name() == "recorder" {
            self.unrecorded.before += std::mem::take(&mut self.unrecorded.now);
        }
        Ok(())
    }

    fn all_ready(&mut self) -> Result<(), FolderError> {
        let now = self.bus.clock().now_ns();
        let lead = match self.place_of("tracker").is_some() {
            true => clock::ns(LEAD),
            false => 0,
        };
        let began_ns = *self.began_ns.get_or_insert(now + lead);
        self.context.begin(match self.options.simulated_time {
            true => SIMULATED_START_NS,
            false => began_ns,
        })?;
        let ending = self.options.ending();
        let words = format!("everybody ready after {:.2} s; {ending}", clock::ms(now) / 1e3);
        bus::stderr_line!("pilot: {words}");
        self.tell(Level::Info, &words);
        Ok(())
    }
}
