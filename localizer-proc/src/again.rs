//! A peer that sends its last message again and again: frames come, and nothing new is in them.

use bus::clock;

#[derive(Debug, Default)]
pub(crate) struct Again {
    /// When the last news came.
    news_ns: i64,
    /// How many messages came since that held nothing new.
    count: u64,
    is_told: bool,
}

impl Again {
    /// Something new came.
    pub(crate) fn news(&mut self, now_ns: i64) {
        *self = Self {
            news_ns: now_ns,
            ..Self::default()
        };
    }

    /// A message came at `now_ns` that came before. What is to be told: once, where nothing else has come for `long_ns`.
    pub(crate) fn came(&mut self, now_ns: i64, long_ns: i64) -> Option<String> {
        self.count += 1;
        let since_ns = now_ns.saturating_sub(self.news_ns);
        let is_news = since_ns > long_ns && !std::mem::replace(&mut self.is_told, since_ns > long_ns);
        is_news.then(|| {
            format!(
                "the peer sends its last message again and again: nothing new has come for {:.0} ms, and poses grow old",
                clock::ms(since_ns)
            )
        })
    }

    /// The same for the status; empty where there are news.
    pub(crate) fn words(&self) -> String {
        match self.is_told {
            true => format!("the same message again and again ({})", self.count),
            false => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The status said `20 frames/s` of a peer that hung, and nothing said why there was no pose.
    #[test]
    fn a_peer_that_repeats_itself_is_told_once() {
        let ms = 1_000_000;
        let mut again = Again::default();
        again.news(0);
        let told: Vec<String> = (1..100).filter_map(|k| again.came(k * 50 * ms, 1000 * ms)).collect();
        assert_eq!(told.len(), 1);
        assert!(told[0].contains("nothing new has come for 1050 ms"), "{told:?}");
        assert_eq!(again.words(), "the same message again and again (99)");
        again.news(6000 * ms);
        assert_eq!(again.words(), "");
        // A copy of each message, a little later, is no silence.
        assert_eq!(again.came(6010 * ms, 1000 * ms), None);
        assert_eq!(again.words(), "");
    }
}
