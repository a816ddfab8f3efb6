//! What images showed of organs that the tube moves, and how long that took.

use std::collections::BTreeMap;

use bus::clock::ms;
use bus::message::{FrameStamp, TissueShown};
use fit::Histogram;
use scene::Scene;
use serde::Serialize;

use super::{Latency, percentiles};

/// Words of a model may have numbers in them: so many different ones are told, and the rest counted together.
const MOST_REASONS: usize = 32;
const OTHER_REASONS: &str = "other reasons";

/// The first image of each pose in each view.
#[derive(Debug)]
pub(crate) struct TissueBook {
    counts: [u64; TissueShown::ALL.len()],
    /// Images, however often drawn and whatever asked for, that say nothing or have a code that no version has.
    unmarked: u64,
    /// Images, however often drawn, of a model that has folded: two places of it claim some of their pixels.
    covered_twice: u64,
    /// How many first images a model's refusal left at rest, by its words.
    refused: BTreeMap<String, u64>,
    /// From capture to handing over, of images with organs where a state has them, ms.
    moved_ms: Histogram,
}

/// What the report says of it.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct TissueReport {
    /// First images of poses by what they showed: settled, approximate, late, catching up, refused, rigid.
    pub(crate) images: BTreeMap<&'static str, u64>,
    /// Images that say nothing of organs though the scene moves some: that must never be.
    pub(crate) unmarked: u64,
    /// Images on which tissue lies over itself, and which say so.
    pub(crate) covered_twice: u64,
    /// Why a model refused poses, in its words, with the number of their first images.
    pub(crate) refused_because: BTreeMap<String, u64>,
    /// From the capture of a pose to the image of organs where the state of that pose has them.
    pub(crate) pose_to_tissue_ms: Latency,
}

impl Default for TissueBook {
    fn default() -> Self {
        Self {
            counts: Default::default(),
            unmarked: 0,
            covered_twice: 0,
            refused: BTreeMap::new(),
            moved_ms: Histogram::new(1e-3, 1e6),
        }
    }
}

impl TissueBook {
    /// Any image.
    pub(super) fn said(&mut self, stamp: &FrameStamp) {
        let shown = TissueShown::from_code(stamp.tissue);
        self.unmarked += u64::from(shown.is_none_or(|shown| shown == TissueShown::None));
        // Of a pose that is not refused the stamp has no other words than that.
        let is_moved = matches!(shown, Some(TissueShown::Settled | TissueShown::Approximate));
        self.covered_twice += u64::from(is_moved && !stamp.tissue_why().is_empty());
    }

    /// The first image of a pose, handed over `age_ns` behind its capture.
    pub(super) fn frame(&mut self, stamp: &FrameStamp, age_ns: i64) {
        let Some(shown) = TissueShown::from_code(stamp.tissue) else {
            return;
        };
        self.counts[shown.code() as usize] += 1;
        if shown == TissueShown::Refused {
            let why = stamp.tissue_why();
            let has_room = self.refused.len() < MOST_REASONS || self.refused.contains_key(why);
            let why = if has_room { why } else { OTHER_REASONS };
            *self.refused.entry(why.to_owned()).or_default() += 1;
        }
        if matches!(shown, TissueShown::Settled | TissueShown::Approximate) {
            self.moved_ms.add(ms(age_ns));
        }
    }

    /// What came of it; `None` where `scene` moves no organs.
    pub(crate) fn report(&self, scene: &Scene) -> Option<TissueReport> {
        scene.tissue.as_ref().map(|_| self.counted())
    }

    fn counted(&self) -> TissueReport {
        let of = |shown: &TissueShown| (shown.word(), self.counts[shown.code() as usize]);
        TissueReport {
            images: TissueShown::ALL.iter().skip(1).map(of).collect(),
            unmarked: self.unmarked,
            covered_twice: self.covered_twice,
            refused_because: self.refused.clone(),
            pose_to_tissue_ms: percentiles(&self.moved_ms),
        }
    }
}

impl TissueReport {
    /// A line for people.
    pub(crate) fn line(&self) -> String {
        let counts: Vec<_> = self.images.iter().filter(|(_, n)| **n > 0).collect();
        let counts: Vec<_> = counts.iter().map(|(word, n)| format!("{word} {n}")).collect();
        let took = &self.pose_to_tissue_ms;
        let twice = match self.covered_twice {
            0 => String::new(),
            images => format!("; tissue covered twice on {images}"),
        };
        let shown = format!("images by their organs: {}{twice}", counts.join(", "));
        // Where time waits for images nothing is said of the machine.
        if took.max <= 0.0 {
            return shown;
        }
        let [p50, p95, p99, max] = [took.p50, took.p95, took.p99, took.max];
        format!("{shown}; pose to organs moved, ms: p50 {p50:.2}, p95 {p95:.2}, p99 {p99:.2}, max {max:.2}")
    }

    /// What was wrong, in words.
    pub(crate) fn problem(&self) -> Option<String> {
        let says =
            "images said nothing of the organs that the tube moves, and nobody could tell whether they were moved";
        (self.unmarked > 0).then(|| format!("{} {says}", self.unmarked))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_are_counted_by_what_they_show_and_those_that_say_nothing_are_a_problem() {
        let mut book = TissueBook::default();
        let stamp = |shown: u32| FrameStamp {
            tissue: shown,
            ..FrameStamp::default()
        };
        for (shown, age_ns) in [
            (TissueShown::Settled, 20_000_000),
            (TissueShown::Settled, 40_000_000),
            (TissueShown::Late, 90_000_000),
        ] {
            book.frame(&stamp(shown.code()), age_ns);
        }
        let report = book.counted();
        assert_eq!(
            (
                report.images["settled"],
                report.images["late"],
                report.images["refused"]
            ),
            (2, 1, 0)
        );
        assert_eq!(
            (report.pose_to_tissue_ms.count, report.pose_to_tissue_ms.max),
            (2, 40.0)
        );
        assert_eq!((report.unmarked, report.problem()), (0, None));
        assert!(report.line().contains("late 1, settled 2;"), "{}", report.line());
        let refused = |why: &str| stamp(TissueShown::Refused.code()).refused_because(why);
        book.frame(&refused("draw it back"), 0);
        book.frame(&refused("draw it back"), 0);
        (0..40).for_each(|mm| book.frame(&refused(&format!("{mm} mm")), 0));
        let because = book.counted().refused_because;
        assert_eq!((because["draw it back"], because.len()), (2, MOST_REASONS + 1));
        assert_eq!(because[OTHER_REASONS], 42 - 2 - (MOST_REASONS as u64 - 1));
        book.said(&refused("draw it back"));
        assert_eq!(book.counted().covered_twice, 0);
        let folded = |shown: TissueShown| stamp(shown.code()).refused_because("TISSUE COVERED TWICE: 31 px");
        book.said(&folded(TissueShown::Settled));
        book.said(&folded(TissueShown::Approximate));
        let report = book.counted();
        assert!(
            report.covered_twice == 2
                && report
                    .line()
                    .contains("late 1, refused 42, settled 2; tissue covered twice on 2"),
            "{}",
            report.line()
        );
        for shown in [TissueShown::None.code(), 99, TissueShown::Late.code()] {
            book.said(&stamp(shown));
        }
        assert!(book.counted().problem().unwrap().starts_with("2 images"));
    }
}
