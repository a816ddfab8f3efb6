//! `calib beads`: the metal beads of a CT.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use bead::{Search, find};
use clap::Args;

use super::error::BeadsError;
use super::file::BeadsFile;
use super::sheet;
use super::volume::{LoadVolume, ReadArgs, Volume, warned};
use crate::commands::Outcome;
use crate::store;
use crate::text::shown;
use crate::values::Positive;

pub(crate) const BEADS_HELP: &str = "\
VOLUME is what volume-loader reads: a folder with a DICOM series, or a NIfTI, NRRD or MetaImage file; `phantom` is the \
generated patient of seed 1.

Every local maximum that is bright enough is held against the detector chi: mean and deviation within a ball, and in a \
shell around it. A blurred ball is fitted to what remains, without the voxels that the scanner clipped. A bead must be \
round, of the radius and the metal asked for, with nothing as bright beside it: screws, wires, clips and bone are told \
of and not taken. Beads must lie about 3 mm apart, more in thick slices. The centre is fitted once more with the tissue \
around as a random field, so that bone beside a bead does not draw it.

Beads are numbered from the lowest slice on. x, y, z are left, posterior, superior in mm; `error` is the root mean \
square error of the centre that the fit predicts, without distortion of the scanner.

--png draws each bead in three planes with its centre marked: look at it before the beads are used.

Examples:
  calib beads ct-folder --out beads.json --png beads.png
  calib beads scan.nii.gz --radius-mm 0.5 --metal-hu 15000
  calib beads scan.mha --radius-range-mm 0.8 1.6 --all
  calib beads phantom --spacing-mm 1 --out beads.json";

#[derive(Debug, Args)]
pub(crate) struct BeadsArgs {
    /// The CT
    volume: PathBuf,
    #[command(flatten)]
    read: ReadArgs,
    /// Radius of the beads; 25 % to either side are accepted
    #[arg(long, value_name = "MM", default_value = "1", allow_hyphen_values = true)]
    radius_mm: Positive,
    /// Least and greatest radius, instead of that
    #[arg(long, value_names = ["LEAST", "MOST"], num_args = 2, conflicts_with = "radius_mm", allow_hyphen_values = true)]
    radius_range_mm: Option<Vec<Positive>>,
    /// Least HU of the beads' metal over its surroundings, before the scanner's blur and clipping
    #[arg(long, value_name = "HU", default_value = "6000", allow_hyphen_values = true)]
    metal_hu: Positive,
    /// The HU at which the scanner clips [default: found from the volume]
    #[arg(long, value_name = "HU", allow_hyphen_values = true)]
    clip_hu: Option<i16>,
    /// Write the beads here, as JSON
    #[arg(long, value_name = "FILE.json")]
    out: Option<PathBuf>,
    /// Draw them here
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Replace those files if they exist
    #[arg(long)]
    overwrite: bool,
    /// Print the file as JSON and nothing else
    #[arg(long)]
    json: bool,
    /// Take the numbers of another modality than CT as HU; the result's file says so
    #[arg(long)]
    accept_not_ct: bool,
    /// List every bright spot that is no bead
    #[arg(long)]
    all: bool,
}

/// Rejected spots that are listed where not all are.
const SHOWN: usize = 10;

impl BeadsArgs {
    pub(crate) fn run(&self, load: LoadVolume) -> Result<Outcome, BeadsError> {
        for path in [&self.out, &self.png].into_iter().flatten() {
            store::check(path, self.overwrite)?;
        }
        let (volume, warnings) = self.read.load_ct(&self.volume, load, self.accept_not_ct)?;
        let search = self.search();
        let found = find(&volume, &search).map_err(|refused| BeadsError::Find {
            path: self.volume.clone(),
            refused: Box::new(refused),
        })?;
        let file = BeadsFile::new((&self.volume, &volume, warnings), &search, &found);
        let encoded = serde_json::to_string_pretty(&file)? + "\n";
        let mut text = self.report(&file, found.spots);
        if let Some(out) = &self.out {
            store::write(out, Ok(encoded.clone()), std::iter::once(self.volume.as_path()))?;
            text += &format!("\nwritten to {}\n", out.display());
        }
        if let Some(png) = &self.png {
            self.draw(png, &volume, &file)?;
            text += &format!("drawn in {}\n", png.display());
        }
        Ok(Outcome {
            text: if self.json { encoded } else { text },
            refused: None,
        })
    }

