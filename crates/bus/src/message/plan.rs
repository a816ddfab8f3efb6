//! The plan of the operation, as the pilot of a planning run keeps it.

use geometry::{Ct, Point};
use guidance::plan::{
    self, Confirmed, MAX_MEASURES, MAX_NAME, MAX_NOTES, MAX_TARGETS, MAX_TIME, MAX_WHO, Measure, PlanError, Target,
};
use guidance::workflow::VolumeId;
use iceoryx2::prelude::ZeroCopySend;

use super::{field_text, text_field};

/// A target of a plan: 112 bytes.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct PlanTarget {
    /// Its centre, LPS, mm.
    pub centre_mm: [f64; 3],
    /// Where the tube is to enter, LPS, mm, of meaning with [`PlanTarget::ENTRY`].
    pub entry_mm: [f64; 3],
    /// Its diameter, mm.
    pub diameter_mm: f64,
    /// How far before its centre the tip is to stop, mm.
    pub stop_mm: f64,
    /// Bits: [`PlanTarget::ENTRY`].
    pub flags: u64,
    /// Its name.
    pub name: [u8; MAX_NAME],
}

/// A distance or an angle of a plan: 80 bytes.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct PlanMeasure {
    /// Its points, LPS, mm; the third of meaning for an angle.
    pub points_mm: [[f64; 3]; 3],
    /// 2: a distance; 3: an angle.
    pub count: u64,
}

/// A plan.
#[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend)]
#[repr(C)]
#[type_name("trocar/Plan/2")]
pub struct Plan {
    /// When it was said, ns on the session's clock.
    pub t_ns: i64,
    /// The id of its file's content, as a number.
    pub file_id: u64,
    /// How many changes can be taken back.
    pub undos: u32,
    /// How many of these can be made again.
    pub redos: u32,
    /// How many targets.
    pub targets: u32,
    /// How many distances and angles.
    pub measures: u32,
    /// Bits: [`Plan::CONFIRMED`], [`Plan::CHANGED_ELSEWHERE`].
    pub flags: u64,
    /// The hash of the examination that it was made for.
    pub volume: [u8; 32],
    /// Who confirmed it, of meaning with [`Plan::CONFIRMED`].
    pub by: [u8; MAX_WHO],
    /// When, the same.
    pub at: [u8; MAX_TIME],
    /// The targets: as many as [`Plan::targets`] says.
    pub target: [PlanTarget; MAX_TARGETS],
    /// The distances and angles: as many as [`Plan::measures`] says.
    pub measure: [PlanMeasure; MAX_MEASURES],
    /// The notes.
    pub notes: [u8; MAX_NOTES],
}

const _: () = assert!(size_of::<PlanTarget>() == 112 && size_of::<PlanMeasure>() == 80);
const _: () = assert!(size_of::<Plan>() == 160 + 112 * MAX_TARGETS + 80 * MAX_MEASURES + MAX_NOTES);

/// Why a plan on the bus is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanMessageError {
    /// A count beyond the message's room.
    #[error("the plan on the bus: {found} {what}, and room for {most}")]
    Count {
        /// Of what.
        what: &'static str,
        /// The count.
        found: u32,
        /// The room.
        most: usize,
    },
    /// A measure of neither two nor three points.
    #[error("the plan on the bus: a measure of {0} points")]
    Points(u64),
    /// A part outside its domain.
    #[error("the plan on the bus: {0}")]
    Plan(#[from] PlanError),
}

impl PlanTarget {
    /// There is an entry.
    pub const ENTRY: u64 = 1;
    /// None: what a request has that names no target.
    pub const NONE: Self = Self {
        centre_mm: [0.0; 3],
        entry_mm: [0.0; 3],
        diameter_mm: 0.0,
        stop_mm: 0.0,
        flags: 0,
        name: [0; MAX_NAME],
    };

    /// That of a plan.
    pub fn of(target: &Target) -> Self {
        Self {
            centre_mm: target.centre.mm(),
            entry_mm: target.entry.map(Point::mm).unwrap_or_default(),
            diameter_mm: target.diameter_mm,
            stop_mm: target.stop_mm,
            flags: if target.entry.is_some() { Self::ENTRY } else { 0 },
            name: text_field(&target.name),
        }
    }

    /// As a plan has it: not checked.
    pub(super) fn target(&self) -> Target {
        Target {
            name: field_text(&self.name),
            centre: point(self.centre_mm),
            diameter_mm: self.diameter_mm,
            entry: (self.flags & Self::ENTRY != 0).then(|| point(self.entry_mm)),
            stop_mm: self.stop_mm,
        }
    }
}

impl PlanMeasure {
    /// None: what a request has that measures nothing.
    pub const NONE: Self = Self {
        points_mm: [[0.0; 3]; 3],
        count: 0,
    };

    /// That of a plan.
    pub fn of(measure: &Measure) -> Self {
        let mut points_mm = [[0.0; 3]; 3];
        for (place, p) in points_mm.iter_mut().zip(measure.points()) {
            *place = p.mm();
        }
        Self {
            points_mm,
            count: measure.points().len() as u64,
        }
    }

