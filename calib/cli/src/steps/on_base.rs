//! The tool in its seat on the calibration base, which is touched with its own tip.

use std::rc::Rc;

use bus::message::{Practice, StepFigure, StepPoint, Steps};
use geometry::{Base, Point, Vector};

use super::course::{Around, Course, Listen, Moment, Proposal, Said};
use super::hand;
use super::made::Calibrated;
use super::touched::Touches;
use crate::base::Drawn;
use crate::store;

const TIP: &str = "tip.json";
const TOUCH: &str = "touch.csv";
const TOUCHED: &str = "base.csv";
const BASE: &str = "base.json";
/// How long the tool is left in its seat, s.
const SEATED: &str = "3";
/// What is touched, and how often: over its whole length.
const TOUCHED_PARTS: [(&str, &str, usize); 4] = [
    ("plane", "the plane", 10),
    ("groove_0", "the first groove", 6),
    ("groove_1", "the second groove", 6),
    ("groove_2", "the third groove", 6),
];

/// Tip, plane and grooves, seat.
pub(super) struct OnBase {
    around: Rc<Around>,
    drawn: Drawn,
    tip: Option<Calibrated>,
    touches: Touches,
    /// The part that a person chose to touch more of.
    chosen: Option<usize>,
    base: Option<Calibrated>,
    is_due: bool,
    tool: Option<Calibrated>,
}

/// Where a person stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum At {
    Tip,
    Part(usize),
    Seat,
}

impl OnBase {
    /// Reads the drawing.
    pub(super) fn new(around: &Rc<Around>) -> Result<Self, String> {
        let drawing = around.spec.drawing.clone().unwrap_or_default();
        let drawn = Drawn::read(&drawing).map_err(|error| error.to_string())?;
        if drawn.base_from_tool.is_none() {
            return Err(format!(
                "{}: the base is drawn without a table [seat]",
                drawing.display()
            ));
        }
        Ok(Self {
            around: around.clone(),
            drawn,
            tip: None,
            touches: Touches::default(),
            chosen: None,
            base: None,
            is_due: false,
            tool: None,
        })
    }

    fn count(&self, part: usize) -> usize {
        let name = TOUCHED_PARTS[part].0;
        self.touches.rows().iter().filter(|row| row.name == name).count()
    }

    fn at(&self) -> At {
        if !self.tip.as_ref().is_some_and(Calibrated::is_accepted) {
            return At::Tip;
        }
        let missing = (0..TOUCHED_PARTS.len()).find(|&part| self.count(part) < TOUCHED_PARTS[part].2);
        match (self.chosen.or(missing), &self.base) {
            (Some(part), _) => At::Part(part),
            (None, Some(base)) if base.is_accepted() => At::Seat,
            // The base was refused: more touches of its plane say more.
            (None, _) => At::Part(0),
        }
    }

    fn practice(&self, at: At) -> Option<Practice> {
        let room = self.around.room?;
        let normal = self.drawn.drawing.normal();
        Some(match at {
            At::Tip => hand::pivot(room.divot),
            At::Part(part) => hand::touch_base(self.place(part), normal, self.touches.rows().len() + 1),
            At::Seat => hand::seat(self.drawn.base_from_tool.as_ref()?.transform()),
        })
    }

    /// Where the simulated hand touches a part the next time: along the groove, and about its middle on the plane.
    fn place(&self, part: usize) -> Point<Base> {
        let (count, drawing) = (self.count(part), &self.drawn.drawing);
        let grooves = drawing.grooves();
        let share = (count as f64 * 0.381_966).fract();
        let groove = part.checked_sub(1).and_then(|k| grooves.get(k));
        if let Some(groove) = groove {
            return groove.start.lerp(groove.end, 0.05 + 0.9 * share);
        }
        let reach = |point: Point<Base>| drawing.plane().distance(point);
        let far = grooves
            .iter()
            .flat_map(|g| [g.start, g.end])
            .map(reach)
            .fold(0.0, f64::max);
        let normal = drawing.normal().vector();
        let aside = |axis: Vector<Base>| axis - normal * normal.dot(axis);
        let (x, y, z) = (
            aside(Vector::new(1.0, 0.0, 0.0)),
            aside(Vector::new(0.0, 1.0, 0.0)),
            aside(Vector::new(0.0, 0.0, 1.0)),
        );
        // The longest shadow of an axis on the plane is 0.8 long at least.
        let along = [x, y, z]
            .into_iter()
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
            .unwrap_or(x);
        let along = along * (1.0 / along.norm());
        let (sin, cos) = (2.4 * count as f64).sin_cos();
        drawing.plane() + (along * cos + normal.cross(along) * sin) * (far * (0.4 + 0.6 * share))
    }

    fn newest(&self) -> Option<&Calibrated> {
        match self.at() {
            At::Tip => self.tip.as_ref(),
            At::Part(_) => self.base.as_ref(),
            At::Seat => self.tool.as_ref().or(self.base.as_ref()),
        }
    }

    fn touched(&mut self) -> Result<(), String> {
        let taken = self.touches.take(&self.around.work.join(TOUCH))?;
        self.chosen = self.chosen.filter(|&part| TOUCHED_PARTS[part].0 != taken.name);
        self.changed()?;
        taken.told()
    }

