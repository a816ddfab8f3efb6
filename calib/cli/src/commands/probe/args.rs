//! The words of the command, and what is done.

use std::path::{Path, PathBuf};

use calib::gate::{Gates, Reached, Verdict};
use clap::Args;
use geometry::Uncertain;
use probe::{
    CrossValidated, Options, PointNoise, PoseNoise, Priors, ProbeCalibration, Track, calibrate, calibrate_by_wall,
    check, cross_validate,
};

use super::array::ArrayRecord;
use super::beams::{self, ArrayArgs};
use super::error::ProbeCommandError;
use super::file::ProbeFile;
use super::input::{self, Read};
use super::phantom::{self, Told};
use super::report;
use super::seeing::SeeingArgs;
use super::water::{SCANNER_M_S, WaterRecord};
use crate::commands::Outcome;
use crate::poses::{Pixels, timed};
use crate::store;
use crate::values::{Name, Positive, Target};

pub(crate) const PROBE_HELP: &str = "\
Finds where the image of a tracked ultrasound probe lies in the marker on it, with the size of its pixels, from \
points of a phantom's wires \
(--config: a device set of PLUS with the wires' ends and the phantom's place) or of a flat wall that stands still \
(--wall). Any wires do \
that are not all parallel; none needs to belong to an N.

Without --points the dots of the wires, or the line of the wall, are read off the images of the sequence (8 bits a \
pixel, plain or deflated). A dot has a name where the drawing leaves no other; wires must be parallel for that, three \
or more, but for those that run across. A drawing that is the same from behind needs --right and --down. What is left \
out is told with its reason; --points-out keeps the points, --picture shows them: look at it.

