//! `calib check`: a known point is touched, and the error is held against the prediction.

use std::path::{Path, PathBuf};

use bead::check::{Checked, FAIL_RATIO, Limits, Verdict, check};
use clap::Args;
use geometry::{Ct, Point, Tracker, Uncertain, UncertainPoint, checked};
use nalgebra::{Matrix3, Matrix6};
use serde::Serialize;

use super::check_tip::{self, Touch};
use super::error::{BeadsError, unusable};
use crate::bounds::on_registration;
use crate::calibration::Gate;
use crate::commands::Outcome;
use crate::commands::common::{broken, gates_text};
use crate::live::{Against, FollowMarkers, LiveArgs, LiveError, MostMotion, Run, TOUCH_S, calibration_id, touched};
use crate::register::file::RegistrationFile;
use crate::scene_context::SceneContext;
use crate::values::{Name, Positive, Target};

pub(crate) const CHECK_HELP: &str = "\
Touch a point whose place in the CT is known, best one near the target and not one that the registration was made of. \
The error is where the registration places the touched point, minus where it is, in the CT's axes.

The predicted radius holds 95 % of errors where nothing has moved, by the covariance of the registration and those of the \
touched and the known point. The tip's calibration is in registration and touch alike where both are with the same one, and \
cancels: what is left of it counts. Where that is not known, what is told of it counts for nothing: the check is then the stricter, and says so. \
--max-mm is vouched for by the larger radius, in which nothing cancels.

--touches takes a file of one touch by calib touch, with its covariance and its calibration; --touched is a place alone.

  pass   the error is within the predicted radius (and within --max-mm)
  warn   it is beyond, up to 1.5 times the radius, as one in twenty is; or the radius itself is beyond --max-mm; or the
         registration's points lie in a plane, and the known point is not further off it than the radius, so that a
         mirrored registration would pass too: touch another point
  fail   it is beyond 1.5 times the predicted radius, or beyond --max-mm: do not use the registration. Exit code 1

With --live or --scene the registration must keep the scene's [tracker.registration.gates] too, as a tracker asks of it.

Examples:
  calib check registration.json --known 10,-20,95.5 --touched 101.2,-33.0,1890.4
  calib check registration.json --known 10,-20,95.5 --touches known.csv
  calib check --live default --known 10,-20,95.5       hold the tip on the point; the registration is the run's
  calib check registration.json --known 10,-20,95.5 --touched 101.2,-33.0,1890.4 --max-mm 2 --ct-hash HASH --json";

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// The registration [default: that of the scene]
    #[arg(value_name = "REGISTRATION.json", required_unless_present_any = ["live", "scene"])]
    registration: Option<PathBuf>,
    /// Where the point is in the CT, mm
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    known: Target,
    /// Where it was touched, in the frame that the registration maps from, mm
    #[arg(
        long,
        value_name = "x,y,z",
        allow_hyphen_values = true,
        required_unless_present_any = ["live", "touches"],
        conflicts_with = "live"
    )]
    touched: Option<Target>,
    /// Or a file that calib touch made, of this one point
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["live", "touched"])]
    touches: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) live: LiveArgs,
    /// How far a hand is off the point, a standard deviation along each axis; with --touched the whole error of the touch
    #[arg(long, value_name = "MM", default_value = "0.3", allow_hyphen_values = true)]
    touch_mm: Positive,
    /// Standard deviation of the known point along each axis
    #[arg(long, value_name = "MM", default_value = "0.1", allow_hyphen_values = true)]
    known_mm: Positive,
    /// The greatest error that the operation allows [default: the scene's max_tre_mm]
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    max_mm: Option<Positive>,
    /// Hash of the CT in use, to be checked; the file must say its own
    #[arg(long, value_name = "HASH")]
    ct_hash: Option<Name>,
    /// Name of the marker in use, to be checked; the file must say its own [default: the scene's]
    #[arg(long, value_name = "NAME")]
    marker: Option<Name>,
    /// Print the result as JSON and nothing else
    #[arg(long)]
    json: bool,
}

