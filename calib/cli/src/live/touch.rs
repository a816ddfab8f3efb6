//! `calib touch`: a point touched with the pointer of a run that is going.

use std::path::{Path, PathBuf};

use clap::Args;
use geometry::{Marker, Point, Rigid, Tool, Uncertain, Vector};
use nalgebra::Matrix6;

use super::dwell::Still;
use super::{DwellError, FollowMarkers, LiveArgs, LiveError, MostMotion, Run, Touched, sequence, touched, touches};
use crate::bounds::Bounds;
use crate::calibration::{CalibrationFile, Gate, Kind};
use crate::commands::Outcome;
use crate::commands::common::{CommandError, broken, gates_text};
use crate::scene_context::SceneContext;
use crate::values::{Name, Positive};

pub(crate) const TOUCH_HELP: &str = "\
Hold the tip on the point and still. The mean place of the tip over --seconds is added to the file --to, with its name and \
its covariance (cxx to czz): that of the emitters' noise over all poses, and that of the tip's calibration. The second, which no \
number of touches makes less, is told apart (u1x to u3z: what three normal numbers of deviation 1, the same for all touches of the \
file, move the place by). How far the hand is off the point is in neither.

The tip is that of the run: of the file that the scene's [tracker.calibration] names, or of the scene itself. --tip names \
another pivot or tool calibration. Places are in the frame of the marker on the patient where the scene has one, else in \
the localizer's (--against).

calib base, calib match and calib register (--from-points) read the file: for the base, call the touches plane, groove_0, \
groove_1 and groove_2.

Refused: a tip that moves by more than --max-motion-mm (and the noise), a marker that more than half of the frames do not \
show, fewer than 9 poses, and what does not keep the scene's gates: max_tip_error_mm bounds the error of the place, max_rms_mm \
the scatter of the tip about it. Only what was captured after the command began counts, by the localizer's own stamps.

--from-sequence finds in a recording of the PLUS toolkit where the tip stands still for --dwell-s below --max-speed-mm-s, and adds each as \
a touch, in the order of time. Whether the tip was on a point then is not in the recording: look at the times. A drift is one stretch, refused where it goes \
further than --max-motion-mm; poses that repeat the one before are no measurement; what is not taken is told, and with --dwells \
another number of points is refused. The error is by the scatter and the drift of the poses, and that of --tip.

Examples:
  calib touch bead --from-sequence touches.igs.mha --transform StylusToReference --tip tip.json --dwells 6 --to touched.csv
  calib touch bead-1 --live default --to touched.csv
  calib touch groove_0 --live default --to touches.csv --seconds 0.5 --tip pointer-tip.json";

/// How long a touch takes, s.
pub(crate) const TOUCH_S: f64 = 1.0;

#[derive(Debug, Args)]
pub(crate) struct TouchArgs {
    /// Name of the point
    #[arg(value_name = "NAME")]
    name: Name,
    #[command(flatten)]
    pub(crate) live: LiveArgs,
    /// The file that the point is added to
    #[arg(long, value_name = "FILE.csv")]
    to: PathBuf,
    /// A pivot or tool calibration, instead of the run's own tip
    #[arg(long, value_name = "FILE.json")]
    tip: Option<PathBuf>,
    /// Accept at most so much motion of the tip
    #[arg(long, value_name = "MM", default_value = "0.5", allow_hyphen_values = true)]
    max_motion_mm: Positive,
    /// Take the points at which the tip stands still in this sequence of the PLUS toolkit, called NAME-1, NAME-2, ...
    #[arg(long, value_name = "FILE.mha", conflicts_with_all = ["live", "scene"])]
    from_sequence: Option<PathBuf>,
    /// From the marker on the pointer to what stands still, such as StylusToReference, which may be composed of the file's
    /// transforms; without --tip from the tip itself
    #[arg(long, value_name = "NAME", requires = "from_sequence")]
    transform: Option<String>,
    /// For at least so long, s
    #[arg(
        long,
        value_name = "S",
        default_value = "1",
        requires = "from_sequence",
        allow_hyphen_values = true
    )]
    dwell_s: Positive,
    /// The tip stands still below this speed
    #[arg(
        long,
        value_name = "MM/S",
        default_value = "2",
        requires = "from_sequence",
        allow_hyphen_values = true
    )]
    max_speed_mm_s: Positive,
    /// Refuse other than so many points
    #[arg(long, value_name = "COUNT", requires = "from_sequence")]
    dwells: Option<usize>,
}