Points are CSV with the columns frame, wire, u, v (pixels; whole numbers are centres of pixels, u to the right, v \
down; of a wall the wire is \
empty), or JSON as {\"frames\": {\"0\": [{\"wire\": \"7:G1_g1\", \"px\": [592.1, 195.8]}]}}. frame is the number \
in the sequence. Points of \
frames whose pose was lost are left out, and counted.

The phantom's place has an error, and it is one for all frames: more frames do not make it less. \
--phantom-error-mm and --phantom-error-deg say \
it; 0 and 0 say that it is exact. What else may be wrong is free where its deviation is given: --lag-ms, \
--tracker-percent, --play-mm. Each makes \
the residuals smaller whether it is true or not; the distances of frames that took no part, which are told at the \
end, say whether it is.

The file says which images it holds for: their size, how they are turned, array, depth (--array and --depth-mm, or the \
<ScanConversion> of a device set), and the name of the tool (--tool). A sweep compares each with the images that it gets and \
refuses others; what the file does not say it refuses too, but where it is told to take it unchecked.

In water sound is slower than a scanner believes (20 C: 1482 m/s, where scanners reckon with 1540), and depths are shown 3.8 % too \
long: --water-celsius takes that out (Marczak 1997), so that the image is that of tissue, and a sweep's speed of sound is within some per cent of \
1. Where water has salt or alcohol in it to have the speed of tissue, leave it out.

A lag is told as the time to add to an image's stamp to find the pose that goes with it.

What falls short of a bound is said, and the exit code is 1; nothing is written then.

--check judges a calibration by wires that it has not seen, best in another place than the phantom of the \
calibration: a phantom whose place is wrong is wrong for \
all of its own wires alike.

Examples:
  calib probe --sequence sweep.mha --config PlusDeviceSet.xml --phantom-error-mm 0.3 --phantom-error-deg 0.5 \
--points-out points.csv --picture dots.png --out probe.json
  calib probe --points points.json --sequence sweep.mha --config PlusDeviceSet.xml --phantom-error-mm 0.3 \
--phantom-error-deg 0.5 --out probe.json
  calib probe --points points.csv --sequence sweep.mha --config PlusDeviceSet.xml --phantom-error-mm 0 \
--phantom-error-deg 0 \
--window-ms 100 --lag-ms 100 --tracker-percent 3 --out probe.json
  calib probe --sequence sweep.mha --config PlusDeviceSet.xml --phantom-error-mm 0.3 --phantom-error-deg 0.5 \
--array curved:200,-280,300,56 --depth-mm 80 --tool probe --out probe.json
  calib probe --wall --sequence tank.mha --array linear:10,390,2 --depth-mm 40 --water-celsius 21.5 --out probe.json
  calib probe --check probe.json --points cross.csv --sequence cross.mha --config Cross.xml --phantom-error-mm 0.3 \
--phantom-error-deg 0.5
  calib probe --wall --points wall.csv --sequence wall.mha --pixel-mm 0.08,0.08 --pixel-percent 2 --max-error-mm 1 \
--out probe.json";

#[derive(Debug, Args)]
pub(crate) struct ProbeArgs {
    /// Points in the images; without it they are read off the images of the sequence
    #[arg(long, value_name = "FILE.json|csv")]
    points: Option<PathBuf>,
    #[command(flatten)]
    seeing: SeeingArgs,
    /// The poses, and the images where there are no --points: a sequence of PLUS
    #[arg(long, value_name = "FILE.mha")]
    sequence: PathBuf,
    /// The transform of the sequence from the probe's marker to what stands still with the phantom
    #[arg(long, value_name = "NAME", default_value = "ProbeToReference")]
    transform: String,
    #[command(flatten)]
    array: ArrayArgs,
    /// The name that a run's scene has for the tool that the marker is on [default: the marker's, of --transform]
    #[arg(long, value_name = "NAME")]
    tool: Option<Name>,
    /// The temperature of the water that the phantom or wall is in, 0 to 95: points are put where they would be shown in tissue, and the
    /// file says it. Needs --array, --scan or a device set with <ScanConversion>
    #[arg(long, value_name = "T", value_parser = up_to::<95>)]
    water_celsius: Option<f64>,
    /// The speed of sound that the scanner reckons with
    #[arg(long, value_name = "M/S", default_value_t = SCANNER_M_S, requires = "water_celsius", value_parser = scanner_speed)]
    scanner_speed_m_s: f64,
    /// A device set of PLUS with the phantom's wires and its place, and where it has <ScanConversion> with what --scan says
    #[arg(
        long,
        value_name = "FILE.xml",
        required_unless_present = "wall",
        conflicts_with = "wall"
    )]
    config: Option<PathBuf>,
    /// The phantom's frame in the device set
    #[arg(long, value_name = "FRAME", default_value = "Phantom")]
    phantom_frame: String,
    /// The frame in it in which the phantom stands still
    #[arg(long, value_name = "FRAME", default_value = "Reference")]
    reference_frame: String,
    /// Calibrate nothing: tell how far the points lie from their wires by this calibration. One wire is enough
    #[arg(long, value_name = "PROBE.json", conflicts_with_all = ["wall", "out", "lag_ms", "tracker_percent", "play_mm", "pixel_mm"])]
    check: Option<PathBuf>,
    /// The points lie on a flat wall that stands still
    #[arg(long)]
    wall: bool,
    /// Deviation of the phantom's place along each axis, 0 to 10: at the middle of its wires
    #[arg(long, value_name = "MM", required_unless_present = "wall", value_parser = up_to::<10>)]
    phantom_error_mm: Option<f64>,
    /// Deviation of its turn about each axis, 0 to 10
    #[arg(long, value_name = "DEG", required_unless_present = "wall", value_parser = up_to::<10>)]
    phantom_error_deg: Option<f64>,
    /// Deviations of a point along a row, along the beam and across the image
    #[arg(long, value_name = "MM,MM,MM", default_value = "0.2,0.15,0.4")]
    noise_mm: Target,
    /// Deviation of a pose's shift along each axis, 0 to 10: it is shared by the points of a frame
    #[arg(long, value_name = "MM", default_value = "0.1", value_parser = up_to::<10>)]
    pose_noise_mm: f64,
    /// Deviation of a pose's turn about each axis, 0 to 5
    #[arg(long, value_name = "DEG", default_value = "0.05", value_parser = up_to::<5>)]
    pose_noise_deg: f64,
    /// Sizes of a pixel along a row and along a column, where they are known
    #[arg(long, value_name = "MM,MM", requires = "pixel_percent", value_parser = pair)]
    pixel_mm: Option<Pair>,
    /// How well they are known, 0 to 100; 0 holds them
    #[arg(long, value_name = "PERCENT", requires = "pixel_mm", value_parser = up_to::<100>)]
    pixel_percent: Option<f64>,
    /// Take each pose as the mean of its neighbours in time, weighted by a normal curve of this deviation
    #[arg(long, value_name = "MS", default_value = "0", value_parser = up_to::<1000>)]
    window_ms: f64,
    /// Find the lag of the poses, 0 plus or minus this deviation; needs --window-ms
    #[arg(long, value_name = "MS", default_value = "0", value_parser = up_to::<1000>)]
    lag_ms: f64,
    /// Find a linear error of the tracker's shifts, nine numbers of this deviation: the distortion of a field tracker
    #[arg(long, value_name = "PERCENT", default_value = "0", value_parser = up_to::<20>)]
    tracker_percent: f64,
    /// Find the play of each wire's ends in their holes, of this deviation
    #[arg(long, value_name = "MM", default_value = "0", value_parser = up_to::<2>)]
    play_mm: f64,
    /// Refuse an image whose error by its covariance is above this at a corner of where points were seen, root mean
    /// square
    #[arg(long, value_name = "MM", default_value = "1")]
    max_error_mm: Positive,
    /// Refuse residuals above this many times the noise told
    #[arg(long, value_name = "RATIO", default_value = "1.5")]
    max_noise_ratio: Positive,
    /// Refuse where a larger share of the points is left out, 0 to 1
    #[arg(long, value_name = "SHARE", default_value = "0.3")]
    max_rejected: Positive,
    /// Write the calibration here
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Replace --out if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
}

