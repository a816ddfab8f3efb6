//! When messages came: intervals, latencies, and the times when there was no pose.

use std::fmt;

use bus::message::{Lost, ToolPose};

use crate::read::spread::Spread;

/// The longest intervals without a pose that are named.
const NAMED: usize = 10;

/// The timing of one topic.
#[derive(Debug, Default, Clone, PartialEq)]
pub struct Timing {
    /// From one capture to that of the next number, ns.
    pub intervals: Spread,
    /// From capture to publication, ns.
    pub latency: Spread,
    /// Captures before the one of the number before.
    pub backwards: u64,
    /// Times without a pose; poses only.
    pub lost: LostTimes,
    last: Option<(u64, i64)>,
}

/// Times without a pose.
#[derive(Debug, Default, Clone, PartialEq, Eq)]
pub struct LostTimes {
    /// How many poses were lost.
    pub poses: u64,
    /// How many poses there were, lost ones among them.
    pub of: u64,
    /// How many times tracking was lost.
    pub times: u64,
    /// The longest, the longest first.
    pub longest: Vec<LostTime>,
    open: Option<LostTime>,
}

/// One time without a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LostTime {
    /// The first lost pose's number.
    pub seq: u64,
    /// Its capture, ns.
    pub from_ns: i64,
    /// The capture of the next valid pose, or of the last lost one, ns.
    pub to_ns: i64,
    /// Why the first was lost: its status.
    pub status: u32,
}

impl LostTime {
    fn length_ns(&self) -> i64 {
        self.to_ns.saturating_sub(self.from_ns)
    }
}

impl Timing {
    /// Takes note of a pose.
    pub fn pose(&mut self, pose: &ToolPose) {
        self.frame(pose.seq, [pose.t_capture_ns, pose.t_publish_ns]);
        self.lost.pose(pose);
    }

    /// Takes note of what was captured and published then, ns.
    pub fn frame(&mut self, seq: u64, [t_capture_ns, t_publish_ns]: [i64; 2]) {
        if let Ok(latency) = u64::try_from(t_publish_ns.saturating_sub(t_capture_ns)) {
            self.latency.add(latency);
        }
        if let Some((last, last_ns)) = self.last
            && last.checked_add(1) == Some(seq)
        {
            match u64::try_from(t_capture_ns.saturating_sub(last_ns)) {
                Ok(interval) => self.intervals.add(interval),
                Err(_) => self.backwards += 1,
            }
        }
        self.last = Some((seq, t_capture_ns));
    }
}

impl LostTimes {
    fn pose(&mut self, pose: &ToolPose) {
        self.of += 1;
        let t_ns = pose.t_capture_ns;
        if pose.status == 0 {
            if let Some(open) = self.open.take() {
                self.close(LostTime { to_ns: t_ns, ..open });
            }
            return;
        }
        self.poses += 1;
        match &mut self.open {
            Some(open) => open.to_ns = t_ns,
            None => {
                self.times += 1;
                self.open = Some(LostTime {
                    seq: pose.seq,
                    from_ns: t_ns,
                    to_ns: t_ns,
                    status: pose.status,
                });
            }
        }
    }

    fn close(&mut self, time: LostTime) {
        let place = self
            .longest
            .partition_point(|other| other.length_ns() >= time.length_ns());
        self.longest.insert(place, time);
        self.longest.truncate(NAMED);
    }

    /// Those that are known now, the longest first.
    fn named(&self) -> Vec<LostTime> {
        let mut all = self.clone();
        if let Some(open) = all.open.take() {
            all.close(open);
        }
        all.longest
    }
}

fn ms(ns: f64) -> f64 {
    ns / 1e6
}

fn row(f: &mut fmt::Formatter<'_>, topic: &str, what: &str, spread: &Spread) -> fmt::Result {
    let (Some(mean), Some((least, most))) = (spread.mean(), spread.range()) else {
        return Ok(());
    };
    let [median, p95, p99] = [0.5, 0.95, 0.99].map(|p| ms(spread.quantile(p).unwrap_or(0.0)));
    let (least, mean, most) = (ms(least as f64), ms(mean), ms(most as f64));
    writeln!(
        f,
        "{topic:<16} {what:<22} {least:>9.3} {median:>9.3} {mean:>9.3} {p95:>9.3} {p99:>9.3} {most:>9.3}"
    )
}

