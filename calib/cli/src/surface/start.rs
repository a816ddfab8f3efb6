//! What is known of the pose before, as files have it.

use std::path::{Path, PathBuf};

use geometry::{Point, checked};
use surface_registration::{Landmark, Start};

use super::error::SurfaceCommandError;
use crate::register::file::{InputFile, RegistrationFile};
use crate::register::input::{From as PairsFrom, Input};
use crate::register::solve::{From, To};

/// Where a search is to begin.
#[derive(Debug, Clone)]
pub(super) enum Begin {
    /// A registration that is wrong by up to so much.
    Guess { path: PathBuf, degrees: f64, mm: f64 },
    /// Pairs of points, with a deviation along each axis.
    Landmarks { path: PathBuf, sigma_mm: f64 },
    /// Everywhere.
    Nothing,
}

/// A start that was read, with the files that it is of.
pub(super) struct Begun {
    pub(super) start: Start<To, From>,
    pub(super) word: &'static str,
    pub(super) inputs: Vec<InputFile>,
}

impl Begin {
    /// Reads what it names; a guess must be between the frames of these names.
    pub(super) fn read(&self, to: &str, from: &str) -> Result<Begun, SurfaceCommandError> {
        match self {
            Self::Nothing => Ok(Begun {
                start: Start::Nothing,
                word: "nothing",
                inputs: Vec::new(),
            }),
            Self::Guess { path, degrees, mm } => {
                let bytes = crate::foreign::bytes(path, MAX_GUESS)?;
                Ok(Begun {
                    start: guess(path, [to, from], degrees.to_radians(), *mm)?,
                    word: "guess",
                    inputs: vec![super::bone::input("guess", path, &bytes)],
                })
            }
            Self::Landmarks { path, sigma_mm } => {
                let input = Input::read(&PairsFrom::Csv(path.clone()), false, false)?;
                let place = |[x, y, z]: [f64; 3]| Point::<To>::new(x, y, z);
                let seen = |[x, y, z]: [f64; 3]| Point::<From>::new(x, y, z);
                let landmark = |row: &crate::register::row::Row| Landmark {
                    to: place(row.to),
                    from: seen(row.from),
                    sigma_mm: *sigma_mm,
                };
                Ok(Begun {
                    start: Start::Landmarks(input.rows.iter().map(landmark).collect()),
                    word: "landmarks",
                    inputs: crate::register::inputs(&input)
                        .into_iter()
                        .map(|file| InputFile {
                            role: "landmarks".to_owned(),
                            ..file
                        })
                        .collect(),
                })
            }
        }
    }
}

/// The longest file of a guess, bytes.
const MAX_GUESS: usize = 64 << 20;

fn guess(
    path: &Path,
    [to, from]: [&str; 2],
    turn_rad: f64,
    shift_mm: f64,
) -> Result<Start<To, From>, SurfaceCommandError> {
    let file = RegistrationFile::read(path)?;
    if (file.to.as_str(), file.from.as_str()) != (to, from) {
        return Err(SurfaceCommandError::OtherFrames {
            path: path.to_owned(),
            found: file.transform.name,
            expected: format!("{to}_from_{from}"),
        });
    }
    let numbers = |what: String| SurfaceCommandError::GuessNumbers {
        path: path.to_owned(),
        what,
    };
    let transform = &file.transform;
    if transform.scale != 1.0 {
        return Err(numbers(format!(
            "its scale is {}; patients are measured in mm",
            transform.scale
        )));
    }
    let pose = checked::rigid(transform.quaternion_wxyz, transform.translation_mm, 1e-9)
        .map_err(|error| numbers(error.to_string()))?;
    Ok(Start::Guess {
        pose,
        turn_rad,
        shift_mm,
    })
}
