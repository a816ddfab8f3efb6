//! Play, pause, step, seek, speed and loop: a state machine. It knows no clock; whoever drives it says what
//! CLOCK_MONOTONIC shows, and does what it decides.

use bus::clock::Law;
use bus::message::{ClockLaw, ReplayState};

use super::Speed;

/// What a person asks of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// Stand still.
    Pause,
    /// Go on.
    Play,
    /// Publish the next pose and stand still.
    Step,
    /// Publish the pose of this moment and stand still.
    Show(i64),
    /// Go on from this moment, ns on the recorded run's clock; outside of what is replayed, from the nearer end.
    Seek(i64),
    /// Go on at this speed.
    Speed(Speed),
}

/// What is to be done now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Act {
    /// Publish what comes next, after the clock.
    Publish,
    /// Nothing before CLOCK_MONOTONIC shows this.
    Sleep(i64),
    /// Find the first pose that is due at this moment or later.
    Find(i64),
    /// Nothing until somebody asks for something.
    Idle,
}

/// Where a replay stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Transport {
    span_ns: [i64; 2],
    speed: Speed,
    looping: bool,
    /// The zero of the seconds that people name.
    zero_ns: i64,
    state: ReplayState,
    law: Law,
    jumps: u64,
    /// Publish one pose although paused.
    step: bool,
    find: Option<i64>,
}

impl Transport {
    /// A replay of everything that is due within `span_ns` (both ends belong to it), that begins when it is first driven.
    /// People name its places by the seconds since `zero_ns`.
    pub fn new(span_ns: [i64; 2], zero_ns: i64, speed: Speed, looping: bool) -> Self {
        Self {
            span_ns,
            speed,
            looping,
            zero_ns,
            state: ReplayState::Playing,
            law: Law::still(span_ns[0]),
            jumps: 0,
            step: false,
            find: Some(span_ns[0]),
        }
    }

    /// Takes a request at `monotonic_ns`.
    pub fn control(&mut self, control: Control, monotonic_ns: i64) {
        match control {
            Control::Pause => self.stand(ReplayState::Paused, monotonic_ns),
            Control::Play => self.go_on(monotonic_ns),
            Control::Step => {
                self.stand(ReplayState::Paused, monotonic_ns);
                self.step = self.state == ReplayState::Paused;
            }
            Control::Show(to_ns) => {
                self.state = ReplayState::Paused;
                self.jump(to_ns.clamp(self.span_ns[0], self.span_ns[1]), monotonic_ns);
            }
            Control::Seek(to_ns) => self.jump(to_ns.clamp(self.span_ns[0], self.span_ns[1]), monotonic_ns),
            Control::Speed(speed) => {
                let now_ns = self.law.at(monotonic_ns);
                self.speed = speed;
                if self.state == ReplayState::Playing {
                    self.run_from(now_ns, monotonic_ns);
                }
            }
        }
    }

    /// What is to be done at `monotonic_ns`, where `due_ns` is the publication of what comes next (`None`: nothing does).
    pub fn next(&mut self, due_ns: Option<i64>, monotonic_ns: i64) -> Act {
        if let Some(to_ns) = self.find.take() {
            self.run_from(to_ns, monotonic_ns);
            return Act::Find(to_ns);
        }
        let playing = self.state == ReplayState::Playing;
        if !playing && !std::mem::take(&mut self.step) {
            return Act::Idle;
        }
        let Some(due_ns) = due_ns.filter(|&due| due <= self.span_ns[1]) else {
            // A step behind the last pose: there is nothing more to be shown, and the replay stands where it stood.
            return if playing { self.end(monotonic_ns) } else { Act::Idle };
        };
        if !playing || self.speed == Speed::Max {
            self.law = Law::still(due_ns);
            return Act::Publish;
        }
        match self.law.when(due_ns) {
            Some(when) if monotonic_ns < when => Act::Sleep(when),
            _ => Act::Publish,
        }
    }

    /// The place `at_ns` has been found: the replay goes on from there at `monotonic_ns`, however long the search took.
    pub fn found(&mut self, at_ns: i64, monotonic_ns: i64) {
        self.run_from(at_ns, monotonic_ns);
    }

    /// Nothing comes any more.
    fn end(&mut self, monotonic_ns: i64) -> Act {
        if self.looping {
            self.jump(self.span_ns[0], monotonic_ns);
            return self.next(None, monotonic_ns);
        }
        self.stand(ReplayState::Ended, monotonic_ns);
        Act::Idle
    }

    fn stand(&mut self, state: ReplayState, monotonic_ns: i64) {
        // What has ended stays so until it is sent elsewhere.
        if self.state != ReplayState::Ended {
            self.law = Law::still(self.law.at(monotonic_ns));
            self.state = state;
        }
    }

    fn go_on(&mut self, monotonic_ns: i64) {
        if self.state == ReplayState::Paused {
            self.state = ReplayState::Playing;
            self.run_from(self.law.at(monotonic_ns), monotonic_ns);
        }
    }

    fn jump(&mut self, to_ns: i64, monotonic_ns: i64) {
        self.jumps += 1;
        self.find = Some(to_ns);
        if self.state == ReplayState::Paused {
            // So that the place that was asked for is seen.
            self.step = true;
        } else {
            self.state = ReplayState::Playing;
        }
        self.run_from(to_ns, monotonic_ns);
    }

    /// The clock shows `now_ns` at `monotonic_ns`, and goes on from there if the replay does.
    fn run_from(&mut self, now_ns: i64, monotonic_ns: i64) {
        let rate = match (self.state, self.speed) {
            (ReplayState::Playing, Speed::Times(times)) => times,
            _ => 0.0,
        };
        // Speeds are checked where they come in; were this one impossible, the clock would stand.
        self.law = Law::new(now_ns, monotonic_ns, rate).unwrap_or(Law::still(now_ns));
    }

    /// What to tell everybody; of poses published from `judged_from_ns` on it is known for how long their measurement had stood still.
    pub fn message(&self, judged_from_ns: i64) -> ClockLaw {
        let (anchor_ns, anchor_monotonic_ns) = self.law.anchor();
        ClockLaw {
            anchor_ns,
            anchor_monotonic_ns,
            rate: self.law.rate(),
            jumps: self.jumps,
            first_ns: self.span_ns[0],
            last_ns: self.span_ns[1],
            zero_ns: self.zero_ns,
            judged_from_ns,
            speed: self.speed.number(),
            state: self.state.code(),
            reserved: 0,
        }
    }

    /// The clock of the replay.
    pub fn law(&self) -> Law {
        self.law
    }

    /// What the replay does.
    pub fn state(&self) -> ReplayState {
        self.state
    }

    /// How fast.
    pub fn speed(&self) -> Speed {
        self.speed
    }
}

#[cfg(test)]
mod tests;
