//! What a person must be told of the stream of poses, for as long as it takes to be read.

use bus::continuity::Judged;

/// How long a remark stands on the images, ns of the session's clock.
const STANDS_NS: i64 = 10_000_000_000;

/// When something was last amiss, on the session's clock.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Remarks {
    registration_ns: Option<i64>,
    numbers_ns: Option<i64>,
}

impl Remarks {
    /// Takes in what was found of a sample that was captured at `t_ns`.
    pub(crate) fn take(&mut self, judged: &Judged, t_ns: i64) {
        if judged.registration_before.is_some() {
            self.registration_ns = Some(t_ns);
        }
        if judged.broken.is_some_and(|broken| !broken.refuses()) {
            self.numbers_ns = Some(t_ns);
        }
    }

    /// What is to be said at `now_ns`.
    pub(crate) fn words(&self, now_ns: i64) -> Vec<&'static str> {
        let stands = |at: Option<i64>| at.is_some_and(|at| now_ns.saturating_sub(at) < STANDS_NS);
        let remarks = [
            (self.registration_ns, "REGISTRATION CHANGED"),
            (self.numbers_ns, "POSES ARE COUNTED ANEW"),
        ];
        let standing = remarks.into_iter().filter(|(at, _)| stands(*at));
        standing.map(|(_, words)| words).collect()
    }
}
