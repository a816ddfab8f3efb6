//! `calib bone-line`: its options.

use std::path::PathBuf;

use clap::Args;

use super::super::bone_args::from_zero;
use super::super::sweep::LagMs;
use crate::commands::probe::ArrayArgs;
use crate::values::Positive;

pub(crate) const BONE_LINE_HELP: &str = "\
Finds bone in the images of a recorded sequence of PLUS (.mha, 8 bits a pixel, plain or deflated, orientation MF) in which a tracked \
ultrasound probe was swept over the skin, and writes its points, in mm, in the frame that --transform leads to, as calib surface --points \
takes them.

Bone is a bright line below which it is dark and silent; a fascia is as bright, with tissue below. What fluid or gas lies below is taken for \
bone, too. Look at --picture, which shows the line in up to 24 of the images, before the points are used.

Where the image lies in the probe's marker says --probe, a file of calib probe, or --image-to-probe, PLUS's matrix: 16 numbers by rows, a file of \
them, or a device set with the transform from Image to the marker. A matrix has no error: tell calib surface --shared-mm then. A file of calib \
probe says of which images it is, and others are refused.

Where beams run must be known: --array and --depth-mm, --scan, or what the calibration says.

Each image has the pose of its own frame, unless the calibration or --lag-ms says how late poses are.

Examples:
  calib bone-line --sequence sweep.mha --probe probe.json --to seen.csv --picture lines.png
  calib bone-line --sequence BoneUltrasound_L14.igs.mha --image-to-probe BoneUltrasound_L14_config.xml --to seen.csv --picture lines.png
  calib bone-line --sequence sweep.mha --probe probe.json --array linear:175.5,642.5,3 --depth-mm 52 --lag-ms -42.5,3 --to seen.csv
  calib surface --bone bone.ply --points seen.csv --probe probe.json --target 10,-20,95.5 --out registration.json";

#[derive(Debug, Args)]
pub(crate) struct BoneLineArgs {
    /// Images and poses: a sequence of PLUS
    #[arg(long, value_name = "FILE.mha")]
    pub(super) sequence: PathBuf,
    /// The transform of the sequence from the probe's marker to the frame of the points, or which to compose
    #[arg(long, value_name = "NAME", default_value = "ProbeToReference")]
    pub(super) transform: String,
    /// The calibration of the probe, as calib probe writes it
    #[arg(
        long,
        value_name = "FILE.json",
        required_unless_present = "image_to_probe",
        conflicts_with = "image_to_probe"
    )]
    pub(super) probe: Option<PathBuf>,
    /// PLUS's matrix from pixels to mm in the marker: 16 numbers, a file of them, or a device set
    #[arg(long, value_name = "FILE|NUMBERS", allow_hyphen_values = true)]
    pub(super) image_to_probe: Option<String>,
    /// Take a calibration that does not say of which images it is: what cannot be compared is told
    #[arg(long, requires = "probe")]
    pub(super) unchecked_images: bool,
    #[command(flatten)]
    pub(super) array: ArrayArgs,
    /// Write the points here
    #[arg(long, value_name = "FILE.csv")]
    pub(super) to: PathBuf,
    /// Draw some of the images with their lines here
    #[arg(long, value_name = "FILE.png")]
    pub(super) picture: Option<PathBuf>,
    /// Replace --to and --picture where they exist
    #[arg(long)]
    pub(super) overwrite: bool,
    /// The time to add to an image's stamp to find its pose, and its deviation, instead of what the calibration says
    #[arg(long, value_name = "MS,MS", allow_hyphen_values = true)]
    pub(super) lag_ms: Option<LagMs>,
    /// A point each so far along a line
    #[arg(long, value_name = "MM", default_value = "2", allow_hyphen_values = true)]
    pub(super) step_mm: Positive,
    /// Deviation across its image of what the probe sees: the beam's height
    #[arg(long, value_name = "MM", default_value = "0.7", allow_hyphen_values = true)]
    pub(super) elevation_mm: Positive,
    /// Deviation of a pose's shift along each axis
    #[arg(long, value_name = "MM", default_value = "0.1", value_parser = from_zero, allow_hyphen_values = true)]
    pub(super) pose_noise_mm: f64,
    /// Deviation of a pose's turn about each axis
    #[arg(long, value_name = "DEG", default_value = "0.05", value_parser = from_zero, allow_hyphen_values = true)]
    pub(super) pose_noise_deg: f64,
}