    fn changed(&mut self) -> Result<(), String> {
        (self.base, self.tool) = (None, None);
        self.is_due = (0..TOUCHED_PARTS.len()).all(|part| self.count(part) >= TOUCHED_PARTS[part].2);
        self.touches.write(&self.around.work.join(TOUCHED))
    }
}

fn keep(around: &Around, name: &str, made: &Calibrated) -> Result<(), String> {
    if !made.is_accepted() {
        return Ok(());
    }
    let path = around.work.join(name);
    store::write(&path, Ok(made.text.clone()), std::iter::empty()).map_err(|error| error.to_string())
}

impl Course for OnBase {
    fn listen(&self) -> Result<Listen, String> {
        let around = &self.around;
        let (turn, touch) = (around.spec.turn_s.to_string(), around.spec.touch_s.to_string());
        let (tip, to, base) = (around.file(TIP), around.file(TOUCH), around.file(BASE));
        let at = self.at();
        let words = match at {
            At::Tip => around.command("pivot", ["--seconds", &turn, "--json"]),
            At::Part(part) => {
                // The file is of one touch; it is made anew.
                let _ = std::fs::remove_file(&to);
                let name = TOUCHED_PARTS[part].0;
                let words = [
                    "calib",
                    "touch",
                    name,
                    "--live",
                    &around.run,
                    "--tip",
                    &tip,
                    "--to",
                    &to,
                    "--seconds",
                    &touch,
                ];
                words.map(str::to_owned).to_vec()
            }
            At::Seat => around.command("seat", ["--base", &base, "--seconds", SEATED, "--json"]),
        };
        Ok(Listen {
            words,
            practice: self.practice(at),
        })
    }

    fn heard(&mut self, said: Said, _: Moment) -> Result<(), String> {
        match self.at() {
            At::Tip => {
                let made = Calibrated::of(said)?;
                keep(&self.around, TIP, &made)?;
                self.tip = Some(made);
                Ok(())
            }
            At::Part(_) => {
                said?;
                self.touched()
            }
            At::Seat => {
                self.tool = Some(Calibrated::of(said)?);
                Ok(())
            }
        }
    }

    fn compute(&mut self) -> Result<Option<Vec<String>>, String> {
        let is_due = std::mem::take(&mut self.is_due);
        let drawing = self.around.spec.drawing.clone().unwrap_or_default();
        let (touched, drawing) = (self.around.file(TOUCHED), drawing.to_string_lossy().into_owned());
        Ok(is_due.then(|| {
            self.around
                .command("base", [touched.as_str(), "--drawing", &drawing, "--json"])
        }))
    }

    fn computed(&mut self, said: Said) -> Result<(), String> {
        let made = Calibrated::of(said)?;
        keep(&self.around, BASE, &made)?;
        self.base = Some(made);
        Ok(())
    }

    fn back(&mut self) -> bool {
        if self.tool.take().is_some() {
            return true;
        }
        match self.touches.pop() {
            // What cannot be written now is written with the next touch.
            true => self.changed().is_ok(),
            false => self.tip.take().is_some(),
        }
    }

    fn choose(&mut self, point: usize) -> bool {
        let may = point < TOUCHED_PARTS.len() && self.at() != At::Tip;
        if may {
            self.chosen = Some(point);
        }
        may
    }

    fn proposal(&self) -> Result<Proposal, String> {
        let made = self.tool.as_ref();
        let made = made.ok_or_else(|| match self.at() {
            At::Tip => "turn the instrument first".to_owned(),
            At::Part(part) => format!("{} is still to be touched", TOUCHED_PARTS[part].1),
            At::Seat => "the tool is still to be put into its seat".to_owned(),
        });
        let made = made?;
        match &made.refused {
            Some(why) => Err(why.clone()),
            None => Ok(Proposal {
                path: self.around.files[0].clone().unwrap_or_default(),
                text: made.text.clone(),
            }),
        }
    }

    fn show(&self, mut steps: Steps) -> Steps {
        let at = self.at();
        let (step, title, what) = match at {
            At::Tip => (
                0,
                "Tip: pivot",
                "Put the tip into the divot and turn the instrument about it, to all sides. The tip must not slip."
                    .to_owned(),
            ),
            At::Part(part) => (
                1 + part,
                "Base: touch",
                format!(
                    "Put the tip on {}, elsewhere than before, and hold it still.",
                    TOUCHED_PARTS[part].1
                ),
            ),
            At::Seat => (5, "Seat", "Put the tool into its seat and leave it alone.".to_owned()),
        };
        (steps.step, steps.steps) = (step as u32, 6);
        (steps.title, steps.what) = (Steps::field(title), Steps::field(&what));
        let points = (0..TOUCHED_PARTS.len()).map(|part| {
            let (count, (_, words, asked)) = (self.count(part), TOUCHED_PARTS[part]);
            StepPoint {
                touches: count as u32,
                flags: if count >= asked { StepPoint::TOUCHED } else { 0 },
                ..StepPoint::named(&format!("{words}: {count} of {asked}"))
            }
        });
        if let At::Part(part) = at {
            steps.next = part as u32;
        }
        let gates = self.newest().map(Calibrated::gates).unwrap_or_default();
        let mut figures = self.newest().map(Calibrated::figures).unwrap_or_default();
        let refused = self.base.as_ref().and_then(|base| base.refused.as_ref());
        figures.extend(refused.map(|why| StepFigure::new(why)));
        steps.with(&points.collect::<Vec<_>>(), &gates, &figures)
    }
}