impl TouchArgs {
    /// Does what is asked.
    pub(crate) fn run(&self, follow: FollowMarkers) -> Result<Outcome, CommandError> {
        if let Some(path) = &self.from_sequence {
            return self.dwelt(path);
        }
        let scened = SceneContext::open(&self.live.of)?;
        let mut run = Run::open(scened.as_ref(), &self.live, follow)?.ok_or(CommandError::NoRun)?;
        let tip = match &self.tip {
            Some(path) => tip_of(path, &run)?,
            None => run.follow.marker_from_tool().map_err(|why| LiveError::NoTip {
                name: self.name.as_str().to_owned(),
                why,
            })?,
        };
        let touch = self.touch(&mut run, &tip)?;
        let gates = gates(&touch, run.scened);
        if let Some(why) = broken(&gates) {
            let name = self.name.as_str().to_owned();
            return Err(LiveError::Gates { name, why }.into());
        }
        let of = touches::comment(&run.scened.scene.tool.name, run.against.name(), &tip);
        let count = touches::add(&self.to, self.name.as_str(), &of, (&touch.place, &touch.shared), &gates)?;
        let text = report(self.name.as_str(), &touch, run.against.name()) + &gates_text(&gates);
        Ok(Outcome {
            text: text + &format!("\nadded to {}, touch {count}\n", self.to.display()),
            refused: None,
        })
    }

    /// The points of a sequence.
    fn dwelt(&self, path: &Path) -> Result<Outcome, CommandError> {
        let transform = self.transform.as_deref().ok_or(DwellError::NoTransform)?;
        let transform = transform.strip_suffix("Transform").unwrap_or(transform);
        // What stands still, as touches are in the frame of a live run: reference, tracker.
        let (from, to) = transform.rsplit_once("To").ok_or(DwellError::NoTransform)?;
        let (tool, tip) = match &self.tip {
            Some(tip) => tip_in(tip).map(|(file, tip)| (file.tool, tip))?,
            None => (from.to_owned(), sequence::own_tip()?),
        };
        let asked = sequence::Asked {
            path,
            transform,
            name: self.name.as_str(),
            still: Still {
                most_mm_s: self.max_speed_mm_s.0,
                least_s: self.dwell_s.0,
            },
            most: MostMotion(self.max_motion_mm.0),
            dwells: self.dwells,
        };
        let (found, other) = sequence::dwelt(&asked, &tip)?;
        let frame = to.to_lowercase();
        let (mut text, mut count) = (String::new(), 0);
        for dwelt in &found {
            count = touches::add(
                &self.to,
                &dwelt.name,
                &touches::comment(&tool, &frame, &tip),
                (&dwelt.touch.place, &dwelt.touch.shared),
                &[],
            )?;
            text += &format!("{:.2} to {:.2} s\n", dwelt.from_s, dwelt.to_s);
            text += &report(&dwelt.name, &dwelt.touch, &frame);
        }
        if self.tip.is_none() {
            text += "the error is without that of the tip's calibration, which the sequence does not say\n";
        }
        for line in &other {
            text += &format!("not taken        {line}\n");
        }
        text += &format!(
            "\nadded to {}, {} touches, now {count}\n",
            self.to.display(),
            found.len()
        );
        Ok(Outcome { text, refused: None })
    }

