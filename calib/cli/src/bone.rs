//! `calib bone`: the surface of a bone from a CT, to register with.

mod error;
mod file;
mod labels;
mod readers;
mod region;
mod report;
mod sheet;
mod surface;
#[cfg(test)]
mod tests;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Mutex;

use bone::{Bone, Options, Region, VoxelBox};
use clap::Args;
use geometry::VolumeGrid;

pub use file::{BONE_FORMAT, BONE_VERSION, BoneFile, BoneScannerRecord, LostRecord};

use crate::beads::{ReadArgs, Volume};
use crate::commands::Outcome;
use crate::store;
use crate::values::Positive;
use error::BoneError;
use labels::Labelled;
pub(crate) use readers::Readers;
use region::RegionArgs;
use surface::Format;

pub(crate) const BONE_HELP: &str = "\
CT is what volume-loader reads: a folder with a DICOM series, or a NIfTI, NRRD or MetaImage file; `phantom` is the generated \
patient of seed 1.

A threshold says only which voxels hang together; it lies 0.5 to 1.7 mm outside the bone, the more the thicker the voxels. Along \
each normal of its surface tissue, cortex and what is inside, blurred as the scanner blurs, are fitted to the voxels: that gives each \
corner its position, and its deviation. Blur, noise and the HU of cortex come from the CT itself. Corners without a position of their \
own (a joint that was cut, the CT's end, another bone too near, metal) are left out: the surface is open there, and it is said how much.

What has no cortex is no bone: where a layer of at most --contrast-hu explains the voxels better than cortex does, a vessel or an organ with \
contrast medium, the surface is left out, and it is said where. Where neither is told, as with cortex that is thin against the voxels, \
the corners stay in the file, marked, and no triangle holds them: nothing registers to them. --accept-no-cortex takes all of it, and so does a label map that names the bone, unless most of it is contrast medium.

Which bone: --labels with --label, --box, --seed, or --component. Without one of them what is above the threshold is listed, and where \
there are several bodies nothing is chosen: the largest may be the heart of a CT with contrast, or bones that touch in a joint. Of a \
label map all other labels as bright as bone are kept out; without one --cut cuts a joint by a plane.

--out writes the surface (.ply or .vtk; left, posterior, superior in mm; with each corner's deviation), and beside it, under the same name \
with .json, what it rests on. --png draws its outline on the CT: look at it before the surface is used.

Examples:
  calib bone ct.nii.gz --labels organs.nii.gz --label hip_left --out hip.ply --png hip.png
  calib bone ct-folder --seed -31.5,-12,880 --cut 0,-20,905,0,0,1 --out vertebra.ply
  calib bone ct.nii.gz --box -120,-60,700,0,80,900 --threshold-hu 250 --out hip.vtk
  calib bone ct.nii.gz";

#[derive(Debug, Args)]
pub(crate) struct BoneArgs {
    /// The CT
    #[arg(value_name = "CT")]
    volume: PathBuf,
    #[command(flatten)]
    read: ReadArgs,
    #[command(flatten)]
    region: RegionArgs,
    /// Bone has at least so many HU; for what hangs together, not for where it ends
    #[arg(long, value_name = "HU", default_value = "200", allow_hyphen_values = true)]
    threshold_hu: Positive,
    /// Metal has at least so many HU
    #[arg(long, value_name = "HU", default_value = "3000", allow_hyphen_values = true)]
    metal_hu: i16,
    /// Vessels and organs with contrast medium have at most so many HU: a surface that so many explain has no cortex. 0 of a CT without contrast medium: all of it is bone then
    #[arg(long, value_name = "HU", default_value = "450", allow_hyphen_values = true)]
    contrast_hu: f64,
    /// The scanner's blur in the slices' plane and across it, deviations of a Gaussian [default: found from the CT]
    #[arg(long, value_names = ["PLANE", "ACROSS"], num_args = 2, allow_hyphen_values = true)]
    blur_mm: Option<Vec<Positive>>,
    /// Take what has no cortex too, and register to it
    #[arg(long)]
    accept_no_cortex: bool,
    /// Take the numbers of another modality than CT as HU; the result's file says so
    #[arg(long)]
    accept_not_ct: bool,
    /// Write the surface here, and what it rests on beside it
    #[arg(long, value_name = "FILE.ply|FILE.vtk")]
    out: Option<PathBuf>,
    /// Draw its outline on the CT here
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
    /// Replace those files if they exist
    #[arg(long)]
    overwrite: bool,
    /// Print what it rests on as JSON and nothing else
    #[arg(long)]
    json: bool,
}

/// More threads bring nothing here.
const MOST_THREADS: usize = 16;

impl BoneArgs {
    pub(crate) fn run(&self, hands: &Readers) -> Result<Outcome, BoneError> {
        let outputs = self.outputs()?;
        for path in outputs
            .iter()
            .flat_map(|(surface, _, record)| [surface, record])
            .chain(&self.png)
        {
            store::check(path, self.overwrite)?;
        }
        let spec = self.read.spec(&self.volume)?;
        let (volume, warnings) = self.read.load_ct(&self.volume, hands.load, self.accept_not_ct)?;
        let labelled = self.region.labelled(&volume, &spec, hands, self.threshold_hu.0)?;
        let bone = self.extract(&volume, labelled.as_ref())?;
        let (name, surface_bytes) = match &outputs {
            Some((path, format, _)) => (
                path.file_name().map(|name| name.to_string_lossy().into_owned()),
                surface::bytes(&bone, *format),
            ),
            None => (None, surface::bytes(&bone, Format::Ply)),
        };
        let file = BoneFile::new(
            self,
            (&volume, warnings),
            labelled.as_ref(),
            &bone,
            (name, &surface_bytes),
        );
        let encoded = serde_json::to_string_pretty(&file)? + "\n";
        let mut text = report::report(&self.volume, &volume, &bone, &file);
        if let Some((path, _, record)) = &outputs {
            let inputs = || std::iter::once(self.volume.as_path()).chain(self.region.labels());
            // The surface first: a record without its surface would name what is not there.
            store::write_bytes(path, Ok(surface_bytes), inputs())?;
            store::write(record, Ok(encoded.clone()), inputs())?;
            text += &format!("\nwritten to {} and {}\n", path.display(), record.display());
        }
        if let Some(png) = &self.png {
            let texts = [
                ("ct_hash", file.ct_hash.clone()),
                ("program", file.program.clone()),
                ("surface_blake3", file.surface_blake3.clone()),
            ];
            picture::write_png(png, &sheet::draw(&volume, &bone), &texts)?;
            text += &format!("drawn in {}\n", png.display());
        }
        Ok(Outcome {
            text: if self.json { encoded } else { text },
            refused: None,
        })
    }

    /// The surface's file with its format, and the record beside it.
    fn outputs(&self) -> Result<Option<(PathBuf, Format, PathBuf)>, BoneError> {
        let Some(out) = &self.out else { return Ok(None) };
        let format = Format::of(out).ok_or_else(|| BoneError::Ending { path: out.clone() })?;
        Ok(Some((out.clone(), format, out.with_extension("json"))))
    }

    fn extract(&self, volume: &Volume, labelled: Option<&Labelled>) -> Result<Bone, BoneError> {
        let told = Mutex::new(("", 0_u32));
        let is_terminal = std::io::stderr().is_terminal();
        let progress = |what: &'static str, share: f64| {
            let percent = (4.0 * share) as u32 * 25;
            // A lock that somebody died with is of no matter for a line of progress.
            let mut told = told.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            if is_terminal && *told != (what, percent) {
                *told = (what, percent);
                bus::stderr_line!("calib bone: {what}, {percent} %");
            }
        };
        let blur = self.blur_mm.as_deref();
        let nothing = |_: [u32; 3]| false;
        let is_in = |voxel: [u32; 3]| labelled.is_some_and(|map| map.is_in(voxel));
        let excluded = |voxel: [u32; 3]| labelled.is_some_and(|map| map.is_other(voxel));
        let region = match labelled {
            Some(_) => Region::Labelled {
                is_in: &is_in,
                grow_mm: self.region.grow_mm(),
            },
            None => self.region.region(),
        };
        let cuts = self.region.cuts();
        let options = Options {
            cuts: &cuts,
            excluded: if labelled.is_some() { &excluded } else { &nothing },
            level_hu: self.threshold_hu.0,
            metal_hu: self.metal_hu,
            contrast_hu: self.contrast_hu,
            blur_mm: blur.and_then(|b| Some([b.first()?.0, b.get(1)?.0])),
            threads: std::thread::available_parallelism().map_or(1, |n| n.get().min(MOST_THREADS)),
            takes_no_cortex: self.accept_no_cortex,
            progress: &progress,
            ..Options::of(region)
        };
        bone::extract(volume, &options).map_err(|refused| BoneError::Bone {
            path: self.volume.clone(),
            listed: report::listed(&refused),
            refused: Box::new(refused),
        })
    }
}

impl bone::Voxels for Volume {
    fn grid(&self) -> &VolumeGrid {
        &self.0.grid
    }

    fn row(&self, y: u32, z: u32, out: &mut [i16]) {
        bead::Voxels::row(self, y, z, out);
    }

    fn padding_hu(&self) -> Option<i16> {
        Some(self.0.padding_hu)
    }
}

/// Where a part of the CT lies, in words.
fn in_words(place: VoxelBox) -> String {
    let [x, y, z] = [0, 1, 2].map(|k| format!("{} to {}", place.first[k], place.end[k].saturating_sub(1)));
    format!("columns {x}, rows {y}, slices {z}")
}