    fn search(&self) -> Search {
        let nominal = Search::of_radius(self.radius_mm.0);
        let range = self.radius_range_mm.as_deref();
        let radius_mm = match range {
            Some([low, high]) => [low.0, high.0],
            _ => nominal.radius_mm,
        };
        Search {
            radius_mm,
            metal_hu: self.metal_hu.0,
            clip_hu: self.clip_hu,
            ..nominal
        }
    }

    fn draw(&self, png: &Path, volume: &Volume, file: &BeadsFile) -> Result<(), BeadsError> {
        let texts = [
            ("ct_hash", file.ct_hash.clone()),
            ("program", file.program.clone()),
            ("beads", file.beads.len().to_string()),
        ];
        Ok(picture::write_png(png, &sheet::draw(volume, &file.beads), &texts)?)
    }

    fn report(&self, file: &BeadsFile, spots: usize) -> String {
        let mut text = heading(file, spots);
        // Writing to a string does not fail.
        if file.beads.is_empty() {
            let _ = writeln!(text, "no bead was found");
        } else {
            let _ = writeln!(
                text,
                "bead           x          y          z    error   radius  blur         chi     HU over ground"
            );
        }
        for (i, bead) in file.beads.iter().enumerate() {
            let ([x, y, z], [plane, axial]) = (bead.centre_mm, bead.blur_mm);
            let clipped = if bead.clipped > 0 { ", clipped" } else { "" };
            let _ = writeln!(
                text,
                "{:>4}  {x:>10.3} {y:>10.3} {z:>10.3}   {:>6.3}   {:>6.3}  {plane:.2} {axial:.2} {:>9.1}     {:>7.0}{clipped}",
                i + 1,
                bead.error_rms_mm,
                bead.radius_mm,
                bead.chi,
                bead.contrast_hu
            );
        }
        self.rejected(&mut text, file);
        text
    }

    fn rejected(&self, text: &mut String, file: &BeadsFile) {
        let count = file.rejected.len();
        if count == 0 {
            return;
        }
        let _ = writeln!(text, "\n{count} bright spots that are no beads:");
        let listed = if self.all { count } else { count.min(SHOWN) };
        for spot in &file.rejected[..listed] {
            let [x, y, z] = spot.place_mm;
            let _ = writeln!(text, "      {x:>10.1} {y:>10.1} {z:>10.1}   {}", spot.reason);
        }
        if listed < count {
            let _ = writeln!(text, "      and {} more; --all lists them", count - listed);
        }
    }
}

fn heading(file: &BeadsFile, spots: usize) -> String {
    let [nx, ny, nz] = file.volume.dims;
    let [a, b, c] = file.volume.spacing_mm;
    let [low, high] = file.search.radius_mm;
    let clip = file
        .search
        .clip_hu
        .map_or("not clipped".to_owned(), |hu| format!("clipped at {hu} HU"));
    let warnings = warned(&file.warnings);
    format!(
        "{}: {nx} x {ny} x {nz} voxels of {a:.4} x {b:.4} x {c:.4} mm, {clip}\nCT {}\n{warnings}{} beads of {low:.2} to {high:.2} mm radius \
         among {spots} bright spots; at least {:.0} HU over their surroundings\n\n",
        shown(&file.volume.path),
        file.ct_hash,
        file.beads.len(),
        file.search.least_contrast_hu
    )
}
