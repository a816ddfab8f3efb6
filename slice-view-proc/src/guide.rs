//! What a person chose, as the renderer hears it: which target was chosen, and how images were to look, when a pose was captured.
//!
//! An image of a pose shows what was chosen when that pose was captured, so that all views of one pose agree, and a replay shows
//! what the run showed. An image that is old, or has no pose, shows what is chosen now.

use std::collections::BTreeMap;

use bus::BusError;
use bus::message::{Chosen, Guide, GuideError, Images};
use bus::port::Subscriber;

/// More are not kept: the earliest give way. A person does not choose so often in the time of one pose.
const KEPT: usize = 256;

/// What holds from one saying to the next.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct Said {
    /// The target that is aimed at.
    pub(crate) chosen: Option<Chosen>,
    /// How images look.
    pub(crate) images: Images,
}

/// What was chosen, by when it was said, ns on the session's clock: nothing, where it was no plan.
#[derive(Debug, Default)]
pub(crate) struct Chosens {
    said: BTreeMap<i64, Said>,
    /// How many were no plan.
    refused: u64,
    /// And how many of these were not counted elsewhere yet.
    pub(crate) refused_since: u64,
}

impl Chosens {
    /// Takes in what has come. Gives why something was refused that never was before.
    pub(crate) fn listen(&mut self, guides: &Subscriber<Guide>) -> Result<Option<String>, BusError> {
        let mut why = None;
        while let Some(guide) = guides.next()? {
            let first = self.take(&guide);
            why = why.or(first);
        }
        Ok(why)
    }

    /// Takes in one; of one that is no plan nothing is shown, nor what was chosen before it.
    pub(crate) fn take(&mut self, guide: &Guide) -> Option<String> {
        let (said, why) = match said(guide) {
            Ok(said) => (said, None),
            Err(error) => (Said::default(), Some(error.to_string())),
        };
        self.said.insert(guide.t_ns, said);
        if self.said.len() > KEPT {
            self.said.pop_first();
        }
        self.refused += u64::from(why.is_some());
        self.refused_since += u64::from(why.is_some());
        why.filter(|_| self.refused == 1)
    }

    /// What held at `t_ns`; `None` before the first saying.
    pub(crate) fn at(&self, t_ns: i64) -> Option<&Said> {
        self.said.range(..=t_ns).next_back().map(|(_, said)| said)
    }
}

fn said(guide: &Guide) -> Result<Said, GuideError> {
    Ok(Said {
        chosen: guide.chosen()?,
        images: guide.images()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Point;

    fn guide(t_ns: i64, name: &str) -> Guide {
        let chosen = Chosen {
            name: name.to_owned(),
            centre: Point::new(1.0, 2.0, 3.0),
            radius_mm: 2.5,
            entry: None,
            stop_mm: 0.0,
        };
        Guide {
            t_ns,
            ..Guide::default().choosing(Some(&chosen), 1)
        }
    }

    fn at(chosens: &Chosens, t_ns: i64) -> Option<&str> {
        chosens.at(t_ns)?.chosen.as_ref().map(|chosen| chosen.name.as_str())
    }

    #[test]
    fn a_pose_has_what_was_chosen_when_it_was_captured() {
        let mut chosens = Chosens::default();
        for said in [
            guide(0, "a"),
            guide(100, "b"),
            Guide {
                t_ns: 200,
                ..Guide::default()
            },
        ] {
            assert_eq!(chosens.take(&said), None);
        }
        let found = [-1, 0, 99, 100, 199, 200, i64::MAX].map(|t| at(&chosens, t));
        assert_eq!(found, [None, Some("a"), Some("a"), Some("b"), Some("b"), None, None]);
        // A replay that went back tells it again: nothing changes.
        chosens.take(&guide(0, "a"));
        assert_eq!((at(&chosens, 150), at(&chosens, 50)), (Some("b"), Some("a")));
    }

    #[test]
    fn what_is_no_plan_is_refused_counted_and_shows_nothing() {
        let mut chosens = Chosens::default();
        chosens.take(&guide(0, "a"));
        let bad = Guide {
            target_mm: [f64::NAN; 3],
            ..guide(100, "b")
        };
        let said = chosens.take(&bad).unwrap();
        assert!(said.contains("target"), "{said}");
        // Neither it nor what it took the place of.
        assert_eq!((at(&chosens, 100), at(&chosens, 99)), (None, Some("a")));
        assert_eq!(chosens.take(&Guide { t_ns: 101, ..bad }), None);
        assert_eq!(chosens.refused, 2);
        let dark = Guide {
            flags: Guide::WINDOW,
            ..guide(300, "c")
        };
        assert_eq!(chosens.take(&dark), None);
        assert_eq!((chosens.refused, at(&chosens, 300)), (3, None));
    }

    #[test]
    fn the_memory_is_bounded_and_keeps_the_latest() {
        let mut chosens = Chosens::default();
        for t_ns in 0..10_000 {
            chosens.take(&guide(t_ns, "a"));
        }
        assert_eq!(chosens.said.len(), KEPT);
        assert_eq!(at(&chosens, i64::MAX), Some("a"));
    }
}