/// How far the known point is off the plane of a registration's points.
#[derive(Debug, Clone, Copy)]
struct OffPlane {
    mm: f64,
    /// A mirrored registration would be off by twice that, and fail.
    is_enough: bool,
}

impl OffPlane {
    /// `None` where the registration's points lie in no plane.
    fn of(file: &RegistrationFile, known: [f64; 3], radius_mm: f64) -> Option<Self> {
        let mm = file.plane.as_ref()?.off_mm(known);
        // A NaN is beyond nothing.
        Some(Self {
            mm,
            is_enough: mm > radius_mm,
        })
    }
}

/// The result for programs.
#[derive(Debug, Serialize)]
struct CheckRecord {
    verdict: &'static str,
    error_mm: [f64; 3],
    distance_mm: f64,
    predicted_radius_95_mm: f64,
    /// What is known of the tip's error in both.
    tip: String,
    /// The radius with nothing cancelled.
    apart_radius_95_mm: f64,
    ratio: f64,
    max_mm: Option<f64>,
    gates: Vec<Gate>,
    place_mm: [f64; 3],
    /// Of the known point from the plane of a registration whose points lie in one.
    #[serde(skip_serializing_if = "Option::is_none")]
    off_plane_mm: Option<f64>,
    registration: String,
    ct_hash: Option<String>,
}

impl CheckArgs {
    pub(crate) fn run(&self, follow: FollowMarkers) -> Result<Outcome, BeadsError> {
        let scened = SceneContext::open(&self.live.of)?;
        let mut run = Run::open(scened.as_ref(), &self.live, follow)?;
        let path = self.path(scened.as_ref())?;
        let file = RegistrationFile::read(&path)?;
        self.paired(&path, &file, scened.as_ref())?;
        let gates = scened
            .as_ref()
            .map(|scened| on_registration(&file, scened))
            .transpose()?;
        let gates = gates.unwrap_or_default();
        let registration = uncertain(&path, &file)?;
        let touch = match (&mut run, &self.touches) {
            (Some(run), _) => self.touch(run, &path, &file.from)?,
            (None, Some(touches)) => Touch::read(touches, &file.from, self.touch_mm.0)?,
            // The command line asks for one or the other.
            (None, None) => Touch::plain(point(&path, self.touched.unwrap_or(self.known), self.touch_mm)?),
        };
        let tip = check_tip::parts(&path, &file, &touch)?;
        let known = point(&path, self.known, self.known_mm)?;
        let limits = Limits {
            most_mm: self.most_mm(scened.as_ref()),
        };
        let mut checked = check::<Tracker>(&registration, touch.place, known, &tip, limits);
        let off_plane = OffPlane::of(&file, self.known.0, checked.radius_95_mm);
        if off_plane.is_some_and(|off| !off.is_enough) && checked.verdict == Verdict::Pass {
            checked.verdict = Verdict::Warn;
        }
        let told = check_tip::words(&file, &touch, &tip);
        let text = match self.json {
            true => {
                serde_json::to_string_pretty(&record((&path, &file), &checked, (limits, off_plane), (&gates, told)))?
                    + "\n"
            }
            false => gates_text(&gates) + &report(&checked, (limits, off_plane), &told),
        };
        let failed = checked.verdict == Verdict::Fail;
        let refused = failed.then(|| refusal(&path, &checked, limits));
        Ok(Outcome {
            text,
            refused: refused.or_else(|| broken(&gates).map(|why| format!("checking {}: {why}", path.display()))),
        })
    }

    /// The greatest error allowed: as given, else the error at the target that the scene allows.
    fn most_mm(&self, scened: Option<&SceneContext>) -> Option<f64> {
        let link = scened.and_then(SceneContext::registration);
        let scene = link.and_then(|link| link.gates.max_tre_mm);
        self.max_mm.map(|limit| limit.0).or(scene)
    }

