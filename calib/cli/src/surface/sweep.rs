//! `calib sweep`: the tip of a run's pointer, or its ultrasound probe, goes over the bone; the registration is made meanwhile, and what it still lacks is told.

mod course;
mod sounded;
mod taken;

use std::path::PathBuf;

use clap::Args;
use geometry::{Marker, Tool, Uncertain};
use scene::localizer::LocalizerSpec;

use super::bone::Bone;
use super::bone_args::{BoneArgs, ct_of, from_zero};
use super::calibrated::Calibrated;
use super::error::SurfaceCommandError;
use super::points::Shared;
use super::{Asked, register};
use crate::commands::Outcome;
use crate::commands::common::CommandError;
use crate::live::{FollowMarkers, Listened, LiveArgs, LiveError, Run, tip_of};
use crate::scene_context::SceneContext;
use crate::store;
use crate::values::{Name, Positive};
use course::{Advice, Course, Way};
pub(super) use sounded::Sounding;
pub(super) use taken::Taken;

pub(crate) const SWEEP_HELP: &str = "\
Lets the tip of the run's pointer glide over the bone for --seconds, and takes a point each --step-mm of its way. Once a second or so the points \
so far are registered, and it is told on stderr how large the error at the targets is, what speaks against the result yet, and at which \
place of the bone more points would help most: whether the pointer reaches it is for you to see.

Lift the pointer quickly: what is faster than --max-speed-mm-s is no point. What was taken in the air all the same is left out by the fit, as \
long as it is less than half of all. A marker on the patient is needed where the patient may move.

With --probe the run's tool is a tracked ultrasound probe, and the bone is seen in its images (us-image) through the skin: --probe is its calibration, as \
calib probe writes it, with its lag where that was found. A point is taken each --step-mm of a bone's line; neighbours within --held-mm share the pose of \
their image and the look of their echo, and count as one. Depth is measured by the probe's nominal speed of sound, which is fitted within \
--speed-percent.

The calibration says which images it is of. Images of another size, depth, array or place of the beams, and a run whose tool has another name, \
are refused with what was found and expected; where one and the same tool has two names, say --probe-tool. A calibration that does not say one of \
these is refused as well, unless --unchecked-images takes it; what was not compared is then told on stderr and in the result. An image that was \
mirrored is refused where the run and the calibration both say how images are turned; else it is told that this was not compared.

An image that the calibration does not hold for is left out and named, and the points of the others are kept; where those are not half of all, nothing is \
registered.

The points are written to --to, with the covariance of each and the pose of the marker, so that calib surface can use them again; with \
--out the result is written too, as by calib surface, and under the same conditions.

Examples:
  calib sweep --live default --bone bone.ply --to swept.csv --out registration.json
  calib sweep --live or --bone bone.ply --to swept.csv --seconds 90 --guess before.json --target 10,-20,95.5 --picture p.png
  calib sweep --live or --bone bone.ply --probe probe.json --to seen.csv --target 10,-20,95.5 --out registration.json
  pilot calibrate sweep --bone bone.ply --to swept.csv --out registration.json";

