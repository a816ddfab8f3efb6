//! The frames of the system, as types without values.
//!
//! | frame | thesis | origin | axes | unit |
//! |---|---|---|---|---|
//! | [`Ct`] | C | the scanner's | LPS: Left, Posterior, Superior | mm |
//! | [`Tracker`] | L | the localizer's | the localizer's | mm |
//! | [`Marker`] | B | the marker's calibration | the marker's calibration | mm |
//! | [`Reference`] | (proposed in 2.3.3) | a marker on the patient | its calibration | mm |
//! | [`Tool`] | M | inner tip of the tube | +z along the tube, from the handle to the tip | mm |
//! | [`Base`] | socle | the calibration base | its drawing | mm |
//! | [`Pointer`] | palpeur | the pointer's calibration | the pointer's calibration | mm |
//! | [`Probe`] | sonde | the marker on the ultrasound probe | the marker's calibration | mm |
//! | [`Phantom`] | | a calibration phantom's drawing | its drawing | mm |
//! | [`Model`] | | a model of organs: that of its label map | the label map's, right-handed | mm |
//! | [`Named`] | | of a file that names its frames | of that file | mm |
//! | [`Voxel`] | | centre of the first voxel | column, row, slice | voxel index |
//! | [`Image`] | | centre of the first pixel | right, down, into the screen | pixel |

/// A coordinate frame. Sealed by convention: the frames of the system are the ones in this module.
pub trait Frame: 'static {
    /// The frame's name in messages and errors.
    const NAME: &'static str;
}

macro_rules! frames {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {}
        impl Frame for $name {
            const NAME: &'static str = stringify!($name);
        }
    )*};
}

frames! {
    /// The CT volume's patient frame: LPS, mm (thesis: C).
    Ct
    /// The localizer's frame, mm (thesis: L).
    Tracker
    /// A rigid body of emitters, mm (thesis: B, the 24-diode ball).
    Marker
    /// A marker fixed to the patient, mm: the dynamic reference frame.
    Reference
    /// The instrument, mm (thesis: M): origin at the inner tip, +z from the handle to the tip.
    Tool
    /// The calibration base, mm (thesis: socle).
    Base
    /// The pointer, mm (thesis: palpeur).
    Pointer
    /// The marker on an ultrasound probe, mm.
    Probe
    /// A phantom of wires that a probe is calibrated with, by its drawing, mm.
    Phantom
    /// A model of organs, mm: along the axes of its label map.
    Model
    /// A frame whose name is known at run time only, mm: [`crate::named`].
    Named
    /// Continuous voxel index; whole numbers are voxel centres.
    Voxel
    /// Continuous pixel index of a slice image; whole numbers are pixel centres; x right, y down.
    Image
}
