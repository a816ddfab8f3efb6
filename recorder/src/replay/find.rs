//! The way to a place in a recording, with what a pose there goes on from.

use super::lead::Judge;
use super::tape::Tape;
use crate::edit::cut::CUT;
use crate::read::damage::OpenError;

/// Beyond the limit itself, so much is looked at first before a place, ns; where that was not enough, [`WIDER`] times as much.
const MARGIN_NS: i64 = 100_000_000;
const WIDER: i64 = 8;
/// Farther back nothing is looked for: a scene's limit is at most a minute, ns.
const FARTHEST_NS: i64 = 120_000_000_000;
/// Poses passed over between two calls of `goes_on`.
const PASSED: usize = 4096;

/// Goes to the first pose that is due at `at_ns` or later, and judges what came before it: from so long before it on that it is
/// known for how long the measurement has stood still. `limit_ns` is for how long it may; without, nothing is judged. Ends early where
/// `goes_on`, which is called now and then, says so.
///
/// # Errors
/// [`OpenError`].
pub(super) fn go_to(
    tape: &mut Tape,
    at_ns: i64,
    limit_ns: Option<i64>,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<Judge, OpenError> {
    let Some(limit) = limit_ns else {
        let mut judge = Judge::new(None, false);
        pass_to(tape, (at_ns, at_ns), &mut judge, goes_on)?;
        return Ok(judge);
    };
    let captures = tape.session().span_ns();
    let first_ns = captures.map_or(0, |(first_ns, _)| i64::try_from(first_ns).unwrap_or(i64::MAX));
    let mut back_ns = limit.saturating_add(MARGIN_NS);
    loop {
        let from_ns = at_ns.saturating_sub(back_ns);
        let mut judge = Judge::new(limit_ns, from_ns <= first_ns && begins_with_its_run(tape)?);
        let is_there = pass_to(tape, (from_ns, at_ns), &mut judge, goes_on)?;
        let next = tape.peek().map(|next| &next.pose);
        if next.is_none() || judge.is_known(next) || !is_there {
            return Ok(judge);
        }
        if back_ns >= FARTHEST_NS {
            // Nobody is told of a beginning that is not known to be one.
            return Ok(Judge::new(limit_ns, false));
        }
        back_ns = back_ns.saturating_mul(WIDER).min(FARTHEST_NS);
    }
}

/// Whether nothing came before the recording's first pose: a stretch that was cut out of another, a part behind a disk that was full, and a
/// recorder that came late do not have what the first measurement goes on from.
fn begins_with_its_run(tape: &Tape) -> Result<bool, OpenError> {
    let session = tape.session();
    let first = session.poses_from(i64::MIN)?.next();
    let is_first = first.and_then(Result::ok).is_some_and(|pose| pose.seq == 0);
    Ok(is_first && session.metadata(CUT)?.is_none())
}

/// What is due before `at_ns` is passed over, and judged from about `from_ns` on; whether it came so far.
fn pass_to(
    tape: &mut Tape,
    (from_ns, at_ns): (i64, i64),
    judge: &mut Judge,
    goes_on: &mut dyn FnMut() -> bool,
) -> Result<bool, OpenError> {
    tape.near(from_ns)?;
    let mut passed = 0_usize;
    while tape.peek().is_some_and(|next| next.due_ns() < at_ns) {
        if let Some(moment) = tape.take() {
            judge.take(&moment.pose);
        }
        passed += 1;
        if passed.is_multiple_of(PASSED) && !goes_on() {
            return Ok(false);
        }
    }
    Ok(true)
}
