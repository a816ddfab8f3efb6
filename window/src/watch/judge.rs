//! Whether what stands on the screen may be believed: a pure function of what was read, with the times handed in.
//!
//! One rule carries all: within the limit a *newer* valid code must have been read. Whatever keeps it away, a window that hangs or died,
//! another window above it, a server that shows an old picture, is then a fault, and the latest reading only names it.

use crate::code::{Code, Shown, Unread};

const MS: i64 = 1_000_000;

/// What is tolerated, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// A picture that is not followed by a newer one within this time stands still.
    pub standing_ns: i64,
    /// The scene's `limits.stale_ms`: the window itself stops calling a pose of this age live.
    pub stale_ns: i64,
    /// A window that gives no sign of life on the bus for so long is a fault, whatever it paints.
    pub silent_ns: i64,
    /// So many newer pictures end a fault, each within `standing_ns` of the one before.
    pub good: u32,
}

/// One life of a window: its number in X, and the process that paints it.
pub type Life = [u32; 2];

/// What was found in the place of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// No window of this run is on the screen.
    NoWindow,
    /// There is one, and no code of it can be read.
    Unread(Unread),
    /// A code.
    Code(Life, Code),
}

/// One look at the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reading {
    /// What was found.
    pub seen: Seen,
    /// The clock by which poses are aged, when the pixels were asked for, ns.
    pub t_session_ns: i64,
    /// Whether this run is a replay, in which nothing is live.
    pub is_replay: bool,
    /// The window's newest sign of life, ns on the run's clock.
    pub t_heard_ns: Option<i64>,
    /// Whether that sign said that the window is ending as it was asked to.
    pub is_ending: bool,
}

/// Why the screen must not be believed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The window is no longer there, and nobody asked it to go.
    NoWindow,
    /// The cell cannot be read.
    Unread(Unread),
    /// The same picture all the time, or pictures that were there before.
    Standing,
    /// It says live, and its oldest pose is older than it may be.
    Old,
    /// It says live, and its pose is of a time to come.
    Ahead,
    /// It says live in a replay.
    LiveInReplay,
    /// The window gives no sign of life on the bus.
    Silent,
}

/// What follows from all readings so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There was no window yet, so there is nothing to be mistaken about.
    Waiting,
    /// The window was closed in order.
    Closed,
    /// What is on the screen is what it says.
    Good,
    /// It is to be covered. For so long: since the last newer picture, of a pose its age, of a silent window its silence, ns.
    Bad(Fault, i64),
}

/// What is remembered from one reading to the next.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct State {
    /// The newest code of the present life.
    newest: Option<(Life, Code)>,
    /// When a window was first seen, or a newer code last, ns.
    proven_ns: Option<i64>,
    /// Since when signs of life are waited for, ns.
    listening_ns: i64,
    /// The fault that is not yet lifted, and how many newer codes have come since it was last seen.
    fault: Option<(Fault, u32)>,
}

/// The next state and the verdict, at `now_ns` of the run's clock, when the pixels were asked for.
pub fn step(limits: &Limits, state: State, reading: &Reading, now_ns: i64) -> (State, Verdict) {
    if reading.seen == Seen::NoWindow && reading.is_ending {
        return (State::default(), Verdict::Closed);
    }
    let Some(proven_ns) = state.proven_ns.or((reading.seen != Seen::NoWindow).then_some(now_ns)) else {
        return (state, Verdict::Waiting);
    };
    let mut next = state;
    if state.proven_ns.is_none() {
        next.listening_ns = now_ns;
    }
    let is_newer = take(&mut next, reading.seen);
    next.proven_ns = Some(if is_newer { now_ns } else { proven_ns });
    let fault = fault(limits, &next, reading, now_ns).map(|found| match found {
        // The pose has grown old because the picture stands.
        (Fault::Old, _) if !is_newer => (Fault::Standing, now_ns - proven_ns),
        found => found,
    });
    next.fault = match (fault, state.fault) {
        (Some((fault, _)), _) => Some((fault, 0)),
        (None, Some((fault, good))) => {
            let good = good + u32::from(is_newer);
            (good < limits.good).then_some((fault, good))
        }
        (None, None) => None,
    };
    // While a fault is on trial its name stays, and how long the newest proof lies back is all there is to count.
    let for_ns = fault.map_or(now_ns - proven_ns, |(_, for_ns)| for_ns);
    (
        next,
        next.fault
            .map_or(Verdict::Good, |(fault, _)| Verdict::Bad(fault, for_ns)),
    )
}

/// Takes a code over where it is newer; returns whether it was. The first of a life is none: what stood there before is not known.
fn take(state: &mut State, seen: Seen) -> bool {
    let Seen::Code(life, code) = seen else { return false };
    match state.newest {
        Some((old, newest)) if old == life => {
            // A code that was there before proves nothing: two old pictures may be shown in turn.
            let is_newer = code.is_behind(newest);
            if is_newer {
                state.newest = Some((life, code));
            }
            is_newer
        }
        _ => {
            state.newest = Some((life, code));
            false
        }
    }
}

/// What is wrong now, and for how long it has been, ns.
fn fault(limits: &Limits, state: &State, reading: &Reading, now_ns: i64) -> Option<(Fault, i64)> {
    if let Seen::Code(_, code) = reading.seen
        && let Some(fault) = lie(limits, code, reading)
    {
        return Some(fault);
    }
    let since_proof = now_ns - state.proven_ns.unwrap_or(now_ns);
    if since_proof > limits.standing_ns {
        let fault = match reading.seen {
            Seen::NoWindow => Fault::NoWindow,
            Seen::Unread(why) => Fault::Unread(why),
            Seen::Code(..) => Fault::Standing,
        };
        return Some((fault, since_proof));
    }
    // Listening began with the window: who was started before it is owed no sign from then.
    let heard = reading
        .t_heard_ns
        .map_or(state.listening_ns, |t| t.max(state.listening_ns));
    let silence = now_ns - heard;
    (silence > limits.silent_ns).then_some((Fault::Silent, silence))
}

/// What a code says that cannot be, however fresh its picture is.
fn lie(limits: &Limits, code: Code, reading: &Reading) -> Option<(Fault, i64)> {
    if code.shown() != Shown::Live {
        return None;
    }
    let age_ns = code.age_ms(reading.t_session_ns) * MS;
    if reading.is_replay {
        Some((Fault::LiveInReplay, age_ns))
    } else if age_ns > limits.stale_ns + limits.standing_ns / 2 {
        // A window paints at least every 50 ms: several pictures in a row are missing, or say what is not.
        Some((Fault::Old, age_ns))
    } else if age_ns < -limits.standing_ns {
        Some((Fault::Ahead, -age_ns))
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