    /// The registration's file: the one given, or that of the run's scene.
    fn path(&self, scened: Option<&SceneContext>) -> Result<PathBuf, BeadsError> {
        if let Some(path) = &self.registration {
            return Ok(path.clone());
        }
        let link = scened.and_then(SceneContext::registration);
        let own = || {
            unusable(
                Path::new("(none)"),
                "the scene names no [tracker.registration]; give the file",
            )
        };
        link.map(|link| link.file.path.clone()).ok_or_else(own)
    }

    /// The tip of the run's pointer, in the frame that the registration maps from.
    fn touch(&self, run: &mut Run<'_>, path: &Path, from: &str) -> Result<Touch, BeadsError> {
        run.against = match (from, run.follow.has_reference()) {
            ("tracker", _) => Against::Tracker,
            ("reference", true) => Against::Reference,
            _ => {
                return Err(unusable(
                    path,
                    format!("it maps from {from:?}, which the run does not see"),
                ));
            }
        };
        let name = "the known point";
        let none = |why| LiveError::NoTip {
            name: name.to_owned(),
            why,
        };
        let tip = run.follow.marker_from_tool().map_err(none)?;
        let seconds = self.live.seconds_or(TOUCH_S);
        let heard = run.listen(seconds, None)?;
        let found = touched(name, &heard, &tip, MostMotion::USUAL, seconds)?;
        // What the poses say, and how far a hand is off the point.
        let hand = Matrix3::identity() * (self.touch_mm.0 * self.touch_mm.0);
        let place = UncertainPoint::new(found.place.point(), found.place.covariance() + hand);
        Ok(Touch {
            place: place.map_err(|error| unusable(path, error.to_string()))?,
            shared: Some(found.shared),
            calibration: Some(calibration_id(&tip)),
        })
    }

    /// Refuses a registration of another CT or marker, where the ones in use are told.
    fn paired(&self, path: &Path, file: &RegistrationFile, scened: Option<&SceneContext>) -> Result<(), BeadsError> {
        let text = |given: &Option<Name>| given.as_ref().map(|name| name.as_str().to_owned());
        let (hash, marker) = (text(&self.ct_hash), text(&self.marker));
        file.tells(path, hash.as_deref(), marker.as_deref())?;
        let (hash, marker) = match scened {
            Some(scened) => (
                text(&scened.ct_hash(self.ct_hash.as_ref())?),
                text(&scened.registered_marker(self.marker.as_ref())?),
            ),
            None => (hash, marker),
        };
        // A scene that names a marker asks for it, as the tracker does.
        file.tells(path, None, marker.as_deref())?;
        let own = |told: Option<String>, own: &Option<String>| told.or_else(|| own.clone()).unwrap_or_default();
        let (hash, marker) = (own(hash, &file.ct_hash), own(marker, &file.marker));
        Ok(file.paired(path, &hash, &marker)?)
    }
}

fn report(checked: &Checked, (limits, off_plane): (Limits, Option<OffPlane>), told: &str) -> String {
    let ([x, y, z], [a, b, c]) = (checked.error.mm(), checked.place.mm());
    let radius = checked.radius_95_mm;
    let limit = limits
        .most_mm
        .map_or(String::new(), |limit| format!(", {limit} mm allowed"));
    format!(
        "placed at        {a:.3}, {b:.3}, {c:.3} mm\nerror            {x:.3}, {y:.3}, {z:.3} mm (left, posterior, superior), \
         length {:.3} mm{limit}\npredicted        {radius:.3} mm holds 95 % of errors; beyond {:.3} mm is a failure\n\
         the tip          {told}\n{}verdict          {}: {}\n",
        checked.distance_mm,
        FAIL_RATIO * radius,
        off_plane.map_or(String::new(), |off| format!(
            "off the plane    {:.3} mm, of the registration's points: mirrored through it they would fit as well\n",
            off.mm
        )),
        name(checked.verdict),
        meaning(checked, (limits, off_plane))
    )
}

