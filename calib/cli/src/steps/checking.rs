//! The check: known points are touched, and their distances held against what the registration promises.

use std::rc::Rc;

use bus::message::{Command, StepFigure, StepPoint, Steps};
use serde::Deserialize;

use super::course::{Around, Course, Listen, Moment, Proposal, Report, Said};
use super::hand;

/// What `calib check --json` says.
#[derive(Debug, Deserialize)]
struct Record {
    verdict: String,
    distance_mm: f64,
    predicted_radius_95_mm: f64,
    /// Of the point from the plane of a registration whose points lie in one.
    #[serde(default)]
    off_plane_mm: Option<f64>,
}

impl Record {
    /// Whether a mirrored registration would be seen here; `None` where no other fits.
    fn tells_sides(&self) -> Option<bool> {
        self.off_plane_mm.map(|mm| mm > self.predicted_radius_95_mm)
    }
}

/// A point as it was touched.
#[derive(Debug, Clone)]
struct Found {
    distance_mm: f64,
    radius_mm: f64,
    fails: bool,
    /// See [`Record::tells_sides`].
    tells_sides: Option<bool>,
    moment: Moment,
}

/// Why a check at these points passes no registration whose points lie in a plane (`calib check --help`), in the words of a request.
const MAY_BE_MIRRORED: &str =
    "registered by points in a plane, none touched off it by more than expected: may be mirrored";
const _: () = assert!(MAY_BE_MIRRORED.len() <= Command::TEXT);

/// The check of the registration in use.
pub(super) struct Checking {
    around: Rc<Around>,
    found: Vec<Option<Found>>,
    next: usize,
    /// Something was touched that was not told yet.
    is_due: bool,
}

impl Checking {
    pub(super) fn new(around: &Rc<Around>) -> Self {
        Self {
            around: around.clone(),
            found: vec![None; around.spec.check.len()],
            next: 0,
            is_due: false,
        }
    }

    fn touched(&self) -> impl Iterator<Item = (&str, &Found)> {
        let points = self.around.spec.check.iter().zip(&self.found);
        points.filter_map(|(point, found)| Some((point.name.as_str(), found.as_ref()?)))
    }

    fn is_off(&self, found: &Found) -> bool {
        found.fails || found.distance_mm > self.around.check_mm
    }

    /// Whether the registration may be mirrored for all that was touched.
    fn may_be_mirrored(&self) -> bool {
        let mut told = self.touched().filter_map(|(_, found)| found.tells_sides).peekable();
        told.peek().is_some() && !told.any(|tells| tells)
    }

    /// What was touched under another registration says nothing of this one.
    fn forget_others(&mut self, moment: Moment) {
        for found in &mut self.found {
            if found
                .as_ref()
                .is_some_and(|found| found.moment.registration_id != moment.registration_id)
            {
                *found = None;
            }
        }
    }
}

impl Course for Checking {
    fn listen(&self) -> Result<Listen, String> {
        let point = self.around.spec.check.get(self.next);
        let point = point.ok_or("every point was touched; choose the one to be touched again")?;
        let [x, y, z] = point.place.mm();
        let (known, seconds) = (format!("--known={x},{y},{z}"), self.around.spec.touch_s.to_string());
        Ok(Listen {
            words: self
                .around
                .command("check", [known.as_str(), "--seconds", &seconds, "--json"]),
            practice: self.around.room.map(|_| hand::touch(point.place, self.next + 1)),
        })
    }

    fn heard(&mut self, said: Said, moment: Moment) -> Result<(), String> {
        let outcome = said?;
        if moment.registration_id.is_none() {
            let why = "the registration changed, or no pose rested on it, while the point was touched: touch it again";
            return Err(why.to_owned());
        }
        let record: Record = serde_json::from_str(&outcome.text)
            .map_err(|error| outcome.refused.clone().unwrap_or_else(|| error.to_string()))?;
        self.forget_others(moment);
        self.found[self.next] = Some(Found {
            distance_mm: record.distance_mm,
            radius_mm: record.predicted_radius_95_mm,
            fails: record.verdict == "fail" || outcome.refused.is_some(),
            tells_sides: record.tells_sides(),
            moment,
        });
        self.is_due = true;
        self.next = self.found.iter().position(Option::is_none).unwrap_or(self.found.len());
        Ok(())
    }

