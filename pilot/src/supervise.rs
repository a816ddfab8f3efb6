//! Supervision as a pure function: `step(event, now) -> actions`.
//!
//! The supervisor knows processes by number, what must be ready before each starts, and in which rank each stops. It
//! never blocks and never touches the system: what it decides is carried out by its caller, and what happens comes back
//! as events.
//!
//! Policy:
//! * A process that ends with a refusal (exit code not 0) before it was ever ready would refuse again: the run fails.
//! * One that ends in any other way is started again: at once the first time, then after 100 ms, 200 ms, ... up to 2 s.
//! * More than `restarts` of them within `restart_window`, and it is held: the others go on without it. If it was never
//!   ready there is nothing to go on with: the run fails.
//! * Time in which the supervisor itself was not called (a machine that stood still) counts against nobody.
//! * One that gives no sign of life for `silent` after its first, or is not ready after `start`, is killed, and then the above
//!   applies. A machine that is slow to load a program says nothing of the program.
//! * Stopping goes by rank; who does not end within `stop` is killed.

use std::time::Duration;

use bus::clock::ns;
use bus::message::ProcessState;
use scene::Limits;

const FIRST_BACK_OFF: Duration = Duration::from_millis(100);
const LONGEST_BACK_OFF: Duration = Duration::from_secs(2);

/// What the supervisor must know of a process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Role {
    /// Starts once these have been ready.
    pub after: Vec<usize>,
    /// Is asked to stop once everybody of lower rank has ended.
    pub stop_rank: u8,
}

/// How a process ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Exit code.
    Code(i32),
    /// Killed by this signal.
    Signal(i32),
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A process gave a sign of life.
    Beat(usize, ProcessState),
    /// A process ended.
    Ended(usize, Ending),
    /// Somebody wants a process back that is held, or another one in the place of one that is ready.
    Restart(usize),
    /// Somebody wants the run to stop.
    Stop,
    /// Time went by.
    Tick,
}

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Start this process.
    Start(usize),
    /// Ask it to end.
    Terminate(usize),
    /// End it.
    Kill(usize, KillReason),
    /// Say that this process is not restarted any more.
    GaveUp(usize),
    /// Everybody is ready for the first time.
    AllReady,
    /// Nothing is running any more.
    Finished(Outcome),
}

/// Why a process is killed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KillReason {
    /// No sign of life.
    Silent,
    /// Not ready in time.
    SlowStart,
    /// Did not end when asked.
    SlowStop,
    /// A person wants another one in its place.
    Asked,
}

/// How the run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// As asked.
    Stopped,
    /// This process could not be started; the reason is on stderr.
    Refused(usize),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Waits for others to be ready.
    Waiting,
    /// Started, not ready.
    Starting { since: i64 },
    /// Does its work.
    Ready,
    /// Is started again at this time.
    BackOff { until: i64 },
    /// Not restarted any more.
    GivenUp,
    /// Was asked to end.
    Ending { since: i64 },
    /// Has ended, or never started.
    Ended,
}

#[derive(Debug, Clone)]
struct Member {
    role: Role,
    stage: Stage,
    was_ready: bool,
    killed: bool,
    /// `None`: it has given no sign of life since it was started.
    last_beat: Option<i64>,
    restarts: Vec<i64>,
}

/// The state of all processes of a run.
#[derive(Debug, Clone)]
pub struct Supervisor {
    members: Vec<Member>,
    limits: Limits,
    stopping: Option<Outcome>,
    all_ready: bool,
    finished: bool,
    last_step: Option<i64>,
}

impl Supervisor {
    /// Nothing is started yet; the first [`Event::Tick`] does that.
    pub fn new(roles: Vec<Role>, limits: Limits) -> Self {
        let member = |role| Member {
            role,
            stage: Stage::Waiting,
            was_ready: false,
            killed: false,
            last_beat: None,
            restarts: Vec::new(),
        };
        Self {
            members: roles.into_iter().map(member).collect(),
            limits,
            stopping: None,
            all_ready: false,
            finished: false,
            last_step: None,
        }
    }

    /// Takes in what happened at `now` (ns on the run's clock) and says what is to be done.
    pub fn step(&mut self, event: Event, now: i64) -> Vec<Action> {
        let mut actions = Vec::new();
        self.forgive_own_absence(now);
        match event {
            Event::Beat(i, state) => self.beat(i, state, now),
            Event::Ended(i, ending) => self.ended(i, ending, now, &mut actions),
            Event::Restart(i) => self.restart(i, now, &mut actions),
            Event::Stop => self.stop(Outcome::Stopped),
            Event::Tick => {}
        }
        if self.stopping.is_some() {
            self.drive_stop(now, &mut actions);
        } else {
            self.drive(now, &mut actions);
        }
        actions
    }

    /// Who did not look cannot say that others were silent: an absence moves every clock on by its length.
    fn forgive_own_absence(&mut self, now: i64) {
        let absent = now - self.last_step.replace(now).unwrap_or(now);
        if absent <= ns(self.limits.silent) / 4 {
            return;
        }
        for member in &mut self.members {
            member.last_beat = member.last_beat.map(|at| at + absent);
            if let Stage::Starting { since } | Stage::Ending { since } = &mut member.stage {
                *since += absent;
            }
        }
    }

