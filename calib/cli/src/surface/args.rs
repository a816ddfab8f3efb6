//! `calib surface`: its options.

use std::path::PathBuf;

use clap::Args;

use super::bone::Bone;
use super::bone_args::{BoneArgs, ct_of, from_zero};
use super::calibrated::{Calibrated, without_probe};
use super::error::SurfaceCommandError;
use super::points::Shared;
use super::sweep::{ECHO_MM, HELD_IN_IMAGES_MM};
use super::{Asked, register};
use crate::beads::{LoadVolume, ReadArgs};
use crate::commands::Outcome;
use crate::commands::common::CommandError;
use crate::input_files::columns::TableError;
use crate::input_files::source::Source;
use crate::live::{tip_in, touched_in};
use crate::scene_context::{SceneArgs, SceneContext};
use crate::values::{Name, Positive};

/// Points nearer to one another are of a pointer held still, mm.
const HELD_MM: f64 = 0.5;

pub(crate) const SURFACE_HELP: &str = "\
Finds the pose in which points of the bone's surface, touched with a pointer or seen by a tracked ultrasound probe, lie on it, without knowing \
which point of the bone each is. The thesis' way of registering a patient (part I, 2.2.1 and 2.3.3).

--points has a line a point, in the order in which they were taken, in mm, in the frame of the marker on the patient or of the localizer. \
The first line names the columns, in any \
order:

  x,y,z                                    the place; a file of calib touch is read as it is
  sigma                                    deviation along each axis, or
  cxx,cxy,cxz,cyy,cyz,czz                  its covariance, mm^2, or
  axial,lateral,elevation                  of ultrasound: along the beam, across it in the image, across the image
  beam_x,beam_y,beam_z                     the way that the sound went, into the body, of length 1
  across_x,across_y,across_z               across the beam, in the image
  depth                                    along the beam, by the probe's nominal speed of sound
  marker_qw,...,marker_qz,marker_x,...     pose of the marker on the tool as the point was taken, for --tip
  on                                       a name

Points that a probe saw say in their second line with which calibration they were made, and --probe takes no other; points without that line \
only with --unchecked-images.

Where the search begins: within --guess-deg and --guess-mm of the registration --guess, at --landmarks (pairs as calib register takes \
them), or, without either, everywhere. One kind of ill luck has no number: a bone that is not the patient's own. Touch a point that \
you know and hold calib check against it.

The result is written only where nothing speaks against it: residuals as the noise says, no other pose that fits nearly as well, enough \
points, a predicted error at each target of at most --max-tre-mm, no motion left free. What falls short is said with its number, and \
the exit code is 1. With --scene or --live it must also keep that scene's [tracker.registration.gates].

Examples:
  calib bone ct-folder --labels labels.nii.gz --label hip_left --out bone.ply
  calib surface --bone bone.ply --points touched.csv --target 10,-20,95.5 --out registration.json --picture residuals.png
  calib surface --bone bone.ply --points swept.csv --guess before.json --guess-deg 20 --guess-mm 20 --target 10,-20,95.5
  calib surface --bone bone.stl --bone-frame lps --points p.csv --noise-mm 0.5 --landmarks three.csv --target 0,0,0
  calib surface --bone bone.ply --points touched.csv --live default --tip tip.json --out registration.json
  calib surface --bone bone.ply --points seen.csv --probe probe.json --target 10,-20,95.5 --out registration.json";

#[derive(Debug, Args)]
pub(crate) struct SurfaceArgs {
    #[command(flatten)]
    of: BoneArgs,
    /// The points, as comma-separated values
    #[arg(long, value_name = "FILE.csv")]
    points: PathBuf,
    /// Deviation along each axis of points whose file has none
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    noise_mm: Option<Positive>,
    /// Points nearer to one another than this were taken by a tool held still, and count as one [default: 0.5, with --probe 8]
    #[arg(long, value_name = "MM", value_parser = from_zero, allow_hyphen_values = true)]
    held_mm: Option<f64>,
    /// Deviation of the speed of sound, which is fitted where points have a depth; 0 holds it
    #[arg(long, value_name = "PERCENT", default_value = "3", value_parser = from_zero, allow_hyphen_values = true)]
    speed_percent: f64,
    /// The pointer's tip or tool calibration: its error is that of all points
    #[arg(long, value_name = "FILE.json", conflicts_with = "shared_mm")]
    tip: Option<PathBuf>,
    /// The calibration of the ultrasound probe that saw the points: its error is that of all points, and an echo's top may lie off the bone
    #[arg(long, value_name = "FILE.json", conflicts_with_all = ["tip", "shared_mm"])]
    probe: Option<PathBuf>,
    /// Take points that do not say with which calibration of the probe they were made
    #[arg(long, requires = "probe")]
    unchecked_images: bool,
    /// Deviation along each axis of a shift that all points share, where no calibration tells it; 0 where there is none
    #[arg(long, value_name = "MM", value_parser = from_zero, allow_hyphen_values = true)]
    shared_mm: Option<f64>,
    #[command(flatten)]
    scene: SceneArgs,
    /// Name of the frame of the points [default: that of the touches, else the scene's, else tracker]
    #[arg(long)]
    from: Option<Name>,
    /// The CT volume that the bone is of, to be checked when the file is used
    #[arg(long, value_name = "VOLUME", conflicts_with = "ct_hash")]
    ct: Option<PathBuf>,
    #[command(flatten)]
    read: ReadArgs,
    /// Its hash instead
    #[arg(long, value_name = "HASH")]
    ct_hash: Option<Name>,
    /// Name of the marker that the points are seen by, to be checked when the file is used
    #[arg(long, value_name = "NAME")]
    marker: Option<Name>,
    /// Print the registration as JSON and nothing else
    #[arg(long)]
    json: bool,
}

