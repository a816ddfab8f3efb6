//! What is studied: the study files, checked, with places and reasons.

mod at;
mod check;
mod error;
mod raw;
mod surface;
mod sweep;
mod tissue;
mod told;

use std::path::{Path, PathBuf};

use phantom::{Landmark, Phantom};

pub use error::PlanError;
pub use surface::Surface;
pub use sweep::{Factor, Sweep};
pub use tissue::Tissue;
use told::OfFile;

/// The longest study file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// All that a run of the program does.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// In the order of the files and of the strata in them; no two of one name.
    pub strata: Vec<Stratum>,
    /// Factorial sweeps among them, in order.
    pub sweeps: Vec<Sweep>,
    /// BLAKE3 of the files' texts, of the names that files give to strata, and of the scenes of organs that they name, hexadecimal: what a
    /// folder of results is of.
    pub hash: String,
    /// The files' names without folders, for the report.
    pub files: Vec<String>,
}

/// Operations that differ by their draws alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Stratum {
    /// What it is told as: its name, or `FILE.NAME` where several files of the plan have one of that name.
    pub name: String,
    /// Its name in its file, of the characters a-z, A-Z, 0-9, `-` and `_`.
    pub own_name: String,
    /// All draws follow from this, the name in its file and the number of the operation.
    pub seed: u64,
    /// How many.
    pub operations: u64,
    /// Under which conditions.
    pub dials: Dials,
}

/// The conditions of a stratum. Lengths mm, angles rad, times s.
#[derive(Debug, Clone, PartialEq)]
pub struct Dials {
    /// Which of the patient's nodes are approached, by number among [`phantom::Phantom::targets`].
    pub targets: Vec<usize>,
    /// Radius that is aimed at: ON TARGET promises that the tip is within.
    pub radius_mm: f64,
    /// What the operator steers by.
    pub display: Display,
    /// The examination.
    pub ct: Ct,
    /// The beads in the examination, of which some are touched to register.
    pub beads: Beads,
    /// The bone's surface is seen by ultrasound to register, and of the beads one is touched, to check that.
    pub surface: Option<Surface>,
    /// The diameter of all beads on the skin: balls of metal.
    pub bead_mm: f64,
    /// The balls of emitters on tool and patient.
    pub marker: Marker,
    /// How the marker on the patient sits on it: turned by so much about an axis that is none of the patient's.
    pub reference_deg: f64,
    /// Who sees them.
    pub localizer: Localizer,
    /// How calibrations are made.
    pub calibration: Calibration,
    /// How points are touched.
    pub touch: Touch,
    /// The largest error that a check of the registration lets pass.
    pub check_max_mm: f64,
    /// A hand before the emitters: the share of the time, and from one coming to the next.
    pub occlusion: Option<[f64; 2]>,
    /// Organs move with the breath while targets are approached.
    pub breathing: Option<Breathing>,
    /// The tube moves organs, and what is told is told of a place in one.
    pub tissue: Option<Tissue>,
    /// The marker on the patient is moved on it after the registration.
    pub bump: Option<Bump>,
    /// An error that nobody states, so that the study has something to find.
    pub planted: Option<Planted>,
    /// Poses state deviations that are so many times smaller than those of the chain; 1 in earnest.
    pub understated: f64,
}

/// What the operator steers by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Display {
    /// The numbers of the sight, as coarse as they are drawn.
    Sight,
    /// What stands in the window's pixels.
    Pixels,
}

/// The examination.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ct {
    /// Along left, posterior and superior.
    pub spacing_mm: [f64; 3],
    /// Standard deviation of a voxel.
    pub noise_hu: f64,
    /// Examinations of the stratum, each with voxels at other places and its own noise; operations take them in turn.
    pub images: u64,
}

/// What is touched to register.
#[derive(Debug, Clone, PartialEq)]
pub enum Beads {
    /// Some of the eight beads on the skin, by number among [`phantom::Phantom::beads`].
    OnSkin(Vec<usize>),
    /// Beads at these places of the CT, mm.
    At(Vec<[f64; 3]>),
}

/// A ball of emitters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marker {
    /// How many.
    pub emitters: usize,
    /// Of the ball.
    pub radius_mm: f64,
    /// How wide it is across its axis, as a share of that: 1 is a ball, little is a needle.
    pub width: f64,
    /// Half-angle in which an emitter shines.
    pub cone_deg: f64,
    /// How far emitters are from where they were to be put, standard deviation along each axis.
    pub made_mm: f64,
}