    fn compute(&mut self) -> Result<Option<Vec<String>>, String> {
        Ok(None)
    }

    fn computed(&mut self, said: Said) -> Result<(), String> {
        said.map(drop)
    }

    /// A check that failed was told, and is not taken back.
    fn back(&mut self) -> bool {
        false
    }

    fn choose(&mut self, point: usize) -> bool {
        let is_there = point < self.found.len();
        if is_there {
            self.next = point;
        }
        is_there
    }

    fn proposal(&self) -> Result<Proposal, String> {
        Err("a check is not accepted: it holds as soon as every point was touched".to_owned())
    }

    /// A point that is off is told at once, and all when every point was touched.
    fn report(&mut self) -> Option<Report> {
        if !std::mem::take(&mut self.is_due) {
            return None;
        }
        let off = self.touched().find(|(_, found)| self.is_off(found));
        if off.is_none() && self.found.iter().any(Option::is_none) {
            return None;
        }
        let fails = self.touched().find(|(_, found)| found.fails).map(|(name, found)| {
            format!(
                "{name}: {:.2} mm off, {:.2} mm hold 95 % of errors",
                found.distance_mm, found.radius_mm
            )
        });
        // Another point may tell it still.
        let mirrored = || (off.is_none() && self.may_be_mirrored()).then(|| MAY_BE_MIRRORED.to_owned());
        let fails = fails.or_else(mirrored);
        let (points, oldest) = (
            self.touched().count() as u32,
            self.touched().map(|(_, f)| f.moment).min_by_key(|m| m.t_ns)?,
        );
        Some(Report {
            worst_mm: self.touched().map(|(_, found)| found.distance_mm).fold(0.0, f64::max),
            points,
            // The check is as old as its first touch.
            moment: oldest,
            fails: fails.unwrap_or_default(),
        })
    }

    fn show(&self, mut steps: Steps) -> Steps {
        let points = &self.around.spec.check;
        let count = self.touched().count();
        (steps.step, steps.steps, steps.next) = (count as u32, points.len() as u32, self.next as u32);
        let what = match points.get(self.next) {
            Some(point) => format!("Put the tip on {} and hold it still.", point.name),
            None => "Every point was touched.".to_owned(),
        };
        (steps.title, steps.what) = (Steps::field("Check: touch known points"), Steps::field(&what));
        let shown = points.iter().zip(&self.found).map(|(point, found)| {
            let mut shown = StepPoint::named(&point.name);
            if let Some(found) = found {
                let off = if self.is_off(found) { StepPoint::OFF } else { 0 };
                (shown.residual_mm, shown.expected_mm) = (found.distance_mm, found.radius_mm);
                (shown.flags, shown.touches) = (StepPoint::TOUCHED | off, 1);
            }
            shown
        });
        let worst = self.touched().map(|(_, found)| found.distance_mm).fold(0.0, f64::max);
        let line = match count {
            0 => format!("allowed: {} mm", self.around.check_mm),
            _ => format!(
                "the worst {worst:.2} mm; allowed: {} mm, and 1.5 times what is expected",
                self.around.check_mm
            ),
        };
        let mut figures = vec![StepFigure::new(&line)];
        if self.may_be_mirrored() {
            figures.push(StepFigure::new(
                "MAY BE MIRRORED: its points lie in a plane, and none touched here is far enough off it",
            ));
        }
        steps.with(&shown.collect::<Vec<_>>(), &[], &figures)
    }
}
