//! What a recording holds over its time, told while it is read: for the bar that a replay is steered by.
//!
//! The same reading as a report's, so that the bar and the page never differ on what was live, lost or missing.

use std::io::{BufReader, Seek};
use std::ops::ControlFlow;
use std::path::Path;

use bus::clock::monotonic_ns;
use bus::message::{Timeline, TimelineColumn, TimelineMark};

use super::ReportError;
use super::basis::Limits;
use super::gather::{Gathered, gather_each};
use super::states::{Shares, State};
use crate::read::damage::OpenError;
use crate::read::scan;

/// What is known so far is told so often, ns.
const EVERY_NS: i64 = 300_000_000;
/// The clock is looked at once in so many messages.
const LOOKED_AT: u32 = 256;

/// Reads the recording `path`, judging its samples by `limits`, those of the scene that is shown, or by those of its own scene, and hands
/// `tell` what is known so far, the last time all of it; ends where `tell` breaks.
///
/// # Errors
/// [`ReportError::Open`], [`ReportError::Schema`], [`ReportError::Newer`].
pub(crate) fn follow(
    path: &Path,
    limits: Option<Limits>,
    tell: &mut dyn FnMut(Timeline) -> ControlFlow<()>,
) -> Result<(), ReportError> {
    let fail = |source| OpenError::Io {
        path: path.to_owned(),
        source,
    };
    let (mut file, bytes) = scan::open_file(path)?;
    file.rewind().map_err(fail)?;
    let (mut messages, mut next_ns) = (0_u32, monotonic_ns() + EVERY_NS);
    let mut has_broken = false;
    let found = gather_each(path, BufReader::new(file), bytes, limits, &mut |found, (read, _)| {
        messages = messages.wrapping_add(1);
        if !messages.is_multiple_of(LOOKED_AT) || monotonic_ns() < next_ns {
            return ControlFlow::Continue(());
        }
        next_ns = monotonic_ns() + EVERY_NS;
        // The last word is that of the end.
        let told = tell(timeline(found, (read.min(bytes.saturating_sub(1)), bytes)));
        has_broken = told.is_break();
        told
    })?;
    if !has_broken {
        let _ = tell(timeline(&found, (bytes, bytes)));
    }
    Ok(())
}

/// What was found so far.
fn timeline(found: &Gathered, (read_bytes, bytes): (u64, u64)) -> Timeline {
    let damage = &found.damage;
    let unreadable = damage.unreadable + damage.places + u64::from(damage.is_cut_off || damage.stops_at.is_some());
    let mut told = Timeline {
        read_bytes,
        bytes,
        unreadable: u32::try_from(unreadable).unwrap_or(u32::MAX),
        ..Timeline::default()
    };
    let listed = found.marks.all.iter().zip(&mut told.marks);
    told.marks_count = listed
        .map(|(mark, room)| *room = TimelineMark::new(mark.t_ns, &mark.words))
        .count() as u32;
    let left_out = found.marks.count.saturating_sub(u64::from(told.marks_count));
    told.marks_left_out = u32::try_from(left_out).unwrap_or(u32::MAX);
    if let Some((from_ns, to_ns)) = found.span_ns {
        columns(&mut told, found, (from_ns, to_ns));
    }
    told
}

fn columns(told: &mut Timeline, found: &Gathered, (from_ns, to_ns): (i64, i64)) {
    let states = found.timeline.clone().finish(from_ns, to_ns, found.between).columns;
    let Some(((first_ns, end_ns), _)) = states.each().next() else {
        return;
    };
    (told.from_ns, told.column_ns) = (first_ns, end_ns - first_ns);
    let place = |t_ns: i64| usize::try_from((t_ns - first_ns) / (end_ns - first_ns)).ok();
    for ((from_ns, _), shares) in states.each() {
        let Some(column) = place(from_ns).and_then(|k| told.columns.get_mut(k)) else {
            continue;
        };
        column.states = bits(shares);
        told.columns_count = told.columns_count.max(place(from_ns).map_or(0, |k| k as u32 + 1));
    }
    // Errors come with poses, which all lie within the states: their columns are no wider.
    for ((from_ns, _), errors) in found.tip.predicted.columns.each() {
        let Some(column) = place(from_ns.max(first_ns)).and_then(|k| told.columns.get_mut(k)) else {
            continue;
        };
        if errors.unknown > 0 {
            column.states |= TimelineColumn::ERROR_UNKNOWN;
        }
        if let Some(drawn) = errors.drawn {
            column.error(drawn.range.0);
            column.error(drawn.range.1);
        }
    }
}

/// Which states had any time.
fn bits(shares: &Shares) -> u32 {
    let bit = |state: State| match state {
        State::NotYet => TimelineColumn::NOT_YET,
        State::Live => TimelineColumn::LIVE,
        State::Stale => TimelineColumn::STALE,
        State::Lost(_) | State::Missing => TimelineColumn::LOST,
        State::NotReadable => TimelineColumn::NOT_READABLE,
        State::Ending => TimelineColumn::ENDING,
    };
    State::all()
        .filter(|state| shares.of(*state) > 0)
        .fold(0, |bits, state| bits | bit(state))
}
