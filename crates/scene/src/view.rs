//! One image of a scene.

use std::f64::consts::FRAC_PI_2;

use geometry::{Ct, Direction, PlaneError, SlicePlane, Vector, VolumeGrid};

use super::Sampling;
use super::raw::{Drawn, Extent, Plane, Up};

/// One image, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Names the topic and the PNG; unique in the scene.
    pub name: String,
    /// The plane's direction.
    pub plane: Plane,
    /// Whole patient or zoomed at the tip.
    pub extent: Extent,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Local views: what the image's shorter side shows, mm.
    pub field_mm: f64,
    /// How the volume is sampled.
    pub sampling: Sampling,
    /// Perpendicular views: how far in front of the tip the plane lies, mm; 0 for the others.
    pub ahead_mm: f64,
    /// How HU become grey.
    pub window: WindowLevel,
    /// Perpendicular views: what points up.
    pub up: Up,
    /// How large words on the image are: 1 is the type that 512 pixels are meant for.
    pub text: f64,
    /// What is drawn over the slice.
    pub overlay: Drawn,
    /// From where a surface view sees the patient, and of what; of no meaning for the others.
    pub surface: Surface,
}

/// How a surface view sees the patient: by parallel projection, from a direction that stands still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Where the viewer is: from the patient's front towards her left, radians.
    pub azimuth_rad: f64,
    /// And from there towards her head, radians.
    pub elevation_rad: f64,
    /// What the image's shorter side shows about the middle of the examination, mm; `None`: all of it.
    pub field_mm: Option<f64>,
    /// Voxels of so many HU and more are bone.
    pub bone_hu: f64,
}

/// Where a viewer may be by name, with azimuth and elevation in degrees. From the head and the feet the front is up.
pub(super) const SIDES: [(&str, [f64; 2]); 6] = [
    ("anterior", [0.0, 0.0]),
    ("left", [90.0, 0.0]),
    ("posterior", [180.0, 0.0]),
    ("right", [-90.0, 0.0]),
    ("head", [180.0, 90.0]),
    ("feet", [0.0, -90.0]),
];

impl Surface {
    /// From this side, the whole examination, with bone from `bone_hu` on; `None` where no side has that name.
    pub fn from(side: &str, bone_hu: f64) -> Option<Self> {
        let (_, angles) = SIDES.iter().find(|(name, _)| *name == side)?;
        let [azimuth_rad, elevation_rad] = angles.map(f64::to_radians);
        Some(Self {
            azimuth_rad,
            elevation_rad,
            field_mm: None,
            bone_hu,
        })
    }

    /// The image plane, through the middle of `grid`, that parallel projection goes onto.
    ///
    /// # Errors
    /// [`PlaneError`] for a grid so large that its pixels would be.
    pub fn camera(&self, grid: &VolumeGrid, size: [u32; 2]) -> Result<SlicePlane, PlaneError> {
        let axes = self.axes();
        match self.field_mm {
            None => SlicePlane::covering(grid, grid.centre(), axes, size),
            Some(field_mm) => {
                let shorter = f64::from(size[0].min(size[1]));
                SlicePlane::centred(grid.centre(), axes, field_mm / shorter, size)
            }
        }
    }

    /// The camera after it was turned about the middle of `grid`, further round by `azimuth_rad` and further up by `elevation_rad`, at most to
    /// the head or the feet. The patient stays as large as she was.
    ///
    /// # Errors
    /// [`PlaneError`], as of [`Surface::camera`].
    pub fn turned(
        &self,
        [azimuth_rad, elevation_rad]: [f64; 2],
        grid: &VolumeGrid,
        size: [u32; 2],
    ) -> Result<SlicePlane, PlaneError> {
        let pixel_mm = self.camera(grid, size)?.pixel_mm();
        let turned = Self {
            azimuth_rad: self.azimuth_rad + azimuth_rad,
            elevation_rad: (self.elevation_rad + elevation_rad).clamp(-FRAC_PI_2, FRAC_PI_2),
            ..*self
        };
        SlicePlane::centred(grid.centre(), turned.axes(), pixel_mm, size)
    }

    /// The directions of growing columns and rows.
    fn axes(&self) -> [Direction<Ct>; 2] {
        let ((sa, ca), (se, ce)) = (self.azimuth_rad.sin_cos(), self.elevation_rad.sin_cos());
        // LPS: the viewer stands at (sa ce, -ca ce, se); up is where she would go with more elevation.
        let right = Vector::new(ca, sa, 0.0).direction().unwrap_or(Direction::X);
        let down = Vector::new(sa * se, -ca * se, -ce).direction().unwrap_or(-Direction::Z);
        [right, down]
    }
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            azimuth_rad: 0.0,
            elevation_rad: 0.0,
            field_mm: None,
            bone_hu: 300.0,
        }
    }
}

/// How HU become grey: linear from black at `centre - width/2` to white at `centre + width/2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowLevel {
    /// The HU shown as middle grey.
    pub centre_hu: f64,
    /// From black to white, HU.
    pub width_hu: f64,
}

/// Windows as radiologists name them.
pub(super) const WINDOWS: [(&str, WindowLevel); 5] = [
    (
        "abdomen",
        WindowLevel {
            centre_hu: 40.0,
            width_hu: 400.0,
        },
    ),
    (
        "soft-tissue",
        WindowLevel {
            centre_hu: 50.0,
            width_hu: 350.0,
        },
    ),
    (
        "bone",
        WindowLevel {
            centre_hu: 400.0,
            width_hu: 2000.0,
        },
    ),
    (
        "lung",
        WindowLevel {
            centre_hu: -600.0,
            width_hu: 1500.0,
        },
    ),
    (
        "vessels",
        WindowLevel {
            centre_hu: 200.0,
            width_hu: 600.0,
        },
    ),
];

impl WindowLevel {
    /// The window with this name.
    pub fn named(name: &str) -> Option<Self> {
        WINDOWS
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, window)| *window)
    }
}

impl View {
    /// The seven images of the thesis: axial, frontal and sagittal, each global and local, and perpendicular.
    pub(super) fn thesis_seven() -> Vec<Self> {
        let view = |plane: Plane, extent: Extent, name: &str| Self {
            name: name.to_owned(),
            plane,
            extent,
            size: [512, 512],
            field_mm: 100.0,
            sampling: Sampling::default(),
            ahead_mm: 0.0,
            window: WINDOWS[0].1,
            up: Up::Superior,
            text: 1.0,
            overlay: Drawn::All,
            surface: Surface::default(),
        };
        vec![
            view(Plane::Axial, Extent::Global, "axial-global"),
            view(Plane::Axial, Extent::Local, "axial-local"),
            view(Plane::Frontal, Extent::Global, "frontal-global"),
            view(Plane::Frontal, Extent::Local, "frontal-local"),
            view(Plane::Sagittal, Extent::Global, "sagittal-global"),
            view(Plane::Sagittal, Extent::Local, "sagittal-local"),
            view(Plane::Perpendicular, Extent::Local, "perpendicular"),
        ]
    }
}