impl SurfaceArgs {
    /// Does what is asked.
    pub(crate) fn run(self, load: LoadVolume) -> Result<Outcome, CommandError> {
        self.of.check()?;
        let scened = SceneContext::open(&self.scene)?;
        let bone = self.of.bone()?;
        let asked = self.asked(scened.as_ref(), &bone, load)?;
        register(&bone, &asked, scened.as_ref())
    }

    fn asked(self, scened: Option<&SceneContext>, bone: &Bone, load: LoadVolume) -> Result<Asked, CommandError> {
        let ct_hash = ct_of(bone, self.expected_ct(scened, load)?)?;
        let touched = touched_in(&self.points, self.from.as_ref())?;
        let from = touched.unwrap_or_else(|| Name::told(scened.map_or("tracker", SceneContext::registered_from)));
        let marker = match scened {
            Some(scened) => scened.registered_marker(self.marker.as_ref())?,
            None => self.marker.clone(),
        };
        let mut warnings = Vec::new();
        if self.probe.is_none() {
            let source = Source::read(&self.points).map_err(TableError::from)?;
            without_probe(&self.points, &source.text)?;
        }
        let shared = match (&self.tip, &self.probe, self.shared_mm) {
            (None, Some(path), _) => {
                // Its lag went into the points when they were seen, and its images were compared then.
                let probe = Calibrated::read(path, Some([0.0; 2]))?;
                let source = Source::read(&self.points).map_err(TableError::from)?;
                warnings.extend(probe.made(&self.points, &source.text, self.unchecked_images)?);
                probe.shared()
            }
            (Some(path), ..) => {
                let of = format!("the calibration {}", path.display());
                Shared::Tip(of, Box::new(tip_in(path)?.1))
            }
            (None, None, Some(sigma_mm)) => Shared::Shift(sigma_mm),
            (None, None, None) => Shared::Unknown,
        };
        let (held_mm, alike_mm) = match &self.probe {
            Some(_) => (HELD_IN_IMAGES_MM, ECHO_MM),
            None => (HELD_MM, 0.0),
        };
        Ok(Asked {
            options: self.of.options(bone, self.speed_percent / 100.0, alike_mm),
            limits: self.of.limits(self.probe.is_some()),
            begin: self.of.begin(),
            noise_mm: self.noise_mm.map(|mm| mm.0),
            held_mm: self.held_mm.unwrap_or(held_mm),
            shared,
            tip: self.tip.or(self.probe),
            targets: self.of.targets(scened)?,
            from: from.0,
            ct_hash: ct_hash.map(|name| name.0),
            marker: marker.map(|name| name.0),
            points: self.points,
            out: self.of.out,
            keep_refused: self.of.keep_refused,
            picture: self.of.picture,
            json: self.json,
            warnings,
        })
    }

    /// The CT in use, by what is given and by the run, which must be one.
    fn expected_ct(&self, scened: Option<&SceneContext>, load: LoadVolume) -> Result<Option<Name>, CommandError> {
        let given = match &self.ct {
            Some(path) => {
                let hash = self.read.hash(path, load);
                let hash = hash.map_err(|error| SurfaceCommandError::Volume(Box::new(error)))?;
                Some(Name::told(&hash))
            }
            None => self.ct_hash.clone(),
        };
        Ok(match scened {
            Some(scened) => scened.ct_hash(given.as_ref())?,
            None => given,
        })
    }
}