    /// A process's stage in a word, for people.
    pub fn stage_word(&self, i: usize) -> &'static str {
        match self.members[i].stage {
            Stage::Waiting => "waiting",
            Stage::Starting { .. } => "starting",
            Stage::Ready => "ready",
            Stage::BackOff { .. } => "restarting",
            Stage::GivenUp => "held",
            Stage::Ending { .. } => "ending",
            Stage::Ended => "ended",
        }
    }

    /// Whether a process does its work now.
    pub fn is_ready(&self, i: usize) -> bool {
        self.members[i].stage == Stage::Ready
    }

    fn beat(&mut self, i: usize, state: ProcessState, now: i64) {
        let member = &mut self.members[i];
        member.last_beat = Some(now);
        if state == ProcessState::Ready && matches!(member.stage, Stage::Starting { .. }) {
            member.stage = Stage::Ready;
            member.was_ready = true;
        }
    }

    fn ended(&mut self, i: usize, ending: Ending, now: i64, actions: &mut Vec<Action>) {
        let member = &mut self.members[i];
        if self.stopping.is_some() {
            member.stage = Stage::Ended;
            return;
        }
        let refused = matches!(ending, Ending::Code(code) if code != 0);
        if refused && !member.was_ready && !member.killed {
            member.stage = Stage::Ended;
            self.stop(Outcome::Refused(i));
            return;
        }
        member.killed = false;
        let window = ns(self.limits.restart_window);
        member.restarts.retain(|at| now - at <= window);
        member.restarts.push(now);
        if member.restarts.len() > self.limits.restarts as usize {
            let was_ready = member.was_ready;
            member.stage = if was_ready { Stage::GivenUp } else { Stage::Ended };
            actions.push(Action::GaveUp(i));
            if !was_ready {
                self.stop(Outcome::Refused(i));
            }
        } else {
            member.stage = Stage::BackOff {
                until: now + back_off(member.restarts.len()),
            };
        }
    }

    /// One that is held begins anew, with as many restarts as at first; one that is ready makes room for the next. Of any other this is no
    /// business.
    fn restart(&mut self, i: usize, now: i64, actions: &mut Vec<Action>) {
        let member = &mut self.members[i];
        match member.stage {
            Stage::GivenUp => {
                member.restarts.clear();
                member.stage = Stage::BackOff { until: now };
            }
            Stage::Ready => self.kill(i, KillReason::Asked, now, actions),
            _ => {}
        }
    }

    fn stop(&mut self, outcome: Outcome) {
        if self.stopping.is_some() {
            return;
        }
        self.stopping = Some(outcome);
        for member in &mut self.members {
            if matches!(member.stage, Stage::Waiting | Stage::BackOff { .. } | Stage::GivenUp) {
                member.stage = Stage::Ended;
            }
        }
    }

    fn drive(&mut self, now: i64, actions: &mut Vec<Action>) {
        for i in 0..self.members.len() {
            match self.members[i].stage {
                Stage::Waiting if self.may_start(i) => self.start(i, now, actions),
                Stage::BackOff { until } if now >= until => self.start(i, now, actions),
                Stage::Starting { since } if now - since > ns(self.limits.start) => {
                    self.kill(i, KillReason::SlowStart, now, actions);
                }
                Stage::Starting { .. } | Stage::Ready if self.is_silent(i, now) => {
                    self.kill(i, KillReason::Silent, now, actions);
                }
                _ => {}
            }
        }
        if !self.all_ready && self.members.iter().all(|m| m.was_ready) {
            self.all_ready = true;
            actions.push(Action::AllReady);
        }
    }

    fn may_start(&self, i: usize) -> bool {
        self.members[i]
            .role
            .after
            .iter()
            .all(|&other| self.members[other].was_ready)
    }

    fn is_silent(&self, i: usize, now: i64) -> bool {
        self.members[i]
            .last_beat
            .is_some_and(|at| now - at > ns(self.limits.silent))
    }

    fn start(&mut self, i: usize, now: i64, actions: &mut Vec<Action>) {
        let member = &mut self.members[i];
        member.stage = Stage::Starting { since: now };
        member.last_beat = None;
        actions.push(Action::Start(i));
    }

    /// Kills once; the process stays in its stage until its end is reported, with a fresh allowance of silence.
    fn kill(&mut self, i: usize, reason: KillReason, now: i64, actions: &mut Vec<Action>) {
        let member = &mut self.members[i];
        member.killed = true;
        member.last_beat = Some(now);
        if let Stage::Starting { since } = &mut member.stage {
            *since = now;
        }
        actions.push(Action::Kill(i, reason));
    }

    fn drive_stop(&mut self, now: i64, actions: &mut Vec<Action>) {
        let lowest = |members: &[Member]| {
            let running = members.iter().filter(|m| m.stage != Stage::Ended);
            running.map(|m| m.role.stop_rank).min()
        };
        let Some(rank) = lowest(&self.members) else {
            if !self.finished {
                self.finished = true;
                actions.extend(self.stopping.map(Action::Finished));
            }
            return;
        };
        for (i, member) in self.members.iter_mut().enumerate() {
            if member.role.stop_rank != rank {
                continue;
            }
            match member.stage {
                Stage::Starting { .. } | Stage::Ready => {
                    member.stage = Stage::Ending { since: now };
                    actions.push(Action::Terminate(i));
                }
                Stage::Ending { since } if now - since > ns(self.limits.stop) => {
                    member.stage = Stage::Ending { since: now };
                    actions.push(Action::Kill(i, KillReason::SlowStop));
                }
                _ => {}
            }
        }
    }
}

/// How long the `n`-th restart within the window waits, ns; the first does not.
fn back_off(n: usize) -> i64 {
    match n {
        0 | 1 => 0,
        n => ns(FIRST_BACK_OFF * 2_u32.pow((n - 2).min(10) as u32)).min(ns(LONGEST_BACK_OFF)),
    }
}

#[cfg(test)]
mod tests;