/// Writes the table of several topics, and the times without a pose of each.
///
/// # Errors
/// Those of the formatter.
pub(crate) fn write_table<'a>(
    f: &mut fmt::Formatter<'_>,
    topics: impl Iterator<Item = (&'a String, &'a Timing)> + Clone,
) -> fmt::Result {
    if topics.clone().all(|(_, timing)| timing.latency.count() == 0) {
        return Ok(());
    }
    writeln!(
        f,
        "{:<16} {:<22} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "timing, ms", "", "least", "median", "mean", "95 %", "99 %", "most"
    )?;
    for (topic, timing) in topics.clone() {
        row(f, topic, "capture to capture", &timing.intervals)?;
        row(f, topic, "capture to publication", &timing.latency)?;
        if timing.backwards > 0 {
            writeln!(
                f,
                "{topic}: {} captures before the one of the number before",
                timing.backwards
            )?;
        }
    }
    topics
        .filter(|(_, timing)| timing.lost.times > 0)
        .try_for_each(|(topic, timing)| write_lost(f, topic, &timing.lost))
}

fn write_lost(f: &mut fmt::Formatter<'_>, topic: &str, lost: &LostTimes) -> fmt::Result {
    let share = 100.0 * lost.poses as f64 / lost.of.max(1) as f64;
    let (poses, times) = (lost.poses, lost.times);
    writeln!(
        f,
        "{topic}: {poses} poses lost ({share:.1} %), {times} times; the longest:"
    )?;
    for time in lost.named() {
        let (from, length) = (time.from_ns as f64 / 1e9, time.length_ns() as f64 / 1e9);
        let why = Lost::from_code(time.status).map_or("unknown", Lost::words);
        writeln!(f, "  from {from:.3} s on (pose {}) for {length:.3} s: {why}", time.seq)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;
    use bus::message::Tracked;

    fn pose(seq: u64, t_ms: i64, lost: Option<Lost>) -> ToolPose {
        let mut pose = testing::pose(seq);
        pose.t_capture_ns = 1_000_000 * t_ms;
        pose.t_publish_ns = pose.t_capture_ns + 2_000_000;
        if let Some(reason) = lost {
            pose.set(Tracked::Lost(reason));
        }
        pose
    }

    #[test]
    fn lost_times_run_to_the_next_valid_pose() {
        let mut timing = Timing::default();
        let few = Some(Lost::TooFew);
        let lost = [None, few, few, None, Some(Lost::NotSeen), None, few, few];
        for (seq, lost) in (0..).zip(lost) {
            timing.pose(&pose(seq, 10 * seq.cast_signed(), lost));
        }
        assert_eq!((timing.lost.poses, timing.lost.of, timing.lost.times), (5, 8, 3));
        let named: Vec<_> = timing
            .lost
            .named()
            .iter()
            .map(|t| (t.seq, t.from_ns, t.to_ns, t.status))
            .collect();
        let ms = 1_000_000;
        assert_eq!(
            named,
            [
                (1, 10 * ms, 30 * ms, 4),
                (4, 40 * ms, 50 * ms, 1),
                (6, 60 * ms, 70 * ms, 4)
            ]
        );
    }

    #[test]
    fn intervals_are_those_of_neighbours_only() {
        let mut timing = Timing::default();
        for (seq, t_ms) in [(0, 0), (1, 10), (3, 500), (4, 520), (5, 515)] {
            timing.pose(&pose(seq, t_ms, None));
        }
        assert_eq!(timing.intervals.range(), Some((10_000_000, 20_000_000)));
        assert_eq!((timing.intervals.count(), timing.backwards), (2, 1));
        assert_eq!(timing.latency.range(), Some((2_000_000, 2_000_000)));
    }
}
