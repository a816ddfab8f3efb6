//! Which bone is meant, as it is typed.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use bone::{Cut, Region};
use clap::Args;
use scene::VolumeSpec;

use super::error::BoneError;
use super::labels::Labelled;
use super::readers::Readers;
use crate::beads::Volume;
use crate::values::Target;

/// Six numbers, with commas between.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Six([f64; 6]);

impl FromStr for Six {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let parse = |part: &str| part.trim().parse::<f64>().map_err(|e| format!("{part:?}: {e}"));
        let numbers: Vec<f64> = text.split(',').map(parse).collect::<Result<_, _>>()?;
        let six: [f64; 6] = numbers
            .try_into()
            .map_err(|n: Vec<f64>| format!("{} numbers; 6 are needed", n.len()))?;
        let finite = six.iter().all(|x| x.is_finite());
        finite
            .then_some(Self(six))
            .ok_or_else(|| "every number must be finite".to_owned())
    }
}

impl Six {
    fn halves(self) -> [[f64; 3]; 2] {
        let [a, b, c, d, e, f] = self.0;
        [[a, b, c], [d, e, f]]
    }
}

/// A plane: a place on it, and its normal towards what is cut away.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane(Cut);

impl FromStr for Plane {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let [place_mm, normal] = Six::from_str(text)?.halves();
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        // An overflow has no direction either.
        let usable = length.is_finite() && length > 1e-6;
        usable
            .then_some(Self(Cut { place_mm, normal }))
            .ok_or_else(|| "the normal (the last three numbers) must not be zero".to_owned())
    }
}

/// Which bone.
#[derive(Debug, Args)]
pub(crate) struct RegionArgs {
    /// A label map of the CT
    #[arg(long, value_name = "FILE", requires = "label")]
    labels: Option<PathBuf>,
    /// The bone's label: its number, or its name where the map comes with names
    #[arg(long, value_name = "NAME|NUMBER", requires = "labels")]
    label: Option<String>,
    /// Another label that is kept out, beside all that are as bright as bone
    #[arg(long, value_name = "NAME|NUMBER", requires = "labels")]
    exclude_label: Vec<String>,
    /// How far bone may go beyond its label, mm
    #[arg(long, value_name = "MM", default_value = "4", value_parser = growth)]
    grow_mm: f64,
    /// The largest body within this box: two corners, mm (left, posterior, superior)
    #[arg(long = "box", value_name = "X,Y,Z,X,Y,Z", allow_hyphen_values = true, conflicts_with_all = ["labels", "seed", "component"])]
    bounds: Option<Six>,
    /// The body that holds this place, mm
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, conflicts_with_all = ["labels", "component"])]
    seed: Option<Target>,
    /// The body of this number of those that are listed without any of these, from 1
    #[arg(long, value_name = "NUMBER", conflicts_with = "labels")]
    component: Option<usize>,
    /// Cut a joint by a plane: a place on it, and its normal towards what is cut away
    #[arg(long, value_name = "X,Y,Z,NX,NY,NZ", allow_hyphen_values = true)]
    cut: Vec<Plane>,
}

fn growth(text: &str) -> Result<f64, String> {
    let mm = text.parse().ok().filter(|mm| (0.0..=20.0).contains(mm));
    mm.ok_or_else(|| "expected 0 to 20 mm".to_owned())
}

impl RegionArgs {
    pub(super) fn labels(&self) -> Option<&Path> {
        self.labels.as_deref()
    }

    pub(super) fn grow_mm(&self) -> f64 {
        self.grow_mm
    }

    pub(super) fn cuts(&self) -> Vec<Cut> {
        self.cut.iter().map(|plane| plane.0).collect()
    }

    pub(super) fn labelled(
        &self,
        volume: &Volume,
        spec: &VolumeSpec,
        hands: &Readers,
        threshold_hu: f64,
    ) -> Result<Option<Labelled>, BoneError> {
        let (Some(path), Some(label)) = (&self.labels, &self.label) else {
            return Ok(None);
        };
        let asked = (label.as_str(), self.exclude_label.as_slice());
        Labelled::read(path, asked, (volume, spec), hands, threshold_hu).map(Some)
    }

    /// Without a label map.
    pub(super) fn region(&self) -> Region<'static> {
        match (self.bounds, self.seed, self.component) {
            (Some(bounds), _, _) => Region::Box {
                corners_mm: bounds.halves(),
            },
            (_, Some(seed), _) => Region::Seed { mm: seed.0 },
            (_, _, Some(number)) => Region::Number(number),
            _ => Region::Only,
        }
    }

    /// In words.
    pub(super) fn words(&self, labelled: Option<&Labelled>) -> String {
        let mut words = match (labelled, self.bounds, self.seed, self.component) {
            (Some(map), ..) => format!("{} of {}, grown by {} mm", map.name, map.path.display(), self.grow_mm),
            (_, Some(bounds), ..) => format!("largest body in the box {:?} mm", bounds.halves()),
            (_, _, Some(seed), _) => format!("body at {:?} mm", seed.0),
            (_, _, _, Some(number)) => format!("body {number} of those above the threshold"),
            _ => "the only body above the threshold".to_owned(),
        };
        for Plane(cut) in &self.cut {
            words += &format!("; cut at {:?} mm towards {:?}", cut.place_mm, cut.normal);
        }
        words
    }
}
