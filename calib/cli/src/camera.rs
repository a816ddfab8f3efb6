//! `calib camera`: grids seen in several views to a camera.

mod agree;
mod drawing;
mod error;
mod field;
mod file;
mod read;
mod report;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use optics::camera::{Gates, LensModel, Options, Short, View, calibrate, held_out};

use crate::commands::Outcome;
use crate::input_files::source::Source;
use crate::store;
use crate::values::Positive;
use error::{CameraError, advice};
pub use field::FieldRecord;
pub use file::{CAMERA_FORMAT, CAMERA_VERSION, CameraFile, CameraReadError, CameraView, PlateRecord, SourceRecord};
use read::{Grids, Seen};

pub(crate) const CAMERA_HELP: &str = "\
Takes what `calib grid --out` wrote for several images of one camera, at least three, with the grid tilted differently \
in each, and finds focal lengths, principal point and the lens' distortion, the grid's place in every view and the \
covariance of all of them. Use `calib grid --one-by-one`: discs that were fitted as a whole lie on a homography by \
construction and say nothing of the lens.

A pixel's centre is at whole coordinates, x to the right, y down. The lens is Brown's in OpenCV's order and signs: with \
x = X/Z, y = Y/Z, r2 = x^2 + y^2
  x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + 2 p1 x y + p2 (r2 + 2 x^2)
  y' = y (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 y^2) + 2 p2 x y
  u = fx x' + skew y' + cx,  v = fy y' + cy
--lens prism has in the place of p1 and p2 a thin prism: s1 r2 + s2 r2^2 added to x', s3 r2 + s4 r2^2 to y'. --plate bent \
also finds how far the grid is from flat, a paraboloid that is the same in all views; --plate field, besides, a smooth \
field by which its discs lie off that and off their places, as large as the views make it likely. More numbers leave smaller \
residuals whether they are true or not; --held-out tells: each view is predicted by the camera of the others.

The picture shows each disc's residual as a line, enlarged, over the image: an even pattern is a lens that needs more \
coefficients or a grid that is not flat: try --lens prism and --plate bent.

What falls short is said with what to do, and the exit code is 1; the file is written with its verdict. \
--allow-poor takes views that say little all the same. Residuals above 3 times the stated deviations of the discs are refused, \
and views whose focal lengths and principal points differ by as much, with the views that agree on one camera, where there are such: another camera's pictures, a focus or zoom that was moved, another \
lens than --lens, or a bent grid gives such residuals. --max-noise-ratio takes more of them.