    fn touch(&self, run: &mut Run<'_>, tip: &Uncertain<Marker, Tool>) -> Result<Touched, LiveError> {
        let seconds = self.live.seconds_or(TOUCH_S);
        let heard = run.listen(seconds, None)?;
        touched(
            self.name.as_str(),
            &heard,
            tip,
            MostMotion(self.max_motion_mm.0),
            seconds,
        )
    }
}

fn report(name: &str, touch: &Touched, frame: &str) -> String {
    let [x, y, z] = touch.place.point().mm();
    format!(
        "{name}  {x:.3}, {y:.3}, {z:.3} mm in the {frame}\n\
         error            {:.3} mm rms, of {} poses that scatter {:.2} times their covariances\n\
         moved            {:.3} mm\n",
        touch.place.rms_mm(),
        touch.poses,
        touch.noise_ratio,
        touch.moved_mm
    )
}

/// The scene's gates, of the touched place: what its poses scatter, and how well it is known.
fn gates(touch: &Touched, scened: &SceneContext) -> Vec<Gate> {
    let scene = scened.calibration_gates();
    let bounds = Bounds::calibration(Some(scened))
        .most("max-rms-mm", None, scene.max_rms_mm, touch.rms_mm)
        .most("max-tip-error-mm", None, scene.max_tip_error_mm, touch.place.rms_mm());
    bounds.done()
}

/// A tip from its file: of the whole tool, or of a pivot calibration, whose frame then has the marker's axes.
pub(crate) fn tip_of(path: &Path, run: &Run<'_>) -> Result<Uncertain<Marker, Tool>, CommandError> {
    let (file, tip) = tip_in(path)?;
    file.of_tool(path, "run", &run.scened.scene.tool.name)?;
    if let Some(link) = &run.scened.scene.tracker.links.calibration {
        let marker = link.file.marker.as_deref().unwrap_or(&file.marker);
        file.of_marker(path, "run", marker)?;
    }
    Ok(tip)
}

/// The file and its tip.
pub(crate) fn tip_in(path: &Path) -> Result<(CalibrationFile, Uncertain<Marker, Tool>), CommandError> {
    let unusable = |error: &dyn std::fmt::Display| LiveError::NoTip {
        name: path.display().to_string(),
        why: error.to_string(),
    };
    let (file, pivot) = match CalibrationFile::read(path, Kind::Tool) {
        Ok(file) => (file, false),
        Err(_) => (CalibrationFile::read(path, Kind::Pivot)?, true),
    };
    if pivot {
        let record = file.pivot.as_ref().ok_or_else(|| unusable(&"no tip in it"))?;
        let none = || unusable(&"the pivot calibration has no covariance; make it by errors-in-variables");
        let c = record.covariance_upper_mm2.ok_or_else(none)?;
        let [x, y, z] = record.tip_mm;
        let rotation = Rigid::<Marker, Tool>::identity().rotation();
        let mut covariance = Matrix6::zeros();
        // Rows of six, five and four numbers: the first three of each row are the tip's.
        for (i, j, k) in [(0, 0, 0), (0, 1, 1), (0, 2, 2), (1, 1, 6), (1, 2, 7), (2, 2, 11)] {
            covariance[(3 + i, 3 + j)] = c[k];
            covariance[(3 + j, 3 + i)] = c[k];
        }
        let at = Rigid::from_parts(rotation, Vector::new(x, y, z));
        let tip = Uncertain::from_covariance_about(Point::new(x, y, z), at, covariance);
        return Ok((file, tip.map_err(LiveError::from)?));
    }
    let frame = file.tool_frame.as_ref().ok_or_else(|| unusable(&"no tool in it"))?;
    let rigid = geometry::checked::rigid(frame.quaternion_wxyz, frame.translation_mm, 1e-9);
    let rigid = rigid.map_err(|error| unusable(&error))?;
    let tip = Uncertain::from_upper(rigid, frame.covariance_upper).map_err(LiveError::from)?;
    Ok((file, tip))
}