/// The localizer, 2.3 m from the patient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Localizer {
    /// Noise across the line of sight.
    pub across_mm: f64,
    /// And along it.
    pub depth_mm: f64,
    /// Frames a second.
    pub rate_hz: f64,
    /// Beyond the 50 ms that a display takes.
    pub latency_s: f64,
    /// How long it has been on when the operation begins: its frames are numbered from the beginning.
    pub uptime_s: f64,
    /// By how much it and its axes are turned about the patient's long axis.
    pub turned_deg: f64,
    /// And then moved, along left, posterior and superior.
    pub moved_mm: [f64; 3],
}

/// How calibrations are made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Frames of the marker's calibration.
    pub marker_frames: u64,
    /// How long the tip is turned in its divot.
    pub pivot_s: f64,
    /// How far the tool sits in the base from where it is drawn, standard deviations about each axis.
    pub seat_mm: f64,
    /// See `seat_mm`.
    pub seat_deg: f64,
}

/// How points are touched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// How far a touch is off its point, standard deviation along each axis.
    pub error_mm: f64,
    /// What `calib match` and `calib check` are told of that.
    pub stated_mm: f64,
    /// How the tip trembles.
    pub tremor_mm: f64,
    /// How long the tip is held.
    pub seconds: f64,
}

/// Organs and the targets in them move along the patient's long axis: towards the feet on inspiration, and back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breathing {
    /// From the end of an expiration to the end of an inspiration.
    pub mm: f64,
    /// One breath.
    pub period_s: f64,
}

/// The marker on the patient is moved on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bump {
    /// In this share of the operations; in half of these before the check, in the others after it.
    pub share: f64,
    /// How far, in a direction of its own each time.
    pub mm: f64,
    /// How much it turns.
    pub deg: f64,
}

/// An error that nobody states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planted {
    /// In which link.
    pub link: PlantedIn,
    /// How large.
    pub mm: f64,
}

/// Where an error is planted: a shift along x of the frame that the link maps to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlantedIn {
    /// The tool's calibration, as it is in use.
    Tool,
    /// The patient's registration, as it is in use.
    Registration,
}

impl Stratum {
    /// Of what errors are told, in this order: what is approached, but where the tube moves organs.
    pub fn targets(&self) -> Vec<Landmark> {
        if let Some(tissue) = &self.dials.tissue {
            return vec![tissue.told.clone()];
        }
        let (patient, numbers) = (Phantom::new(phantom::DEFAULT_SEED), &self.dials.targets);
        numbers
            .iter()
            .filter_map(|at| patient.targets().get(*at).cloned())
            .collect()
    }
}

impl Plan {
    /// Reads and checks study files; all of them together are one study.
    ///
    /// # Errors
    /// [`PlanError`], with the file, the stratum and the key.
    pub fn load(paths: &[PathBuf]) -> Result<Self, PlanError> {
        let mut texts = Vec::new();
        for path in paths {
            let text = scene::file::read_text(path, MAX_BYTES).map_err(|error| PlanError::Open {
                path: path.clone(),
                why: error.to_string(),
            })?;
            texts.push((path.as_path(), text));
        }
        Self::of_texts(texts.iter().map(|(path, text)| (*path, text.as_str())))
    }

    /// The same of texts that were read, each with the name to be told in errors.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn of_texts<'a>(texts: impl IntoIterator<Item = (&'a Path, &'a str)>) -> Result<Self, PlanError> {
        let mut hash = blake3::Hasher::new();
        let (mut of_files, mut files, mut before) = (Vec::new(), Vec::new(), 0);
        for (path, text) in texts {
            hash.update(&(text.len() as u64).to_le_bytes());
            hash.update(text.as_bytes());
            files.push(path.file_name().unwrap_or_default().to_string_lossy().into_owned());
            let (own, sweep) = check::strata(path, text, before)?;
            before += own.len();
            of_files.push(OfFile {
                path,
                strata: own,
                sweep,
            });
        }
        told::apart(&mut of_files, &mut hash)?;
        let (mut strata, mut sweeps) = (Vec::new(), Vec::new());
        for file in of_files {
            for stratum in &file.strata {
                stratum.dials.tissue.iter().for_each(|tissue| {
                    hash.update(&tissue.hash);
                });
            }
            strata.extend(file.strata);
            sweeps.extend(file.sweep);
        }
        if strata.is_empty() {
            return Err(PlanError::Nothing);
        }
        Ok(Self {
            strata,
            sweeps,
            hash: hash.finalize().to_hex().to_string(),
            files,
        })
    }

    /// Operations of all strata.
    pub fn operations(&self) -> u64 {
        self.strata.iter().map(|stratum| stratum.operations).sum()
    }

    /// The operation of this place in the order of all: its stratum and its number there.
    pub fn operation(&self, at: u64) -> Option<(&Stratum, u64)> {
        let mut left = at;
        for stratum in &self.strata {
            match left.checked_sub(stratum.operations) {
                None => return Some((stratum, left)),
                Some(rest) => left = rest,
            }
        }
        None
    }
}
