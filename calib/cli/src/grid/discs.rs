//! `calib discs`: all discs of an image, wherever they are.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use nalgebra::Vector2;
use optics::disc::{DetectOptions, DetectRefused, Disc, DiscFit, Ellipse, Polarity, detect, fit_disc};
use optics::image::Image;
use picture::{Line, Rgb, write_png};
use serde_json::{Value, json};

use crate::commands::Outcome;
use crate::grid::overlay::{canvas, on_canvas};
use crate::grid::{ReadImageError, read_image};
use crate::store::{self, StoreError};
use crate::values::Positive;

pub(crate) const DISCS_HELP: &str = "\
Finds discs that are even inside and around, and refines each. `chi` is the contrast by the deviations inside and in \
half the ring; `deviation_px` is that of the refined centre, by the noise found there; without it the fit was refused \
and the place is good to a pixel. Specks of texture are discs too: those far fainter than most are left out (--contrast-min), more \
with a greater --chi-min.

Examples:
  calib discs plate.png --radius-min 3 --radius-max 12 --overlay seen.png
  calib discs film.pgm --radius-min 2 --radius-max 6 --polarity bright --json";

/// The blur that the fits start from, pixels.
const BLUR: f64 = 0.9;

#[derive(Debug, Args)]
pub(crate) struct DiscsArgs {
    /// A PNG, JPEG or PGM image of 8 or 16 bits
    image: PathBuf,
    /// The least radius, pixels
    #[arg(long, value_name = "PX", default_value = "2", allow_hyphen_values = true)]
    radius_min: Positive,
    /// The greatest radius, pixels
    #[arg(long, value_name = "PX", default_value = "12", allow_hyphen_values = true)]
    radius_max: Positive,
    /// The least contrast, in deviations of what is inside and half of those around
    #[arg(long, value_name = "CHI", default_value = "1", allow_hyphen_values = true)]
    chi_min: Positive,
    /// The least contrast, beside the median of all discs found; 0 keeps all
    #[arg(long, value_name = "SHARE", default_value = "0.25", allow_hyphen_values = true)]
    contrast_min: Share,
    /// Darker or brighter than what is around
    #[arg(long, value_enum, default_value = "dark")]
    polarity: PolarityArg,
    /// Write what was found here, as JSON
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Draw what was found here
    #[arg(long, value_name = "FILE.png")]
    overlay: Option<PathBuf>,
    /// Replace --out if it exists
    #[arg(long, requires = "out")]
    overwrite: bool,
    /// Print the result as JSON and nothing else
    #[arg(long)]
    json: bool,
}

/// From 0 to 1.
#[derive(Debug, Clone, Copy)]
struct Share(f64);

