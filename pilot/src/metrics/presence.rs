//! Whether the pilot itself was there all the time: a process that was stopped, or a machine that slept, watches over nobody.

use bus::clock::ms;

/// The pilot's own turns.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Presence {
    /// When the last turn began; `None`: there was none yet.
    last_ns: Option<i64>,
    /// For how long it was away at most, ns.
    longest_ns: i64,
    /// How often.
    count: u32,
}

impl Presence {
    /// A turn begins: for how long nobody had looked, where that is more than `allowed_ns`.
    pub(crate) fn turn(&mut self, now_ns: i64, allowed_ns: i64) -> Option<i64> {
        let away_ns = now_ns.saturating_sub(self.last_ns.replace(now_ns)?);
        (away_ns > allowed_ns).then_some(away_ns)
    }

    /// What the pilot did until now takes its time, and is no standstill.
    pub(crate) fn was_at_work(&mut self, now_ns: i64) {
        self.last_ns = Some(now_ns);
    }

    /// It was away for so long, and that is to be told.
    pub(crate) fn stood_still(&mut self, away_ns: i64) -> String {
        self.longest_ns = self.longest_ns.max(away_ns);
        self.count += 1;
        format!("the pilot stood still for {:.1} s", ms(away_ns) / 1e3)
    }

    /// That as a problem of the run.
    pub(crate) fn problem(&self) -> Option<String> {
        let longest_s = ms(self.longest_ns) / 1e3;
        let times = match self.count {
            0 => return None,
            1 => String::new(),
            count => format!("{count} times, at most "),
        };
        Some(format!(
            "the pilot stood still {times}for {longest_s:.1} s, as one that was stopped or a machine that slept: nobody watched over the \
             other processes meanwhile"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: i64 = 1_000_000_000;

    #[test]
    fn a_pilot_that_was_stopped_says_so_and_its_own_work_is_no_standstill() {
        let mut presence = Presence::default();
        assert_eq!(presence.turn(7 * S, S), None, "before the first turn there is nothing");
        assert_eq!(presence.turn(8 * S, S), None);
        assert_eq!(presence.problem(), None);
        assert_eq!(presence.turn(13 * S, S), Some(5 * S));
        assert_eq!(presence.stood_still(5 * S), "the pilot stood still for 5.0 s");
        assert!(
            presence
                .problem()
                .unwrap()
                .starts_with("the pilot stood still for 5.0 s")
        );
        presence.was_at_work(20 * S);
        assert_eq!(presence.turn(20 * S + 1, S), None);
        presence.stood_still(2 * S);
        assert!(presence.problem().unwrap().contains("2 times, at most for 5.0 s"));
    }
}
