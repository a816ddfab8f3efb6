//! The examination that a command is about, and how far its reading is.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::mpsc;
use std::thread::{self, JoinHandle};

use bus::clock::Clock;
use bus::message::Marks;
use clap::Args;
use geometry::VolumeGrid;
use scene::{RawRegion, RawVolume, VolumeSource, VolumeSpec};

use crate::dicom::{self, Series};
use crate::error::LoadError;
use crate::load::open;
use crate::progress::Progress;
use crate::source::{Conversion, Facts, ReadError, VoxelSource};

/// Which examination, and how much of it.
#[derive(Debug, Clone, Args)]
pub(super) struct Input {
    /// The examination: a folder with a DICOM series, a file (.nii, .nii.gz, .nrrd, .nhdr, .mha, .mhd, an Enhanced CT), or
    /// `phantom`, the generated patient.
    #[arg(value_name = "IN")]
    path: PathBuf,
    /// Which series of the folder or of an Enhanced CT, from 1 in the order in which they are listed where there are several.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    series: Option<u32>,
    /// Interpolate slices at uneven places to even ones instead of refusing them.
    #[arg(long)]
    regrid: bool,
    /// Take the axes of a file without orientation as left, posterior, superior instead of refusing it.
    #[arg(long)]
    assume_lps: bool,
    /// Only this box: two opposite corners, LPS mm.
    #[arg(long, value_name = "x,y,z,x,y,z", value_parser = six::<f64>, allow_hyphen_values = true)]
    box_mm: Option<[f64; 6]>,
    /// Only these voxels: the first, and the one behind the last.
    #[arg(long, value_name = "i,j,k,i,j,k", value_parser = six::<u32>, conflicts_with = "box_mm")]
    box_voxels: Option<[u32; 6]>,
    /// So many voxels along each axis become one.
    #[arg(long, value_name = "i,j,k", value_parser = numbers::<u32, 3>)]
    downsample: Option<[u32; 3]>,
}

fn six<T: FromStr>(text: &str) -> Result<[T; 6], String> {
    numbers(text)
}

fn numbers<T: FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    let parsed: Result<Vec<T>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let wrong = || format!("expected {N} numbers with commas between them");
    parsed.map_err(|_| wrong())?.try_into().map_err(|_| wrong())
}

impl Input {
    /// All of what is at `path`, with nothing allowed that is doubtful.
    pub(super) fn of(path: PathBuf) -> Self {
        Self {
            path,
            series: None,
            regrid: false,
            assume_lps: false,
            box_mm: None,
            box_voxels: None,
            downsample: None,
        }
    }

    /// The same for each series of a folder that holds several, where none was chosen; otherwise itself alone.
    ///
    /// # Errors
    /// Those of looking through the folder.
    pub(super) fn each_series(&self) -> Result<Vec<Self>, InputError> {
        let several = match self.series.is_none() && dicom::holds_series(&self.path) {
            true => Series::scan(&self.path)
                .map_err(ReadError::from)
                .map_err(LoadError::from)?
                .series
                .len(),
            false => 1,
        };
        let chosen = |number: usize| Self {
            series: if several > 1 {
                u32::try_from(number).ok()
            } else {
                self.series
            },
            ..self.clone()
        };
        Ok((1..=several.max(1)).map(chosen).collect())
    }

    /// What a DICOM series says of the patient, the visit and the place; other formats say nothing.
    ///
    /// # Errors
    /// Those of looking through the folder.
    pub(super) fn identity(&self) -> Result<Vec<(&'static str, String)>, InputError> {
        if !dicom::holds_series(&self.path) {
            return Ok(Vec::new());
        }
        let number = self.series.map(|number| number as usize);
        let found = Series::scan(&self.path).and_then(|found| found.choose(number));
        let said = found.and_then(|series| series.identity());
        Ok(said.map_err(ReadError::from).map_err(LoadError::from)?)
    }

    /// Opens it, with a bar that shows how far its reading is.
    ///
    /// # Errors
    /// [`InputError`].
    pub(super) fn open(&self) -> Result<Watched, InputError> {
        let source = open(&self.spec()?, phantom::DEFAULT_SEED)?;
        let bar = Bar::new(source.grid().dims()[2]);
        Ok(Watched { source, bar })
    }

    /// The same as a scene's `[volume]`, and checked like that.
    fn spec(&self) -> Result<VolumeSpec, InputError> {
        let region = RawRegion {
            box_mm: self.box_mm.map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]),
            box_voxels: self.box_voxels.map(|[a, b, c, d, e, f]| [[a, b, c], [d, e, f]]),
            ..RawRegion::default()
        };
        let raw = RawVolume {
            source: self.path.to_string_lossy().into_owned(),
            series: self.series,
            regrid: self.regrid,
            assume_lps: self.assume_lps,
            downsample: self.downsample.unwrap_or([1; 3]),
            region: (region != RawRegion::default()).then_some(region),
            ..RawVolume::default()
        };
        let mut spec = raw.checked().map_err(InputError::Option)?;
        if let VolumeSource::File(file) = &mut spec.source {
            // A name that is not UTF-8 is a name.
            file.path.clone_from(&self.path);
        }
        Ok(spec)
    }
}

/// Why an examination was not opened.
#[derive(Debug, thiserror::Error)]
pub(crate) enum InputError {
    /// An option has a value that is not allowed.
    #[error("{0}")]
    Option(String),
    /// The examination was refused.
    #[error(transparent)]
    Load(#[from] LoadError),
}

/// A source that shows its progress while it is read slice by slice.
pub(super) struct Watched {
    source: Box<dyn VoxelSource>,
    bar: Bar,
}

/// Progress on a thread of its own: a source goes from thread to thread, and a [`Progress`] stays on one.
struct Bar {
    done: Option<mpsc::Sender<u32>>,
    thread: Option<JoinHandle<()>>,
}

impl Bar {
    fn new(total: u32) -> Self {
        let (done, told) = mpsc::channel();
        let thread = thread::spawn(move || {
            let mut progress = Progress::new(Clock::monotonic(0), total);
            told.iter().for_each(|done| progress.at(done));
            progress.finish();
        });
        Self {
            done: Some(done),
            thread: Some(thread),
        }
    }

    fn at(&self, slices: u32) {
        if let Some(done) = &self.done {
            // Without its thread there is no bar; the reading goes on.
            let _ = done.send(slices);
        }
    }

    /// Ends the bar's line before anything else is printed.
    fn end(&mut self) {
        self.done = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.end();
    }
}

impl VoxelSource for Watched {
    fn grid(&self) -> &VolumeGrid {
        self.source.grid()
    }

    fn padding_hu(&self) -> i16 {
        self.source.padding_hu()
    }

    fn describe(&self) -> String {
        self.source.describe()
    }

    fn marks(&self) -> Marks {
        self.source.marks()
    }

    fn facts(&self) -> Facts {
        self.source.facts()
    }

    fn remarks(&self) -> Vec<String> {
        self.source.remarks()
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.bar.at(k);
        self.source.read_slice(k, out)
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        self.bar.end();
        self.source.finish()
    }
}
