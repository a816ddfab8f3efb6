//! Changes of the plan that a person asks for.

use guidance::plan::Edit;
use iceoryx2::prelude::ZeroCopySend;

use super::{PlanMeasure, PlanTarget};

/// A change of the plan that a person asks for: 208 bytes.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct PlanEdit {
    /// Code of a [`PlanWish`]; 0: none.
    pub kind: u64,
    /// For the removal of a measure: its place, from 0.
    pub place: u64,
    /// The target that is to be there.
    pub target: PlanTarget,
    /// The distance or angle that is to be there.
    pub measure: PlanMeasure,
}

/// What a person asks of a plan.
#[derive(Debug, Clone, PartialEq)]
pub enum PlanWish {
    /// Change it.
    Edit(Edit),
    /// Take the last change back.
    Undo,
    /// Make it again.
    Redo,
    /// It is to be followed: nothing changes after this. With the words that say who confirms it.
    Confirm(String),
}

impl PlanEdit {
    /// None.
    pub const NONE: Self = Self {
        kind: 0,
        place: 0,
        target: PlanTarget::NONE,
        measure: PlanMeasure::NONE,
    };

    /// The wish, with the words that go beside it in the request. `None` for notes, which have no room in one.
    pub fn of(wish: &PlanWish) -> Option<(Self, String)> {
        let none = |kind| Self { kind, ..Self::NONE };
        Some(match wish {
            PlanWish::Edit(Edit::Add(target)) => (
                Self {
                    target: PlanTarget::of(target),
                    ..none(1)
                },
                String::new(),
            ),
            PlanWish::Edit(Edit::Change(name, target)) => (
                Self {
                    target: PlanTarget::of(target),
                    ..none(2)
                },
                name.clone(),
            ),
            PlanWish::Edit(Edit::Remove(name)) => (none(3), name.clone()),
            PlanWish::Edit(Edit::Measure(measure)) => (
                Self {
                    measure: PlanMeasure::of(measure),
                    ..none(4)
                },
                String::new(),
            ),
            PlanWish::Edit(Edit::RemoveMeasure(place)) => (
                Self {
                    place: *place as u64,
                    ..none(5)
                },
                String::new(),
            ),
            PlanWish::Edit(Edit::Notes(_)) => return None,
            PlanWish::Undo => (none(6), String::new()),
            PlanWish::Redo => (none(7), String::new()),
            PlanWish::Confirm(by) => (none(8), by.clone()),
        })
    }

    /// What is asked for, with the request's words; `None` for an unknown code and for what is no measure. Its numbers are checked by
    /// who changes the plan.
    pub fn wish(&self, words: &str) -> Option<PlanWish> {
        let words = words.to_owned();
        Some(match self.kind {
            1 => PlanWish::Edit(Edit::Add(self.target.target())),
            2 => PlanWish::Edit(Edit::Change(words, self.target.target())),
            3 => PlanWish::Edit(Edit::Remove(words)),
            4 => PlanWish::Edit(Edit::Measure(self.measure.measure().ok()?)),
            5 => PlanWish::Edit(Edit::RemoveMeasure(usize::try_from(self.place).ok()?)),
            6 => PlanWish::Undo,
            7 => PlanWish::Redo,
            8 => PlanWish::Confirm(words),
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Point;
    use guidance::plan::{Measure, Target};

    fn target() -> Target {
        Target {
            // As long as a name may be.
            name: "é".repeat(20),
            centre: Point::new(1.0, -2.0, 3.5),
            diameter_mm: 6.0,
            entry: Some(Point::new(90.0, 40.0, 3.0)),
            stop_mm: 2.0,
        }
    }

    #[test]
    fn every_wish_comes_back_with_its_words() {
        let zero = Point::new(0.0, 0.0, 0.0);
        for wish in [
            PlanWish::Edit(Edit::Add(target())),
            PlanWish::Edit(Edit::Change("old".to_owned(), target())),
            PlanWish::Edit(Edit::Remove("b".to_owned())),
            PlanWish::Edit(Edit::Measure(Measure::Distance([zero, zero]))),
            PlanWish::Edit(Edit::RemoveMeasure(7)),
            PlanWish::Undo,
            PlanWish::Redo,
            PlanWish::Confirm("Dr. A".to_owned()),
        ] {
            let (edit, words) = PlanEdit::of(&wish).unwrap();
            assert_eq!(edit.wish(&words), Some(wish));
        }
        assert_eq!(PlanEdit::of(&PlanWish::Edit(Edit::Notes("x".to_owned()))), None);
        for kind in [0, 9, u64::MAX] {
            assert_eq!(PlanEdit { kind, ..PlanEdit::NONE }.wish("x"), None);
        }
        let no_measure = PlanEdit {
            kind: 4,
            ..PlanEdit::NONE
        };
        assert_eq!(no_measure.wish(""), None);
    }
}
