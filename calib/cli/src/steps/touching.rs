//! The patient by touched points: known ones in their order, or beads in any.

use std::path::PathBuf;
use std::rc::Rc;

use bus::message::{StepFigure, StepPoint, Steps};
use geometry::{Ct, Point};
use scene::steps::KnownPoint;

use super::course::{Around, Course, Listen, Moment, Proposal, Said};
use super::hand;
use super::made::Registered;
use super::touched::{Touch, Touches};
use crate::beads::BeadsFile;
use crate::store;

/// The file of a touch that was made just now, all of them, and the pairs.
const TOUCH: &str = "touch.csv";
const TOUCHED: &str = "touched.csv";
const PAIRS: &str = "pairs.csv";
/// A registration takes so many points.
const FEWEST: usize = 3;
/// With three points one that was touched elsewhere is not seen; where there are more, so many are asked for.
const TELLING: usize = 4;
/// The least that comes to what a touch states of itself, along each axis, mm: a hand, and the point's place in the CT, as `calib match` takes them.
const HAND_MM: f64 = 0.3;
const CT_MM: f64 = 0.1;

/// What is touched.
enum Of {
    /// Known points; the next one to be touched.
    Points(Vec<KnownPoint>, usize),
    /// The beads in this file, with their places.
    Beads(PathBuf, Vec<Point<Ct>>),
}

/// The registration of the patient by touched points.
pub(super) struct Touching {
    around: Rc<Around>,
    of: Of,
    touches: Touches,
    /// Of the touches there are; `None`: they are too few, or were not computed yet.
    made: Option<Registered>,
    is_due: bool,
}

impl Touching {
    pub(super) fn points(around: &Rc<Around>, points: Vec<KnownPoint>) -> Self {
        Self::new(around, Of::Points(points, 0))
    }

    /// Reads the beads.
    pub(super) fn beads(around: &Rc<Around>, path: PathBuf) -> Result<Self, String> {
        let (file, _) = BeadsFile::read(&path).map_err(|error| error.to_string())?;
        let centres = file.beads.iter().map(|bead| {
            let [x, y, z] = bead.centre_mm;
            Point::new(x, y, z)
        });
        Ok(Self::new(around, Of::Beads(path, centres.collect())))
    }

    fn new(around: &Rc<Around>, of: Of) -> Self {
        Self {
            around: around.clone(),
            of,
            touches: Touches::default(),
            made: None,
            is_due: false,
        }
    }

    /// What the next touch is called, and where it is to be.
    fn next(&self) -> (String, Option<Point<Ct>>) {
        let count = self.touches.rows().len();
        match &self.of {
            Of::Points(points, next) => (label(*next), points.get(*next).map(|point| point.place)),
            Of::Beads(_, centres) => (label(count), centres.get(count % centres.len().max(1)).copied()),
        }
    }

    /// The touch of a known point.
    fn touch_of(&self, point: usize) -> Option<&Touch> {
        let name = label(point);
        self.touches.rows().iter().find(|touch| touch.name == name)
    }

    /// The next of the known points is the first that was not touched.
    fn go_on(&mut self) {
        let Of::Points(points, _) = &self.of else { return };
        let next = (0..points.len()).find(|&point| self.touch_of(point).is_none());
        let next = next.unwrap_or(points.len());
        if let Of::Points(_, at) = &mut self.of {
            *at = next;
        }
    }

    /// Something was touched or taken back.
    fn changed(&mut self) -> Result<(), String> {
        self.made = None;
        self.is_due = self.touches.rows().len() >= FEWEST;
        self.go_on();
        self.touches.write(&self.around.work.join(TOUCHED))
    }

    /// A refusal with the point's own name in the place of that on the command line.
    fn in_words(&self, why: &str) -> String {
        let (label, _) = self.next();
        let Of::Points(points, next) = &self.of else {
            return why.to_owned();
        };
        let name = points.get(*next).map_or(label.as_str(), |point| point.name.as_str());
        why.replacen(&format!("touch of {label}:"), &format!("touch of {name}:"), 1)
    }