/// Two numbers.
#[derive(Debug, Clone, Copy)]
struct Pair([f64; 2]);

fn pair(text: &str) -> Result<Pair, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    let numbers: Option<[f64; 2]> = numbers.and_then(|n| n.try_into().ok());
    numbers
        .map(Pair)
        .ok_or_else(|| "expected two numbers, for instance 0.08,0.075".to_owned())
}

fn scanner_speed(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|found| (1400.0..=1700.0).contains(found));
    found.ok_or_else(|| "expected a speed of 1400 to 1700 m/s".to_owned())
}

fn up_to<const MOST: u32>(text: &str) -> Result<f64, String> {
    let found = text
        .parse()
        .ok()
        .filter(|found| (0.0..=f64::from(MOST)).contains(found));
    found.ok_or_else(|| format!("expected a number from 0 to {MOST}"))
}

/// What was found, with what judges it.
struct Found {
    calibration: ProbeCalibration,
    crossed: Option<[CrossValidated; 2]>,
    phantom: Option<Told>,
}

impl ProbeArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, ProbeCommandError> {
        if let Some(out) = &self.out {
            store::check(out, self.overwrite)?;
        }
        self.seeing.check()?;
        let options = self.options();
        let phantom = self.config.as_deref().map(|path| {
            let frames = [self.phantom_frame.as_str(), self.reference_frame.as_str()];
            let errors = [
                self.phantom_error_mm.unwrap_or(0.0),
                self.phantom_error_deg.unwrap_or(0.0).to_radians(),
            ];
            phantom::read(path, frames, errors, self.check.is_some())
        });
        let phantom = phantom.transpose()?;
        let names: Vec<String> = match &phantom {
            Some(told) => told.wires.all().iter().map(|wire| wire.name.clone()).collect(),
            None => vec![String::new()],
        };
        let pictured = Pixels::pictured(&self.sequence)?;
        let (mut read, seen) = self.read(&names, phantom.as_ref())?;
        let beamed = self.array.read(self.config.as_deref(), pictured.size_px)?;
        let water = self.water(&mut read, beamed.array.as_ref())?;
        if let (Some(path), Some(told)) = (&self.check, &phantom) {
            let mut outcome = self.judge(path, &read, told, &options)?;
            outcome.text.insert_str(0, &seen);
            return Ok(outcome);
        }
        let images = beams::record(pictured, &beamed, &self.transform, self.tool.as_ref().map(Name::as_str));
        let found = self.solve(&read, phantom, &options)?;
        let gates = self.gates();
        let verdict = gates.judge(&reached(&found.calibration));
        let holds_for = images.words();
        let file = ProbeFile::new(
            &found.calibration,
            found.crossed.as_ref(),
            (read.lost, images, water),
            self.sources(),
            &verdict,
        );
        let mut text = seen;
        text += &report::text(
            &found.calibration,
            found.crossed.as_ref(),
            found.phantom.as_ref(),
            &read,
        );
        text += &holds_for;
        text.extend(water.map(|water| water.words()));
        text.extend(beamed.left.map(|why| format!("  {why}\n")));
        text.push_str(&format!("verdict          {verdict}\n"));
        if let Verdict::Refused(_) = verdict {
            let refused = Some(format!("the probe's image is not accepted: {verdict}"));
            return Ok(Outcome { text, refused });
        }
        if let Some(out) = &self.out {
            store::write(out, file.text(), self.sources().into_iter().map(PathBuf::as_path))?;
            text.push_str(&format!("written to {}, id {}\n", out.display(), file.id));
        }
        Ok(Outcome { text, refused: None })
    }

    /// Puts the points right for the water that they were seen in, where its temperature is told.
    fn water(&self, read: &mut Read, array: Option<&ArrayRecord>) -> Result<Option<WaterRecord>, ProbeCommandError> {
        let Some(celsius) = self.water_celsius else {
            return Ok(None);
        };
        let array = array.ok_or(ProbeCommandError::WaterArray)?;
        let water = WaterRecord::new(celsius, self.scanner_speed_m_s);
        let marks = read.frames.iter_mut().flat_map(|frame| &mut frame.marks);
        // Along their beams, to where a scanner that knew the water would show them.
        marks.for_each(|mark| mark.px = array.at_depth(mark.px, water.share()));
        Ok(Some(water))
    }

    /// Points and poses, and what was seen in the images where the points are theirs.
    fn read(&self, names: &[String], phantom: Option<&Told>) -> Result<(Read, String), ProbeCommandError> {
        let poses = timed(&self.sequence, &self.transform)?;
        if let Some(points) = &self.points {
            let marks = input::marks(points, names)?;
            return Ok((input::join(marks, points, &self.sequence, &poses)?, String::new()));
        }
        let inputs = self.sources();
        let by_number = input::poses_of(&poses);
        let (marks, text) = self.seeing.see(&self.sequence, phantom, names, &by_number, &inputs)?;
        Ok((input::join(marks, &self.sequence, &self.sequence, &poses)?, text))
    }

    fn solve(&self, read: &Read, phantom: Option<Told>, options: &Options) -> Result<Found, ProbeCommandError> {
        let track = match self.window_ms > 0.0 || self.lag_ms > 0.0 {
            true => Some(Track::new(&read.timed, self.window_ms / 1000.0)?),
            false => None,
        };
        let track = track.as_ref();
        let Some(told) = phantom else {
            return Ok(Found {
                calibration: calibrate_by_wall(&read.frames, track, options)?,
                crossed: None,
                phantom: None,
            });
        };
        let place: &Uncertain<_, _> = &told.reference_from_phantom;
        let calibration = calibrate(&read.frames, &told.wires, place, track, options)?;
        let half = read.frames.len() / 2;
        let crossed = |is_first: &dyn Fn(usize) -> bool| {
            cross_validate(&read.frames, &told.wires, place, track, options, is_first)
        };
        // Half of few frames may hold no image: that is no error of all of them.
        let crossed = crossed(&|i| i % 2 == 0).and_then(|every| Ok([every, crossed(&|i| i < half)?]));
        Ok(Found {
            calibration,
            crossed: crossed.ok(),
            phantom: Some(told),
        })
    }

    /// Holds a calibration against wires.
    fn judge(&self, path: &Path, read: &Read, told: &Told, options: &Options) -> Result<Outcome, ProbeCommandError> {
        let file = ProbeFile::read(path).map_err(Box::new)?;
        let known = file.known().ok_or(ProbeCommandError::NoImage)?;
        // A lag is along a track; without one each frame has its own pose.
        let track = match self.window_ms > 0.0 || known.lag_s != 0.0 {
            true => Some(Track::new(&read.timed, self.window_ms / 1000.0)?),
            false => None,
        };
        let place = &told.reference_from_phantom;
        let found = check(&known, &read.frames, &told.wires, place, track.as_ref(), options)?;
        let gates = Gates {
            max_noise_ratio: Some(self.max_noise_ratio.0),
            ..Gates::default()
        };
        let verdict = gates.judge(&Reached {
            noise_ratio: Some(found.ratio),
            ..Reached::default()
        });
        let text = report::checked(&found, &file) + &format!("verdict          {verdict}\n");
        let refused =
            (!verdict.is_accepted()).then(|| format!("the probe's image is not where these wires say: {verdict}"));
        Ok(Outcome { text, refused })
    }

    fn options(&self) -> Options {
        let [lateral_mm, axial_mm, elevation_mm] = self.noise_mm.0;
        let known = self.pixel_mm.zip(self.pixel_percent);
        Options {
            point: PointNoise {
                lateral_mm,
                axial_mm,
                elevation_mm,
            },
            pose: PoseNoise {
                turn_rad: self.pose_noise_deg.to_radians(),
                shift_mm: self.pose_noise_mm,
            },
            priors: Priors {
                pixel_mm: known.map(|(Pair(sizes), percent)| (sizes, percent / 100.0)),
                lag_s: self.lag_ms / 1000.0,
                tracker: self.tracker_percent / 100.0,
                play_mm: self.play_mm,
            },
            ..Options::default()
        }
    }

    fn gates(&self) -> Gates {
        Gates {
            max_tip_error_mm: None,
            max_target_mm: Some(self.max_error_mm.0),
            max_noise_ratio: Some(self.max_noise_ratio.0),
            max_rejected: Some(self.max_rejected.0),
            ..Gates::default()
        }
    }

    fn sources(&self) -> Vec<&PathBuf> {
        let all = [self.points.as_ref(), Some(&self.sequence), self.config.as_ref()];
        all.into_iter().flatten().collect()
    }
}

fn reached(found: &ProbeCalibration) -> Reached {
    Reached {
        rms_mm: Some(found.rms_mm),
        // A fit that did not settle has no error that could be promised.
        target_mm: found.is_settled.then(|| found.worst_mm()),
        noise_ratio: Some(found.noise_ratio),
        rejected: Some(1.0 - found.share_kept),
        count: Some(found.frames),
        ..Reached::default()
    }
}
