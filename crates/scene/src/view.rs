//! One image of a scene.

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
