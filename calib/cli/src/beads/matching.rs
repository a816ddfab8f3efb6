//! `calib match`: touched points to the beads of a CT, without being told which is which, and the registration of both.

use std::path::PathBuf;

use bead::matching::{Errors, Matched, Stated, match_stated};
use clap::Args;
use geometry::{Ct, Point, Tracker};

use super::error::BeadsError;
use super::file::BeadsFile;
use super::touch_noise::{noise_of, noise_text, pairing_text, stated};
use super::volume::{LoadVolume, ReadArgs};
use crate::commands::Outcome;
use crate::input_files::points_text;
use crate::input_files::source::Source;
use crate::live::touched_in;
use crate::register::input::{From, Input};
use crate::register::report;
use crate::register::row::Row;
use crate::register::solve::{Options, Told, solve};
use crate::register::{Request, describe, judge};
use crate::scene_context::{SceneArgs, SceneContext};
use crate::store;
use crate::values::{Name, Positive, Target};

pub(crate) const MATCH_HELP: &str = "\
BEADS.json is what calib beads wrote. TOUCHED holds the points touched with the pointer, three numbers a line with blanks \
or commas between them, mm, in the frame of the tracker (or of the patient's reference marker: --from reference). Their \
order does not matter; beads that nobody touched, false beads, and touched points on no bead are told of.

Two pairs agree where the distances between the points differ by less than 4.5 deviations of such a difference. The \
largest set of pairs that all agree, and whose residuals the errors explain, is registered. If another set fits as well \
and places the patient elsewhere, both are named and nothing is written.

Where the file of touches states their covariances, as that of calib touch does, each touch counts with its own, and \
--touch-mm is how far a hand is off the point besides. What all touches share, the error of the tip's calibration (u1x to \
u3z), stays in the result however many there are. Without covariances --touch-mm is the whole error of a touch. All pairs weigh the same.

--ct reads the CT again and refuses beads of another one; --ct-hash does so by the hash alone. The file carries the hash, \
and whoever uses it with another CT is refused. With --live or --scene the result must keep the scene's \
[tracker.registration.gates] too, and the beads must be of the run's CT.

Refused: fewer than 3 points, points on a line, two points nearer than they can be told, layouts that look alike from \
two sides; more than a quarter of the touched points on no bead, a point that lies near a bead and farther off than the \
errors told, and so few pairs that touches of somebody else would match as well (among ten beads three). Residuals that \
show more noise than told make the errors of the result larger, and say so.

Examples:
  calib match beads.json touched.txt --out registration.json
  calib match beads.json touched.txt --ct ct-folder --from reference --marker patient --target 10,-20,95.5 --out reg.json
  calib match beads.json touched.csv --live default --out registration.json
  calib match beads.json touched.txt --touch-mm 0.5 --bead-mm 0.2";

#[derive(Debug, Args)]
pub(crate) struct MatchArgs {
    /// The beads of the CT
    #[arg(value_name = "BEADS.json")]
    beads: PathBuf,
    /// The touched points
    #[arg(value_name = "TOUCHED")]
    touched: PathBuf,
    /// The CT that will be used, to be checked against the beads
    #[arg(long, value_name = "VOLUME", conflicts_with = "ct_hash")]
    ct: Option<PathBuf>,
    /// Its hash instead
    #[arg(long, value_name = "HASH")]
    ct_hash: Option<Name>,
    #[command(flatten)]
    read: ReadArgs,
    /// How far a hand is off the point, a standard deviation along each axis; without covariances in TOUCHED the whole error of a
    /// touch
    #[arg(long, value_name = "MM", default_value = "0.3", allow_hyphen_values = true)]
    touch_mm: Positive,
    /// Standard deviation of a bead's centre along each axis: the scanner's distortion, and what the skin moved since
    #[arg(long, value_name = "MM", default_value = "0.1", allow_hyphen_values = true)]
    bead_mm: Positive,
    #[command(flatten)]
    scene: SceneArgs,
    /// Name of the frame that the points were touched in [default: as the touches say, as the scene has it, tracker]
    #[arg(long, value_name = "NAME")]
    from: Option<Name>,
    /// Name of the marker that the points were seen by, to be checked when the file is used
    #[arg(long, value_name = "NAME")]
    marker: Option<Name>,
    /// Where to predict the error, in the CT, mm; may be given several times
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    target: Vec<Target>,
    /// Write the registration here, as JSON
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Replace that file if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Print the registration as JSON and nothing else
    #[arg(long)]
    json: bool,
}

/// What was read.
struct Read {
    beads: BeadsFile,
    sources: [Source; 2],
    centres: Vec<Point<Ct>>,
    touched: Vec<points_text::Point>,
}