Examples:
  calib grid views/*.png --cols 16 --rows 14 --pitch-mm 5 --one-by-one --out grids.json
  calib camera grids.json --out camera.toml --png residuals.png
  calib camera grids.json --lens prism --plate bent --held-out
  calib camera grids.json more.json --lens brown5 --max-rms-px 0.3
  calib camera grids.json --lens prism --plate field --max-noise-ratio 4 --out camera.toml";

#[derive(Debug, Args)]
pub(crate) struct CameraArgs {
    /// Files that calib grid wrote
    #[arg(required = true, value_name = "GRID.json")]
    grids: Vec<PathBuf>,
    /// The lens: none; k1, k2; these with p1, p2; these with k3; k1, k2 with s1 to s4
    #[arg(long, value_enum, default_value = "brown")]
    lens: LensArg,
    /// Free the skew too; else it is 0
    #[arg(long)]
    skew: bool,
    /// Whether the grid is flat, or bent by a paraboloid to be found, the same in all views, or that with its discs off by
    /// a smooth field
    #[arg(long, value_enum, default_value = "flat")]
    plate: PlateArg,
    /// Say too how well the camera of all other views predicts each view: one calibration more for each
    #[arg(long)]
    held_out: bool,
    /// Leave discs out that are further off than this many deviations
    #[arg(long, value_name = "DEVIATIONS", default_value = "6", allow_hyphen_values = true)]
    gate: Positive,
    /// Refuse residuals above this, root mean square
    #[arg(long, value_name = "PX", allow_hyphen_values = true)]
    max_rms_px: Option<Positive>,
    /// Refuse residuals above this many times the stated deviations of the discs, and views that differ by as much in what
    /// they say of the camera
    #[arg(long, value_name = "RATIO", default_value = "3", allow_hyphen_values = true)]
    max_noise_ratio: Positive,
    /// Accept views that differ little in tilt or leave much of the image empty
    #[arg(long)]
    allow_poor: bool,
    /// Write the camera here, as TOML
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Draw the residuals over the image here
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Replace --out if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LensArg {
    Pinhole,
    Radial,
    Brown,
    Brown5,
    Prism,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PlateArg {
    Flat,
    Bent,
    Field,
}

impl LensArg {
    fn model(self) -> LensModel {
        match self {
            Self::Pinhole => LensModel::Pinhole,
            Self::Radial => LensModel::Radial,
            Self::Brown => LensModel::Brown,
            Self::Brown5 => LensModel::Brown5,
            Self::Prism => LensModel::Prism,
        }
    }
}

impl CameraArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, CameraError> {
        if let Some(out) = &self.out {
            store::check(out, self.overwrite)?;
        }
        let grids = self.grids.iter().map(|path| Source::read_whole(path));
        let sources: Vec<Source> = grids.collect::<Result<_, _>>()?;
        let seen = Grids::of(&sources)?.seen()?;
        self.not_whole(&seen)?;
        let views: Vec<View> = seen.images.iter().map(|i| i.view.clone()).collect();
        let options = Options {
            lens: self.lens.model(),
            skew: self.skew,
            bent: self.plate != PlateArg::Flat,
            field: self.plate == PlateArg::Field,
            gate: self.gate.0,
            ..Options::default()
        };
        let names = || seen.images.iter().map(|i| i.name.clone()).collect();
        let refused = |refused| CameraError::Refused {
            views: views.len(),
            names: names(),
            advice: agree::after(advice(&refused), &refused, (&views, &seen, &options)),
            refused,
        };
        let found = calibrate(&views, seen.size, &options).map_err(refused)?;
        let short = self
            .gates()
            .judge(&found.coverage, found.rms_px, [found.noise_ratio, found.view_ratio]);
        let told = |short: &Short| short.to_string() + &agree::beside(short, &views, &seen, &options);
        let reasons: Vec<String> = short.iter().map(told).collect();
        let file = CameraFile::new(&found, &seen, &options, &sources, &reasons);
        let mut text = report::text(&found, &seen, &file);
        if self.held_out {
            let all = held_out(&views, seen.size, &options).map_err(refused)?;
            text.push_str(&report::held_out(&all, &seen));
        }
        if let Some(path) = &self.png {
            drawing::write(path, &found, &seen)?;
            text.push_str(&format!("residuals drawn in {}\n", path.display()));
        }
        if let Some(out) = &self.out {
            let inputs = self.grids.iter().map(PathBuf::as_path);
            store::write(out, file.text(), inputs)?;
            text.push_str(&format!("written to {}, id {}\n", out.display(), file.id));
        }
        let refused = (!reasons.is_empty()).then(|| format!("the camera is not accepted: {}", reasons.join("; ")));
        Ok(Outcome { text, refused })
    }

    fn gates(&self) -> Gates {
        let asked = Gates {
            max_rms_px: self.max_rms_px.map(|px| px.0),
            max_noise_ratio: Some(self.max_noise_ratio.0),
            ..Gates::default()
        };
        match self.allow_poor {
            true => Gates {
                min_tilt_rad: None,
                min_image: None,
                ..asked
            },
            false => asked,
        }
    }

    /// Discs that lie on a homography by construction hide the lens.
    fn not_whole(&self, seen: &Seen) -> Result<(), CameraError> {
        let whole = seen.images.iter().find(|image| image.whole);
        match whole {
            Some(image) if self.lens != LensArg::Pinhole => Err(CameraError::Whole {
                name: image.name.clone(),
            }),
            _ => Ok(()),
        }
    }
}

/// A file's name for people.
fn name_of(path: &str) -> String {
    let name = Path::new(path).file_name().map(|n| n.to_string_lossy().into_owned());
    crate::text::shown(&name.unwrap_or_else(|| path.to_owned()))
}
