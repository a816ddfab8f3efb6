//! One operation, from the marker's calibration to the last target.

mod lines;
mod organs;

use std::cell::RefCell;
use std::path::Path;

use chance::{Chance, mix};
use geometry::{Ct, Marker, Point, Reference, Rigid};
use phantom::Landmark;
use tracker_proc::chain::{Chain, Registration};
use tracker_proc::operating_room::OperatingRoom;

use crate::approach::{Approached, Tape, approach, at_target, longest_s, push, task};
use crate::breathing::Breath;
use crate::images::Images;
use crate::patient::{metal, patient, touched};
use crate::plan::{Bump, PlantedIn, Stratum};
use crate::record::{Ended, Row};
use crate::room::{TUBE, TrueRoom};
use crate::steps::{Prepared, Refused, Step, Verdict, Work, true_from_calibrated, true_tool};
use crate::tissue::pushed;
use crate::truth::{Told, True, shifted, told};

use lines::{empty, is_right, misplaced, with};
use organs::Organs;

/// What is drawn of an operation, by number.
const BUMPED: u64 = 1;
const TASKS: u64 = 100;

/// The words of a check that refused the registration, and of one that could not be made.
const FAIL: &str = "fail";
const NOT_MADE: &str = "not-made";

/// What is the same for all targets of an operation.
struct Ready {
    room: TrueRoom,
    quiet: OperatingRoom,
    chain: Chain,
    truth: True,
    breath: Option<Breath>,
    bump: &'static str,
    check: String,
    /// Why the check refused.
    refused: Option<String>,
    /// The emitters as they were calibrated.
    emitters: Vec<Point<Marker>>,
    ct_hash: String,
}

/// The lines of an operation, one for each target. `folder` is its own, and empty.
///
/// # Errors
/// Where the machine failed: of such an operation there are no lines.
pub(crate) fn operate(stratum: &Stratum, number: u64, images: &Images, folder: &Path) -> Result<Vec<Row>, Refused> {
    let (work, targets) = (work(stratum, number, folder), stratum.targets());
    match ready(&work, number, images, &targets) {
        Ok(mut ready) => {
            let mut rows = Vec::new();
            for (at, target) in (0..).zip(&targets) {
                rows.push(ready.approached(&work, number, (target, images), (task_seed(&work, at), None))?);
            }
            Ok(rows)
        }
        Err(refused) if refused.is_of_the_machine() => Err(refused),
        Err(Refused {
            step,
            why,
            registration,
        }) => {
            let why = images.unnamed(&why, folder);
            let refused = |target: &Landmark| {
                let row = Row {
                    step: step.word().to_owned(),
                    why: why.clone(),
                    ..empty(stratum, number, target)
                };
                match &registration {
                    Some(registration) => misplaced(registration, stratum.dials.check_max_mm, target.centre, row),
                    None => row,
                }
            };
            Ok(targets.iter().map(refused).collect())
        }
    }
}

/// The files of an operation, and what all that is drawn follows from.
fn work<'a>(stratum: &'a Stratum, number: u64, folder: &'a Path) -> Work<'a> {
    let name = blake3::hash(stratum.own_name.as_bytes());
    // The first bytes of the name's hash: strata of one seed draw apart.
    let of_name = name
        .as_bytes()
        .iter()
        .take(8)
        .fold(0_u64, |all, byte| (all << 8) | u64::from(*byte));
    Work {
        stratum,
        seed: mix(stratum.seed ^ mix(of_name ^ mix(number))),
        folder,
    }
}

fn task_seed(work: &Work<'_>, at: u64) -> u64 {
    mix(work.seed ^ mix(TASKS + at))
}

/// One approach of an operation once more, with all its frames.
pub(crate) struct Again {
    /// Its line, as it was.
    pub(crate) row: Row,
    /// The frames.
    pub(crate) tape: Tape,
    /// What made poses of them.
    pub(crate) chain: Chain,
    /// The emitters as they were calibrated.
    pub(crate) emitters: Vec<Point<Marker>>,
    /// The hash of the examination.
    pub(crate) ct_hash: String,
}

/// Does the approach of the `at`-th target once more; the files of the operation are left in `folder`.
///
/// # Errors
/// Those of its steps, and of the machine.
pub(crate) fn again(
    stratum: &Stratum,
    (number, at): (u64, usize),
    images: &Images,
    folder: &Path,
) -> Result<Again, Refused> {
    let (work, targets) = (work(stratum, number, folder), stratum.targets());
    let mut ready = ready(&work, number, images, &targets)?;
    // The time of the approaches before it goes by.
    for _ in 0..at {
        ready.room.wait(longest_s(ready.room.rate_hz()));
    }
    let target = targets.get(at);
    let target = target.ok_or_else(|| Refused::at(Step::Chain)("the operation has no such target"))?;
    let tape = RefCell::new(Tape::default());
    let seed = task_seed(&work, at as u64);
    let row = ready.approached(&work, number, (target, images), (seed, Some(&tape)))?;
    Ok(Again {
        row,
        tape: tape.into_inner(),
        chain: ready.chain,
        emitters: ready.emitters,
        ct_hash: ready.ct_hash,
    })
}