impl FromStr for Share {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let share = text.parse::<f64>().map_err(|e| format!("{text:?}: {e}"))?;
        let good = (0.0..=1.0).contains(&share);
        good.then_some(Self(share))
            .ok_or_else(|| format!("{text} is not from 0 to 1"))
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PolarityArg {
    Dark,
    Bright,
    Both,
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DiscsError {
    #[error(transparent)]
    Image(#[from] ReadImageError),
    #[error("looking for discs in {path}: {refused}")]
    Detect { path: PathBuf, refused: DetectRefused },
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Picture(#[from] picture::PngError),
}

/// A disc and, where it could be fitted, its outline.
type Seen = (Disc, Option<DiscFit>);

impl DiscsArgs {
    /// Does what is asked.
    pub(crate) fn run(&self) -> Result<Outcome, DiscsError> {
        if let Some(out) = &self.out {
            store::check(out, self.overwrite)?;
        }
        let image = read_image(&self.image)?;
        let polarity = match self.polarity {
            PolarityArg::Dark => Polarity::Dark,
            PolarityArg::Bright => Polarity::Bright,
            PolarityArg::Both => Polarity::Both,
        };
        let options = DetectOptions {
            polarity,
            least: self.chi_min.0,
            share: self.contrast_min.0,
            ..DetectOptions::new(self.radius_min.0, self.radius_max.0)
        };
        let path = self.image.clone();
        let discs = detect(&image, &options).map_err(|refused| DiscsError::Detect { path, refused })?;
        let seen: Vec<Seen> = discs.into_iter().map(|disc| (disc, fitted(&image, &disc))).collect();
        if let Some(path) = &self.overlay {
            draw(path, &image, &seen)?;
        }
        let encoded = format!("{:#}\n", self.record(&image, &seen));
        let mut text = words(&seen);
        if let Some(out) = &self.out {
            store::write(out, Ok(encoded.clone()), [self.image.as_path()].into_iter())?;
            text.push_str(&format!("written to {}\n", out.display()));
        }
        let text = if self.json { encoded } else { text };
        Ok(Outcome { text, refused: None })
    }

    fn record(&self, image: &Image, seen: &[Seen]) -> Value {
        let discs: Vec<Value> = seen.iter().map(record).collect();
        json!({
            "trocar_discs": 1,
            "program": concat!("calib ", env!("CARGO_PKG_VERSION")),
            "units": "pixels, centres of pixels at whole coordinates, x to the right, y down",
            "path": self.image.to_string_lossy(),
            "width": image.width(),
            "height": image.height(),
            "discs": discs,
        })
    }
}

fn fitted(image: &Image, disc: &Disc) -> Option<DiscFit> {
    let start = Ellipse::circle(centre(disc), disc.radius.max(1.0));
    fit_disc(image, &start, BLUR, (0.6 * disc.radius).clamp(3.0, 10.0)).ok()
}

fn centre(disc: &Disc) -> Vector2<f64> {
    Vector2::new(disc.at[0] as f64, disc.at[1] as f64)
}

fn record((disc, fit): &Seen) -> Value {
    let at = fit.as_ref().map_or(centre(disc), |f| f.ellipse.centre);
    let axes = fit.as_ref().map(|f| f.ellipse.axes());
    json!({
        "x_px": at.x,
        "y_px": at.y,
        "radius_px": disc.radius,
        "chi": disc.chi.value,
        "semi_axes_px": axes.map(|a| a.semi),
        "long_axis_deg": axes.map(|a| a.long.y.atan2(a.long.x).to_degrees()),
        "deviation_px": fit.as_ref().map(deviation),
    })
}

/// Root mean square of the deviations along x and y.
fn deviation(fit: &DiscFit) -> f64 {
    (0.5 * fit.covariance.trace()).max(0.0).sqrt()
}

fn words(seen: &[Seen]) -> String {
    let fits = seen.iter().filter(|s| s.1.is_some()).count();
    let mut text = format!(
        "{} discs, {fits} of them refined\n     x px      y px  radius  chi    deviation px\n",
        seen.len()
    );
    for (disc, fit) in seen.iter().take(20) {
        let at = fit.as_ref().map_or(centre(disc), |f| f.ellipse.centre);
        let deviation = fit.as_ref().map_or("-".to_owned(), |f| format!("{:.4}", deviation(f)));
        let (radius, chi) = (disc.radius, disc.chi.value);
        text.push_str(&format!(
            "{:9.3} {:9.3} {radius:7.2} {chi:6.2} {deviation}\n",
            at.x, at.y
        ));
    }
    if seen.len() > 20 {
        text.push_str(&format!("and {} more: --json lists all\n", seen.len() - 20));
    }
    text
}

fn draw(path: &std::path::Path, image: &Image, seen: &[Seen]) -> Result<(), picture::PngError> {
    let mut canvas = canvas(image);
    for (disc, fit) in seen {
        let at = fit.as_ref().map_or(centre(disc), |f| f.ellipse.centre);
        let colour = if fit.is_some() {
            Rgb(0, 230, 90)
        } else {
            Rgb(255, 190, 0)
        };
        canvas.circle(on_canvas(at), disc.radius + 2.0, Line::solid(colour, 1.0));
    }
    write_png(path, &canvas, &[])
}