    fn most(&self) -> usize {
        match &self.of {
            Of::Points(points, _) => points.len(),
            Of::Beads(_, centres) => centres.len(),
        }
    }

    /// Pairs of the touched points with their known places, in a file that `calib register` reads.
    fn write_pairs(&self, points: &[KnownPoint]) -> Result<(), String> {
        // With all that the touches state, and the calibration that they are with: their first line.
        let mut text = self.touches.of() + "\nto_x,to_y,to_z,label,";
        let columns: Vec<String> = self
            .touches
            .columns()
            .map(|name| match name {
                "x" | "y" | "z" => format!("from_{name}"),
                name => name.to_owned(),
            })
            .collect();
        text += &(columns.join(",") + "\n");
        for (i, point) in points.iter().enumerate() {
            let Some(touch) = self.touch_of(i) else { continue };
            let [a, b, c] = point.place.mm();
            text += &format!("{a},{b},{c},{}\n", touch.line);
        }
        let path = self.around.work.join(PAIRS);
        store::write(&path, Ok(text), std::iter::empty()).map_err(|error| error.to_string())
    }

    fn shown(&self) -> Vec<StepPoint> {
        let pair = |label: &str| {
            let made = self.made.as_ref()?;
            let pair = made.file.pairs.iter().find(|pair| pair.label == label)?;
            Some((made, pair))
        };
        let on = |label: &str, point: StepPoint| pair(label).map_or(point, |(made, pair)| made.on_point(pair, point));
        match &self.of {
            Of::Points(points, _) => {
                let point = |(i, known): (usize, &KnownPoint)| {
                    let is_touched = self.touch_of(i).is_some();
                    let point = StepPoint {
                        flags: if is_touched { StepPoint::TOUCHED } else { 0 },
                        touches: is_touched.into(),
                        ..StepPoint::named(&known.name)
                    };
                    on(&label(i), point)
                };
                points.iter().enumerate().map(point).collect()
            }
            // `calib match` says of each pair which line was touched: the first two lines of the file are its head.
            Of::Beads(..) => (0..self.touches.rows().len()).map(|i| self.shown_touch(i)).collect(),
        }
    }

    /// A touch of some bead.
    fn shown_touch(&self, i: usize) -> StepPoint {
        let made = self.made.as_ref();
        let pair = made.and_then(|made| made.file.pairs.iter().find(|pair| pair.lines[1] == i + 3));
        let name = match (pair, made) {
            (Some(pair), _) => format!("touch {}: {}", i + 1, pair.label),
            (None, Some(_)) => format!("touch {}: on no bead", i + 1),
            (None, None) => format!("touch {}", i + 1),
        };
        let point = StepPoint {
            flags: StepPoint::TOUCHED
                | if made.is_some() && pair.is_none() {
                    StepPoint::OFF
                } else {
                    0
                },
            touches: 1,
            ..StepPoint::named(&name)
        };
        match (made, pair) {
            (Some(made), Some(pair)) => made.on_point(pair, point),
            _ => point,
        }
    }
}

/// The name of a touch on the command line.
fn label(i: usize) -> String {
    format!("p{}", i + 1)
}

impl Course for Touching {
    fn listen(&self) -> Result<Listen, String> {
        let (name, place) = self.next();
        let place = match (&self.of, place) {
            (Of::Points(..), None) => {
                return Err("every point was touched; choose the one to be touched again".to_owned());
            }
            (_, place) => place,
        };
        if self.touches.rows().len() >= Steps::POINTS && matches!(self.of, Of::Beads(..)) {
            return Err(format!("{} touches are the most", Steps::POINTS));
        }
        let (to, seconds) = (self.around.file(TOUCH), self.around.spec.touch_s.to_string());
        // The file is of one touch; it is made anew.
        let _ = std::fs::remove_file(&to);
        let words = [
            "calib",
            "touch",
            &name,
            "--live",
            &self.around.run,
            "--to",
            &to,
            "--seconds",
            &seconds,
        ];
        let count = self.touches.rows().len() + 1;
        Ok(Listen {
            words: words.map(str::to_owned).to_vec(),
            practice: self.around.room.and(place).map(|place| hand::touch(place, count)),
        })
    }