/// Everything before the first approach.
fn ready(work: &Work<'_>, number: u64, images: &Images, targets: &[Landmark]) -> Result<Ready, Refused> {
    let dials = &work.stratum.dials;
    let first = targets
        .first()
        .map_or(Point::new(0.0, 0.0, 0.0), |target| target.centre);
    let metal = metal(&patient(), &dials.beads);
    let examined = images.of(work.stratum, number, &metal).map_err(Refused::at(Step::Ct))?;
    let mut room = TrueRoom::new(work.stratum, TUBE, work.seed).map_err(Refused::at(Step::Marker))?;
    let mut prepared = work.marker(&mut room, (TUBE, Step::Marker))?;
    work.tool(&mut room, &mut prepared)?;
    let count = touched(&dials.beads);
    match &dials.surface {
        Some(surface) => work.registered_by_surface(surface, room.ct_from_reference(), &examined, targets)?,
        None => {
            let touching = (examined.path.as_path(), &metal[..count.min(metal.len())]);
            work.registered(&mut room, &mut prepared, touching, first)?;
        }
    }
    let chain = work.chain(&prepared, &examined.beads.ct_hash, first)?;
    let registered = room.ct_from_reference();
    let bumped = dials.bump.and_then(|bump| drawn(bump, work.seed));
    if let Some((motion, "before")) = bumped {
        room.bump(motion).map_err(Refused::at(Step::Check))?;
    }
    let (check, refused) = check(work, &mut room, &mut prepared, (&examined.beads, metal.get(count)))?;
    let refused = refused.map(|why| images.unnamed(&why, work.folder));
    if let Some((motion, "after")) = bumped {
        room.bump(motion).map_err(Refused::at(Step::Chain))?;
    }
    let gauge = true_from_calibrated(&room.emitters(), &prepared.emitters).map_err(Refused::at(Step::Marker))?;
    Ok(Ready {
        quiet: room.quiet().map_err(Refused::at(Step::Chain))?,
        chain: planted(work.stratum, chain).ok_or_else(|| Refused::at(Step::Chain)("the planted error cannot be"))?,
        truth: True {
            registered,
            ct_from_reference: room.ct_from_reference(),
            marker_from_tool: true_tool(&room),
            gauge,
        },
        breath: dials.breathing.map(|breathing| Breath::drawn(breathing, work.seed)),
        bump: bumped.map_or("", |(_, when)| when),
        check,
        refused,
        emitters: prepared.emitters,
        ct_hash: examined.beads.ct_hash.clone(),
        room,
    })
}

/// What the check says, and why it refuses; nothing where there is no bead left to be touched.
///
/// # Errors
/// Where the machine failed: the check has said nothing.
fn check(
    work: &Work<'_>,
    room: &mut TrueRoom,
    prepared: &mut Prepared,
    (beads, place): (&calib_cli::BeadsFile, Option<&Point<Ct>>),
) -> Result<(String, Option<String>), Refused> {
    let Some(place) = place else {
        return Ok((String::new(), None));
    };
    match work.checked(room, prepared, beads, *place) {
        Ok(Verdict::Passed(word)) => Ok((word, None)),
        Ok(Verdict::Fail(why)) => Ok((FAIL.to_owned(), Some(why))),
        Err(refused) if refused.is_of_the_machine() => Err(refused),
        Err(refused) => Ok((NOT_MADE.to_owned(), Some(refused.why))),
    }
}

/// How the marker on the patient is moved in this operation, and when.
fn drawn(bump: Bump, seed: u64) -> Option<(Rigid<Reference, Reference>, &'static str)> {
    let chance = Chance::new(seed, BUMPED);
    let when = if chance.uniform(1) < 0.5 { "before" } else { "after" };
    let moved = chance.uniform(0) < bump.share;
    moved.then(|| (push(Chance::new(seed, BUMPED + 1), bump.mm, bump.deg), when))
}

/// The chain with the error that nobody states.
fn planted(stratum: &Stratum, chain: Chain) -> Option<Chain> {
    let Some(planted) = stratum.dials.planted else {
        return Some(chain);
    };
    let (mut tool, mut registration) = (chain.marker_from_tool, chain.registration);
    match (planted.link, registration) {
        (PlantedIn::Tool, _) => tool = shifted(tool, planted.mm)?,
        (PlantedIn::Registration, Registration::Referenced(found)) => {
            registration = Registration::Referenced(shifted(found, planted.mm)?);
        }
        (PlantedIn::Registration, Registration::Fixed(found)) => {
            registration = Registration::Fixed(shifted(found, planted.mm)?);
        }
    }
    Some(Chain {
        marker_from_tool: tool,
        registration,
        ..chain
    })
}