fn meaning(checked: &Checked, (limits, off_plane): (Limits, Option<OffPlane>)) -> &'static str {
    let vouched = limits.most_mm.is_none_or(|limit| checked.apart_radius_95_mm <= limit);
    match checked.verdict {
        Verdict::Pass => "the error is what was predicted",
        Verdict::Warn if !vouched => {
            "the predicted error is beyond --max-mm, or the scene's max_tre_mm: touch more beads, or nearer to the target"
        }
        Verdict::Warn if checked.distance_mm <= checked.radius_95_mm && off_plane.is_some_and(|off| !off.is_enough) => {
            "the registration's points lie in a plane, and the known point is nearer to it than the predicted error: that nothing is \
             mirrored was not checked; touch a known point off that plane"
        }
        Verdict::Warn => "larger than 95 % of errors would be: touch another point before you rely on it",
        Verdict::Fail => "do not use this registration: touch the beads again, and check the pointer",
    }
}

fn refusal(path: &Path, checked: &Checked, limits: Limits) -> String {
    let limit = limits
        .most_mm
        .map_or(String::new(), |limit| format!(" and {limit} mm are allowed"));
    format!(
        "checking {}: the error is {:.3} mm, and {:.3} mm hold 95 % of errors{limit}: do not use this registration",
        path.display(),
        checked.distance_mm,
        checked.radius_95_mm
    )
}

fn record(
    (path, file): (&Path, &RegistrationFile),
    checked: &Checked,
    (limits, off_plane): (Limits, Option<OffPlane>),
    (gates, tip): (&[Gate], String),
) -> CheckRecord {
    CheckRecord {
        verdict: name(checked.verdict),
        error_mm: checked.error.mm(),
        distance_mm: checked.distance_mm,
        predicted_radius_95_mm: checked.radius_95_mm,
        tip,
        apart_radius_95_mm: checked.apart_radius_95_mm,
        ratio: checked.distance_mm / checked.radius_95_mm,
        max_mm: limits.most_mm,
        gates: gates.to_vec(),
        place_mm: checked.place.mm(),
        off_plane_mm: off_plane.map(|off| off.mm),
        registration: path.to_string_lossy().into_owned(),
        ct_hash: file.ct_hash.clone(),
    }
}

fn point<F>(path: &Path, at: Target, sigma: Positive) -> Result<UncertainPoint<F>, BeadsError> {
    let [x, y, z] = at.0;
    UncertainPoint::new(Point::new(x, y, z), Matrix3::identity() * (sigma.0 * sigma.0))
        .map_err(|error| unusable(path, format!("the deviation {} mm: {error}", sigma.0)))
}

const fn name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::Warn => "warn",
        Verdict::Fail => "fail",
    }
}

/// The transform with its covariance; the frames' names are known at run time only, so that the tracker stands for `from`.
pub(crate) fn uncertain(path: &Path, file: &RegistrationFile) -> Result<Uncertain<Ct, Tracker>, BeadsError> {
    let transform = &file.transform;
    if transform.scale_fitted || transform.scale != 1.0 {
        let what = format!("it has the scale {}; a patient is registered without", transform.scale);
        return Err(unusable(path, what));
    }
    if file.to != "ct" {
        let what = format!("it maps to {:?}; expected \"ct\"", file.to);
        return Err(unusable(path, what));
    }
    let rows = file.covariance.ok_or_else(|| {
        unusable(
            path,
            "it has no covariance, as its points lie on a line; register points off the line",
        )
    })?;
    let covariance = Matrix6::from_fn(|i, j| rows[i][j]);
    let rigid = checked::rigid(transform.quaternion_wxyz, transform.translation_mm, 1e-9);
    let rigid = rigid.map_err(|error| unusable(path, format!("its transform is none: {error}")))?;
    Uncertain::new(rigid, covariance).map_err(|error| unusable(path, format!("its covariance is none: {error}")))
}