    pub(super) fn measure(&self) -> Result<Measure, PlanMessageError> {
        let [a, b, c] = self.points_mm.map(point);
        match self.count {
            2 => Ok(Measure::Distance([a, b])),
            3 => Ok(Measure::Angle([a, b, c])),
            count => Err(PlanMessageError::Points(count)),
        }
    }
}

impl Plan {
    /// A person has confirmed it: it is read-only.
    pub const CONFIRMED: u64 = 1;
    /// What stands in its file is not this plan: somebody else has changed it.
    pub const CHANGED_ELSEWHERE: u64 = 2;

    /// That of a file with this id, of which `depth` changes can be taken back and made again.
    pub fn of(plan: &plan::Plan, file_id: u64, depth: [usize; 2]) -> Self {
        let mut message = Self {
            t_ns: 0,
            file_id,
            undos: depth[0] as u32,
            redos: depth[1] as u32,
            // A plan has no more than there is room for.
            targets: plan.targets.len().min(MAX_TARGETS) as u32,
            measures: plan.measures.len().min(MAX_MEASURES) as u32,
            flags: if plan.confirmed.is_some() { Self::CONFIRMED } else { 0 },
            volume: plan.volume.0,
            by: text_field(plan.confirmed.as_ref().map_or("", |confirmed| &confirmed.by)),
            at: text_field(plan.confirmed.as_ref().map_or("", |confirmed| &confirmed.at)),
            target: [PlanTarget::NONE; MAX_TARGETS],
            measure: [PlanMeasure::NONE; MAX_MEASURES],
            notes: text_field(&plan.notes),
        };
        for (place, target) in message.target.iter_mut().zip(&plan.targets) {
            *place = PlanTarget::of(target);
        }
        for (place, measure) in message.measure.iter_mut().zip(&plan.measures) {
            *place = PlanMeasure::of(measure);
        }
        message
    }

    /// The plan: the door from the bus to geometry.
    ///
    /// # Errors
    /// Each variant of [`PlanMessageError`].
    pub fn plan(&self) -> Result<plan::Plan, PlanMessageError> {
        let targets = counted("targets", self.targets, &self.target)?;
        let measures = counted("measures", self.measures, &self.measure)?;
        let confirmed = (self.flags & Self::CONFIRMED != 0).then(|| Confirmed {
            by: field_text(&self.by),
            at: field_text(&self.at),
        });
        let plan = plan::Plan {
            volume: VolumeId(self.volume),
            targets: targets.iter().map(PlanTarget::target).collect(),
            measures: measures.iter().map(PlanMeasure::measure).collect::<Result<_, _>>()?,
            notes: field_text(&self.notes),
            confirmed,
        };
        Ok(plan.checked()?)
    }
}

fn counted<'a, T>(what: &'static str, count: u32, all: &'a [T]) -> Result<&'a [T], PlanMessageError> {
    all.get(..count as usize).ok_or(PlanMessageError::Count {
        what,
        found: count,
        most: all.len(),
    })
}

fn point([x, y, z]: [f64; 3]) -> Point<Ct> {
    Point::new(x, y, z)
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn plan() -> plan::Plan {
        let zero = Point::new(0.0, 0.0, 0.0);
        plan::Plan {
            targets: vec![
                target(),
                Target {
                    name: "b".to_owned(),
                    entry: None,
                    ..target()
                },
            ],
            measures: vec![
                Measure::Distance([zero, Point::new(1.0, 0.0, 0.0)]),
                Measure::Angle([zero, Point::new(1.0, 0.0, 0.0), Point::new(1.0, 1.0, 0.0)]),
            ],
            confirmed: Some(Confirmed {
                by: "é".repeat(32),
                at: "2026-11-25T12:00:00Z".to_owned(),
            }),
            notes: "é".repeat(MAX_NOTES / 2),
            ..plan::Plan::new(VolumeId([9; 32]))
        }
    }

    #[test]
    fn a_plan_comes_back_over_the_bus() {
        let told = Plan::of(&plan(), 5, [3, 2]);
        assert_eq!((told.plan(), told.undos, told.redos), (Ok(plan()), 3, 2));
        let open = plan::Plan {
            confirmed: None,
            ..plan()
        };
        assert_eq!(Plan::of(&open, 5, [0, 0]).plan(), Ok(open));
    }

    #[test]
    fn what_is_no_plan_is_refused() {
        let good = Plan::of(&plan(), 5, [0, 0]);
        let said = |plan: Plan| plan.plan().unwrap_err().to_string();
        assert!(said(Plan { targets: 65, ..good }).contains("65 targets, and room for 64"));
        assert!(
            said(Plan {
                measures: u32::MAX,
                ..good
            })
            .contains("room for 32")
        );
        let mut bad = good;
        bad.measure[1].count = 4;
        assert!(said(bad).contains("a measure of 4 points"));
        let mut bad = good;
        bad.target[1].centre_mm[2] = f64::NAN;
        assert!(said(bad).contains("centre of b: found NaN"));
        let mut bad = good;
        bad.target[1].name = good.target[0].name;
        assert!(said(bad).contains("already"));
    }
}
