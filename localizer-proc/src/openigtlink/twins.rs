//! Two tools of a peer that have one name on the wire, where the longer names that tell them apart were cut.
//!
//! A list of tools shows that at once. TRANSFORMs come one by one, and the two follow each other under one stamp: at two places that one
//! tool cannot have within the time between them.

use igtl::Stamp;

use super::pose::Tool;
use super::stamp_ns;
use crate::driver::Seen;

/// Two markers are never nearer to each other, and no hand moves one so far within [`WITHIN_NS`], mm.
const APART_MM: f64 = 50.0;
/// How long after the first of two poses with one stamp the second may come, ns. Stamps that stand still have longer between them.
const WITHIN_NS: i64 = 20_000_000;

/// What one connection has shown.
#[derive(Debug, Clone, Default)]
pub(super) struct Twins {
    /// The newest pose of each marker, with its stamp and its arrival.
    last: Vec<(u32, Stamp, Tool, i64)>,
    /// Markers that are two tools.
    found: Vec<u32>,
}

impl Twins {
    /// Whether this marker is two tools, as this pose or an earlier one of the connection shows.
    pub(super) fn are_two(&mut self, stamp: Stamp, seen: &Seen, now_ns: i64) -> bool {
        if let Ok((pose, _)) = seen.outcome {
            let before = self.last.iter().position(|(marker, ..)| *marker == seen.marker);
            if let Some((_, last_stamp, last, at_ns)) = before.map(|place| self.last.swap_remove(place)) {
                let is_one_time =
                    stamp_ns(stamp) != 0 && stamp == last_stamp && now_ns.saturating_sub(at_ns) <= WITHIN_NS;
                if is_one_time && apart_mm(&last, &pose) > APART_MM && !self.found.contains(&seen.marker) {
                    self.found.push(seen.marker);
                }
            }
            self.last.push((seen.marker, stamp, pose, now_ns));
        }
        self.found.contains(&seen.marker)
    }
}

fn apart_mm(a: &Tool, b: &Tool) -> f64 {
    let off = a
        .translation_mm()
        .into_iter()
        .zip(b.translation_mm())
        .map(|(a, b)| a - b);
    off.map(|mm| mm * mm).sum::<f64>().sqrt()
}
