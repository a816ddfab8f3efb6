//! Where a replay stands, and what its recording holds: for the bar that it is steered by.

use std::rc::Rc;

use bus::message::{ClockLaw, ReplayState, Timeline, TimelineMark};

use super::Known;

/// Who goes to the mark before and is no further behind the last one than this goes to the one before that, ns.
const JUST_PASSED_NS: i64 = 700_000_000;

/// A replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayModel {
    /// The first and the last moment of what is replayed, ns on the clock of the run that was recorded.
    pub span_ns: [i64; 2],
    /// The zero of the seconds that people name, ns.
    pub zero_ns: i64,
    /// Where it stands, ns.
    pub at_ns: i64,
    /// What it does.
    pub state: ReplayState,
    /// How many times as fast as the recording; infinite: as fast as images are drawn.
    pub speed: f64,
    /// What the recording holds; `None` while nothing was told of it, and where poses are made again.
    pub timeline: Option<Rc<Timeline>>,
}

/// That of what is known; `None` where nothing is replayed, or before the replayer has spoken.
pub fn replay(known: &Known<'_>) -> Option<ReplayModel> {
    let law = known.law.filter(|_| known.is_replay)?;
    let span_ns = [law.first_ns, law.last_ns.max(law.first_ns)];
    Some(ReplayModel {
        span_ns,
        zero_ns: law.zero_ns,
        at_ns: at_ns(&law, known.now_ns),
        state: law.replay_state(),
        speed: law.speed,
        timeline: known.timeline.cloned(),
    })
}

/// Where a replay stands whose clock shows `now_ns`: its clock may run on behind the last pose.
pub fn at_ns(law: &ClockLaw, now_ns: i64) -> i64 {
    now_ns.clamp(law.first_ns, law.last_ns.max(law.first_ns))
}

impl ReplayModel {
    /// Seconds as people name them.
    pub fn seconds(&self, t_ns: i64) -> f64 {
        bus::clock::ms(t_ns.saturating_sub(self.zero_ns)) / 1e3
    }

    /// Where a moment lies in what is replayed, 0 to 1.
    pub fn part(&self, t_ns: i64) -> f64 {
        let [first, last] = self.span_ns;
        match last.saturating_sub(first) {
            0 => 0.0,
            length => (t_ns.saturating_sub(first) as f64 / length as f64).clamp(0.0, 1.0),
        }
    }

    /// The moment that lies there.
    pub fn moment_ns(&self, part: f64) -> i64 {
        let [first, last] = self.span_ns;
        let ns = part.clamp(0.0, 1.0) * last.saturating_sub(first) as f64;
        first.saturating_add(ns.round() as i64).min(last)
    }

    /// The marks within what is replayed, in order.
    pub fn marks(&self) -> Vec<&TimelineMark> {
        let [first, last] = self.span_ns;
        let all = self.timeline.iter().flat_map(|timeline| timeline.marks());
        let mut marks: Vec<_> = all.filter(|mark| (first..=last).contains(&mark.t_ns)).collect();
        marks.sort_by_key(|mark| mark.t_ns);
        marks
    }

    /// The mark that the replay has reached, with its number from 1.
    pub fn reached(&self) -> Option<(usize, &TimelineMark)> {
        let marks = self.marks();
        let count = marks.partition_point(|mark| mark.t_ns <= self.at_ns);
        count.checked_sub(1).map(|last| (count, marks[last]))
    }

    /// The moment of the next mark, or of the one before.
    pub fn mark_ns(&self, is_forward: bool) -> Option<i64> {
        let moments = self.marks().into_iter().map(|mark| mark.t_ns);
        match is_forward {
            true => moments.into_iter().find(|t_ns| *t_ns > self.at_ns),
            false => {
                // Who plays has always just passed the one that she was sent to.
                let passed_ns = match self.state {
                    ReplayState::Playing => self.at_ns.saturating_sub(JUST_PASSED_NS),
                    ReplayState::Paused | ReplayState::Ended => self.at_ns,
                };
                moments.into_iter().rfind(|t_ns| *t_ns < passed_ns)
            }
        }
    }

    /// What it does, in words.
    pub fn doing(&self) -> String {
        let speed = match self.speed {
            speed if speed.is_infinite() => "max".to_owned(),
            speed => format!("{speed} x"),
        };
        match self.state {
            ReplayState::Playing => format!("PLAYING {speed}"),
            ReplayState::Paused => format!("PAUSED  {speed}"),
            ReplayState::Ended => "ENDED".to_owned(),
        }
    }

    /// What the bar does not show, in words; empty where it shows all.
    pub fn lacking(&self) -> String {
        let Some(timeline) = &self.timeline else {
            return "what it holds is not read".to_owned();
        };
        if !timeline.why().is_empty() {
            return format!("not read on: {}", timeline.why());
        }
        if !timeline.is_read() {
            let percent = 100.0 * timeline.read_bytes as f64 / (timeline.bytes.max(1)) as f64;
            return format!("reading {percent:.0} %");
        }
        let parts = [
            (timeline.unreadable, "not readable"),
            (timeline.marks_left_out, "marks more"),
        ];
        let said = parts.into_iter().filter(|(count, _)| *count > 0);
        said.map(|(count, words)| format!("{count} {words}"))
            .collect::<Vec<_>>()
            .join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(at_ns: i64, state: ReplayState) -> ReplayModel {
        let mut timeline = Timeline {
            marks_count: 3,
            ..Timeline::default()
        };
        let marks = [(3_000_000_000, "b"), (1_000_000_000, "a"), (90_000_000_000, "beyond")];
        for (room, (t_ns, words)) in timeline.marks.iter_mut().zip(marks) {
            *room = TimelineMark::new(t_ns, words);
        }
        ReplayModel {
            span_ns: [0, 10_000_000_000],
            zero_ns: 0,
            at_ns,
            state,
            speed: 1.0,
            timeline: Some(Rc::new(timeline)),
        }
    }

    #[test]
    fn marks_are_gone_to_in_order_and_those_outside_are_none() {
        let to = |at_s: f64, state| {
            let model = model((at_s * 1e9) as i64, state);
            [true, false].map(|is_forward| model.mark_ns(is_forward).map(|ns| ns / 1_000_000_000))
        };
        assert_eq!(to(0.5, ReplayState::Paused), [Some(1), None]);
        assert_eq!(to(1.0, ReplayState::Paused), [Some(3), None]);
        assert_eq!(to(3.0, ReplayState::Paused), [None, Some(1)]);
        // Pressed twice in playing it goes back twice.
        assert_eq!(to(3.2, ReplayState::Playing), [None, Some(1)]);
        assert_eq!(to(4.0, ReplayState::Playing), [None, Some(3)]);
        let words = |at_ns| {
            model(at_ns, ReplayState::Paused)
                .reached()
                .map(|(k, mark)| (k, mark.words()))
        };
        assert_eq!(words(2_000_000_000), Some((1, "a".to_owned())));
        assert_eq!(words(0), None);
    }

    #[test]
    fn a_place_on_the_bar_comes_back_as_its_moment() {
        let model = model(0, ReplayState::Paused);
        for t_ns in [0, 1, 3_333_333_333, 10_000_000_000] {
            assert!((model.moment_ns(model.part(t_ns)) - t_ns).abs() <= 1);
        }
        assert_eq!((model.part(-5), model.part(i64::MAX)), (0.0, 1.0));
        // A recording of one pose.
        let one = ReplayModel {
            span_ns: [7, 7],
            ..model
        };
        assert_eq!((one.part(7), one.moment_ns(0.5)), (0.0, 7));
    }
}
