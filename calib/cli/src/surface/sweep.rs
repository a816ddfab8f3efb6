//! `calib sweep`: the tip of a run's pointer goes over the bone; the registration is made meanwhile, and what it still lacks is told.

mod course;

use std::path::PathBuf;

use clap::Args;
use geometry::{Marker, Tool, Uncertain};

use super::bone::Bone;
use super::bone_args::{BoneArgs, ct_of};
use super::error::SurfaceCommandError;
use super::points::Shared;
use super::{Asked, register};
use crate::commands::Outcome;
use crate::commands::common::CommandError;
use crate::live::{FollowMarkers, Listened, LiveArgs, LiveError, Run, tip_of};
use crate::scene_context::SceneContext;
use crate::store;
use crate::values::Positive;
use course::{Advice, Course};

pub(crate) const SWEEP_HELP: &str = "\
Lets the tip of the run's pointer glide over the bone for --seconds, and takes a point each --step-mm of its way. Once a second or so the points \
so far are registered, and it is told on stderr how large the error at the targets is, what speaks against the result yet, and at which \
place of the bone more points would help most: whether the pointer reaches it is for you to see.

Lift the pointer quickly: what is faster than --max-speed-mm-s is no point. What was taken in the air all the same is left out by the fit, as \
long as it is less than half of all. A marker on the patient is needed where the patient may move.

The points are written to --to, with the covariance of each and the pose of the marker, so that calib surface can use them again; with \
--out the result is written too, as by calib surface, and under the same conditions.

Examples:
  calib sweep --live default --bone bone.ply --to swept.csv --out registration.json
  calib sweep --live or --bone bone.ply --to swept.csv --seconds 90 --guess before.json --target 10,-20,95.5 --picture p.png
  pilot calibrate sweep --bone bone.ply --to swept.csv --out registration.json";

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
    /// How far the tip may be off the bone where it touches it, along each axis
    #[arg(long, value_name = "MM", default_value = "0.3", allow_hyphen_values = true)]
    contact_mm: Positive,
    /// A point each so far of the tip's way
    #[arg(long, value_name = "MM", default_value = "2", allow_hyphen_values = true)]
    step_mm: Positive,
    /// A tip that is faster is lifted
    #[arg(long, value_name = "MM/S", default_value = "100", allow_hyphen_values = true)]
    max_speed_mm_s: Positive,
}

impl SweepArgs {
    /// Does what is asked.
    pub(crate) fn run(self, follow: FollowMarkers) -> Result<Outcome, CommandError> {
        self.of.check()?;
        store::check(&self.to, self.of.overwrite)?;
        let scened = SceneContext::open(&self.live.of)?;
        let bone = self.of.bone()?;
        let mut run = Run::open(scened.as_ref(), &self.live, follow)?.ok_or(SurfaceCommandError::NoRun)?;
        let (of, tip) = self.tip(&run)?;
        let asked = self.asked(run.scened, &bone, run.against.name(), (of, &tip))?;
        let course = Course {
            tip: &tip,
            step_mm: self.step_mm.0,
            most_mm_s: self.max_speed_mm_s.0,
            contact_mm: self.contact_mm.0,
        };
        // Also read here, so that a guess that is none is told before the sweep and not after it.
        asked.begin.read(&asked.of())?;
        let (tool, frame) = (run.scened.scene.tool.name.as_str(), run.against.name());
        let advice = Advice {
            bone: &bone,
            asked: &asked,
            course: &course,
            tool,
            frame,
        };
        let seconds = self.live.seconds_or(SWEEP_S);
        let told = |heard: &Listened| advice.lacks(heard);
        let heard = run.listen(seconds, Some(&told))?;
        let text = course.csv(&heard, tool, frame);
        let inputs = asked.inputs(&bone);
        store::write(&self.to, Ok(text), inputs)?;
        // From the file: what is registered is what can be registered again.
        register(&bone, &asked, scened.as_ref())
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

    fn asked(
        &self,
        scened: &SceneContext,
        bone: &Bone,
        from: &str,
        (of, tip): (String, &Uncertain<Marker, Tool>),
    ) -> Result<Asked, CommandError> {
        let ct_hash = ct_of(bone, scened.ct_hash(None)?)?;
        // A scene's drawing has no covariance: nothing is known of its error, and that is said.
        let shared = match tip.upper().iter().any(|entry| *entry != 0.0) {
            true => Shared::Tip(of, Box::new(*tip)),
            false => Shared::Unknown,
        };
        Ok(Asked {
            options: self.of.options(bone, 0.0),
            limits: self.of.limits(),
            begin: self.of.begin(),
            noise_mm: None,
            held_mm: course::HELD_MM,
            shared,
            tip: self.tip.clone(),
            targets: self.of.targets(Some(scened))?,
            from: from.to_owned(),
            ct_hash: ct_hash.map(|name| name.0),
            marker: scened.registered_marker(None)?.map(|name| name.0),
            points: self.to.clone(),
            out: self.of.out.clone(),
            picture: self.of.picture.clone(),
            json: false,
        })
    }
}