impl MatchArgs {
    pub(crate) fn run(&self, load: LoadVolume) -> Result<Outcome, BeadsError> {
        if let Some(out) = &self.out {
            store::check(out, self.overwrite)?;
        }
        let read = self.read_files()?;
        let scened = SceneContext::open(&self.scene)?;
        self.check_ct(&read.beads, load, scened.as_ref())?;
        let from = self.from(scened.as_ref())?;
        let marker = match &scened {
            Some(scened) => scened.registered_marker(self.marker.as_ref())?,
            None => self.marker.clone(),
        };
        // The frame's name is known at run time only; the tracker stands for it here.
        let touched: Vec<Point<Tracker>> = read.touched.iter().map(|p| point(p.mm)).collect();
        let stated: Vec<Stated> = read.touched.iter().filter_map(stated).collect();
        let matched = match_stated(&read.centres, &touched, &stated, &self.errors());
        let matched = matched.map_err(|refused| BeadsError::Match {
            beads: self.beads.clone(),
            touched: self.touched.clone(),
            refused: Box::new(refused),
        })?;
        let noise = noise_of(&matched, &read.touched, &self.errors());
        let pairing = noise_text(noise, self.touch_mm.0) + &pairing_text(&matched, &read.touched);
        let ct_hash = read.beads.ct_hash.clone();
        let input = input(&matched, read);
        let request = self.request((ct_hash, matched.noise.sigma_mm), from, marker);
        let mut solution = solve(&input.rows, &request.options, &input.names())?;
        solution.by_pairs = matched.propagated;
        solution.noise = matched.noise;
        solution.told = Some(Told::times(matched.noise_factor.sqrt()));
        solution.touches = noise;
        let mut file = describe(&request, &input, &solution);
        let (judged, refused) = judge(&mut file, scened.as_ref())?;
        let encoded = file.to_json().map_err(serde_json::Error::io)?;
        let mut text = report::text(&file, true) + &pairing + &judged;
        if let (Some(out), Some(_)) = (&self.out, &refused) {
            text += &format!("\nnot written to {}\n", out.display());
        } else if let Some(out) = &self.out {
            let inputs = [self.beads.as_path(), self.touched.as_path()];
            store::write(out, Ok(encoded.clone()), inputs.into_iter())?;
            text += &format!("\nwritten to {}\n", out.display());
        }
        Ok(Outcome {
            text: if self.json { encoded } else { text },
            refused,
        })
    }

    /// The frame of the touches: as they say, as the command line says, as the scene has it.
    fn from(&self, scened: Option<&SceneContext>) -> Result<Name, BeadsError> {
        let own = || scened.map_or("tracker", SceneContext::registered_from);
        let told = touched_in(&self.touched, self.from.as_ref())?;
        Ok(told.unwrap_or_else(|| Name::told(own())))
    }

    fn errors(&self) -> Errors {
        Errors {
            bead_mm: self.bead_mm.0,
            touch_mm: self.touch_mm.0,
        }
    }

    fn read_files(&self) -> Result<Read, BeadsError> {
        let (beads, source) = BeadsFile::read(&self.beads)?;
        let touched = Source::read(&self.touched)?;
        Ok(Read {
            centres: beads.beads.iter().map(|bead| point(bead.centre_mm)).collect(),
            touched: points_text::read(&touched)?,
            beads,
            sources: [source, touched],
        })
    }

    /// Refuses beads of another CT.
    fn check_ct(&self, beads: &BeadsFile, load: LoadVolume, scened: Option<&SceneContext>) -> Result<(), BeadsError> {
        let own = scened.map(SceneContext::examined).transpose()?.flatten();
        if let Some(own) = own {
            self.same_ct(beads, own.hash.clone(), "the run".to_owned())?;
        }
        let (expected, by) = match (&self.ct, &self.ct_hash) {
            (Some(path), _) => (
                self.read.load(path, load)?.0.hash.to_string(),
                path.display().to_string(),
            ),
            (None, Some(hash)) => (hash.as_str().to_owned(), "--ct-hash".to_owned()),
            (None, None) => return Ok(()),
        };
        self.same_ct(beads, expected, by)
    }

    fn same_ct(&self, beads: &BeadsFile, expected: String, by: String) -> Result<(), BeadsError> {
        if beads.ct_hash == expected {
            return Ok(());
        }
        Err(BeadsError::OtherCt {
            path: self.beads.clone(),
            found: beads.ct_hash.clone(),
            expected,
            by,
        })
    }

    fn request(&self, (ct_hash, noise_mm): (String, f64), from: Name, marker: Option<Name>) -> Request {
        Request {
            input: From::Points {
                to: self.beads.clone(),
                from: self.touched.clone(),
            },
            allow_duplicates: false,
            options: Options {
                // What residuals show is in it already.
                noise_mm: Some(noise_mm),
                ..Options::default()
            },
            targets: self.target.iter().map(|target| target.0).collect(),
            to: "ct".to_owned(),
            from: from.0,
            out: self.out.clone(),
            overwrite: self.overwrite,
            grid: None,
            ct_hash: Some(ct_hash),
            marker: marker.map(|name| name.0),
            all: true,
            json: false,
        }
    }
}

fn point<F>([x, y, z]: [f64; 3]) -> Point<F> {
    Point::new(x, y, z)
}

/// The pairs that were found, as if they had been given.
fn input(matched: &Matched<Tracker>, read: Read) -> Input {
    let pairs = matched.bead_of.iter().zip(&read.touched);
    let row = |(bead, touched): (&Option<usize>, &points_text::Point)| {
        bead.map(|bead| Row {
            lines: [bead + 1, touched.line],
            to: read.centres[bead].mm(),
            from: touched.mm,
            weight: 1.0,
            label: format!("bead {}", bead + 1),
            // The matching has counted it.
            error: None,
        })
    };
    let [beads, touched] = read.sources;
    Input {
        rows: pairs.filter_map(row).collect(),
        sources: vec![("beads", beads), ("touched", touched)],
        has_weights: false,
    }
}