    fn heard(&mut self, said: Said, _: Moment) -> Result<(), String> {
        said.map_err(|why| self.in_words(&why))?;
        let taken = self.touches.take(&self.around.work.join(TOUCH))?;
        self.touches.keep_last_of(&taken.name);
        self.changed()?;
        taken.told()
    }

    fn compute(&mut self) -> Result<Option<Vec<String>>, String> {
        if !std::mem::take(&mut self.is_due) {
            return Ok(None);
        }
        let target = self.around.target.as_ref().map(|(_, place)| {
            let [x, y, z] = place.mm();
            format!("--target={x},{y},{z}")
        });
        let target = target.iter().map(String::as_str);
        Ok(Some(match &self.of {
            Of::Points(points, _) => {
                self.write_pairs(points)?;
                // What comes to what the touches state themselves.
                let least = HAND_MM.hypot(CT_MM).to_string();
                let pairs = self.around.file(PAIRS);
                let words = ["--pairs", &pairs, "--least-noise-mm", &least, "--json"];
                self.around.command("register", words.into_iter().chain(target))
            }
            Of::Beads(path, _) => {
                let (beads, touched) = (path.to_string_lossy(), self.around.file(TOUCHED));
                let words = [beads.as_ref(), &touched, "--json"];
                self.around.command("match", words.into_iter().chain(target))
            }
        }))
    }

    fn computed(&mut self, said: Said) -> Result<(), String> {
        self.made = Some(Registered::of(said)?);
        Ok(())
    }

    fn back(&mut self) -> bool {
        let had = self.touches.pop();
        // What cannot be written now is written with the next touch.
        let _ = self.changed();
        had
    }

    fn choose(&mut self, point: usize) -> bool {
        match &mut self.of {
            Of::Points(points, next) if point < points.len() => {
                *next = point;
                true
            }
            _ => false,
        }
    }

    fn proposal(&self) -> Result<Proposal, String> {
        let (count, most) = (self.touches.rows().len(), self.most());
        let asked = TELLING.min(most);
        if count < asked {
            return Err(format!(
                "{count} of {most} points were touched; at least {asked} are needed"
            ));
        }
        let made = self.made.as_ref().ok_or("these touches give no registration")?;
        match &made.refused {
            Some(why) => Err(why.clone()),
            None => Ok(Proposal {
                path: self.around.files[1].clone().unwrap_or_default(),
                text: made.text.clone(),
            }),
        }
    }

    fn show(&self, mut steps: Steps) -> Steps {
        let (count, most) = (self.touches.rows().len(), self.most());
        (steps.step, steps.steps) = (count.min(most) as u32, most as u32);
        let what = match &self.of {
            Of::Points(points, next) => {
                steps.next = *next as u32;
                match points.get(*next) {
                    Some(point) => format!("Put the tip on {} and hold it still.", point.name),
                    None => "Every point was touched. Look at the residuals; touch again what is off.".to_owned(),
                }
            }
            Of::Beads(..) => "Put the tip on a bead that was not touched yet, whichever, and hold it still.".to_owned(),
        };
        (steps.title, steps.what) = (Steps::field("Patient: touch the points"), Steps::field(&what));
        let made = self.made.as_ref();
        let gates = made.map(Registered::gates).unwrap_or_default();
        let mut figures = made.map(Registered::figures).unwrap_or_default();
        if let (Some(made), Some((name, place))) = (made, &self.around.target) {
            steps.target = Steps::field(name);
            if let Some(at) = made.at(*place) {
                let c = at.covariance();
                steps.covariance = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|place| c[place]);
                steps.target_95_mm = at.radius_95_mm();
                figures.push(StepFigure::new(&format!(
                    "registration at {name}: 95 % of its errors within {:.2} mm",
                    at.radius_95_mm()
                )));
            }
        }
        steps.with(&self.shown(), &gates, &figures)
    }
}