impl Ready {
    /// The line of one target.
    ///
    /// # Errors
    /// Where the machine failed.
    fn approached(
        &mut self,
        work: &Work<'_>,
        number: u64,
        (target, images): (&Landmark, &Images),
        (seed, tape): (u64, Option<&RefCell<Tape>>),
    ) -> Result<Row, Refused> {
        let dials = &work.stratum.dials;
        let tissue = dials.tissue.as_ref();
        let (aimed, entry) = match tissue {
            Some(tissue) => (tissue.aimed.centre, Some(tissue.entry)),
            None => (target.centre, None),
        };
        let row = Row {
            bump: self.bump.to_owned(),
            check: self.check.clone(),
            ..empty(work.stratum, number, target)
        };
        let from = self.room.next_frame();
        self.room.wait(longest_s(self.room.rate_hz()));
        let Some(task) = task(seed, (aimed, entry), dials.radius_mm, (&self.quiet, from)) else {
            return Ok(Row {
                step: Step::Way.word().to_owned(),
                ..row
            });
        };
        if let Some(why) = &self.refused {
            let why = why.clone();
            let told = at_target(&task).and_then(|pose| self.unmoved(pose, from, target.centre));
            let row = Row {
                step: Step::Check.word().to_owned(),
                why,
                ..row
            };
            return Ok(self.judged(told, dials.check_max_mm, row));
        }
        // Organs go by all poses on the way, not by the last one.
        let own = RefCell::new(Tape::default());
        let tape = tape.or(tissue.map(|_| &own));
        let done = approach(&task, (&self.room.localizer, &self.chain), dials, from, tape);
        let done = done.map_err(Refused::at(Step::Way))?;
        let organs = match (tissue, tape) {
            (Some(tissue), Some(tape)) => {
                let anatomist = images.organs(tissue).map_err(Refused::at(Step::Organs))?;
                let pushed = pushed(tissue, &anatomist, &tape.borrow().shots, work.seed);
                Organs::Pushed(pushed.map_err(Refused::at(Step::Organs))?)
            }
            _ => self.breath.map_or(Organs::AtRest, Organs::Breathe),
        };
        Ok(self.told(&done, (target.centre, aimed), &organs, (dials.understated, row)))
    }

    /// What would be told of the tool at the target, in a frame without noise.
    fn unmoved(&self, pose: Rigid<Ct, geometry::Tool>, seq: u64, target: Point<Ct>) -> Option<Told> {
        let frame = self.quiet.frame_at(seq, pose);
        let found = self.chain.solve(&frame.tool, &frame.reference).ok()?;
        let moved = self.breath.map(|breath| breath.moved(frame.t_capture_ns as f64 / 1e9));
        told(
            &self.truth,
            &self.chain,
            (&frame, &frame),
            &found.ct_from_tool,
            (target, moved),
        )
    }

    /// The line of an operation that the check refused.
    fn judged(&self, told: Option<Told>, max_mm: f64, row: Row) -> Row {
        let Some(told) = told else { return row };
        Row {
            right: is_right(&self.check, told.registration, max_mm),
            ..with(&told, told.ball_95_mm, row)
        }
    }

    /// The line of an approach: errors at `target`, the miss from what was aimed at.
    fn told(
        &self,
        done: &Approached,
        (target, aimed): (Point<Ct>, Point<Ct>),
        organs: &Organs,
        (times, row): (f64, Row),
    ) -> Row {
        let outcome = done.outcome;
        let row = Row {
            ended: if outcome.is_arrived {
                Ended::Arrived
            } else {
                Ended::GivenUp
            },
            miss_mm: organs.miss_mm(done, aimed),
            time_s: outcome.time_s,
            strokes: outcome.strokes as u64,
            pictures: [done.pictures, done.reasons.iter().sum()],
            reasons: done.reasons,
            model: organs.word().to_owned(),
            ..row
        };
        let told = done.last.as_ref().and_then(|last| {
            let quiet = self.quiet.frame_at(last.frame.seq, last.frame.ct_from_tool);
            let moved = organs.moved(last.frame.t_capture_ns)?;
            told(
                &self.truth,
                &self.chain,
                (&last.frame, &quiet),
                &last.pose,
                (target, moved),
            )
        });
        match told {
            // Where the last picture was lost the sight predicts nothing; the pose before it did.
            Some(mut told) => {
                let predicted_mm = match outcome.predicted_mm.is_finite() {
                    true => outcome.predicted_mm,
                    false => told.ball_95_mm / times,
                };
                told.nees *= times * times;
                let model_numbers = organs.model_numbers(&told);
                Row {
                    model_numbers,
                    ..with(&told, predicted_mm, row)
                }
            }
            None => row,
        }
    }
}

#[cfg(test)]
mod tests;