/// Points of one image within this share the pose of the image and the look of their echo, mm: with less the error predicted is too
/// small (docs/ultrasound.md).
pub(super) const HELD_IN_IMAGES_MM: f64 = 8.0;
/// How far the top of an echo may lie from the surface that sends it back, everywhere alike, deviation, mm (docs/bone-line.md).
pub(super) const ECHO_MM: f64 = 0.5;
/// How long a sweep takes, s.
const SWEEP_S: f64 = 60.0;

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    of: BoneArgs,
    #[command(flatten)]
    pub(crate) live: LiveArgs,
    /// Write the points here
    #[arg(long, value_name = "FILE.csv")]
    to: PathBuf,
    /// A pivot or tool calibration, instead of the run's own tip
    #[arg(long, value_name = "FILE.json")]
    tip: Option<PathBuf>,
    /// The calibration of the ultrasound probe that is the run's tool: the bone is seen in its images
    #[arg(long, value_name = "FILE.json", conflicts_with = "tip")]
    probe: Option<PathBuf>,
    /// The name that the calibration has for the run's tool, where it is another than the run's
    #[arg(long, value_name = "NAME", requires = "probe")]
    probe_tool: Option<Name>,
    /// Take a calibration that does not say of which images or of which tool it is: what cannot be compared is told
    #[arg(long, requires = "probe")]
    unchecked_images: bool,
    /// How late poses are behind images, and its deviation, instead of what the calibration says: the time to add to an image's stamp to
    /// find its pose, as calib lag tells it
    #[arg(long, value_name = "MS,MS", requires = "probe", allow_hyphen_values = true)]
    lag_ms: Option<LagMs>,
    /// Deviation across its image of what the probe sees: the beam's height
    #[arg(long, value_name = "MM", default_value = "0.7", allow_hyphen_values = true)]
    elevation_mm: Positive,
    /// Points nearer to one another than this count as one [default: 0.5, with --probe 8]
    #[arg(long, value_name = "MM", value_parser = from_zero, allow_hyphen_values = true)]
    held_mm: Option<f64>,
    /// Deviation of the speed of sound, which is fitted with --probe; 0 holds it
    #[arg(long, value_name = "PERCENT", default_value = "3", value_parser = from_zero, allow_hyphen_values = true)]
    speed_percent: f64,
    /// How far the tip may be off the bone where it touches it, along each axis
    #[arg(long, value_name = "MM", default_value = "0.3", allow_hyphen_values = true)]
    contact_mm: Positive,
    /// A point each so far of the tip's way, or along a line of bone in an image
    #[arg(long, value_name = "MM", default_value = "2", allow_hyphen_values = true)]
    step_mm: Positive,
    /// A tip that is faster is lifted
    #[arg(long, value_name = "MM/S", default_value = "100", allow_hyphen_values = true)]
    max_speed_mm_s: Positive,
}

/// A lag and its deviation, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct LagMs(pub(super) [f64; 2]);

impl std::str::FromStr for LagMs {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([lag, sigma]) if lag.abs() <= 1000.0 && (0.0..=100.0).contains(sigma) => {
                Ok(Self([lag / 1e3, sigma / 1e3]))
            }
            _ => Err(
                "expected a lag of -1000 to 1000 ms and its deviation of 0 to 100 ms, for instance -42.5,3".to_owned(),
            ),
        }
    }
}

impl SweepArgs {
    /// Does what is asked.
    pub(crate) fn run(self, follow: FollowMarkers) -> Result<Outcome, CommandError> {
        self.of.check()?;
        store::check(&self.to, self.of.overwrite)?;
        let probe = self
            .probe
            .as_deref()
            .map(|path| Calibrated::read(path, self.lag_ms.map(|lag| lag.0)))
            .transpose()?;
        let mut warnings = Vec::new();
        if let Some(probe) = &probe {
            let unchecked = probe.unchecked(self.unchecked_images)?;
            warnings.extend(unchecked.map(|what| format!("the probe's calibration does not say {what}: not compared")));
        }
        let scened = SceneContext::open(&self.live.of)?;
        let bone = self.of.bone()?;
        let mut run = Run::open(scened.as_ref(), &self.live, follow)?.ok_or(SurfaceCommandError::NoRun)?;
        let tip = match &probe {
            Some(probe) => {
                let alias = self.probe_tool.as_ref().map(Name::as_str);
                probe.of_tool(&run.scened.scene.tool.name, alias)?;
                None
            }
            None => Some(self.tip(&run)?),
        };
        let (way, shared) = match (&probe, &tip) {
            (Some(probe), _) => (self.sounding(&run, probe), probe.shared()),
            (None, Some((of, tip))) => self.course(&run, of, tip),
            (None, None) => return Err(SurfaceCommandError::NoRun.into()),
        };
        let mut asked = self.asked(run.scened, &bone, run.against.name(), shared)?;
        asked.warnings = warnings;
        // Also read here, so that a guess that is none is told before the sweep and not after it.
        asked.begin.read(&asked.of())?;
        let frame = run.against.name();
        let advice = Advice {
            bone: &bone,
            asked: &asked,
            way: &way,
            frame,
        };
        if probe.is_some() {
            let localizer = run.scened.scene.localizer.as_ref();
            // Told before the sweep and not after it.
            if let Some(why) = localizer.and_then(LocalizerSpec::why_no_sweep) {
                return Err(SurfaceCommandError::NoSweep(why).into());
            }
            run.hear_images()?;
        }
        let seconds = self.live.seconds_or(SWEEP_S);
        let told = |heard: &Listened| advice.lacks(heard);
        let heard = run.listen(seconds, Some(&told))?;
        if probe.is_some() && heard.images.is_empty() {
            return Err(SurfaceCommandError::NoImages { seconds }.into());
        }
        if let Some(probe) = &probe {
            let is_told = heard.images.iter().all(|image| image.orientation.is_some());
            asked.warnings.extend(probe.not_compared(is_told));
        }
        let taken = way.taken(&heard, frame);
        asked.warnings.extend(self.keep(&asked, &bone, taken)?);
        // From the file: what is registered is what can be registered again.
        register(&bone, &asked, scened.as_ref())
    }

    /// Writes the points, whatever else is the matter; what is to be told of images that were left out.
    fn keep(&self, asked: &Asked, bone: &Bone, taken: Taken) -> Result<Option<String>, CommandError> {
        let Taken { text, count, refused } = taken;
        match refused {
            // There is nothing to keep, and what --to holds of before stays.
            Some(refused) if refused.count == refused.of => {
                Err(SurfaceCommandError::AllRefused(refused.to_string()).into())
            }
            refused => {
                store::write(&self.to, Ok(text), asked.inputs(bone))?;
                match refused {
                    Some(refused) if refused.is_most() => Err(SurfaceCommandError::MostRefused {
                        to: self.to.clone(),
                        points: count,
                        why: refused.to_string(),
                    }
                    .into()),
                    refused => Ok(refused.map(|refused| refused.to_string())),
                }
            }
        }
    }

    fn sounding<'a>(&self, run: &Run<'a>, probe: &'a Calibrated) -> Way<'a> {
        let sounding = Sounding {
            probe,
            step_mm: self.step_mm.0,
            elevation_mm: self.elevation_mm.0,
        };
        Way::Probe(sounding, run.scened.scene.tool.name.as_str())
    }

    fn course<'a>(&self, run: &Run<'a>, of: &str, tip: &'a Uncertain<Marker, Tool>) -> (Way<'a>, Shared) {
        let course = Course {
            tip,
            step_mm: self.step_mm.0,
            most_mm_s: self.max_speed_mm_s.0,
            contact_mm: self.contact_mm.0,
        };
        // A scene's drawing has no covariance: nothing is known of its error, and that is said.
        let shared = match tip.upper().iter().any(|entry| *entry != 0.0) {
            true => Shared::Tip(of.to_owned(), Box::new(*tip)),
            false => Shared::Unknown,
        };
        (Way::Tip(course, run.scened.scene.tool.name.as_str()), shared)
    }

    /// The calibration of the tip, with the words for it.
    fn tip(&self, run: &Run<'_>) -> Result<(String, Uncertain<Marker, Tool>), CommandError> {
        let Some(path) = &self.tip else {
            let own = run.follow.marker_from_tool().map_err(|why| LiveError::NoTip {
                name: "sweep".to_owned(),
                why,
            })?;
            return Ok((format!("the tip's calibration of run {}", run.name()), own));
        };
        let tip = tip_of(path, run)?;
        Ok((format!("the calibration {}", path.display()), tip))
    }

    fn asked(&self, scened: &SceneContext, bone: &Bone, from: &str, shared: Shared) -> Result<Asked, CommandError> {
        let ct_hash = ct_of(bone, scened.ct_hash(None)?)?;
        let (speed, held_mm, alike_mm) = match &self.probe {
            Some(_) => (self.speed_percent / 100.0, HELD_IN_IMAGES_MM, ECHO_MM),
            // A tip has no depth.
            None => (0.0, course::HELD_MM, self.contact_mm.0),
        };
        Ok(Asked {
            options: self.of.options(bone, speed, alike_mm),
            limits: self.of.limits(self.probe.is_some()),
            begin: self.of.begin(),
            noise_mm: None,
            held_mm: self.held_mm.unwrap_or(held_mm),
            shared,
            tip: self.probe.clone().or_else(|| self.tip.clone()),
            targets: self.of.targets(Some(scened))?,
            from: from.to_owned(),
            ct_hash: ct_hash.map(|name| name.0),
            marker: scened.registered_marker(None)?.map(|name| name.0),
            points: self.to.clone(),
            out: self.of.out.clone(),
            keep_refused: self.of.keep_refused.clone(),
            picture: self.of.picture.clone(),
            json: false,
            warnings: Vec::new(),
        })
    }
}
